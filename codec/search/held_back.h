#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "codec/evaluation/evaluator.h"
#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf::internal {

/// Directions that no sample is placed by, with the source's values: what a structure is judged on. Means over them are
/// those of the uniform draw: theta of both uniform in [0, theta_max] and both azimuths uniform, as on the paper's grid
/// but between its nodes. They come from HighlightDraw, and of these more are kept where the source is large, which
/// weigh less in return, so that highlights are looked at densely, however narrow.
struct HeldBack {
  std::vector<DirectionPair> pairs;
  std::vector<double> weights;  ///< sum to 1
  std::vector<float> values;    ///< f_r, channel fastest
};

/// Which directions are drawn.
struct HeldBackDraw {
  std::size_t count = 0;
  std::uint64_t seed = 1;
  bool isotropic = false;  ///< phi_v = 0
  double theta_max_deg = kPaperThetaMaxDeg;
  /// Of many pairs, which are measured (1) and which are not (0): only the former are kept. Empty: all are.
  std::function<void(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags)> measured = {};
};
/// About `count` pairs, fewer where most are not measured; the same for a seed. The errors of `measure`.
[[nodiscard]] Result<HeldBack> draw_held_back(const HeldBackDraw& draw, std::size_t channel_count,
                                              const Measure& measure);

/// Some of them, evenly picked: less to judge by at a glance.
[[nodiscard]] HeldBack first_of(const HeldBack& held_back, std::size_t count);

/// Of such values no relative error can be stated.
[[nodiscard]] bool all_zero(const HeldBack& held_back);

/// Smallest denominator of relative errors [1/sr]: a hundredth of the mean |f|.
[[nodiscard]] double mre_floor(const HeldBack& held_back);

/// Of all pairs, on all cores, channel fastest.
[[nodiscard]] std::vector<float> evaluate(const Evaluator& evaluator, std::span<const DirectionPair> pairs);

/// Never NaN. Infinite where the result is no number, and where it is not 0 though all held-back values are.
struct HeldBackError {
  double mre_percent = 0;     ///< 100 x mean |f - r| / max(|f|, mre_floor)
  double rel_l1_percent = 0;  ///< 100 x sum |f - r| / sum |f|
};
[[nodiscard]] HeldBackError judge(const Evaluator& evaluator, const HeldBack& held_back);
/// The same of the values that evaluate() has given.
[[nodiscard]] HeldBackError judge(std::span<const float> values, const HeldBack& held_back);

}  // namespace sbrdf::internal
