#pragma once

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

namespace sbrdf::internal {

/// Which directions to the light a table tells apart.
enum class IncidenceSymmetry : std::uint8_t {
  kNone,       ///< all azimuths
  kHalfTurn,   ///< f is the same after half a turn about the normal: azimuths in [0, pi)
  kQuarter,    ///< f is the same mirrored along x and along y: azimuths in [0, pi / 2]
  kIsotropic,  ///< none; and both sides of the plane of incidence are one
};

/// A direction to the light turned or mirrored to where a table has it, and the way there and back for others.
class Incidence {
 public:
  /// Nothing for a `w_i` on or below the horizon, and for what is no direction. Any length but 0.
  [[nodiscard]] static std::optional<Incidence> fold(const glm::dvec3& w_i, IncidenceSymmetry symmetry);

  /// Unit vector with z of at least MirrorPolar::kLeastHeight.
  [[nodiscard]] const glm::dvec3& w_i() const { return w_i_; }
  /// In [0, 2 pi); 0 for kIsotropic.
  [[nodiscard]] double azimuth() const;

  [[nodiscard]] glm::dvec3 to_table(const glm::dvec3& w) const {
    return {x_.x * w.x + x_.y * w.y, y_.x * w.x + y_.y * w.y, w.z};
  }
  [[nodiscard]] glm::dvec3 from_table(const glm::dvec3& w) const {
    return {x_.x * w.x + y_.x * w.y, x_.y * w.x + y_.y * w.y, w.z};
  }

 private:
  glm::dvec3 w_i_ = {0, 0, 1};
  glm::dvec3 x_ = {1, 0, 0};  ///< the table's axes
  glm::dvec3 y_ = {0, 1, 0};
};

}  // namespace sbrdf::internal
