#include "tools/bench/figures.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/charts/log_axis.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

Figure count_or_nothing(std::uint64_t count) { return count > 0 ? Figure(count) : Figure(); }
Figure optional_count(const std::optional<std::uint64_t>& count) { return count ? Figure(*count) : Figure(); }

constexpr std::array kBenchColumns = {
    Column<BenchRow>{"material", [](const BenchRow& row) { return Figure(row.material); }},
    Column<BenchRow>{"method", [](const BenchRow& row) { return Figure(row.method); }},
    Column<BenchRow>{"variant", [](const BenchRow& row) { return Figure(row.variant); }},
    Column<BenchRow>{"samples", [](const BenchRow& row) { return count_or_nothing(row.samples); }},
    Column<BenchRow>{"single_ns", [](const BenchRow& row) { return Figure(row.single_ns); }},
    Column<BenchRow>{"single_ratio", [](const BenchRow& row) { return Figure(row.single_ratio()); }},
    Column<BenchRow>{"batch_ns", [](const BenchRow& row) { return Figure(row.batch_ns); }},
    Column<BenchRow>{"batch_ratio", [](const BenchRow& row) { return Figure(row.batch_ratio()); }},
    Column<BenchRow>{"yardstick_ns", [](const BenchRow& row) { return Figure(row.yardstick_ns); }},
    Column<BenchRow>{"first_value_ms", [](const BenchRow& row) { return Figure(row.first_value_ms); }},
    Column<BenchRow>{"resident_bytes", [](const BenchRow& row) { return Figure(row.resident_bytes); }},
    Column<BenchRow>{"file_bytes", [](const BenchRow& row) { return optional_count(row.file_bytes); }},
    Column<BenchRow>{"grid_mre_percent", [](const BenchRow& row) { return Figure(row.quality.grid_mre_percent); }},
    Column<BenchRow>{"grid_rel_l1_percent",
                     [](const BenchRow& row) { return Figure(row.quality.grid_rel_l1_percent); }},
    Column<BenchRow>{"off_grid_mre_percent",
                     [](const BenchRow& row) { return Figure(row.quality.off_grid_mre_percent); }},
    Column<BenchRow>{"off_grid_rel_l1_percent",
                     [](const BenchRow& row) { return Figure(row.quality.off_grid_rel_l1_percent); }},
};

constexpr std::array kGrowthColumns = {
    Column<GrowthRow>{"material", [](const GrowthRow& row) { return Figure(row.material); }},
    Column<GrowthRow>{"method", [](const GrowthRow& row) { return Figure(row.method); }},
    Column<GrowthRow>{"against",
                      [](const GrowthRow& row) { return Figure(std::string(name_of(kGrowthAxisNames, row.axis))); }},
    Column<GrowthRow>{"at", [](const GrowthRow& row) { return Figure(row.at); }},
    Column<GrowthRow>{"ns", [](const GrowthRow& row) { return Figure(row.ns); }},
    Column<GrowthRow>{"ratio", [](const GrowthRow& row) { return Figure(row.ratio()); }},
    Column<GrowthRow>{"yardstick_ns", [](const GrowthRow& row) { return Figure(row.yardstick_ns); }},
    Column<GrowthRow>{"resident_bytes", [](const GrowthRow& row) { return count_or_nothing(row.resident_bytes); }},
};

}  // namespace

std::span<const Column<BenchRow>> bench_columns() { return kBenchColumns; }
std::span<const Column<GrowthRow>> growth_columns() { return kGrowthColumns; }

std::string bench_csv(std::span<const BenchRow> rows, const std::string& machine) {
  return csv_of(rows, bench_columns(), "machine", machine);
}
std::string growth_csv(std::span<const GrowthRow> rows, const std::string& machine) {
  return csv_of(rows, growth_columns(), "machine", machine);
}
Json bench_json(std::span<const BenchRow> rows) { return json_of(rows, bench_columns()); }
Json growth_json(std::span<const GrowthRow> rows) { return json_of(rows, growth_columns()); }

std::string bytes_text(std::optional<std::uint64_t> bytes) {
  return bytes ? numeral(static_cast<double>(*bytes), Numerals::kBytes) : "-";
}

}  // namespace sbrdf::internal
