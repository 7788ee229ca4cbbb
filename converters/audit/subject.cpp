#include "converters/audit/subject.h"

#include <algorithm>

#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

/// Not that of what anybody chooses by.
constexpr std::uint64_t kAuditSeed = 4;
constexpr std::size_t kFew = 6000;

}  // namespace

Result<AuditSubject> AuditSubject::make(const BrdfSource& source, std::uint64_t directions) {
  const double theta_max = std::min(kPaperThetaMaxDeg, source.traits().slice_theta_max_deg);
  AuditSubject subject;
  subject.sampled_ = std::make_unique<SampledSource>(source, theta_max, SymmetryUse::kAll);
  Result<HeldBack> judged = subject.sampled_->draw(kAuditSeed, directions);
  if (!judged) return judged.error();
  if (all_zero(*judged)) return invalid_file("it is 0 wherever it was looked at: no relative error can be stated");
  subject.judged_ = *std::move(judged);
  subject.few_ = first_of(subject.judged_, kFew);
  return subject;
}

double AuditSubject::few_percent(std::span<const float> values) const { return judge(values, few_).rel_l1_percent; }

double AuditSubject::error_percent(const BrdfSource& test) const {
  std::vector<float> values(judged_.values.size());
  evaluate_in_parallel(test, judged_.pairs, values);
  return judge(values, judged_).rel_l1_percent;
}

}  // namespace sbrdf::internal
