#include "converters/slicing/options.h"

#include <cmath>

namespace sbrdf::internal {

Status check_options(const SliceOptions& options) {
  const auto* fixed = std::get_if<SampleCount>(&options.stop);
  if (fixed != nullptr && fixed->count > kMaxSampleCount) {
    return usage_error("at most 1,000,000 samples can be asked for");
  }
  const std::optional<double> target = target_percent(options.stop);
  if (target && !(*target > 0 && std::isfinite(*target))) return usage_error("a target must be above 0 %");
  const auto* search = std::get_if<SearchedStructure>(&options.structure);
  if (search != nullptr && search->evaluations == 0) return usage_error("a search must try one structure or more");
  const double theta_max = options.theta_max_deg.value_or(90);
  if (!(theta_max >= kLeastThetaMaxDeg && theta_max <= 90)) return usage_error("theta_max must be in [5, 90] degrees");
  const double gap = sampling_of(options).minimum_gap_deg;
  if (!(gap >= 0.01 && gap <= 90)) return usage_error("the minimum gap must be in [0.01, 90] degrees");
  return ok_status();
}

bool fits_values(const SliceOptions& options) {
  return options.fit_values && options.refinement == Refinement::kBySource;
}

std::optional<double> target_percent(const StopRule& rule) {
  if (const auto* mre = std::get_if<TargetMre>(&rule)) return mre->percent;
  if (const auto* rel_l1 = std::get_if<TargetRelL1>(&rule)) return rel_l1->percent;
  return std::nullopt;
}

Objective objective_of(const StopRule& rule) {
  if (std::holds_alternative<TargetMre>(rule)) return Objective::kMre;
  return std::holds_alternative<TargetRelL1>(rule) ? Objective::kRelL1 : Objective::kBoth;
}

SamplingOptions sampling_of(const SliceOptions& options) {
  SamplingOptions sampling;
  sampling.refinement = options.refinement;
  sampling.minimum_gap_deg = options.minimum_gap_deg.value_or(options.refinement == Refinement::kBySource ? 0.01 : 1);
  sampling.domain = options.domain.value_or(DomainKind::kLog);
  return sampling;
}

}  // namespace sbrdf::internal
