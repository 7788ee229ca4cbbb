#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A source made reciprocal: the mean of f(i,v) and f(v,i), or the one of them that was measured. The wrapped source
/// must outlive it.
class SymmetrisedSource final : public BrdfSource {
 public:
  explicit SymmetrisedSource(const BrdfSource& source);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  [[nodiscard]] const std::vector<Finding>& findings() const override { return source_.findings(); }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override;
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return source_.mask_grid(); }

 private:
  const BrdfSource& source_;
  SourceTraits traits_;
};

/// How far a source is from reciprocal: 100 x sum |f(i,v) - f(v,i)| / sum (|f(i,v)| + |f(v,i)|) / 2 [%], over theta in
/// 0, 5, ..., 80 degrees and azimuths every 10 degrees. Exactly 0 for a source whose traits say that it is reciprocal.
[[nodiscard]] double reciprocity_difference_percent(const BrdfSource& source);

}  // namespace sbrdf::internal
