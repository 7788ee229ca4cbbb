#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "codec/frame/frame.h"
#include "codec/search/held_back.h"
#include "converters/source/brdf_source.h"
#include "converters/source/filled_source.h"

namespace sbrdf::internal {

/// Seeds of draws: what choices are made by, what results are judged on, what values are fitted to.
inline constexpr std::uint64_t kChoiceSeed = 1;
inline constexpr std::uint64_t kReportSeed = 2;
inline constexpr std::uint64_t kFitSeed = 3;
inline constexpr std::size_t kHeldBackCount = 12'000;

/// kInvalidFile, saying where, for a value that is not finite.
[[nodiscard]] Status evaluate_checked(const BrdfSource& source, std::span<const DirectionPair> pairs,
                                      std::span<float> values);
/// The same on all cores.
[[nodiscard]] Status evaluate_checked_in_parallel(const BrdfSource& source, std::span<const DirectionPair> pairs,
                                                  std::span<float> values);

/// Which symmetries of a source are used beside reciprocity.
enum class SymmetryUse : std::uint8_t {
  kStated,    ///< isotropy where the source itself says so
  kIsotropy,  ///< isotropy, where it is found, too
  kAll,       ///< and mirrors
};

/// A source as it is sampled: made reciprocal, and without holes, where it is not. The source must outlive it.
class SampledSource {
 public:
  /// Symmetries are looked for up to theta_max.
  SampledSource(const BrdfSource& source, double theta_max_deg, SymmetryUse use);

  /// What is sampled.
  [[nodiscard]] const BrdfSource& sampled() const { return *sampled_; }
  [[nodiscard]] const BrdfSource& source() const { return *source_; }
  /// Where not all directions were measured; else nullptr.
  [[nodiscard]] const FilledSource* filled() const { return filled_.get(); }
  [[nodiscard]] double theta_max_deg() const { return theta_max_deg_; }
  [[nodiscard]] Symmetries symmetries() const { return symmetries_; }
  /// Of the source before it was made reciprocal.
  [[nodiscard]] double reciprocity_difference_percent() const { return reciprocity_difference_percent_; }

  /// Directions that were measured, with their values. kInvalidFile where there are none, or a value is not finite.
  [[nodiscard]] Result<HeldBack> draw(std::uint64_t seed, std::size_t count = kHeldBackCount) const;

 private:
  const BrdfSource* source_;
  std::unique_ptr<const BrdfSource> symmetrised_;
  std::unique_ptr<const FilledSource> filled_;
  const BrdfSource* sampled_;
  double theta_max_deg_;
  double reciprocity_difference_percent_;
  Symmetries symmetries_;
};

}  // namespace sbrdf::internal
