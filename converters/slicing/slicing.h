#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "codec/file/encoder.h"
#include "codec/material/sliced_brdf.h"
#include "codec/sampling/adaptive_sampling.h"
#include "codec/search/held_back.h"
#include "codec/search/structure_search.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf {

/// The paper's placement of slices in the elevation frame: steps of elevation and azimuth [degrees].
struct Placement {
  double elevation_step_deg = 14;
  double azimuth_step_deg = 36;

  bool operator==(const Placement&) const = default;
};

/// The paper's Table 3: the placement for a number of samples.
[[nodiscard]] Placement table_3_placement(std::uint64_t sample_count);
/// The 17 placements of Table 3, from few crossings to many.
[[nodiscard]] std::span<const Placement> table_3_placements();

inline constexpr std::uint64_t kDefaultSampleCount = 4096;
inline constexpr std::size_t kDefaultSearchEvaluations = 200;
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

/// How a source is sampled into slices.
struct SliceOptions {
  StopRule stop = SampleCount{};
  StructureRule structure = SearchedStructure{};
  std::optional<DomainKind> domain;  ///< open: a search chooses; with a placement the log domain
  Refinement refinement = Refinement::kBySource;
  std::optional<double> minimum_gap_deg;  ///< open: 1 for Refinement::kByMeasured (the paper's), 0.1 for kBySource

  EncodeOptions encoding = {0.001};  ///< errors are measured on what a file of this precision gives back
  std::string source_sha256;         ///< of the file that the source was read from, for the metadata; may be empty
  std::string command;               ///< that asked for this, for the metadata; may be empty
};

/// What slicing changed. Counts are of channel values among the samples taken.
struct SliceReport {
  double reciprocity_difference_percent = 0;  ///< of the source before it was symmetrised
  std::uint64_t values = 0;
  std::uint64_t zero_values = 0;
  std::uint64_t negative_values = 0;
  std::uint64_t wanted_samples = 0;
  HeldBackError error;  ///< on directions that took no part in any choice
  std::uint64_t error_directions = 0;
  bool error_values_all_zero = false;  ///< the source is zero on them: the error is 0 or infinite, and says nothing
  std::vector<std::string> reasons;    ///< why this structure, where one was searched for
};

struct Slicing {
  SlicedBrdf sliced;
  Lattice lattice;
  SliceReport report;
};

/// Samples a source into slices. One that is not reciprocal is replaced by the mean of f(i,v) and f(v,i). `metadata` of
/// the result records the source, the choices and the report.
///
/// kUsage for a placement or a number of samples that cannot be; kInvalidFile where the source gives a NaN, an
/// infinity, or no positive value at all; kDifference where a target cannot be reached, kUnsupported where no structure
/// has a finite error; interrupted_error() where `progress` asked to stop.
[[nodiscard]] Result<Slicing> slice_source(const BrdfSource& source, const SliceOptions& options,
                                           const Progress& progress = {});

}  // namespace sbrdf
