#include "codec/coding/value_scaling.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "codec/coding/guide_steps.h"
#include "codec/material/slice_samples.h"

namespace sbrdf::internal {
namespace {

// Steps and values of one list; false where a value is off by more than `bound`.
bool apply_scale(const Quantizer& scale, double bound, const std::vector<float>& values,
                 std::vector<std::int32_t>& steps, std::vector<float>& kept) {
  steps.resize(values.size());
  kept.resize(values.size());
  bool within = true;
  for (std::size_t k = 0; k < values.size(); ++k) {
    steps[k] = scale.step(values[k]);
    kept[k] = scale.value(steps[k]);
    // Written so that an infinity is refused.
    within = within &&
             std::abs(static_cast<double>(kept[k]) - values[k]) <= bound * std::abs(static_cast<double>(values[k]));
  }
  return within;
}

}  // namespace

Scaled scale_values(const SlicedBrdf& sliced, double precision) {
  Scaled scaled;
  // A bound out of a file may be one that no scale is made for.
  if (precision >= kFinestBound) {
    precision = bound_of(millionths_of(std::min(precision, kCoarsestBound)));
    scaled.scale = Quantizer(precision);
    scaled.scale.begin_at_smallest({sliced.crossing_values, sliced.sample_values, sliced.domain.reference});
    if (apply_scale(scaled.scale, precision, sliced.crossing_values, scaled.crossing_steps, scaled.crossing_values) &&
        apply_scale(scaled.scale, precision, sliced.sample_values, scaled.sample_steps, scaled.sample_values) &&
        apply_scale(scaled.scale, precision, sliced.domain.reference, scaled.reference_steps, scaled.references)) {
      return scaled;
    }
    scaled.scale = Quantizer();
  }
  apply_scale(scaled.scale, 0, sliced.crossing_values, scaled.crossing_steps, scaled.crossing_values);
  apply_scale(scaled.scale, 0, sliced.sample_values, scaled.sample_steps, scaled.sample_values);
  apply_scale(scaled.scale, 0, sliced.domain.reference, scaled.reference_steps, scaled.references);
  return scaled;
}

void take_off_guide(const SlicedBrdf& sliced, const Lattice& lattice, Scaled& scaled) {
  if (!sliced.guide) return;
  const std::size_t channels = sliced.channel_count();
  Guide guide = *sliced.guide;
  for (float& v : guide.values) v = guide_value(scaled.scale, guide_step(scaled.scale, v));
  GuideSteps offsets(guide, lattice, channels, scaled.scale);
  const auto row = [channels](std::vector<std::int32_t>& steps, std::size_t k) {
    return std::span(steps).subspan(k * channels, channels);
  };
  for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
    offsets.take_off(lattice.crossings[k], row(scaled.crossing_steps, k));
  }
  std::size_t next = 0;
  for (std::size_t k = 0; k < lattice.slices.size(); ++k) {
    const Slice& slice = lattice.slices[k];
    for (std::uint32_t s = 0; s < sliced.sample_counts[k]; ++s, ++next) {
      offsets.take_off(coordinates_on(slice, position_deg(lattice, slice, sliced.positions[next])),
                       row(scaled.sample_steps, next));
    }
  }
}

void round_to_precision(SlicedBrdf& sliced, double precision) {
  Scaled scaled = scale_values(sliced, precision);
  sliced.crossing_values = std::move(scaled.crossing_values);
  sliced.sample_values = std::move(scaled.sample_values);
  sliced.domain.reference = std::move(scaled.references);
  if (!sliced.guide) return;
  for (float& v : sliced.guide->values) v = guide_value(scaled.scale, guide_step(scaled.scale, v));
}

}  // namespace sbrdf::internal
