#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/console/output.h"      // IWYU pragma: export
#include "tools/console/plain_text.h"  // IWYU pragma: export

namespace sbrdf::internal {

/// Four significant digits; "-" for NaN, "infinite".
[[nodiscard]] std::string format_number(double value);
/// Digits in groups of three: 34,992,012.
[[nodiscard]] std::string format_count(std::uint64_t value);
/// "a, b, c".
[[nodiscard]] std::string join(const std::vector<std::string>& words);

/// Channels that tables for people have columns for; JSON has them all.
inline constexpr std::size_t kMostChannelColumns = 4;

/// Whether a figure is above a limit that was asked for, or is no number.
[[nodiscard]] inline bool exceeds(double value, const std::optional<double>& limit) {
  return limit && !(value <= *limit);
}

/// Rows of cells in columns as wide as they need to be. Cells pass through one_line, which cuts all but the last of a
/// row much sooner.
class Table {
 public:
  void add(std::vector<std::string> cells);
  void print() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace sbrdf::internal
