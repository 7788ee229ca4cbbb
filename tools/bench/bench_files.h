#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "converters/bench/bench.h"
#include "formats/core/result.h"
#include "tools/bench/machine.h"

namespace sbrdf::internal {

/// What a run was asked for and how it went.
struct BenchRun {
  std::vector<std::string> materials;  ///< names, in the order of the report
  Machine machine;
  BenchSettings settings;
  std::string command;
  double seconds = 0;
};

/// The folder of a benchmark's files: bench.csv, growth.csv, bench.json, bench.md, and the charts.
class BenchFolder {
 public:
  explicit BenchFolder(std::string path) : path_(std::move(path)) {}

  /// Makes the folder if it is missing, and looks whether each file can be written there: for asking before long work.
  /// `inputs` are what is read, as it was named: nothing of that is ever replaced. kIo and kUsage as check_output();
  /// the message names the file.
  [[nodiscard]] Status prepare(const std::vector<std::string>& materials, const std::vector<std::string>& inputs);
  /// All files, each whole or not at all. interrupted_error() where a signal came before the last.
  [[nodiscard]] Status write(const BenchReport& report, const BenchRun& run) const;
  /// Takes a folder away that prepare() made and that is still empty.
  void take_back() const;

 private:
  std::string path_;
  bool made_ = false;
};

/// Everything of a run: what bench.json holds and `--json` prints.
[[nodiscard]] nlohmann::ordered_json bench_run_json(const BenchReport& report, const BenchRun& run);

}  // namespace sbrdf::internal
