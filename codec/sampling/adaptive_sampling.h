#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// Measures f_r [1/sr] of each pair into `values` (pairs.size() x channels, channel fastest). Values must be finite; a
/// measurement that fails, or is to stop, ends the sampling with its error.
using Measure = std::function<Status(std::span<const DirectionPair> pairs, std::span<float> values)>;

/// Which gaps between samples are halved first.
enum class Refinement : std::uint8_t {
  kByMeasured,  ///< Algorithm 1 of the paper: judged by what has been measured already, as a goniometer must
  kBySource,    ///< judged by the error of the spline against the source, which is looked at between the samples, too
};

struct SamplingOptions {
  std::uint64_t sample_count = 0;  ///< crossings included; must be at least their number
  Refinement refinement = Refinement::kByMeasured;
  double minimum_gap_deg = 1;  ///< of the slice's parameter; a gap narrower than twice this stays whole
  DomainKind domain = DomainKind::kLinear;
  int floor_halvings = kDefaultFloorHalvings;  ///< for the log domain

  GreyShares grey_shares;  ///< are added to what is measured

  /// Of the guide to take off (see Guide), which gets a twentieth of the samples. Only for the half/difference frame
  /// and the log domain.
  std::optional<double> guide_ratio;

  // kByMeasured: section 5 of the paper and what specs/conventions.md settles about it.
  double first_share = 0.9;  ///< k: share of the adaptive samples that is placed in the first p1 rounds
  int first_rounds = 5;      ///< p1
  int second_rounds = 5;     ///< p2

  // kBySource
  double value_exponent =
      0.5;  ///< errors in the log domain weigh f^this: 0 for the mean relative error, 1 for the L1 error
  std::uint64_t rounds_divisor = 8;  ///< each round places what is left divided by this
};

/// Places and measures samples along the slices until `sample_count` is reached. Deterministic. May end below when
/// every gap is at the minimum.
[[nodiscard]] Result<SlicedBrdf> sample_slices(const Lattice& lattice, std::vector<std::string> channels,
                                               const Measure& measure, const SamplingOptions& options);

}  // namespace sbrdf::internal
