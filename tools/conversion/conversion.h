#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/format.h"
#include "converters/source/progress.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// One file as another: what `sbrdf convert` does, of a single file and of each in a folder.
//
//   const ConversionOrder order = {.in = "a.binary", .out = "a.sbrdf", .format = *find_target("sbrdf"), .given = {}};
//   Conversion done;
//   if (const auto failure = convert_file(order, done)) return report_error(failure->subject, failure->error);

/// An error and whose it is.
struct Failure {
  std::string subject;  ///< a path, or what was named; may be empty
  Error error;
};

struct ConversionOrder {
  std::string in;                                ///< as for open_source: a file, FILE:MATERIAL, kurt:NAME
  std::string out;                               ///< the path of the file to write
  const Format* format = nullptr;                ///< of `out`
  Options given = {};                            ///< each must have an effect, see check_effects
  std::shared_ptr<const ByteSource> bytes = {};  ///< of `in`, where the caller has read them; it is a file then
  bool hash_written = false;                     ///< fill in WrittenFile::sha256, which takes another look at the file
};

/// A file that was written, with its bytes as they were when they got their name: whoever replaced it later did not
/// change this.
struct WrittenFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::string sha256;  ///< 64 hexadecimal digits; empty where nobody asked or it could not be read back
};

struct Conversion {
  OpenedSource in;
  std::string sha256;  ///< of the file that was read; empty for a model, a pipe and a material in a file of many
  Report report;
  std::vector<WrittenFile> written;  ///< the file, then those that belong to it
  double seconds = 0;
};

/// The row to write, of what a user said: a row's name or an extension, with or without its dot, letter case ignored.
/// kUsage listing what there is.
[[nodiscard]] Result<const Format*> find_target(std::string_view text);

/// An option without effect is a misunderstanding: each must be one for writing `written` or for reading `read`
/// (nullptr: a model, which takes none). As long as it is not known what is read (nothing), it may be one for reading
/// any format. kUsage naming the first that is not.
[[nodiscard]] Status check_effects(const Options& given, const Format& written, std::optional<const Format*> read);

/// Those of the options that have an effect where a file of `read` is converted to `written`.
[[nodiscard]] Options effective_options(const Options& given, const Format& written, const Format& read);

/// The options as they stand on a command line, in the order in which rows declare them; empty where there are none.
[[nodiscard]] std::string options_text(const Options& given);

/// Reads `in` and writes `out`, which is there whole or not at all. Everything is as `out` alone was asked for: the
/// same bytes whatever was converted before, on any number of threads. Metadata tell the names of the files without
/// their folders. The failure is that of `in` or of `out`, by its subject; errors as open_source, check_output and
/// save_source, interrupted_error() after a signal. `done` is only of use without a failure.
[[nodiscard]] std::optional<Failure> convert_file(const ConversionOrder& order, Conversion& done,
                                                  const Progress& progress = {});

}  // namespace sbrdf::internal
