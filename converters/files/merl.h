#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/merl/merl.h"

namespace sbrdf {

/// A MERL table that can be evaluated (specs/merl.md). Isotropic and reciprocal by construction: the table knows
/// neither phi_h nor the order of the two directions.
///
/// Values are interpolated linearly between cell centres, along theta_h in its square root. phi_d closes after pi; the
/// first and last cells of theta_h and theta_d hold up to the ends of their axes. A cell whose three channels are all
/// negative is a mark (unmeasured or below the horizon): it is left out and the remaining weights are scaled up, and
/// where only marks are near the value is 0. A cell with one or two negative channels is used as it is.
class MerlSource final : public BrdfSource {
 public:
  /// kInvalidFile where a value is NaN, infinite or beyond the range of float once scaled (the message counts them and
  /// names the first cell; `offset` is its place in the file), and where no value is positive.
  /// `traits().findings` counts the marks and the cells with some negative channel.
  static Result<std::unique_ptr<MerlSource>> make(MerlTable table);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;

  /// The table as it was given, bit for bit: a copy to another MERL file needs no resampling.
  [[nodiscard]] const MerlTable& table() const { return table_; }

 private:
  /// R, G, B in f_r, then 1; all zero in a mark. Weighting all four also adds up the weights that count.
  using Cell = std::array<float, 4>;

  explicit MerlSource(MerlTable table);
  [[nodiscard]] Cell interpolate(const HalfDifference& angles) const;

  MerlTable table_;
  SourceTraits traits_;
  std::vector<Cell> cells_;
};

/// What a resampled table lost against its source. Counts are of cells.
struct MerlReport {
  std::uint64_t cells = 0;
  std::uint64_t below_horizon = 0;      ///< the centre lies below the horizon: -1 in every channel, on disk
  std::uint64_t some_negative = 0;      ///< above the horizon, one or two channels negative: kept
  std::uint64_t all_negative = 0;       ///< above the horizon, all negative: kept, but readers take them for marks
  bool anisotropic_source_cut = false;  ///< the source varies with phi_h; the table holds phi_h = 0 only
  bool source_not_reciprocal = false;   ///< the table holds only one of f(i,v) and f(v,i)
  bool channel_repeated = false;        ///< the only channel of the source stands in R, G and B
};

struct MerlResampling {
  MerlTable table;
  MerlReport report;
};

/// Largest number of cells that resample_merl makes (6 GiB of values).
inline constexpr std::uint64_t kMerlMaxResampledCells = std::uint64_t{1} << 28;

/// The source's value at every cell's centre, at phi_h = 0, divided by kMerlScale. The same bits for any number of
/// threads. Nothing is symmetrised: of a source that is not reciprocal the table holds f(i,v) with the light at phi_d
/// in [0, pi), so give it one that was symmetrised before.
///
/// kUsage for a shape outside [1, kMerlMaxCount] or above kMerlMaxResampledCells; kUnsupported for a source with other
/// than three channels (taken as R, G, B) or one (repeated); kInvalidFile where the source gives a NaN or an infinity;
/// interrupted_error() where `progress` asked to stop.
Result<MerlResampling> resample_merl(const BrdfSource& source, const MerlShape& shape = kMerlShape,
                                     const Progress& progress = {});

}  // namespace sbrdf
