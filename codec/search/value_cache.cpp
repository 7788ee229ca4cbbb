#include "codec/search/value_cache.h"

#include <algorithm>
#include <bit>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20U;
constexpr std::size_t kNeighbours = 8;  // places that a pair may have

bool same(const Direction& a, const Direction& b) { return a.theta == b.theta && a.phi == b.phi; }

std::size_t hash(const DirectionPair& pair) {
  std::uint64_t bits = 0;
  for (const double angle : {pair.i.theta, pair.i.phi, pair.v.theta, pair.v.phi}) {
    bits = (bits ^ std::bit_cast<std::uint64_t>(angle + 0.0)) * 0x9E3779B97F4A7C15U;
    bits ^= bits >> 32U;
  }
  return static_cast<std::size_t>(bits);
}

}  // namespace

ValueCache::ValueCache(const Measure& measure, std::size_t channel_count)
    : measure_(measure),
      channels_(channel_count),
      mask_(std::bit_floor(kMostBytes / (sizeof(DirectionPair) + channel_count * sizeof(float) + 1)) - 1),
      states_(std::make_unique<std::atomic<std::uint8_t>[]>(mask_ + 1)),
      keys_(std::make_unique_for_overwrite<DirectionPair[]>(mask_ + 1)),
      values_(std::make_unique_for_overwrite<float[]>((mask_ + 1) * channel_count)) {}

Status ValueCache::measure(std::span<const DirectionPair> pairs, std::span<float> values) {
  std::vector<DirectionPair> missing;
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (const float* found = find(pairs[k])) {
      std::copy_n(found, channels_, values.data() + k * channels_);
    } else {
      missing.push_back(pairs[k]);
      rows.push_back(k);
    }
  }
  if (missing.empty()) return ok_status();
  std::vector<float> measured(missing.size() * channels_);
  if (Status status = measure_(missing, measured); !status) return status;
  for (std::size_t k = 0; k < missing.size(); ++k) {
    const auto row = std::span<const float>(measured).subspan(k * channels_, channels_);
    std::copy(row.begin(), row.end(), values.data() + rows[k] * channels_);
    insert(missing[k], row);
  }
  return ok_status();
}

const float* ValueCache::find(const DirectionPair& pair) const {
  const std::size_t first = hash(pair);
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    const std::size_t place = (first + k) & mask_;
    const std::uint8_t state = states_[place].load(std::memory_order_acquire);
    if (state == kEmpty) return nullptr;
    if (state == kFull && same(keys_[place].i, pair.i) && same(keys_[place].v, pair.v)) {
      return values_.get() + place * channels_;
    }
  }
  return nullptr;
}

// A place is written once, by the thread that takes it. Two threads may write the same pair to two places: no harm.
void ValueCache::insert(const DirectionPair& pair, std::span<const float> values) {
  const std::size_t first = hash(pair);
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    const std::size_t place = (first + k) & mask_;
    std::uint8_t state = kEmpty;
    if (!states_[place].compare_exchange_strong(state, kBeingWritten, std::memory_order_acquire)) continue;
    keys_[place] = pair;
    std::copy(values.begin(), values.end(), values_.get() + place * channels_);
    states_[place].store(kFull, std::memory_order_release);
    return;
  }
}

}  // namespace sbrdf::internal
