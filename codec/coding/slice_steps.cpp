#include "codec/coding/slice_steps.h"

#include <array>
#include <span>

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

/// A stencil on its way, with the positions of its members.
struct SliceSteps::Members {
  Stencil stencil;
  std::array<double, 4> positions{};

  void take(std::uint32_t member, double position) {
    positions[stencil.count] = position;
    stencil.member[stencil.count++] = member;
  }
};

// The first crossing is sample 0: going over it is one turn.
void SliceSteps::take_periodic(std::uint32_t left, Members& members) const {
  const std::uint32_t right = samples[left].after;
  const std::uint32_t before = samples[left].before;
  const std::uint32_t behind = samples[right].after;
  const double turn = right == 0 ? length_deg : 0;
  members.take(before, samples[before].position_deg - (left == 0 ? length_deg : 0));
  members.take(left, samples[left].position_deg);
  members.take(right, samples[right].position_deg + turn);
  members.take(behind, samples[behind].position_deg + (behind == 0 ? turn + length_deg : turn));
}

// Beyond an end, a mirrored slice has the image of what lies as far before it.
void SliceSteps::take_ended(std::uint32_t left, Members& members) const {
  const bool mirrored = boundary != Boundary::kBounded;
  const std::uint32_t right = samples[left].after;
  const std::uint32_t before = samples[left].before;
  const std::uint32_t behind = samples[right].after;
  const double left_deg = samples[left].position_deg;
  const double right_deg = samples[right].position_deg;
  if (before != kNone) {
    members.take(before, samples[before].position_deg);
  } else if (mirrored) {
    members.take(right, 2 * left_deg - right_deg);
  }
  members.take(left, left_deg);
  members.take(right, right_deg);
  if (behind != kNone) {
    members.take(behind, samples[behind].position_deg);
  } else if (mirrored) {
    members.take(left, 2 * right_deg - left_deg);
  }
}

Stencil SliceSteps::stencil_around(std::uint32_t left, double at) const {
  Members members;
  boundary == Boundary::kPeriodic ? take_periodic(left, members) : take_ended(left, members);
  set_weights(members.stencil, std::span(members.positions).first(members.stencil.count), at);
  return members.stencil;
}

}  // namespace sbrdf::internal
