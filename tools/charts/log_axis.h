#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sbrdf::internal {

/// How numbers are written along an axis.
enum class Numerals : std::uint8_t {
  kPlain,  ///< 0.01, 1, 1,000
  kBytes,  ///< 1 B, 20 kB, 5 MB: powers of 1000
};

/// A number for people, as it stands at a tick.
[[nodiscard]] std::string numeral(double value, Numerals numerals);

/// A line across an axis.
struct Tick {
  double value = 0;
  std::string label;  ///< empty for the minor ones
};

/// A logarithmic axis that begins and ends at 1, 2 or 5 times a power of ten.
class LogAxis {
 public:
  /// The smallest such axis that holds both with a little room, and spans a factor of 4 or more. 0 < least <= most,
  /// both finite.
  [[nodiscard]] static LogAxis around(double least, double most, Numerals numerals);

  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  /// 0 at the low end, 1 at the high end, where values beyond are held.
  [[nodiscard]] double place(double value) const;
  /// Rising. Over more than three powers of ten labels stand at these alone, over more than one at 1, 2 and 5 times
  /// these, else at all digits.
  [[nodiscard]] std::vector<Tick> ticks() const;

 private:
  LogAxis(double low, double high, Numerals numerals) : low_(low), high_(high), numerals_(numerals) {}

  double low_;
  double high_;
  Numerals numerals_;
};

}  // namespace sbrdf::internal
