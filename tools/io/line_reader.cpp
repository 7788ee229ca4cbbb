#include "tools/io/line_reader.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "converters/source/progress.h"
#include "formats/os/interrupt.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

Status LineReader::fill() {
  const std::size_t size = buffer_.size();
  buffer_.resize(size + kBlock);
  ssize_t got = -1;
  do {
    if (!wait_for_input(STDIN_FILENO)) return interrupted_error();
    got = ::read(STDIN_FILENO, buffer_.data() + size, kBlock);
  } while (got < 0 && (errno == EINTR || errno == EAGAIN));
  if (got < 0) {
    return io_error("cannot be read: " + std::generic_category().message(errno));
  }
  buffer_.resize(size + static_cast<std::size_t>(got));
  at_end_ = got == 0;
  return ok_status();
}

Result<std::vector<std::string_view>> LineReader::next() {
  buffer_.erase(0, taken_);
  taken_ = 0;
  std::size_t searched = 0;
  while (!at_end_ && buffer_.find('\n', searched) == std::string::npos) {
    searched = buffer_.size();
    if (searched > kLongestLine) {
      return invalid_file("a line is longer than " + std::to_string(kLongestLine) + " bytes");
    }
    if (Status filled = fill(); !filled) return filled.error();
  }
  std::vector<std::string_view> lines;
  const std::string_view text = buffer_;
  while (taken_ < text.size()) {
    const std::size_t end = text.find('\n', taken_);
    if (end == std::string_view::npos && !at_end_) break;
    const std::size_t size = (end == std::string_view::npos ? text.size() : end + 1) - taken_;
    lines.push_back(text.substr(taken_, size));
    taken_ += size;
  }
  return lines;
}

}  // namespace sbrdf::internal
