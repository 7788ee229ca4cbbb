#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

namespace sbrdf::internal {

/// Relative bounds that a Quantizer can be made for.
inline constexpr double kFinestBound = 1e-6;
inline constexpr double kCoarsestBound = 0.5;
/// Files state bounds in millionths: the greatest of these that is not above `bound`, which is in the range.
[[nodiscard]] std::uint32_t millionths_of(double bound);
[[nodiscard]] inline double bound_of(std::uint32_t millionths) { return millionths / 1e6; }

/// Which values a file can hold, as whole numbers: the *steps* that are predicted and coded. Steps rise with the
/// value, 0 is exactly 0, and step -n is the negative of step n.
///
/// Lossless: the bits of the float32, so every finite value has a step.
///
/// Bounded: a geometric series,
///
///     value(n) = r^(n - 1 + lowest) for n > 0,   r = 2^(1 / per_octave).
///
/// Between two neighbours g and g r the value that is worst off is the one as far from both, as a part of itself:
/// (v - g) / v = (g r - v) / v at v = g (1 + r) / 2, where it is off by (r - 1) / (r + 1). So r may be as large as
/// (1 + b) / (1 - b), b being the bound less what rounding to float32 adds, and per_octave is the least whole number
/// with r^per_octave >= 2 for it. Equal ratios are equal distances of steps: the differences that prediction leaves
/// are relative errors, alike for dark and bright values. specs/sbrdf.md, section 4.
///
/// Only additions, multiplications and divisions of doubles are used, in a fixed order: the same steps everywhere.
class Quantizer {
 public:
  /// Every float32 as it is.
  Quantizer() = default;
  /// The coarsest scale that keeps `bound` (relative, kFinestBound to kCoarsestBound), the last rounding to float32
  /// included, for values from 2^-126 to half the largest float.
  explicit Quantizer(double bound);
  /// As stored in a file.
  Quantizer(double bound, std::int32_t lowest);

  [[nodiscard]] bool lossless() const { return per_octave_ == 0; }
  [[nodiscard]] double bound() const { return bound_; }  ///< 0 if lossless
  [[nodiscard]] std::uint32_t per_octave() const { return per_octave_; }
  [[nodiscard]] double ratio() const { return ratio_; }
  [[nodiscard]] std::int32_t lowest() const { return lowest_; }

  /// Steps to a doubling, whatever the kind.
  [[nodiscard]] double steps_per_octave() const { return lossless() ? 8388608.0 : static_cast<double>(per_octave_); }

  /// Makes the smallest magnitude among all values, zeros aside, step 1. Lossless scales stay as they are.
  void begin_at_smallest(std::initializer_list<std::span<const float>> lists);

  /// The nearest step; finite values only.
  [[nodiscard]] std::int32_t step(float value) const;
  /// Infinite beyond the range of float32, which steps of values close to its end may round to.
  [[nodiscard]] float value(std::int32_t step) const;

 private:
  void make_table();
  [[nodiscard]] double magnitude(std::int64_t power) const;

  double bound_ = 0;
  std::uint32_t per_octave_ = 0;
  double ratio_ = 1;
  std::int32_t lowest_ = 0;            ///< step 1 is of magnitude ratio^lowest
  double reciprocal_ = 1;              ///< of per_octave
  std::vector<double> table_;          ///< ratio^k for k below per_octave
  std::vector<std::uint32_t> starts_;  ///< for 256 equal parts of [1, 2), the last entry of table_ not above its start
};

}  // namespace sbrdf::internal
