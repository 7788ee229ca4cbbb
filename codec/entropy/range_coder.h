#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sbrdf::internal {

// Binary arithmetic coding with probabilities that are learned on the way, for streams of a few dozen bytes, where
// stating probabilities beforehand would cost more than it saves. Whole numbers throughout, so that every machine
// codes alike. specs/sbrdf.md, section 14.
//
// What is coded is a number in an interval of 32 bits, [low, low + range). A decision cuts the interval in two parts in
// the ratio of its probabilities and keeps one. Once range is below 2^24 the leading byte of low is settled, but for a
// carry, and both are multiplied by 256. The bytes of any number in the last interval are the stream; a reader takes
// bytes behind its end for 0, so that the writer chooses the number with the most zeros and leaves them out.

/// How often a decision was yes and no, in 32nds; both begin with what is to be expected of it.
struct DecisionCounts {
  std::uint16_t no = 16;
  std::uint16_t yes = 16;

  /// Of yes, in 2^-16, 64 to 2^16 - 64.
  [[nodiscard]] std::uint32_t probability() const;
  /// Counts one more; all are halved where they become many, so that newer ones weigh more.
  void add(bool decision);
};

class RangeEncoder {
 public:
  void put(bool decision, DecisionCounts& counts);
  /// Of probability 1/2.
  void put_plain(bool bit);
  /// The stream, without zeros at its end.
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  void narrow(bool yes, std::uint32_t yes_part);
  void shift_out();

  std::uint64_t low_ = 0;  ///< bit 32 is a carry into `bytes_`
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::vector<std::byte> bytes_;
};

class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes);
  [[nodiscard]] bool take(DecisionCounts& counts);
  [[nodiscard]] bool take_plain();

 private:
  [[nodiscard]] bool split(std::uint32_t yes_part);
  [[nodiscard]] std::uint32_t next_byte();

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::uint32_t code_ = 0;  ///< the number less low
  std::uint32_t range_ = 0xFFFFFFFFU;
};

}  // namespace sbrdf::internal
