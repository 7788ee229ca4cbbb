#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/evaluation/vector_evaluator.h"
#include "codec/series/series.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Where the table of a series has its nodes [degrees], in the order of SliceKind: `fineness` for each function along a
/// polar axis, twice as many along an azimuth, and one more. Along theta_h and theta_d as Chebyshev points lie in u and
/// v, since there is where polynomials turn; azimuths in equal steps, their end included; one node where nothing moves.
[[nodiscard]] std::array<std::vector<double>, kAxisCount> table_nodes(const SeriesBrdf& brdf);

/// Bytes of the values of the table.
[[nodiscard]] std::size_t table_bytes(const SeriesBrdf& brdf);

/// The series as a table over its nodes: what a file means. f_r at a node is that of the series; between nodes the
/// logarithms (the value domain) of each channel are interpolated along all axes. kUnsupported where it takes more
/// memory than `allowed` [bytes].
[[nodiscard]] Result<VectorEvaluator> make_table(const SeriesBrdf& brdf, std::uint64_t allowed);

}  // namespace sbrdf::internal
