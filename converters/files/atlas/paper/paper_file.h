#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "codec/atlas/paper/paper_evaluator.h"
#include "codec/atlas/paper/paper_textures.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The paper's four textures, evaluated as its shader would (specs/atlas.md).
class PaperSource final : public BrdfSource {
 public:
  /// Texels are there; `description` is one line for people.
  PaperSource(PaperTextures textures, std::string description);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;

 private:
  PaperTextures textures_;
  PaperEvaluator evaluator_;
  SourceTraits traits_;
};

/// Opens a manifest of the layout "paper", whose text is `json`, and the textures that it names.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_paper(const ByteSource& manifest, std::string_view json);

}  // namespace sbrdf::internal
