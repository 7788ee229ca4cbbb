#include "converters/files/table_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "converters/source/reciprocity.h"

namespace sbrdf::internal {

Status check_grid_text(std::string_view text) {
  const Result<Grid> grid = parse_grid(text);
  return grid ? ok_status() : Status(grid.error());
}

Grid grid_for(const BrdfSource& source, const Options& options) {
  if (const auto text = options.text("grid")) return parse_grid(*text).value();
  if (source.table() != nullptr) return source.table()->grid;
  return parse_grid(source.traits().isotropic ? "difference/0:2:2:2" : "5:5:5:5").value();
}

ValueType type_for(const BrdfSource& source, const Grid& grid, const Options& options) {
  if (const auto text = options.text("type")) return value_of(kValueTypeNames, *text).value_or(ValueType::kFloat32);
  return is_table_of(source, grid) ? source.table()->type : ValueType::kFloat32;
}

bool has_nodes_of(const BrdfSource& source, const Grid& grid) {
  if (source.table() == nullptr || source.table()->grid.frame != grid.frame) return false;
  const auto& own = source.table()->grid.axes;
  return std::equal(own.begin(), own.end(), grid.axes.begin(),
                    [](const GridAxis& a, const GridAxis& b) { return a.nodes_deg() == b.nodes_deg(); });
}

Grid own_grid_if_same_nodes(const BrdfSource& source, Grid grid) {
  return has_nodes_of(source, grid) ? source.table()->grid : std::move(grid);
}

FittingSource::FittingSource(const BrdfSource& source, const Grid& grid, Report& report) : source_(source) {
  if (!grid.is_reciprocal() || source.traits().reciprocal || is_table_of(source, grid)) return;
  symmetrised_ = std::make_unique<SymmetrisedSource>(source);
  remark_reciprocity(report, reciprocity_difference_percent(source));
}

namespace {

void remark_beyond(Report& report, const BrdfSource& source, const TableLosses& losses) {
  if (losses.beyond_theta_max == 0 || losses.copied) return;
  const std::uint64_t above = losses.nodes - losses.below_horizon;
  remark_count(report, "nodes_beyond_theta_max", losses.beyond_theta_max,
               fmt::format("of {} nodes above the horizon ({:.3g} %) have a direction beyond theta_max = {:g} degrees, "
                           "how far the source is measured: {}",
                           above, 100 * static_cast<double>(losses.beyond_theta_max) / static_cast<double>(above),
                           source.traits().theta_max_deg, source.traits().beyond_theta_max));
}

}  // namespace

void remark_losses(Report& report, const BrdfSource& source, const TableRequest& request, const TableLosses& losses,
                   std::string_view mark) {
  report.remarks.push_back({"nodes", static_cast<double>(losses.nodes),
                            fmt::format("{} in {} frame, f_r without cosine", request.grid.size_text(),
                                        name_of(kGridFrameNames, request.grid.frame))});
  if (losses.copied)
    report.remarks.push_back({"same_nodes", 1, "the nodes are those of the source: nothing was interpolated"});
  remark_count(report, "below_horizon_nodes", losses.below_horizon,
               fmt::format("nodes below the horizon, {}", losses.copied ? "copied" : mark));
  remark_count(report, "unmeasured_nodes", losses.unmeasured,
               fmt::format("nodes above the horizon unmeasured by the source, {}", mark));
  remark_count(report, "non_finite_nodes", losses.non_finite,
               fmt::format("nodes with a value that is not finite, {}", mark));
  const Negatives negatives = request.policy.negatives;
  const std::string done = negatives == Negatives::kKeep    ? "kept"
                           : negatives == Negatives::kClamp ? "0 in their place"
                                                            : std::string(mark);
  remark_count(report, "some_negative_nodes", losses.some_negative,
               "nodes with some but not all channels negative, " + done);
  remark_count(report, "all_negative_nodes", losses.all_negative, "nodes negative in every channel, " + done);
  remark_count(report, "clamped_nodes", losses.clamped,
               fmt::format("nodes with a value beyond {:g}, held there", request.largest));
  remark_beyond(report, source, losses);
  if (request.grid.is_isotropic() && !source.traits().isotropic) {
    report.remarks.push_back({"anisotropic_source_cut", 1,
                              fmt::format("the source is anisotropic; the table holds {} = {:g} only",
                                          request.grid.axis_name(0), request.grid.axes[0].node_deg(0))});
  }
}

namespace {

/// Relative L1 above which a table is hardly the same material.
constexpr double kDoubtfulPercent = 20;

}  // namespace

void remark_resampling(Report& report, const BrdfSource& source, const ResamplingError& error) {
  if (error.directions == 0) return;
  const auto& channels = source.traits().channels;
  const std::string where = error.at_nodes ? "of its own nodes" : "random directions, most of them in the highlight";
  report.remarks.push_back({"resampling_mre_percent", error.mre_percent,
                            fmt::format("differs from the source by an MRE of {} at {} {}",
                                        percent_text(error.mre_percent), error.directions, where)});
  report.remarks.push_back({"resampling_rel_l1_percent", error.rel_l1_percent,
                            fmt::format("and a relative L1 of {}", percent_text(error.rel_l1_percent))});
  report.remarks.push_back(
      {"resampling_max_abs", error.max_abs,
       fmt::format("largest difference {:.4g} 1/sr, {}", error.max_abs, place_text(error.max_abs_at, channels))});
  if (error.rel_l1_percent > kDoubtfulPercent) {
    report.remarks.push_back(
        {"resampling_warning", error.rel_l1_percent,
         "warning: this is far from the source; other nodes may hold it better, or it has values at "
         "the horizon that no table holds"});
  }
}

void remark_interpolation(Report& report, const BrdfSource& source, const Grid& grid,
                          const std::function<void(std::span<double>)>& change) {
  if (is_table_of(source, grid) && !change) return;
  const DenseTable table = table_of_source(source, grid, change);
  remark_resampling(report, source, resampling_error(source, [&](auto pairs, auto values) {
                      interpolate_table(table, pairs, values);
                    }));
}

}  // namespace sbrdf::internal
