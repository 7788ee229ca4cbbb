#pragma once

#include <span>
#include <string_view>

#include "converters/audit/workbench.h"

namespace sbrdf::internal {

struct TableCoder;

/// A way to keep materials. A row of the registry: whoever adds one there finds it in every table and chart.
struct AuditMethod {
  std::string_view name;  ///< for people; never changes its meaning
  bool in_place = false;  ///< evaluated from what is stored, without expanding it first
  bool in_part = false;   ///< a part of it can be read, and evaluated, without the rest
  /// What is known of errors from the bytes alone: "value" (a bound on each number that is stored), "measured" (errors
  /// that were measured stand in the file), "both", or "none".
  std::string_view bound;
  /// Why a material cannot be kept this way; empty where it can.
  std::string_view (*left_out)(const AuditSubject& subject);
  /// The smallest whose relative L1 off the grid is at most `percent`. interrupted_error(); any other error
  /// is of this way alone.
  Result<Found> (*find)(Workbench& bench, double percent, const Progress& progress);
};

[[nodiscard]] std::span<const AuditMethod> audit_methods();

// The searches, by what they are made of: files of this library, of other formats, tables of logarithms.

[[nodiscard]] Result<Found> find_sliced(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_sliced_tenth(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_dense(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_engine_atlas(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_paper_atlas(Workbench& bench, double percent, const Progress& progress);

[[nodiscard]] Result<Found> find_float(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_half(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_hdf5(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_exr(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_merl(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_utia(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_rgl(Workbench& bench, double percent, const Progress& progress);
[[nodiscard]] Result<Found> find_barycentric(Workbench& bench, double percent, const Progress& progress);

[[nodiscard]] Result<Found> find_tucker(Workbench& bench, double percent, const Progress& progress);
/// The coarsest setting of a coder, on several grids.
[[nodiscard]] Result<Found> find_coded(Workbench& bench, const TableCoder& coder, double percent,
                                       const Progress& progress);

}  // namespace sbrdf::internal
