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

constexpr double kSlicingShare = 0.3;  // of the time of a row; the rest goes into comparing

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
  slices.stop = SampleCount{kPaperCounts[count]};
  slices.encoding.precision = 0;  // the paper's samples are not rounded
  if (!options.automatic) slices.structure = table_3_placement(kPaperCounts[count]);
  StepwiseProgress steps(progress);
  Result<Slicing> slicing = slice_source(*source, slices, steps.step(kSlicingShare));
  if (!slicing) return slicing.error();
  AccuracyRow row = {paper.material,           kPaperCounts[count], structure_text(*slicing, slices), 0,
                     paper.mre_percent[count], paper.exchanged};
  const SlicedSource sliced(DecodedSliced{std::move(slicing->sliced), std::move(slicing->lattice), {}});
  CompareOptions directions;
  directions.random_count = options.random_count;
  directions.seed = options.seed;
  const Result<Comparison> comparison = compare_sources(*source, sliced, directions, steps.step(1));
  if (!comparison) return comparison.error();
  row.mre_percent = comparison->mre_percent;
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
