#include "tools/charts/log_axis.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <fmt/format.h>

#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

constexpr double kRoom = 1.08;      // beyond the outermost values, as a factor
constexpr double kLeastSpan = 4;    // as a factor
constexpr double kSame = 1 + 1e-9;  // equal up to rounding
constexpr std::array<int, 3> kEnds = {1, 2, 5};

/// digit x 10^power, as near as it can be: 10^-3 itself is not.
double step(int digit, int power) {
  const double tens = std::pow(10.0, std::abs(power));
  return power < 0 ? digit / tens : digit * tens;
}

int power_of(double value) { return static_cast<int>(std::floor(std::log10(value) + 1e-12)); }

double at_most(double value) {
  const int power = power_of(value);
  double best = step(5, power - 1);
  for (const int digit : kEnds) {
    if (step(digit, power) <= value * kSame) best = step(digit, power);
  }
  return best;
}

double at_least(double value) {
  const int power = power_of(value);
  for (const int digit : kEnds) {
    if (step(digit, power) * kSame >= value) return step(digit, power);
  }
  return step(1, power + 1);
}

}  // namespace

std::string numeral(double value, Numerals numerals) {
  if (numerals == Numerals::kPlain) {
    if (value >= 1000) return format_count(static_cast<std::uint64_t>(std::llround(value)));
    return fmt::format("{:.4g}", value);
  }
  constexpr std::array<const char*, 5> kUnits = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  return fmt::format("{:.3g} {}", value, kUnits.at(unit));
}

LogAxis LogAxis::around(double least, double most, Numerals numerals) {
  assert(least > 0 && least <= most && std::isfinite(most));
  double low = at_most(least / kRoom);
  double high = at_least(most * kRoom);
  while (high < low * kLeastSpan / kSame) {
    low = at_most(low / 1.5);
    high = at_least(high * 1.5);
  }
  return {low, high, numerals};
}

double LogAxis::place(double value) const {
  if (!(value > low_)) return 0;
  return std::min(std::log(value / low_) / std::log(high_ / low_), 1.0);
}

std::vector<Tick> LogAxis::ticks() const {
  const double powers = std::log10(high_ / low_);
  const auto is_labelled = [&](int digit) {
    if (powers > 3) return digit == 1;
    return powers <= 1 || digit == 1 || digit == 2 || digit == 5;
  };
  std::vector<Tick> ticks;
  for (int power = power_of(low_); step(1, power) <= high_ * kSame; ++power) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = step(digit, power);
      if (value * kSame < low_ || value > high_ * kSame) continue;
      ticks.push_back({value, is_labelled(digit) ? numeral(value, numerals_) : ""});
    }
  }
  return ticks;
}

}  // namespace sbrdf::internal
