#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "converters/files/format.h"
#include "converters/source/progress.h"
#include "tools/conversion/conversion.h"
#include "tools/conversion/folder.h"

namespace sbrdf::internal {

// All files of a folder as files of one format in another. Files are converted one after the other, each on all cores;
// for more at once, several runs take a shard each. specs/convert.md is the manual.

struct FolderOrder {
  std::string folder;
  std::string out_folder;          ///< made where it is missing
  const Format* format = nullptr;  ///< of all outputs
  Options given = {};              ///< each file is converted with those that have an effect on it
  Shard shard = {};                ///< which of the files, counted off in turn
  bool recursive = false;
  std::string report = {};  ///< where the reports go as a JSON array; empty: nowhere
};

enum class Fate : std::uint8_t {
  kConverted,
  kKept,  ///< an earlier run had done the same, and its output is untouched
  kFailed,
  kSkipped,  ///< nobody would convert it
};

/// What became of one file.
struct FileOutcome {
  Fate fate = Fate::kFailed;
  std::string in;
  std::string out;                 ///< empty where it was skipped
  nlohmann::ordered_json report;   ///< with a member "result": the name of the fate
  std::optional<Failure> failure;  ///< of kFailed
  std::optional<Error> note;       ///< why a later run will not know that it was converted
};

struct FolderWatcher {
  std::function<void(const FileOutcome&)>
      tell;                ///< of each file as soon as it is known; skipped ones first, then by name
  Progress progress = {};  ///< through what is left to convert
};

/// All outcomes, in the order in which they were told; after a signal also those that an earlier run had done and this
/// did not reach. Files that fail do not stop the others. A failure is that of the whole: kUsage where the folders are
/// the same, or hold each other so that outputs would be inputs, where there is nothing to convert, an option fits
/// nothing, or the report would replace a BRDF; kIo where a folder cannot be read or takes no files, or the report
/// cannot be written; interrupted_error() after a signal, with the report written for all that was done.
[[nodiscard]] std::optional<Failure> convert_folder(const FolderOrder& order, const FolderWatcher& watcher,
                                                    std::vector<FileOutcome>& outcomes);

}  // namespace sbrdf::internal
