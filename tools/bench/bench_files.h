#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "converters/bench/bench.h"
#include "formats/core/result.h"
#include "tools/bench/machine.h"
#include "tools/io/report_folder.h"

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
  explicit BenchFolder(std::string path) : folder_(std::move(path), "machine") {}

  /// As ReportFolder::prepare.
  [[nodiscard]] Status prepare(const std::vector<std::string>& materials, const std::vector<std::string>& inputs);
  /// As ReportFolder::write.
  [[nodiscard]] Status write(const BenchReport& report, const BenchRun& run) const;
  void take_back() const { folder_.take_back(); }

 private:
  ReportFolder folder_;
};

/// Everything of a run: what bench.json holds and `--json` prints.
[[nodiscard]] nlohmann::ordered_json bench_run_json(const BenchReport& report, const BenchRun& run);

}  // namespace sbrdf::internal
