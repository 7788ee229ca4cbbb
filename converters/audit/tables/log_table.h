#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "converters/audit/subject.h"
#include "converters/source/progress.h"
#include "converters/tables/dense_table.h"
#include "converters/tables/grid.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Numbers of a plane for each channel, nodes in C order.
using Planes = std::vector<std::vector<float>>;

/// asinh(f / (2 unit)): the logarithm of f / unit but around 0 and below, where colours beyond a gamut have values,
/// too.
struct LogScale {
  double unit = 1;  ///< [1/sr]

  [[nodiscard]] double log_of(double f) const;
  [[nodiscard]] double value_of(double log) const;
};

/// A dense table prepared for compression: logarithms by a LogScale, of the middle channel as they are and of the
/// others less that one, so that colours which go along with each other take little. Nodes below the horizon go on as
/// the nearest above. Where phi_d mirrors itself, half of it is left out.
struct LogTable {
  Grid grid;
  std::array<std::uint32_t, 4> counts{};  ///< nodes along each axis that are kept
  LogScale scale;
  std::vector<bool> holes;  ///< of each node of the grid: it lies below the horizon
  Planes planes;

  [[nodiscard]] std::size_t node_count() const { return std::size_t{counts[0]} * counts[1] * counts[2] * counts[3]; }
  [[nodiscard]] std::size_t base() const { return planes.size() / 2; }  ///< the channel that stands for itself
};

/// All of it but the numbers: what a decoder knows.
[[nodiscard]] LogTable without_numbers(const LogTable& table);

/// The errors of sample_table.
[[nodiscard]] Result<LogTable> make_log_table(const AuditSubject& subject, const Grid& grid, const Progress& progress);

/// The table that planes of a LogTable stand for, such as those that were compressed: f_r.
[[nodiscard]] DenseTable dense_table_of(const LogTable& like, const Planes& planes);

/// Of such a table [%]: relative L1 on the few directions.
[[nodiscard]] double few_percent_of(const AuditSubject& subject, const DenseTable& table);

}  // namespace sbrdf::internal
