#include "codec/adaptive_sampling.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "codec/guide_fit.h"
#include "codec/residual_map.h"
#include "codec/slice_table.h"
#include "codec/spline.h"

namespace sbrdf {
namespace {

struct Candidate {
  double weight = 0;
  std::uint32_t slice = 0;
  std::uint32_t left = 0;  ///< the sample before the gap
};

// A total order, so that the chosen set does not depend on how it is selected.
bool weighs_more(const Candidate& a, const Candidate& b) {
  return std::tuple(-a.weight, a.slice, a.left) < std::tuple(-b.weight, b.slice, b.left);
}

/// A slice while it is sampled.
struct Working {
  SliceSamples samples;
  std::vector<double> mapped;   ///< values in the value domain, channel fastest
  std::vector<double> weights;  ///< per gap; negative where it must stay whole
  std::vector<float> probes;    ///< kTrue: per gap, the source at kProbes places
};

class Sampler {
 public:
  Sampler(const Lattice& lattice, const Measure& measure, const SamplingOptions& options, SlicedBrdf& sliced)
      : lattice_(lattice),
        frame_(geometry(lattice.spec.id)),
        measure_(measure),
        options_(options),
        sliced_(sliced),
        channels_(sliced.channel_count()) {}
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;
  virtual ~Sampler() = default;

  Status run() {
    if (Status status = measure_crossings(); !status) return status;
    if (Status status = choose_domain(); !status) return status;
    sliced_.sample_counts.assign(lattice_.slices.size(), 0);
    std::vector<SliceSamples> samples = gather_slices(sliced_, lattice_);
    slices_.resize(samples.size());
    std::vector<Candidate> all;
    for (std::uint32_t k = 0; k < slices_.size(); ++k) {
      slices_[k].samples = std::move(samples[k]);
      all.push_back({0, k, 0});
    }
    if (Status status = start(); !status) return status;
    const std::uint64_t spent = lattice_.crossings.size() + (sliced_.guide ? sliced_.guide->places.size() : 0);
    const std::uint64_t adaptive = options_.sample_count - std::min(spent, options_.sample_count);
    for (int round = 1; placed_ < adaptive; ++round) {
      const std::uint64_t before = placed_;
      const std::uint64_t target = target_after(round, adaptive);
      if (Status status = iterate(target - placed_); !status) return status;
      if (placed_ == before && target > before) break;  // every gap is at the minimum
    }
    std::vector<SliceSamples> done;
    for (Working& slice : slices_) done.push_back(std::move(slice.samples));
    scatter_slices(done, sliced_);
    return ok_status();
  }

 protected:
  virtual Status start() = 0;
  /// How many adaptive samples there shall be after a round, counted from 1.
  [[nodiscard]] virtual std::uint64_t target_after(int round, std::uint64_t adaptive) const = 0;
  /// Measures the middles of the chosen gaps, which come by rising slice and position, into `values`.
  virtual Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) = 0;
  /// After samples were put into the chosen gaps of one slice: brings `probes` and `weights` up to date.
  virtual Status refresh(std::span<const Candidate> chosen) = 0;

  [[nodiscard]] bool may_split(const Slice& slice, const Gap& gap) const {
    return gap.middle.fraction != 0 && gap.width_deg * slice.gap_scale >= 2 * options_.minimum_gap_deg;
  }
  void map_values(const Slice& slice, Working& working) const {
    working.mapped.resize(working.samples.values.size());
    for (std::size_t s = 0; s < working.samples.size(); ++s) {
      map_.forward(coordinates_on(slice, working.samples.positions_deg[s]),
                   std::span(working.samples.values).subspan(s * channels_, channels_),
                   std::span(working.mapped).subspan(s * channels_, channels_));
    }
  }

  const Lattice& lattice_;
  const FrameGeometry& frame_;
  const Measure& measure_;
  const SamplingOptions& options_;
  SlicedBrdf& sliced_;
  std::size_t channels_;
  ResidualMap<double> map_;
  std::vector<Working> slices_;
  std::uint64_t placed_ = 0;

 private:
  Status measure_crossings() {
    std::vector<DirectionPair> pairs;
    for (const Coordinates& x : lattice_.crossings) pairs.push_back(frame_.directions(x));
    sliced_.crossing_values.resize(pairs.size() * channels_);
    return measure_(pairs, sliced_.crossing_values);
  }

  Status choose_domain() {
    sliced_.domain = {};
    if (options_.domain == DomainKind::kLog) {
      sliced_.domain = choose_log_domain(sliced_.crossing_values, channels_, options_.floor_halvings);
    }
    if (options_.guide_ratio > 0) {
      const std::size_t count = std::max<std::size_t>(lattice_.nodes[kVertical].size(), options_.sample_count / 20);
      Result<Guide> guide = fit_guide(sliced_, lattice_, options_.guide_ratio, count, measure_);
      if (!guide) return guide.error();
      sliced_.guide = *std::move(guide);
    }
    map_ = ResidualMap<double>(sliced_, lattice_);
    return ok_status();
  }

  Status iterate(std::uint64_t count) {
    std::vector<Candidate> chosen;
    for (std::uint32_t k = 0; k < slices_.size(); ++k) {
      for (std::uint32_t left = 0; left < slices_[k].weights.size(); ++left) {
        if (slices_[k].weights[left] >= 0) chosen.push_back({slices_[k].weights[left], k, left});
      }
    }
    if (chosen.size() > count) {
      const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(count);
      std::nth_element(chosen.begin(), end, chosen.end(), weighs_more);
      chosen.erase(end, chosen.end());
    }
    std::sort(chosen.begin(), chosen.end(), [](const Candidate& a, const Candidate& b) {
      return std::tuple(a.slice, a.left) < std::tuple(b.slice, b.left);
    });
    std::vector<float> values;
    if (Status status = measure_middles(chosen, values); !status) return status;
    for (std::size_t k = 0; k < chosen.size();) {
      std::size_t end = k;
      while (end < chosen.size() && chosen[end].slice == chosen[k].slice) ++end;
      merge(std::span(chosen).subspan(k, end - k), values.data() + k * channels_);
      k = end;
    }
    placed_ += chosen.size();
    return refresh(chosen);
  }

  void merge(std::span<const Candidate> chosen, const float* values) {
    const Slice& slice = lattice_.slices[chosen.front().slice];
    const SliceSamples& old = slices_[chosen.front().slice].samples;
    SliceSamples merged;
    std::size_t next = 0;
    const auto append = [&](double position, const SamplePosition& place, const float* value) {
      merged.positions_deg.push_back(position);
      merged.places.push_back(place);
      merged.values.insert(merged.values.end(), value, value + channels_);
    };
    for (std::size_t s = 0; s < old.size(); ++s) {
      append(old.positions_deg[s], old.places[s], old.values.data() + s * channels_);
      if (next < chosen.size() && chosen[next].left == s) {
        const Gap gap = gap_after(lattice_, slice, old, s);
        append(gap.middle_deg, gap.middle, values + next * channels_);
        ++next;
      }
    }
    slices_[chosen.front().slice].samples = std::move(merged);
  }
};

/// Algorithm 1: a gap weighs the larger leave-one-out error of its two ends.
class MeasuredSampler final : public Sampler {
 public:
  using Sampler::Sampler;

 private:
  Status start() override {
    for (std::uint32_t k = 0; k < slices_.size(); ++k) weigh(k);
    return ok_status();
  }

  std::uint64_t target_after(int round, std::uint64_t adaptive) const override {
    const double first = std::min<double>(round, options_.first_rounds) / std::max(1, options_.first_rounds);
    const double second = std::clamp<double>(round - options_.first_rounds, 0, options_.second_rounds) /
                          std::max(1, options_.second_rounds);
    const double share = options_.first_share * first + (1 - options_.first_share) * second;
    return static_cast<std::uint64_t>(std::llround(share * static_cast<double>(adaptive)));
  }

  Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) override {
    std::vector<DirectionPair> pairs;
    for (const Candidate& candidate : chosen) {
      const Slice& slice = lattice_.slices[candidate.slice];
      const Gap gap = gap_after(lattice_, slice, slices_[candidate.slice].samples, candidate.left);
      pairs.push_back(frame_.directions(coordinates_on(slice, gap.middle_deg)));
    }
    values.resize(pairs.size() * channels_);
    return measure_(pairs, values);
  }

  Status refresh(std::span<const Candidate> chosen) override {
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      if (k == 0 || chosen[k].slice != chosen[k - 1].slice) weigh(chosen[k].slice);
    }
    return ok_status();
  }

  void weigh(std::uint32_t k) {
    Working& working = slices_[k];
    const Slice& slice = lattice_.slices[k];
    map_values(slice, working);
    const std::size_t n = working.samples.size();
    std::vector<double> errors(n, 0);
    for (std::size_t s = 0; s < n && n > 1; ++s) errors[s] = leave_one_out(slice, working, s);
    working.weights.assign(gap_count(slice, working.samples), -1);
    for (std::size_t left = 0; left < working.weights.size(); ++left) {
      if (!may_split(slice, gap_after(lattice_, slice, working.samples, left))) continue;
      working.weights[left] = std::max(errors[left], errors[left + 1 < n ? left + 1 : 0]);
    }
  }

  // Largest difference over the channels between a sample and the straight line through its neighbours. The ends of a
  // bounded slice have no error.
  [[nodiscard]] double leave_one_out(const Slice& slice, const Working& working, std::size_t s) const {
    const std::vector<double>& positions = working.samples.positions_deg;
    const std::size_t n = positions.size();
    const bool first = s == 0;
    const bool last = s + 1 == n;
    if ((first || last) && slice.boundary == Boundary::kBounded) return 0;
    const bool periodic = slice.boundary == Boundary::kPeriodic;
    const std::size_t before = first ? (periodic ? n - 1 : 1) : s - 1;
    const std::size_t after = last ? (periodic ? 0 : s - 1) : s + 1;
    double left = positions[s] - positions[before];
    double right = positions[after] - positions[s];
    if (first) left = periodic ? left + slice.length_deg : right;
    if (last) right = periodic ? right + slice.length_deg : left;
    const double t = left / (left + right);
    double worst = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double a = working.mapped[before * channels_ + c];
      const double b = working.mapped[after * channels_ + c];
      worst = std::max(worst, std::abs(a + t * (b - a) - working.mapped[s * channels_ + c]));
    }
    return worst;
  }
};

/// A gap weighs the error of the spline within it, times its width and the share of all directions that its slice
/// serves.
class TrueSampler final : public Sampler {
 public:
  using Sampler::Sampler;

 private:
  static constexpr std::size_t kProbes = 3;  // at 1/4, 1/2 and 3/4, so that halving a gap keeps its probes

  Status start() override {
    volume_.resize(slices_.size());
    std::vector<std::pair<std::uint32_t, std::size_t>> gaps;
    for (std::uint32_t k = 0; k < slices_.size(); ++k) {
      volume_[k] = volume_served(lattice_.slices[k]);
      const std::size_t count = gap_count(lattice_.slices[k], slices_[k].samples);
      slices_[k].probes.assign(count * kProbes * channels_, 0);
      for (std::size_t left = 0; left < count; ++left) gaps.emplace_back(k, left);
    }
    std::vector<DirectionPair> pairs;
    for (const auto& [k, left] : gaps) {
      const Gap gap = gap_after(lattice_, lattice_.slices[k], slices_[k].samples, left);
      for (std::size_t p = 0; p < kProbes; ++p) pairs.push_back(probe_at(k, left, gap, p));
    }
    std::vector<float> values(pairs.size() * channels_);
    if (Status status = measure_(pairs, values); !status) return status;
    const float* next = values.data();
    for (Working& working : slices_) {
      std::copy(next, next + working.probes.size(), working.probes.begin());
      next += working.probes.size();
    }
    for (std::uint32_t k = 0; k < slices_.size(); ++k) weigh(k);
    return ok_status();
  }

  // Each round places an eighth of what is left, so that later ones see the splines that earlier ones made.
  std::uint64_t target_after(int /*round*/, std::uint64_t adaptive) const override {
    const std::uint64_t left = adaptive - placed_;
    return placed_ + std::min(left, std::max<std::uint64_t>(left / 8, 1 + adaptive / 100));
  }

  // The middle probe of a gap is the new sample.
  Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) override {
    for (const Candidate& candidate : chosen) {
      const float* probe = slices_[candidate.slice].probes.data() + (candidate.left * kProbes + 1) * channels_;
      values.insert(values.end(), probe, probe + channels_);
    }
    return ok_status();
  }

  Status refresh(std::span<const Candidate> chosen) override {
    std::vector<DirectionPair> pairs;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const std::size_t first = k - rank_in_slice(chosen, k);
      const std::size_t left = chosen[k].left + (k - first);
      for (std::size_t child = 0; child < 2; ++child) {
        const Gap gap =
            gap_after(lattice_, lattice_.slices[chosen[k].slice], slices_[chosen[k].slice].samples, left + child);
        pairs.push_back(probe_at(chosen[k].slice, left + child, gap, 0));
        pairs.push_back(probe_at(chosen[k].slice, left + child, gap, 2));
      }
    }
    std::vector<float> values(pairs.size() * channels_);
    if (Status status = measure_(pairs, values); !status) return status;
    for (std::size_t k = 0; k < chosen.size();) {
      std::size_t end = k;
      while (end < chosen.size() && chosen[end].slice == chosen[k].slice) ++end;
      split_probes(chosen.subspan(k, end - k), values.data() + k * 4 * channels_);
      weigh(chosen[k].slice);
      k = end;
    }
    return ok_status();
  }

  [[nodiscard]] static std::size_t rank_in_slice(std::span<const Candidate> chosen, std::size_t k) {
    std::size_t rank = 0;
    while (rank < k && chosen[k - rank - 1].slice == chosen[k].slice) ++rank;
    return rank;
  }

  void split_probes(std::span<const Candidate> chosen, const float* values) {
    std::vector<float>& probes = slices_[chosen.front().slice].probes;
    std::vector<float> next;
    const std::size_t per_gap = kProbes * channels_;
    std::size_t done = 0;
    for (std::size_t gap = 0; gap * per_gap < probes.size(); ++gap) {
      const float* old = probes.data() + gap * per_gap;
      if (done == chosen.size() || chosen[done].left != gap) {
        next.insert(next.end(), old, old + per_gap);
        continue;
      }
      for (std::size_t child = 0; child < 2; ++child) {
        const float* fresh = values + (done * 2 + child) * 2 * channels_;
        next.insert(next.end(), fresh, fresh + channels_);
        const float* kept = old + 2 * child * channels_;
        next.insert(next.end(), kept, kept + channels_);
        next.insert(next.end(), fresh + channels_, fresh + 2 * channels_);
      }
      ++done;
    }
    probes = std::move(next);
  }

  [[nodiscard]] DirectionPair probe_at(std::uint32_t k, std::size_t left, const Gap& gap, std::size_t probe) const {
    const double position = slices_[k].samples.positions_deg[left] + gap.width_deg * static_cast<double>(probe + 1) / 4;
    return frame_.directions(coordinates_on(lattice_.slices[k], position));
  }

  void weigh(std::uint32_t k) {
    Working& working = slices_[k];
    const Slice& slice = lattice_.slices[k];
    map_values(slice, working);
    second_.resize(working.mapped.size());
    for (std::size_t c = 0; c < channels_; ++c) {
      solver_.solve(slice.boundary, slice.length_deg, working.samples.positions_deg, working.mapped.data() + c,
                    second_.data() + c, channels_);
    }
    const std::size_t n = working.samples.size();
    working.weights.assign(gap_count(slice, working.samples), -1);
    for (std::size_t left = 0; left < working.weights.size(); ++left) {
      const Gap gap = gap_after(lattice_, slice, working.samples, left);
      if (!may_split(slice, gap)) continue;
      const double error = error_in_gap(slice, working, left, left + 1 < n ? left + 1 : 0, gap.width_deg);
      working.weights[left] = error * gap.width_deg * volume_[k];
    }
  }

  [[nodiscard]] double error_in_gap(const Slice& slice, const Working& working, std::size_t left, std::size_t right,
                                    double width) {
    double sum = 0;
    residual_.resize(channels_);
    for (std::size_t p = 0; p < kProbes; ++p) {
      const double t = static_cast<double>(p + 1) / 4;
      const auto probe = std::span(working.probes).subspan((left * kProbes + p) * channels_, channels_);
      map_.forward(coordinates_on(slice, working.samples.positions_deg[left] + t * width), probe, residual_);
      for (std::size_t c = 0; c < channels_; ++c) {
        const double spline = evaluate_segment(t, width * width / 6, working.mapped[left * channels_ + c],
                                               working.mapped[right * channels_ + c], second_[left * channels_ + c],
                                               second_[right * channels_ + c]);
        sum += std::abs(spline - residual_[c]) * value_weight(c, probe[c]);
      }
    }
    return sum;
  }

  // An error in the log domain is relative: f times as large in f_r.
  [[nodiscard]] double value_weight(std::size_t c, float f) const {
    const bool log = sliced_.domain.kind == DomainKind::kLog;
    const double least = log ? sliced_.domain.floor[c] : 1e-9;
    return std::pow(std::max<double>(std::abs(f), least), options_.value_exponent - (log ? 0 : 1));
  }

  // Half the neighbouring cells on each other axis, times how dense directions lie there.
  [[nodiscard]] double volume_served(const Slice& slice) const {
    double volume = 1;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double>& nodes = lattice_.nodes[axis];
      if (axis == slice.kind || nodes.size() < 2) continue;
      volume *= frame_.share_served(axis, nodes, slice.fixed[axis]);
    }
    return volume;
  }

  std::vector<double> volume_;
  std::vector<double> second_;
  std::vector<double> residual_;
  SplineSolver<double> solver_;
};

}  // namespace

Result<SlicedBrdf> sample_slices(const Lattice& lattice, std::vector<std::string> channels, const Measure& measure,
                                 const SamplingOptions& options) {
  if (options.sample_count < lattice.crossings.size()) {
    return Error{ErrorCode::kUsage,
                 std::to_string(options.sample_count) + " samples are fewer than the " +
                     std::to_string(lattice.crossings.size()) + " crossings of this placement",
                 {}};
  }
  SlicedBrdf sliced;
  sliced.frame = lattice.spec;
  sliced.channels = std::move(channels);
  const Status status = options.refinement == Refinement::kMeasured
                            ? MeasuredSampler(lattice, measure, options, sliced).run()
                            : TrueSampler(lattice, measure, options, sliced).run();
  if (!status) return status.error();
  return sliced;
}

}  // namespace sbrdf
