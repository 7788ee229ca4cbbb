#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "codec/evaluation/vector_evaluator.h"
#include "codec/series/series.h"
#include "converters/files/format.h"
#include "converters/files/sliced/report_remarks.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// What a dense file is, as its index tells.
[[nodiscard]] SourceTraits series_traits(const SeriesBrdf& brdf);

/// A dense file, expanded into its table. Reciprocal by construction.
class SeriesSource final : public BrdfSource {
 public:
  SeriesSource(const SeriesBrdf& brdf, VectorEvaluator table, std::shared_ptr<const ByteSource> bytes);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override;
  [[nodiscard]] std::string_view metadata() const override { return metadata_; }
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const override;

 private:
  VectorEvaluator table_;
  SourceTraits traits_;
  std::string metadata_;
  std::shared_ptr<const ByteSource> bytes_;
};

/// Opens a dense file (specs/sbrdf.md, section 14), its levels of detail up to `most_level`.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_series(std::shared_ptr<const ByteSource> bytes,
                                                              const MemoryLimit& memory,
                                                              std::uint32_t most_level = kSeriesLevels);

/// A dense file that is fitted to the source, and what there is to say of it.
[[nodiscard]] Result<MadeFile> make_series_file(const BrdfSource& source, const Options& options,
                                                const Progress& progress);

}  // namespace sbrdf::internal
