#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "converters/audit/audit.h"
#include "converters/files/options.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Which rows of an audit are done, so that a second run does the rest only: a file for each material in a hidden
/// folder beside the report. Rows hold for files that have not changed since, and for the same version, number of
/// directions and options of reading; other targets and methods may be added later.
class AuditJournal {
 public:
  static constexpr const char* kFolder = ".sbrdf-audit";

  /// In the folder of the report, which is there.
  AuditJournal(const std::string& folder, const AuditSettings& settings, const Options& given);

  /// kIo where the folder takes no files.
  [[nodiscard]] Status start() const;
  /// The rows of a material. Notes are written at once, also after a signal; `complain` is told where one cannot be.
  [[nodiscard]] std::unique_ptr<AuditMemory> memory_of(const std::string& material,
                                                       std::function<void(const Error&)> complain) const;

 private:
  /// All that rows follow from, as text.
  [[nodiscard]] std::string work_on(const std::string& material) const;
  [[nodiscard]] std::string entry_of(const std::string& material) const;

  std::string folder_;
  std::string settings_;
};

}  // namespace sbrdf::internal
