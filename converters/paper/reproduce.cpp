#include "converters/paper/reproduce.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <set>

#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/models/kurt.h"
#include "formats/core/parallel.h"

namespace sbrdf {
namespace {

constexpr std::array<std::uint64_t, 2> kCounts = {8'911, 18'721};

struct PaperRow {
  const char* material;
  std::array<double, 2> mre_percent;  // "proposed" at kCounts
  bool exchanged;
  double increase;  // Table 4
};
constexpr std::array<PaperRow, 10> kPaper = {{{"Brushed alum", {24.5, 18.9}, false, 1.31},
                                              {"Purple satin", {0.8, 0.5}, false, 1.19},
                                              {"Red velvet", {0.1, 0.1}, true, 1.49},
                                              {"Yellow satin", {10.4, 5.7}, true, 1.32},
                                              {"fabric002", {0.5, 0.3}, false, 1.02},
                                              {"fabric041", {0.2, 0.1}, false, 1.03},
                                              {"fabric112", {1.3, 0.9}, false, 1.05},
                                              {"fabric135", {3.9, 2.5}, false, 1.27},
                                              {"fabric139", {0.5, 0.3}, false, 1.11},
                                              {"wood01", {0.2, 0.1}, false, 1.17}}};

/// Part of a longer piece of work, reported as if it were the whole. The parts run one after the other.
Progress part_of(const Progress& progress, double begin, double end) {
  if (!progress.report) return {};
  return {[&progress, begin, end](double fraction) { return progress.report(begin + (end - begin) * fraction); }};
}

std::string structure_text(const Slicing& slicing, const SliceOptions& options) {
  if (const auto* placement = std::get_if<Placement>(&options.structure)) return placement_text(*placement);
  std::string text(geometry(slicing.sliced.frame.id).name());
  text += slicing.sliced.domain.kind == DomainKind::kLog ? ", log" : ", linear";
  return slicing.sliced.guide ? text + ", guide" : text;
}

Result<AccuracyRow> accuracy_row(const PaperRow& paper, std::size_t count, const AccuracyOptions& options,
                                 const Progress& progress) {
  Result<KurtModel> model = kurt_material(paper.material);
  if (!model) return model.error();
  const auto source = make_kurt_source(*model);
  SliceOptions slices = options.slices;
  slices.stop = SampleCount{kCounts[count]};
  slices.encoding.precision = 0;  // the paper's samples are not rounded
  if (!options.automatic) slices.structure = table_3_placement(kCounts[count]);
  Result<Slicing> slicing = slice_source(*source, slices, part_of(progress, 0, 0.3));
  if (!slicing) return slicing.error();
  AccuracyRow row = {paper.material,           kCounts[count], structure_text(*slicing, slices), 0,
                     paper.mre_percent[count], paper.exchanged};
  const SlicedSource sliced(DecodedSliced{std::move(slicing->sliced), std::move(slicing->lattice), {}});
  CompareOptions directions;
  directions.random_count = options.random_count;
  directions.seed = options.seed;
  const Result<Comparison> comparison = compare_sources(*source, sliced, directions, part_of(progress, 0.3, 1));
  if (!comparison) return comparison.error();
  row.mre_percent = comparison->mre_percent;
  return row;
}

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
      for (std::size_t c = 0; c < values.size(); ++c) sums.add(grid.values[k * values.size() + c], values[c], 0);
    }
    return sums.summary().mre_percent;
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

}  // namespace

std::string placement_text(const Placement& placement) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%g/%g", placement.elevation_step_deg, placement.azimuth_step_deg);
  return text.data();
}

Result<std::vector<AccuracyRow>> reproduce_accuracy(const AccuracyOptions& options, const Progress& progress) {
  std::set<std::string> wanted;
  for (const std::string& name : options.materials.empty() ? kurt_material_names() : options.materials) {
    Result<KurtModel> model = kurt_material(name);
    if (!model) return model.error();
    wanted.insert(model->name);
  }
  std::vector<AccuracyRow> rows;
  const double total = static_cast<double>(wanted.size() * kCounts.size());
  for (const PaperRow& paper : kPaper) {
    if (wanted.count(paper.material) == 0) continue;
    for (std::size_t count = 0; count < kCounts.size(); ++count) {
      const auto done = static_cast<double>(rows.size());
      Result<AccuracyRow> row =
          accuracy_row(paper, count, options, part_of(progress, done / total, (done + 1) / total));
      if (!row) return row.error();
      rows.push_back(*std::move(row));
    }
  }
  return rows;
}

double mean_ratio_to_paper(std::span<const AccuracyRow> rows, std::uint64_t samples) {
  double sum = 0;
  std::size_t count = 0;
  for (const AccuracyRow& row : rows) {
    if (row.samples != samples) continue;
    sum += std::log(row.mre_percent / row.paper_mre_percent);
    ++count;
  }
  return std::exp(sum / static_cast<double>(count));
}

Result<PlacementStudy> reproduce_placement(const PlacementOptions& options, const Progress& progress) {
  PlacementStudy study;
  std::vector<std::unique_ptr<BrdfSource>> sources;
  std::vector<GridSample> grids;
  for (const PaperRow& paper : kPaper) {
    Result<KurtModel> model = kurt_material(paper.material);
    if (!model) return model.error();
    study.materials.emplace_back(paper.material);
    study.paper_increase.push_back(paper.increase);
    sources.push_back(make_kurt_source(*model));
    grids.push_back(draw_grid(*sources.back(), options));
  }
  std::vector<Lattice> lattices;
  for (const Placement& placement : table_3_placements()) {
    Result<FrameSpec> spec = elevation_frame(placement.elevation_step_deg, placement.azimuth_step_deg, {});
    if (!spec) return spec.error();
    Result<Lattice> lattice = build_lattice(*spec);
    if (!lattice) return lattice.error();
    lattices.push_back(*std::move(lattice));
  }
  const PlacementGrid errors(options, sources, grids, lattices);
  const auto total =
      static_cast<double>(std::accumulate(options.counts.begin(), options.counts.end(), std::uint64_t{0}));
  double done = 0;
  for (const std::uint64_t samples : options.counts) {
    Result<PlacementRow> row = errors.at(samples);
    if (!row) return row.error();
    study.rows.push_back(*std::move(row));
    done += static_cast<double>(samples);
    if (progress.report && !progress.report(done / total)) return interrupted_error();
  }
  for (std::size_t material = 0; material < sources.size(); ++material) {
    study.increase.push_back(mean_increase(study.rows, material, &PlacementRow::best));
    study.increase_table_3.push_back(mean_increase(study.rows, material, &PlacementRow::table_3));
  }
  return study;
}

}  // namespace sbrdf
