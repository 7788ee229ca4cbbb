#include "codec/evaluation/tables/slice_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "codec/curves/slope_limits.h"
#include "codec/curves/spline.h"
#include "codec/material/slice_samples.h"
#include "codec/material/value_map.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBucketsForKnot = 1;
constexpr std::uint32_t kNone = 0xFFFFFFFFU;
constexpr double kMostSlope = 1e38;  // finite, so that it weighs nothing at a sample

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
      : tables_(tables),
        sliced_(sliced),
        lattice_(lattice),
        longest_deg_(longest_period_deg(lattice.spec.id)),
        channels_(sliced.channel_count()),
        map_(sliced, lattice) {}

  void make(const Needs* only) {
    std::vector<ValueRange> bounds;
    for (std::size_t c = 0; c < channels_; ++c) {
      bounds.push_back({static_cast<float>(map_.least(c)), static_cast<float>(map_.most(c))});
    }
    tables_.add_groups(sliced_.domain, bounds);
    crossings_.assign(lattice_.crossings.size() * channels_, std::numeric_limits<double>::quiet_NaN());
    tables_.crossing_values.resize(crossings_.size() + kLanes);
    curves_.resize(lattice_.slices.size(), Line{kNone, 0, 0});
    first_samples_.reserve(lattice_.slices.size() + 1);
    first_samples_.push_back(0);
    for (const std::uint32_t count : sliced_.sample_counts) first_samples_.push_back(first_samples_.back() + count);
    tables_.lines.resize(std::size_t{tables_.lattice->line_count} + 2);  // vectors are read from any line on
    if (only != nullptr) {
      for (const std::uint32_t corner : only->corners) (void)crossing(lattice_.corners[corner]);
      add_lines(*only);
    } else {
      reserve();
      for (std::uint32_t k = 0; k < lattice_.crossings.size(); ++k) (void)crossing(k);
      add_lines();
    }
    // Without a guide vectors may still look at its line: at the first bucket of all, wherever it is met.
    tables_.lines[tables_.lattice->line_count] =
        sliced_.guide ? guide(*sliced_.guide) : Line{0, 0, 31U << kBucketShift};
    tables_.row_values.resize(tables_.row_values.size() + kLanes);
  }

 private:
  // What slices hold for a crossing, worked out once.
  std::span<const double> crossing(std::uint32_t number) {
    const std::span<double> residual = std::span(crossings_).subspan(number * channels_, channels_);
    if (std::isnan(residual[0])) {
      map_.forward(lattice_.crossings[number],
                   std::span(sliced_.crossing_values).subspan(number * channels_, channels_), residual);
      std::copy(residual.begin(), residual.end(),
                tables_.crossing_values.begin() + static_cast<std::ptrdiff_t>(number * channels_));
    }
    return residual;
  }

  void reserve() {
    std::size_t knots = lattice_.slice_nodes.size() + sliced_.positions.size() + 2 * lattice_.slices.size();
    tables_.places.reserve(knots);
    tables_.row_values.reserve(knots * 2 * channels_ + kLanes);
    tables_.knot_buckets.reserve(knots + knots / 2);
  }

  // The curve of a slice, worked out where it is first asked for.
  const Line& curve(std::uint32_t number) {
    Line& line = curves_[number];
    if (line.first_bucket != kNone) return line;
    const Slice& slice = lattice_.slices[number];
    gather_slice(sliced_, lattice_, number, first_samples_[number], samples_);
    const std::vector<double>& positions = samples_.positions_deg;
    values_.resize(positions.size() * channels_);
    const auto nodes = lattice_.nodes_of(slice);
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const std::span<double> v = std::span(values_).subspan(k * channels_, channels_);
      if (samples_.places[k].fraction == 0) {
        const std::span<const double> at_node = crossing(nodes[samples_.places[k].interval].crossing);
        std::copy(at_node.begin(), at_node.end(), v.begin());
      } else {
        map_.forward(coordinates_on(slice, positions[k]),
                     std::span<const float>(samples_.values).subspan(k * channels_, channels_), v);
      }
    }
    slopes_.resize(values_.size());
    for (std::size_t c = 0; c < channels_; ++c) {
      solver_.solve(slice.boundary, slice.length_deg, positions, values_.data() + c, slopes_.data() + c, channels_);
      slopes_within_limits(slice.boundary, slice.length_deg, positions, values_.data() + c, slopes_.data() + c,
                           channels_);
    }
    line = add_slice(slice, positions, values_, slopes_);
    return line;
  }

  Line add_slice(const Slice& slice, const std::vector<double>& positions, const std::vector<double>& values,
                 const std::vector<double>& slopes) {
    const bool bounded = slice.boundary == Boundary::kBounded;
    const double places_per_degree = bounded ? kTurnsPerPolarDegree / 2 : 2147483648.0 / slice.length_deg;
    std::uint32_t shape = slice.boundary == Boundary::kMirrored ? kMirrored : 0;
    if (!bounded) shape |= periods_log2(longest_deg_, period_deg(slice)) << kTurnShift;
    const std::size_t first = tables_.places.size();
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const double position = positions[k];
      add_knot(bounded ? polar_place(position) : azimuth_place(slice, shape, position), values, slopes, k,
               places_per_degree);
    }
    if (slice.boundary == Boundary::kPeriodic) add_knot(kLastPlace, values, slopes, 0, places_per_degree);
    return end_curve(shape, first, tables_.places.back());
  }

  // As the kernel finds the place of a turn on this curve, so that a sample is met exactly where it lies.
  [[nodiscard]] std::int32_t azimuth_place(const Slice& slice, std::uint32_t shape, double position) const {
    const bool mirrored = (shape & kMirrored) != 0;
    if (mirrored && position >= slice.start_deg + slice.length_deg) return kLastPlace;
    const std::uint32_t turn = azimuth_turn(position, longest_deg_) - azimuth_turn(slice.start_deg, longest_deg_);
    const std::uint32_t own = turn << (shape >> kTurnShift & 31U);
    return mirrored ? static_cast<std::int32_t>(std::min(own, std::uint32_t{kLastPlace})) : place_of_turn(own);
  }

  void add_knot(std::int32_t place, std::span<const double> values, std::span<const double> slopes, std::size_t row,
                double places_per_degree) {
    tables_.places.push_back(place);
    for (const double v : values.subspan(row * channels_, channels_)) {
      tables_.row_values.push_back(static_cast<float>(v));
    }
    for (const double m : slopes.subspan(row * channels_, channels_)) {
      const double slope = m * double{kWidthUnit} / places_per_degree;
      tables_.row_values.push_back(static_cast<float>(std::clamp(slope, -kMostSlope, kMostSlope)));
    }
  }

  // Nobody asks for a place beyond `last`.
  Line end_curve(std::uint32_t shape, std::size_t first, std::int32_t last) {
    tables_.places.push_back(kBeyond);
    buckets_.clear();
    const PlaceSearch search = add_place_search(tables_.places, first, last, kBucketsForKnot, buckets_);
    const auto first_bucket = static_cast<std::uint32_t>(tables_.knot_buckets.size());
    for (const PlaceBucket& bucket : buckets_) {
      const std::int32_t end = bucket.split == kBeyond ? kBeyond : tables_.places[bucket.first + 2];
      tables_.knot_buckets.push_back({bucket.first, tables_.places[bucket.first], bucket.split, end});
    }
    const std::size_t row = tables_.row_values.size() - 2 * channels_;
    for (std::size_t c = 0; c < channels_; ++c) tables_.row_values.push_back(tables_.row_values[row + c]);
    tables_.row_values.resize(tables_.row_values.size() + channels_);
    return {first_bucket, 0, shape | search.bucket_shift << kBucketShift};
  }

  void add_lines() {
    std::size_t number = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (lattice_.nodes[axis].size() < 2) continue;
      for (const LineReference& reference : lattice_.lines[axis]) tables_.lines[number++] = line(reference);
    }
    assert(number == tables_.lattice->line_count);
  }

  void add_lines(const Needs& only) {
    for (const std::uint32_t words : only.lines) {
      std::size_t axis = kAxisCount - 1;
      while (tables_.lattice->first_line[axis] > words || lattice_.nodes[axis].size() < 2) --axis;
      const std::uint32_t within = (words - tables_.lattice->first_line[axis]) / LatticeTables::kLineWords;
      tables_.lines[words / LatticeTables::kLineWords] = line(lattice_.lines[axis][within]);
    }
  }

  Line line(const LineReference& reference) {
    if (reference.is_constant()) return constant_line(reference.crossing());
    const Slice& slice = lattice_.slices[reference.target];
    Line line = curve(reference.target);
    if (slice.boundary == Boundary::kBounded) {
      assert(reference.sign > 0 && reference.offset_deg == 0 && slice.start_deg == 0);
      return line;
    }
    line.offset = azimuth_turn(reference.offset_deg, longest_deg_) - azimuth_turn(slice.start_deg, longest_deg_);
    if (reference.sign < 0) line.shape |= kBackwards;
    return line;
  }

  // A line on which nothing varies lies on a curve of one knot, so that the kernel need not tell it apart.
  Line constant_line(std::uint32_t number) {
    const auto known = constants_.find(number);
    if (known != constants_.end()) return known->second;
    const std::size_t first = tables_.places.size();
    tables_.places.push_back(0);
    for (const double v : crossing(number)) tables_.row_values.push_back(static_cast<float>(v));
    tables_.row_values.resize(tables_.row_values.size() + channels_);
    const Line line = end_curve(0, first, kLastPlace);
    constants_.emplace(number, line);
    return line;
  }

  // A guide is one more bounded curve, over its own angle; its slopes are those of its spline.
  Line guide(const Guide& profile) {
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
    const std::size_t first = tables_.places.size();
    for (std::size_t k = 0; k < positions.size(); ++k) {
      add_knot(polar_place(positions[k]), values, slopes, k, kTurnsPerPolarDegree / 2);
    }
    std::fill(slopes.begin(), slopes.end(), 0.0);  // beyond its end it holds
    add_knot(tables_.places.back(), values, slopes, positions.size() - 1, 1);
    return end_curve(0, first, kLastPlace);
  }

  SliceTables& tables_;
  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  double longest_deg_;
  std::size_t channels_;
  ValueMap<double> map_;
  std::vector<double> crossings_;            ///< what slices hold for them; no number where that is not known yet
  std::vector<Line> curves_;                 ///< by number of slice, as if x were the turn; kNone likewise
  std::vector<std::size_t> first_samples_;   ///< by number of slice, in SlicedBrdf::positions
  std::map<std::uint32_t, Line> constants_;  ///< by crossing
  SplineSolver<double> solver_;
  SliceSamples samples_;  ///< of one slice, and what it holds
  std::vector<double> values_;
  std::vector<PlaceBucket> buckets_;
  std::vector<double> slopes_;  ///< second derivatives, until their limits make them slopes
};

SliceTables::SliceTables(const SlicedBrdf& sliced, std::shared_ptr<const LatticeTables> tables)
    : lattice(std::move(tables)),
      channels(sliced.channel_count()),
      row_size(static_cast<std::uint32_t>(2 * channels)),
      log(sliced.domain.kind == DomainKind::kLog),
      guided(sliced.guide.has_value()),
      guide_ratio(sliced.guide ? sliced.guide->ratio : 1),
      grey_shares(sliced.grey_shares) {}

SliceTables::SliceTables(const SlicedBrdf& sliced, const Lattice& given, std::shared_ptr<const LatticeTables> tables,
                         const Needs* only)
    : SliceTables(sliced, std::move(tables)) {
  Maker(*this, sliced, given).make(only);
}

void SliceTables::add_groups(const ValueDomain& domain, const std::vector<ValueRange>& bounds) {
  for (std::size_t first = 0; first < channels; first += kLanes) {
    Group group;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t c = std::min(first + lane, channels - 1);
      if (log) {  // see ValueDomain
        group.reference[lane] = domain.reference[c];
        group.floor[lane] = domain.floor(c);
        const long double at_floor = std::log(static_cast<long double>(group.floor[lane]) / group.reference[lane]);
        group.at_floor[lane] = static_cast<float>(at_floor);
        group.at_zero[lane] = static_cast<float>(at_floor - 1.0L);
      }
      group.least[lane] = bounds[c].least;
      group.most[lane] = bounds[c].most;
    }
    groups.push_back(group);
  }
}

std::size_t SliceTables::bytes() const {
  return crossing_values.size() * sizeof(float) + lines.size() * sizeof(Line) + places.size() * sizeof(std::int32_t) +
         row_values.size() * sizeof(float) + knot_buckets.size() * sizeof(KnotBucket) +
         row_buckets.size() * sizeof(RowBucket) + groups.size() * sizeof(Group);
}

}  // namespace sbrdf::internal
