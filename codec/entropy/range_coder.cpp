#include "codec/entropy/range_coder.h"

#include <algorithm>

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kOne = 32;            // a decision, in the units of counts
constexpr std::uint32_t kMostCounted = 8160;  // 255 decisions
constexpr std::uint32_t kLeastShare = 64;     // of 2^16
constexpr std::uint32_t kLeastRange = 1U << 24U;

std::uint32_t half_of(std::uint32_t range) { return range >> 1U; }
std::uint32_t part_of(std::uint32_t range, std::uint32_t probability) { return (range >> 16U) * probability; }

}  // namespace

std::uint32_t DecisionCounts::probability() const {
  const std::uint32_t share = (static_cast<std::uint32_t>(yes) << 16U) / (static_cast<std::uint32_t>(no) + yes);
  return std::clamp(share, kLeastShare, 65536U - kLeastShare);
}

void DecisionCounts::add(bool decision) {
  std::uint16_t& count = decision ? yes : no;
  count = static_cast<std::uint16_t>(count + kOne);
  if (static_cast<std::uint32_t>(no) + yes <= kMostCounted) return;
  no = static_cast<std::uint16_t>((no + 1U) / 2);
  yes = static_cast<std::uint16_t>((yes + 1U) / 2);
}

// Yes is the lower part.
void RangeEncoder::narrow(bool yes, std::uint32_t yes_part) {
  if (yes) {
    range_ = yes_part;
  } else {
    low_ += yes_part;
    range_ -= yes_part;
  }
  while (range_ < kLeastRange) {
    shift_out();
    range_ <<= 8U;
  }
}

void RangeEncoder::shift_out() {
  if (low_ >> 32U != 0) {
    std::size_t k = bytes_.size();
    while (bytes_[--k] == std::byte{0xFF}) bytes_[k] = std::byte{0};
    bytes_[k] = static_cast<std::byte>(std::to_integer<unsigned>(bytes_[k]) + 1U);
  }
  bytes_.push_back(static_cast<std::byte>((low_ >> 24U) & 0xFFU));
  low_ = (low_ << 8U) & 0xFFFFFFFFU;
}

void RangeEncoder::put(bool decision, DecisionCounts& counts) {
  narrow(decision, part_of(range_, counts.probability()));
  counts.add(decision);
}

void RangeEncoder::put_plain(bool bit) { narrow(bit, half_of(range_)); }

std::vector<std::byte> RangeEncoder::finish() {
  const std::uint64_t end = low_ + range_;
  for (unsigned zeros = 32;; zeros -= 8) {
    const std::uint64_t mask = (std::uint64_t{1} << zeros) - 1;
    const std::uint64_t number = (low_ + mask) & ~mask;
    if (number >= end) continue;
    low_ = number;
    break;
  }
  for (int k = 0; k < 4; ++k) shift_out();
  while (!bytes_.empty() && bytes_.back() == std::byte{0}) bytes_.pop_back();
  return std::move(bytes_);
}

RangeDecoder::RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
  for (int k = 0; k < 4; ++k) code_ = code_ << 8U | next_byte();
}

std::uint32_t RangeDecoder::next_byte() {
  return at_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at_++]) : 0U;
}

bool RangeDecoder::split(std::uint32_t yes_part) {
  const bool yes = code_ < yes_part;
  if (yes) {
    range_ = yes_part;
  } else {
    code_ -= yes_part;
    range_ -= yes_part;
  }
  while (range_ < kLeastRange) {
    code_ = code_ << 8U | next_byte();
    range_ <<= 8U;
  }
  return yes;
}

bool RangeDecoder::take(DecisionCounts& counts) {
  const bool yes = split(part_of(range_, counts.probability()));
  counts.add(yes);
  return yes;
}

bool RangeDecoder::take_plain() { return split(half_of(range_)); }

}  // namespace sbrdf::internal
