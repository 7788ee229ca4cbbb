// What an evaluation costs, in instructions: these are the same on a busy machine, as times are not. With the vectors
// of 128 bits that every processor has, so that all machines count the same; wider ones take about half as many.
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "codec/evaluation/vector_evaluator.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/instruction_count.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 16;

/// Instructions for each pair of a batch, all of which lie far from poles.
std::optional<double> cost_of(const VectorEvaluator& evaluator) {
  std::vector<glm::vec3> w_i;
  std::vector<glm::vec3> w_v;
  for (std::size_t k = 0; k < kPairs; ++k) {
    const double angle = 4 * static_cast<double>(k);
    w_i.emplace_back(vector_from_direction(direction_from_degrees(35 + 0.3 * angle, 5.1 * angle)));
    w_v.emplace_back(vector_from_direction(direction_from_degrees(60 - 0.4 * angle, 40 + 2.3 * angle)));
  }
  std::vector<float> values(kPairs * evaluator.channel_count());
  evaluator.evaluate(w_i, w_v, values);  // what is done once
  const std::optional<std::uint64_t> steps = count_instructions([&] { evaluator.evaluate(w_i, w_v, values); });
  if (!steps) return std::nullopt;
  return static_cast<double>(*steps) / kPairs;
}

SampledBrdf sampled(const FrameSpec& spec) {
  return sample_function(
      spec, 600, DomainKind::kLog,
      [&](const DirectionPair& pair, std::size_t channel) {
        return std::pow(analytic_brdf(pair, spec.symmetries), 1.0 + 0.5 * static_cast<double>(channel));
      },
      3);
}

// Bounds are a quarter above what was counted (g++ 12), for other compilers; each was twice as high or more before the
// lines of a cell were worked out together.
TEST(EvaluationCost, StaysWithinItsInstructions) {
#if !defined(NDEBUG) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "counts are those of optimised programs";
#endif
#if HWY_ARCH_X86
  const FrameSpec isotropic = half_difference_frame({0, 5, 20, 40, 80}, {0, 15, 40, 80}, {0}, {0, 50, 90, 130},
                                                    {.isotropic = true, .mirror_x = true});
  const FrameSpec anisotropic = elevation_frame(20, 90, {}).value();
  const SampledBrdf three = sampled(isotropic);
  const SampledBrdf four = sampled(anisotropic);
  const VectorEvaluator three_axes(three.sliced, three.lattice);
  const VectorEvaluator four_axes(four.sliced, four.lattice);
  hwy::GetChosenTarget().Update(HWY_SSE4);
  const struct {
    const char* name;
    std::optional<double> cost;
    double most;
  } rows[] = {{"three axes, exact", cost_of(three_axes), 2500},
              {"three axes, pre-sampled", cost_of(three_axes.presampled(1e-3)), 2150},
              {"three axes, dense", cost_of(three_axes.dense(three.sliced, three.lattice)), 870},
              {"four axes, exact", cost_of(four_axes), 4800},
              {"four axes, pre-sampled", cost_of(four_axes.presampled(1e-3)), 4200}};
  hwy::GetChosenTarget().DeInit();
  for (const auto& row : rows) {
    if (!row.cost) GTEST_SKIP() << "this system does not let a process trace its children";
    RecordProperty(row.name, static_cast<int>(std::lround(*row.cost)));
    EXPECT_LE(*row.cost, row.most) << row.name;
    EXPECT_GT(*row.cost, 50) << row.name;
  }
#else
  GTEST_SKIP() << "counts are those of x86";
#endif
}

}  // namespace
}  // namespace sbrdf::internal
