#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/rgl/rgl_material.h"

namespace sbrdf::internal {

// The tables of an RGL material, laid out for evaluation: what one lookup reads lies together. All of them are
// functions on the unit square that are bilinear between nodes, and linear between the slices for the nodes of phi_i
// and theta_i. Coordinates outside [0, 1] are a caller's bug.

struct RglPoint {
  double x = 0;
  double y = 0;
};

/// The slices around one direction of incidence and their weights, which add up to 1. Slices of weight 0 are left out.
struct RglSlices {
  std::array<std::size_t, 4> index = {};
  std::array<double, 4> weight = {};
  std::size_t count = 0;
};

/// Slice `i * theta_i.size() + j` belongs to node i of `phi_i` and node j of `theta_i`. Beyond the ends of an axis its
/// last node counts.
[[nodiscard]] RglSlices rgl_slices(std::span<const float> phi_i, std::span<const float> theta_i, double at_phi_i,
                                   double at_theta_i);

/// One table without slices.
class RglTable {
 public:
  /// `values` are [y, x].
  RglTable(const RglGrid& grid, std::vector<float> values);
  [[nodiscard]] double at(const RglPoint& u) const;

 private:
  RglGrid grid_;
  std::vector<float> values_;
};

/// The map of the square onto itself that turns the uniform density into the given one: y goes through the marginal
/// distribution, then x through the distribution given y (the warp by visible normals of Dupuy & Jakob 2018).
class RglWarp {
 public:
  /// `density` is [slice, y, x]: not negative, no slice all zero. Each slice is scaled to integrate to 1.
  RglWarp(const RglGrid& grid, std::span<const float> density);

  /// The uniform point that is warped to `u`. x is 0 where the density vanishes along the whole row of `u`.
  [[nodiscard]] RglPoint invert(const RglPoint& u, const RglSlices& slices) const;
  /// The other way: where a uniform point is warped to.
  [[nodiscard]] RglPoint warp(const RglPoint& s, const RglSlices& slices) const;
  /// The density at `u`; its integral over the square is 1.
  [[nodiscard]] double density(const RglPoint& u, const RglSlices& slices) const;

 private:
  /// Lengths are in cells of the grid. `before` is the integral of the density along the row, from x = 0 to the node.
  struct Node {
    float density = 0;
    float before = 0;
  };
  /// `mass` is the integral of the density along the row, `before` that of the mass from y = 0 to the row.
  struct Row {
    float mass = 0;
    float before = 0;
  };
  void add_slice(std::span<const float> density);
  [[nodiscard]] double row_before(std::size_t y, const RglSlices& slices) const;
  [[nodiscard]] double row_mass(std::size_t y, const RglSlices& slices) const;
  [[nodiscard]] Node node(std::size_t x, std::size_t y, double y_fraction, const RglSlices& slices) const;

  RglGrid grid_;
  std::vector<Node> nodes_;
  std::vector<Row> rows_;
};

/// What four nodes around a point of the square weigh: those at `first`, `first + 1` and, a row on, `first + x_count`
/// and `first + x_count + 1`.
struct RglCell {
  std::size_t first = 0;
  std::array<double, 4> weight = {};
};
[[nodiscard]] RglCell rgl_cell(const RglGrid& grid, const RglPoint& u);

/// The colours in warped coordinates, of any number of channels.
class RglColours {
 public:
  /// `values` are [slice, channel, y, x].
  RglColours(const RglGrid& grid, std::size_t channel_count, std::span<const float> values);
  [[nodiscard]] std::size_t channel_count() const { return channel_count_; }
  /// `values`, one for each channel, times `scale`; held within the range of float.
  void at(const RglPoint& u, const RglSlices& slices, double scale, std::span<float> values) const;

 private:
  RglGrid grid_;
  std::size_t channel_count_;
  std::vector<float> values_;  ///< [slice, y, x, channel]
};

}  // namespace sbrdf::internal
