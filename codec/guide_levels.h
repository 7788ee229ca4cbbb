#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/level_scale.h"
#include "codec/residual_map.h"
#include "codec/sample_coder.h"

namespace sbrdf {

// How a guide is coded, and what it does to the levels of samples. specs/sbrdf.md, section 7.

/// Guides are numbers of the value domain, where steps are equal: 2^-11 in a bounded file, the bits in a lossless one.
[[nodiscard]] std::int32_t guide_level(const LevelScale& scale, float value);
[[nodiscard]] float guide_value(const LevelScale& scale, std::int32_t level);

/// The guide in levels, which prediction takes off. Only for a ratio of 1: other angles need functions whose last bit
/// differs from machine to machine.
class GuideLevels {
 public:
  GuideLevels(const Guide& guide, const Lattice& lattice, std::size_t channels, const LevelScale& scale);

  void take_off(const Coordinates& x, std::span<std::int32_t> levels) const { shift(x, levels, -1); }
  void put_back(const Coordinates& x, std::span<std::int32_t> levels) const { shift(x, levels, 1); }

 private:
  void shift(const Coordinates& x, std::span<std::int32_t> levels, std::int64_t sign) const;

  bool active_ = false;
  double levels_per_unit_ = 0;
  GuideCurve<double> curve_;
};

/// Makes `state` the slice as it is before its first sample: its crossings.
void begin_slice(const Lattice& lattice, const Slice& slice, const LevelTable& crossings, SliceLevels& state);
/// The guide as one more slice, along axis 3.
void begin_guide(const Lattice& lattice, const LevelTable& nodes, SliceLevels& state);

/// The guide's values at its nodes, each predicted by the one before.
template <class Io>
void code_guide_nodes(Io& io, const CodingParameters& coding, std::size_t node_count, LevelTable& nodes) {
  for (std::size_t k = 0; k < node_count && io.ok(); ++k) {
    Stencil stencil;
    if (k > 0) stencil = {{static_cast<std::uint32_t>(k - 1)}, {1.0}, 1};
    code_sample(io, coding, stencil, 0, nodes, k, CodingContext::kGuideNode, CodingContext::kGuideNode, false);
  }
}

}  // namespace sbrdf
