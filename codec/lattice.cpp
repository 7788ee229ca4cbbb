#include "codec/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "codec/frame_geometries.h"

namespace sbrdf {
namespace {

constexpr std::uint64_t kMaxPoints = 1ULL << 21U;

// Compared from the front: the moving axis, then theta_i before theta_v (elevation frame), so that of two reciprocal
// twins the one with theta_i <= theta_v, and of two slices the horizontal one, is kept.
struct Key {
  std::array<std::int64_t, kAxisCount + 1> value{};
  auto operator<=>(const Key&) const = default;
};

struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t hash = 0;
    for (const std::int64_t v : key.value) hash = (hash ^ static_cast<std::uint64_t>(v)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(hash ^ (hash >> 32U));
  }
};

constexpr std::size_t kNoAxis = kAxisCount;
constexpr std::int64_t kMoving = -1;  // no coordinate is negative

std::size_t moving_axis(const AffineLine& line) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (line.slope[axis] != 0) return axis;
  }
  return kNoAxis;
}

Key key_of(const AffineLine& line) {
  Key key;
  key.value[0] = static_cast<std::int64_t>(moving_axis(line));
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    key.value[kAxisCount - axis] = line.slope[axis] != 0 ? kMoving : node_units(line.offset[axis]);
  }
  return key;
}

// Of all symmetric images the one with the least key stands for them all.
const AffineLine& representative(const Images& images) {
  std::size_t best = 0;
  Key best_key = key_of(images.lines[0]);
  for (std::size_t k = 1; k < images.count; ++k) {
    const Key key = key_of(images.lines[k]);
    if (key < best_key) {
      best_key = key;
      best = k;
    }
  }
  return images.lines[best];
}

struct PaddedPoint {
  std::array<std::uint32_t, kAxisCount> index{};
};

class Builder {
 public:
  explicit Builder(const FrameSpec& spec) : frame_(geometry(spec.id)) { lattice_.spec = spec; }

  Result<Lattice> build() {
    if (Status status = pad_axes(); !status) return status.error();
    number_crossings();
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (Status status = number_lines(axis); !status) return status.error();
    }
    if (Status status = place_nodes(); !status) return status.error();
    return std::move(lattice_);
  }

 private:
  Status pad_axes() {
    std::uint64_t points = 1;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double>& nodes = lattice_.spec.axes[axis].nodes_deg;
      std::vector<double>& padded = lattice_.nodes[axis];
      padded = nodes;
      const double period = frame_.node_period(axis);
      if (period > 0 && nodes.size() > 1) {
        const bool two_turns = axis == kAxial && frame_.line_period(axis, lattice_.spec.symmetries) > period;
        if (two_turns) {
          for (const double node : nodes) padded.push_back(node + period);
        }
        padded.push_back(two_turns ? 2 * period : period);
      }
      points *= padded.size();
      if (points > kMaxPoints) return Error{ErrorCode::kUnsupported, "frame: more than 2^21 lattice points", {}};
    }
    return ok_status();
  }

  template <class Visit>
  void for_each_point(std::size_t left_out, const Visit& visit) const {
    PaddedPoint point;
    std::array<std::size_t, kAxisCount> counts{};
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) counts[axis] = lattice_.nodes[axis].size();
    if (left_out < kAxisCount) counts[left_out] = 1;
    for (point.index[3] = 0; point.index[3] < counts[3]; ++point.index[3])
      for (point.index[2] = 0; point.index[2] < counts[2]; ++point.index[2])
        for (point.index[1] = 0; point.index[1] < counts[1]; ++point.index[1])
          for (point.index[0] = 0; point.index[0] < counts[0]; ++point.index[0]) visit(point);
  }

  [[nodiscard]] Strides strides(std::size_t left_out) const {
    Strides strides{};
    std::uint32_t stride = 1;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (axis == left_out) continue;
      strides[axis] = stride;
      stride *= static_cast<std::uint32_t>(lattice_.nodes[axis].size());
    }
    return strides;
  }

  [[nodiscard]] AffineLine at(const PaddedPoint& point) const {
    AffineLine line;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      line.offset[axis] = lattice_.nodes[axis][point.index[axis]];
    }
    return line;
  }

  [[nodiscard]] Images images(const AffineLine& line) const { return frame_.images(line, lattice_.spec.symmetries); }

  std::uint32_t crossing_at(const AffineLine& point) {
    const AffineLine canonical = representative(images(point));
    const auto [entry, added] =
        crossing_ids_.try_emplace(key_of(canonical), static_cast<std::uint32_t>(lattice_.crossings.size()));
    if (added) lattice_.crossings.push_back(canonical.offset);
    return entry->second;
  }

  void number_crossings() {
    lattice_.corner_strides = strides(kNoAxis);
    for_each_point(kNoAxis, [&](const PaddedPoint& point) { lattice_.corners.push_back(crossing_at(at(point))); });
  }

  Status number_lines(std::size_t axis) {
    lattice_.line_strides[axis] = strides(axis);
    if (lattice_.nodes[axis].size() == 1) return ok_status();
    Status status = ok_status();
    for_each_point(axis, [&](const PaddedPoint& point) {
      AffineLine line = at(point);
      line.offset[axis] = 0;
      line.slope[axis] = 1;
      const AffineLine canonical = representative(images(line));
      LineReference reference;
      if (const std::size_t moving = moving_axis(canonical); moving == kNoAxis) {
        reference.target = LineReference::kConstant | crossing_at(at(point));
      } else {
        reference = {slice_of(canonical, moving), canonical.slope[moving], canonical.offset[moving]};
        collect_nodes(axis, point, reference);
      }
      lattice_.lines[axis].push_back(reference);
    });
    return status;
  }

  std::uint32_t slice_of(const AffineLine& canonical, std::size_t moving) {
    const auto [entry, added] =
        slice_ids_.try_emplace(key_of(canonical), static_cast<std::uint32_t>(lattice_.slices.size()));
    if (added) {
      lattice_.slices.push_back(make_slice(canonical, moving));
      collected_.emplace_back();
    }
    return entry->second;
  }

  // The symmetries that map a line onto itself shorten its period or make it even about a point.
  [[nodiscard]] Slice make_slice(const AffineLine& canonical, std::size_t moving) const {
    Slice slice;
    slice.kind = static_cast<SliceKind>(moving);
    slice.gap_scale = frame_.arc_scale(moving);
    slice.fixed = canonical.offset;
    AffineLine line = canonical;
    line.offset[moving] = 0;
    line.slope[moving] = 1;
    slice.fixed[moving] = 0;
    const double line_period = frame_.line_period(moving, lattice_.spec.symmetries);
    if (line_period == 0) {
      slice.length_deg = lattice_.nodes[moving].back();
      return slice;
    }
    std::int64_t period = node_units(line_period);
    std::int64_t centre = -1;
    const Key key = key_of(line);
    const Images all = images(line);
    for (std::size_t k = 0; k < all.count; ++k) {
      const AffineLine& image = all.lines[k];
      if (key_of(image) != key) continue;
      const std::int64_t offset = node_units(image.offset[moving]);
      if (image.slope[moving] > 0) {
        period = std::gcd(period, offset);
      } else if (centre < 0 || offset < centre) {
        centre = offset;
      }
    }
    const double period_deg = static_cast<double>(period) / kUnitsPerDegree;
    slice.boundary = centre < 0 ? Boundary::kPeriodic : Boundary::kMirrored;
    slice.start_deg = centre < 0 ? 0 : static_cast<double>(centre % period) / kUnitsPerDegree / 2;
    slice.length_deg = centre < 0 ? period_deg : period_deg / 2;
    return slice;
  }

  void collect_nodes(std::size_t axis, const PaddedPoint& point, const LineReference& reference) {
    const Slice& slice = lattice_.slices[reference.target];
    PaddedPoint p = point;
    for (p.index[axis] = 0; p.index[axis] < lattice_.nodes[axis].size(); ++p.index[axis]) {
      const double x = lattice_.nodes[axis][p.index[axis]];
      const double position = fold(slice, reference.sign * x + reference.offset_deg);
      std::uint32_t corner = 0;
      for (std::size_t a = 0; a < kAxisCount; ++a) corner += p.index[a] * lattice_.corner_strides[a];
      collected_[reference.target].try_emplace(node_units(position), SliceNode{position, lattice_.corners[corner]});
    }
  }

  Status place_nodes() {
    for (std::size_t k = 0; k < lattice_.slices.size(); ++k) {
      Slice& slice = lattice_.slices[k];
      slice.node_begin = static_cast<std::uint32_t>(lattice_.slice_nodes.size());
      slice.node_count = static_cast<std::uint32_t>(collected_[k].size());
      for (const auto& [position, node] : collected_[k]) lattice_.slice_nodes.push_back(node);
      const auto nodes = lattice_.nodes_of(slice);
      const bool starts = std::abs(nodes.front().position_deg - slice.start_deg) < 1e-6;
      const bool ends = std::abs(nodes.back().position_deg - slice.start_deg - slice.length_deg) < 1e-6;
      if (!starts || (slice.boundary != Boundary::kPeriodic && !ends)) {
        return Error{
            ErrorCode::kUnsupported,
            "frame: the mirror planes of the symmetries need nodes on axis " + lattice_.spec.axes[slice.kind].name,
            {}};
      }
    }
    return ok_status();
  }

  const FrameGeometry& frame_;
  Lattice lattice_;
  std::unordered_map<Key, std::uint32_t, KeyHash> crossing_ids_;
  std::unordered_map<Key, std::uint32_t, KeyHash> slice_ids_;
  std::vector<std::map<std::int64_t, SliceNode>> collected_;
};

}  // namespace

Result<Lattice> build_lattice(const FrameSpec& spec) {
  if (Status status = check_frame(spec); !status) return status.error();
  return Builder(spec).build();
}

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

}  // namespace sbrdf
