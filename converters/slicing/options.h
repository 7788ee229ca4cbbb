#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "codec/file/encoder.h"
#include "codec/search/structure_search.h"
#include "converters/slicing/placements.h"

namespace sbrdf::internal {

inline constexpr std::uint64_t kDefaultSampleCount = 4096;
inline constexpr std::size_t kDefaultSearchEvaluations = 200;
inline constexpr double kLeastThetaMaxDeg = 5;
inline constexpr std::uint64_t kMaxSampleCount = 1'000'000;

/// So many samples, crossings included: at most kMaxSampleCount. Fewer where every interval is at the smallest gap.
struct SampleCount {
  std::uint64_t count = kDefaultSampleCount;
};
/// The fewest samples whose mean relative error on held-back directions is not above this; above 0.
struct TargetMre {
  double percent = 0;
};
/// The same for the relative L1 error.
struct TargetRelL1 {
  double percent = 0;
};
/// The most samples whose file is not larger.
struct MaxBytes {
  std::uint64_t count = 0;
};
/// When to stop.
using StopRule = std::variant<SampleCount, TargetMre, TargetRelL1, MaxBytes>;

/// Frame, nodes, guide and, where it is open, the domain are chosen by the error on held-back directions.
struct SearchedStructure {
  std::optional<FrameId> frame = std::nullopt;  ///< open: both are tried
  bool use_mirrors = true;  ///< look for mirror symmetries of the source and use those that hold exactly
  std::size_t evaluations = kDefaultSearchEvaluations;  ///< see SearchOptions::evaluations; 1 or more
};
/// Where slices lie. A placement fixes the frame to the elevation frame and its symmetries to reciprocity and, for
/// isotropic sources, isotropy, as in the paper: nothing is searched.
using StructureRule = std::variant<SearchedStructure, Placement>;

/// How much a file tells of how it came to be.
enum class MetadataDetail : std::uint8_t {
  kNone,  ///< nothing
  kLean,  ///< format and checksum of the source, errors, findings, and what symmetrising changed
  kFull,  ///< all that the specification has a key for
};

/// How a source is sampled into slices, and how a file of these is coded.
struct SliceOptions {
  StopRule stop = SampleCount{};
  StructureRule structure = SearchedStructure{};
  std::optional<DomainKind> domain;  ///< open: a search chooses; with a placement the log domain
  Refinement refinement = Refinement::kBySource;
  /// Values at samples are moved so that the whole comes nearest to the source (see fit_values), where this helps. Only
  /// with Refinement::kBySource: measured values are kept otherwise.
  bool fit_values = true;
  /// Of the slices, kLeastThetaMaxDeg to 90, in whole hundredths where frames are searched for. Open: the source's
  /// slice_theta_max_deg; for a placement the paper's.
  std::optional<double> theta_max_deg;
  std::optional<double> minimum_gap_deg;  ///< open: 1 for Refinement::kByMeasured (the paper's), 0.01 for kBySource

  std::optional<double> precision;  ///< see EncodeOptions::precision; open: as coarse as the error allows
  ChunkSize chunks = ChunkSize::kAuto;
  MetadataDetail metadata = MetadataDetail::kLean;
  std::string source_sha256;  ///< of the file that the source was read from, for the metadata; may be empty
  std::string command;        ///< that asked for this, for the metadata; may be empty
};

/// kUsage, saying what may be, for a number that may not.
[[nodiscard]] Status check_options(const SliceOptions& options);

/// Whether values are fitted under these options.
[[nodiscard]] bool fits_values(const SliceOptions& options);

/// [%], of the error that objective_of() names; open where the number of samples or of bytes decides.
[[nodiscard]] std::optional<double> target_percent(const StopRule& rule);

/// What structures are compared by under this rule.
[[nodiscard]] Objective objective_of(const StopRule& rule);

/// What all structures have in common; the number of samples is left at 0.
[[nodiscard]] SamplingOptions sampling_of(const SliceOptions& options);

}  // namespace sbrdf::internal
