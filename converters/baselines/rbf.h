#pragma once

#include <memory>

#include "converters/baselines/scheme_samples.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Uniform samples interpolated by radial basis functions, as a tensor product over light and viewer:
///
///   f(i, v) = b(i)^T C b(v),   b(w) = (phi(|w - x_1|), ..., phi(|w - x_n|), p(w)),   C = A^-1 F A^-1
///
/// with the scheme's directions x, the samples F between them, bordered by zeros, and A the same of one side: its
/// columns are b(x_k), bordered by the polynomial's. p is what makes the solution unique: 1 with the kernel r, 1 and
/// the coordinates with r^3 and r^2 log r, nothing otherwise (Fasshauer, "Meshfree Approximation Methods with MATLAB",
/// 2007, chapters 6 to 8). Goes through every sample; below the last ring it extrapolates. Values may fall below 0.
///
/// kUnsupported where the equations have no unique solution in double precision, and for more than 2^25 coefficients:
/// directions squared times channels.
[[nodiscard]] Result<std::unique_ptr<SchemeSource>> make_rbf(SchemeSamples samples, RbfKernel kernel);

}  // namespace sbrdf::internal
