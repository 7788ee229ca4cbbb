#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Reads lines from standard input as they come: a block holds the whole lines that have arrived, so that a program
/// that writes one line and waits gets its answer.
class LineReader {
 public:
  /// The next lines, each with its end, valid until the next call; the last may have none. No lines: the end of the
  /// input. kIo where reading fails, interrupted_error() after a signal, kInvalidFile for a line above 2^20 bytes.
  [[nodiscard]] Result<std::vector<std::string_view>> next();

 private:
  [[nodiscard]] Status fill();

  std::string buffer_;
  std::size_t taken_ = 0;  ///< bytes of buffer_ given out by the last call
  bool at_end_ = false;
};

}  // namespace sbrdf::internal
