#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sbrdf::internal {

/// Places are found through buckets of equal width: what a bucket begins with, and where that ends, which nearly always
/// is the only change in it.
struct PlaceBucket {
  std::uint32_t first = 0;  ///< the last of the places at or before the bucket's beginning
  std::int32_t split = 0;   ///< the place after it
};

/// The buckets of one list of rising places.
struct PlaceSearch {
  std::uint32_t first_bucket = 0;
  std::uint32_t bucket_shift = 0;  ///< log2 of the places in a bucket
};

/// Appends the buckets for places[first] and those after it, behind which kBeyond stands: so many for each of them, or
/// half as many at least. Nobody looks beyond `last`.
inline PlaceSearch add_place_search(const std::vector<std::int32_t>& places, std::size_t first, std::int32_t last,
                                    std::size_t buckets_each, std::vector<PlaceBucket>& buckets) {
  PlaceSearch search;
  search.first_bucket = static_cast<std::uint32_t>(buckets.size());
  const std::uint64_t count = places.size() - 1 - first;
  const std::uint64_t wanted = count > 1 ? count * buckets_each : 1;
  const auto end = static_cast<std::uint64_t>(last);
  search.bucket_shift = 31;  // all places in one
  if (wanted > 1) {
    search.bucket_shift = static_cast<std::uint32_t>(std::bit_width(std::max<std::uint64_t>(1, end / wanted)));
  }
  auto place = static_cast<std::uint32_t>(first);
  for (std::uint64_t bucket = 0; bucket <= end >> search.bucket_shift; ++bucket) {
    const std::uint64_t from = bucket << search.bucket_shift;
    while (static_cast<std::uint64_t>(places[place + 1]) <= from) ++place;
    buckets.push_back({place, places[place + 1]});
  }
  return search;
}

}  // namespace sbrdf::internal
