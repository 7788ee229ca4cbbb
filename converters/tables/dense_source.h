#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/source/brdf_source.h"
#include "converters/tables/dense_table.h"
#include "converters/tables/value_policy.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Largest |f_r| that a table may hold: weighted sums of such values still fit a float.
inline constexpr double kTableLargest = 1e38;

/// How far the values of a table are good for anything, as in SourceTraits.
struct MeasuredReach {
  double theta_max_deg = 90;
  double slice_theta_max_deg = 90;
  std::string beyond_theta_max;

  /// Both angles are above 0, at most 90 degrees, and in order.
  [[nodiscard]] bool is_valid() const {
    return slice_theta_max_deg > 0 && slice_theta_max_deg <= theta_max_deg && theta_max_deg <= 90;
  }
};
[[nodiscard]] inline MeasuredReach reach_of(const SourceTraits& traits) {
  return {traits.theta_max_deg, traits.slice_theta_max_deg, traits.beyond_theta_max};
}

/// What a reader of a dense table knows beside the table itself.
struct DenseDescription {
  std::string format;                      ///< name of the row of the format table
  std::string description;                 ///< one line for people
  std::vector<std::string> channels;       ///< as many as the table has
  std::shared_ptr<const ByteSource> file;  ///< for copies bit for bit; nullptr where options changed what it means
  ValuePolicy policy = {Negatives::kKeep, NonFinite::kUnmeasured};
  MeasuredReach reach;                          ///< where the file tells; the grid may say less
  std::vector<Finding> findings;                ///< what the reader saw, before those of the table
  std::string unmeasured = "nodes unmeasured";  ///< the finding on nodes that hold no number
};

/// A dense table that can be evaluated: linear between the 16 nodes around a pair (in what each axis is linear in),
/// with the ends of each axis as it says. Nodes that were not measured are left out and the remaining weights scaled
/// up; a pair is unmeasured where these weigh more, of those above the horizon. Where an axis is extrapolated, what
/// would become negative there and is not at the nodes, is 0, and what would become larger than kTableLargest is held
/// there. In half/difference and mirror coordinates a pair at the
/// horizon may lie among nodes below it alone: it takes the value shortly above.
class DenseSource final : public BrdfSource {
 public:
  /// Looks at every node once, on all cores. kInvalidFile where no value is positive, and, with NonFinite::kRefuse,
  /// where one is NaN, infinite or beyond kTableLargest; the message names the first such node. Findings count nodes
  /// that were not measured (those above the horizon), that hold an infinite value, and that have some negative
  /// channel.
  [[nodiscard]] static Result<std::unique_ptr<BrdfSource>> make(DenseTable table, DenseDescription description);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override;
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override;
  /// With the policy applied.
  [[nodiscard]] const DenseTable* table() const override { return &table_; }
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const override {
    return format == traits_.format ? file_ : nullptr;
  }

 private:
  DenseSource(DenseTable table, DenseDescription description);
  [[nodiscard]] Status examine(DenseDescription& description);

  DenseTable table_;
  std::shared_ptr<const ByteSource> file_;
  bool has_holes_ = false;  ///< above the horizon
  SourceTraits traits_;
};

/// A source as a dense table of it would give it back: the source at the nodes of the grid, interpolated between. What
/// `change` makes of the values of a node comes before. Keeps references: `source` must outlive it.
[[nodiscard]] DenseTable table_of_source(const BrdfSource& source, Grid grid,
                                         std::function<void(std::span<double>)> change = {});

/// The value that DenseSource gives at each of `pairs`, of any table, looking at no other node.
void interpolate_table(const DenseTable& table, std::span<const DirectionPair> pairs, std::span<float> values);

}  // namespace sbrdf::internal
