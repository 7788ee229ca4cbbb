#include "codec/search/structure_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <utility>

#include "codec/search/moves.h"
#include "codec/search/starts.h"
#include "codec/search/value_cache.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr HeldBackError kInfiniteError = {kInfinite, kInfinite};
constexpr double kLeastGain = 0.998;            // a move must bring the error below this times what it was
constexpr std::uint64_t kFewestSearched = 500;  // samples; below, half of them say nothing about all

std::string describe(const Structure& structure) {
  const FrameSpec spec = expand_outline(structure.outline);
  std::string text(geometry(spec.id).name());
  text += structure.domain == DomainKind::kLog ? " frame, log" : " frame, linear";
  if (structure.guide_ratio) text += ", guide";
  for (const Axis& axis : spec.axes) text += ", " + std::to_string(axis.nodes_deg.size()) + " " + axis.name;
  return text;
}

/// A search for one number of samples.
class Search {
 public:
  Search(const std::vector<std::string>& channels, const Measure& measure, const HeldBack& held_back,
         const SearchOptions& options)
      : channels_(channels), measure_(measure), held_back_(held_back), options_(options) {
    standard_.objective = options.objective;
  }

  // `fewer`: what a search for fewer samples found.
  Result<SearchResult> run(const std::optional<SearchResult>& fewer) {
    std::vector<Structure> candidates = regular_starts(options_, options_.evaluations - (fewer ? 1 : 0));
    if (fewer) candidates.push_back(fewer->structure);
    if (candidates.empty()) return too_few();
    const std::vector<HeldBackError> errors = try_all(candidates);
    if (stopped_) return interrupted();
    if (fewer) standard_.ceiling = worse_of(fewer->error, errors.back());
    take_best(candidates, errors, kInfinite);
    if (standard_.value_of(error_) == kInfinite) return why_all_fail(candidates.front());
    report_starts(candidates, errors);
    while (!stopped_ && !options_.starts_only && spent_ < options_.evaluations && improve()) {
    }
    if (stopped_) return interrupted();
    const std::string tried = std::to_string(tried_) + (tried_ == 1 ? " structure" : " structures");
    reason(describe(structure_) + ", after " + tried + " tried with so many samples", standard_.value_of(error_));
    return SearchResult{structure_, error_, std::move(reasons_)};
  }

 private:
  [[nodiscard]] Result<HeldBackError> error_of(const Structure& structure) const {
    const Result<Lattice> lattice = build_lattice(expand_outline(structure.outline));
    if (!lattice) return lattice.error();
    if (!fits_budget(lattice->crossings.size(), options_.sampling.sample_count)) return kInfiniteError;
    const Result<SlicedBrdf> sliced =
        sample_slices(*lattice, channels_, measure_, sampling_for(structure, options_.sampling));
    if (!sliced) return sliced.error();
    return judge(Evaluator(*sliced, *lattice), held_back_);
  }

  [[nodiscard]] static HeldBackError worse_of(const HeldBackError& a, const HeldBackError& b) {
    return {std::max(a.mre_percent, b.mre_percent), std::max(a.rel_l1_percent, b.rel_l1_percent)};
  }

  // False where none is below the limit.
  bool take_best(const std::vector<Structure>& candidates, const std::vector<HeldBackError>& errors, double limit) {
    bool taken = false;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (standard_.value_of(errors[k]) >= limit) continue;
      limit = standard_.value_of(errors[k]);
      structure_ = candidates[k];
      error_ = errors[k];
      taken = true;
    }
    return taken;
  }

  [[nodiscard]] static Error interrupted() { return io_error("interrupted"); }

  [[nodiscard]] Error too_few() const {
    return usage_error("too few samples for any structure: " + std::to_string(options_.sampling.sample_count));
  }

  // Of structures that all fit the budget.
  [[nodiscard]] Error why_all_fail(const Structure& structure) const {
    const Result<HeldBackError> error = error_of(structure);
    if (!error) return error.error();
    const std::string zero = all_zero(held_back_) ? ", where all values are zero" : "";
    return unsupported("every structure tried has an infinite error on the " + std::to_string(held_back_.pairs.size()) +
                       " held-back directions" + zero + ": there is nothing to choose one by");
  }

  std::vector<HeldBackError> try_all(const std::vector<Structure>& candidates) {
    std::vector<HeldBackError> errors(candidates.size(), kInfiniteError);
    parallel_for(candidates.size(), [&](std::size_t k) {
      const Result<HeldBackError> error = error_of(candidates[k]);
      if (error) errors[k] = *error;
    });
    tried_ += candidates.size();
    spent_ += candidates.size();
    const double done = static_cast<double>(spent_) / static_cast<double>(std::max(options_.evaluations, spent_));
    if (options_.progress && !options_.progress(done)) stopped_ = true;
    return errors;
  }

  bool improve() {
    const Moves moves = moves_from(structure_, options_);
    const double limit = kLeastGain * standard_.value_of(error_);
    const bool better = take_best(moves.structures, try_all(moves.structures), limit);
    spent_ += moves.known;
    return better;
  }

  // The best of each frame.
  void report_starts(const std::vector<Structure>& starts, const std::vector<HeldBackError>& errors) {
    for (const FrameId id : {FrameId::kElevation, FrameId::kHalfDifference}) {
      double least = kInfinite;
      const Structure* best = nullptr;
      for (std::size_t k = 0; k < starts.size(); ++k) {
        if (starts[k].outline.id != id || standard_.value_of(errors[k]) >= least) continue;
        least = standard_.value_of(errors[k]);
        best = &starts[k];
      }
      if (best != nullptr) reason("best start: " + describe(*best), least);
    }
  }

  void reason(const std::string& what, double error) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.3g %%", error);
    reasons_.push_back(what + ": " + number.data());
  }

  const std::vector<std::string>& channels_;
  const Measure& measure_;
  const HeldBack& held_back_;
  const SearchOptions& options_;
  Standard standard_;
  Structure structure_;
  HeldBackError error_ = kInfiniteError;
  std::size_t tried_ = 0;
  std::size_t spent_ = 0;  // of the evaluations: those tried, and moves that lead nowhere
  bool stopped_ = false;
  std::vector<std::string> reasons_;
};

}  // namespace

double objective_value(const HeldBackError& error, Objective objective) {
  switch (objective) {
    case Objective::kMre:
      return error.mre_percent;
    case Objective::kRelL1:
      return error.rel_l1_percent;
    case Objective::kBoth:
      break;
  }
  return std::sqrt(error.mre_percent * error.rel_l1_percent);
}

double Standard::value_of(const HeldBackError& error) const {
  const bool worse = error.mre_percent > ceiling.mre_percent || error.rel_l1_percent > ceiling.rel_l1_percent;
  return worse && objective == Objective::kBoth ? kInfinite : objective_value(error, objective);
}

SamplingOptions sampling_for(const Structure& structure, SamplingOptions options) {
  options.domain = structure.domain;
  options.floor_halvings = structure.floor_halvings;
  options.value_exponent = structure.value_exponent;
  options.guide_ratio = structure.domain == DomainKind::kLog && structure.outline.id == FrameId::kHalfDifference
                            ? structure.guide_ratio
                            : std::nullopt;
  return options;
}

Result<SearchResult> search_structure(const std::vector<std::string>& channels, const Measure& measure,
                                      const HeldBack& held_back, const SearchOptions& options) {
  std::vector<std::uint64_t> counts = {options.sampling.sample_count};
  while (!options.starts_only && counts.back() / 2 >= kFewestSearched) counts.push_back(counts.back() / 2);
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  double done = 0;
  bool stopped = false;
  ValueCache cache(measure, channels.size());
  const Measure cached = [&](auto pairs, auto values) { return cache.measure(pairs, values); };
  std::optional<SearchResult> fewer;
  for (;; counts.pop_back()) {
    const double share = static_cast<double>(counts.back()) / total;
    SearchOptions step = options;
    step.sampling.sample_count = counts.back();
    step.progress = [&](double fraction) {
      stopped = stopped || (options.progress && !options.progress(done + share * fraction));
      return !stopped;
    };
    Result<SearchResult> found = Search(channels, cached, held_back, step).run(fewer);
    if (stopped || counts.size() == 1) return found;
    if (found) fewer = std::move(found).value();
    done += share;
  }
}

}  // namespace sbrdf::internal
