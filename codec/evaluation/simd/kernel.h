#pragma once

#include <cstddef>

#include "codec/evaluation/tables/slice_tables.h"

namespace sbrdf::internal {

// The hot loops of the evaluator, compiled once for each set of instructions (SSE4, AVX2, AVX-512, NEON ...); the best
// one of the machine is taken when the program runs. On one machine the values of a pair are the same to the last bit
// however many pairs are worked out at once. Between sets of instructions slices are the same, too: nothing is fused,
// and sums have one order. What is left are the roundings of Highway's atan and exp.

/// What the slices give at frame coordinates [degrees]. `guide_angle_deg` counts where there is a guide. `values` has
/// one entry per channel.
void evaluate_coordinates(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* values);

/// f_r of pairs of vectors x, y, z towards light and viewer, of any length but 0; `w_i` and `w_v` have three numbers
/// for each pair, `values` one per channel, channel fastest. 0 where one points below the horizon or is no direction.
void evaluate_vectors(const SliceTables& tables, const float* w_i, const float* w_v, std::size_t count, float* values);

/// Adds what one pair needs. `tables` need hold nothing but what its second constructor sets.
void find_needs(const SliceTables& tables, const float* w_i, const float* w_v, SliceTables::Needs& needs);

}  // namespace sbrdf::internal
