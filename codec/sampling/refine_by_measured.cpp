#include <algorithm>
#include <cmath>

#include "codec/sampling/sampler.h"

namespace sbrdf::internal {
namespace {

/// Algorithm 1: a gap weighs the larger leave-one-out error of its two ends.
class RefineByMeasured final : public Sampler {
 public:
  using Sampler::Sampler;

 private:
  Status start() override {
    for_all(slices_.size(), kSlicesPerTask, [&](std::size_t k) { weigh(static_cast<std::uint32_t>(k)); });
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
    std::vector<DirectionPair> pairs(chosen.size());
    for_all(chosen.size(), kPairsPerTask, [&](std::size_t k) {
      const Slice& slice = lattice_.slices[chosen[k].slice];
      const Gap gap = gap_after(lattice_, slice, slices_[chosen[k].slice].samples, chosen[k].left);
      pairs[k] = directions_at(lattice_.spec, coordinates_on(slice, gap.middle_deg));
    });
    values.resize(pairs.size() * channels_);
    return measure_(pairs, values);
  }

  Status refresh(std::span<const Candidate> chosen) override {
    for_each_slice(chosen, [&](std::span<const Candidate> run, std::size_t) { weigh(run.front().slice); });
    return ok_status();
  }

  void weigh(std::uint32_t k) {
    Working& working = slices_[k];
    const Slice& slice = lattice_.slices[k];
    map_.forward(slice, working.samples, working.mapped);
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

}  // namespace

Status sample_by_measured_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                                SlicedBrdf& sliced) {
  return RefineByMeasured(lattice, measure, options, sliced).run();
}

}  // namespace sbrdf::internal
