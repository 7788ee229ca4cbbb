#include "codec/search/structure_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
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
constexpr std::uint64_t kFewestSearched = 500;  // samples; below, half of them say nothing about all
constexpr std::size_t kGlanceCount = 2000;      // held-back directions that single moves are judged by
constexpr std::uint64_t kRoundsDivisor = 4;     // of sampling: structures that are only tried are sampled faster

// Of an error after a change over that before:
constexpr double kLeastGain = 0.998;    // a change that is made must be below
constexpr double kDullGain = 1.02;      // a move above is not tried again with so many samples
constexpr double kWorthAnother = 0.97;  // after a round below, there is another
constexpr double kHopeless = 1.15;      // a frame so many times worse than the other is given up
constexpr double kHopelessWithFew = 2;  // where both have gone all their way with fewer samples

std::string describe(const Structure& structure) {
  const FrameSpec spec = expand_outline(structure.outline);
  std::string text(geometry(spec.id).name());
  text += structure.domain == DomainKind::kLog ? " frame, log" : " frame, linear";
  if (structure.guide_ratio) text += ", guide";
  for (const Axis& axis : spec.axes) text += ", " + std::to_string(axis.nodes_deg.size()) + " " + axis.name;
  return text;
}

HeldBackError worse_of(const HeldBackError& a, const HeldBackError& b) {
  return {std::max(a.mre_percent, b.mre_percent), std::max(a.rel_l1_percent, b.rel_l1_percent)};
}

Structure in_other_domain(Structure structure) {
  structure.domain = structure.domain == DomainKind::kLog ? DomainKind::kLinear : DomainKind::kLog;
  return structure;
}

// The last comes first.
std::vector<std::uint64_t> counts_on_the_way(const SearchOptions& options) {
  std::vector<std::uint64_t> counts = {options.sampling.sample_count};
  while (!options.starts_only && counts.back() / 2 >= kFewestSearched) {
    counts.push_back(counts.back() / (counts.back() / 4 >= kFewestSearched ? 4 : 2));
  }
  return counts;
}

/// What tells a move of a round from others, and finds it again in the next one.
using MoveKey = std::array<double, 4>;

MoveKey key_of(const Move& move) {
  MoveKey key = {static_cast<double>(move.part), move.first_deg, move.last_deg, -1};
  if (move.part == kFloorPart) {
    key[3] = move.to.floor_halvings;
  } else if (move.part == kGuidePart) {
    key[3] = move.to.guide_ratio.value_or(-1);
  } else {
    for (const double node : move.to.outline.lists[move.part]) {
      if (node > move.first_deg && node < move.last_deg) key[3] = node;
    }
  }
  return key;
}

/// The errors of a structure.
struct Judged {
  HeldBackError all = kInfiniteError;     ///< on all held-back directions
  HeldBackError glance = kInfiniteError;  ///< on the few that moves are judged by
};

/// What a search has found for one frame. The frames do not know of each other, so that a search that is free to choose
/// finds what it would find if it were told.
struct Track {
  Structure structure;
  Judged error;
  Standard standard;
  std::size_t tried = 0;            ///< structures with so many samples, starts of both frames among them
  std::map<MoveKey, double> gains;  ///< of moves that were looked at: the error after them over that before
};

double value_of(const Track& track) { return track.standard.value_of(track.error.all); }

class Search {
 public:
  Search(const std::vector<std::string>& channels, const Measure& measure, const HeldBack& held_back,
         const SearchOptions& options)
      : channels_(channels),
        measure_(measure),
        held_back_(held_back),
        glance_(first_of(held_back, kGlanceCount)),
        options_(options) {}

  Result<SearchResult> run() {
    std::vector<std::uint64_t> counts = counts_on_the_way(options_);
    total_ = std::accumulate(counts.begin(), counts.end(), 0.0);
    for (; !counts.empty(); counts.pop_back()) {
      samples_ = counts.back();
      tried_ = 0;
      const Status status = tracks_.empty() ? begin() : go_on();
      for (Track& track : tracks_) improve_all(track);
      if (stopped_) return io_error("interrupted");
      if (!status && counts.size() == 1) return status.error();
      done_ += static_cast<double>(samples_);
    }
    const Track& best = best_track();
    const std::string tried = std::to_string(tried_) + (tried_ == 1 ? " structure" : " structures");
    reason(describe(best.structure) + ", after " + tried + " tried with so many samples", value_of(best));
    return SearchResult{best.structure, best.error.all, std::move(reasons_)};
  }

 private:
  // Infinite for what does not fit the budget.
  [[nodiscard]] Result<Judged> judge_structure(const Structure& structure, bool at_a_glance) const {
    const Result<Lattice> lattice = build_lattice(expand_outline(structure.outline));
    if (!lattice) return lattice.error();
    if (!fits_budget(lattice->crossings.size(), samples_)) return Judged();
    SamplingOptions sampling = sampling_for(structure, options_.sampling);
    sampling.sample_count = samples_;
    sampling.rounds_divisor = kRoundsDivisor;
    const Result<SlicedBrdf> sliced = sample_slices(*lattice, channels_, measure_, sampling);
    if (!sliced) return sliced.error();
    const Evaluator evaluator(*sliced, *lattice);
    Judged judged;
    judged.glance = judge(evaluator, glance_);
    if (!at_a_glance) judged.all = judge(evaluator, held_back_);
    return judged;
  }

  std::vector<Judged> judge_all(const std::vector<Structure>& structures, bool at_a_glance) {
    std::vector<Judged> judged(structures.size());
    parallel_for(structures.size(), [&](std::size_t k) {
      const Result<Judged> result = judge_structure(structures[k], at_a_glance);
      if (result) judged[k] = *result;
    });
    report_progress();
    return judged;
  }

  [[nodiscard]] double glance_value(const Judged& judged) const {
    return objective_value(judged.glance, options_.objective);
  }

  // The best start of each frame.
  Status begin() {
    SearchOptions options = options_;
    options.sampling.sample_count = samples_;
    const std::vector<Structure> starts = regular_starts(options, options_.evaluations);
    if (starts.empty()) {
      return usage_error("too few samples for any structure: " + std::to_string(options_.sampling.sample_count));
    }
    const std::vector<Judged> judged = judge_all(starts, true);
    tried_ += starts.size();
    for (const FrameId id : {FrameId::kElevation, FrameId::kHalfDifference}) {
      double least = kInfinite;
      const Structure* best = nullptr;
      for (std::size_t k = 0; k < starts.size(); ++k) {
        if (starts[k].outline.id != id || glance_value(judged[k]) >= least) continue;
        least = glance_value(judged[k]);
        best = &starts[k];
      }
      if (best == nullptr) continue;
      reason("best start: " + describe(*best), least);
      tracks_.push_back({*best, {}, {.objective = options_.objective}, starts.size(), {}});
    }
    judge_tracks();
    std::erase_if(tracks_, [](const Track& track) { return value_of(track) == kInfinite; });
    if (tracks_.empty()) return why_all_fail(starts.front());
    return ok_status();
  }

  // What was found with fewer samples, with more of them.
  Status go_on() {
    drop_hopeless(kHopelessWithFew);
    for (Track& track : tracks_) track.tried = 1;
    tried_ = tracks_.size();
    judge_tracks();
    drop_hopeless(kHopeless);
    return ok_status();
  }

  // Takes the other domain where it is better. What was known of the errors before becomes the ceiling.
  void judge_tracks() {
    std::vector<Structure> structures;
    for (const Track& track : tracks_) structures.push_back(track.structure);
    const bool both = !options_.domain && tried_ < options_.evaluations;
    for (std::size_t k = 0; both && k < tracks_.size(); ++k) structures.push_back(in_other_domain(structures[k]));
    const std::vector<Judged> judged = judge_all(structures, false);
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      Track& track = tracks_[k];
      track.standard.ceiling = worse_of(track.error.all, judged[k].all);
      track.error = judged[k];
      track.gains.clear();
      if (!both) continue;
      count_tried(track, 1);
      take_if_better(track, structures[k + tracks_.size()], judged[k + tracks_.size()], value_of(track));
    }
  }

  static bool take_if_better(Track& track, const Structure& structure, const Judged& judged, double limit) {
    if (track.standard.value_of(judged.all) >= limit) return false;
    track.structure = structure;
    track.error = judged;
    return true;
  }

  void count_tried(Track& track, std::size_t count) {
    track.tried += count;
    tried_ += count;
  }

  void improve_all(Track& track) {
    while (!stopped_ && !options_.starts_only && track.tried < options_.evaluations && improve(track)) {
    }
  }

  // A round: looks at all moves at a glance, then makes the best, the two best, the four best ... together. False
  // where another would hardly be worth it.
  bool improve(Track& track) {
    std::vector<Move> moves = moves_from(track.structure, options_);
    std::erase_if(moves, [&](const Move& move) {
      const auto known = track.gains.find(key_of(move));
      return known != track.gains.end() && known->second > kDullGain;
    });
    std::vector<Structure> structures;
    for (const Move& move : moves) structures.push_back(move.to);
    std::vector<double> gains;
    for (const Judged& judged : judge_all(structures, true)) {
      gains.push_back(glance_value(judged) / glance_value(track.error));
    }
    for (std::size_t k = 0; k < moves.size(); ++k) track.gains[key_of(moves[k])] = gains[k];
    count_tried(track, moves.size());
    const std::vector<Structure> bundles = bundles_of(track.structure, moves, gains);
    if (stopped_ || bundles.empty()) return false;
    const std::vector<Judged> judged = judge_all(bundles, false);
    count_tried(track, bundles.size());
    const double before = value_of(track);
    double limit = kLeastGain * before;
    for (std::size_t k = 0; k < bundles.size(); ++k) {
      if (take_if_better(track, bundles[k], judged[k], limit)) limit = value_of(track);
    }
    return value_of(track) < kWorthAnother * before;
  }

  [[nodiscard]] static std::vector<Structure> bundles_of(const Structure& from, const std::vector<Move>& moves,
                                                         const std::vector<double>& gains) {
    std::vector<std::size_t> order(moves.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t k) { return !(gains[k] < kLeastGain); });
    std::ranges::stable_sort(order, {}, [&](std::size_t k) { return gains[k]; });
    std::vector<Move> chosen;
    std::vector<Structure> bundles;
    for (const std::size_t k : order) {
      if (!std::ranges::all_of(chosen, [&](const Move& other) { return are_apart(moves[k], other); })) continue;
      chosen.push_back(moves[k]);
      if (std::has_single_bit(chosen.size())) bundles.push_back(with_moves(from, chosen));
    }
    if (!std::has_single_bit(chosen.size()) && !chosen.empty()) bundles.push_back(with_moves(from, chosen));
    return bundles;
  }

  [[nodiscard]] const Track& best_track() const { return *std::ranges::min_element(tracks_, {}, value_of); }

  void drop_hopeless(double factor) {
    const double limit = factor * value_of(best_track());
    std::erase_if(tracks_, [&](const Track& track) { return value_of(track) > limit; });
  }

  // Of a structure that fits the budget.
  [[nodiscard]] Error why_all_fail(const Structure& structure) const {
    const Result<Judged> error = judge_structure(structure, true);
    if (!error) return error.error();
    const std::string zero = all_zero(held_back_) ? ", where all values are zero" : "";
    return unsupported("every structure tried has an infinite error on the " + std::to_string(held_back_.pairs.size()) +
                       " held-back directions" + zero + ": there is nothing to choose one by");
  }

  void report_progress() {
    if (!options_.progress || stopped_) return;
    const double all = static_cast<double>(options_.evaluations * std::max<std::size_t>(1, tracks_.size()));
    const double here = std::min(1.0, static_cast<double>(tried_) / all);
    stopped_ = !options_.progress((done_ + here * static_cast<double>(samples_)) / total_);
  }

  static const char* name_of(Objective objective) {
    if (objective == Objective::kBoth) return "sqrt(MRE x relative L1)";
    return objective == Objective::kMre ? "MRE" : "relative L1";
  }

  void reason(const std::string& what, double error) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.3g %%", error);
    reasons_.push_back(what + ": " + name_of(options_.objective) + " " + number.data());
  }

  const std::vector<std::string>& channels_;
  const Measure& measure_;
  const HeldBack& held_back_;
  const HeldBack glance_;
  const SearchOptions& options_;
  std::vector<Track> tracks_;
  std::uint64_t samples_ = 0;  ///< for which structures are tried just now
  std::size_t tried_ = 0;      ///< structures with so many samples
  double done_ = 0;            ///< sum of the numbers of samples that are searched for
  double total_ = 1;
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
  ValueCache cache(measure, channels.size());
  const Measure cached = [&](auto pairs, auto values) { return cache.measure(pairs, values); };
  return Search(channels, cached, held_back, options).run();
}

}  // namespace sbrdf::internal
