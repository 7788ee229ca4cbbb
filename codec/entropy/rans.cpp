#include "codec/entropy/rans.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace sbrdf::internal {
namespace {

constexpr unsigned kBitsAtOnce = kProbabilityBits;

// Multiplications in a fixed order: std::pow differs from library to library.
double power(double base, std::uint64_t exponent) {
  double result = 1;
  for (; exponent > 0; exponent >>= 1U) {
    if ((exponent & 1U) != 0) result *= base;
    base *= base;
  }
  return result;
}

struct Bucket {
  std::uint64_t first = 0;  ///< least number, after folding the signs in
  std::uint64_t size = 1;
};

Bucket bucket_of(unsigned token) {
  if (token < Token::kDirect) return {token, 1};
  const unsigned exponent = 4 + (token - Token::kDirect) / 2;
  const std::uint64_t half = std::uint64_t{1} << (exponent - 1);
  return {2 * half + ((token - Token::kDirect) % 2) * half, half};
}

}  // namespace

Distribution make_distribution(unsigned number, unsigned token_count) {
  assert(number < Distribution::kFamilySize && token_count >= Token::kDirect && token_count <= Token::kCount);
  const double root_two = std::sqrt(2.0);
  double width = 0.25;
  for (unsigned k = 0; k < number / 2; ++k) width *= root_two;
  const double fall = width / (width + 1);
  std::array<double, Token::kCount> weight{};
  double sum = 0;
  for (unsigned t = 0; t < token_count; ++t) {
    const Bucket bucket = bucket_of(t);
    const std::uint64_t middle = (bucket.first + bucket.size / 2 + 1) / 2;  // its magnitude, signs unfolded
    double density = 0;
    if (number % 2 == 0) {
      density = power(fall, middle);
    } else {
      const double along = static_cast<double>(middle) / width;
      const double spread = 1 + along * along;
      density = 1 / (spread * spread);
    }
    weight[t] = static_cast<double>(bucket.size) * density;
    sum += weight[t];
  }
  Distribution made;
  std::uint32_t given = 0;
  unsigned largest = 0;
  for (unsigned t = 0; t < token_count; ++t) {
    const auto share = static_cast<std::uint32_t>(weight[t] / sum * static_cast<double>(kProbabilityOne - token_count));
    made.frequency[t] = static_cast<std::uint16_t>(1 + share);
    given += made.frequency[t];
    if (made.frequency[t] > made.frequency[largest]) largest = t;
  }
  made.frequency[largest] = static_cast<std::uint16_t>(made.frequency[largest] + kProbabilityOne - given);
  std::uint32_t next = 0;
  for (unsigned t = 0; t < token_count; ++t) {
    made.start[t] = static_cast<std::uint16_t>(next);
    next += made.frequency[t];
  }
  return made;
}

SymbolTable make_symbol_table(const Distribution& distribution, unsigned token_count) {
  SymbolTable table{};
  for (unsigned t = 0; t < token_count; ++t) {
    std::fill_n(table.begin() + distribution.start[t], distribution.frequency[t], static_cast<std::uint8_t>(t));
  }
  return table;
}

std::uint32_t cost_256(std::uint32_t frequency) {
  // 256 log2(4096 / frequency) by squaring: one bit of the logarithm at a time.
  const auto whole = static_cast<unsigned>(std::bit_width(frequency)) - 1;
  std::uint64_t mantissa = (std::uint64_t{frequency} << 31U) >> whole;  // in [2^31, 2^32)
  std::uint32_t log2_256 = whole;
  for (int bit = 0; bit < 8; ++bit) {
    mantissa = (mantissa * mantissa) >> 31U;
    const auto carry = static_cast<std::uint32_t>(mantissa >> 32U);
    log2_256 = 2 * log2_256 + carry;
    mantissa >>= carry;
  }
  return 256 * kProbabilityBits - log2_256;
}

void RansEncoder::put(std::uint32_t start, std::uint32_t frequency) {
  if (state_ >= std::uint64_t{frequency} << (32U - kProbabilityBits)) {
    words_.push_back(static_cast<std::uint16_t>(state_));
    state_ >>= 16U;
  }
  state_ = ((state_ / frequency) << kProbabilityBits) + state_ % frequency + start;
}

void RansEncoder::put_bits(std::uint64_t bits, unsigned count) {
  // The decoder takes full pieces from the lowest bits on: here the last piece goes in first.
  for (unsigned from = count == 0 ? 0 : (count - 1) / kBitsAtOnce * kBitsAtOnce + kBitsAtOnce; from > 0;) {
    from -= kBitsAtOnce;
    const unsigned size = std::min(kBitsAtOnce, count - from);
    const auto piece = static_cast<std::uint32_t>((bits >> from) & ((1U << size) - 1));
    put(piece << (kProbabilityBits - size), 1U << (kProbabilityBits - size));
  }
}

std::vector<std::byte> RansEncoder::finish() {
  std::vector<std::byte> stream(4 + 2 * words_.size());
  std::memcpy(stream.data(), &state_, 4);
  std::reverse(words_.begin(), words_.end());
  if (!words_.empty()) std::memcpy(stream.data() + 4, words_.data(), 2 * words_.size());
  return stream;
}

RansDecoder::RansDecoder(std::span<const std::byte> stream) : stream_(stream) {
  if (stream.size() < 4) {
    overrun_ = true;
    return;
  }
  std::memcpy(&state_, stream.data(), 4);
  next_ = 4;
  overrun_ = state_ < (1U << 16U);
}

}  // namespace sbrdf::internal
