#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/rgl/rgl_material.h"

namespace sbrdf::internal {

// Least squares for colours on the nodes of many slices: each equation is a value interpolated among four nodes of up
// to four slices. The same bits for any number of threads: each panel adds up by itself, panels in their order.

/// One value that interpolation is to give.
struct RglEquation {
  std::uint32_t first = 0;  ///< node of a slice; the others are the next, and those a row on
  float x = 0;              ///< how far from the first node to the next, and to the next row, in [0, 1]
  float y = 0;
  std::array<float, 4> slice = {};  ///< weights of the panel's slices
  float weight = 0;                 ///< of the squared error
};

/// The equations between two neighbouring elevations, and two neighbouring azimuths where there are any.
class RglPanel {
 public:
  RglPanel(const RglGrid& grid, std::size_t channel_count)
      : cells_(grid.cell_count()), row_(grid.x_count), channels_(channel_count) {}

  std::array<std::size_t, 4> slices = {};   ///< of the unknowns
  std::array<std::size_t, 4> on_file = {};  ///< the same slices as numbered in the material
  std::size_t slice_count = 0;

  /// Which of the panel's slices is number `slice` of the material.
  [[nodiscard]] std::size_t place_of(std::size_t slice) const {
    std::size_t place = 0;
    while (place + 1 < slice_count && on_file[place] != slice) ++place;
    return place;
  }

  /// Room for so many equations, and no more.
  void reserve(std::size_t equation_count) { equations_.reserve(equation_count); }
  /// `target` holds a value for each channel.
  void add(const RglEquation& equation, std::span<const double> target);

  // Sums over the equations, [slice, node, channel] with the panel's own slices.

  /// Weighted targets: the right side of the normal equations.
  [[nodiscard]] const std::vector<double>& right_side() const { return right_side_; }
  /// [slice, node]: the diagonal of the normal matrix, and the sum of weights.
  void add_diagonal(std::span<double> diagonal, std::span<double> total) const;
  /// Of unknowns [slice, channel, node]: nodes below 0 become 0 where an equation comes out below 0 in their channel.
  void lift(std::span<double> unknowns) const;
  /// The normal matrix times `x`; both of `width` channels, `x` with the slices of all unknowns.
  void multiply(std::span<const double> x, std::size_t width, std::span<double> result) const;

 private:
  [[nodiscard]] std::array<std::size_t, 4> nodes_of(const RglEquation& equation) const {
    return {equation.first, equation.first + 1, equation.first + row_, equation.first + row_ + 1};
  }

  std::size_t cells_;
  std::size_t row_;
  std::size_t channels_;
  std::vector<RglEquation> equations_;
  std::vector<double> right_side_;
};

/// The unknowns [slice, channel, node] that solve the equations best, and vary smoothly where these say little: second
/// differences along x and y within a slice count a little, first differences less. Nodes more than two steps from any
/// equation have the value of the nearest that is not.
[[nodiscard]] std::vector<double> solve_least_squares(std::span<const RglPanel> panels, const RglGrid& grid,
                                                      std::size_t slice_count, std::size_t channel_count);

}  // namespace sbrdf::internal
