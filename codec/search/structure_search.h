#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "codec/frame/outline.h"
#include "codec/sampling/adaptive_sampling.h"
#include "codec/search/held_back.h"

namespace sbrdf::internal {

/// What an error is when structures are compared.
enum class Objective : std::uint8_t {
  kBoth,   ///< sqrt(MRE x relative L1)
  kMre,    ///< mean relative error
  kRelL1,  ///< sum |f - r| / sum |f|
};
[[nodiscard]] double objective_value(const HeldBackError& error, Objective objective);

/// How much a structure is worth: what searches compare.
struct Standard {
  Objective objective = Objective::kBoth;
  /// What fewer samples can do. Objective::kBoth takes nothing that is worse by either error, however good by the
  /// other.
  HeldBackError ceiling = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

  /// The error to make small; infinite for what must not be taken.
  [[nodiscard]] double value_of(const HeldBackError& error) const;
};

/// All choices that a material leaves open.
struct Structure {
  FrameOutline outline;
  DomainKind domain = DomainKind::kLog;
  int floor_halvings = 5;
  double value_exponent = 0.5;
  std::optional<double> guide_ratio;  ///< of no effect but in the half/difference frame and the log domain
};

/// Which of the choices are fixed beforehand.
struct SearchOptions {
  std::optional<FrameId> frame;
  std::optional<DomainKind> domain;
  Symmetries symmetries;
  double theta_max_deg = kPaperThetaMaxDeg;  ///< of the frames
  Objective objective = Objective::kBoth;
  SamplingOptions sampling;  ///< count, refinement and minimum gap; the rest comes from the structure
  /// How many structures are tried for each number of samples, 1 or more (with 1, the densest start for the fewest
  /// samples is kept): no more starts than this, and rounds of moves (some fifty each) of each frame for as long as it
  /// tried fewer; a round is finished.
  std::size_t evaluations = 200;
  bool starts_only = false;  ///< no moves
  /// Called between rounds with the fraction done; false asks to stop.
  std::function<bool(double)> progress;
};

struct SearchResult {
  Structure structure;
  HeldBackError error;               ///< on the held-back directions
  std::vector<std::string> reasons;  ///< for people: what was tried and how far it came, a line each
};

/// Finds the structure with the least error on `held_back` within the sample budget. Each frame goes its own way: the
/// best of regular starts, in the better domain, then rounds of moves (a node more, less or elsewhere; another floor or
/// guide). A round looks at all moves on a few of the directions and makes those together that help most. First for a
/// sixteenth of the samples, say, then a quarter and all of them, where what was found before is the start, and
/// Objective::kBoth takes no structure that is worse by either error than that one is with fewer samples or with as
/// many: so errors hardly ever grow with more samples. A frame that is far behind the other is given up.
/// `measure` is called from several threads at once. The same result for any number of threads. kUsage where no
/// structure fits the budget, kUnsupported where all errors are infinite.
[[nodiscard]] Result<SearchResult> search_structure(const std::vector<std::string>& channels, const Measure& measure,
                                                    const HeldBack& held_back, const SearchOptions& options);

/// The sampling options that make a structure real.
[[nodiscard]] SamplingOptions sampling_for(const Structure& structure, SamplingOptions options);

}  // namespace sbrdf::internal
