#include "converters/judge/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "converters/tables/dense_source.h"

namespace sbrdf::internal {
namespace {

constexpr std::array kThetasDeg = {0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0};
constexpr std::array kAzimuthsDeg = {0.0, 45.0, 90.0, 135.0};
/// Of the grid that stands for an isotropic source that is no table.
constexpr double kGridStepDeg = 2;

std::vector<Direction> lights(bool isotropic) {
  std::vector<Direction> result;
  for (const double theta : kThetasDeg) {
    for (const double phi : kAzimuthsDeg) {
      if (phi == 0 || (theta > 0 && !isotropic)) result.push_back(direction_from_degrees(theta, phi));
    }
  }
  return result;
}

bool is_up_to(const Direction& direction, double theta_max_deg) {
  return degrees_from_radians(direction.theta) <= theta_max_deg + 1e-9;
}

Status integrate(const BrdfSource& source, const AlbedoOptions& options, const Progress& progress,
                 CheckReport& report) {
  const std::vector<Direction> from = lights(source.traits().isotropic);
  ProgressCounter counter(progress, from.size());
  for (const Direction& light : from) {
    report.albedos.push_back(directional_albedo(source, light, options));
    if (!counter.advance()) return interrupted_error();
  }
  report.highest_albedo = -1;
  for (const Albedo& albedo : report.albedos) {
    if (!is_up_to(albedo.i, source.traits().theta_max_deg)) continue;
    for (std::size_t c = 0; c < albedo.measured.size(); ++c) {
      if (albedo.measured[c] <= report.highest_albedo) continue;
      report.highest_albedo = albedo.measured[c];
      report.highest_at = albedo.i;
      report.highest_channel = c;
    }
  }
  return ok_status();
}

// Every 2 degrees of both theta and of phi_v - phi_i, up to theta_max.
DenseTable table_for(const BrdfSource& source) {
  const double last = source.traits().theta_max_deg;
  const auto thetas = even_nodes(0, kGridStepDeg, static_cast<std::size_t>(last / kGridStepDeg + 1e-9) + 1);
  Grid grid;
  grid.frame = GridFrame::kDifference;
  grid.axes = {GridAxis({0}), GridAxis(thetas), GridAxis(thetas),
               GridAxis(even_nodes(0, kGridStepDeg, static_cast<std::size_t>(360 / kGridStepDeg)), Ends::kFullTurn)};
  std::vector<DirectionPair> pairs(grid.node_count());
  for (std::uint64_t k = 0; k < pairs.size(); ++k) pairs[k] = grid.pair_of(grid.node(k));
  std::vector<float> values(pairs.size() * source.channel_count());
  evaluate_in_parallel(source, pairs, values);
  return table_in_memory(std::move(grid), source.channel_count(), std::move(values));
}

Status look_for_spikes(const BrdfSource& source, const Progress& progress, CheckReport& report) {
  if (const DenseTable* table = source.table()) {
    Result<SpikeSearch> found = find_spikes(*table, progress);
    if (!found) return found.error();
    report.spikes = *std::move(found);
    report.spikes_in = "all nodes of the table";
    return ok_status();
  }
  if (!source.traits().isotropic) {
    report.spikes_in = "not looked for: neither a table nor isotropic";
    return ok_status();
  }
  Result<SpikeSearch> found = find_spikes(table_for(source), progress);
  if (!found) return found.error();
  report.spikes = *std::move(found);
  report.spikes_in = "a 2-degree grid, as this is no table";
  return ok_status();
}

}  // namespace

std::size_t CheckReport::suspicious_count() const {
  return static_cast<std::size_t>(
      std::count_if(remarks.begin(), remarks.end(), [](const CheckRemark& remark) { return remark.suspicious; }));
}

std::string CheckReport::verdict() const {
  const std::size_t count = suspicious_count();
  return count == 0 ? "plausible" : fmt::format("suspicious: {} remark{}", count, count == 1 ? "" : "s");
}

Result<CheckReport> check_source(const BrdfSource& source, const AlbedoOptions& options, const Progress& progress) {
  StepwiseProgress steps(progress);
  CheckReport report;
  if (Status done = integrate(source, options, steps.step(0.6), report); !done) return done.error();
  report.reciprocity = reciprocity_of(source);
  report.pairs = check_pairs(source);
  report.grazing = grazing_growth(source);
  if (const DenseTable* table = source.table()) {
    report.shares = shares_of_nodes(*table);
    report.shares_of_nodes = true;
  } else {
    report.shares = report.pairs.shares;
  }
  if (Status done = look_for_spikes(source, steps.step(1), report); !done) return done.error();
  report.remarks = remarks_on(report, source.traits());
  return report;
}

}  // namespace sbrdf::internal
