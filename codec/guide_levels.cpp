#include "codec/guide_levels.h"

#include <algorithm>
#include <cmath>

namespace sbrdf {
namespace {

constexpr double kGuideStep = 1.0 / 2048;
constexpr double kOctavesPerUnit = 1.4426950408889634;  // 1 / log 2
constexpr std::int64_t kMostGuideLevels = 1 << 24;

}  // namespace

std::int32_t guide_level(const LevelScale& scale, float value) {
  if (scale.lossless()) return scale.level(value);
  const double steps = std::clamp(static_cast<double>(value) / kGuideStep, -16777215.0, 16777215.0);
  return static_cast<std::int32_t>(std::floor(steps + 0.5));
}

float guide_value(const LevelScale& scale, std::int32_t level) {
  return scale.lossless() ? scale.value(level) : static_cast<float>(level * kGuideStep);
}

GuideLevels::GuideLevels(const Guide& guide, const Lattice& lattice, std::size_t channels, const LevelScale& scale)
    : active_(guide.ratio == 1),
      levels_per_unit_(scale.levels_per_octave() * kOctavesPerUnit),
      curve_(guide, lattice.nodes[kVertical], channels) {}

void GuideLevels::shift(const Coordinates& x, std::span<std::int32_t> levels, std::int64_t sign) const {
  if (!active_) return;
  for (std::size_t c = 0; c < levels.size(); ++c) {
    double g = 0;
    curve_.evaluate_at(x[kVertical], c, std::span(&g, 1));
    const double wanted = std::clamp(g * levels_per_unit_, -1.0 * kMostGuideLevels, 1.0 * kMostGuideLevels);
    // Modulo 2^32: taking off and putting back cancel whatever the level.
    const auto offset = static_cast<std::uint32_t>(sign * static_cast<std::int64_t>(std::floor(wanted + 0.5)));
    levels[c] = static_cast<std::int32_t>(static_cast<std::uint32_t>(levels[c]) + offset);
  }
}

void begin_slice(const Lattice& lattice, const Slice& slice, const LevelTable& crossings, std::size_t channels,
                 SliceLevels& state) {
  const auto nodes = lattice.nodes_of(slice);
  state.boundary = slice.boundary;
  state.length_deg = slice.length_deg;
  state.deepest = 0;
  state.places.resize(nodes.size());
  state.positions_deg.resize(nodes.size());
  state.depths.assign(nodes.size(), 0);
  state.table.resize(nodes.size() * channels);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    state.places[k] = {static_cast<std::uint32_t>(k), 0};
    state.positions_deg[k] = nodes[k].position_deg;
    for (std::size_t c = 0; c < channels; ++c) {
      state.table.levels[k * channels + c] = crossings.levels[nodes[k].crossing * channels + c];
      state.table.residuals[k * channels + c] = crossings.residuals[nodes[k].crossing * channels + c];
    }
  }
}

SliceLevels begin_guide(const Lattice& lattice, const LevelTable& nodes) {
  SliceLevels state;
  state.positions_deg = lattice.nodes[kVertical];
  state.depths.assign(state.positions_deg.size(), 0);
  for (std::uint32_t k = 0; k < state.positions_deg.size(); ++k) state.places.push_back({k, 0});
  state.table = nodes;
  return state;
}

std::pair<int, int> levels_of_piece(const ChunkLayout& layout, std::size_t piece) {
  const bool last = piece + 1 == layout.piece_levels.size();
  return {layout.piece_levels[piece], last ? kMaxLevel + 1 : layout.piece_levels[piece + 1]};
}

}  // namespace sbrdf
