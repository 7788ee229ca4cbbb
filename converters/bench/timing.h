#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "converters/bench/yardstick.h"

namespace sbrdf::internal {

// Everything that is timed goes through here, and from here to Google Benchmark, which chooses how often a piece of
// work is repeated until its time can be told.

/// What the clock counts.
enum class Clock : std::uint8_t {
  kProcessor,  ///< time of the calling thread on a processor: what else the machine does counts little
  kWall,       ///< time that passes: for work on many threads
  kTold,       ///< what `run` returns [s]: where only a part of the work counts
};

/// A piece of work; `run` does it once.
struct TimedWork {
  std::function<std::optional<double>()> run;
  Clock clock = Clock::kProcessor;
};

struct TimingOptions {
  int repetitions = 9;
  double least_seconds = 0.02;  ///< of one repetition
};

/// Median over the repetitions of the time that each work takes [s], in their order. Repetitions of all works are mixed
/// at random, so that a machine that grows slower or faster does so for all of them. One call at a time in a process.
[[nodiscard]] std::vector<double> median_seconds(std::span<const TimedWork> works, const TimingOptions& options);

/// Arrays four times as large as the largest cache, and no smaller than `least_bytes`.
[[nodiscard]] MemorySpeed measure_memory_speed(std::uint64_t least_bytes, const TimingOptions& options);

/// The set of instructions that evaluation in vectors takes here, by Highway's name: "AVX3", "AVX2", "SSE4".
[[nodiscard]] std::string vector_target();

}  // namespace sbrdf::internal
