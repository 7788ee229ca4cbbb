#include "converters/source/filled_source.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "codec/frame/frame.h"
#include "converters/source/reciprocity.h"

namespace sbrdf::internal {
namespace {

using Holes = std::function<bool(const DirectionPair&)>;
using Function = std::function<double(const DirectionPair&)>;

/// A function with holes, in which it is -7.
class HoleySource final : public BrdfSource {
 public:
  HoleySource(const MaskGrid& grid, Function function, Holes holes, bool reciprocal = true)
      : grid_(grid), function_(std::move(function)), holes_(std::move(holes)) {
    traits_.channels = {"grey"};
    traits_.isotropic = true;
    traits_.reciprocal = reciprocal;
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      values[k] = static_cast<float>(holes_(pairs[k]) ? -7 : function_(pairs[k]));
    }
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) flags[k] = holes_(pairs[k]) ? 0 : 1;
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return grid_; }

 private:
  MaskGrid grid_;
  Function function_;
  Holes holes_;
  SourceTraits traits_;
};

const MaskGrid kGrid = {MaskFrame::kHalfDifference, {1, 12, 18, 12}};

float value_at(const BrdfSource& source, const DirectionPair& pair) {
  float value = 0;
  source.evaluate(std::span(&pair, 1), std::span(&value, 1));
  return value;
}

std::vector<DirectionPair> random_pairs(std::size_t count) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> theta(0, 1.55);
  std::uniform_real_distribution<double> phi(0, 2 * kPi);
  std::vector<DirectionPair> pairs;
  for (std::size_t k = 0; k < count; ++k) pairs.push_back({{theta(random), phi(random)}, {theta(random), phi(random)}});
  return pairs;
}

double theta_d_of(const DirectionPair& pair) { return half_difference_from_pair(pair).theta_d; }
double theta_h_of(const DirectionPair& pair) { return half_difference_from_pair(pair).theta_h; }

TEST(FilledSource, RunsLevelIntoAHole) {
  const double edge = radians_from_degrees(70);
  const HoleySource source(
      kGrid, [](const DirectionPair& pair) { return 1 + std::exp(-theta_h_of(pair)) + theta_d_of(pair); },
      [&](const DirectionPair& pair) { return theta_d_of(pair) > edge; });
  const FilledSource filled(source);
  std::size_t holes = 0;
  for (const DirectionPair& pair : random_pairs(20000)) {
    if (theta_d_of(pair) <= edge) {
      EXPECT_EQ(value_at(filled, pair), value_at(source, pair));
      continue;
    }
    if (theta_h_of(pair) > 0.25) continue;  // the cell at 67.5 degrees may lie below the horizon
    ++holes;
    // 67.5 degrees is the last centre of the cells that are measured; theta_h is that of the pair.
    const double level = 1 + std::exp(-theta_h_of(pair)) + radians_from_degrees(67.5);
    EXPECT_NEAR(value_at(filled, pair), level, 1e-5);
  }
  EXPECT_GT(holes, 20U);
}

// By looking at all cells.
TEST(FilledSource, TakesTheNearestMeasuredCellThatDiffersAlongOneAxis) {
  std::mt19937_64 random(4);
  std::vector<bool> hole(kGrid.cell_count());
  for (std::size_t cell = 0; cell < hole.size(); ++cell) hole[cell] = random() % 8 < 5;
  const auto cell_value = [&](const DirectionPair& pair) { return static_cast<double>(kGrid.cell_of(pair)); };
  const HoleySource source(kGrid, cell_value, [&](const DirectionPair& pair) { return hole[kGrid.cell_of(pair)]; });
  const FilledSource filled(source);
  std::size_t tested = 0;
  for (std::uint64_t cell = 0; cell < hole.size(); ++cell) {
    const DirectionPair centre = kGrid.centre_of(cell);
    if (!hole[cell] || !above_horizon(centre)) continue;
    const MaskGrid::Place place = kGrid.place_of_centre(cell);
    double nearest = std::numeric_limits<double>::infinity();
    std::vector<std::uint64_t> best;
    for (std::uint64_t other = 0; other < hole.size(); ++other) {
      if (hole[other] || !above_horizon(kGrid.centre_of(other))) continue;
      const MaskGrid::Place there = kGrid.place_of_centre(other);
      std::size_t differing = 0;
      double distance = 0;
      for (std::size_t axis = 0; axis < 4; ++axis) {
        if (place[axis] == there[axis]) continue;
        ++differing;
        distance = kGrid.distance_deg(axis, place[axis], there[axis]);
      }
      if (differing != 1 || distance > nearest + 1e-3) continue;
      if (distance < nearest - 1e-3) best.clear();
      nearest = std::min(nearest, distance);
      best.push_back(other);
    }
    if (best.empty()) continue;
    const auto found = static_cast<std::uint64_t>(value_at(filled, centre));
    EXPECT_NE(std::find(best.begin(), best.end(), found), best.end()) << cell << " takes " << found;
    ++tested;
  }
  EXPECT_GT(tested, 300U);
}

TEST(FilledSource, FillsEverythingFromASingleCell) {
  const std::uint64_t only = 3 * 18 * 12 + 4 * 12 + 5;
  const HoleySource source(
      kGrid, [](const DirectionPair&) { return 5.0; },
      [&](const DirectionPair& pair) { return kGrid.cell_of(pair) != only; });
  const FilledSource filled(source);
  for (const DirectionPair& pair : random_pairs(500)) EXPECT_EQ(value_at(filled, pair), 5);
}

TEST(FilledSource, StillTellsWhatWasMeasured) {
  const double edge = radians_from_degrees(70);
  const HoleySource source(
      kGrid, [](const DirectionPair&) { return 5.0; },
      [&](const DirectionPair& pair) { return theta_d_of(pair) > edge; });
  const FilledSource filled(source);
  const std::vector<DirectionPair> pairs = random_pairs(500);
  std::vector<std::uint8_t> flags(pairs.size());
  filled.measured(pairs, flags);
  for (std::size_t k = 0; k < pairs.size(); ++k) EXPECT_EQ(flags[k], theta_d_of(pairs[k]) > edge ? 0 : 1);
  for (std::uint64_t cell = 0; cell < kGrid.cell_count(); ++cell) {
    if (!above_horizon(kGrid.centre_of(cell))) continue;
    EXPECT_EQ(filled.mask()->unmeasured[cell], cell / 12 % 18 >= 14) << cell;
  }
}

TEST(SymmetrisedSource, TakesTheOrderThatWasMeasured) {
  const HoleySource source(
      kGrid, [](const DirectionPair& pair) { return 1 + pair.i.theta; },
      [](const DirectionPair& pair) { return pair.i.theta > 1 || (pair.i.theta > 0.5 && pair.v.theta > 0.5); }, false);
  const SymmetrisedSource symmetrised(source);
  const auto flag = [&](const DirectionPair& pair) {
    std::uint8_t found = 2;
    symmetrised.measured(std::span(&pair, 1), std::span(&found, 1));
    return found;
  };
  const DirectionPair both = {{0.2, 1}, {0.4, 2}};
  EXPECT_FLOAT_EQ(value_at(symmetrised, both), 1.3F);
  EXPECT_EQ(flag(both), 1);
  for (const DirectionPair& one : {DirectionPair{{1.2, 1}, {0.4, 2}}, DirectionPair{{0.4, 2}, {1.2, 1}}}) {
    EXPECT_FLOAT_EQ(value_at(symmetrised, one), 1.4F);
    EXPECT_EQ(flag(one), 1);
  }
  EXPECT_EQ(flag({{0.7, 1}, {0.8, 2}}), 0);
}

}  // namespace
}  // namespace sbrdf::internal
