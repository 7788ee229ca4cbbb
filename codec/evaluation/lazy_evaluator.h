#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "codec/evaluation/vector_evaluator.h"

namespace sbrdf::internal {

/// A VectorEvaluator that is made when it pays: who asks a material for a value or two waits for the slices that these
/// need, not for all. The bits are the same. Serves any number of threads.
class LazyEvaluator {
 public:
  /// `sliced` must have passed check_sliced with this lattice; both must live as long as this object.
  LazyEvaluator(const SlicedBrdf& sliced, const Lattice& lattice) : sliced_(sliced), lattice_(lattice) {}

  /// As VectorEvaluator::evaluate.
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) const;

  /// Of all slices: made now if it was not before.
  [[nodiscard]] const VectorEvaluator& whole() const;

  /// Of everything this holds, beside `sliced` and `lattice`.
  [[nodiscard]] std::size_t bytes() const;

 private:
  [[nodiscard]] const std::shared_ptr<const LatticeTables>& lattice_tables() const;

  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  mutable std::once_flag lattice_made_;
  mutable std::shared_ptr<const LatticeTables> lattice_tables_;
  mutable std::once_flag whole_made_;
  mutable std::optional<VectorEvaluator> whole_;
  mutable std::atomic<const VectorEvaluator*> ready_ = nullptr;  ///< whole_, once it is there
  mutable std::atomic<std::size_t> asked_ = 0;                   ///< pairs, before it was
};

}  // namespace sbrdf::internal
