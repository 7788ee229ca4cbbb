#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "converters/source/progress.h"

namespace sbrdf::internal {

// Numerical stability of evaluation, judged on sampled analytic functions. "Exact" is the same equations in long
// double.
//
// Float evaluation is to stay within 2e-5 of the exact value in the log domain, and within 1e-5 of the local maximum in
// the linear domain: the largest of the samples that enclose the point on the slices that are combined there. Where
// that comes from (specs/stress.md): a value v is rounded by up to |v| 2^-24, and the sum p + q + s + t - 3c has
// absolute coefficients that add up to 4 + 3 = 7, so one rounding in each term makes 7 |v| 2^-24. Linear: v = f_r,
// which is 4.2e-7 of the local maximum. Log: v = log(f / reference), whose absolute error is the relative error of f;
// |v| = 10, a factor of 22,000 from the reference, makes 4.2e-6.

/// One row of the suite.
struct StressRow {
  std::string name;  ///< topic, frame, domain and evaluation
  std::string what;  ///< what was tried, and in which unit `worst` is
  std::uint64_t cases = 0;
  double worst = 0;  ///< NaN where some error was not a number
  double limit = 0;
  bool passed = false;  ///< there were cases, and worst <= limit
};

/// Which evaluation is judged.
enum class StressEvaluation : std::uint8_t {
  kPlain,   ///< Evaluator
  kKernel,  ///< VectorEvaluator, at the same coordinates
};

/// What is judged, for tests of the suite itself.
struct StressSubject {
  std::function<float(float value)> distort;  ///< changes each result of float evaluation; empty: nothing
  std::string topic;                          ///< only the rows of this topic; empty: all
  std::vector<StressEvaluation> evaluations = {StressEvaluation::kPlain, StressEvaluation::kKernel};
};

/// The topics, in the order of their rows. Each has a row for every frame, domain and
/// evaluation to which it applies.
[[nodiscard]] std::vector<std::string> stress_topics();

/// The same rows for the same seed. Where `progress` asks to stop, the rows so far.
[[nodiscard]] std::vector<StressRow> run_stress(std::uint64_t seed, const Progress& progress = {},
                                                const StressSubject& subject = {});

}  // namespace sbrdf::internal
