#include "tools/console/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "formats/core/interrupted.h"
#include "formats/os/interrupt.h"
#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMostPending = std::size_t{1} << 20U;  // bytes that are printed before they are handed out

std::string pending;
int output_errno = 0;  // the first failure's reason
bool interrupt_told = false;

/// A pipe that takes anything at all takes this much at once, without making the program wait where no signal ends it.
std::size_t size_of_piece() {
  struct stat status {};
  const bool is_file = ::fstat(STDOUT_FILENO, &status) == 0 && S_ISREG(status.st_mode);
  return is_file ? kMostPending : 4096;
}

void write_to_error_output(std::string_view text) {
  // In the order in which it happened, where both outputs go to one place.
  std::ignore = flush_output();
  while (!text.empty()) {
    const ssize_t put = ::write(STDERR_FILENO, text.data(), text.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return;  // nothing is left to tell it to
    text.remove_prefix(static_cast<std::size_t>(put));
  }
}

void print_error(std::string_view line) { write_to_error_output("sbrdf: " + std::string(line) + "\n"); }

int tell_interrupt() {
  if (!std::exchange(interrupt_told, true)) print_error(interrupted_error().message);
  return interrupt_exit_code();
}

/// Objects and what holds them on lines of their own, lists of plain values on one. `line_feed` is followed by the
/// indent.
void append_json(const nlohmann::ordered_json& json, const std::string& line_feed, std::string& text) {
  const bool on_one_line = !json.is_object() && std::none_of(json.begin(), json.end(),
                                                             [](const auto& item) { return item.is_structured(); });
  if (!json.is_structured() || json.empty() || on_one_line) {
    text += json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    return;
  }
  const std::string deeper = line_feed + "  ";
  text += json.is_object() ? '{' : '[';
  const char* separator = "";
  for (const auto& [key, value] : json.items()) {
    text += separator + deeper;
    if (json.is_object()) {
      append_json(key, deeper, text);
      text += ": ";
    }
    append_json(value, deeper, text);
    separator = ",";
  }
  text += line_feed + (json.is_object() ? "}" : "]");
}

}  // namespace

void keep_standard_descriptors() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(number, F_GETFD) >= 0) continue;
    // The least free number is the one that is missing. With O_PATH every read and write fails with EBADF, as they
    // would without a file.
    std::ignore = ::open("/", O_PATH);
  }
}

void print(std::string_view text) {
  if (output_errno != 0) return;
  pending += text;
  if (pending.size() >= kMostPending) std::ignore = flush_output();
}

bool flush_output() {
  const std::string text = std::exchange(pending, {});
  const std::size_t piece = text.empty() ? 0 : size_of_piece();
  for (std::size_t done = 0; done < text.size() && output_errno == 0;) {
    if (!wait_for_output(STDOUT_FILENO)) return false;
    const ssize_t put = ::write(STDOUT_FILENO, text.data() + done, std::min(piece, text.size() - done));
    if (put < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (put < 0) {
      output_errno = errno;
    } else {
      done += static_cast<std::size_t>(put);
    }
  }
  return output_errno == 0;
}

std::string json_text(const nlohmann::ordered_json& json) {
  std::string text;
  append_json(json, "\n", text);
  return escape_controls(text) + "\n";
}

void print_json(const nlohmann::ordered_json& json) { print(json_text(json)); }

int report_error(std::string_view subject, const Error& error) {
  if (interrupted()) return tell_interrupt();
  std::string line = (subject.empty() ? "" : one_line(subject) + ": ") + one_line(error.message);
  if (error.offset) line += fmt::format(" (at byte {})", *error.offset);
  print_error(line);
  return static_cast<int>(error.code);
}

void print_note(std::string_view subject, std::string_view text) {
  print_error(one_line(subject) + ": " + one_line(text));
}

int report_no_memory() {
  write_to_error_output("sbrdf: not enough memory\n");
  return static_cast<int>(ErrorCode::kIo);
}

int finish_output(int exit_code) {
  std::ignore = flush_output();
  // Some file systems tell only now that there was no room.
  if (::close(STDOUT_FILENO) != 0 && output_errno == 0 && errno != EINTR) output_errno = errno;
  stop_catching_interrupts();
  if (interrupted()) return tell_interrupt();
  if (output_errno == 0 || exit_code != 0) return exit_code;
  print_error("standard output: " + std::generic_category().message(output_errno));
  return static_cast<int>(ErrorCode::kIo);
}

}  // namespace sbrdf::internal
