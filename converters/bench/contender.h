#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include <glm/vec3.hpp>

#include "codec/evaluation/lazy_evaluator.h"
#include "codec/evaluation/vector_evaluator.h"
#include "codec/file/encoder.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A material in memory, ready to be evaluated one way or another: what is timed. Immutable; several threads may ask at
/// once.
class Contender {
 public:
  Contender() = default;
  Contender(const Contender&) = delete;
  Contender& operator=(const Contender&) = delete;
  virtual ~Contender() = default;

  [[nodiscard]] virtual std::size_t channel_count() const = 0;
  /// f(i,v) = f(v,i) by construction: judged against the mean of both where the source is not.
  [[nodiscard]] virtual bool is_reciprocal() const = 0;
  /// f_r [1/sr] for unit vectors above the horizon, without cosine. `values` has w_i.size() x channel_count() entries,
  /// channel fastest. One pair at a time gives the same bits.
  virtual void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const = 0;
};

/// Any source.
class SourceContender final : public Contender {
 public:
  explicit SourceContender(std::unique_ptr<BrdfSource> source) : source_(std::move(source)) {}

  [[nodiscard]] std::size_t channel_count() const override { return source_->channel_count(); }
  [[nodiscard]] bool is_reciprocal() const override { return source_->traits().reciprocal; }
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                std::span<float> values) const override {
    source_->evaluate_vectors(w_i, w_v, values);
  }

 private:
  std::unique_ptr<BrdfSource> source_;
};

/// Slices, in any form that an evaluator can bring them into.
class SlicedContender final : public Contender {
 public:
  using Make = VectorEvaluator (*)(const DecodedSliced& decoded);
  /// `decoded` is not needed afterwards.
  SlicedContender(const DecodedSliced& decoded, Make make) : evaluator_(make(decoded)) {}

  [[nodiscard]] std::size_t channel_count() const override { return evaluator_.channel_count(); }
  [[nodiscard]] bool is_reciprocal() const override { return true; }
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                std::span<float> values) const override {
    evaluator_.evaluate(w_i, w_v, values);
  }

 private:
  VectorEvaluator evaluator_;
};

/// Slices in the exact form, made when it pays, as a material of the front door has them.
class LazyContender final : public Contender {
 public:
  explicit LazyContender(DecodedSliced decoded)
      : decoded_(std::move(decoded)), evaluator_(decoded_.sliced, decoded_.lattice) {}

  [[nodiscard]] std::size_t channel_count() const override { return decoded_.sliced.channel_count(); }
  [[nodiscard]] bool is_reciprocal() const override { return true; }
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                std::span<float> values) const override {
    evaluator_.evaluate(w_i, w_v, values);
  }

 private:
  DecodedSliced decoded_;
  LazyEvaluator evaluator_;
};

/// A contender where a source is wanted, as by what compares sources. `reference` says what the channels are. Keeps
/// references to both.
class ContenderSource final : public BrdfSource {
 public:
  ContenderSource(const Contender& contender, const BrdfSource& reference);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;

 private:
  const Contender& contender_;
  SourceTraits traits_;
};

}  // namespace sbrdf::internal
