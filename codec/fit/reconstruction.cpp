#include "codec/fit/reconstruction.h"

#include <algorithm>
#include <array>

#include "codec/curves/spline.h"
#include "codec/frame/cells.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBlock = 1024;  // rows that one task works on
/// Parts of the rows whose transposed sums are made apart and then added in order: the same bits for any number of
/// threads.
constexpr std::size_t kParts = 8;

std::vector<double> spline_matrix(const Slice& slice, const SliceSamples& samples) {
  const std::size_t n = samples.size();
  std::vector<double> matrix(n * n);
  std::vector<double> unit(n);
  std::vector<double> second(n);
  SplineSolver<double> solver;
  for (std::size_t k = 0; k < n; ++k) {
    unit[k] = 1;
    solver.solve(slice.boundary, slice.length_deg, samples.positions_deg, unit.data(), second.data(), 1);
    for (std::size_t row = 0; row < n; ++row) matrix[row * n + k] = second[row];
    unit[k] = 0;
  }
  return matrix;
}

}  // namespace

Reconstruction::Reconstruction(const SlicedBrdf& sliced, const Lattice& lattice, std::span<const SliceSamples> slices)
    : lattice_(lattice), slices_(slices), rings_(pole_rings(lattice)), unknown_count_(sliced.crossing_count()) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (lattice.nodes[axis].size() > 1) moving_.push_back(axis);
  }
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const auto nodes = lattice.nodes_of(lattice.slices[k]);
    first_knot_.push_back(static_cast<std::uint32_t>(unknowns_.size()));
    for (const SamplePosition& place : slices[k].places) {
      unknowns_.push_back(place.fraction == 0 ? nodes[place.interval].crossing
                                              : static_cast<std::uint32_t>(unknown_count_++));
    }
  }
  matrices_.resize(slices.size());
  parallel_for(slices.size(), [&](std::size_t k) { matrices_[k] = spline_matrix(lattice.slices[k], slices[k]); });
}

Reconstruction::Cell Reconstruction::cell_at(const Coordinates& x) const {
  Cell cell;
  for (const std::size_t axis : moving_) {
    const std::vector<double>& nodes = lattice_.nodes[axis];
    const auto [index, clamped] = cell_on_axis(nodes, cells_per_degree(nodes), x[axis]);
    cell.index[axis] = index;
    cell.fraction[axis] = (clamped - nodes[index]) / (nodes[index + 1] - nodes[index]);
  }
  return cell;
}

/// The corners of the cell, or the lines along the axis left out, each with its weight.
template <class Visit>
void Reconstruction::for_each_weight(const Cell& cell, std::size_t left_out, const Visit& visit) const {
  for (unsigned bits = 0; bits < (1U << moving_.size()); ++bits) {
    LatticePoint point = cell.index;
    double weight = 1;
    for (std::size_t m = 0; m < moving_.size(); ++m) {
      const std::size_t axis = moving_[m];
      const bool far = ((bits >> m) & 1U) != 0;
      if (axis == left_out) {
        if (far) weight = 0;
        continue;
      }
      weight *= far ? cell.fraction[axis] : 1 - cell.fraction[axis];
      if (far) ++point[axis];
    }
    if (weight != 0) visit(point, weight);
  }
}

void Reconstruction::add_sum_in_cell(const Cell& cell, const Coordinates& x, double factor, Rows& rows) const {
  const double corners = 1 - static_cast<double>(moving_.size());
  for_each_weight(cell, kAxisCount, [&](const LatticePoint& point, double weight) {
    add_corner(index_at(point, lattice_.corner_strides), factor * corners * weight, rows);
  });
  for (const std::size_t axis : moving_) {
    for_each_weight(cell, axis, [&](LatticePoint point, double weight) {
      point[axis] = 0;
      add_line(lattice_.lines[axis][index_at(point, lattice_.line_strides[axis])], x[axis], factor * weight, rows);
    });
  }
}

void Reconstruction::add_sum_on_ring(const PoleRing& ring, const Cell& cell, const Coordinates& x, double factor,
                                     Rows& rows) const {
  const double position = ring.position_deg(x);
  const std::size_t before = ring.node_before(position);
  const PoleRing::Node* nodes = ring.nodes.data() + before;
  const double along_ring = (position - nodes[0].position_deg) / (nodes[1].position_deg - nodes[0].position_deg);
  const std::array<double, 2> ring_weights = {1 - along_ring, along_ring};
  const std::array<double, 2> polar_weights = {1 - cell.fraction[ring.along], cell.fraction[ring.along]};
  const std::size_t ring_axis = ring.merging.ring_axis;
  for (std::uint32_t p = 0; p < 2; ++p) {
    const std::uint32_t at = cell.index[ring.along] + p;
    for (std::uint32_t r = 0; r < 2; ++r) {
      add_corner(nodes[r].corner + at * lattice_.corner_strides[ring.along],
                 -factor * ring_weights[r] * polar_weights[p], rows);
    }
    add_line(lattice_.lines[ring_axis][at * lattice_.line_strides[ring_axis][ring.along]], position,
             factor * polar_weights[p], rows);
    add_line(lattice_.lines[ring.along][nodes[p].line], x[ring.along], factor * ring_weights[p], rows);
  }
}

void Reconstruction::add_corner(std::uint32_t corner, double factor, Rows& rows) const {
  if (factor != 0) rows.corners.push_back({lattice_.corners[corner], static_cast<float>(factor)});
}

void Reconstruction::add_line(const LineReference& line, double x, double factor, Rows& rows) const {
  if (factor == 0) return;
  if (line.is_constant()) {
    rows.corners.push_back({line.crossing(), static_cast<float>(factor)});
    return;
  }
  const Slice& slice = lattice_.slices[line.target];
  const std::vector<double>& positions = slices_[line.target].positions_deg;
  const bool periodic = slice.boundary == Boundary::kPeriodic;
  const double at = fold(slice, line.sign * x + line.offset_deg);
  const auto last = positions.end() - (periodic ? 0 : 1);  // beginnings of segments
  const auto after = std::upper_bound(positions.begin() + 1, std::max(positions.begin() + 1, last), at);
  const auto knot = static_cast<std::size_t>(after - positions.begin()) - 1;
  const std::size_t next = knot + 1 < positions.size() ? knot + 1 : 0;
  const double width = next > 0 ? positions[next] - positions[knot] : positions[0] + slice.length_deg - positions[knot];
  const double t = std::clamp((at - positions[knot]) / width, 0.0, 1.0);
  const double s = 1 - t;
  const double bow = -factor * s * t * width * width / 6;
  const std::uint32_t first = first_knot_[line.target];
  rows.lines.push_back({first + static_cast<std::uint32_t>(knot), first + static_cast<std::uint32_t>(next),
                        static_cast<float>(factor * s), static_cast<float>(factor * t),
                        static_cast<float>(bow * (1 + s)), static_cast<float>(bow * (1 + t))});
}

void Reconstruction::set_rows(std::span<const Coordinates> places) {
  row_count_ = places.size();
  blocks_.assign((row_count_ + kBlock - 1) / kBlock, {});
  parallel_for(blocks_.size(), [&](std::size_t block) {
    const std::size_t first = block * kBlock;
    for (const Coordinates& x : places.subspan(first, std::min(kBlock, row_count_ - first))) add_row(x, blocks_[block]);
  });
}

template <class Visit>
void Reconstruction::for_rows(std::size_t first, std::size_t end, const Visit& visit) const {
  for (std::size_t row = first; row < end; ++row) {
    const Rows& rows = blocks_[row / kBlock];
    const std::size_t k = row % kBlock;
    visit(row, std::span(rows.lines).subspan(rows.line_ends[k], rows.line_ends[k + 1] - rows.line_ends[k]),
          std::span(rows.corners).subspan(rows.corner_ends[k], rows.corner_ends[k + 1] - rows.corner_ends[k]));
  }
}

void Reconstruction::add_row(const Coordinates& x, Rows& rows) const {
  const Cell cell = cell_at(x);
  add_sum_in_cell(cell, x, 1, rows);
  for (const PoleRing& ring : rings_) {
    const std::size_t axis = ring.merging.polar_axis;
    if (cell.index[axis] != 0) continue;
    const double share = 1 - cell.fraction[axis];
    Cell on_face = cell;
    on_face.fraction[axis] = 0;
    Coordinates at_face = x;
    at_face[axis] = 0;
    add_sum_in_cell(on_face, at_face, -share, rows);
    add_sum_on_ring(ring, cell, x, share, rows);
  }
  rows.line_ends.push_back(static_cast<std::uint32_t>(rows.lines.size()));
  rows.corner_ends.push_back(static_cast<std::uint32_t>(rows.corners.size()));
}

template <std::size_t N>
void Reconstruction::splines(std::span<const double> values, std::vector<double>& knots,
                             std::vector<double>& seconds) const {
  knots.resize(unknowns_.size() * N);
  seconds.assign(unknowns_.size() * N, 0);
  for (std::size_t k = 0; k < unknowns_.size(); ++k) {
    for (std::size_t c = 0; c < N; ++c) knots[k * N + c] = values[unknowns_[k] * N + c];
  }
  parallel_for(matrices_.size(), [&](std::size_t slice) {
    const std::size_t n = slices_[slice].size();
    const double* y = knots.data() + first_knot_[slice] * N;
    double* second = seconds.data() + first_knot_[slice] * N;
    for (std::size_t row = 0; row < n; ++row) {
      const double* matrix = matrices_[slice].data() + row * n;
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t c = 0; c < N; ++c) second[row * N + c] += matrix[k] * y[k * N + c];
      }
    }
  });
}

template <std::size_t N>
void Reconstruction::apply(std::span<const double> values, std::span<double> rows) const {
  std::vector<double> knots;
  std::vector<double> seconds;
  splines<N>(values, knots, seconds);
  parallel_blocks(row_count(), kBlock, [&](std::size_t first, std::size_t size) {
    for_rows(first, first + size, [&](std::size_t row, auto lines, auto corners) {
      std::array<double, N> sum{};
      for (const LineTerm& term : lines) {
        for (std::size_t c = 0; c < N; ++c) {
          sum[c] += term.value0 * knots[term.knot * N + c] + term.value1 * knots[term.next * N + c] +
                    term.second0 * seconds[term.knot * N + c] + term.second1 * seconds[term.next * N + c];
        }
      }
      for (const CornerTerm& term : corners) {
        for (std::size_t c = 0; c < N; ++c) sum[c] += term.factor * values[term.crossing * N + c];
      }
      std::copy_n(sum.data(), N, rows.data() + row * N);
    });
  });
}

template <std::size_t N>
void Reconstruction::apply_transposed(std::span<const double> rows, std::span<double> values) const {
  struct Part {
    std::vector<double> knots, seconds, crossings;
  };
  std::array<Part, kParts> parts;
  const std::size_t crossing_count = lattice_.crossings.size();
  parallel_for(kParts, [&](std::size_t p) {
    Part& part = parts[p];
    part.knots.assign(unknowns_.size() * N, 0);
    part.seconds.assign(unknowns_.size() * N, 0);
    part.crossings.assign(crossing_count * N, 0);
    for_rows(row_count() * p / kParts, row_count() * (p + 1) / kParts, [&](std::size_t row, auto lines, auto corners) {
      const double* from = rows.data() + row * N;
      for (const LineTerm& term : lines) {
        for (std::size_t c = 0; c < N; ++c) {
          part.knots[term.knot * N + c] += term.value0 * from[c];
          part.knots[term.next * N + c] += term.value1 * from[c];
          part.seconds[term.knot * N + c] += term.second0 * from[c];
          part.seconds[term.next * N + c] += term.second1 * from[c];
        }
      }
      for (const CornerTerm& term : corners) {
        for (std::size_t c = 0; c < N; ++c) part.crossings[term.crossing * N + c] += term.factor * from[c];
      }
    });
  });
  Part& all = parts[0];
  for (std::size_t p = 1; p < kParts; ++p) {
    for (std::size_t k = 0; k < all.knots.size(); ++k) all.knots[k] += parts[p].knots[k];
    for (std::size_t k = 0; k < all.seconds.size(); ++k) all.seconds[k] += parts[p].seconds[k];
    for (std::size_t k = 0; k < all.crossings.size(); ++k) all.crossings[k] += parts[p].crossings[k];
  }
  parallel_for(matrices_.size(), [&](std::size_t slice) {
    const std::size_t n = slices_[slice].size();
    double* y = all.knots.data() + first_knot_[slice] * N;
    const double* second = all.seconds.data() + first_knot_[slice] * N;
    for (std::size_t row = 0; row < n; ++row) {
      const double* matrix = matrices_[slice].data() + row * n;
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t c = 0; c < N; ++c) y[k * N + c] += matrix[k] * second[row * N + c];
      }
    }
  });
  std::copy(all.crossings.begin(), all.crossings.end(), values.begin());
  std::fill(values.begin() + static_cast<std::ptrdiff_t>(crossing_count * N), values.end(), 0.0);
  for (std::size_t k = 0; k < unknowns_.size(); ++k) {
    for (std::size_t c = 0; c < N; ++c) values[unknowns_[k] * N + c] += all.knots[k * N + c];
  }
}

template <std::size_t N>
void Reconstruction::add_squares(std::span<const double> weights, std::span<double> diagonal) const {
  for_rows(0, row_count(), [&](std::size_t row, auto lines, auto /*corners*/) {
    for (const LineTerm& term : lines) {
      for (std::size_t c = 0; c < N; ++c) {
        diagonal[unknowns_[term.knot] * N + c] += weights[row * N + c] * term.value0 * term.value0;
        diagonal[unknowns_[term.next] * N + c] += weights[row * N + c] * term.value1 * term.value1;
      }
    }
  });
}

template void Reconstruction::apply<1>(std::span<const double>, std::span<double>) const;
template void Reconstruction::apply<3>(std::span<const double>, std::span<double>) const;
template void Reconstruction::apply_transposed<1>(std::span<const double>, std::span<double>) const;
template void Reconstruction::apply_transposed<3>(std::span<const double>, std::span<double>) const;
template void Reconstruction::add_squares<1>(std::span<const double>, std::span<double>) const;
template void Reconstruction::add_squares<3>(std::span<const double>, std::span<double>) const;

}  // namespace sbrdf::internal
