#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include <glm/vec3.hpp>

#include "codec/evaluation/tables/dense.h"
#include "codec/evaluation/tables/presample.h"
#include "codec/evaluation/tables/slice_tables.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// The function of the Evaluator for those who have vectors, as renderers do, and ask for many values: no angle is
/// worked out that is not needed, everything lies in flat arrays, and what can be done at once is (Highway, the best
/// set of instructions of the machine). Immutable after construction, so one object serves any number of threads; no
/// allocation per evaluation.
///
/// Values are worked out in float32, places along slices in whole numbers of at most 3.4e-7 degrees (see SliceTables),
/// angles in double: within a few 1e-5 of the same in long double where a curve is steep, within 1e-6 where not.
class VectorEvaluator {
 public:
  /// `sliced` must have passed check_sliced with this lattice; neither is needed afterwards.
  VectorEvaluator(const SlicedBrdf& sliced, const Lattice& lattice)
      : VectorEvaluator(sliced, lattice, std::make_shared<const LatticeTables>(lattice)) {}
  /// With tables of this lattice that others may share.
  VectorEvaluator(const SlicedBrdf& sliced, const Lattice& lattice, std::shared_ptr<const LatticeTables> tables)
      : tables_(sliced, lattice, std::move(tables)) {}

  /// Of tables that were made otherwise.
  explicit VectorEvaluator(SliceTables tables) : tables_(std::move(tables)) {}

  /// The same with slices that are straight between rows, near enough for no slice to be off by more than `tolerance`
  /// (see presample). Faster, and larger.
  [[nodiscard]] VectorEvaluator presampled(double tolerance) const {
    return VectorEvaluator(presample(tables_, tolerance));
  }

  /// The same as a dense table: see make_dense. `sliced` and `lattice` are those of the constructor.
  [[nodiscard]] VectorEvaluator dense(const SlicedBrdf& sliced, const Lattice& lattice,
                                      const DenseLimits& limits = {}) const {
    return VectorEvaluator(make_dense(tables_, sliced, lattice, limits));
  }

  [[nodiscard]] std::size_t channel_count() const { return tables_.channels; }

  /// f_r [1/sr] for vectors x, y, z with the normal at (0, 0, 1), of any length but 0; 0 where one points below the
  /// horizon or is no direction. `w_i` and `w_v` have the same length; `values` has w_i.size() x channel_count()
  /// entries, channel fastest. Exchanging w_i and w_v gives the same bits, and so does one pair at a time.
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) const;

  /// What the slices give at frame coordinates [degrees], as Evaluator::evaluate_at.
  void evaluate_at(const Coordinates& x, std::span<float> values) const;

  /// Of everything this holds.
  [[nodiscard]] std::size_t bytes() const { return tables_.bytes() + tables_.lattice->bytes(); }

 private:
  SliceTables tables_;
};

}  // namespace sbrdf::internal
