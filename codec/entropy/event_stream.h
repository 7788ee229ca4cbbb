#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "codec/entropy/contexts.h"
#include "codec/entropy/distribution_choice.h"
#include "codec/entropy/rans.h"

namespace sbrdf::internal {

// The two ends of a chunk. The walk over crossings and slices (codec/coding) is written once, as a template over an Io:
//
//                        EventRecorder -> events -> choose_distributions     all chunks of a file
//   walk over samples <                      \----> StreamWriter -> bytes    each chunk
//                        StreamReader  <------------------------ bytes
//
// An Io has `residual(context, value&)` and `flag(context, value&)`, which write the value or put there what was read;
// `step(value)`, which brings a step that was read into its range; and `ok()`.

/// The Io for writing: keeps what is to be coded until the distributions of the file are known.
class EventRecorder {
 public:
  static constexpr bool kDecodes = false;

  /// Appends to `events`.
  explicit EventRecorder(std::vector<Event>& events) : events_(events) {}

  void residual(unsigned context, std::int64_t& value) {
    events_.push_back({value, static_cast<std::uint8_t>(context), false});
  }
  void flag(unsigned context, bool& value) {
    events_.push_back({value ? 1 : 0, static_cast<std::uint8_t>(context), true});
  }
  [[nodiscard]] static std::int32_t step(std::int64_t step) { return static_cast<std::int32_t>(step); }
  [[nodiscard]] static bool ok() { return true; }

 private:
  std::vector<Event>& events_;
};

/// Makes streams of events, all with the distributions of one file.
class StreamWriter {
 public:
  explicit StreamWriter(const Distributions& distributions);

  /// The payload of a chunk; nothing for no events.
  [[nodiscard]] std::vector<std::byte> write(std::span<const Event> events) const;

 private:
  void put(const Event& event, RansEncoder& out) const;

  std::array<Distribution, CodingContext::kResidualCount> residuals_;
  std::array<std::uint32_t, CodingContext::kFlagCount> flags_{};  ///< frequency of yes
};

/// Distributions made ready for decoding, those of residuals when they are first used: many never are.
class DecodingTables {
 public:
  struct Residuals {
    std::array<std::uint32_t, Token::kCount> ranges;  ///< of each token its start, and 2^16 times its frequency
    SymbolTable symbols;
  };

  explicit DecodingTables(const Distributions& distributions);

  [[nodiscard]] const Residuals& residuals(unsigned context) {
    if (!made_[context]) make(context);
    return residuals_[context];
  }
  /// Frequency of yes; 0: never.
  [[nodiscard]] std::uint32_t flag(unsigned context) const { return flags_[context]; }

 private:
  void make(unsigned context);

  Distributions distributions_;
  std::unique_ptr<Residuals[]> residuals_;  ///< by context; not initialised but where made
  std::array<bool, CodingContext::kResidualCount> made_{};
  std::array<std::uint32_t, CodingContext::kFlagCount> flags_{};
};

/// The Io for reading. A step out of range or a read past the end make it not ok, and stay; what is read from then on
/// is of no use.
class StreamReader {
 public:
  static constexpr bool kDecodes = true;

  /// Both must outlive the reader.
  StreamReader(std::span<const std::byte> stream, DecodingTables& tables) : stream_(stream), tables_(tables) {}

  /// A token, which tells how many plain bits follow, and these.
  void residual(unsigned context, std::int64_t& value) {
    const DecodingTables::Residuals& table = tables_.residuals(context);
    const unsigned token = table.symbols[stream_.peek()];
    const std::uint32_t range = table.ranges[token];
    stream_.take(range & 0xFFFFU, range >> 16U);
    const unsigned count = plain_bits(token);
    value = residual_of(token, count == 0 ? 0 : stream_.bits(count));
  }
  /// Yes is the symbol that begins at 0, no the rest.
  void flag(unsigned context, bool& value) {
    const std::uint32_t yes = tables_.flag(context);
    value = stream_.peek() < yes;
    value ? stream_.take(0, yes) : stream_.take(yes, kProbabilityOne - yes);
  }
  /// A prediction and its residual may add up to what no step is; only damaged files have such.
  [[nodiscard]] std::int32_t step(std::int64_t step) {
    constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
    if (step < kLeast || step > kMost) failed_ = true;
    return static_cast<std::int32_t>(std::clamp(step, kLeast, kMost));
  }
  [[nodiscard]] bool ok() const { return !failed_ && !stream_.overrun(); }
  /// Whether all was well and nothing is left.
  [[nodiscard]] bool at_end() const { return ok() && stream_.at_end(); }

 private:
  RansDecoder stream_;
  DecodingTables& tables_;
  bool failed_ = false;
};

}  // namespace sbrdf::internal
