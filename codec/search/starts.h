#pragma once

#include <cstddef>
#include <vector>

#include "codec/search/structure_search.h"

namespace sbrdf::internal {

/// Fewer crossings than this share of the samples: slices need samples of their own.
[[nodiscard]] bool fits_budget(std::size_t crossing_count, std::uint64_t sample_count);

/// The regular structures that a search begins with, of the frames and in the domain that the options leave: the
/// densest third of those that fit the budget, or the densest eight where that is more; no more than `most` in all.
/// Those with hardly any crossings for the budget lead nowhere, and leaving them out saves most of the time. None where
/// none fits.
[[nodiscard]] std::vector<Structure> regular_starts(const SearchOptions& options, std::size_t most);

}  // namespace sbrdf::internal
