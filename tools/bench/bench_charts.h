#pragma once

#include <string>
#include <vector>

#include "converters/bench/bench.h"
#include "tools/charts/chart.h"

namespace sbrdf::internal {

/// A picture of a benchmark, and what its file is called.
struct NamedChart {
  std::string file;  ///< "kurt-fabric112-time.svg"
  Chart chart;
};

/// For each of these materials, time against error and bytes against error. `machine` goes below each.
[[nodiscard]] std::vector<NamedChart> material_charts(const BenchReport& report,
                                                      const std::vector<std::string>& materials,
                                                      const std::string& machine);
/// Growth against samples, batch size and threads.
[[nodiscard]] std::vector<NamedChart> growth_charts(const BenchReport& report, const std::string& machine);

/// Names of all of them, before anything is measured.
[[nodiscard]] std::vector<std::string> chart_files(const std::vector<std::string>& materials);

}  // namespace sbrdf::internal
