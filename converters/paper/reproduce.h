#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "converters/baselines/scheme_samples.h"
#include "converters/files/atlas/atlas_judge.h"
#include "converters/paper/published.h"
#include "converters/slicing/slicing.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

// The tables of Vávra & Filip, "Adaptive Measurement of Anisotropic Material Appearance", Pacific Graphics 2017,
// supplemental material, made again with this implementation.

/// One cell of the accuracy tables (Figures 5 to 14).
struct AccuracyRow {
  std::string material;
  PaperMethod method = PaperMethod::kProposed;
  std::uint64_t samples = 0;
  std::string structure;   ///< "14/36", the frame that a search chose, or "scheme 14"
  double mre_percent = 0;  ///< over the 2-degree grid, no floor
  double paper_mre_percent = 0;
  double off_grid_mre_percent = 0;     ///< over random directions, no floor
  double off_grid_rel_l1_percent = 0;  ///< on the same
  std::uint64_t false_values = 0;      ///< on the same, of three for each pair
  bool exchanged_in_paper = false;     ///< the document's Figures 7 and 8 carry each other's MRE column; put right here
};

struct AccuracyOptions {
  std::vector<std::string> materials;  ///< names as kurt_material() takes them, in any order; empty: all ten
  std::vector<PaperMethod> methods;    ///< in any order; empty: all three
  /// Of the four the one that comes nearest to the paper's figures; it does not tell its own.
  RbfKernel kernel = RbfKernel::kInverseMultiquadric;
  std::uint64_t random_count = 0;  ///< 0: all 54,464,400 pairs; else so many random ones of them, and off the grid
  std::uint64_t seed = 1;
  bool automatic = false;  ///< let the search choose the structure, instead of Table 3 in the elevation frame
  SliceOptions slices;     ///< domain, refinement, mirrors and search effort; the rest is set per row
};

/// The materials x {8,911; 18,721} samples x methods, in this order of growing, materials and methods as in the paper.
/// Samples are not rounded, as in the paper. kUsage for a name that is none of the ten.
[[nodiscard]] Result<std::vector<AccuracyRow>> reproduce_accuracy(const AccuracyOptions& options,
                                                                  const Progress& progress = {});

/// exp(mean(log(mre / paper's mre))) over the rows of a method and a sample count, of which there is one or more.
[[nodiscard]] double mean_ratio_to_paper(std::span<const AccuracyRow> rows, PaperMethod method, std::uint64_t samples);

/// In how many materials and sample counts, of those that have rows of both, the proposed method has the smaller MRE.
struct PaperOrdering {
  std::size_t cells = 0;
  std::size_t proposed_better = 0;
  std::vector<std::string> otherwise;  ///< where it has not: "fabric112 at 8,911"
};
[[nodiscard]] PaperOrdering ordering_against(std::span<const AccuracyRow> rows, PaperMethod method);

/// One line of Table 5: a way to put a material onto a graphics card, as files that were made for it.
struct TextureSizes {
  struct File {
    std::string name;
    std::vector<std::byte> bytes;
  };

  std::string method;     ///< "proposed", "barycentric", "engine layout"
  std::string structure;  ///< "14/36", "scheme 14", "BC6H"
  std::uint64_t samples = 0;
  std::optional<double> paper_megabytes = {};       ///< of 2^20 bytes
  std::optional<std::uint64_t> formula_bytes = {};  ///< from the numbers of slices, or of directions, alone
  std::uint64_t texel_bytes = 0;                    ///< of the textures in the files, unpacked
  std::vector<File> files = {};
  AtlasErrors of_source = {};  ///< against the material, on directions that are dense in highlights

  [[nodiscard]] std::uint64_t file_bytes() const;
};

/// Table 5 for a material as kurt_material() takes it: the paper's four textures as float32 in OpenEXR; the look-up of
/// barycentric interpolation as two cube maps in KTX2 and the samples in OpenEXR, whose layout the paper does not give
/// (BarycentricCube); and this program's own layout with compressed texels, of as many samples in the same places but
/// logarithms.
[[nodiscard]] Result<std::vector<TextureSizes>> reproduce_storage(const std::string& material,
                                                                  const Progress& progress = {});

struct PlacementOptions {
  std::vector<std::uint64_t> counts;  ///< rising; each at least 55
  std::uint64_t random_count = 10'000;
  std::uint64_t seed = 1;
  SliceOptions slices;  ///< domain and refinement
};

/// Section 6 at one sample count: placements as indices into table_3_placements().
struct PlacementRow {
  std::uint64_t samples = 0;
  std::size_t best = 0;                          ///< by Equation 1 over all materials
  std::size_t table_3 = 0;                       ///< what the paper's Table 3 says
  std::vector<std::size_t> best_without;         ///< Equation 1 with one material left out, per material
  std::vector<std::vector<double>> mre_percent;  ///< [material][placement]; NaN where the crossings exceed the samples
};

struct PlacementStudy {
  std::vector<std::string> materials;
  std::vector<PlacementRow> rows;
  /// Table 4: mean over the counts of MRE(placement) / MRE(best placement of that material), per material.
  std::vector<double> increase;          ///< with the placement of Equation 1
  std::vector<double> increase_table_3;  ///< with that of the paper's Table 3
  std::vector<double> paper_increase;    ///< what Table 4 says
};

[[nodiscard]] Result<PlacementStudy> reproduce_placement(const PlacementOptions& options,
                                                         const Progress& progress = {});

/// "14/36".
[[nodiscard]] std::string placement_text(const Placement& placement);

}  // namespace sbrdf::internal
