#include "codec/frame/symmetry_folding.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "codec/frame/frame_geometries.h"

namespace sbrdf::internal {
namespace {

// How equal things are found. The material's symmetries form a group G (reciprocity and up to two mirrors, 8 members at
// most). f is the same at a point and at its images under G, so they all are one measurement; the images of a line all
// carry the same values. A frame lists these images in a normal form in which equal places have equal numbers. A key
// holds those numbers in whole units of 1e-6 degrees, so that rounding does not tell twins apart, and the image with
// the least key stands for its orbit. What lies on a line (its offset along the moving axis) is no part of the key: it
// says where on the common slice a line begins.
//
// Compared from the front: the moving axis, then theta_i before theta_v (elevation frame), so that of two reciprocal
// twins the one with theta_i <= theta_v, and of two slices the horizontal one, is kept.
using Key = std::array<std::int64_t, kAxisCount + 1>;

struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t hash = 0;
    for (const std::int64_t v : key) hash = (hash ^ static_cast<std::uint64_t>(v)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(hash ^ (hash >> 32U));
  }
};

constexpr std::size_t kNoAxis = kAxisCount;
constexpr std::int64_t kMoving = -1;  // no coordinate is negative
// A line along a polar axis stands on no node of it. Beyond all nodes it is neither at a pole nor smaller than they
// are.
constexpr double kPastPolarNodesDeg = 180;

std::size_t moving_axis(const AffineLine& line) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (line.slope[axis] != 0) return axis;
  }
  return kNoAxis;
}

// Member by member, so that most comparisons end before the rest is made.
std::int64_t key_member(const AffineLine& line, std::size_t k) {
  if (k == 0) return static_cast<std::int64_t>(moving_axis(line));
  const std::size_t axis = kAxisCount - k;
  return line.slope[axis] != 0 ? kMoving : node_units(line.offset[axis]);
}

Key key_of(const AffineLine& line) {
  Key key;
  for (std::size_t k = 0; k < key.size(); ++k) key[k] = key_member(line, k);
  return key;
}

bool is_before(const AffineLine& line, const Key& key) {
  for (std::size_t k = 0; k < key.size(); ++k) {
    const std::int64_t member = key_member(line, k);
    if (member != key[k]) return member < key[k];
  }
  return false;
}

struct Representative {
  const AffineLine& line;
  Key key;
};

// Of all symmetric images the one with the least key stands for them all.
Representative representative(const Images& images) {
  std::size_t best = 0;
  Key key = key_of(images.lines[0]);
  for (std::size_t k = 1; k < images.count; ++k) {
    if (!is_before(images.lines[k], key)) continue;
    best = k;
    key = key_of(images.lines[k]);
  }
  return {images.lines[best], key};
}

// The first of several nodes at one position is kept.
void sort_nodes(std::vector<PatternNode>& nodes) {
  const auto units = [](const PatternNode& node) { return node_units(node.position_deg); };
  std::stable_sort(nodes.begin(), nodes.end(), [&](const auto& a, const auto& b) { return units(a) < units(b); });
  const auto same = [&](const auto& a, const auto& b) { return units(a) == units(b); };
  nodes.erase(std::unique(nodes.begin(), nodes.end(), same), nodes.end());
}

}  // namespace

class SymmetryFolding::Folding {
 public:
  explicit Folding(SymmetryFolding& patterns)
      : patterns_(patterns), lattice_(patterns.lattice_), frame_(geometry(lattice_.spec.id)) {}

  // Pairs in the order of the lattice, so that each crossing and slice is first met where the lattice meets it first.
  void run() {
    for (const std::size_t axis : {kPoints, std::size_t{kAxial}, std::size_t{kDiagonal}}) {
      if (axis != kPoints && lattice_.nodes[axis].size() == 1) continue;
      for_each_pair(axis == kPoints, [&](const PolarPair& pair) {
        Pattern& pattern = patterns_.patterns_[axis][patterns_.kind_of(pair)];
        if (pattern.references.empty()) fold_pattern(axis, pair, pattern);
      });
    }
    for (PolarKind& kind : patterns_.kinds_) {
      for (PatternSlice& slice : kind.slices) sort_nodes(slice.nodes);
    }
  }

 private:
  template <class Visit>
  void for_each_pair(bool with_lines, const Visit& visit) const {
    const auto count = [&](std::size_t axis) {
      const auto nodes = static_cast<std::uint32_t>(lattice_.nodes[axis].size());
      return with_lines && nodes > 1 ? nodes + 1 : nodes;
    };
    walk_polar_pairs(count(kHorizontal), count(kVertical), visit);
  }

  void fold_pattern(std::size_t axis, const PolarPair& pair, Pattern& pattern) {
    AffineLine line;
    line.offset[kHorizontal] = patterns_.polar_deg(pair, kHorizontal);
    line.offset[kVertical] = patterns_.polar_deg(pair, kVertical);
    if (axis != kPoints) line.slope[axis] = 1;
    const auto count = [&](std::size_t a) {
      return a == axis ? 1U : static_cast<std::uint32_t>(lattice_.nodes[a].size());
    };
    walk_grid({count(kAxial), count(kDiagonal), 1, 1}, [&](const LatticePoint& p) {
      for (const std::size_t a : {kAxial, kDiagonal}) line.offset[a] = a == axis ? 0 : lattice_.nodes[a][p[a]];
      fold_line(axis, pair, line, pattern);
      if (axis != kPoints && !pattern.references.back().is_constant()) {
        collect_nodes(axis, p[1 - axis] * lattice_.corner_strides[1 - axis], pattern);
      }
    });
  }

  // A line, or a point where `axis` is kPoints.
  void fold_line(std::size_t axis, const PolarPair& pair, const AffineLine& line, Pattern& pattern) {
    const Images images = frame_.images(line, lattice_.spec.symmetries);
    const auto [canonical, key] = representative(images);
    pattern.exchanged = canonical.offset[kVertical] != line.offset[kVertical];
    pattern.home = patterns_.kind_of(pattern.exchanged ? PolarPair{pair[1], pair[0]} : pair);
    pattern.references.push_back(axis == kPoints ? crossing_reference(canonical, key, pattern)
                                                 : slice_reference(canonical, key, pattern));
  }

  // The number of a crossing or slice within its kind, and whether it is new. Within a kind the polar coordinates say
  // nothing, so the kind stands in the key for both.
  std::pair<std::uint32_t, bool> number(Key key, std::size_t home, std::size_t count) {
    key[1] = static_cast<std::int64_t>(home);
    key[2] = 0;
    const auto [entry, added] = numbers_.try_emplace(key, static_cast<std::uint32_t>(count));
    return {entry->second, added};
  }

  LineReference crossing_reference(const AffineLine& canonical, const Key& key, const Pattern& pattern) {
    std::vector<Coordinates>& crossings = patterns_.kinds_[pattern.home].crossings;
    const auto [k, added] = number(key, pattern.home, crossings.size());
    if (added) crossings.push_back(canonical.offset);
    return {k, 1, 0};
  }

  LineReference slice_reference(const AffineLine& canonical, const Key& key, const Pattern& pattern) {
    const std::size_t moving = moving_axis(canonical);
    if (moving == kNoAxis) return {LineReference::kConstant, 1, 0};
    std::vector<PatternSlice>& slices = patterns_.kinds_[pattern.home].slices;
    const auto [k, added] = number(key, pattern.home, slices.size());
    if (added) slices.push_back({make_slice(canonical, moving), {}});
    return {k, canonical.slope[moving], canonical.offset[moving]};
  }

  [[nodiscard]] Slice make_slice(const AffineLine& canonical, std::size_t moving) const {
    Slice slice;
    slice.kind = static_cast<SliceKind>(moving);
    slice.gap_scale = frame_.arc_scale(moving);
    slice.fixed = canonical.offset;
    slice.fixed[moving] = 0;
    AffineLine line = canonical;
    line.offset[moving] = 0;
    line.slope[moving] = 1;
    find_domain(line, moving, slice);
    return slice;
  }

  // The symmetries that map a line onto itself tell how little of it needs measuring. Such an image has the line's own
  // key, and the point at p goes to offset + slope p of the same line:
  //
  //   slope +1:  f(p) = f(p + offset)    one more period; all of them together have their greatest common divisor P
  //   slope -1:  f(p) = f(offset - p)    even about offset / 2, and with the period about offset / 2 + P / 2 too
  //
  // Without the second kind [0, P) is measured. With it [start, start + P / 2] suffices, both ends mirrors, where start
  // is the first point about which f is even.
  void find_domain(const AffineLine& line, std::size_t moving, Slice& slice) const {
    std::int64_t period = node_units(frame_.line_period(moving, lattice_.spec.symmetries));
    std::int64_t centre = -1;
    const Key key = key_of(line);
    const Images all = frame_.images(line, lattice_.spec.symmetries);
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
  }

  // Where the nodes of the line that `pattern` got last come to lie on its slice. Several lines add to one slice, since
  // each may meet it at other nodes.
  void collect_nodes(std::size_t axis, std::uint32_t corner, const Pattern& pattern) {
    const LineReference& reference = pattern.references.back();
    PatternSlice& slice = patterns_.kinds_[pattern.home].slices[reference.target];
    for (const double x : lattice_.nodes[axis]) {
      const double position = fold(slice.slice, reference.sign * x + reference.offset_deg);
      slice.nodes.push_back({position, corner, pattern.exchanged});
      corner += lattice_.corner_strides[axis];
    }
  }

  SymmetryFolding& patterns_;
  const Lattice& lattice_;
  const FrameGeometry& frame_;
  std::unordered_map<Key, std::uint32_t, KeyHash> numbers_;
};

SymmetryFolding::SymmetryFolding(const Lattice& lattice) : lattice_(lattice) { Folding(*this).run(); }

double SymmetryFolding::polar_deg(const PolarPair& pair, std::size_t axis) const {
  const std::vector<double>& nodes = lattice_.nodes[axis];
  const std::uint32_t index = pair[axis - kHorizontal];
  return index < nodes.size() ? nodes[index] : kPastPolarNodesDeg;
}

// All that the symmetries see of two polar angles: which of them are 0, and which is the larger.
std::size_t SymmetryFolding::kind_of(const PolarPair& pair) const {
  const double h = polar_deg(pair, kHorizontal);
  const double v = polar_deg(pair, kVertical);
  return (h == 0 ? 1U : 0U) + (v == 0 ? 2U : 0U) + (h < v ? 4U : h > v ? 8U : 0U);
}

}  // namespace sbrdf::internal
