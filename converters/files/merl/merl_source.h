#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <vector>

#include "converters/files/merl/merl_cells.h"
#include "converters/files/merl/merl_census.h"
#include "converters/files/merl/merl_convention.h"
#include "converters/files/value_options.h"
#include "converters/source/brdf_source.h"
#include "converters/tables/dense_table.h"
#include "formats/core/byte_source.h"
#include "formats/core/named.h"
#include "formats/merl/merl.h"

namespace sbrdf::internal {

/// A MERL table that can be evaluated (specs/merl.md). Isotropic, as the table does not know phi_h; reciprocal unless
/// it covers a full turn of phi_d, as half a turn does not know the order of the two directions.
///
/// Values are interpolated linearly between the places of the cells, along theta_h in its square root, unless the
/// nearest cell is asked for. phi_d closes after half a turn, or a full one; the first and last cells of theta_h and
/// theta_d hold up to the ends of their axes. A cell whose three channels are all negative is a mark (unmeasured or
/// below the horizon): it is left out and the remaining weights are scaled up, and where only marks are near the value
/// is 0, but for pairs at the horizon, which take that shortly above it. A cell with one or two negative channels is
/// used as it is, with 0 in their place, or as a mark, as `policy` says; cells with a value that is not finite are
/// refused or taken as marks.
///
/// A pair is unmeasured where, of the cells around it, marks above the horizon weigh more than cells that are none.
///
/// The table stays where it is: cells are read from the file's view as they are needed, so a mapped file of any size
/// takes no memory of its own.
class MerlSource final : public BrdfSource {
 public:
  /// Keeps `file`; one without a view is read into memory. Errors as of parse_merl_shape; kInvalidFile also, with
  /// NonFinite::kRefuse, where a value is NaN, infinite or beyond kMerlLargest once scaled (the message counts them and
  /// names the first cell; `offset` is its place in the file), and where no value is positive.
  ///
  /// Looks at no more values than that takes. `findings()` counts the marks, those above the horizon by themselves, the
  /// cells with some negative channel, and those with a value that is not finite, of which it names the first: with the
  /// first that asks for these or for what was measured, all values are looked at once.
  ///
  /// A table whose size is that of 32-bit floats is kUnsupported unless the convention says so: half of a table of
  /// 64-bit ones has that size, too.
  ///
  /// With MerlTurn::kAuto, a table whose third count is even and not 180 is looked at: cells that are blank where one
  /// of the two readings has its horizon and the other has not; without blank cells, whether values half the dimension
  /// apart are as near as reciprocity makes them. What was concluded is a finding.
  static Result<std::unique_ptr<MerlSource>> make(std::shared_ptr<const ByteSource> file,
                                                  const ValuePolicy& policy = {},
                                                  const MerlConvention& convention = {});
  ~MerlSource() override;

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  [[nodiscard]] const std::vector<Finding>& findings() const override {
    census();
    return findings_;
  }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override;
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override;
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override;
  /// Its cells as nodes; nullptr where the nearest is taken, which no grid describes.
  [[nodiscard]] const DenseTable* table() const override { return table_.get(); }
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const override {
    return format == traits_.format && table_ != nullptr && !changes_values() ? file_ : nullptr;
  }

 private:
  /// R, G, B in f_r, then 1; all zero in a mark. Weighting all four also adds up the weights that count.
  using Cell = std::array<float, 4>;

  class CellValues;

  MerlSource(std::shared_ptr<const ByteSource> file, const MerlHead& head, const ValuePolicy& policy,
             const MerlConvention& convention);
  void settle_turn();
  [[nodiscard]] Status examine() const;
  /// The eight cells around a point: two neighbours along phi_d in four rows.
  struct Place {
    std::array<std::uint64_t, 4> rows;  ///< index of their first cell
    std::array<float, 4> row_weights;
    std::uint64_t low, high;  ///< in a row
    float high_weight;
  };

  /// Taken when it is asked for first.
  const MerlCensus& census() const;
  void add_findings() const;
  [[nodiscard]] bool changes_values() const;
  [[nodiscard]] bool is_mark(const MerlColour& colour) const;
  [[nodiscard]] std::unique_ptr<DenseTable> make_table() const;
  [[nodiscard]] DirectionPair away_from_horizon(DirectionPair pair) const;
  [[nodiscard]] bool is_measured(const Place& place) const;
  [[nodiscard]] Place place_of(const HalfDifference& angles) const;
  void fetch(const Place& place) const;
  // T is the type of the file's numbers.
  template <class T>
  [[nodiscard]] Cell cell(std::uint64_t index) const;
  template <class T>
  [[nodiscard]] Cell interpolate(const Place& place) const;
  template <class T>
  [[nodiscard]] Cell interpolate_marked(const Place& place) const;
  /// `pair_of(k)` is the pair at places[k]; where not above[k], values are 0.
  template <class T, class PairOf>
  void evaluate_numbers(std::span<const Place> places, std::span<const bool> above, const PairOf& pair_of,
                        float* values) const;
  template <class PairOf>
  void evaluate_places(std::span<const Place> places, std::span<const bool> above, const PairOf& pair_of,
                       float* values) const;

  std::shared_ptr<const ByteSource> file_;
  MerlCells cells_;
  MerlConvention convention_;
  ValuePolicy policy_;
  std::unique_ptr<DenseTable> table_;
  SourceTraits traits_;
  mutable std::once_flag census_asked_;
  mutable MerlCensus census_;
  mutable std::vector<Finding> findings_;
};

/// The cells of a table as a grid.
[[nodiscard]] Grid merl_cell_grid(const MerlShape& shape, const MerlConvention& convention);

/// "theta_h 3, theta_d 0, phi_d 7, channel G", for messages.
[[nodiscard]] std::string merl_cell_name(const MerlShape& shape, std::uint64_t cell, std::size_t channel);

/// What options say of it; `turn` where they do not.
[[nodiscard]] MerlConvention merl_convention_of(const Options& options, MerlTurn turn);

/// Opens a MERL file: the row of the format table. Options: merl-float32; merl-position; merl-lookup; merl-turn;
/// negatives; non-finite, of which the default is unmeasured.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_merl(std::shared_ptr<const ByteSource> file,
                                                            const Options& options = {});

}  // namespace sbrdf::internal
