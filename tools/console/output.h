#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// What the program says and how it ends. Whatever is lost on the way ends with an exit code other than 0: a closed
/// descriptor, a full disk, a reader that went away.

/// Opens those of the descriptors 0, 1 and 2 that are closed onto something that can be neither read nor written, so
/// that no other file gets such a number: a read of the input would then wait for it, and output would end up in it.
/// To be called before anything else is opened.
void keep_standard_descriptors();

/// Appends to standard output. Failures are remembered for finish_output.
void print(std::string_view text);

/// Hands what was printed to the reader, however slow, unless a signal comes. False once output was lost.
[[nodiscard]] bool flush_output();

/// An object or array and a line feed. Bytes that are not UTF-8 are replaced, what controls a terminal is escaped, NaN
/// and infinity become null.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& json);

/// Prints json_text.
void print_json(const nlohmann::ordered_json& json);

/// The line "sbrdf: SUBJECT: MESSAGE (at byte N)" on standard error, each part passed through one_line; `subject` is
/// the file, and may be empty. Returns the exit code: that of the error. After a signal the line is "sbrdf:
/// interrupted", once, whatever the error, and the code is that of the signal.
[[nodiscard]] int report_error(std::string_view subject, const Error& error);

/// The line "sbrdf: SUBJECT: TEXT" on standard error, for what is no error but should be known.
void print_note(std::string_view subject, std::string_view text);

/// Its own line and the exit code, without asking for memory.
[[nodiscard]] int report_no_memory();

/// The end of the program: hands out the rest of the output, and stops catching signals. `exit_code`; or that of a
/// signal that came, however late; or that of kIo with a line on standard error where some output was lost and the
/// program had not failed already.
[[nodiscard]] int finish_output(int exit_code);

}  // namespace sbrdf::internal
