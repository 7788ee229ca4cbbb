#include "converters/files/rgl/rgl_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sbrdf::internal {
namespace {

/// A position along an axis: the node before it, and how far it is to the next in [0, 1].
struct Position {
  std::size_t index = 0;
  double fraction = 0;
};

Position position_on_grid(double u, std::size_t node_count) {
  const double scaled = u * static_cast<double>(node_count - 1);
  const std::size_t index = std::min(static_cast<std::size_t>(std::max(0.0, scaled)), node_count - 2);
  return {index, scaled - static_cast<double>(index)};
}

Position position_on_axis(std::span<const float> nodes, double value) {
  if (nodes.size() == 1) return {};
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, value);
  const auto index = static_cast<std::size_t>(above - nodes.begin()) - 1;
  const double low = nodes[index];
  const double high = nodes[index + 1];
  return {index, std::clamp((value - low) / (high - low), 0.0, 1.0)};
}

/// How far it is from one of two numbers to the other, as it is seen from the nearer: so what lies between two positive
/// ones never rounds to zero.
class Way {
 public:
  explicit Way(double fraction) : near_first_(fraction < 0.5), part_(near_first_ ? fraction : fraction - 1) {}
  [[nodiscard]] double operator()(double a, double b) const { return (near_first_ ? a : b) + part_ * (b - a); }

 private:
  bool near_first_;
  double part_;
};
double mix(double a, double b, double fraction) { return Way(fraction)(a, b); }

/// Integral of a linear function over the first part of an interval of width 1 with the values `a` and `b` at its ends.
double integral_to(double fraction, double a, double b) { return fraction * (a + 0.5 * fraction * (b - a)); }

/// The inverse: the fraction in [0, 1] with this integral, 0 where there is nothing to integrate.
double fraction_of(double integral, double a, double b) {
  const double divisor = a + std::sqrt(std::max(0.0, a * a + 2 * (b - a) * integral));
  return divisor > 0 ? std::clamp(2 * integral / divisor, 0.0, 1.0) : 0.0;
}

/// Of `count` rising values: the last that is not above `target`, but not the very last.
template <class Value>
std::size_t last_not_above(std::size_t count, double target, const Value& value) {
  std::size_t low = 0;
  std::size_t high = count - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (value(middle) <= target ? low : high) = middle;
  }
  return low;
}

}  // namespace

RglSlices rgl_slices(std::span<const float> phi_i, std::span<const float> theta_i, double at_phi_i, double at_theta_i) {
  const Position phi = position_on_axis(phi_i, at_phi_i);
  const Position theta = position_on_axis(theta_i, at_theta_i);
  const std::size_t first = phi.index * theta_i.size() + theta.index;
  const std::array<std::size_t, 4> indices = {first, first + 1, first + theta_i.size(), first + theta_i.size() + 1};
  const std::array<double, 4> weights = {(1 - phi.fraction) * (1 - theta.fraction), (1 - phi.fraction) * theta.fraction,
                                         phi.fraction * (1 - theta.fraction), phi.fraction * theta.fraction};
  RglSlices slices;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (weights[i] == 0) continue;
    slices.index[slices.count] = indices[i];
    slices.weight[slices.count++] = weights[i];
  }
  return slices;
}

RglTable::RglTable(const RglGrid& grid, std::vector<float> values) : grid_(grid), values_(std::move(values)) {}

double RglTable::at(const RglPoint& u) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const float* low = values_.data() + y.index * grid_.x_count + x.index;
  const float* high = low + grid_.x_count;
  return mix(mix(low[0], low[1], x.fraction), mix(high[0], high[1], x.fraction), y.fraction);
}

RglWarp::RglWarp(const RglGrid& grid, std::span<const float> density) : grid_(grid) {
  const std::size_t slice_count = density.size() / grid.cell_count();
  nodes_.reserve(density.size());
  rows_.reserve(slice_count * grid.y_count);
  for (std::size_t slice = 0; slice < slice_count; ++slice) {
    add_slice(density.subspan(slice * grid.cell_count(), grid.cell_count()));
  }
}

// A sum along a row waits for each addition before the next: rows go side by side, four at a time. The last of them may
// be the same again.
void RglWarp::add_slice(std::span<const float> density) {
  constexpr std::size_t kRows = 4;
  const auto row = [&](std::size_t y) { return std::min(y, grid_.y_count - 1) * grid_.x_count; };
  std::vector<double> masses(grid_.y_count + kRows);
  for (std::size_t y = 0; y < grid_.y_count; y += kRows) {
    std::array<double, kRows> mass{};
    const std::array<const float*, kRows> from = {density.data() + row(y), density.data() + row(y + 1),
                                                  density.data() + row(y + 2), density.data() + row(y + 3)};
    for (std::size_t x = 1; x < grid_.x_count; ++x) {
      for (std::size_t r = 0; r < kRows; ++r) mass[r] += integral_to(1, from[r][x - 1], from[r][x]);
    }
    std::copy(mass.begin(), mass.end(), masses.begin() + static_cast<std::ptrdiff_t>(y));
  }
  double total = 0;
  for (std::size_t y = 1; y < grid_.y_count; ++y) total += integral_to(1, masses[y - 1], masses[y]);

  const std::size_t first = nodes_.size();
  nodes_.resize(first + density.size());
  for (std::size_t y = 0; y < grid_.y_count; y += kRows) {
    std::array<double, kRows> before{};
    std::array<double, kRows> previous{};
    const std::array<std::size_t, kRows> rows = {row(y), row(y + 1), row(y + 2), row(y + 3)};
    for (std::size_t x = 0; x < grid_.x_count; ++x) {
      for (std::size_t r = 0; r < kRows; ++r) {
        const double value = density[rows[r] + x] / total;
        if (x > 0) before[r] += integral_to(1, previous[r], value);
        nodes_[first + rows[r] + x] = {static_cast<float>(value), static_cast<float>(before[r])};
        previous[r] = value;
      }
    }
    std::copy(before.begin(), before.end(), masses.begin() + static_cast<std::ptrdiff_t>(y));
  }
  double before_row = 0;
  for (std::size_t y = 0; y < grid_.y_count; ++y) {
    if (y > 0) before_row += integral_to(1, masses[y - 1], masses[y]);
    rows_.push_back({static_cast<float>(masses[y]), static_cast<float>(before_row)});
  }
}

RglPoint RglWarp::invert(const RglPoint& u, const RglSlices& slices) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  double before_row = 0;
  double mass_low = 0;
  double mass_high = 0;
  double before_low = 0;
  double before_high = 0;
  for (std::size_t i = 0; i < slices.count; ++i) {
    const double weight = slices.weight[i];
    const Row* rows = rows_.data() + slices.index[i] * grid_.y_count + y.index;
    before_row += weight * rows[0].before;
    mass_low += weight * rows[0].mass;
    mass_high += weight * rows[1].mass;
    const Node* low = nodes_.data() + slices.index[i] * grid_.cell_count() + y.index * grid_.x_count + x.index;
    const Node* high = low + grid_.x_count;
    before_low += weight * (low[0].before + integral_to(x.fraction, low[0].density, low[1].density));
    before_high += weight * (high[0].before + integral_to(x.fraction, high[0].density, high[1].density));
  }
  const double mass = mix(mass_low, mass_high, y.fraction);
  const double before = mix(before_low, before_high, y.fraction);
  const double at_y = before_row + integral_to(y.fraction, mass_low, mass_high);
  return {mass > 0 ? std::clamp(before / mass, 0.0, 1.0) : 0.0, std::clamp(at_y, 0.0, 1.0)};
}

double RglWarp::row_before(std::size_t y, const RglSlices& slices) const {
  double before = 0;
  for (std::size_t i = 0; i < slices.count; ++i)
    before += slices.weight[i] * rows_[slices.index[i] * grid_.y_count + y].before;
  return before;
}

double RglWarp::row_mass(std::size_t y, const RglSlices& slices) const {
  double mass = 0;
  for (std::size_t i = 0; i < slices.count; ++i)
    mass += slices.weight[i] * rows_[slices.index[i] * grid_.y_count + y].mass;
  return mass;
}

RglWarp::Node RglWarp::node(std::size_t x, std::size_t y, double y_fraction, const RglSlices& slices) const {
  Node sum;
  for (std::size_t i = 0; i < slices.count; ++i) {
    const Node* low = nodes_.data() + slices.index[i] * grid_.cell_count() + y * grid_.x_count + x;
    const Node* high = low + grid_.x_count;
    const auto weight = static_cast<float>(slices.weight[i]);
    const auto fraction = static_cast<float>(y_fraction);
    sum.density += weight * ((1 - fraction) * low->density + fraction * high->density);
    sum.before += weight * ((1 - fraction) * low->before + fraction * high->before);
  }
  return sum;
}

RglPoint RglWarp::warp(const RglPoint& s, const RglSlices& slices) const {
  const double y_target = s.y * row_before(grid_.y_count - 1, slices);
  const std::size_t y = last_not_above(grid_.y_count, y_target, [&](std::size_t k) { return row_before(k, slices); });
  const double y_fraction = fraction_of(y_target - row_before(y, slices), row_mass(y, slices), row_mass(y + 1, slices));
  const double x_target = s.x * node(grid_.x_count - 1, y, y_fraction, slices).before;
  const std::size_t x =
      last_not_above(grid_.x_count, x_target, [&](std::size_t k) { return node(k, y, y_fraction, slices).before; });
  const Node low = node(x, y, y_fraction, slices);
  const double x_fraction = fraction_of(x_target - low.before, low.density, node(x + 1, y, y_fraction, slices).density);
  return {(static_cast<double>(x) + x_fraction) / static_cast<double>(grid_.x_count - 1),
          (static_cast<double>(y) + y_fraction) / static_cast<double>(grid_.y_count - 1)};
}

double RglWarp::density(const RglPoint& u, const RglSlices& slices) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const double in_cells = mix(node(x.index, y.index, y.fraction, slices).density,
                              node(x.index + 1, y.index, y.fraction, slices).density, x.fraction);
  return in_cells * static_cast<double>((grid_.x_count - 1) * (grid_.y_count - 1));
}

RglCell rgl_cell(const RglGrid& grid, const RglPoint& u) {
  const Position x = position_on_grid(u.x, grid.x_count);
  const Position y = position_on_grid(u.y, grid.y_count);
  return {y.index * grid.x_count + x.index,
          {(1 - y.fraction) * (1 - x.fraction), (1 - y.fraction) * x.fraction, y.fraction * (1 - x.fraction),
           y.fraction * x.fraction}};
}

RglColours::RglColours(const RglGrid& grid, std::size_t channel_count, std::span<const float> values)
    : grid_(grid), channel_count_(channel_count), values_(values.size()) {
  const std::size_t cell_count = grid.cell_count();
  const std::size_t slice_size = cell_count * channel_count_;
  for (std::size_t slice = 0; slice < values.size(); slice += slice_size) {
    for (std::size_t channel = 0; channel < channel_count_; ++channel) {
      const float* plane = values.data() + slice + channel * cell_count;
      float* target = values_.data() + slice + channel;
      for (std::size_t cell = 0; cell < cell_count; ++cell) target[cell * channel_count_] = plane[cell];
    }
  }
}

void RglColours::at(const RglPoint& u, const RglSlices& slices, double scale, std::span<float> values) const {
  constexpr double largest = std::numeric_limits<float>::max();
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const std::size_t first = (y.index * grid_.x_count + x.index) * channel_count_;
  const std::size_t row = grid_.x_count * channel_count_;
  const Way along_x(x.fraction);
  const Way along_y(y.fraction);
  for (std::size_t c = 0; c < channel_count_; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < slices.count; ++i) {
      const float* low = values_.data() + slices.index[i] * grid_.cell_count() * channel_count_ + first + c;
      const float* high = low + row;
      sum += slices.weight[i] * along_y(along_x(low[0], low[channel_count_]), along_x(high[0], high[channel_count_]));
    }
    values[c] = static_cast<float>(std::clamp(sum * scale, -largest, largest));
  }
}

}  // namespace sbrdf::internal
