#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/core/result.h"
#include "tools/conversion/conversion.h"

namespace sbrdf::internal {

// Which conversions of a folder are done, so that a second run does the rest only. Each output has an entry of its own,
// OUTDIR/.sbrdf-convert/NAME.json, which is written once the output has its name: whatever ends a run, what has an
// entry is whole. No two outputs share one, so that any number of runs may work in a folder at once, and the entries do
// not depend on who made them, when, or where.

/// All that an output follows from.
struct Work {
  std::string source;          ///< name of the file, which metadata tell
  std::string sha256;          ///< of its content
  std::string sidecar_sha256;  ///< of the file that belongs to it; empty where there is none
  std::string options;         ///< those that have an effect, as options_text gives them
  std::string target;          ///< name of the row
};

class Journal {
 public:
  /// Of the outputs in `folder`, which need not be there before start().
  explicit Journal(std::string folder) : folder_(std::move(folder)) {}

  /// Where the entries lie.
  [[nodiscard]] std::string folder() const;

  /// Makes the folders that are missing. kIo where they take no files.
  [[nodiscard]] Status start() const;
  /// The same for the subfolder of an output, such as "cloth/a.sbrdf".
  [[nodiscard]] Status make_room(const std::string& out) const;

  /// Whether an output was begun and finished at some time, by any version and with any options: finished_report may
  /// find something.
  [[nodiscard]] bool has_entry(const std::string& out) const;

  /// The report of an output that is there, by this work and this version of the program, and whose files have the size
  /// and content that they were written with. Nothing otherwise: it is to be made again. `out` is relative to the
  /// folder.
  [[nodiscard]] std::optional<nlohmann::ordered_json> finished_report(const std::string& out, const Work& work) const;

  /// Says so of an output that has just got its name, also after a signal. Of the report, folders and times are left
  /// out. kIo as for any file.
  [[nodiscard]] Status finish(const std::string& out, const Work& work, const std::vector<WrittenFile>& written,
                              const nlohmann::ordered_json& report) const;

 private:
  [[nodiscard]] std::string entry_of(const std::string& out) const;

  std::string folder_;
};

}  // namespace sbrdf::internal
