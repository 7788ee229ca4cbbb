#include "converters/difference/log_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sbrdf::internal {
namespace {

// The exponent and the first bits of a double's fraction number the cells: no logarithm, so no rounding of one.
constexpr unsigned kFractionBits = 52;
constexpr unsigned kCellBits = 7;
constexpr unsigned kShift = kFractionBits - kCellBits;
constexpr double kFirst = 0x1p-34;
constexpr double kEnd = 0x1p30;
constexpr double kWeightUnit = 0x1p-22;
constexpr double kSlack = 1e-12;  // for the rounding of a product: 0.99 of 100 values are 99

constexpr std::uint64_t prefix(double value) { return std::bit_cast<std::uint64_t>(value) >> kShift; }
constexpr std::uint64_t kCells = prefix(kEnd) - prefix(kFirst) + 2;

std::uint64_t cell_of(double value) {
  if (value < kFirst) return 0;
  return value < kEnd ? prefix(value) - prefix(kFirst) + 1 : kCells - 1;
}

double middle_of(std::uint64_t cell) {
  if (cell == 0) return 0;
  if (cell == kCells - 1) return std::numeric_limits<double>::infinity();
  const std::uint64_t start = (cell - 1 + prefix(kFirst)) << kShift;
  return std::bit_cast<double>(start | (1ULL << (kShift - 1)));
}

}  // namespace

void LogHistogram::add(double value, double weight) {
  if (cells_.empty()) cells_.resize(kCells);
  if (std::isnan(value)) {
    has_nan_ = true;
    return;
  }
  cells_[cell_of(value)] += static_cast<std::uint64_t>(std::llround(weight / kWeightUnit));
  least_ = std::min(least_, value);
  largest_ = std::max(largest_, value);
}

void LogHistogram::add(const LogHistogram& other) {
  if (cells_.empty()) cells_.resize(kCells);
  for (std::size_t cell = 0; cell < other.cells_.size(); ++cell) cells_[cell] += other.cells_[cell];
  least_ = std::min(least_, other.least_);
  largest_ = std::max(largest_, other.largest_);
  has_nan_ = has_nan_ || other.has_nan_;
}

double LogHistogram::quantile(double part) const {
  std::uint64_t total = 0;
  for (const std::uint64_t count : cells_) total += count;
  if (has_nan_ || total == 0) return std::numeric_limits<double>::quiet_NaN();
  const double wanted = part * static_cast<double>(total) * (1 - kSlack);
  std::uint64_t below = 0;
  std::uint64_t cell = 0;
  for (; cell + 1 < cells_.size(); ++cell) {
    below += cells_[cell];
    if (static_cast<double>(below) >= wanted) break;
  }
  return std::clamp(middle_of(cell), least_, largest_);
}

}  // namespace sbrdf::internal
