#include "codec/coding/sample_coder.h"

namespace sbrdf::internal {

void SliceSteps::begin(Boundary new_boundary, double new_length_deg, std::size_t crossings) {
  boundary = new_boundary;
  length_deg = new_length_deg;
  samples.resize(crossings);
  for (std::uint32_t k = 0; k < crossings; ++k) samples[k] = {0, {k, 0}, k - 1, k + 1};
  const bool periodic = boundary == Boundary::kPeriodic;
  samples.front().before = periodic ? static_cast<std::uint32_t>(crossings - 1) : kNone;
  samples.back().after = periodic ? 0 : kNone;
  table.hold(crossings);
  newest = 0;
  depth = 0;
}

void SliceSteps::link(std::size_t first, int new_depth) {
  for (std::size_t k = first; k < samples.size(); ++k) {
    const auto own = static_cast<std::uint32_t>(k);
    Sample& sample = samples[k];
    sample.after = samples[sample.before].after;
    samples[sample.before].after = own;
    samples[sample.after].before = own;
  }
  newest = first;
  depth = new_depth;
}

Stencil SliceSteps::stencil_around(std::uint32_t left, double at) const {
  Stencil stencil;
  std::array<double, 4> positions{};
  const auto take = [&](std::uint32_t member, double position) {
    positions[stencil.count] = position;
    stencil.member[stencil.count++] = member;
  };
  const std::uint32_t right = samples[left].after;
  const std::uint32_t before = samples[left].before;
  const std::uint32_t behind = samples[right].after;
  const double left_deg = samples[left].position_deg;
  const double right_deg = samples[right].position_deg;
  if (boundary == Boundary::kPeriodic) {
    // The first crossing is sample 0: going over it is one turn.
    const double turn = right == 0 ? length_deg : 0;
    take(before, samples[before].position_deg - (left == 0 ? length_deg : 0));
    take(left, left_deg);
    take(right, right_deg + turn);
    take(behind, samples[behind].position_deg + (behind == 0 ? turn + length_deg : turn));
  } else {
    const bool mirrored = boundary != Boundary::kBounded;
    if (before != kNone) {
      take(before, samples[before].position_deg);
    } else if (mirrored) {
      take(right, 2 * left_deg - right_deg);
    }
    take(left, left_deg);
    take(right, right_deg);
    if (behind != kNone) {
      take(behind, samples[behind].position_deg);
    } else if (mirrored) {
      take(left, 2 * right_deg - left_deg);
    }
  }
  set_weights(stencil, std::span(positions).first(stencil.count), at);
  return stencil;
}

}  // namespace sbrdf::internal
