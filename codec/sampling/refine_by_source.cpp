#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/material/spline.h"
#include "codec/sampling/sampler.h"

namespace sbrdf {
namespace {

/// A gap weighs the error of the spline within it, times its width and the share of all directions that its slice
/// serves.
class RefineBySource final : public Sampler {
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

Status sample_by_true_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                            SlicedBrdf& sliced) {
  return RefineBySource(lattice, measure, options, sliced).run();
}

}  // namespace sbrdf
