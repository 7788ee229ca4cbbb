#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf::internal {

/// Remembers what a Measure gave for a pair of directions: neighbouring structures of a search look at the same pairs
/// again and again. Takes some 64 MiB; what finds no place is measured each time. The measure must give the same values
/// whenever it is asked, so that results do not depend on what is remembered. May be used by several threads at once.
class ValueCache {
 public:
  /// `measure` must outlive this.
  ValueCache(const Measure& measure, std::size_t channel_count);

  /// As the measure itself, whose errors it passes on.
  Status measure(std::span<const DirectionPair> pairs, std::span<float> values);

 private:
  enum State : std::uint8_t { kEmpty, kBeingWritten, kFull };

  [[nodiscard]] const float* find(const DirectionPair& pair) const;
  void insert(const DirectionPair& pair, std::span<const float> values);

  const Measure& measure_;
  std::size_t channels_;
  std::size_t mask_;  ///< the number of places, a power of 2, less 1
  std::unique_ptr<std::atomic<std::uint8_t>[]> states_;
  std::unique_ptr<DirectionPair[]> keys_;
  std::unique_ptr<float[]> values_;
};

}  // namespace sbrdf::internal
