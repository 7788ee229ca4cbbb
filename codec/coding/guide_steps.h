#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/coding/quantizer.h"
#include "codec/coding/sample_coder.h"
#include "codec/material/value_map.h"

namespace sbrdf::internal {

// How a guide is coded, and what it does to the steps of samples. specs/sbrdf.md, section 7.
//
// A guide g(theta_h) is a number of the log domain, log f + const; steps are logarithms too, steps_per_octave / log 2
// of them to a unit. So slices, which hold f / e^g where a guide is used, differ from f by round(g steps_per_octave /
// log 2) steps. What is coded is that difference, where it can be computed with the same bits everywhere.

/// Guides are numbers of the value domain, where steps are equal: a power of two in a bounded file, the bits in a
/// lossless one.
[[nodiscard]] std::int32_t guide_step(const Quantizer& scale, float value);
[[nodiscard]] float guide_value(const Quantizer& scale, std::int32_t step);

/// The guide in steps, which prediction takes off. Only for a ratio of 1: other angles need functions whose last bit
/// differs from machine to machine.
class GuideSteps {
 public:
  GuideSteps(const Guide& guide, const Lattice& lattice, std::size_t channels, const Quantizer& scale);

  /// One step per channel, of a sample at x. The two cancel each other, bit for bit.
  void take_off(const Coordinates& x, std::span<std::int32_t> steps) { shift(x, steps, ~0U); }
  void put_back(const Coordinates& x, std::span<std::int32_t> steps) { shift(x, steps, 0); }

 private:
  void shift(const Coordinates& x, std::span<std::int32_t> steps, std::uint32_t negated);
  void find_offsets(double theta_h_deg);

  bool active_ = false;
  double steps_per_unit_ = 0;
  GuideCurve<double> curve_;
  // Of the sample before: those of a slice along another axis share them.
  double theta_h_deg_ = -1;
  std::vector<double> guide_;
  std::vector<std::uint32_t> offsets_;
};

/// Makes `state` the slice as it is before its first sample: its crossings.
void begin_slice(const Lattice& lattice, const Slice& slice, const StepTable& crossings, SliceSteps& state);
/// The guide as one more slice, along axis 3.
void begin_guide(const Lattice& lattice, const StepTable& nodes, SliceSteps& state);

/// The guide's values at its nodes, each predicted by the one before.
template <class Io>
void code_guide_nodes(Io& io, const CodingParameters& coding, std::size_t node_count, StepTable& nodes) {
  for (std::size_t k = 0; k < node_count && io.ok(); ++k) {
    Stencil stencil;
    if (k > 0) stencil = {{static_cast<std::uint32_t>(k - 1)}, {1.0}, 1};
    code_sample(io, coding, {stencil, 0}, kGuideNodeContexts, nodes, k);
  }
}

}  // namespace sbrdf::internal
