#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "codec/atlas/atlas.h"
#include "codec/atlas/atlas_evaluator.h"
#include "converters/files/format.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// An atlas, evaluated as its shader does (specs/atlas.md).
class AtlasSource final : public BrdfSource {
 public:
  /// `texels` are there; `description` is one line for people.
  AtlasSource(Atlas atlas, std::string description);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;

  [[nodiscard]] const Atlas& atlas() const { return atlas_; }

 private:
  Atlas atlas_;
  AtlasEvaluator evaluator_;
  SourceTraits traits_;
};

/// Opens a manifest and the texture that it names: the row of the format table.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_atlas(std::shared_ptr<const ByteSource> bytes,
                                                             const Options& options);

}  // namespace sbrdf::internal
