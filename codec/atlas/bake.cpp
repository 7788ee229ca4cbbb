#include "codec/atlas/bake.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "codec/atlas/slice_values.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 3;
constexpr std::size_t kLinesLookedAt = 200;  // of each axis, when its texels are chosen
constexpr std::uint32_t kFinest = 128;       // steps that a cell is looked at in

using Value = SliceValues::Value;

/// The part of the nodes that symmetries do not repeat.
std::vector<double> folded_nodes(const FrameSpec& spec, std::size_t axis, const std::vector<double>& nodes) {
  const Symmetries& symmetries = spec.symmetries;
  const bool half = spec.id == FrameId::kHalfDifference;
  double end = 1e9;
  if (symmetries.isotropic) {
    if (axis == kDiagonal && (symmetries.mirror_x || symmetries.mirror_y)) end = half ? 90 : 180;
  } else if (half && axis == kAxial && symmetries.mirror_x) {
    end = symmetries.mirror_y ? 90 : 180;
  }
  std::vector<double> kept;
  for (const double node : nodes) {
    if (node <= end + 1e-9) kept.push_back(node);
  }
  return kept;
}

/// The coordinate at `t` in [0, 1] of the texels of a cell.
double coordinate_in(const AtlasAxis& axis, std::size_t cell, double t) {
  const double low = axis.nodes_deg[cell];
  return low + (axis.root_spacing && cell == 0 ? t * t : t) * (axis.nodes_deg[cell + 1] - low);
}

/// Of all texels of an axis.
std::vector<double> texel_coordinates(const AtlasAxis& axis) {
  std::vector<double> coordinates;
  for (std::size_t cell = 0; cell + 1 < axis.nodes_deg.size(); ++cell) {
    const std::uint32_t count = axis.texels[cell + 1] - axis.texels[cell];
    for (std::uint32_t s = cell == 0 ? 0 : 1; s <= count; ++s) {
      coordinates.push_back(coordinate_in(axis, cell, static_cast<double>(s) / count));
    }
  }
  return coordinates;
}

std::vector<std::uint32_t> steps_of(const AtlasAxis& axis) {
  std::vector<std::uint32_t> steps;
  for (std::size_t k = 1; k < axis.texels.size(); ++k) steps.push_back(axis.texels[k] - axis.texels[k - 1]);
  return steps;
}

void set_steps(AtlasAxis& axis, const std::vector<std::uint32_t>& steps) {
  axis.texels.assign(1, 0);
  for (const std::uint32_t count : steps) axis.texels.push_back(axis.texels.back() + count);
}

/// Chooses how many texels each cell of an axis gets.
class TexelChoice {
 public:
  TexelChoice(const SliceValues& values, const AtlasLayout& layout, const BakeOptions& options)
      : values_(values), layout_(layout), options_(options) {}

  void choose(std::size_t along, AtlasAxis& axis) const {
    const std::vector<Coordinates> lines = some_lines(along);
    const std::size_t cells = axis.nodes_deg.size() - 1;
    std::vector<std::uint32_t> steps(cells);
    parallel_for(cells, [&](std::uint64_t cell) { steps[cell] = steps_for(along, axis, cell, lines); });
    set_steps(axis, steps);
  }

 private:
  [[nodiscard]] std::vector<Coordinates> some_lines(std::size_t along) const {
    std::mt19937 random(23);
    std::vector<Coordinates> lines(kLinesLookedAt);
    for (Coordinates& x : lines) {
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const std::vector<double>& nodes = layout_.axes[axis].nodes_deg;
        const std::size_t node = random() % nodes.size();
        x[axis] = axis == along ? 0 : nodes[node];
        if (!layout_.dense_along || axis == along || node + 1 == nodes.size()) continue;
        // Not only along slices: texels lie everywhere.
        x[axis] += (nodes[node + 1] - nodes[node]) * static_cast<double>(random() % 16) / 16;
      }
    }
    return lines;
  }

  [[nodiscard]] std::uint32_t steps_for(std::size_t along, const AtlasAxis& axis, std::size_t cell,
                                        const std::vector<Coordinates>& lines) const {
    std::vector<Value> values(lines.size() * (kFinest + 1));
    for (std::size_t k = 0; k < lines.size(); ++k) {
      Coordinates x = lines[k];
      for (std::uint32_t s = 0; s <= kFinest; ++s) {
        x[along] = coordinate_in(axis, cell, static_cast<double>(s) / kFinest);
        values[k * (kFinest + 1) + s] = values_.at(x);
      }
    }
    std::uint32_t steps = 1;
    while (steps < std::min(kFinest, options_.most_texels_per_cell) && error_with(values, steps) > options_.tolerance) {
      steps *= 2;
    }
    return steps;
  }

  // Root of the mean square over lines, places and channels.
  [[nodiscard]] static double error_with(const std::vector<Value>& values, std::uint32_t steps) {
    const std::uint32_t stride = kFinest / steps;
    double sum = 0;
    for (std::size_t first = 0; first < values.size(); first += kFinest + 1) {
      for (std::uint32_t s = 0; s < kFinest; ++s) {
        const Value& low = values[first + s / stride * stride];
        const Value& high = values[first + (s / stride + 1) * stride];
        const double t = static_cast<double>(s % stride) / stride;
        for (std::size_t c = 0; c < kChannels; ++c) {
          const double error = low[c] + t * (high[c] - low[c]) - values[first + s][c];
          sum += error * error;
        }
      }
    }
    return std::sqrt(sum / static_cast<double>(values.size() * kChannels));
  }

  const SliceValues& values_;
  const AtlasLayout& layout_;
  const BakeOptions& options_;
};

/// Fills the texels.
class Filling {
 public:
  Filling(const SliceValues& values, Atlas& atlas) : values_(values), atlas_(atlas) {}

  void fill() {
    const AtlasLayout& layout = atlas_.layout;
    atlas_.texels.assign(std::size_t{layout.width} * layout.height * kChannels, 0);
    atlas_.scales.assign(layout.tables.size() + (layout.ring ? 1 : 0), {AtlasScale{}});
    for (std::size_t k = 0; k < layout.tables.size(); ++k) fill_table(layout.tables[k], k == 0);
    if (layout.ring) fill_ring(*layout.ring);
  }

 private:
  /// Where rows and tiles of tables along other axes lie.
  [[nodiscard]] std::vector<double> steps(std::size_t axis) const {
    const AtlasAxis& on = atlas_.layout.axes[axis];
    return atlas_.layout.dense_along ? texel_coordinates(on) : on.nodes_deg;
  }

  void fill_table(const AtlasTable& table, bool primary) {
    const AtlasLayout& layout = atlas_.layout;
    const std::vector<double> first_steps = table.between.empty() ? std::vector<double>{0} : steps(table.between[0]);
    const std::vector<double> second_steps =
        table.between.size() < 2 ? std::vector<double>{0} : steps(table.between[1]);
    parallel_for(first_steps.size() * second_steps.size(), [&](std::uint64_t number) {
      const std::size_t first = number / second_steps.size();
      const std::size_t second = number % second_steps.size();
      if (table.triangular && second > first + 1) return;
      Coordinates x{};
      if (!table.between.empty()) x[table.between[0]] = first_steps[first];
      if (table.between.size() > 1) x[table.between[1]] = second_steps[second];
      fill_tile(table, table.tiles[tile_number(layout, table, first, second)], x, primary);
    });
  }

  void fill_tile(const AtlasTable& table, const AtlasTile& tile, Coordinates x, bool primary) {
    const AtlasAxis& along = atlas_.layout.axes[table.along];
    const std::vector<double> columns = texel_coordinates(along);
    const std::vector<double> rows = table.across ? steps(*table.across) : std::vector<double>();
    std::vector<Value> row(columns.size());
    for (std::uint32_t y = 0; y < tile.height; ++y) {
      if (table.across) x[*table.across] = rows[std::min<std::size_t>(tile.first_row + y, rows.size() - 1)];
      for (std::size_t t = 0; t < columns.size(); ++t) {
        x[table.along] = columns[t];
        row[t] = values_.at(x);
      }
      if (!primary) take_off_straight_lines(along, row);
      for (std::uint32_t t = 0; t < tile.width; ++t) {
        put(tile.x + t, tile.y + y, row[std::min<std::size_t>(tile.first_column + t, row.size() - 1)]);
      }
    }
  }

  static void take_off_straight_lines(const AtlasAxis& along, std::vector<Value>& row) {
    const std::vector<Value> values = row;
    for (std::size_t cell = 0; cell + 1 < along.nodes_deg.size(); ++cell) {
      const Value& low = values[along.texels[cell]];
      const Value& high = values[along.texels[cell + 1]];
      const std::uint32_t count = along.texels[cell + 1] - along.texels[cell];
      for (std::uint32_t s = 0; s <= count; ++s) {
        const double t = static_cast<double>(s) / count;
        const double part = along.root_spacing && cell == 0 ? t * t : t;
        for (std::size_t c = 0; c < kChannels; ++c) {
          row[along.texels[cell] + s][c] = values[along.texels[cell] + s][c] - (low[c] + part * (high[c] - low[c]));
        }
      }
    }
  }

  void fill_ring(const AtlasRing& ring) {
    const AtlasLayout& layout = atlas_.layout;
    const AtlasPole pole = poles(layout).front();
    const std::vector<double> places = texel_coordinates(layout.axes[pole.along]);
    for (std::uint32_t y = 0; y < ring.tile_height; ++y) {
      for (std::uint32_t x = 0; x < ring.tile_width; ++x) {
        Coordinates at{};
        at[pole.along] = places[std::min<std::size_t>(y, places.size() - 1)];
        at[pole.ring_axis] = std::min(x, ring.ring_texels) % ring.ring_texels * ring.period_deg / ring.ring_texels;
        put(ring.x + x, ring.y + y, values_.at(at));
      }
    }
  }

  void put(std::uint32_t x, std::uint32_t y, const Value& v) {
    for (std::size_t c = 0; c < kChannels; ++c) {
      atlas_.texels[(std::size_t{y} * atlas_.layout.width + x) * kChannels + c] = static_cast<float>(v[c]);
    }
  }

  const SliceValues& values_;
  Atlas& atlas_;
};

/// In the elevation frame exchanging light and view turns u into 360 - u and s into s + 360, and the elevations change
/// places. Texels that do not follow would make a step where theta_i = theta_v.
void make_reciprocal(AtlasLayout& layout) {
  AtlasAxis& s = layout.axes[kAxial];
  AtlasAxis& u = layout.axes[kDiagonal];
  if (s.moves()) {
    const std::vector<std::uint32_t> steps = steps_of(s);
    std::vector<std::uint32_t> both = steps;
    for (std::size_t k = 0; k < steps.size(); ++k)
      both[k] = std::max(steps[k], steps[(k + steps.size() / 2) % steps.size()]);
    set_steps(s, both);
  }
  if (u.moves() && u.nodes_deg.back() == 360) {
    const std::vector<std::uint32_t> steps = steps_of(u);
    std::vector<std::uint32_t> both = steps;
    for (std::size_t k = 0; k < steps.size(); ++k) both[k] = std::max(steps[k], steps[steps.size() - 1 - k]);
    set_steps(u, both);
  }
  const std::vector<std::uint32_t> view = steps_of(layout.axes[kHorizontal]);
  std::vector<std::uint32_t> both = steps_of(layout.axes[kVertical]);
  for (std::size_t k = 0; k < both.size(); ++k) both[k] = std::max(both[k], view[k]);
  set_steps(layout.axes[kHorizontal], both);
  set_steps(layout.axes[kVertical], both);
}

}  // namespace

AtlasLayout atlas_axes(const Lattice& lattice) {
  AtlasLayout layout;
  layout.frame = lattice.spec.id;
  layout.symmetries = lattice.spec.symmetries;
  layout.theta_max_deg = lattice.spec.theta_max_deg;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    layout.axes[axis].nodes_deg = folded_nodes(lattice.spec, axis, lattice.nodes[axis]);
    layout.axes[axis].root_spacing = layout.frame == FrameId::kHalfDifference && axis == kVertical;
  }
  return layout;
}

std::optional<std::size_t> dense_axis(const Lattice& lattice) {
  const FrameSpec& spec = lattice.spec;
  const bool few = spec.symmetries.isotropic && spec.id == FrameId::kHalfDifference;
  return few && lattice.nodes[kVertical].size() > 1 ? std::optional<std::size_t>(kVertical) : std::nullopt;
}

Result<Atlas> bake_atlas(const SlicedBrdf& sliced, const Lattice& lattice, const BakeOptions& options) {
  if (Status held = check_atlas_channels(sliced.channel_count()); !held) return held.error();
  const SliceValues values(sliced, lattice);
  Atlas atlas;
  AtlasLayout& layout = atlas.layout;
  layout = atlas_axes(lattice);
  layout.cells = options.cells;
  layout.blocks = options.blocks;
  if (options.dense) layout.dense_along = dense_axis(lattice);
  const bool all_move =
      std::all_of(layout.axes.begin(), layout.axes.end(), [](const auto& axis) { return axis.moves(); });
  const TexelChoice choice(values, layout, options);
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (layout.axes[axis].moves()) choice.choose(axis, layout.axes[axis]);
  }
  if (layout.frame == FrameId::kElevation) make_reciprocal(layout);
  if (all_move) {
    const Merging merging = geometry(layout.frame).mergings().front();
    const AtlasAxis& ring_axis = layout.axes[merging.ring_axis];
    AtlasRing ring;
    ring.period_deg = merging.period_deg;
    // As dense as the slices along the azimuth that is left.
    ring.ring_texels = static_cast<std::uint32_t>(
        std::lround(ring_axis.texels.back() * merging.period_deg / ring_axis.nodes_deg.back()));
    layout.ring = ring;
  }
  if (Status status = lay_out(layout, options.most_side); !status) return status.error();
  if (std::uint64_t{layout.width} * layout.height > options.most_texels) {
    return unsupported("more than " + std::to_string(options.most_texels) + " texels are needed");
  }
  atlas.domain = domain_of(sliced, lattice);
  Filling(values, atlas).fill();
  return atlas;
}

}  // namespace sbrdf::internal
