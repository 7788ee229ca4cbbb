#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "converters/bench/contender.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Unit vectors, as a renderer has them.
struct VectorPairs {
  std::vector<glm::vec3> i;
  std::vector<glm::vec3> v;

  [[nodiscard]] std::size_t size() const { return i.size(); }
};

/// theta uniform up to a largest one, both azimuths uniform; the same on every machine.
[[nodiscard]] VectorPairs draw_vector_pairs(std::size_t count, double theta_max_deg);

/// Pairs that verify() looks at.
inline constexpr std::size_t kVerifiedPairs = 4096;
/// A contender is wild where more than half of its values are off by more than this [% of the value, or of a hundredth
/// of the mean where that is larger]: a wrong axis, scale or order of channels, not a coarse table. A method may have
/// another limit.
inline constexpr double kWildPercent = 100;

/// Whether a contender is worth timing: its values are finite, have the same bits alone and in batches of any size, and
/// are near those of the source, or of its mean with the directions exchanged. kDifference, saying where it fails.
/// Pairs that the source did not measure are left out.
[[nodiscard]] Status verify(const Contender& contender, const BrdfSource& source, const VectorPairs& pairs,
                            double wild_percent = kWildPercent);

/// How far a contender is from its source, over all channels [%]; specs/conventions.md defines each.
struct Quality {
  double grid_mre_percent = 0;  ///< on the grid of 2 degrees, no floor: the paper's
  double grid_rel_l1_percent = 0;
  double off_grid_mre_percent = 0;  ///< between its nodes, densely in the highlight, floor a hundredth of the mean
  double off_grid_rel_l1_percent = 0;
};

/// Which pairs errors are measured on.
struct QualityOptions {
  std::uint64_t pairs = 100'000;  ///< of the grid, picked at random, and as many off it
  double theta_max_deg = 80;
};

/// interrupted_error(), and those of compare_sources().
[[nodiscard]] Result<Quality> measure_quality(const Contender& contender, const BrdfSource& source,
                                              const QualityOptions& options, const Progress& progress);

}  // namespace sbrdf::internal
