#include "codec/material/value_map.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 5;
constexpr Coordinates kPlace = {30, 40, 20, 10};

SampledBrdf guided_material() {
  const FrameSpec spec =
      half_difference_frame({0, 10, 40}, {0, 40}, {0, 90, 180, 270}, {0, 45, 90, 135}, {.mirror_x = true});
  SampledBrdf made;
  made.lattice = build_lattice(spec).value();
  SamplingOptions options;
  options.sample_count = made.lattice.crossings.size() + 100;
  options.domain = DomainKind::kLog;
  options.guide_ratio = 1.5;
  const TestFunction function = [](const DirectionPair& pair, std::size_t c) {
    return analytic_brdf(pair, {.mirror_x = true}) * static_cast<double>(c + 1);
  };
  made.sliced = sample_slices(made.lattice, channel_names(kChannels), measure_of(function, kChannels), options).value();
  return made;
}

TEST(ValueMap, GivesBackWhatItMappedForAnyChannelsThatItTakesAtOnce) {
  const auto [lattice, sliced] = guided_material();
  const ValueMap<double> map(sliced, lattice);
  const std::array<float, kChannels> f = {0.5F, 1.5F, 2.5F, 3.5F, 0.25F};
  std::array<double, kChannels> mapped{};
  map.forward(kPlace, f, mapped);
  for (std::size_t count = 1; count <= ValueMap<double>::kMostChannels; ++count) {
    for (std::size_t channel = 0; channel + count <= kChannels; ++channel) {
      std::vector<double> values(mapped.begin() + std::ptrdiff_t(channel),
                                 mapped.begin() + std::ptrdiff_t(channel + count));
      map.inverse(kPlace, channel, values);
      for (std::size_t c = 0; c < count; ++c) EXPECT_NEAR(values[c], f[channel + c], 1e-12);
    }
  }
}

TEST(ValueMap, MapsAllSamplesOfASliceAsItMapsThemOneByOne) {
  const auto [lattice, sliced] = guided_material();
  const ValueMap<double> map(sliced, lattice);
  const std::vector<SliceSamples> slices = gather_slices(sliced, lattice);
  std::vector<double> all;
  std::array<double, kChannels> one{};
  for (std::size_t k = 0; k < slices.size(); ++k) {
    map.forward(lattice.slices[k], slices[k], all);
    ASSERT_EQ(all.size(), slices[k].size() * kChannels);
    for (std::size_t s = 0; s < slices[k].size(); ++s) {
      map.forward(coordinates_on(lattice.slices[k], slices[k].positions_deg[s]),
                  std::span(slices[k].values).subspan(s * kChannels, kChannels), one);
      for (std::size_t c = 0; c < kChannels; ++c) ASSERT_EQ(all[s * kChannels + c], one[c]);
    }
  }
}

#ifndef NDEBUG
TEST(ValueMapDeathTest, StopsAtChannelsThatAreNotThere) {
  const auto [lattice, sliced] = guided_material();
  const ValueMap<double> map(sliced, lattice);
  std::vector<double> values(3);
  EXPECT_DEATH(map.inverse(kPlace, kChannels - 2, values), "channel");
  values.resize(4);
  EXPECT_DEATH(map.inverse(kPlace, 0, values), "kMostChannels");
}
#endif

}  // namespace
}  // namespace sbrdf::internal
