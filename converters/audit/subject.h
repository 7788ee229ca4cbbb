#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codec/search/held_back.h"
#include "converters/drawing/sampled_source.h"
#include "converters/source/brdf_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What is audited: a source made reciprocal and without holes, and the directions that every way of keeping it is
/// judged on, between the nodes of any grid and densely in highlights. The source must outlive it.
class AuditSubject {
 public:
  /// `directions`: how many are judged on. kInvalidFile where the source gives a value that is not finite, or none that
  /// is not 0 on them.
  [[nodiscard]] static Result<AuditSubject> make(const BrdfSource& source, std::uint64_t directions);

  /// What is kept.
  [[nodiscard]] const BrdfSource& source() const { return sampled_->sampled(); }
  /// As it was opened.
  [[nodiscard]] const BrdfSource& original() const { return sampled_->source(); }
  [[nodiscard]] Symmetries symmetries() const { return sampled_->symmetries(); }
  [[nodiscard]] std::size_t channel_count() const { return original().channel_count(); }
  [[nodiscard]] double theta_max_deg() const { return sampled_->theta_max_deg(); }
  /// Judged on; and an even pick of these, for choices that are checked later.
  [[nodiscard]] const HeldBack& judged() const { return judged_; }
  [[nodiscard]] const HeldBack& few() const { return few_; }

  /// Relative L1 of values at few().pairs, or of another source at judged().pairs [%].
  [[nodiscard]] double few_percent(std::span<const float> values) const;
  [[nodiscard]] double error_percent(const BrdfSource& test) const;

 private:
  AuditSubject() = default;

  std::unique_ptr<const SampledSource> sampled_;
  HeldBack judged_;
  HeldBack few_;
};

}  // namespace sbrdf::internal
