#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/lazy_evaluator.h"
#include "codec/file/encoder.h"
#include "converters/files/format.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// What a sliced file is, as its index tells.
[[nodiscard]] SourceTraits sliced_traits(const FrameSpec& frame, const std::vector<std::string>& channels);

/// A sliced BRDF that can be evaluated. Reciprocal by construction. What evaluation needs is made when values are first
/// asked for, from angles or from vectors.
class SlicedSource final : public BrdfSource {
 public:
  explicit SlicedSource(DecodedSliced decoded);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override;
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override;
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override;
  [[nodiscard]] const DecodedSliced* sliced() const override { return &decoded_; }
  [[nodiscard]] std::string_view metadata() const override { return decoded_.sliced.metadata; }

 private:
  DecodedSliced decoded_;
  SourceTraits traits_;
  mutable std::once_flag angles_asked_;
  mutable std::optional<Evaluator> for_angles_;
  LazyEvaluator for_vectors_;
};

/// Opens a sliced file (specs/sbrdf.md), all of it, within options.memory: the row of the format table. Keeps nothing
/// of the bytes.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_sliced(std::shared_ptr<const ByteSource> bytes,
                                                              const Options& options);

/// Writes a sliced file. A source that has slices is written with just these, in another precision or another layout
/// where `precision` or `chunks` ask for it, unless some other option asks to sample it anew; every other source is
/// sampled. A copy in another precision says in its metadata that the errors in there were measured before.
[[nodiscard]] Status save_sliced(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                                 const Progress& progress);

}  // namespace sbrdf::internal
