#pragma once

#include <string>

#include "converters/files/scattered/sample_columns.h"
#include "converters/tables/grid.h"

namespace sbrdf::internal {

/// A grid that suits samples, and why it is as it is.
struct ChosenGrid {
  Grid grid;
  std::string reason;  ///< for people: "phi_i is 0 throughout, so the material is taken as isotropic; ..."
};

/// Where phi_i is the same for all samples, an isotropic grid in phi_v - phi_i, mirrored where all of these lie on one
/// side of the plane of incidence; else one of all four angles. An axis has the angles of the samples themselves where
/// these are few, as a goniometer measures them, with more in gaps that are too wide to interpolate over; else even
/// steps, finer for more samples.
[[nodiscard]] ChosenGrid choose_grid(const Samples& samples);

}  // namespace sbrdf::internal
