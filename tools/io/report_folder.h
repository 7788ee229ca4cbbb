#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// A folder that a run of measurements writes its tables, page and charts to.
class ReportFolder {
 public:
  /// `first_member`: the first of the JSON files that it writes, by which they are told from parameters of materials.
  ReportFolder(std::string path, std::string first_member)
      : path_(std::move(path)), first_member_(std::move(first_member)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Of a file in it.
  [[nodiscard]] std::string path_of(const std::string& file) const;

  /// Makes the folder if it is missing, and looks whether each of `files` can be written there: for asking before long
  /// work. `inputs` are what is read, as it was named: nothing of that is ever replaced. kIo and kUsage as
  /// check_output(); the message names the file.
  [[nodiscard]] Status prepare(const std::vector<std::string>& files, const std::vector<std::string>& inputs);
  /// Names and texts: all files, each whole or not at all. interrupted_error() where a signal came before the last.
  [[nodiscard]] Status write(const std::vector<std::pair<std::string, std::string>>& files) const;
  /// Takes a folder away that prepare() made and that is still empty.
  void take_back() const;

 private:
  std::string path_;
  std::string first_member_;
  bool made_ = false;
};

}  // namespace sbrdf::internal
