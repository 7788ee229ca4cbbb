#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A source without holes: a pair that was not measured gets the value of a pair nearby that was. In cells of the
/// source's mask_grid(): of the measured cells that differ along one axis, the one at the least angle, with all other
/// coordinates of the pair as they are; where no such cell is measured, the measured cell nearest in the order of the
/// grid, at its centre. So the filling depends on the pair alone, and runs level into the holes.
///
/// `measured` and `mask_grid` still tell the truth. The source must outlive it, and have a mask_grid().
class FilledSource final : public BrdfSource {
 public:
  explicit FilledSource(const BrdfSource& source);

  [[nodiscard]] const SourceTraits& traits() const override { return source_.traits(); }
  [[nodiscard]] const std::vector<Finding>& findings() const override { return source_.findings(); }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    source_.measured(pairs, flags);
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return grid_; }

  /// Which cells are not measured, by their centres. Of a cell below the horizon the mask says what it says of the cell
  /// before, which takes the least to write down.
  [[nodiscard]] std::shared_ptr<const DirectionMask> mask() const { return mask_; }

 private:
  enum class State : std::uint8_t { kMeasured, kUnmeasured, kBelowHorizon };

  [[nodiscard]] std::vector<State> look_at_cells() const;
  void find_stand_ins(const std::vector<State>& states);
  [[nodiscard]] DirectionPair stand_in(const DirectionPair& pair) const;

  const BrdfSource& source_;
  MaskGrid grid_;
  std::shared_ptr<const DirectionMask> mask_;
  std::vector<std::uint32_t> stand_ins_;  ///< of each cell: itself where it is measured
};

}  // namespace sbrdf::internal
