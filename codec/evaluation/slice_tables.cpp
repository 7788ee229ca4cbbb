#include "codec/evaluation/slice_tables.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>

#include "codec/curves/slope_limits.h"
#include "codec/curves/spline.h"
#include "codec/material/slice_samples.h"
#include "codec/material/value_map.h"

namespace sbrdf::internal {
namespace {

constexpr double kPlaces = 2147483648.0;  // along a turn, or between mirrors
constexpr std::size_t kPadding = 16;      // places that a vector may reach beyond the last
constexpr std::size_t kSegmentsInBucket = 2;

/// The period of the function along a slice [degrees]; 0 where it has none.
double period_deg(const Slice& slice) {
  if (slice.boundary == Boundary::kBounded) return 0;
  return slice.boundary == Boundary::kMirrored ? 2 * slice.length_deg : slice.length_deg;
}

}  // namespace

/// Fills the tables of one material.
class SliceTables::Maker {
 public:
  Maker(SliceTables& tables, const SlicedBrdf& sliced, const Lattice& lattice)
      : tables_(tables), sliced_(sliced), lattice_(lattice), channels_(sliced.channel_count()), map_(sliced, lattice) {}

  void make() {
    add_groups();
    add_crossings();
    add_slices();
    add_axes();
    if (sliced_.guide) add_guide(*sliced_.guide);
    add_nodes();
    tables_.crossing_values.resize(tables_.crossing_values.size() + kLanes);
    tables_.knot_values.resize(tables_.knot_values.size() + kLanes);
    tables_.places.resize(tables_.places.size() + kPadding, kBeyond);
  }

 private:
  void add_groups() {
    for (std::size_t first = 0; first < channels_; first += kLanes) {
      Group group;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t c = std::min(first + lane, channels_ - 1);
        if (tables_.log) {  // see ValueDomain
          group.reference[lane] = sliced_.domain.reference[c];
          group.floor[lane] = sliced_.domain.floor(c);
          const long double at_floor = std::log(static_cast<long double>(group.floor[lane]) / group.reference[lane]);
          group.at_floor[lane] = static_cast<float>(at_floor);
          group.at_zero[lane] = static_cast<float>(at_floor - 1.0L);
        }
        group.least[lane] = static_cast<float>(map_.least(c));
        group.most[lane] = static_cast<float>(map_.most(c));
      }
      tables_.groups.push_back(group);
    }
  }

  void add_crossings() {
    std::vector<double> residual(channels_);
    tables_.crossing_values.reserve(lattice_.crossings.size() * channels_ + kLanes);
    for (std::size_t k = 0; k < lattice_.crossings.size(); ++k) {
      map_.forward(lattice_.crossings[k], std::span(sliced_.crossing_values).subspan(k * channels_, channels_),
                   residual);
      for (const double v : residual) tables_.crossing_values.push_back(static_cast<float>(v));
    }
  }

  void add_slices() {
    const std::vector<SliceSamples> slices = gather_slices(sliced_, lattice_);
    std::size_t knots = 0;
    for (const SliceSamples& samples : slices) knots += samples.size() + 1;
    tables_.places.reserve(knots);
    tables_.knot_values.reserve(knots * 2 * channels_ + kLanes);
    SplineSolver<double> solver;
    std::vector<double> values;
    std::vector<double> slopes;  // second derivatives, until their limits make them slopes
    for (std::size_t k = 0; k < slices.size(); ++k) {
      const Slice& slice = lattice_.slices[k];
      const std::vector<double>& positions = slices[k].positions_deg;
      map_.forward(slice, slices[k], values);
      slopes.resize(values.size());
      for (std::size_t c = 0; c < channels_; ++c) {
        solver.solve(slice.boundary, slice.length_deg, positions, values.data() + c, slopes.data() + c, channels_);
        slopes_within_limits(slice.boundary, slice.length_deg, positions, values.data() + c, slopes.data() + c,
                             channels_);
      }
      add_slice(slice, positions, values, slopes);
    }
  }

  void add_slice(const Slice& slice, const std::vector<double>& positions, const std::vector<double>& values,
                 const std::vector<double>& slopes) {
    const bool bounded = slice.boundary == Boundary::kBounded;
    assert(!bounded || slice.start_deg == 0);
    const double scale = bounded ? kPlacesPerPolarDegree : kPlaces / slice.length_deg;
    Line curve = begin_curve();
    curve.mirrored = slice.boundary == Boundary::kMirrored;
    if (!bounded) {
      const double periods = longest_period_deg(tables_.frame) / period_deg(slice);
      curve.shift = static_cast<std::uint8_t>(std::lround(std::log2(periods)));
      assert(std::abs(std::ldexp(1.0, curve.shift) - periods) < 1e-6);
    }
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const double from_start = positions[k] - slice.start_deg;
      add_knot(bounded ? polar_place(from_start) : azimuth_place(from_start * scale), values, slopes, k, scale);
    }
    if (slice.boundary == Boundary::kPeriodic) add_knot(kLastPlace, values, slopes, 0, scale);
    end_curve(curve);
  }

  static std::int32_t azimuth_place(double places) {
    return static_cast<std::int32_t>(std::min(places + 0.5, double{kLastPlace}));
  }

  Line begin_curve() const {
    Line curve;
    curve.first_knot = static_cast<std::uint32_t>(tables_.places.size());
    return curve;
  }

  void add_knot(std::int32_t place, std::span<const double> values, std::span<const double> slopes, std::size_t row,
                double places_per_degree) {
    tables_.places.push_back(place);
    for (const double v : values.subspan(row * channels_, channels_)) {
      tables_.knot_values.push_back(static_cast<float>(v));
    }
    for (const double m : slopes.subspan(row * channels_, channels_)) {
      tables_.knot_values.push_back(static_cast<float>(m * double{kWidthUnit} / places_per_degree));
    }
  }

  // The last knot stands there once more, beyond all places: the end is then found as any other knot is, at the
  // beginning of a segment.
  void end_curve(Line& curve) {
    curve.knots = make_search(curve.first_knot);
    tables_.places.push_back(kBeyond);
    const std::size_t row = tables_.knot_values.size() - 2 * channels_;
    for (std::size_t c = 0; c < channels_; ++c) tables_.knot_values.push_back(tables_.knot_values[row + c]);
    tables_.knot_values.resize(tables_.knot_values.size() + channels_);
    curves_.push_back(curve);
  }

  // Over the places since `first`: buckets of so many segments that nearly always one comparison of a vector finds the
  // right one.
  Search make_search(std::size_t first) {
    Search search;
    const std::size_t count = tables_.places.size();
    const auto end = static_cast<std::uint64_t>(tables_.places.back());
    search.first_bucket = static_cast<std::uint32_t>(tables_.buckets.size());
    const std::uint64_t wanted = (count - first + kSegmentsInBucket - 1) / kSegmentsInBucket;
    search.bucket_shift = static_cast<std::uint8_t>(std::bit_width(std::max<std::uint64_t>(1, end / wanted)) - 1);
    auto segment = static_cast<std::uint32_t>(first);
    for (std::uint64_t bucket = 0; bucket <= end >> search.bucket_shift; ++bucket) {
      const std::uint64_t from = bucket << search.bucket_shift;
      while (segment + 1 < count && static_cast<std::uint64_t>(tables_.places[segment + 1]) <= from) ++segment;
      tables_.buckets.push_back(segment);
    }
    return search;
  }

  void add_axes() {
    tables_.corners = lattice_.corners;
    tables_.corner_strides = lattice_.corner_strides;
    for (std::uint32_t axis = 0; axis < kAxisCount; ++axis) {
      if (lattice_.nodes[axis].size() < 2) continue;
      MovingAxis moving;
      moving.axis = axis;
      moving.azimuth = geometry(lattice_.spec.id).node_period(axis) > 0;
      moving.line_strides = lattice_.line_strides[axis];
      moving.last_deg = lattice_.nodes[axis].back();
      moving.lines.reserve(lattice_.lines[axis].size());
      for (const LineReference& reference : lattice_.lines[axis]) moving.lines.push_back(line(reference));
      tables_.axes.push_back(std::move(moving));
    }
  }

  void add_nodes() {
    for (MovingAxis& moving : tables_.axes) {
      moving.first_node = static_cast<std::uint32_t>(tables_.places.size());
      for (const double node : lattice_.nodes[moving.axis]) {
        tables_.places.push_back(moving.azimuth ? axis_place(node, longest_period_deg(tables_.frame))
                                                : polar_place(node));
      }
      moving.last_cell = static_cast<std::uint32_t>(tables_.places.size() - 2);
      moving.nodes = make_search(moving.first_node);
    }
  }

  Line line(const LineReference& reference) {
    if (reference.is_constant()) return constant_line(reference.crossing());
    const Slice& slice = lattice_.slices[reference.target];
    Line line = curves_[reference.target];
    line.backwards = reference.sign < 0;
    if (slice.boundary != Boundary::kBounded) {
      const double longest = longest_period_deg(tables_.frame);
      const double turns = (reference.offset_deg - slice.start_deg) / longest;
      line.offset = azimuth_units((turns - std::floor(turns)) * longest, longest);
    }
    return line;
  }

  // A line on which nothing varies lies on a curve of one segment, so that the kernel need not tell it apart.
  Line constant_line(std::uint32_t crossing) {
    const auto known = constants_.find(crossing);
    if (known != constants_.end()) return known->second;
    Line curve = begin_curve();
    for (const std::int32_t place : {0, kLastPlace}) {
      tables_.places.push_back(place);
      for (std::size_t c = 0; c < channels_; ++c) {
        tables_.knot_values.push_back(tables_.crossing_values[crossing * channels_ + c]);
      }
      tables_.knot_values.resize(tables_.knot_values.size() + channels_);
    }
    end_curve(curve);
    constants_.emplace(crossing, curve);
    return curve;
  }

  // A guide is one more bounded curve, over its own angle; its slopes are those of its spline.
  void add_guide(const Guide& profile) {
    tables_.guided = true;
    tables_.guide_ratio = profile.ratio;
    std::vector<double> positions;
    for (const SamplePosition& place : profile.places) {
      positions.push_back(guide_position_deg(lattice_.nodes[kVertical], place));
    }
    const std::vector<double> values(profile.values.begin(), profile.values.end());
    std::vector<double> slopes(values.size());
    SplineSolver<double> solver;
    for (std::size_t c = 0; c < channels_; ++c) {
      solver.solve(Boundary::kBounded, 0, positions, values.data() + c, slopes.data() + c, channels_);
      slopes_of_spline(Boundary::kBounded, 0, positions, values.data() + c, slopes.data() + c, channels_);
    }
    Line curve = begin_curve();
    for (std::size_t k = 0; k < positions.size(); ++k) {
      add_knot(polar_place(positions[k]), values, slopes, k, kPlacesPerPolarDegree);
    }
    tables_.guide_end = tables_.places.back();
    end_curve(curve);
    tables_.guide = curve;
  }

  SliceTables& tables_;
  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  std::size_t channels_;
  ValueMap<double> map_;
  std::vector<Line> curves_;                 ///< by number of slice, then constants and guide: as if x were the place
  std::map<std::uint32_t, Line> constants_;  ///< by crossing
};

SliceTables::SliceTables(const SlicedBrdf& sliced, const Lattice& lattice)
    : frame(lattice.spec.id),
      channels(sliced.channel_count()),
      log(sliced.domain.kind == DomainKind::kLog),
      rings(pole_rings(lattice)),
      grey_shares(sliced.grey_shares) {
  Maker(*this, sliced, lattice).make();
}

std::size_t SliceTables::bytes() const {
  std::size_t lines = 0;
  for (const MovingAxis& axis : axes) lines += axis.lines.size() * sizeof(Line);
  for (const PoleRing& ring : rings) lines += ring.nodes.size() * sizeof(PoleRing::Node);
  return lines + corners.size() * sizeof(std::uint32_t) + crossing_values.size() * sizeof(float) +
         places.size() * sizeof(std::int32_t) + knot_values.size() * sizeof(float) +
         buckets.size() * sizeof(std::uint32_t) + groups.size() * sizeof(Group);
}

}  // namespace sbrdf::internal
