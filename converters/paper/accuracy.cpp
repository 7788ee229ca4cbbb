#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/models/analytic.h"
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

/// What a method makes of a material with so many samples, and in what structure.
struct Reconstruction {
  std::unique_ptr<BrdfSource> source;
  std::string structure;
};

Result<Reconstruction> slices_of(const BrdfSource& source, std::size_t count, const AccuracyOptions& options,
                                 const Progress& progress) {
  SliceOptions slices = options.slices;
  slices.stop = SampleCount{kPaperCounts[count]};
  slices.precision = 0;  // the paper's samples are not rounded
  if (!options.automatic) slices.structure = table_3_placement(kPaperCounts[count]);
  Result<Slicing> slicing = slice_source(source, slices, progress);
  if (!slicing) return slicing.error();
  std::string structure = structure_text(*slicing, slices);
  return Reconstruction{
      std::make_unique<SlicedSource>(DecodedSliced{std::move(slicing->sliced), std::move(slicing->lattice), {}}),
      std::move(structure)};
}

Result<Reconstruction> uniform_samples_of(const BrdfSource& source, PaperMethod method, std::size_t count,
                                          RbfKernel kernel, const Progress& progress) {
  const Result<UniformScheme> scheme = paper_scheme(kPaperSchemes[count]);
  if (!scheme) return scheme.error();
  Result<SchemeSamples> samples = sample_scheme(source, *scheme, progress);
  if (!samples) return samples.error();
  const auto kind = method == PaperMethod::kRbf ? Interpolation::Kind::kRbf : Interpolation::Kind::kBarycentric;
  Result<std::unique_ptr<SchemeSource>> made = SchemeSource::make(*std::move(samples), {kind, kernel});
  if (!made) return made.error();
  return Reconstruction{*std::move(made), "scheme " + scheme->name};
}

Result<AccuracyRow> accuracy_row(const PaperRow& paper, PaperMethod method, std::size_t count,
                                 const AccuracyOptions& options, const Progress& progress) {
  Result<AnalyticModel> model = kurt_material(paper.material);
  if (!model) return model.error();
  const auto source = make_analytic_source(*model);
  StepwiseProgress steps(progress);
  const Progress making = steps.step(kSlicingShare);
  Result<Reconstruction> made = method == PaperMethod::kProposed
                                    ? slices_of(*source, count, options, making)
                                    : uniform_samples_of(*source, method, count, options.kernel, making);
  if (!made) return made.error();
  AccuracyRow row;
  row.material = paper.material;
  row.method = method;
  row.samples = kPaperCounts[count];
  row.structure = made->structure;
  row.paper_mre_percent = paper.mre_percent(method)[count];
  row.exchanged_in_paper = paper.exchanged;
  if (Status status = measure_errors(*source, *made->source, options, row, steps.step(1)); !status) {
    return status.error();
  }
  return row;
}

bool is_asked_for(const AccuracyOptions& options, PaperMethod method) {
  const auto& methods = options.methods;
  return methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end();
}

/// The full names of those asked for; empty: of all ten.
Result<std::set<std::string>> full_names(const std::vector<std::string>& names) {
  std::set<std::string> full;
  for (const std::string& name : names.empty() ? kurt_material_names() : names) {
    Result<AnalyticModel> model = kurt_material(name);
    if (!model) return model.error();
    full.insert(model->name);
  }
  return full;
}

}  // namespace

Result<std::vector<AccuracyRow>> reproduce_accuracy(const AccuracyOptions& options, const Progress& progress) {
  const Result<std::set<std::string>> wanted = full_names(options.materials);
  if (!wanted) return wanted.error();
  std::size_t left = 0;
  for (const auto& [name, method] : kPaperMethodNames) {
    if (is_asked_for(options, method)) left += wanted->size() * kPaperCounts.size();
  }
  StepwiseProgress steps(progress);
  std::vector<AccuracyRow> rows;
  for (const PaperRow& paper : kPaper) {
    if (!wanted->contains(paper.material)) continue;
    for (std::size_t count = 0; count < kPaperCounts.size(); ++count) {
      for (const auto& [name, method] : kPaperMethodNames) {
        if (!is_asked_for(options, method)) continue;
        const Progress step = steps.step(1.0 / static_cast<double>(left--));
        Result<AccuracyRow> row = accuracy_row(paper, method, count, options, step);
        if (!row) return row.error();
        rows.push_back(*std::move(row));
      }
    }
  }
  return rows;
}

double mean_ratio_to_paper(std::span<const AccuracyRow> rows, PaperMethod method, std::uint64_t samples) {
  double sum = 0;
  std::size_t count = 0;
  for (const AccuracyRow& row : rows) {
    if (row.samples != samples || row.method != method) continue;
    sum += std::log(row.mre_percent / row.paper_mre_percent);
    ++count;
  }
  return std::exp(sum / static_cast<double>(count));
}

PaperOrdering ordering_against(std::span<const AccuracyRow> rows, PaperMethod method) {
  PaperOrdering ordering;
  for (const AccuracyRow& ours : rows) {
    if (ours.method != PaperMethod::kProposed) continue;
    const auto theirs = std::find_if(rows.begin(), rows.end(), [&](const AccuracyRow& row) {
      return row.method == method && row.material == ours.material && row.samples == ours.samples;
    });
    if (theirs == rows.end()) continue;
    ++ordering.cells;
    if (ours.mre_percent < theirs->mre_percent) {
      ++ordering.proposed_better;
    } else {
      ordering.otherwise.push_back(fmt::format("{} at {}", ours.material, ours.samples));
    }
  }
  return ordering;
}

}  // namespace sbrdf::internal
