#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "codec/evaluation/pole_ring.h"
#include "codec/frame/lattice_walk.h"
#include "codec/material/slice_samples.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// What an evaluator computes at given places, before it bounds anything, as a linear map of the samples in the value
/// domain, and its transpose. Splines are those before their slopes are limited.
///
/// The unknowns are the crossings in the order of the lattice, then the samples of each slice.
class Reconstruction {
 public:
  /// All must outlive this. Takes the square of the number of samples on a slice, for each slice, in memory.
  Reconstruction(const SlicedBrdf& sliced, const Lattice& lattice, std::span<const SliceSamples> slices);

  [[nodiscard]] std::size_t unknown_count() const { return unknown_count_; }
  [[nodiscard]] std::size_t row_count() const { return row_count_; }
  /// The unknown at sample `sample` of slice `slice`.
  [[nodiscard]] std::uint32_t unknown_at(std::size_t slice, std::size_t sample) const {
    return unknowns_[first_knot_[slice] + sample];
  }

  /// Row k: the value at frame coordinates places[k].
  void set_rows(std::span<const Coordinates> places);

  /// N channels of each row from N channels of each unknown, channel fastest.
  template <std::size_t N>
  void apply(std::span<const double> values, std::span<double> rows) const;
  /// The transpose: what each unknown gets from the rows.
  template <std::size_t N>
  void apply_transposed(std::span<const double> rows, std::span<double> values) const;
  /// Of each unknown the sum, over the rows, of weight x (its own straight-line part)^2: about the diagonal of the
  /// normal equations, for `weights` with N channels of each row.
  template <std::size_t N>
  void add_squares(std::span<const double> weights, std::span<double> diagonal) const;

 private:
  /// What the segment of a slice adds to a row: factors of the values and the second derivatives at its ends.
  struct LineTerm {
    std::uint32_t knot = 0;
    std::uint32_t next = 0;
    float value0 = 0, value1 = 0, second0 = 0, second1 = 0;
  };
  struct CornerTerm {
    std::uint32_t crossing = 0;
    float factor = 0;
  };
  /// Rows that one task makes: their terms, row by row.
  struct Rows {
    std::vector<LineTerm> lines;
    std::vector<CornerTerm> corners;
    std::vector<std::uint32_t> line_ends = {0};  ///< terms of row k: from entry k to entry k + 1
    std::vector<std::uint32_t> corner_ends = {0};
  };
  /// The cell that holds a place, and the place in it; on an axis of one node both are 0.
  struct Cell {
    LatticePoint index{};
    std::array<double, kAxisCount> fraction{};
  };

  [[nodiscard]] Cell cell_at(const Coordinates& x) const;
  void add_row(const Coordinates& x, Rows& rows) const;
  void add_sum_in_cell(const Cell& cell, const Coordinates& x, double factor, Rows& rows) const;
  void add_sum_on_ring(const PoleRing& ring, const Cell& cell, const Coordinates& x, double factor, Rows& rows) const;
  void add_corner(std::uint32_t corner, double factor, Rows& rows) const;
  void add_line(const LineReference& line, double x, double factor, Rows& rows) const;
  /// Calls `visit(row, line terms, corner terms)` for rows [first, end).
  template <class Visit>
  void for_rows(std::size_t first, std::size_t end, const Visit& visit) const;
  template <class Visit>
  void for_each_weight(const Cell& cell, std::size_t left_out, const Visit& visit) const;
  template <std::size_t N>
  void splines(std::span<const double> values, std::vector<double>& knots, std::vector<double>& seconds) const;

  const Lattice& lattice_;
  std::span<const SliceSamples> slices_;
  std::vector<PoleRing> rings_;
  std::vector<std::size_t> moving_;  ///< axes with two nodes or more
  std::size_t unknown_count_ = 0;
  std::vector<std::uint32_t> first_knot_;      ///< of each slice, in unknowns_
  std::vector<std::uint32_t> unknowns_;        ///< of each sample of each slice
  std::vector<std::vector<double>> matrices_;  ///< of each slice: second derivatives from values, row by row
  std::size_t row_count_ = 0;
  std::vector<Rows> blocks_;  ///< kBlock rows each, the last one fewer
};

}  // namespace sbrdf::internal
