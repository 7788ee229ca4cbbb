#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "converters/judge/albedo.h"
#include "converters/judge/node_checks.h"
#include "converters/judge/pair_checks.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

/// Something that a user should know about a source; specs/check.md lists them with their thresholds.
struct CheckRemark {
  std::string topic;        ///< "albedo", "scale", "cosine", "exchange", "spikes" and the like
  std::string text;         ///< one line with the evidence in numbers
  bool suspicious = false;  ///< the data are probably wrong; else it is only good to know
};

/// All that is known about how plausible a source is.
struct CheckReport {
  std::vector<Albedo> albedos;  ///< theta_i 0, 15, ... 75, 85 degrees; anisotropic: four phi_i each
  SelfDifference reciprocity;
  PairChecks pairs;
  Shares shares;                 ///< of all nodes, or of the pairs
  bool shares_of_nodes = false;  ///< of a table
  std::optional<SpikeSearch> spikes;
  std::string spikes_in;  ///< what was searched, or why nothing was
  std::vector<GrazingGrowth> grazing;
  std::vector<CheckRemark> remarks;

  /// The largest albedo of a light up to the source's theta_max, from views up to it.
  double highest_albedo = 0;
  Direction highest_at;
  std::size_t highest_channel = 0;

  [[nodiscard]] std::size_t suspicious_count() const;
  /// "plausible" or "suspicious: 2 remarks".
  [[nodiscard]] std::string verdict() const;
};

/// Looks at everything. The same bits for any number of threads. interrupted_error().
[[nodiscard]] Result<CheckReport> check_source(const BrdfSource& source, const AlbedoOptions& options = {},
                                               const Progress& progress = {});

/// What the figures of a report say: its remarks. By itself, so that thresholds can be read and tested in one place.
[[nodiscard]] std::vector<CheckRemark> remarks_on(const CheckReport& report, const SourceTraits& traits);

}  // namespace sbrdf::internal
