#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/slice_samples.h"
#include "codec/material/value_map.h"
#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf {

// The inside of adaptive_sampling.h: what the ways of refinement have in common.

/// A gap that may be halved.
struct Candidate {
  double weight = 0;
  std::uint32_t slice = 0;
  std::uint32_t left = 0;  ///< the sample before the gap
};

/// A slice while it is sampled.
struct Working {
  SliceSamples samples;
  std::vector<double> mapped;   ///< values in the value domain, channel fastest
  std::vector<double> weights;  ///< per gap; negative where it must stay whole
  std::vector<float> probes;    ///< kBySource: per gap, the source at some places within
};

/// Rounds that halve the heaviest gaps of all slices. What a gap weighs is the derived class' affair.
class Sampler {
 public:
  Sampler(const Lattice& lattice, const Measure& measure, const SamplingOptions& options, SlicedBrdf& sliced);
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;
  virtual ~Sampler() = default;

  /// Fills `sliced`, whose frame and channels are set. The Measure's errors.
  Status run();

 protected:
  /// Before the first round: weighs the gaps between crossings.
  virtual Status start() = 0;
  /// How many adaptive samples there shall be after a round, counted from 1.
  [[nodiscard]] virtual std::uint64_t target_after(int round, std::uint64_t adaptive) const = 0;
  /// Measures the middles of the chosen gaps, which come by rising slice and position, into `values`.
  virtual Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) = 0;
  /// After samples were put into the chosen gaps: brings `probes` and `weights` up to date.
  virtual Status refresh(std::span<const Candidate> chosen) = 0;

  [[nodiscard]] bool may_split(const Slice& slice, const Gap& gap) const;
  /// Brings `mapped` up to date with the samples.
  void map_values(const Slice& slice, Working& working) const;

  const Lattice& lattice_;
  const FrameGeometry& frame_;
  const Measure& measure_;
  const SamplingOptions& options_;
  SlicedBrdf& sliced_;
  std::size_t channels_;
  ValueMap<double> map_;
  std::vector<Working> slices_;
  std::uint64_t placed_ = 0;

 private:
  Status measure_crossings();
  Status choose_domain();
  Status iterate(std::uint64_t count);
  void merge(std::span<const Candidate> chosen, const float* values);
};

/// Refinement::kByMeasured and kBySource. `sliced` as for Sampler::run.
Status sample_by_measured_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                                SlicedBrdf& sliced);
Status sample_by_true_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                            SlicedBrdf& sliced);

}  // namespace sbrdf
