#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/series/series.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Above any coefficient, either sign.
inline constexpr std::int32_t kCoefficientEnd = 1 << 24;

/// How many terms of a field there are up to its last coefficient that is not 0.
[[nodiscard]] std::uint32_t coded_terms(std::span<const std::int32_t> coefficients);

/// The coefficients of all fields, each up to its last one that is not 0, as one stream of the range coder. What is
/// expected of a coefficient follows from those of the terms next to it with lower degrees and orders, and, for
/// colours, from that of the same term in the first field. specs/sbrdf.md, section 14.
[[nodiscard]] std::vector<std::byte> code_coefficients(const SeriesBasis& basis,
                                                       std::span<const std::vector<std::int32_t>> fields);

/// The inverse: as many fields as there are `counts`, each with so many terms coded and one number for every term of
/// the basis. Terms of levels above `most_level` are left at 0.
[[nodiscard]] Result<std::vector<std::vector<std::int32_t>>> decode_coefficients(
    const SeriesBasis& basis, std::span<const std::byte> stream, std::span<const std::uint32_t> counts,
    std::uint32_t most_level = kSeriesLevels);

}  // namespace sbrdf::internal
