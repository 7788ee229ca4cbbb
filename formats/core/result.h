#pragma once

#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace sbrdf::internal {

/// What went wrong, by who can mend it. The values are the exit codes of the program.
enum class ErrorCode : std::uint8_t {
  kUsage = 1,        ///< an option or a parameter is out of its range
  kIo = 2,           ///< the operating system refused to read or write
  kInvalidFile = 3,  ///< the bytes do not form a valid file, or hold values that cannot be a BRDF
  kUnsupported = 4,  ///< valid, but of a kind that is not handled
  kDifference = 5,   ///< a measured difference is above the limit that was asked for
};

/// A failure as a value. `message` is one line without the file's name, which the caller that knows it puts before;
/// `offset` is the position in the file [bytes from its start] where that makes sense.
struct Error {
  ErrorCode code = ErrorCode::kInvalidFile;
  std::string message;
  std::optional<std::uint64_t> offset;
};

/// The five kinds in one word each: `return invalid_file("no samples", offset);`.
[[nodiscard]] inline Error usage_error(std::string message) { return {ErrorCode::kUsage, std::move(message), {}}; }
[[nodiscard]] inline Error io_error(std::string message) { return {ErrorCode::kIo, std::move(message), {}}; }
[[nodiscard]] inline Error invalid_file(std::string message, std::optional<std::uint64_t> offset = {}) {
  return {ErrorCode::kInvalidFile, std::move(message), offset};
}
[[nodiscard]] inline Error unsupported(std::string message, std::optional<std::uint64_t> offset = {}) {
  return {ErrorCode::kUnsupported, std::move(message), offset};
}
[[nodiscard]] inline Error difference_error(std::string message) {
  return {ErrorCode::kDifference, std::move(message), {}};
}

/// Either a value or an Error. Asking for the one that is not there is a bug of the caller.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor): `return value;`
  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor): `return error;`

  [[nodiscard]] bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] const Error& error() const {
    assert(!ok());
    return *std::get_if<Error>(&state_);
  }
  [[nodiscard]] T& value() & {
    assert(ok());
    return *std::get_if<T>(&state_);
  }
  [[nodiscard]] const T& value() const& {
    assert(ok());
    return *std::get_if<T>(&state_);
  }
  [[nodiscard]] T&& value() && {
    assert(ok());
    return std::move(*std::get_if<T>(&state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value.
using Status = Result<std::monostate>;
[[nodiscard]] inline Status ok_status() { return std::monostate{}; }

}  // namespace sbrdf::internal
