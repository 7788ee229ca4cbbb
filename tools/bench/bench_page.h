#pragma once

#include <string>
#include <vector>

#include "converters/bench/bench.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {

/// A material's rows, or growth, as people read them: cells with their units.
using TextRows = std::vector<std::vector<std::string>>;

/// The rows of one material, the head first.
[[nodiscard]] TextRows material_table(const BenchReport& report, const std::string& material);
/// All growth along one axis, the head first; only the head where there is none.
[[nodiscard]] TextRows growth_table(const BenchReport& report, GrowthAxis axis);
/// "plain look-up 195 ns; memory read 12 GB/s, ...".
[[nodiscard]] std::string yardstick_text(const BenchReport& report);

/// Everything as a page in Markdown, with the charts, for specs/results.
[[nodiscard]] std::string bench_page(const BenchReport& report, const std::vector<std::string>& materials,
                                     const std::string& machine, const std::string& command);

}  // namespace sbrdf::internal
