#pragma once

#include <span>

namespace sbrdf::internal {

/// angles[k] = atan2(y[k], x[k]) [radians] in (-pi, pi], within 4 ulp; 0 where both are 0. As many at once as the
/// machine can (Highway), with the same bits for any number of them. All three have the same length; `angles` may be
/// `y` or `x`. Finite numbers only.
void atan2_each(std::span<const double> y, std::span<const double> x, std::span<double> angles);

}  // namespace sbrdf::internal
