#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "codec/evaluation/evaluator.h"
#include "converters/judge/compare.h"
#include "converters/models/analytic.h"
#include "converters/paper/published.h"
#include "converters/paper/reproduce.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

// Placements that do not fit have a NaN, which no comparison takes.
double least_error(const std::vector<double>& errors) {
  double least = std::numeric_limits<double>::infinity();
  for (const double error : errors) least = error < least ? error : least;
  return least;
}

/// Random pairs of the 2-degree grid, with the values of a source.
struct GridSample {
  std::vector<DirectionPair> pairs;
  std::vector<float> values;  ///< f_r, channel fastest
};

/// The error of every material and placement at one sample count.
class PlacementGrid {
 public:
  PlacementGrid(const PlacementOptions& options, const std::vector<std::unique_ptr<BrdfSource>>& sources,
                const std::vector<GridSample>& grids, const std::vector<Lattice>& lattices)
      : options_(options), sources_(sources), grids_(grids), lattices_(lattices) {}

  [[nodiscard]] Result<PlacementRow> at(std::uint64_t samples) const {
    const std::size_t placements = lattices_.size();
    PlacementRow row;
    row.samples = samples;
    row.mre_percent.assign(sources_.size(), std::vector<double>(placements, std::numeric_limits<double>::quiet_NaN()));
    parallel_for(sources_.size() * placements, [&](std::size_t k) {
      const std::size_t placement = k % placements;
      if (lattices_[placement].crossings.size() > samples) return;
      row.mre_percent[k / placements][placement] = error_of(k / placements, lattices_[placement], samples);
    });
    row.best = best_placement(row, sources_.size());
    const auto table_3 = table_3_placement(samples);
    const auto all = table_3_placements();
    row.table_3 = static_cast<std::size_t>(std::find(all.begin(), all.end(), table_3) - all.begin());
    for (std::size_t left_out = 0; left_out < sources_.size(); ++left_out) {
      row.best_without.push_back(best_placement(row, left_out));
    }
    return row;
  }

 private:
  [[nodiscard]] double error_of(std::size_t material, const Lattice& lattice, std::uint64_t samples) const {
    SamplingOptions sampling;
    sampling.sample_count = samples;
    sampling.refinement = options_.slices.refinement;
    sampling.domain = options_.slices.domain.value_or(DomainKind::kLinear);
    sampling.minimum_gap_deg = options_.slices.minimum_gap_deg.value_or(1);
    const Result<SlicedBrdf> sliced = sample_slices(
        lattice, sources_[material]->traits().channels,
        [&](std::span<const DirectionPair> pairs, std::span<float> values) {
          sources_[material]->evaluate(pairs, values);
          return ok_status();
        },
        sampling);
    return sliced ? mean_relative_error(Evaluator(*sliced, lattice), grids_[material])
                  : std::numeric_limits<double>::quiet_NaN();
  }

  [[nodiscard]] static double mean_relative_error(const Evaluator& evaluator, const GridSample& grid) {
    std::vector<float> values(evaluator.channel_count());
    ErrorSums sums;
    for (std::size_t k = 0; k < grid.pairs.size(); ++k) {
      evaluator.evaluate(grid.pairs[k], values);
      for (std::size_t c = 0; c < values.size(); ++c) {
        sums.add({grid.pairs[k], c, grid.values[k * values.size() + c], values[c]});
      }
    }
    return sums.figures().mre_percent;
  }

  // Equation 1: the least sum over the materials of the error against each material's own best.
  [[nodiscard]] static std::size_t best_placement(const PlacementRow& row, std::size_t left_out) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t placement = 0; placement < row.mre_percent.front().size(); ++placement) {
      double sum = 0;
      for (std::size_t m = 0; m < row.mre_percent.size(); ++m) {
        if (m != left_out) sum += row.mre_percent[m][placement] / least_error(row.mre_percent[m]);
      }
      if (sum < least) {  // false for placements that do not fit
        least = sum;
        best = placement;
      }
    }
    return best;
  }

  const PlacementOptions& options_;
  const std::vector<std::unique_ptr<BrdfSource>>& sources_;
  const std::vector<GridSample>& grids_;
  const std::vector<Lattice>& lattices_;
};

GridSample draw_grid(const BrdfSource& source, const PlacementOptions& options) {
  const CompareOptions paper;
  const DirectionGrid all(paper.step_deg, paper.theta_max_deg, false);
  GridSample grid;
  std::uint64_t state = options.seed;
  const auto draw = [&](std::uint64_t count) {  // splitmix64
    std::uint64_t z = (state += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return (z ^ (z >> 31U)) % count;
  };
  for (std::uint64_t k = 0; k < options.random_count; ++k) {
    const std::uint64_t theta_i = draw(all.theta_count());
    const std::uint64_t phi_i = draw(all.phi_count());
    const std::uint64_t theta_v = draw(all.theta_count());
    grid.pairs.push_back(all.at(theta_i, phi_i, theta_v, draw(all.phi_count())));
  }
  grid.values.resize(grid.pairs.size() * source.channel_count());
  source.evaluate(grid.pairs, grid.values);
  return grid;
}

double mean_increase(const std::vector<PlacementRow>& rows, std::size_t material, std::size_t PlacementRow::*chosen) {
  double sum = 0;
  std::size_t count = 0;
  for (const PlacementRow& row : rows) {
    const double ratio = row.mre_percent[material][row.*chosen] / least_error(row.mre_percent[material]);
    if (!std::isfinite(ratio)) continue;
    sum += ratio;
    ++count;
  }
  return sum / static_cast<double>(count);
}

Result<std::vector<Lattice>> lattices_of_table_3() {
  std::vector<Lattice> lattices;
  for (const Placement& placement : table_3_placements()) {
    Result<FrameSpec> spec = elevation_frame(placement.elevation_step_deg, placement.azimuth_step_deg, {});
    if (!spec) return spec.error();
    Result<Lattice> lattice = build_lattice(*spec);
    if (!lattice) return lattice.error();
    lattices.push_back(*std::move(lattice));
  }
  return lattices;
}

/// The ten materials, and where on the grid they are judged.
struct Materials {
  std::vector<std::unique_ptr<BrdfSource>> sources;
  std::vector<GridSample> grids;
};

Result<Materials> materials_of_paper(const PlacementOptions& options) {
  Materials materials;
  for (const PaperRow& paper : kPaper) {
    Result<AnalyticModel> model = kurt_material(paper.material);
    if (!model) return model.error();
    materials.sources.push_back(make_analytic_source(*model));
    materials.grids.push_back(draw_grid(*materials.sources.back(), options));
  }
  return materials;
}

// How much the chosen placements cost, in the order of kPaper.
void add_increases(PlacementStudy& study) {
  for (std::size_t material = 0; material < kPaper.size(); ++material) {
    study.materials.emplace_back(kPaper[material].material);
    study.paper_increase.push_back(kPaper[material].increase);
    study.increase.push_back(mean_increase(study.rows, material, &PlacementRow::best));
    study.increase_table_3.push_back(mean_increase(study.rows, material, &PlacementRow::table_3));
  }
}

}  // namespace

std::string placement_text(const Placement& placement) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%g/%g", placement.elevation_step_deg, placement.azimuth_step_deg);
  return text.data();
}

Result<PlacementStudy> reproduce_placement(const PlacementOptions& options, const Progress& progress) {
  const Result<Materials> materials = materials_of_paper(options);
  if (!materials) return materials.error();
  const Result<std::vector<Lattice>> lattices = lattices_of_table_3();
  if (!lattices) return lattices.error();
  const PlacementGrid errors(options, materials->sources, materials->grids, *lattices);
  const auto total =
      static_cast<double>(std::accumulate(options.counts.begin(), options.counts.end(), std::uint64_t{0}));
  PlacementStudy study;
  double done = 0;
  for (const std::uint64_t samples : options.counts) {
    Result<PlacementRow> row = errors.at(samples);
    if (!row) return row.error();
    study.rows.push_back(*std::move(row));
    done += static_cast<double>(samples);
    if (progress.report && !progress.report(done / total)) return interrupted_error();
  }
  add_increases(study);
  return study;
}

}  // namespace sbrdf::internal
