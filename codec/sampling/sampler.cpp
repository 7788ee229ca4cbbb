#include "codec/sampling/sampler.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "codec/sampling/guide_fit.h"

namespace sbrdf::internal {
namespace {

// A total order, so that the chosen set does not depend on how it is selected.
bool weighs_more(const Candidate& a, const Candidate& b) {
  if (a.weight != b.weight) return a.weight > b.weight;
  return std::tuple(a.slice, a.left) < std::tuple(b.slice, b.left);
}

}  // namespace

Sampler::Sampler(const Lattice& lattice, const Measure& measure, const SamplingOptions& options, SlicedBrdf& sliced)
    : lattice_(lattice),
      frame_(geometry(lattice.spec.id)),
      measure_(measure),
      options_(options),
      sliced_(sliced),
      channels_(sliced.channel_count()) {}

Status Sampler::run() {
  if (Status status = measure_crossings(); !status) return status;
  if (Status status = choose_domain(); !status) return status;
  sliced_.sample_counts.assign(lattice_.slices.size(), 0);
  std::vector<SliceSamples> samples = gather_slices(sliced_, lattice_);
  slices_.resize(samples.size());
  for (std::size_t k = 0; k < slices_.size(); ++k) slices_[k].samples = std::move(samples[k]);
  if (Status status = start(); !status) return status;
  if (Status status = refine(); !status) return status;
  std::vector<SliceSamples> done;
  for (Working& slice : slices_) done.push_back(std::move(slice.samples));
  scatter_slices(done, sliced_);
  return ok_status();
}

Status Sampler::refine() {
  const std::uint64_t spent = lattice_.crossings.size() + sliced_.guide_count();
  const std::uint64_t adaptive = options_.sample_count - std::min(spent, options_.sample_count);
  for (int round = 1; placed_ < adaptive; ++round) {
    const std::uint64_t before = placed_;
    const std::uint64_t target = target_after(round, adaptive);
    if (Status status = halve_heaviest(target - placed_); !status) return status;
    if (placed_ == before && target > before) break;  // every gap is at the minimum
  }
  return ok_status();
}

bool Sampler::may_split(const Slice& slice, const Gap& gap) const {
  return gap.middle.fraction != 0 && gap.width_deg * slice.gap_scale >= 2 * options_.minimum_gap_deg;
}

Status Sampler::measure_crossings() {
  std::vector<DirectionPair> pairs(lattice_.crossings.size());
  for_all(pairs.size(), kPairsPerTask,
          [&](std::size_t k) { pairs[k] = directions_at(lattice_.spec, lattice_.crossings[k]); });
  sliced_.crossing_values.resize(pairs.size() * channels_);
  return measure_(pairs, sliced_.crossing_values);
}

Status Sampler::choose_domain() {
  sliced_.domain = {};
  if (options_.domain == DomainKind::kLog) {
    sliced_.domain = choose_log_domain(sliced_.crossing_values, channels_, options_.floor_halvings);
  }
  if (options_.guide_ratio) {
    const std::size_t count = std::max<std::size_t>(lattice_.nodes[kVertical].size(), options_.sample_count / 20);
    Result<Guide> guide = fit_guide(sliced_, lattice_, *options_.guide_ratio, count, measure_);
    if (!guide) return guide.error();
    sliced_.guide = *std::move(guide);
  }
  map_ = ValueMap<double>(sliced_, lattice_);
  return ok_status();
}

// At most `count` gaps, by rising slice and position.
std::vector<Candidate> Sampler::heaviest(std::uint64_t count) const {
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
  return chosen;
}

Status Sampler::halve_heaviest(std::uint64_t count) {
  const std::vector<Candidate> chosen = heaviest(count);
  std::vector<float> values;
  if (Status status = measure_middles(chosen, values); !status) return status;
  for_each_slice(chosen, [&](std::span<const Candidate> run, std::size_t first) {
    merge(run, std::span(values).subspan(first * channels_, run.size() * channels_));
  });
  placed_ += chosen.size();
  return refresh(chosen);
}

// Puts one row of `values` into each of the chosen gaps of one slice. All are put in together: each alone would move
// the samples behind it, which takes quadratic time.
void Sampler::merge(std::span<const Candidate> chosen, std::span<const float> values) {
  const Slice& slice = lattice_.slices[chosen.front().slice];
  const SliceSamples& old = slices_[chosen.front().slice].samples;
  SliceSamples merged;
  const auto append = [&](double position, const SamplePosition& place, std::span<const float> row) {
    merged.positions_deg.push_back(position);
    merged.places.push_back(place);
    merged.values.insert(merged.values.end(), row.begin(), row.end());
  };
  std::size_t next = 0;
  for (std::size_t s = 0; s < old.size(); ++s) {
    append(old.positions_deg[s], old.places[s], std::span(old.values).subspan(s * channels_, channels_));
    if (next < chosen.size() && chosen[next].left == s) {
      const Gap gap = gap_after(lattice_, slice, old, s);
      append(gap.middle_deg, gap.middle, values.subspan(next * channels_, channels_));
      ++next;
    }
  }
  slices_[chosen.front().slice].samples = std::move(merged);
}

}  // namespace sbrdf::internal
