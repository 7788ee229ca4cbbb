#include "codec/search/structure_search.h"
#include "formats/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace sbrdf {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr HeldBackError kInfiniteError = {kInfinite, kInfinite};
constexpr double kLeastGain = 0.998;            // a move must bring the error below this times what it was
constexpr double kMaxCrossingShare = 0.9;       // of the budget; slices need samples of their own
constexpr std::uint64_t kFewestSearched = 500;  // samples; below, half of them say nothing about all
constexpr std::array<double, kAxisCount> kLeastCellDeg = {4, 4, 2, 0.5};

std::vector<double> steps(double end, double step) {
  std::vector<double> list;
  for (int k = 0; k * step < end - 1e-9; ++k) list.push_back(k * step);
  list.push_back(end);
  return list;
}

std::vector<Structure> elevation_seeds(const Symmetries& symmetries) {
  std::vector<Structure> seeds;
  for (const double elevation : {28.0, 20.0, 14.0, 10.0, 7.0, 5.0}) {
    for (const double azimuth : {180.0, 60.0, 36.0, 20.0, 12.0}) {
      Structure seed;
      seed.outline = {FrameId::kElevation, symmetries, {}};
      seed.outline.lists[kAxial] = symmetries.isotropic ? std::vector<double>{0} : steps(180, azimuth);
      seed.outline.lists[kDiagonal] = steps(180, azimuth);
      seed.outline.lists[kHorizontal] = steps(kThetaMaxDeg, elevation);
      seeds.push_back(seed);
    }
  }
  return seeds;
}

std::vector<Structure> half_difference_seeds(const Symmetries& symmetries) {
  const std::vector<std::vector<double>> theta_h = {
      {0, 20, 50, 80}, {0, 6, 16, 32, 55, 80}, {0, 3, 8, 16, 32, 55, 80}, {0, 2, 5, 10, 20, 35, 55, 80}};
  const std::vector<std::vector<double>> theta_d = {
      {0, 40, 80}, {0, 20, 40, 60, 72, 80}, {0, 12, 24, 36, 48, 60, 70, 80}};
  const std::vector<double> phi_h =
      symmetries.isotropic ? std::vector<double>{0} : std::vector<double>{90, 45, 22.5, 15};
  std::vector<Structure> seeds;
  for (const auto& h : theta_h) {
    for (const auto& d : theta_d) {
      for (const double phi_h_step : phi_h) {
        for (const double phi_d_step : {45.0, 30.0, 18.0}) {
          Structure seed;
          seed.outline = {FrameId::kHalfDifference, symmetries, {}};
          seed.outline.lists[kAxial] = symmetries.isotropic ? std::vector<double>{0} : steps(90, phi_h_step);
          seed.outline.lists[kDiagonal] = steps(90, phi_d_step);
          seed.outline.lists[kHorizontal] = d;
          seed.outline.lists[kVertical] = h;
          seeds.push_back(seed);
        }
      }
    }
  }
  return seeds;
}

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
      : channels_(channels), measure_(measure), held_back_(held_back), options_(options) {}

  // `fewer`: what a search for fewer samples found.
  Result<SearchResult> run(const std::optional<SearchResult>& fewer) {
    std::vector<Structure> candidates = seeds(options_.evaluations - (fewer ? 1 : 0));
    if (fewer) candidates.push_back(fewer->structure);
    if (candidates.empty()) return too_few();
    const std::vector<HeldBackError> errors = try_all(candidates);
    if (stopped_) return interrupted();
    if (fewer) {
      ceiling_.mre_percent = std::max(fewer->error.mre_percent, errors.back().mre_percent);
      ceiling_.rel_l1_percent = std::max(fewer->error.rel_l1_percent, errors.back().rel_l1_percent);
    }
    for (std::size_t k = 0; k < candidates.size(); ++k) remember(candidates[k], value_of(errors[k]));
    take_best(candidates, errors, kInfinite);
    if (value_of(error_) == kInfinite) return why_all_fail(candidates.front());
    report_frames();
    while (!stopped_ && !options_.starts_only && tried_ < options_.evaluations && improve()) {
    }
    if (stopped_) return interrupted();
    const std::string tried = std::to_string(tried_) + (tried_ == 1 ? " structure" : " structures");
    reason(describe(structure_) + ", after " + tried + " tried with so many samples", value_of(error_));
    return SearchResult{structure_, error_, std::move(reasons_)};
  }

 private:
  [[nodiscard]] std::vector<Structure> seeds(std::size_t most) const {
    std::vector<Structure> all;
    for (const FrameId id : {FrameId::kElevation, FrameId::kHalfDifference}) {
      if (options_.frame && *options_.frame != id) continue;
      const auto some =
          id == FrameId::kElevation ? elevation_seeds(options_.symmetries) : half_difference_seeds(options_.symmetries);
      all.insert(all.end(), some.begin(), some.end());
    }
    for (Structure& seed : all) {
      seed.domain = options_.domain.value_or(DomainKind::kLog);
      if (options_.objective == Objective::kMre) seed.value_exponent = 0;
      if (options_.objective == Objective::kRelL1) seed.value_exponent = 1;
    }
    return keep_fitting(all, most);
  }

  // Seeds with hardly any crossings for the budget lead nowhere; those with too many do not fit. The densest third of
  // the fitting ones of each frame stay, which saves most of the time; fewer where fewer are to be tried.
  [[nodiscard]] std::vector<Structure> keep_fitting(const std::vector<Structure>& all, std::size_t most) const {
    std::array<std::vector<Structure>, 2> kept = {densest_third(all, FrameId::kElevation),
                                                  densest_third(all, FrameId::kHalfDifference)};
    while (kept[0].size() + kept[1].size() > most) kept[kept[0].size() < kept[1].size() ? 1 : 0].pop_back();
    kept[0].insert(kept[0].end(), kept[1].begin(), kept[1].end());
    return std::move(kept[0]);
  }

  [[nodiscard]] std::vector<Structure> densest_third(const std::vector<Structure>& all, FrameId id) const {
    std::vector<std::pair<std::size_t, std::size_t>> counts;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k].outline.id != id) continue;
      const Result<Lattice> lattice = build_lattice(expand_outline(all[k].outline));
      if (!lattice || !fits(lattice->crossings.size())) continue;
      counts.emplace_back(lattice->crossings.size(), k);
    }
    std::sort(counts.rbegin(), counts.rend());
    const std::size_t keep = std::max<std::size_t>(std::min<std::size_t>(8, counts.size()), counts.size() / 3);
    std::vector<Structure> kept;
    for (std::size_t k = 0; k < keep; ++k) kept.push_back(all[counts[k].second]);
    return kept;
  }

  [[nodiscard]] bool fits(std::size_t crossings) const {
    return static_cast<double>(crossings) <= kMaxCrossingShare * static_cast<double>(options_.sampling.sample_count);
  }

  [[nodiscard]] Result<HeldBackError> error_of(const Structure& structure) const {
    const Result<Lattice> lattice = build_lattice(expand_outline(structure.outline));
    if (!lattice) return lattice.error();
    if (!fits(lattice->crossings.size())) return kInfiniteError;
    const Result<SlicedBrdf> sliced =
        sample_slices(*lattice, channels_, measure_, sampling_for(structure, options_.sampling));
    if (!sliced) return sliced.error();
    return judge(Evaluator(*sliced, *lattice), held_back_);
  }

  // Infinite for what is worse by either error than fewer samples can do.
  [[nodiscard]] double value_of(const HeldBackError& error) const {
    const bool worse = error.mre_percent > ceiling_.mre_percent || error.rel_l1_percent > ceiling_.rel_l1_percent;
    return worse && options_.objective == Objective::kBoth ? kInfinite : objective_value(error, options_.objective);
  }

  // False where none is below the limit.
  bool take_best(const std::vector<Structure>& candidates, const std::vector<HeldBackError>& errors, double limit) {
    bool taken = false;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (value_of(errors[k]) >= limit) continue;
      limit = value_of(errors[k]);
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
    const double done = static_cast<double>(tried_) / static_cast<double>(std::max(options_.evaluations, tried_));
    if (options_.progress && !options_.progress(done)) stopped_ = true;
    return errors;
  }

  bool improve() {
    const std::vector<Structure> candidates = moves();
    return take_best(candidates, try_all(candidates), kLeastGain * value_of(error_));
  }

  [[nodiscard]] std::vector<Structure> moves() const {
    std::vector<Structure> all;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) move_nodes(axis, all);
    if (!options_.domain) {
      all.push_back(structure_);
      all.back().domain = structure_.domain == DomainKind::kLog ? DomainKind::kLinear : DomainKind::kLog;
    }
    if (structure_.domain != DomainKind::kLog) return all;
    for (const int halvings : {2, 5, 10}) {
      all.push_back(structure_);
      all.back().floor_halvings = halvings;
    }
    if (structure_.outline.id != FrameId::kHalfDifference) return all;
    const bool isotropic = options_.symmetries.isotropic;
    using Ratios = std::vector<std::optional<double>>;
    for (const auto ratio : isotropic ? Ratios{{}, 1} : Ratios{{}, 1, 0.2, 0.4, 2.5, 5}) {
      all.push_back(structure_);
      all.back().guide_ratio = ratio;
    }
    return all;
  }

  // A node more in the middle of each cell, each inner node gone, each inner node a third of its way to a neighbour.
  void move_nodes(std::size_t axis, std::vector<Structure>& all) const {
    const std::vector<double>& list = structure_.outline.lists[axis];
    const auto changed = [&]() -> std::vector<double>& {
      all.push_back(structure_);
      return all.back().outline.lists[axis];
    };
    for (std::size_t k = 0; k + 1 < list.size(); ++k) {
      if (list[k + 1] - list[k] < 2 * kLeastCellDeg[axis]) continue;
      std::vector<double>& target = changed();
      target.insert(target.begin() + static_cast<std::ptrdiff_t>(k + 1), (list[k] + list[k + 1]) / 2);
    }
    for (std::size_t k = 1; k + 1 < list.size(); ++k) {
      std::vector<double>& target = changed();
      target.erase(target.begin() + static_cast<std::ptrdiff_t>(k));
      changed()[k] -= std::round((list[k] - list[k - 1]) * 32 / 3) / 32;
      changed()[k] += std::round((list[k + 1] - list[k]) * 32 / 3) / 32;
    }
  }

  void remember(const Structure& structure, double error) {
    auto& best = best_of_frame_[structure.outline.id == FrameId::kElevation ? 0 : 1];
    if (error < best.second) best = {structure, error};
  }

  void report_frames() {
    for (const auto& [structure, error] : best_of_frame_) {
      if (error < kInfinite) reason("best start: " + describe(structure), error);
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
  Structure structure_;
  HeldBackError error_ = kInfiniteError;
  HeldBackError ceiling_ = kInfiniteError;
  std::size_t tried_ = 0;
  bool stopped_ = false;
  std::array<std::pair<Structure, double>, 2> best_of_frame_ = {std::pair{Structure{}, kInfinite},
                                                                std::pair{Structure{}, kInfinite}};
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
  std::optional<SearchResult> fewer;
  for (;; counts.pop_back()) {
    const double share = static_cast<double>(counts.back()) / total;
    SearchOptions step = options;
    step.sampling.sample_count = counts.back();
    step.progress = [&](double fraction) {
      stopped = stopped || (options.progress && !options.progress(done + share * fraction));
      return !stopped;
    };
    Result<SearchResult> found = Search(channels, measure, held_back, step).run(fewer);
    if (stopped || counts.size() == 1) return found;
    if (found) fewer = std::move(found).value();
    done += share;
  }
}

}  // namespace sbrdf
