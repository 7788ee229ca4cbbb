#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Directions equally far apart in azimuth, the first at 0.
struct Ring {
  double theta_deg = 0;
  std::size_t count = 1;
};

/// A uniform sampling scheme: directions that the light and the viewer go through independently of each other, in rings
/// that grow in theta. The first ring is the normal alone.
struct UniformScheme {
  std::string name;
  std::vector<Ring> rings;

  /// Directions of the light, and as many of the viewer.
  [[nodiscard]] std::uint64_t direction_count() const;
  /// Pairs of them.
  [[nodiscard]] std::uint64_t pair_count() const { return direction_count() * direction_count(); }
  /// Pairs that have to be measured where light and viewer may be exchanged.
  [[nodiscard]] std::uint64_t reciprocal_pair_count() const { return direction_count() * (direction_count() + 1) / 2; }
};

/// The thirty of Table 1 of Vávra and Filip, "Adaptive Measurement of Anisotropic Material Appearance", supplemental
/// material, 2017, in its order: "1" to "30".
[[nodiscard]] std::vector<UniformScheme> paper_schemes();

/// One of them by its name. kUsage where there is none.
[[nodiscard]] Result<UniformScheme> paper_scheme(std::string_view name);

/// More directions than this [pairs grow with their square].
inline constexpr std::uint64_t kMostSchemeDirections = 4096;

/// {"name": text, "rings": [{"theta_deg": 0, "count": 1}, {"theta_deg": 30, "count": 12}, ...]}: theta grows and stays
/// below 90 degrees, and rings beyond the normal have three directions at least. kInvalidFile names the member;
/// kUnsupported where there are more than kMostSchemeDirections.
[[nodiscard]] Result<UniformScheme> parse_scheme(std::string_view text);

/// Whether rings that come from elsewhere make a scheme, by the same rules.
[[nodiscard]] Status check_scheme(const UniformScheme& scheme);

/// A scheme of the paper by its name, or one from a file whose name ends with ".json". Errors as of paper_scheme and
/// parse_scheme, or kIo.
[[nodiscard]] Result<UniformScheme> scheme_by_name(const std::string& name);

/// The directions, ring by ring, as angles and as unit vectors.
[[nodiscard]] std::vector<Direction> scheme_angles(const UniformScheme& scheme);
[[nodiscard]] std::vector<glm::dvec3> scheme_directions(const UniformScheme& scheme);

}  // namespace sbrdf::internal
