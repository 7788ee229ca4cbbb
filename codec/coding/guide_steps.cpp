#include "codec/coding/guide_steps.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr double kOctavesPerUnit = 1.4426950408889634;  // 1 / log 2
constexpr std::int64_t kMostGuideSteps = 1 << 24;

// Half to a quarter of a step of the samples: what a guide is off is made good where samples lie.
double size_of_guide_step(const Quantizer& scale) {
  return std::ldexp(1.0, -1 - static_cast<int>(std::bit_width(scale.per_octave())));
}

}  // namespace

std::int32_t guide_step(const Quantizer& scale, float value) {
  if (scale.lossless()) return scale.step(value);
  const double steps = std::clamp(static_cast<double>(value) / size_of_guide_step(scale), -16777215.0, 16777215.0);
  return static_cast<std::int32_t>(std::floor(steps + 0.5));
}

float guide_value(const Quantizer& scale, std::int32_t step) {
  return scale.lossless() ? scale.value(step) : static_cast<float>(step * size_of_guide_step(scale));
}

GuideSteps::GuideSteps(const Guide& guide, const Lattice& lattice, std::size_t channels, const Quantizer& scale)
    : active_(guide.ratio == 1),
      steps_per_unit_(scale.steps_per_octave() * kOctavesPerUnit),
      curve_(guide, lattice.nodes[kVertical], channels),
      guide_(channels),
      offsets_(channels) {}

void GuideSteps::find_offsets(double theta_h_deg) {
  theta_h_deg_ = theta_h_deg;
  curve_.evaluate_at(theta_h_deg, 0, guide_);
  for (std::size_t c = 0; c < guide_.size(); ++c) {
    const double wanted = std::clamp(guide_[c] * steps_per_unit_, -1.0 * kMostGuideSteps, 1.0 * kMostGuideSteps);
    offsets_[c] = static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(wanted + 0.5)));
  }
}

// Modulo 2^32: taking off and putting back cancel whatever the step.
void GuideSteps::shift(const Coordinates& x, std::span<std::int32_t> steps, std::uint32_t negated) {
  if (!active_) return;
  if (x[kVertical] != theta_h_deg_) find_offsets(x[kVertical]);
  for (std::size_t c = 0; c < steps.size(); ++c) {
    const std::uint32_t offset = (offsets_[c] ^ negated) - negated;
    steps[c] = static_cast<std::int32_t>(static_cast<std::uint32_t>(steps[c]) + offset);
  }
}

void begin_slice(const Lattice& lattice, const Slice& slice, const StepTable& crossings, SliceSteps& state) {
  const auto nodes = lattice.nodes_of(slice);
  state.begin(slice.boundary, slice.length_deg, nodes.size());
  for (std::uint32_t k = 0; k < nodes.size(); ++k) {
    state.samples[k].position_deg = nodes[k].position_deg;
    state.table.copy(k, crossings, nodes[k].crossing);
  }
}

void begin_guide(const Lattice& lattice, const StepTable& nodes, SliceSteps& state) {
  const std::vector<double>& positions = lattice.nodes[kVertical];
  state.begin(Boundary::kBounded, 0, positions.size());
  for (std::uint32_t k = 0; k < positions.size(); ++k) {
    state.samples[k].position_deg = positions[k];
    state.table.copy(k, nodes, k);
  }
}

}  // namespace sbrdf::internal
