#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "codec/importance/incidence.h"
#include "codec/importance/mirror_polar.h"

namespace sbrdf::internal {

/// What a table is made of: f_r [1/sr] for unit vectors with the normal at (0, 0, 1); `values` has w_i.size() x
/// `channels` entries, channel fastest. Called from several threads at once.
struct VectorBrdf {
  std::function<void(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values)> evaluate;
  std::size_t channels = 0;
  bool isotropic = false;
};

/// Bytes of a table, at most.
inline constexpr std::size_t kMostIsotropicTableBytes = std::size_t{256} << 10U;
inline constexpr std::size_t kMostTableBytes = std::size_t{1} << 20U;

/// Where a table has its nodes and cells.
struct ImportanceGrid {
  IncidenceSymmetry symmetry = IncidenceSymmetry::kIsotropic;
  Stretch stretch;
  std::vector<double> cosines;  ///< of theta_i at the nodes, falling from 1
  std::size_t azimuths_i = 1;   ///< nodes of phi_i
  std::size_t azimuths = 0;     ///< cells around the mirror direction: over half a turn for kIsotropic, else a turn
  std::vector<double> radii;    ///< ends of cells of PolarPlace::radius, rising from 0 to 1

  [[nodiscard]] std::size_t rings() const { return radii.size() - 1; }
  [[nodiscard]] double azimuth_step() const;    ///< between cells [radians]
  [[nodiscard]] double azimuth_i_step() const;  ///< between nodes of phi_i [radians]
  [[nodiscard]] std::size_t nodes() const { return cosines.size() * azimuths_i; }
  /// Floats of a node: the cosine's share; for each azimuth what lies up to its end; for each azimuth and ring what of
  /// the azimuth lies up to the ring's end. Both end with 1 and rise.
  [[nodiscard]] std::size_t node_size() const { return 1 + azimuths * (1 + rings()); }
};

/// A direction that was drawn, and the density that it was drawn with [1/sr]: 0 where none can be, and then w_v is the
/// normal.
struct DrawnDirection {
  glm::vec3 w_v = {0, 0, 1};
  float pdf = 0;
};

/// Directions to the viewer drawn about as densely as f_r cos theta_v is large, for any direction to the light:
/// a share of the cosine's distribution, which takes what is diffuse, and a table of steps about the mirror direction
/// for what is not (specs/importance.md). Immutable; no allocation per call; the same bits on any thread.
class ImportanceTable {
 public:
  /// `nodes` has grid.nodes() x grid.node_size() entries, phi_i slowest, then theta_i.
  ImportanceTable(ImportanceGrid grid, std::vector<float> nodes);

  /// `u` in [0, 1) twice; beyond, the nearest that is, and 0 for what is no number. The density is that of `pdf`, with
  /// the same bits.
  [[nodiscard]] DrawnDirection sample(const glm::vec3& w_i, const glm::dvec2& u) const;

  /// Density of `w_v` [1/sr]. 0 where one of both is on or below the horizon, or no direction. Any lengths but 0.
  [[nodiscard]] float pdf(const glm::vec3& w_i, const glm::vec3& w_v) const;

  /// Of everything this holds.
  [[nodiscard]] std::size_t bytes() const;

  [[nodiscard]] const ImportanceGrid& grid() const { return grid_; }

 private:
  struct Blend;  // the nodes around a direction to the light
  [[nodiscard]] Blend blend(const Incidence& incidence) const;
  [[nodiscard]] PolarPlace draw(const Blend& blend, const MirrorPolar& polar, const glm::dvec2& u) const;
  [[nodiscard]] double table_pdf(const Blend& blend, const MirrorPolar& polar, const glm::dvec3& w_v) const;
  [[nodiscard]] double density(const Blend& blend, const MirrorPolar& polar, const glm::dvec3& w_v) const;

  ImportanceGrid grid_;
  std::vector<float> nodes_;
};

/// The table of any BRDF. Of what several channels say the mean counts; values that are negative or not finite weigh 0.
/// Uses all cores; the same bits on any number.
[[nodiscard]] ImportanceTable make_importance_table(const VectorBrdf& brdf);

}  // namespace sbrdf::internal
