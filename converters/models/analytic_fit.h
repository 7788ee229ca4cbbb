#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "converters/models/analytic.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Of what the differences are squared.
enum class FitMetric : std::uint8_t {
  kLog,       ///< log(f + a thousandth of the channel's mean): all values count alike, relative to themselves
  kCubeRoot,  ///< cube root of f: bright values count more
};
inline constexpr std::array kFitMetricNames = {Named{"log", FitMetric::kLog}, Named{"cube-root", FitMetric::kCubeRoot}};

inline constexpr std::uint64_t kMostFitLobes = 6;
inline constexpr std::uint64_t kMostFitStarts = 10'000;

struct AnalyticFitOptions {
  LobeKind kind = LobeKind::kKurt;
  std::uint64_t lobes = 1;    ///< 1 to kMostFitLobes
  std::uint64_t starts = 24;  ///< so many sets of roughness, spread evenly, from which a minimum is looked for
  FitMetric metric = FitMetric::kLog;
};

struct AnalyticFit {
  AnalyticModel model;           ///< lobes from the roughest on
  double rms = 0;                ///< of the differences in the metric, over pairs and channels
  std::size_t pairs = 0;         ///< that were fitted to
  std::size_t same_minimum = 0;  ///< how many of the finished ones came within a hundredth of the best rms ...
  std::size_t finished = 0;      ///< ... of so many that were followed to their end
};

/// Fits an analytic model: every parameter, from a cold start, by Levenberg and Marquardt's method. Half of the pairs
/// are spread evenly in theta up to the source's slice_theta_max_deg, half lie densely around the mirror direction. A
/// source that is not reciprocal is fitted to its mean of both ways; one channel becomes three. The same on any number
/// of threads. kUnsupported where a source has other than one or three channels, or where too few pairs were measured;
/// interrupted_error().
[[nodiscard]] Result<AnalyticFit> fit_analytic(const BrdfSource& source, const AnalyticFitOptions& options,
                                               const Progress& progress = {});

}  // namespace sbrdf::internal
