#include "converters/slicing/slicing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "codec/file/value_scaling.h"
#include "codec/material/evaluator.h"
#include "converters/slicing/names.h"
#include "converters/source/reciprocity.h"
#include "converters/source/symmetry_detection.h"

namespace sbrdf {
namespace {

constexpr std::size_t kHeldBackCount = 12'000;
constexpr std::uint64_t kChoiceSeed = 1;
constexpr std::uint64_t kReportSeed = 2;
constexpr std::uint64_t kFewestSamples = 64;

constexpr std::array<Placement, 17> kTable3 = {{{28, 180},
                                                {20, 180},
                                                {16, 180},
                                                {28, 60},
                                                {20, 60},
                                                {16, 60},
                                                {14, 60},
                                                {16, 36},
                                                {14, 36},
                                                {12, 36},
                                                {10, 36},
                                                {8, 36},
                                                {12, 20},
                                                {10, 20},
                                                {8, 20},
                                                {6, 20},
                                                {6, 12}}};
constexpr std::array<std::uint64_t, 16> kTable3Limits = {
    667, 932, 1'034, 1'060, 2'272, 3'230, 4'928, 5'645, 9'660, 17'096, 20'969, 22'291, 33'879, 38'735, 79'469, 184'655};

std::string at_degrees(const DirectionPair& pair) {
  const auto text = [](const char* name, double radians) {
    return std::string(name) + " " + std::to_string(degrees_from_radians(radians));
  };
  return text("theta_i", pair.i.theta) + ", " + text("phi_i", pair.i.phi) + ", " + text("theta_v", pair.v.theta) +
         ", " + text("phi_v", pair.v.phi) + " degrees";
}

Status check_finite(std::span<const DirectionPair> pairs, std::span<const float> values) {
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == values.end()) return ok_status();
  const std::size_t k = static_cast<std::size_t>(bad - values.begin()) / (values.size() / pairs.size());
  return invalid_file("the value at " + at_degrees(pairs[k]) + " is not finite");
}

Status evaluate_checked(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<float> values) {
  source.evaluate(pairs, values);
  return check_finite(pairs, values);
}

Status evaluate_checked_in_parallel(const BrdfSource& source, std::span<const DirectionPair> pairs,
                                    std::span<float> values) {
  evaluate_in_parallel(source, pairs, values);
  return check_finite(pairs, values);
}

/// One conversion: the source made reciprocal, the directions it is judged on, and the choices.
class Slicer {
 public:
  Slicer(const BrdfSource& source, const SliceOptions& options, const Progress& progress)
      : source_(source),
        options_(options),
        progress_(progress),
        symmetrised_(source),
        measured_(source.traits().reciprocal ? source : symmetrised_),
        search_(std::get_if<SearchedStructure>(&options.structure)),
        placement_(std::get_if<Placement>(&options.structure)) {}

  Result<Slicing> run() {
    if (Status status = check_options(); !status) return status.error();
    if (search_ != nullptr) {
      symmetries_ = detect_symmetries(measured_);
      if (!search_->use_mirrors) symmetries_.mirror_x = symmetries_.mirror_y = false;
    } else {
      symmetries_.isotropic = source_.traits().isotropic;
    }
    if (search_ != nullptr || target()) {
      if (Status status = draw(kChoiceSeed, choice_); !status) return status.error();
    }
    if (Status status = draw(kReportSeed, report_); !status) return status.error();
    Result<Slicing> slicing = by_stop_rule();
    if (!slicing) return slicing;
    finish(*slicing);
    return slicing;
  }

 private:
  /// Of a search: the starts suffice to tell how many samples it will take.
  enum class Effort : std::uint8_t { kStarts, kFull };

  Status check_options() const {
    const auto* fixed = std::get_if<SampleCount>(&options_.stop);
    if (fixed != nullptr && fixed->count > kMaxSampleCount) {
      return usage_error("at most 1,000,000 samples can be asked for");
    }
    if (target() && !(*target() > 0 && std::isfinite(*target()))) return usage_error("a target must be above 0 %");
    if (search_ != nullptr && search_->evaluations == 0) return usage_error("a search must try one structure or more");
    const double gap = sampling(0).minimum_gap_deg;
    if (!(gap >= 0.01 && gap <= 90)) return usage_error("the minimum gap must be in [0.01, 90] degrees");
    return ok_status();
  }

  Status draw(std::uint64_t seed, HeldBack& target) {
    Result<HeldBack> drawn =
        draw_held_back(kHeldBackCount, seed, symmetries_.isotropic, source_.channel_count(),
                       [&](auto pairs, auto values) { return evaluate_checked_in_parallel(measured_, pairs, values); });
    if (!drawn) return drawn.error();
    target = std::move(drawn).value();
    return ok_status();
  }

  [[nodiscard]] SamplingOptions sampling(std::uint64_t count) const {
    SamplingOptions sampling;
    sampling.sample_count = count;
    sampling.refinement = options_.refinement;
    sampling.minimum_gap_deg =
        options_.minimum_gap_deg.value_or(options_.refinement == Refinement::kBySource ? 0.1 : 1);
    sampling.domain = options_.domain.value_or(DomainKind::kLog);
    return sampling;
  }

  [[nodiscard]] Objective objective() const {
    if (std::holds_alternative<TargetMre>(options_.stop)) return Objective::kMre;
    return std::holds_alternative<TargetRelL1>(options_.stop) ? Objective::kRelL1 : Objective::kBoth;
  }

  // [%], of the error that objective() names; open where the number of samples or of bytes decides.
  [[nodiscard]] std::optional<double> target() const {
    if (const auto* mre = std::get_if<TargetMre>(&options_.stop)) return mre->percent;
    if (const auto* rel_l1 = std::get_if<TargetRelL1>(&options_.stop)) return rel_l1->percent;
    return std::nullopt;
  }

  Result<Slicing> by_stop_rule() {
    if (const auto* fixed = std::get_if<SampleCount>(&options_.stop)) return at_count(fixed->count, Effort::kFull);
    if (const auto* size = std::get_if<MaxBytes>(&options_.stop)) return most_samples(size->count);
    return fewest_samples(*target());
  }

  // The samples of a fixed placement, or of the best structure that a search finds.
  Result<Slicing> at_count(std::uint64_t count, Effort effort) {
    if (placement_ != nullptr) {
      Result<FrameSpec> spec =
          elevation_frame(placement_->elevation_step_deg, placement_->azimuth_step_deg, symmetries_);
      if (!spec) return spec.error();
      return sample(*spec, sampling(count));
    }
    SearchOptions search;
    search.frame = search_->frame;
    search.domain = options_.domain;
    search.symmetries = symmetries_;
    search.objective = objective();
    search.sampling = sampling(count);
    search.evaluations = search_->evaluations;
    search.starts_only = effort == Effort::kStarts;
    search.progress = progress_.report;
    Result<SearchResult> found = search_structure(
        source_.traits().channels, [&](auto pairs, auto values) { return evaluate_checked(measured_, pairs, values); },
        choice_, search);
    if (!found) return found.error();
    structure_ = found->structure;
    reasons_ = found->reasons;
    return resample(count);
  }

  Result<Slicing> resample(std::uint64_t count) {
    if (placement_ != nullptr) return at_count(count, Effort::kStarts);
    return sample(expand_outline(structure_.outline), sampling_for(structure_, sampling(count)));
  }

  Result<Slicing> sample(const FrameSpec& spec, const SamplingOptions& sampling) {
    Result<Lattice> lattice = build_lattice(spec);
    if (!lattice) return lattice.error();
    ProgressCounter counter(placement_ != nullptr ? progress_ : Progress{}, sampling.sample_count);
    Result<SlicedBrdf> sliced = sample_slices(
        *lattice, source_.traits().channels,
        [&](std::span<const DirectionPair> pairs, std::span<float> values) -> Status {
          if (!counter.advance(pairs.size())) return interrupted_error();
          return evaluate_checked_in_parallel(measured_, pairs, values);
        },
        sampling);
    if (!sliced) return sliced.error();
    Slicing slicing{std::move(sliced).value(), std::move(lattice).value(), {}};
    slicing.report.wanted_samples = sampling.sample_count;
    return slicing;
  }

  // Of what a file gives back, not of what was measured.
  [[nodiscard]] double error_of(const Slicing& slicing, const HeldBack& held_back) const {
    SlicedBrdf coded = slicing.sliced;
    round_to_precision(coded, options_.encoding.precision);
    return objective_value(judge(Evaluator(coded, slicing.lattice), held_back), objective());
  }

  Result<Slicing> fewest_samples(double target) {
    if (all_zero(choice_) || all_zero(report_)) {
      return difference_error("the source is zero on all " + std::to_string(choice_.pairs.size()) +
                              " held-back directions: there is no relative error to hold against a target");
    }
    std::uint64_t enough = kFewestSamples;
    const auto reaches = [&](std::uint64_t count) -> Result<bool> {
      Result<Slicing> slicing = at_count(count, Effort::kStarts);
      if (!slicing && slicing.error().code == ErrorCode::kUsage) return false;  // too few for the placement
      if (!slicing) return slicing.error();
      return error_of(*slicing, choice_) <= target;
    };
    for (;; enough *= 2) {
      if (enough > kMaxSampleCount) {
        return difference_error("no structure of up to 1,000,000 samples reaches the target");
      }
      const Result<bool> reached = reaches(enough);
      if (!reached) return reached.error();
      if (*reached) break;
    }
    std::uint64_t few = enough / 2;
    while (enough - few > std::max<std::uint64_t>(1, enough / 20)) {
      const std::uint64_t middle = (few + enough) / 2;
      const Result<bool> reached = reaches(middle);
      if (!reached) return reached.error();
      (*reached ? enough : few) = middle;
    }
    return verified_from(enough, target);
  }

  // The full search at that count, and more samples for as long as fresh directions say that the target is missed.
  Result<Slicing> verified_from(std::uint64_t count, double target) {
    Result<Slicing> slicing = at_count(count, Effort::kFull);
    while (slicing && error_of(*slicing, report_) > target) {
      count += count / 16 + 1;
      if (count > kMaxSampleCount) {
        return difference_error("no structure of up to 1,000,000 samples reaches the target");
      }
      slicing = resample(count);
    }
    return slicing;
  }

  Result<Slicing> most_samples(std::uint64_t limit) {
    std::uint64_t few = kFewestSamples;
    std::uint64_t many = std::min<std::uint64_t>(kMaxSampleCount, std::max<std::uint64_t>(limit, kFewestSamples));
    Result<Slicing> best = at_count(few, Effort::kStarts);
    if (!best) return best.error();
    if (size_of(*best) > limit) return too_small(size_of(*best), limit);
    while (many - few > std::max<std::uint64_t>(1, few / 50)) {
      const std::uint64_t middle = (few + many) / 2;
      Result<Slicing> slicing = at_count(middle, Effort::kStarts);
      if (!slicing) return slicing.error();
      (size_of(*slicing) <= limit ? few : many) = middle;
    }
    for (std::uint64_t count = few; count >= kFewestSamples; count -= count / 50 + 1) {
      best = count == few ? at_count(count, Effort::kFull) : resample(count);
      if (!best || size_of(*best) <= limit) return best;
    }
    return too_small(size_of(*best), limit);
  }

  [[nodiscard]] Error too_small(std::size_t size, std::uint64_t limit) const {
    return usage_error("the smallest file takes " + std::to_string(size) + " bytes; " + std::to_string(limit) +
                       " are too few");
  }

  // With the metadata that the file will have.
  [[nodiscard]] std::size_t size_of(Slicing slicing) const {
    finish(slicing);
    return encode_sliced(slicing.sliced, slicing.lattice, options_.encoding).size();
  }

  void finish(Slicing& slicing) const {
    SliceReport& report = slicing.report;
    round_to_precision(slicing.sliced, options_.encoding.precision);
    for (const auto* values : {&slicing.sliced.crossing_values, &slicing.sliced.sample_values}) {
      report.values += values->size();
      report.zero_values += static_cast<std::uint64_t>(std::count(values->begin(), values->end(), 0.0F));
      report.negative_values +=
          static_cast<std::uint64_t>(std::count_if(values->begin(), values->end(), [](float v) { return v < 0; }));
    }
    report.reciprocity_difference_percent = reciprocity_difference_percent(source_);
    report.error = judge(Evaluator(slicing.sliced, slicing.lattice), report_);
    report.error_directions = report_.pairs.size();
    report.error_values_all_zero = all_zero(report_);
    report.reasons = reasons_;
    slicing.sliced.metadata = describe(report);
  }

  [[nodiscard]] std::string describe(const SliceReport& report) const {
    const SourceTraits& traits = source_.traits();
    const auto rounded = [](double value) {
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), "%.4g", value);
      return std::strtod(text.data(), nullptr);
    };
    nlohmann::ordered_json json;
    json["source"] = {{"format", traits.format}, {"description", traits.description}};
    if (!options_.source_sha256.empty()) json["source"]["sha256"] = options_.source_sha256;
    if (!options_.command.empty()) json["command"] = options_.command;
    json["quantity"] = "f_r, 1/sr, without cosine";
    json["colour"] = "channels as in the source, linear";
    json["precision_percent"] = rounded(100 * options_.encoding.precision);
    json["symmetrised"] = !traits.reciprocal;
    json["reciprocity_residual_percent"] = rounded(report.reciprocity_difference_percent);
    json["refinement"] = name_of(kRefinementNames, options_.refinement);
    json["zero_values"] = report.zero_values;
    json["negative_values"] = report.negative_values;
    json["error"] = {{"mre_percent", rounded(report.error.mre_percent)},
                     {"rel_l1_percent", rounded(report.error.rel_l1_percent)},
                     {"directions", report.error_directions},
                     {"measured_on", "random directions that took no part in any choice, theta up to 80 degrees"}};
    if (report.error_values_all_zero) json["error"]["values_all_zero"] = true;
    for (const Finding& finding : traits.findings) {
      json["findings"].push_back({{"what", finding.what}, {"count", finding.count}, {"total", finding.total}});
    }
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }

  const BrdfSource& source_;
  const SliceOptions& options_;
  const Progress& progress_;
  SymmetrisedSource symmetrised_;
  const BrdfSource& measured_;
  const SearchedStructure* search_;  // one of these two
  const Placement* placement_;
  Symmetries symmetries_;
  HeldBack choice_;
  HeldBack report_;
  Structure structure_;
  std::vector<std::string> reasons_;
};

bool has_positive(const SlicedBrdf& sliced) {
  const auto positive = [](float v) { return v > 0; };
  return std::any_of(sliced.crossing_values.begin(), sliced.crossing_values.end(), positive) ||
         std::any_of(sliced.sample_values.begin(), sliced.sample_values.end(), positive);
}

}  // namespace

std::span<const Placement> table_3_placements() { return kTable3; }

Placement table_3_placement(std::uint64_t sample_count) {
  const auto row = std::lower_bound(kTable3Limits.begin(), kTable3Limits.end(), sample_count);
  return kTable3[static_cast<std::size_t>(row - kTable3Limits.begin())];
}

Result<Slicing> slice_source(const BrdfSource& source, const SliceOptions& options, const Progress& progress) {
  Result<Slicing> slicing = Slicer(source, options, progress).run();
  if (slicing && !has_positive(slicing->sliced)) {
    return invalid_file("none of the " + std::to_string(slicing->report.values) +
                        " values sampled is positive; this is no reflectance");
  }
  return slicing;
}

}  // namespace sbrdf
