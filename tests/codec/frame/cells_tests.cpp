#include "codec/frame/cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

const std::vector<std::vector<double>>& various_axes() {
  static const std::vector<std::vector<double>> kAxes = {
      {0, 80}, {0, 20, 40, 60, 80}, {0, 0.5, 1, 2, 79, 80}, {0, 78, 79, 79.001, 80}, {0, 50, 200, 360, 410, 560, 720}};
  return kAxes;
}

AxisCell cell_of(const std::vector<double>& nodes, double x) { return cell_on_axis(nodes, cells_per_degree(nodes), x); }

/// The last cell whose node lies at or before x, found by trying all.
std::uint32_t slowly_found(const std::vector<double>& nodes, double x) {
  std::uint32_t found = 0;
  for (std::uint32_t k = 0; k + 1 < nodes.size(); ++k) {
    if (nodes[k] <= x) found = k;
  }
  return found;
}

TEST(CellOnAxis, BeginsWithItsNodeAndEndsBeforeTheNext) {
  for (const std::vector<double>& nodes : various_axes()) {
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const std::uint32_t last = static_cast<std::uint32_t>(nodes.size()) - 2;
      const auto before = static_cast<std::uint32_t>(k == 0 ? 0 : k - 1);
      EXPECT_EQ(cell_of(nodes, nodes[k]).index, std::min(static_cast<std::uint32_t>(k), last));
      EXPECT_EQ(cell_of(nodes, std::nextafter(nodes[k], -1.0)).index, before);
      EXPECT_EQ(cell_of(nodes, std::nextafter(nodes[k], 1e3)).index, std::min(static_cast<std::uint32_t>(k), last));
    }
  }
}

TEST(CellOnAxis, IsTheOneThatASlowSearchFinds) {
  for (const std::vector<double>& nodes : various_axes()) {
    for (int k = -50; k < 1050; ++k) {
      const double x = nodes.back() * k / 1000;
      EXPECT_EQ(cell_of(nodes, x).index, slowly_found(nodes, x)) << x;
    }
  }
}

TEST(CellOnAxis, MovesWhatLiesOutsideToTheEndsAndANaNToTheFirstNode) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& nodes : various_axes()) {
    const auto last = static_cast<std::uint32_t>(nodes.size()) - 2;
    for (const double x : {nodes.back() + 1e-9, 1e300, kInfinity}) {
      EXPECT_EQ(cell_of(nodes, x).index, last);
      EXPECT_EQ(cell_of(nodes, x).x, nodes.back());
    }
    for (const double x : {-1e-9, -1e300, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
      EXPECT_EQ(cell_of(nodes, x).index, 0U);
      EXPECT_EQ(cell_of(nodes, x).x, 0);
    }
  }
}

TEST(CellsPerDegree, IsZeroForAnAxisOfOneNode) {
  EXPECT_EQ(cells_per_degree(std::vector{0.0}), 0);
  EXPECT_EQ(cells_per_degree(std::vector{0.0, 20.0, 80.0}), 2.0 / 80);
}

}  // namespace
}  // namespace sbrdf::internal
