#pragma once

#include <cstdint>
#include <vector>

#include "formats/zemax/zemax.h"

namespace sbrdf::internal {

/// What is integrated.
enum class ZemaxIntegrand : std::uint8_t {
  kCosine,  ///< f_r cos(theta_v): the hemispherical reflectance
  kPlain,   ///< f_r
};

/// The integral of each block of a table over all directions above the horizon, with values linear between nodes in
/// both angles, held from the first radial inwards, 0 beyond the last. Blocks and channels in the order of
/// ZemaxTable::tis, which states something of the kind. Midpoint rule with steps of at most a degree (more for files of
/// more than 460 incidences, so that time is bounded).
[[nodiscard]] std::vector<double> zemax_integrals(const ZemaxTable& table, ZemaxIntegrand integrand);

}  // namespace sbrdf::internal
