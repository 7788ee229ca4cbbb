#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

// Entropy coding of what prediction leaves: whole numbers by tokens and plain bits, yes-or-no flags, all in one stream
// of an rANS coder (Duda, Asymmetric numeral systems, 2013). specs/sbrdf.md, section 5.
//
// The state x is one large number that holds all symbols so far. With probabilities in units of 2^-k, k = 12, a symbol
// of frequency f that begins at c goes into it by
//
//     x' = (x / f) 2^k + x mod f + c          x' is about x 2^k / f: it grows by log2(2^k / f) bits, the symbol's share
//
// and comes out again, since x' mod 2^k lies in [c, c + f) and so tells which symbol it was, by
//
//     x = f (x' / 2^k) + x' mod 2^k - c
//
// What goes in last comes out first: the encoder works from the last symbol to the first.
//
// Invariant: 2^16 <= x < 2^32 before and after each symbol. The encoder moves the low 16 bits of x out as a word when
// x >= f 2^(32 - k), the least at which x' would reach 2^32; then x' stays in range, since one word is enough: x < 2^32
// leaves x / 2^16 < 2^16 <= f 2^(32 - k) (f >= 1, k <= 16). The decoder takes a word in when its x falls below 2^16,
// which is after just the symbols before which the encoder moved one out. A word of 16 bits in a state of 32 is the
// coarsest split in which one step is enough on both sides and a state needs no more than a register of 32 bits, and
// f (x / 2^k) no more than its product. x begins, and so ends for the decoder, at 2^16: a check on the whole stream.

/// Probabilities are counted in 1/4096.
inline constexpr unsigned kProbabilityBits = 12;
inline constexpr std::uint32_t kProbabilityOne = 1U << kProbabilityBits;

/// A residual as a token and plain bits. Residuals 0, -1, 1, -2 ... become 0, 1, 2, 3 ...; the first 16 of these are
/// tokens of their own, above there are two tokens to each doubling.
struct Token {
  static constexpr unsigned kDirect = 16;
  static constexpr unsigned kCount = 74;  ///< enough for residuals of 33 bits

  unsigned index = 0;
  unsigned bit_count = 0;
  std::uint64_t bits = 0;
};
[[nodiscard]] inline Token token_of(std::int64_t residual) {
  const std::uint64_t folded =
      residual < 0 ? 2 * static_cast<std::uint64_t>(-(residual + 1)) + 1 : 2 * static_cast<std::uint64_t>(residual);
  if (folded < Token::kDirect) return {static_cast<unsigned>(folded), 0, 0};
  const auto exponent = static_cast<unsigned>(std::bit_width(folded)) - 1;
  const auto upper_half = static_cast<unsigned>((folded >> (exponent - 1)) & 1U);
  const unsigned bit_count = exponent - 1;
  return {Token::kDirect + 2 * (exponent - 4) + upper_half, bit_count, folded & ((std::uint64_t{1} << bit_count) - 1)};
}
[[nodiscard]] inline unsigned plain_bits(unsigned token) {
  return token < Token::kDirect ? 0 : 3 + (token - Token::kDirect) / 2;
}
[[nodiscard]] inline std::int64_t residual_of(unsigned token, std::uint64_t bits) {
  std::uint64_t folded = token;
  if (token >= Token::kDirect) {
    const std::uint64_t half = std::uint64_t{1} << plain_bits(token);
    folded = (2 + (token - Token::kDirect) % 2) * half + bits;
  }
  const auto size = static_cast<std::int64_t>(folded >> 1U);
  return (folded & 1U) != 0 ? -size - 1 : size;
}

/// A member of the fixed family of distributions that residuals are coded with: two shapes, 56 widths half an octave
/// apart. Nothing but its number is stored.
struct Distribution {
  static constexpr unsigned kWidths = 56;
  static constexpr unsigned kFamilySize = 2 * kWidths;  ///< even numbers: geometric; odd ones: with long tails

  std::array<std::uint16_t, Token::kCount> frequency{};
  std::array<std::uint16_t, Token::kCount> start{};
};
/// Of the first `token_count` tokens (16 to kCount); each of them gets a frequency of at least 1.
[[nodiscard]] Distribution make_distribution(unsigned number, unsigned token_count);

/// Which symbol a probability belongs to, for decoding.
using SymbolTable = std::array<std::uint8_t, kProbabilityOne>;
[[nodiscard]] SymbolTable make_symbol_table(const Distribution& distribution, unsigned token_count);

/// Bits, times 256, that a symbol of this frequency takes. The same everywhere.
[[nodiscard]] std::uint32_t cost_256(std::uint32_t frequency);

/// Symbols go in from the last to the first; `finish` gives the stream that a decoder reads from the first on: the
/// state, then the words in the reverse of the order in which they were moved out.
class RansEncoder {
 public:
  void put(std::uint32_t start, std::uint32_t frequency);
  /// Plain bits, the lowest first when read.
  void put_bits(std::uint64_t bits, unsigned count);
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  std::uint32_t state_ = 1U << 16U;  ///< x
  std::vector<std::uint16_t> words_;
};

/// Takes symbols out, from the first on. Reading past the end gives zeros and is remembered.
class RansDecoder {
 public:
  explicit RansDecoder(std::span<const std::byte> stream);

  /// x mod 2^k, which tells the symbol; `take` goes on to the next.
  [[nodiscard]] std::uint32_t peek() const { return state_ & (kProbabilityOne - 1); }
  void take(std::uint32_t start, std::uint32_t frequency) {
    state_ = frequency * (state_ >> kProbabilityBits) + (state_ & (kProbabilityOne - 1)) - start;
    if (state_ < (1U << 16U)) refill();
  }
  [[nodiscard]] std::uint64_t bits(unsigned count) {
    std::uint64_t bits = 0;
    for (unsigned from = 0; from < count; from += kProbabilityBits) {
      const unsigned size = std::min(kProbabilityBits, count - from);
      const std::uint32_t piece = peek() >> (kProbabilityBits - size);
      take(piece << (kProbabilityBits - size), 1U << (kProbabilityBits - size));
      bits |= static_cast<std::uint64_t>(piece) << from;
    }
    return bits;
  }

  /// True when the stream was read to its end and left the state that every encoder begins with.
  [[nodiscard]] bool at_end() const { return !overrun_ && next_ == stream_.size() && state_ == (1U << 16U); }
  [[nodiscard]] bool overrun() const { return overrun_; }

 private:
  void refill() {
    std::uint16_t word = 0;
    if (next_ + 2 <= stream_.size()) {
      std::memcpy(&word, stream_.data() + next_, 2);
      next_ += 2;
    } else {
      overrun_ = true;
    }
    state_ = state_ << 16U | word;
  }

  std::span<const std::byte> stream_;
  std::size_t next_ = 0;
  std::uint32_t state_ = 0;
  bool overrun_ = false;
};

}  // namespace sbrdf::internal
