#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf {

/// Appends to standard output. Failures are remembered for finish_output.
void print(std::string_view text);

/// Hands what was printed to the reader. False once output was lost.
[[nodiscard]] bool flush_output();

/// Prints an object or array and a line feed. Bytes that are not UTF-8 are replaced, NaN and infinity become null.
void print_json(const nlohmann::ordered_json& json);

/// Empties the buffer of standard output. `exit_code`, or that of kIo with a line on standard error where some output
/// was lost and the program had not failed already.
[[nodiscard]] int finish_output(int exit_code);

/// The line "sbrdf: SUBJECT: MESSAGE (at byte N)" on standard error; `subject` is the file, and may be empty. Returns
/// the exit code: that of the error, or of the signal after an interrupt.
[[nodiscard]] int report_error(std::string_view subject, const Error& error);

/// Control characters, which names and messages from files may hold, replaced by '?'.
[[nodiscard]] std::string one_line(std::string_view text);

/// Four significant digits; "-" for NaN, "infinite".
[[nodiscard]] std::string format_number(double value);
/// Digits in groups of three: 34,992,012.
[[nodiscard]] std::string format_count(std::uint64_t value);
/// "a, b, c".
[[nodiscard]] std::string join(const std::vector<std::string>& words);

/// Rows of cells in columns as wide as they need to be. Cells pass through one_line.
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

}  // namespace sbrdf
