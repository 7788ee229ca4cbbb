#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/tables/dense_table.h"
#include "converters/tables/grid.h"
#include "converters/tables/resampling_error.h"
#include "converters/tables/sampled_table.h"

namespace sbrdf::internal {

// What formats that hold a dense table have in common: options, and what their reports say.

/// --grid: of a table that is written, or that is read and does not tell its own.
[[nodiscard]] Status check_grid_text(std::string_view text);
[[nodiscard]] constexpr OptionSpec grid_option() {
  return {.name = "grid",
          .use = OptionUse::kBoth,
          .unit = "GRID",
          .fallback = "that of an IN that is a table, else 5:5:5:5, isotropic difference/0:2:2:2",
          .check = check_grid_text,
          .meaning =
              "Nodes of a dense table, as steps [degrees] or lists along theta_i:phi_i:theta_v:phi_v, such as "
              "5:10:5:10 or 0,10,30,60:15:0,10,30,60:15; difference/ before it: phi_i:theta_i:theta_v:phi_v-phi_i; "
              "half-difference/: phi_h:theta_h:theta_d:phi_d (0 for phi_i or phi_h: isotropic); or utia, "
              "utia-dense, merl. Of an IN: where its nodes are, if the file does not tell"};
}
/// --type, of numbers that are written.
inline constexpr auto kValueTypeChoices = names_of(kValueTypeNames);
[[nodiscard]] constexpr OptionSpec type_option() {
  return {.name = "type",
          .kind = OptionKind::kChoice,
          .choices = kValueTypeChoices,
          .fallback = "that of an IN with the same grid, else float32",
          .meaning = "Numbers of a dense table that is written; float16 holds at most 65504"};
}

/// The grid that a dense table of a source has: that of --grid, that of the source's own table, or one for a source
/// that is none: every 5 degrees, or every 2 with one phi_i where it is isotropic.
[[nodiscard]] Grid grid_for(const BrdfSource& source, const Options& options);
/// Likewise the numbers.
[[nodiscard]] ValueType type_for(const BrdfSource& source, const Grid& grid, const Options& options);

/// Whether a source consists of a table with just the nodes of `grid`, whatever it says to lie beyond them.
[[nodiscard]] bool has_nodes_of(const BrdfSource& source, const Grid& grid);
/// The source's own grid where it has the nodes of `grid`, so that its numbers are copied; else `grid`. For formats
/// that do not tell what lies beyond the nodes.
[[nodiscard]] Grid own_grid_if_same_nodes(const BrdfSource& source, Grid grid);

/// A source as a table of `grid` can hold it: itself, or made reciprocal where the grid is by construction and it is
/// not, which is said in the report. Lives as long as `source` and this.
class FittingSource {
 public:
  FittingSource(const BrdfSource& source, const Grid& grid, Report& report);
  [[nodiscard]] const BrdfSource& operator*() const { return symmetrised_ ? *symmetrised_ : source_; }

 private:
  const BrdfSource& source_;
  std::unique_ptr<BrdfSource> symmetrised_;
};

/// Everything that there is to say of a table that was made of a source: what TableLosses counts, whether it was
/// copied, an anisotropic source cut at phi_i = 0. `mark` says how the file holds what is unmeasured: "NaN", "-1".
void remark_losses(Report& report, const BrdfSource& source, const TableRequest& request, const TableLosses& losses,
                   std::string_view mark);
/// "differs from the source, at 20,000 of its own nodes: MRE 0.1 %, relative L1 0.2 %, largest ...".
void remark_resampling(Report& report, const BrdfSource& source, const ResamplingError& error);
/// The same for a table whose values at nodes are the source's after `change`: measured before the file is written.
void remark_interpolation(Report& report, const BrdfSource& source, const Grid& grid,
                          const std::function<void(std::span<double>)>& change = {});

}  // namespace sbrdf::internal
