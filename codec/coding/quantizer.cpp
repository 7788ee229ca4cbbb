#include "codec/coding/quantizer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kParts = 256;
constexpr double kFloatRounding = 1.0 / 16777216;  // 2^-24: what the last step to float32 may add

double power(double base, std::uint32_t exponent) {
  double result = 1;
  for (std::uint32_t k = 0; k < exponent; ++k) result *= base;
  return result;
}

// The n-th root of 2 by bisection: only multiplications and comparisons, so it has the same bits everywhere.
double root_of_two(std::uint32_t n) {
  double low = 1;
  double high = 2;
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return high;
    (power(middle, n) < 2 ? low : high) = middle;
  }
}

}  // namespace

std::uint32_t millionths_of(double bound) {
  // A bound that was a decimal fraction is one again.
  constexpr double kRounding = 1e-9;
  return static_cast<std::uint32_t>(std::floor(bound * 1e6 * (1 + kRounding)));
}

Quantizer::Quantizer(double bound) : bound_(bound) {
  assert(bound >= kFinestBound && bound <= kCoarsestBound);
  // Two neighbours g and g ratio: the value between them that is as far from both, as a part of itself, is off by
  // (ratio - 1) / (ratio + 1).
  const double left = bound - kFloatRounding;
  const double widest = (1 + left) / (1 - left);
  for (double reached = 1; reached < 2; reached *= widest) ++per_octave_;
  ratio_ = root_of_two(per_octave_);
  make_table();
}

Quantizer::Quantizer(double bound, std::int32_t lowest) : Quantizer(bound) { lowest_ = lowest; }

void Quantizer::make_table() {
  reciprocal_ = 1.0 / per_octave_;
  table_.resize(per_octave_);
  double next = 1;
  for (double& entry : table_) {
    entry = next;
    next *= ratio_;
  }
  starts_.resize(kParts);
  for (std::size_t part = 0; part < kParts; ++part) {
    const double start = 1 + static_cast<double>(part) / kParts;
    starts_[part] =
        static_cast<std::uint32_t>(std::upper_bound(table_.begin(), table_.end(), start) - table_.begin()) - 1;
  }
}

double Quantizer::magnitude(std::int64_t power) const {
  const auto n = static_cast<std::int64_t>(per_octave_);
  // Division by way of the reciprocal is off by one at most, which is put right.
  auto octave = static_cast<std::int64_t>(static_cast<double>(power) * reciprocal_);
  octave -= power < octave * n ? 1 : 0;
  octave += power >= (octave + 1) * n ? 1 : 0;
  // Far beyond the range of float32 the octave does not matter any more.
  const std::int64_t exponent = 1023 + std::clamp<std::int64_t>(octave, -1000, 1000);
  return table_[static_cast<std::size_t>(power - octave * n)] *
         std::bit_cast<double>(static_cast<std::uint64_t>(exponent) << 52U);
}

void Quantizer::begin_at_smallest(std::initializer_list<std::span<const float>> lists) {
  if (lossless()) return;
  float smallest = std::numeric_limits<float>::max();
  for (const std::span<const float> values : lists) {
    for (const float v : values) smallest = v != 0 ? std::min(smallest, std::abs(v)) : smallest;
  }
  lowest_ = 0;
  lowest_ = step(smallest) - 1;
}

std::int32_t Quantizer::step(float value) const {
  if (lossless()) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const auto magnitude_bits = static_cast<std::int32_t>(bits & 0x7FFFFFFFU);
    return (bits >> 31U) != 0 ? -magnitude_bits : magnitude_bits;
  }
  if (value == 0) return 0;
  const double target = std::abs(static_cast<double>(value));
  // Every float32 but 0 is a normal double.
  const auto bits = std::bit_cast<std::uint64_t>(target);
  const auto exponent = static_cast<std::int64_t>(bits >> 52U) - 1023;
  const double mantissa = std::bit_cast<double>((bits & ((1ULL << 52U) - 1)) | (1023ULL << 52U));  // in [1, 2)
  std::size_t below = starts_[static_cast<std::size_t>((mantissa - 1) * kParts)];
  while (below + 1 < table_.size() && table_[below + 1] <= mantissa) ++below;
  std::int64_t power = exponent * per_octave_ + static_cast<std::int64_t>(below);
  // The lower neighbour is found; the upper one may be nearer as a part of the value.
  if (magnitude(power + 1) - target < target - magnitude(power)) ++power;
  const auto step = static_cast<std::int32_t>(power - lowest_ + 1);
  return value < 0 ? -step : step;
}

float Quantizer::value(std::int32_t step) const {
  const auto size = static_cast<std::uint32_t>(step < 0 ? -static_cast<std::int64_t>(step) : step);
  if (lossless()) {
    // The most negative step has no counterpart; it may only come from a damaged file.
    if (size > 0x7FFFFFFFU) return -std::numeric_limits<float>::infinity();
    return std::bit_cast<float>(size | (step < 0 ? 0x80000000U : 0U));
  }
  if (step == 0) return 0;
  const auto f = static_cast<float>(magnitude(static_cast<std::int64_t>(size) - 1 + lowest_));
  return step < 0 ? -f : f;
}

}  // namespace sbrdf::internal
