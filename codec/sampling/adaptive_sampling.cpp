#include "codec/sampling/adaptive_sampling.h"

#include <utility>

#include "codec/sampling/sampler.h"

namespace sbrdf::internal {

Result<SlicedBrdf> sample_slices(const Lattice& lattice, std::vector<std::string> channels, const Measure& measure,
                                 const SamplingOptions& options) {
  if (options.sample_count < lattice.crossings.size()) {
    return usage_error(std::to_string(options.sample_count) + " samples are fewer than the " +
                       std::to_string(lattice.crossings.size()) + " crossings of this placement");
  }
  SlicedBrdf sliced;
  sliced.frame = lattice.spec;
  sliced.channels = std::move(channels);
  sliced.grey_shares = options.grey_shares;
  const Measure measure_stored = [&](std::span<const DirectionPair> pairs, std::span<float> values) {
    const Status status = measure(pairs, values);
    if (status) options.grey_shares.add(values);
    return status;
  };
  const Status status = options.refinement == Refinement::kByMeasured
                            ? sample_by_measured_error(lattice, measure_stored, options, sliced)
                            : sample_by_true_error(lattice, measure_stored, options, sliced);
  if (!status) return status.error();
  return sliced;
}

}  // namespace sbrdf::internal
