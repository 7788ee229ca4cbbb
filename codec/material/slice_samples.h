#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// All samples of one slice, crossings included, by rising position: what a file keeps apart (crossings are shared by
/// slices) put together for a spline.
struct SliceSamples {
  std::vector<double> positions_deg;   ///< along the slice, from Slice::start_deg on
  std::vector<SamplePosition> places;  ///< the same as the file has it; fraction 0 marks a crossing
  std::vector<float> values;           ///< f_r [1/sr], channel fastest

  [[nodiscard]] std::size_t size() const { return positions_deg.size(); }
};

/// The gap after sample `left` of a slice: to the next one, or for the last sample of a periodic slice to the first.
struct Gap {
  double width_deg = 0;
  SamplePosition middle;  ///< fraction 0 when it cannot be halved any more
  double middle_deg = 0;  ///< position of the middle; 0 when there is none
};

/// Where a place lies on its slice; fraction 0 is the crossing at which the interval begins.
[[nodiscard]] double position_deg(const Lattice& lattice, const Slice& slice, const SamplePosition& place);

/// Gaps between samples: as many as samples on a periodic slice, one less on others.
[[nodiscard]] std::size_t gap_count(const Slice& slice, const SliceSamples& samples);
/// `left` is below gap_count.
[[nodiscard]] Gap gap_after(const Lattice& lattice, const Slice& slice, const SliceSamples& samples, std::size_t left);

/// The samples of one slice, into `samples`; `first` is the number of its first one in SlicedBrdf::positions.
void gather_slice(const SlicedBrdf& sliced, const Lattice& lattice, std::size_t slice, std::size_t first,
                  SliceSamples& samples);
/// The samples of every slice of a sliced BRDF, which must have passed check_sliced, by number of the slice.
[[nodiscard]] std::vector<SliceSamples> gather_slices(const SlicedBrdf& sliced, const Lattice& lattice);

/// The inverse: writes counts, positions and values of the samples that are not crossings.
void scatter_slices(std::span<const SliceSamples> slices, SlicedBrdf& sliced);

}  // namespace sbrdf::internal
