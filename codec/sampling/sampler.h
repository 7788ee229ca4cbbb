#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/slice_samples.h"
#include "codec/material/value_map.h"
#include "codec/sampling/adaptive_sampling.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {

// The inside of adaptive_sampling.h: what the ways of refinement have in common.

/// A gap between samples that may be halved.
struct Candidate {
  double weight = 0;        ///< not negative; the heaviest are halved first
  std::uint32_t slice = 0;  ///< its number in the lattice
  std::uint32_t left = 0;   ///< the sample before the gap
};

/// A slice while it is sampled. Gap k lies behind sample k; a periodic slice has as many gaps as samples, others one
/// less.
struct Working {
  SliceSamples samples;
  std::vector<double> mapped;   ///< what the slice interpolates at its samples (see ValueMap), channel fastest
  std::vector<double> weights;  ///< per gap; negative where it must stay whole
  std::vector<float> probes;    ///< kBySource: f_r at some places within each gap, gap by gap, channel fastest
};

/// So many slices or directions are a task for a thread: fewer take no longer than handing them out.
constexpr std::size_t kSlicesPerTask = 16;
constexpr std::size_t kPairsPerTask = 256;

/// Calls `visit(run, first)` for the candidates of each slice, which come together, on all cores; `first` is the index
/// of the first.
template <class Visit>
void for_each_slice(std::span<const Candidate> chosen, const Visit& visit) {
  std::vector<std::size_t> starts;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (k == 0 || chosen[k].slice != chosen[k - 1].slice) starts.push_back(k);
  }
  parallel_blocks(starts.size(), kSlicesPerTask, [&](std::size_t begin, std::size_t size) {
    for (std::size_t run = begin; run < begin + size; ++run) {
      const std::size_t end = run + 1 < starts.size() ? starts[run + 1] : chosen.size();
      visit(chosen.subspan(starts[run], end - starts[run]), starts[run]);
    }
  });
}

/// Rounds that halve the heaviest gaps of all slices. What a gap weighs is the derived class' affair.
class Sampler {
 public:
  /// All arguments must outlive this.
  Sampler(const Lattice& lattice, const Measure& measure, const SamplingOptions& options, SlicedBrdf& sliced);
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;
  virtual ~Sampler() = default;

  /// Fills `sliced`, whose frame and channels are set: crossings, domain and guide first, then round by round until all
  /// samples are placed or no gap may be halved. The Measure's errors.
  Status run();

 protected:
  /// Before the first round: weighs the gaps between crossings.
  virtual Status start() = 0;
  /// How many adaptive samples of `adaptive` there shall be after a round, counted from 1. Not fewer than there are.
  [[nodiscard]] virtual std::uint64_t target_after(int round, std::uint64_t adaptive) const = 0;
  /// Measures the middles of the chosen gaps, which come by rising slice and position, into `values`: one row per gap.
  virtual Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) = 0;
  /// After samples were put into the chosen gaps: brings `probes` and `weights` up to date. `left` counts samples as
  /// they were before.
  virtual Status refresh(std::span<const Candidate> chosen) = 0;

  /// Whether a gap is wide enough, and not yet at the last halving that a position can hold.
  [[nodiscard]] bool may_split(const Slice& slice, const Gap& gap) const;

  const Lattice& lattice_;
  const FrameGeometry& frame_;
  const Measure& measure_;
  const SamplingOptions& options_;
  SlicedBrdf& sliced_;
  std::size_t channels_;
  ValueMap<double> map_;         ///< once the domain is chosen
  std::vector<Working> slices_;  ///< by number of slice
  std::uint64_t placed_ = 0;     ///< adaptive samples so far

 private:
  Status measure_crossings();
  Status choose_domain();
  Status refine();
  Status halve_heaviest(std::uint64_t count);
  [[nodiscard]] std::vector<Candidate> heaviest(std::uint64_t count) const;
  void merge(std::span<const Candidate> chosen, std::span<const float> values);
};

/// Refinement::kByMeasured. `sliced` as for Sampler::run.
Status sample_by_measured_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                                SlicedBrdf& sliced);
/// Refinement::kBySource.
Status sample_by_true_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                            SlicedBrdf& sliced);

}  // namespace sbrdf::internal
