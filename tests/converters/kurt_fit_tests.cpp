#include "converters/models/kurt_fit.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/core/parallel.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

KurtFitOptions with_lobes(std::size_t lobes, FitMetric metric = FitMetric::kLog) {
  KurtFitOptions options;
  options.lobes = lobes;
  options.metric = metric;
  return options;
}

void expect_same(const KurtModel& found, KurtModel expected) {
  const auto near = [](double value, double truth) { return std::abs(value - truth) <= 0.01 * truth + 1e-6; };
  std::sort(expected.lobes.begin(), expected.lobes.end(),
            [](const KurtLobe& a, const KurtLobe& b) { return a.m_x * a.m_y > b.m_x * b.m_y; });
  ASSERT_EQ(found.lobes.size(), expected.lobes.size());
  for (std::size_t c = 0; c < 3; ++c) EXPECT_TRUE(near(found.k_d[c], expected.k_d[c])) << found.k_d[c];
  for (std::size_t l = 0; l < found.lobes.size(); ++l) {
    const KurtLobe& a = found.lobes[l];
    const KurtLobe& b = expected.lobes[l];
    for (std::size_t c = 0; c < 3; ++c) EXPECT_TRUE(near(a.k_s[c], b.k_s[c])) << a.k_s[c] << " for " << b.k_s[c];
    EXPECT_TRUE(near(a.f_0, b.f_0)) << a.f_0;
    EXPECT_TRUE(near(a.m_x, b.m_x)) << a.m_x;
    EXPECT_TRUE(near(a.m_y, b.m_y)) << a.m_y;
    EXPECT_TRUE(near(a.alpha, b.alpha)) << a.alpha;
  }
}

// From a cold start, every parameter within a hundredth.
TEST(KurtFit, RecoversTheTenMaterials) {
  for (const FitMetric metric : {FitMetric::kLog, FitMetric::kCubeRoot}) {
    for (const std::string& name : kurt_material_names()) {
      SCOPED_TRACE(name + (metric == FitMetric::kLog ? ", log" : ", cube root"));
      const KurtModel expected = kurt_material(name).value();
      const KurtFit fit = fit_kurt(*make_kurt_source(expected), with_lobes(expected.lobes.size(), metric)).value();
      EXPECT_LT(fit.rms, 1e-5);
      EXPECT_EQ(fit.pairs, 4000U);
      EXPECT_GE(fit.same_minimum, 1U);
      expect_same(fit.model, expected);
    }
  }
}

TEST(KurtFit, IsTheSameOnAnyNumberOfThreads) {
  const auto source = make_kurt_source(kurt_material("fabric135").value());
  const std::string free = emit_kurt_json(fit_kurt(*source, with_lobes(2)).value().model);
  std::string alone;
  with_threads(1, [&] { alone = emit_kurt_json(fit_kurt(*source, with_lobes(2)).value().model); });
  EXPECT_EQ(free, alone);
}

TEST(KurtFit, TakesOneChannelForThreeAndTheMeanOfBothWays) {
  const auto red = make_kurt_source(kurt_material("Yellow satin").value());
  // A tenth more one way, a tenth less the other way.
  const FunctionSource source(
      [&](const DirectionPair& pair, std::size_t) {
        std::array<float, 3> rgb{};
        red->evaluate(std::span(&pair, 1), rgb);
        return rgb[0] * (pair.i.theta > pair.v.theta ? 1.1 : 0.9);
      },
      {.channels = {"Y"}});
  const KurtFit fit = fit_kurt(source, with_lobes(1)).value();
  KurtModel grey = kurt_material("Yellow satin").value();
  grey.k_d = {grey.k_d[0], grey.k_d[0], grey.k_d[0]};
  grey.lobes[0].k_s = {grey.lobes[0].k_s[0], grey.lobes[0].k_s[0], grey.lobes[0].k_s[0]};
  expect_same(fit.model, grey);
}

TEST(KurtFit, ChannelsThatAreBlackStayBlack) {
  KurtModel model = kurt_material("Purple satin").value();
  model.k_d[1] = 0;
  model.lobes[0].k_s[1] = 0;
  const KurtFit fit = fit_kurt(*make_kurt_source(model), with_lobes(1)).value();
  expect_same(fit.model, model);
}

TEST(KurtFit, RefusesOtherChannelsAndStopsWhenAsked) {
  const auto one = [](const DirectionPair&, std::size_t) { return 1.0; };
  const auto four = fit_kurt(FunctionSource(one, {.channels = {"a", "b", "c", "d"}}), with_lobes(1));
  ASSERT_FALSE(four);
  EXPECT_EQ(four.error().code, ErrorCode::kUnsupported);
  Progress stop;
  stop.report = [](double) { return false; };
  const auto stopped = fit_kurt(FunctionSource(one), with_lobes(1), stop);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, interrupted_error().code);
}

TEST(KurtJson, GivesBackEveryNumber) {
  for (const std::string& name : kurt_material_names()) {
    KurtModel model = kurt_material(name).value();
    model.k_d[0] = 1.0 / 3;
    model.lobes[0].m_x = 0.1 + 0.2;
    const KurtModel read = parse_kurt_json(emit_kurt_json(model)).value();
    EXPECT_EQ(emit_kurt_json(read), emit_kurt_json(model));
    EXPECT_EQ(read.k_d, model.k_d);
    EXPECT_EQ(read.lobes[0].m_x, model.lobes[0].m_x);
    EXPECT_EQ(read.name, model.name);
  }
}

}  // namespace
}  // namespace sbrdf::internal
