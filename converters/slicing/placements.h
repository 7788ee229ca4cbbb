#pragma once

#include <cstdint>
#include <span>

namespace sbrdf::internal {

/// The paper's placement of slices in the elevation frame: steps of elevation and azimuth [degrees].
struct Placement {
  double elevation_step_deg = 14;
  double azimuth_step_deg = 36;

  bool operator==(const Placement&) const = default;
};

/// The paper's Table 3: the placement for a number of samples.
[[nodiscard]] Placement table_3_placement(std::uint64_t sample_count);
/// The 17 placements of Table 3, from few crossings to many.
[[nodiscard]] std::span<const Placement> table_3_placements();

}  // namespace sbrdf::internal
