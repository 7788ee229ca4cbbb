#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "converters/bench/bench.h"

namespace sbrdf::internal {

/// A figure, a count, a name, or nothing.
using Figure = std::variant<std::monostate, double, std::uint64_t, std::string>;

/// A column of what a benchmark tells: CSV, JSON and the tables for people all go by these, so that they agree.
template <class Row>
struct Column {
  std::string_view key;  ///< in CSV and JSON, with the unit
  Figure (*of)(const Row& row);
};

[[nodiscard]] std::span<const Column<BenchRow>> bench_columns();
[[nodiscard]] std::span<const Column<GrowthRow>> growth_columns();

/// Six significant digits; empty for nothing, a NaN or an infinity. Names as they are.
[[nodiscard]] std::string figure_text(const Figure& figure);
/// The number that figure_text() tells, null where that is empty.
[[nodiscard]] nlohmann::ordered_json figure_json(const Figure& figure);

/// A head and a line for each row; the last column is the machine.
[[nodiscard]] std::string bench_csv(std::span<const BenchRow> rows, const std::string& machine);
[[nodiscard]] std::string growth_csv(std::span<const GrowthRow> rows, const std::string& machine);
/// An object for each row.
[[nodiscard]] nlohmann::ordered_json bench_json(std::span<const BenchRow> rows);
[[nodiscard]] nlohmann::ordered_json growth_json(std::span<const GrowthRow> rows);

/// Bytes for people: "35 MB", powers of 1000; "-" for nothing.
[[nodiscard]] std::string bytes_text(std::optional<std::uint64_t> bytes);

}  // namespace sbrdf::internal
