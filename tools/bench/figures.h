#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "converters/bench/bench.h"
#include "tools/io/columns.h"

namespace sbrdf::internal {

[[nodiscard]] std::span<const Column<BenchRow>> bench_columns();
[[nodiscard]] std::span<const Column<GrowthRow>> growth_columns();

/// A head and a line for each row; the last column is the machine.
[[nodiscard]] std::string bench_csv(std::span<const BenchRow> rows, const std::string& machine);
[[nodiscard]] std::string growth_csv(std::span<const GrowthRow> rows, const std::string& machine);
/// An object for each row.
[[nodiscard]] nlohmann::ordered_json bench_json(std::span<const BenchRow> rows);
[[nodiscard]] nlohmann::ordered_json growth_json(std::span<const GrowthRow> rows);

/// Bytes for people: "35 MB", powers of 1000; "-" for nothing.
[[nodiscard]] std::string bytes_text(std::optional<std::uint64_t> bytes);

}  // namespace sbrdf::internal
