#include "converters/drawing/sampled_source.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "converters/source/reciprocity.h"
#include "converters/source/symmetry_detection.h"

namespace sbrdf::internal {
namespace {

std::string at_degrees(const DirectionPair& pair) {
  const auto text = [](const char* name, double radians) {
    return std::string(name) + " " + std::to_string(degrees_from_radians(radians));
  };
  return text("theta_i", pair.i.theta) + ", " + text("phi_i", pair.i.phi) + ", " + text("theta_v", pair.v.theta) +
         ", " + text("phi_v", pair.v.phi) + " degrees";
}

Status check_finite(std::span<const DirectionPair> pairs, std::span<const float> values) {
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == values.end()) return ok_status();
  const std::size_t k = static_cast<std::size_t>(bad - values.begin()) / (values.size() / pairs.size());
  return invalid_file("the value at " + at_degrees(pairs[k]) + " is not finite");
}

}  // namespace

Status evaluate_checked(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<float> values) {
  source.evaluate(pairs, values);
  return check_finite(pairs, values);
}

Status evaluate_checked_in_parallel(const BrdfSource& source, std::span<const DirectionPair> pairs,
                                    std::span<float> values) {
  evaluate_in_parallel(source, pairs, values);
  return check_finite(pairs, values);
}

SampledSource::SampledSource(const BrdfSource& source, double theta_max_deg, SymmetryUse use)
    : source_(&source),
      sampled_(&source),
      theta_max_deg_(theta_max_deg),
      reciprocity_difference_percent_(internal::reciprocity_difference_percent(source)) {
  if (!source.traits().reciprocal) {
    symmetrised_ = std::make_unique<SymmetrisedSource>(source);
    sampled_ = symmetrised_.get();
  }
  if (source.mask_grid()) {
    filled_ = std::make_unique<FilledSource>(*sampled_);
    sampled_ = filled_.get();
  }
  symmetries_.isotropic = source.traits().isotropic;
  if (use == SymmetryUse::kStated) return;
  symmetries_ = detect_symmetries(*sampled_, theta_max_deg);
  if (use == SymmetryUse::kIsotropy) symmetries_.mirror_x = symmetries_.mirror_y = false;
}

Result<HeldBack> SampledSource::draw(std::uint64_t seed, std::size_t count) const {
  HeldBackDraw wanted = {count, seed, symmetries_.isotropic, theta_max_deg_};
  if (filled_) wanted.measured = [&](auto pairs, auto flags) { filled_->measured(pairs, flags); };
  Result<HeldBack> drawn = draw_held_back(wanted, source_->channel_count(), [&](auto pairs, auto values) {
    return evaluate_checked_in_parallel(*sampled_, pairs, values);
  });
  if (drawn && drawn->pairs.empty()) return invalid_file("none of the directions drawn to judge by was measured");
  return drawn;
}

}  // namespace sbrdf::internal
