#include "converters/files/atlas/atlas_judge.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "codec/atlas/bake.h"
#include "codec/evaluation/evaluator.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kJudgedBy = 20'000;
constexpr std::uint64_t kSeed = 5;
constexpr std::size_t kBlock = 256;

AtlasErrors errors_of(std::span<const float> values, const HeldBack& held_back) {
  const HeldBackError error = judge(values, held_back);
  return {error.mre_percent, error.rel_l1_percent, held_back.pairs.size()};
}

}  // namespace

Result<AtlasJudge> AtlasJudge::make(const DecodedSliced& sliced, const BrdfSource& source, const AtlasCells& cells) {
  const Evaluator evaluator(sliced.sliced, sliced.lattice);
  const FrameSpec& frame = sliced.sliced.frame;
  HeldBackDraw wanted = {kJudgedBy, kSeed, frame.symmetries.isotropic, frame.theta_max_deg};
  const AtlasLayout axes = atlas_axes(sliced.lattice);
  if (!cells.is_everything()) {
    wanted.measured = [&](std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) {
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        flags[k] = cells.has(cell_of(axes, pairs[k])) ? 1 : 0;
      }
    };
  }
  Result<HeldBack> drawn = draw_held_back(wanted, evaluator.channel_count(), [&](auto pairs, auto values) {
    evaluate_in_parallel(source, pairs, values);
    return ok_status();
  });
  if (!drawn) return drawn.error();
  AtlasJudge judge;
  judge.channels_ = evaluator.channel_count();
  judge.from_source_ = *std::move(drawn);
  judge.from_slices_ = judge.from_source_;
  judge.from_slices_.values = evaluate(evaluator, judge.from_source_.pairs);
  return judge;
}

AtlasJudge::Errors AtlasJudge::errors(const Evaluate& evaluate) const {
  std::vector<float> values(from_slices_.values.size());
  for_all(from_slices_.pairs.size(), kBlock, [&](std::size_t k) {
    std::array<float, 3> rgb{};
    evaluate(from_slices_.pairs[k], rgb);
    std::copy_n(rgb.begin(), channels_, values.begin() + static_cast<std::ptrdiff_t>(k * channels_));
  });
  return {errors_of(values, from_slices_), errors_of(values, from_source_)};
}

}  // namespace sbrdf::internal
