#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/coding/chunk_layout.h"
#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// What a value is predicted from: up to four values that are known already, and the weights of the polynomial
/// through them.
struct Stencil {
  std::array<std::uint32_t, 4> member{};
  std::array<double, 4> weight{};
  std::uint32_t count = 0;
};

/// Weights of the polynomial through values at `positions` (1 to 4, distinct), at position `at`, after Lagrange: that
/// of the value at x_k is the product, over the other j, of (at - x_j) / (x_k - x_j).
void set_weights(Stencil& stencil, std::span<const double> positions, double at);

/// In which order the crossings of one block are coded, and from which others: coarse parts of the lattice first, each
/// finer crossing by interpolation along one of the axes on which it lies between coarser ones. On two axes of nine
/// nodes, with the stride (the greatest power of two that divides both indices) at which each crossing is coded:
///
///     8 1 2 1 4 1 2 1 8
///     1 1 1 1 1 1 1 1 1         stride 8 first, then 4, 2, 1. Of one stride, those that lie between coarser ones on
///     2 1 2 1 2 1 2 1 2         one axis (a) come before those that do on both (b), which the a then surround:
///     1 1 1 1 1 1 1 1 1
///     4 1 2 1 4 1 2 1 4             4 a 4        a is predicted along its row or column, from the coarser ones at
///     1 1 1 1 1 1 1 1 1             a b a        -3, -1, 1 and 3 strides; b along either, from the a beside it.
///     2 1 2 1 2 1 2 1 2             4 a 4
///     1 1 1 1 1 1 1 1 1
///     8 1 2 1 4 1 2 1 8
///
/// Only crossings of the same block are used, so a chunk can be decoded by itself. specs/sbrdf.md, section 6.
struct CrossingPlan {
  struct Step {
    std::uint32_t crossing = 0;
    std::uint32_t first_stencil = 0;
    std::uint32_t stencil_count = 0;  ///< the one whose members differ least is used; 0 only for the first of a block
  };
  std::vector<Step> steps;
  std::vector<Stencil> stencils;
  std::vector<std::uint32_t> block_begin;  ///< in steps, one entry more than there are blocks
};

[[nodiscard]] CrossingPlan plan_crossings(const Lattice& lattice, const LatticeBlocks& blocks);

}  // namespace sbrdf::internal
