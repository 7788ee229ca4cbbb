#include "codec/frame/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "codec/frame/frame_geometries.h"
#include "codec/frame/symmetry_folding.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMaxPoints = 1ULL << 21U;
constexpr std::size_t kNoAxis = kAxisCount;
constexpr std::uint32_t kUnseen = 0xFFFFFFFFU;

Status pad_axes(Lattice& lattice) {
  const FrameGeometry& frame = geometry(lattice.spec.id);
  std::uint64_t points = 1;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::vector<double>& nodes = lattice.spec.axes[axis].nodes_deg;
    std::vector<double>& padded = lattice.nodes[axis];
    padded = nodes;
    const double period = frame.node_period(axis);
    if (period > 0 && nodes.size() > 1) {
      const bool two_turns = axis == kAxial && frame.line_period(axis, lattice.spec.symmetries) > period;
      if (two_turns) {
        for (const double node : nodes) padded.push_back(node + period);
      }
      padded.push_back(two_turns ? 2 * period : period);
    }
    points *= padded.size();
    if (points > kMaxPoints) return unsupported("frame: more than 2^21 lattice points");
  }
  return ok_status();
}

Strides strides(const Lattice& lattice, std::size_t left_out) {
  Strides strides{};
  std::uint32_t stride = 1;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (axis == left_out) continue;
    strides[axis] = stride;
    stride *= static_cast<std::uint32_t>(lattice.nodes[axis].size());
  }
  return strides;
}

/// Of each polar pair, the numbers of the crossings or slices that it has for its own: which of them the walk has met
/// so far, and as the how-manieth.
class PairNumbers {
 public:
  explicit PairNumbers(const Lattice& lattice)
      : pairs_in_row_(lattice.nodes[kHorizontal].size() + 1),
        begin_(pairs_in_row_ * (lattice.nodes[kVertical].size() + 1), kUnseen) {}

  /// `count` numbers, kUnseen at first.
  std::span<std::uint32_t> of(const PolarPair& pair, std::size_t count) {
    std::uint32_t& begin = begin_[pair[0] + pair[1] * pairs_in_row_];
    if (begin == kUnseen) {
      begin = static_cast<std::uint32_t>(numbers_.size());
      numbers_.resize(numbers_.size() + count, kUnseen);
    }
    return std::span(numbers_).subspan(begin, count);
  }

 private:
  std::size_t pairs_in_row_;
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> numbers_;
};

/// Walks the polar pairs in the order of the lattice, and gives the crossings and slices of their patterns numbers.
class Builder {
 public:
  /// The lattice has its nodes and strides.
  explicit Builder(Lattice& lattice)
      : lattice_(lattice), patterns_(lattice), crossing_numbers_(lattice), slice_numbers_(lattice) {}

  void build() {
    reserve();
    number_crossings();
    for (const std::size_t axis : {kAxial, kDiagonal}) {
      if (lattice_.nodes[axis].size() > 1) number_azimuth_lines(axis);
    }
    for (const std::size_t axis : {kHorizontal, kVertical}) {
      if (lattice_.nodes[axis].size() > 1) number_polar_lines(axis);
    }
  }

 private:
  [[nodiscard]] std::uint32_t node_count(std::size_t axis) const {
    return static_cast<std::uint32_t>(lattice_.nodes[axis].size());
  }

  template <class Visit>
  void for_each_pair(const Visit& visit) const {
    walk_polar_pairs(node_count(kHorizontal), node_count(kVertical), visit);
  }

  // The pairs of the lines along a polar axis.
  template <class Visit>
  void for_each_polar_line(std::size_t axis, const Visit& visit) const {
    PolarPair pair{};
    pair[axis - kHorizontal] = node_count(axis);
    std::uint32_t& fixed = pair[kVertical - axis];
    for (fixed = 0; fixed < node_count(kHorizontal + kVertical - axis); ++fixed) visit(pair);
  }

  [[nodiscard]] std::uint32_t first_corner(const PolarPair& pair) const {
    return pair[0] * lattice_.corner_strides[kHorizontal] + pair[1] * lattice_.corner_strides[kVertical];
  }

  // Its members change places only where both polar axes have the same nodes.
  [[nodiscard]] static PolarPair home_pair(const PolarPair& pair, const Pattern& pattern) {
    return pattern.exchanged ? PolarPair{pair[1], pair[0]} : pair;
  }

  // The polar coordinates of what a pattern finds at a pair; the one of a line along its axis is 0.
  void set_polar(Coordinates& x, const PolarPair& pair, const Pattern& pattern) const {
    for (const std::size_t axis : {kHorizontal, kVertical}) {
      const std::size_t own = pattern.exchanged ? kHorizontal + kVertical - axis : axis;
      const std::uint32_t index = pair[own - kHorizontal];
      x[axis] = index < node_count(own) ? lattice_.nodes[own][index] : 0;
    }
  }

  // What there is going to be, but for crossings and slices that rounding keeps apart.
  void reserve() {
    std::size_t points = 1;
    for (const std::vector<double>& nodes : lattice_.nodes) points *= nodes.size();
    lattice_.corners.reserve(points);
    std::size_t crossings = 0;
    std::size_t slices = 0;
    std::size_t slice_nodes = 0;
    for_each_pair([&](const PolarPair& pair) {
      const Pattern& pattern = patterns_.points(pair);
      if (pattern.exchanged) return;
      const PolarKind& kind = patterns_.kind(pattern.home);
      crossings += kind.crossings.size();
      slices += kind.slices.size();
      for (const PatternSlice& slice : kind.slices) slice_nodes += slice.nodes.size();
    });
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (node_count(axis) == 1) continue;
      lattice_.lines[axis].reserve(points / node_count(axis));
      if (axis < kHorizontal) continue;
      for_each_polar_line(axis, [&](const PolarPair& pair) {
        const Pattern& pattern = patterns_.points(pair);
        if (pattern.exchanged) return;
        const std::size_t count = patterns_.kind(pattern.home).crossings.size();
        slices += count;
        slice_nodes += count * node_count(axis);
      });
    }
    lattice_.crossings.reserve(crossings);
    lattice_.slices.reserve(slices);
    lattice_.slice_nodes.reserve(slice_nodes);
  }

  void number_crossings() {
    for_each_pair([&](const PolarPair& pair) {
      const Pattern& pattern = patterns_.points(pair);
      const std::vector<Coordinates>& crossings = patterns_.kind(pattern.home).crossings;
      const std::span<std::uint32_t> numbers = crossing_numbers_.of(home_pair(pair, pattern), crossings.size());
      for (const LineReference& reference : pattern.references) {
        std::uint32_t& number = numbers[reference.target];
        if (number == kUnseen) {
          number = static_cast<std::uint32_t>(lattice_.crossings.size());
          lattice_.crossings.push_back(crossings[reference.target]);
          set_polar(lattice_.crossings.back(), pair, pattern);
        }
        lattice_.corners.push_back(number);
      }
    });
  }

  void number_azimuth_lines(std::size_t axis) {
    const std::uint32_t stride = lattice_.corner_strides[kAxial + kDiagonal - axis];
    for_each_pair([&](const PolarPair& pair) {
      const Pattern& pattern = patterns_.lines(axis, pair);
      const std::vector<PatternSlice>& slices = patterns_.kind(pattern.home).slices;
      const std::span<std::uint32_t> numbers = slice_numbers_.of(home_pair(pair, pattern), slices.size());
      std::uint32_t corner = first_corner(pair);
      for (LineReference reference : pattern.references) {
        if (reference.is_constant()) {
          reference.target |= lattice_.corners[corner];
        } else {
          std::uint32_t& number = numbers[reference.target];
          if (number == kUnseen) number = add_azimuth_slice(slices[reference.target], pair, pattern);
          reference.target = number;
        }
        lattice_.lines[axis].push_back(reference);
        corner += stride;
      }
    });
  }

  std::uint32_t add_azimuth_slice(const PatternSlice& made, const PolarPair& pair, const Pattern& pattern) {
    Slice slice = made.slice;
    set_polar(slice.fixed, pair, pattern);
    slice.fixed[slice.kind] = 0;
    const PolarPair home = home_pair(pair, pattern);
    const std::array<std::uint32_t, 2> first = {first_corner(home), first_corner({home[1], home[0]})};
    begin_slice(slice, made.nodes.size());
    for (const PatternNode& node : made.nodes) {
      const std::uint32_t corner = first[node.exchanged ? 1 : 0] + node.corner;
      lattice_.slice_nodes.push_back({node.position_deg, lattice_.corners[corner]});
    }
    return static_cast<std::uint32_t>(lattice_.slices.size() - 1);
  }

  // The first of the lines on a slice has all its nodes.
  void number_polar_lines(std::size_t axis) {
    const std::size_t other = kHorizontal + kVertical - axis;
    for_each_polar_line(axis, [&](const PolarPair& pair) {
      const Pattern& pattern = patterns_.points(pair);
      const std::vector<Coordinates>& crossings = patterns_.kind(pattern.home).crossings;
      const std::span<std::uint32_t> numbers = slice_numbers_.of(home_pair(pair, pattern), crossings.size());
      std::uint32_t corner = pair[other - kHorizontal] * lattice_.corner_strides[other];
      for (const LineReference& reference : pattern.references) {
        std::uint32_t& number = numbers[reference.target];
        if (number == kUnseen) {
          Slice slice;
          slice.fixed = crossings[reference.target];
          set_polar(slice.fixed, pair, pattern);
          number = add_polar_slice(axis, pattern.exchanged ? other : axis, slice, corner);
        }
        lattice_.lines[axis].push_back({number, 1, 0});
        ++corner;
      }
    });
  }

  std::uint32_t add_polar_slice(std::size_t axis, std::size_t kind, Slice slice, std::uint32_t corner) {
    slice.kind = static_cast<SliceKind>(kind);
    slice.gap_scale = geometry(lattice_.spec.id).arc_scale(kind);
    slice.length_deg = lattice_.nodes[kind].back();
    begin_slice(slice, lattice_.nodes[axis].size());
    for (const double x : lattice_.nodes[axis]) {
      lattice_.slice_nodes.push_back({fold(slice, x + 0.0), lattice_.corners[corner]});
      corner += lattice_.corner_strides[axis];
    }
    return static_cast<std::uint32_t>(lattice_.slices.size() - 1);
  }

  void begin_slice(Slice& slice, std::size_t count) {
    slice.node_begin = static_cast<std::uint32_t>(lattice_.slice_nodes.size());
    slice.node_count = static_cast<std::uint32_t>(count);
    lattice_.slices.push_back(slice);
  }

  Lattice& lattice_;
  SymmetryFolding patterns_;
  PairNumbers crossing_numbers_;
  PairNumbers slice_numbers_;
};

Status check_ends(const Lattice& lattice) {
  for (const Slice& slice : lattice.slices) {
    const auto nodes = lattice.nodes_of(slice);
    const bool starts = std::abs(nodes.front().position_deg - slice.start_deg) < 1e-6;
    const bool ends = std::abs(nodes.back().position_deg - slice.start_deg - slice.length_deg) < 1e-6;
    if (!starts || (slice.boundary != Boundary::kPeriodic && !ends)) {
      return unsupported("frame: the mirror planes of the symmetries need nodes on axis " +
                         lattice.spec.axes[slice.kind].name);
    }
  }
  return ok_status();
}

}  // namespace

Result<Lattice> build_lattice(const FrameSpec& spec) {
  if (Status status = check_frame(spec); !status) return status.error();
  Lattice lattice;
  lattice.spec = spec;
  if (Status status = pad_axes(lattice); !status) return status.error();
  lattice.corner_strides = strides(lattice, kNoAxis);
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) lattice.line_strides[axis] = strides(lattice, axis);
  Builder(lattice).build();
  if (Status status = check_ends(lattice); !status) return status.error();
  return lattice;
}

// Bounded: the clamp. Periodic: the sawtooth x - P floor(x / P). Mirrored: the triangle wave of period P = 2 length,
// which is the sawtooth up to its middle and runs back from there. What rounding leaves just below a whole period is
// its start, where the node is.
double fold(const Slice& slice, double position_deg) {
  if (slice.boundary == Boundary::kBounded)
    return std::clamp(position_deg, slice.start_deg, slice.start_deg + slice.length_deg);
  const bool mirrored = slice.boundary == Boundary::kMirrored;
  const double period = mirrored ? 2 * slice.length_deg : slice.length_deg;
  double from_start = position_deg - slice.start_deg;
  if (from_start < 0 || from_start >= period) from_start -= period * std::floor(from_start / period);
  if (period - from_start < 1e-9) from_start = 0;
  if (mirrored && from_start > slice.length_deg) from_start = period - from_start;
  return slice.start_deg + from_start;
}

Coordinates coordinates_on(const Slice& slice, double position_deg) {
  Coordinates x = slice.fixed;
  x[slice.kind] = position_deg;
  return x;
}

}  // namespace sbrdf::internal
