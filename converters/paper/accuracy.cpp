#include <cmath>
#include <set>
#include <utility>

#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/models/kurt.h"
#include "converters/paper/published.h"
#include "converters/paper/reproduce.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kOffGridPairs = 1'000'000;  // beside the whole grid
constexpr double kOffGridShare = 0.03;              // of the time of both
constexpr double kSlicingShare = 0.3;               // of the time of a row; the rest goes into comparing

std::string structure_text(const Slicing& slicing, const SliceOptions& options) {
  if (const auto* placement = std::get_if<Placement>(&options.structure)) return placement_text(*placement);
  std::string text(geometry(slicing.sliced.frame.id).name());
  text += slicing.sliced.domain.kind == DomainKind::kLog ? ", log" : ", linear";
  return slicing.sliced.guide ? text + ", guide" : text;
}

/// On the grid and off it.
Status measure_errors(const BrdfSource& source, const BrdfSource& sliced, const AccuracyOptions& options,
                      AccuracyRow& row, const Progress& progress) {
  StepwiseProgress steps(progress);
  CompareOptions directions;
  directions.random_count = options.random_count;
  directions.seed = options.seed;
  directions.floor = 0;
  directions.false_values = FalseValueSearch::kNone;
  const double share = options.random_count > 0 ? 0.5 : 1 - kOffGridShare;
  const Result<Comparison> on_grid = compare_sources(source, sliced, directions, steps.step(share));
  if (!on_grid) return on_grid.error();
  directions.directions = CompareDirections::kRandom;
  directions.false_values = FalseValueSearch::kFar;
  if (directions.random_count == 0) directions.random_count = kOffGridPairs;
  const Result<Comparison> off_grid = compare_sources(source, sliced, directions, steps.step(1));
  if (!off_grid) return off_grid.error();
  row.mre_percent = on_grid->mre_percent;
  row.off_grid_mre_percent = off_grid->mre_percent;
  row.off_grid_rel_l1_percent = off_grid->rel_l1_percent;
  row.false_values = off_grid->false_values.count;
  return ok_status();
}

Result<AccuracyRow> accuracy_row(const PaperRow& paper, std::size_t count, const AccuracyOptions& options,
                                 const Progress& progress) {
  Result<KurtModel> model = kurt_material(paper.material);
  if (!model) return model.error();
  const auto source = make_kurt_source(*model);
  SliceOptions slices = options.slices;
  slices.stop = SampleCount{kPaperCounts[count]};
  slices.precision = 0;  // the paper's samples are not rounded
  if (!options.automatic) slices.structure = table_3_placement(kPaperCounts[count]);
  StepwiseProgress steps(progress);
  Result<Slicing> slicing = slice_source(*source, slices, steps.step(kSlicingShare));
  if (!slicing) return slicing.error();
  AccuracyRow row;
  row.material = paper.material;
  row.samples = kPaperCounts[count];
  row.structure = structure_text(*slicing, slices);
  row.paper_mre_percent = paper.mre_percent[count];
  row.exchanged_in_paper = paper.exchanged;
  const SlicedSource sliced(DecodedSliced{std::move(slicing->sliced), std::move(slicing->lattice), {}});
  if (Status status = measure_errors(*source, sliced, options, row, steps.step(1)); !status) return status.error();
  return row;
}

/// The full names of those asked for; empty: of all ten.
Result<std::set<std::string>> full_names(const std::vector<std::string>& names) {
  std::set<std::string> full;
  for (const std::string& name : names.empty() ? kurt_material_names() : names) {
    Result<KurtModel> model = kurt_material(name);
    if (!model) return model.error();
    full.insert(model->name);
  }
  return full;
}

}  // namespace

Result<std::vector<AccuracyRow>> reproduce_accuracy(const AccuracyOptions& options, const Progress& progress) {
  const Result<std::set<std::string>> wanted = full_names(options.materials);
  if (!wanted) return wanted.error();
  StepwiseProgress steps(progress);
  std::size_t left = wanted->size() * kPaperCounts.size();
  std::vector<AccuracyRow> rows;
  for (const PaperRow& paper : kPaper) {
    if (!wanted->contains(paper.material)) continue;
    for (std::size_t count = 0; count < kPaperCounts.size(); ++count, --left) {
      Result<AccuracyRow> row = accuracy_row(paper, count, options, steps.step(1.0 / static_cast<double>(left)));
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

}  // namespace sbrdf::internal
