#include "converters/slicing/slicer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/coding/value_scaling.h"
#include "codec/fit/value_fit.h"
#include "codec/material/slice_samples.h"
#include "converters/slicing/metadata.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBlock = 256;  // held-back directions that one task looks at

double theta_max_of(const BrdfSource& source, const SliceOptions& options) {
  const bool placed = std::holds_alternative<Placement>(options.structure);
  return options.theta_max_deg.value_or(placed ? kPaperThetaMaxDeg : source.traits().slice_theta_max_deg);
}

SymmetryUse symmetries_of(const SliceOptions& options) {
  const auto* search = std::get_if<SearchedStructure>(&options.structure);
  if (search == nullptr) return SymmetryUse::kStated;
  return search->use_mirrors ? SymmetryUse::kAll : SymmetryUse::kIsotropy;
}

// Refinement by the source looks at four places for each new sample, one of which is the sample.
std::uint64_t measurements_for(const SamplingOptions& sampling) {
  return sampling.sample_count * (sampling.refinement == Refinement::kBySource ? 4 : 1);
}

HeldBackError error_of(const SlicedBrdf& sliced, const Lattice& lattice, const HeldBack& held_back) {
  return judge(Evaluator(sliced, lattice), held_back);
}

// Of what a file of that precision gives back.
HeldBackError rounded_error(const Slicing& slicing, double precision, const HeldBack& held_back) {
  if (precision == 0) return error_of(slicing.sliced, slicing.lattice, held_back);
  SlicedBrdf coded = slicing.sliced;
  round_to_precision(coded, precision);
  return error_of(coded, slicing.lattice, held_back);
}

}  // namespace

const std::vector<double>& tried_precisions() {
  static const std::vector<double> kTried = [] {
    std::vector<double> tried;
    for (double tenfold = 0.1; tenfold > 0.9e-6; tenfold /= 10) {
      for (const double part : {4.7, 3.3, 2.2, 1.5, 1.0, 0.68}) {
        const std::uint32_t millionths = millionths_of(tenfold * part);
        if (millionths > 0 && (tried.empty() || bound_of(millionths) < tried.back()))
          tried.push_back(bound_of(millionths));
      }
    }
    return tried;
  }();
  return kTried;
}

Slicer::Slicer(const BrdfSource& source, const SliceOptions& options)
    : source_(source), options_(options), sampled_(source, theta_max_of(source, options), symmetries_of(options)) {}

Result<Slicer> Slicer::make(const BrdfSource& source, const SliceOptions& options) {
  if (Status status = check_options(options); !status) return status.error();
  Slicer slicer(source, options);
  const bool chooses = std::holds_alternative<SearchedStructure>(options.structure) || target_percent(options.stop) ||
                       !options.precision || fits_values(options);
  if (chooses) {
    Result<HeldBack> choice = slicer.sampled_.draw(kChoiceSeed);
    if (!choice) return choice.error();
    slicer.choice_ = *std::move(choice);
  }
  if (fits_values(options) && options.domain != DomainKind::kLinear) {
    slicer.grey_shares_ = choose_grey_shares(slicer.choice_.values, source.channel_count());
  }
  Result<HeldBack> report = slicer.sampled_.draw(kReportSeed);
  if (!report) return report.error();
  slicer.report_ = *std::move(report);
  return slicer;
}

Result<SlicePlan> Slicer::plan(std::uint64_t sample_count, Effort effort, Objective objective,
                               const Progress& progress) const {
  if (const auto* rule = std::get_if<SearchedStructure>(&options_.structure)) {
    return search(*rule, sample_count, effort, objective, progress);
  }
  const auto& placement = std::get<Placement>(options_.structure);
  Result<FrameSpec> spec =
      elevation_frame(placement.elevation_step_deg, placement.azimuth_step_deg, sampled_.symmetries(), theta_max_deg());
  if (!spec) return spec.error();
  SamplingOptions sampling = sampling_of(options_);
  sampling.grey_shares = grey_shares_;
  return SlicePlan{*std::move(spec), std::move(sampling), {}, effort == Effort::kFull && fits_values(options_)};
}

Result<SlicePlan> Slicer::search(const SearchedStructure& rule, std::uint64_t sample_count, Effort effort,
                                 Objective objective, const Progress& progress) const {
  SearchOptions search;
  search.frame = rule.frame;
  search.domain = options_.domain;
  search.symmetries = sampled_.symmetries();
  search.theta_max_deg = theta_max_deg();
  search.objective = objective;
  search.sampling = sampling_of(options_);
  search.sampling.sample_count = sample_count;
  search.sampling.grey_shares = grey_shares_;
  search.evaluations = rule.evaluations;
  search.starts_only = effort == Effort::kStarts;
  search.progress = progress.report;
  // Not in parallel: the search tries many structures at once.
  const auto measure = [&](auto pairs, auto values) { return evaluate_checked(sampled_.sampled(), pairs, values); };
  const Result<SearchResult> found = search_structure(source_.traits().channels, measure, choice_, search);
  if (!found) return found.error();
  return SlicePlan{expand_outline(found->structure.outline), sampling_for(found->structure, search.sampling),
                   found->reasons, effort == Effort::kFull && fits_values(options_)};
}

Result<Slicing> Slicer::sample(const SlicePlan& plan, std::uint64_t sample_count, const Progress& progress) const {
  Result<Lattice> lattice = build_lattice(plan.frame);
  if (!lattice) return lattice.error();
  SamplingOptions sampling = plan.sampling;
  sampling.sample_count = sample_count;
  ProgressCounter counter(progress, measurements_for(sampling));
  const auto measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) -> Status {
    if (!counter.advance(pairs.size())) return interrupted_error();
    return evaluate_checked_in_parallel(sampled_.sampled(), pairs, values);
  };
  Result<SlicedBrdf> sliced = sample_slices(*lattice, source_.traits().channels, measure, sampling);
  if (!sliced) return sliced.error();
  Slicing slicing{*std::move(sliced), *std::move(lattice), {}};
  if (sampled_.filled() != nullptr) slicing.sliced.mask = sampled_.filled()->mask();
  slicing.report.wanted_samples = sample_count;
  slicing.report.reasons = plan.reasons;
  if (plan.fits && sample_count <= kMostFittedSamples) {
    if (Status status = fit(slicing); !status) return status.error();
  }
  return slicing;
}

Status Slicer::fit(Slicing& slicing) const {
  const Result<HeldBack> directions = sampled_.draw(kFitSeed, fit_directions(slicing.sliced.sample_count()));
  if (!directions) return directions.error();
  SlicedBrdf fitted = fit_values(slicing.sliced, slicing.lattice, *directions, objective());
  const Standard standard = {objective(), error_of(slicing.sliced, slicing.lattice, choice_)};
  const double before = standard.value_of(standard.ceiling);
  if (standard.value_of(error_of(fitted, slicing.lattice, choice_)) >= before) return ok_status();
  slicing.sliced = std::move(fitted);
  slicing.report.fitted = true;
  return ok_status();
}

Result<Slicing> Slicer::slice(std::uint64_t sample_count, Effort effort, const Progress& progress) const {
  constexpr double kSearchShare = 0.9;
  const bool searches = std::holds_alternative<SearchedStructure>(options_.structure);
  StepwiseProgress steps(progress);
  const Result<SlicePlan> found = plan(sample_count, effort, objective(), steps.step(searches ? kSearchShare : 0));
  if (!found) return found.error();
  return sample(*found, sample_count, steps.step(1));
}

std::uint64_t Slicer::count_filled(const Slicing& slicing) const {
  if (sampled_.filled() == nullptr) return 0;
  std::vector<DirectionPair> pairs;
  for (const Coordinates& x : slicing.lattice.crossings) pairs.push_back(directions_at(slicing.lattice.spec, x));
  const std::vector<SliceSamples> all = gather_slices(slicing.sliced, slicing.lattice);
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (std::size_t s = 0; s < all[k].size(); ++s) {
      if (all[k].places[s].fraction == 0) continue;  // a crossing
      const Coordinates x = coordinates_on(slicing.lattice.slices[k], all[k].positions_deg[s]);
      pairs.push_back(directions_at(slicing.lattice.spec, x));
    }
  }
  std::vector<std::uint8_t> flags(pairs.size());
  sampled_.filled()->measured(pairs, flags);
  return static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), std::uint8_t{0}));
}

double Slicer::error_on_choice(const Slicing& slicing, double precision) const {
  return objective_value(rounded_error(slicing, precision, choice_), objective());
}

double Slicer::error_on_report(const Slicing& slicing, double precision) const {
  return objective_value(rounded_error(slicing, precision, report_), objective());
}

double Slicer::precision_for(const Slicing& slicing) const {
  if (options_.precision) return *options_.precision;
  constexpr double kShare = 0.1;
  constexpr double kAlways = 0.0015;  // [percentage points]
  const HeldBackError exact = rounded_error(slicing, 0, choice_);
  // Of what has no error that could be compared, a thousandth is fine enough.
  if (!std::isfinite(exact.mre_percent) || !std::isfinite(exact.rel_l1_percent)) return 0.001;
  const auto little_more = [&](double error, double than) { return error <= than + std::max(kShare * than, kAlways); };
  const auto found = coarsest_precision([&](double precision) {
    const HeldBackError error = rounded_error(slicing, precision, choice_);
    return little_more(error.mre_percent, exact.mre_percent) && little_more(error.rel_l1_percent, exact.rel_l1_percent);
  });
  return found.value_or(0);
}

std::vector<float> Slicer::finish(Slicing& slicing) const {
  if (!slicing.precision) slicing.precision = precision_for(slicing);
  SliceReport& report = slicing.report;
  round_to_precision(slicing.sliced, *slicing.precision);
  for (std::vector<float> values : {slicing.sliced.crossing_values, slicing.sliced.sample_values}) {
    const std::size_t channels = slicing.sliced.channel_count();
    for (std::size_t k = 0; k < values.size(); k += channels) {
      slicing.sliced.grey_shares.take_off(std::span(values).subspan(k, channels));
    }
    report.values += values.size();
    report.zero_values += static_cast<std::uint64_t>(std::count(values.begin(), values.end(), 0.0F));
    report.negative_values +=
        static_cast<std::uint64_t>(std::count_if(values.begin(), values.end(), [](float v) { return v < 0; }));
  }
  report.reciprocity_difference_percent = sampled_.reciprocity_difference_percent();
  const std::vector<float> values = evaluate(Evaluator(slicing.sliced, slicing.lattice), report_.pairs);
  report.error = judge(values, report_);
  report.error_directions = report_.pairs.size();
  report.error_values_all_zero = all_zero(report_);
  report.theta_max_deg = theta_max_deg();
  report.filled_samples = count_filled(slicing);
  slicing.sliced.metadata = metadata_of_slicing(source_.reported_traits(), options_, report);
  return values;
}

void Slicer::look_closer(std::span<const float> values, Slicing& slicing) const {
  const std::size_t channels = source_.channel_count();
  const std::size_t count = report_.pairs.size();
  const auto of_pair = [&](std::span<const float> all, std::size_t k) { return all.subspan(k * channels, channels); };
  slicing.report.figures = figures_of(report_, values);
  // Blocks are added in their order, so that the worst is the first of equals for any number of threads.
  std::vector<FalseValues> blocks((count + kBlock - 1) / kBlock);
  parallel_for(blocks.size(), [&](std::uint64_t block) {
    const std::size_t first = static_cast<std::size_t>(block) * kBlock;
    for (std::size_t k = first; k < std::min(count, first + kBlock); ++k) {
      find_false_values(sampled_.sampled(), report_.pairs[k], of_pair(report_.values, k), of_pair(values, k),
                        FalseValueSearch::kFar, blocks[block]);
    }
  });
  for (const FalseValues& block : blocks) slicing.report.false_values.add(block);
}

std::size_t Slicer::file_size(Slicing slicing) const {
  static_cast<void>(finish(slicing));
  return encode_sliced(slicing.sliced, slicing.lattice, encoding_of(slicing, options_)).size();
}

}  // namespace sbrdf::internal
