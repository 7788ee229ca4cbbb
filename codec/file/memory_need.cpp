#include "codec/file/memory_need.h"

#include <algorithm>

namespace sbrdf::internal {
namespace {

constexpr double kGrowth = 2;  // of a table that is filled without knowing its length

double count_of(std::size_t count) { return static_cast<double>(count); }

// A row of steps and one of residuals, as StepTable holds them.
double row_bytes(std::size_t channels) {
  return count_of((channels + StepTable::kGroup - 1) / StepTable::kGroup * StepTable::kGroup) * 2 *
         sizeof(std::int32_t);
}

// The nodes of an azimuth with its turn closed, once or twice round.
double padded_count(const FrameSpec& frame, std::size_t axis) {
  const FrameGeometry& frame_geometry = geometry(frame.id);
  const double nodes = count_of(frame.axes[axis].nodes_deg.size());
  const double period = frame_geometry.node_period(axis);
  if (!(period > 0) || nodes == 1) return nodes;
  const bool two_turns = axis == kAxial && frame_geometry.line_period(axis, frame.symmetries) > period;
  return two_turns ? 2 * nodes + 1 : nodes + 1;
}

}  // namespace

double memory_of_index(std::size_t index_size) {
  constexpr double kCopies = 4;
  constexpr double kChunkSize = kGrowth * sizeof(std::uint32_t);
  constexpr double kOffset = kGrowth * sizeof(std::uint64_t);
  return (kCopies + kChunkSize + kOffset) * count_of(index_size);
}

double memory_of_metadata(const SlicedIndex& index) {
  constexpr double kCopies = 3;
  constexpr double kEscape = 6;  // \u0000
  return kGrowth * (kCopies + kEscape) * index.metadata_size;
}

double memory_of_mask(const SlicedIndex& index) {
  constexpr double kCopies = 2;
  if (!index.mask) return 0;
  return kCopies * index.mask_size + static_cast<double>(index.mask->cell_count()) / 8;
}

double memory_of_lattice(const FrameSpec& frame) {
  // Most of a point's share are the slices that pass it: with each their crossing and its position.
  constexpr double kPoint = 128;
  // Azimuths are folded once for each of up to 12 kinds of polar pairs.
  constexpr double kAzimuths = 320;
  const double azimuths = padded_count(frame, kAxial) * padded_count(frame, kDiagonal);
  const double polar = padded_count(frame, kHorizontal) * padded_count(frame, kVertical);
  constexpr double kMostPoints = 1 << 21;  // a larger one is refused before it takes anything
  if (azimuths * polar > kMostPoints) return 0;
  return azimuths * (kPoint * polar + kAzimuths);
}

double memory_of_samples(const SlicedIndex& index, const Lattice& lattice) {
  const double channels = count_of(index.channels.size());
  const double values = channels * sizeof(float);
  double lines = 0;
  for (const auto& axis : lattice.lines) lines += count_of(axis.size());
  // The evaluator has the corners and the lines once more.
  const double tables = 2 * (count_of(lattice.corners.size()) * sizeof(std::uint32_t) + lines * sizeof(LineReference));
  const double crossings = count_of(lattice.crossings.size());
  const double slices = count_of(lattice.slices.size());
  const double samples = count_of(index.adaptive_count) + count_of(index.guide_count);
  const double nodes = count_of(lattice.slice_nodes.size());

  constexpr double kPlanned = 160;  // the order of coding, with what each is predicted from
  const double crossing = sizeof(Coordinates) + kPlanned + row_bytes(index.channels.size()) + (1 + kGrowth) * values;
  constexpr double kCurve = 64;  // of the evaluator
  const double slice = sizeof(Slice) + kGrowth * kCurve;
  const double sample = kGrowth * (sizeof(SamplePosition) + values);
  // Every sample, and every crossing once for each slice that it lies on: gathered by slice, then as a knot with its
  // second derivative.
  const double gathered = sizeof(double) + sizeof(SamplePosition) + values;
  const double knot = sizeof(double) + sizeof(std::uint32_t) + 2 * values;
  return tables + crossing * crossings + slice * slices + sizeof(SliceNode) * nodes + sample * samples +
         kGrowth * (gathered + knot) * (samples + nodes) +
         memory_of_decoded_sample(index.channels.size()) * index.guide_count;
}

double memory_of_decoded_sample(std::size_t channels) {
  return kGrowth * (sizeof(SliceSteps::Sample) + row_bytes(channels));
}

}  // namespace sbrdf::internal
