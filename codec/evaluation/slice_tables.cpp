#include "codec/evaluation/slice_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

#include "codec/curves/slope_limits.h"
#include "codec/curves/spline.h"
#include "codec/material/slice_samples.h"
#include "codec/material/value_map.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBucketsForKnot = 1;

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

  void make() {
    add_groups();
    add_crossings();
    add_slices();
    add_lines();
    // Without a guide vectors may still look at its line: at the first bucket of all, wherever it is met.
    tables_.lines.push_back(sliced_.guide ? guide(*sliced_.guide) : Line{0, 0, 31U << kBucketShift});
    tables_.lines.resize(tables_.lines.size() + 1);  // vectors are read from any line on
    tables_.crossing_values.resize(tables_.crossing_values.size() + kLanes);
    tables_.knot_values.resize(tables_.knot_values.size() + kLanes);
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
      curves_.push_back(add_slice(slice, positions, values, slopes));
    }
  }

  Line add_slice(const Slice& slice, const std::vector<double>& positions, const std::vector<double>& values,
                 const std::vector<double>& slopes) {
    const bool bounded = slice.boundary == Boundary::kBounded;
    const double places_per_degree = bounded ? kTurnsPerPolarDegree / 2 : 2147483648.0 / slice.length_deg;
    std::uint32_t shape = slice.boundary == Boundary::kMirrored ? kMirrored : 0;
    if (!bounded) {
      const double periods = longest_deg_ / period_deg(slice);
      const auto turn_shift = static_cast<std::uint32_t>(std::lround(std::log2(periods)));
      assert(std::abs(std::ldexp(1.0, static_cast<int>(turn_shift)) - periods) < 1e-6);
      shape |= turn_shift << kTurnShift;
    }
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
      tables_.knot_values.push_back(static_cast<float>(v));
    }
    for (const double m : slopes.subspan(row * channels_, channels_)) {
      tables_.knot_values.push_back(static_cast<float>(m * double{kWidthUnit} / places_per_degree));
    }
  }

  // Nobody asks for a place beyond `last`.
  Line end_curve(std::uint32_t shape, std::size_t first, std::int32_t last) {
    tables_.places.push_back(kBeyond);
    const PlaceSearch search = add_place_search(tables_.places, first, last, kBucketsForKnot, tables_.buckets);
    const std::size_t row = tables_.knot_values.size() - 2 * channels_;
    for (std::size_t c = 0; c < channels_; ++c) tables_.knot_values.push_back(tables_.knot_values[row + c]);
    tables_.knot_values.resize(tables_.knot_values.size() + channels_);
    return {search.first_bucket, 0, shape | search.bucket_shift << kBucketShift};
  }

  void add_lines() {
    tables_.lines.reserve(tables_.lattice->line_count + 2);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (lattice_.nodes[axis].size() < 2) continue;
      for (const LineReference& reference : lattice_.lines[axis]) tables_.lines.push_back(line(reference));
    }
    assert(tables_.lines.size() == tables_.lattice->line_count);
  }

  Line line(const LineReference& reference) {
    if (reference.is_constant()) return constant_line(reference.crossing());
    const Slice& slice = lattice_.slices[reference.target];
    Line line = curves_[reference.target];
    if (slice.boundary == Boundary::kBounded) {
      assert(reference.sign > 0 && reference.offset_deg == 0 && slice.start_deg == 0);
      return line;
    }
    line.offset = azimuth_turn(reference.offset_deg, longest_deg_) - azimuth_turn(slice.start_deg, longest_deg_);
    if (reference.sign < 0) line.shape |= kBackwards;
    return line;
  }

  // A line on which nothing varies lies on a curve of one knot, so that the kernel need not tell it apart.
  Line constant_line(std::uint32_t crossing) {
    const auto known = constants_.find(crossing);
    if (known != constants_.end()) return known->second;
    const std::size_t first = tables_.places.size();
    tables_.places.push_back(0);
    for (std::size_t c = 0; c < channels_; ++c) {
      tables_.knot_values.push_back(tables_.crossing_values[crossing * channels_ + c]);
    }
    tables_.knot_values.resize(tables_.knot_values.size() + channels_);
    const Line line = end_curve(0, first, kLastPlace);
    constants_.emplace(crossing, line);
    return line;
  }

  // A guide is one more bounded curve, over its own angle; its slopes are those of its spline.
  Line guide(const Guide& profile) {
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
  std::vector<Line> curves_;                 ///< by number of slice, as if x were the turn
  std::map<std::uint32_t, Line> constants_;  ///< by crossing
};

SliceTables::SliceTables(const SlicedBrdf& sliced, const Lattice& given, std::shared_ptr<const LatticeTables> tables)
    : lattice(std::move(tables)),
      channels(sliced.channel_count()),
      knot_size(static_cast<std::uint32_t>(2 * channels)),
      log(sliced.domain.kind == DomainKind::kLog),
      grey_shares(sliced.grey_shares) {
  Maker(*this, sliced, given).make();
}

std::size_t SliceTables::bytes() const {
  return crossing_values.size() * sizeof(float) + lines.size() * sizeof(Line) + places.size() * sizeof(std::int32_t) +
         knot_values.size() * sizeof(float) + buckets.size() * sizeof(PlaceBucket) + groups.size() * sizeof(Group);
}

}  // namespace sbrdf::internal
