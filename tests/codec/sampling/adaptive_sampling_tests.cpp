#include "codec/sampling/adaptive_sampling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;

Lattice small_lattice(const Symmetries& symmetries = {}) {
  return build_lattice(elevation_frame(28, 180, symmetries).value()).value();
}

TestFunction colourful(const Symmetries& symmetries) {
  return [symmetries](const DirectionPair& pair, std::size_t channel) {
    const double f = analytic_brdf(pair, symmetries);
    return f + 0.3 * f * f * static_cast<double>(channel + 1);
  };
}

SamplingOptions options_for(std::uint64_t count, DomainKind domain = DomainKind::kLinear) {
  SamplingOptions options;
  options.sample_count = count;
  options.domain = domain;
  return options;
}

SlicedBrdf sample(const Lattice& lattice, const SamplingOptions& options, const TestFunction& function,
                  std::size_t channels = 1) {
  return sample_slices(lattice, channel_names(channels), measure_of(function, channels), options).value();
}

/// How many pairs each call of Measure asked for.
std::vector<std::size_t> round_sizes(const Lattice& lattice, const SamplingOptions& options) {
  std::vector<std::size_t> sizes;
  const Measure measure = measure_of(colourful({}), 1);
  const auto result = sample_slices(
      lattice, {"f"},
      [&](auto pairs, auto values) {
        sizes.push_back(pairs.size());
        return measure(pairs, values);
      },
      options);
  EXPECT_TRUE(result);
  return sizes;
}

TEST(AdaptiveSampling, MeasuresTheCrossingsFirstAndThenTheSharesOfAlgorithm1) {
  EXPECT_THAT(round_sizes(small_lattice(), options_for(55 + 500)),
              ElementsAre(55, 90, 90, 90, 90, 90, 10, 10, 10, 10, 10));
  SamplingOptions options = options_for(55 + 500);
  options.first_share = 0.6;
  options.first_rounds = 3;
  options.second_rounds = 2;
  EXPECT_THAT(round_sizes(small_lattice(), options), ElementsAre(55, 100, 100, 100, 100, 100));
}

TEST(AdaptiveSampling, TakesExactlyTheNumberAskedForWhereSharesAreNotWhole) {
  const Lattice lattice = small_lattice();
  for (const std::uint64_t extra : {0U, 1U, 2U, 7U, 99U, 103U, 331U}) {
    const std::vector<std::size_t> sizes = round_sizes(lattice, options_for(55 + extra));
    EXPECT_EQ(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}), 55 + extra);
    const SlicedBrdf sliced = sample(lattice, options_for(55 + extra), colourful({}));
    EXPECT_EQ(sliced.crossing_count(), 55U);
    EXPECT_EQ(sliced.adaptive_count(), extra);
    for (std::size_t round = 1; round < sizes.size(); ++round) {
      EXPECT_NEAR(static_cast<double>(sizes[round]), static_cast<double>(extra) * (round <= 5 ? 0.18 : 0.02), 1);
    }
  }
}

TEST(AdaptiveSampling, MeasuresNoDirectionPairTwice) {
  const Lattice lattice = small_lattice();
  std::vector<DirectionPair> all;
  const Measure measure = measure_of(colourful({}), 1);
  ASSERT_TRUE(sample_slices(
      lattice, {"f"},
      [&](auto pairs, auto values) {
        all.insert(all.end(), pairs.begin(), pairs.end());
        return measure(pairs, values);
      },
      options_for(500)));
  ASSERT_EQ(all.size(), 500U);
  for (std::size_t a = 0; a < all.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) ASSERT_GT(measurement_distance(all[a], all[b], {}), 1e-4) << a << ", " << b;
  }
}

TEST(AdaptiveSampling, StoresTheValueThatBelongsToEachPosition) {
  for (const Symmetries& symmetries : {Symmetries{}, Symmetries{.isotropic = true}, Symmetries{.mirror_x = true}}) {
    const Lattice lattice = small_lattice(symmetries);
    const SlicedBrdf sliced = sample(lattice, options_for(300), colourful(symmetries), 2);
    ASSERT_TRUE(check_sliced(sliced, lattice));
    for (std::size_t k = 0; k < sliced.crossing_values.size(); ++k) {
      const DirectionPair pair = directions_at(lattice.spec, lattice.crossings[k / 2]);
      ASSERT_FLOAT_EQ(sliced.crossing_values[k], static_cast<float>(colourful(symmetries)(pair, k % 2)));
    }
    std::size_t next = 0;
    for (std::size_t s = 0; s < lattice.slices.size(); ++s) {
      for (std::uint32_t k = 0; k < sliced.sample_counts[s]; ++k, ++next) {
        const Slice& slice = lattice.slices[s];
        const double position = place_in_degrees(lattice, slice, sliced.positions[next]);
        const DirectionPair pair = directions_at(lattice.spec, coordinates_on(slice, position));
        for (std::size_t c = 0; c < 2; ++c) {
          ASSERT_FLOAT_EQ(sliced.sample_values[2 * next + c], static_cast<float>(colourful(symmetries)(pair, c)));
        }
      }
    }
  }
}

/// Samples of one slice by position: value of each channel in the value domain.
using SlowSlice = std::map<double, std::vector<double>>;

struct SlowCandidate {
  double weight = 0;
  std::size_t slice = 0;
  double position = 0;
};

/// Algorithm 1 once more, from the text of the paper and with nothing but sorted lists.
class SlowSampler {
 public:
  SlowSampler(const Lattice& lattice, const SamplingOptions& options, const SlicedBrdf& reference,
              const TestFunction& function)
      : lattice_(lattice), options_(options), domain_(reference.domain), function_(function) {
    channels_ = reference.channel_count();
    for (const Slice& slice : lattice.slices) {
      SlowSlice samples;
      for (const SliceNode& node : lattice.nodes_of(slice)) {
        samples[node.position_deg] = measured(directions_at(lattice.spec, lattice.crossings[node.crossing]));
      }
      slices_.push_back(samples);
    }
  }

  void run() {
    const double adaptive = static_cast<double>(options_.sample_count - lattice_.crossings.size());
    double done = 0;
    for (int round = 1; round <= 10; ++round) {
      const double share = round <= 5 ? 0.9 * round / 5 : 0.9 + 0.1 * (round - 5) / 5;
      const double target = std::round(share * adaptive);
      iterate(static_cast<std::size_t>(target - done));
      done = target;
    }
  }

  [[nodiscard]] const std::vector<SlowSlice>& slices() const { return slices_; }

 private:
  [[nodiscard]] std::vector<double> measured(const DirectionPair& pair) const {
    std::vector<double> values;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double f = static_cast<float>(function_(pair, c));
      values.push_back(domain_.kind == DomainKind::kLinear ? f : std::log(f / domain_.reference[c]));
    }
    return values;
  }

  // Positions on the endless line, of which the slice shows one period: sorted, without the samples of `left_out`.
  [[nodiscard]] SlowSlice unrolled(std::size_t s, double left_out) const {
    const Slice& slice = lattice_.slices[s];
    SlowSlice all;
    for (const auto& [position, values] : slices_[s]) {
      if (position == left_out) continue;
      all[position] = values;
      if (slice.boundary == Boundary::kPeriodic) {
        all[position + slice.length_deg] = values;
        all[position - slice.length_deg] = values;
      }
      if (slice.boundary == Boundary::kMirrored) {
        all[2 * slice.start_deg - position] = values;
        all[2 * (slice.start_deg + slice.length_deg) - position] = values;
      }
    }
    return all;
  }

  [[nodiscard]] double error(std::size_t s, double position) const {
    const SlowSlice others = unrolled(s, position);
    const auto after = others.upper_bound(position);
    if (after == others.begin() || after == others.end()) return 0;
    const auto before = std::prev(after);
    const double t = (position - before->first) / (after->first - before->first);
    double worst = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double predicted = (1 - t) * before->second[c] + t * after->second[c];
      worst = std::max(worst, std::abs(predicted - slices_[s].at(position)[c]));
    }
    return worst;
  }

  void iterate(std::size_t count) {
    std::vector<SlowCandidate> list;
    for (std::size_t s = 0; s < slices_.size(); ++s) {
      const Slice& slice = lattice_.slices[s];
      std::vector<double> positions;
      std::vector<double> errors;
      for (const auto& [position, values] : slices_[s]) {
        positions.push_back(position);
        errors.push_back(error(s, position));
      }
      if (slice.boundary == Boundary::kPeriodic) {
        positions.push_back(positions.front() + slice.length_deg);
        errors.push_back(errors.front());
      }
      for (std::size_t k = 0; k + 1 < positions.size(); ++k) {
        if ((positions[k + 1] - positions[k]) * slice.gap_scale < 2 * options_.minimum_gap_deg) continue;
        list.push_back({std::max(errors[k], errors[k + 1]), s, (positions[k] + positions[k + 1]) / 2});
      }
    }
    std::sort(list.begin(), list.end(), [](const SlowCandidate& a, const SlowCandidate& b) {
      return std::tuple(-a.weight, a.slice, a.position) < std::tuple(-b.weight, b.slice, b.position);
    });
    list.resize(std::min(list.size(), count));
    for (const auto& [weight, s, position] : list) {
      slices_[s][position] = measured(directions_at(lattice_.spec, coordinates_on(lattice_.slices[s], position)));
    }
  }

  const Lattice& lattice_;
  const SamplingOptions& options_;
  const ValueDomain& domain_;
  const TestFunction& function_;
  std::size_t channels_ = 0;
  std::vector<SlowSlice> slices_;
};

TEST(AdaptiveSampling, PicksTheSamplesThatASlowReadingOfThePaperPicks) {
  for (const Symmetries& symmetries :
       {Symmetries{}, Symmetries{.isotropic = true}, Symmetries{.mirror_x = true, .mirror_y = true}}) {
    for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
      const Lattice lattice = small_lattice(symmetries);
      const SamplingOptions options = options_for(lattice.crossings.size() + 150, domain);
      const TestFunction function = colourful(symmetries);
      const SlicedBrdf sliced = sample(lattice, options, function, 2);
      SlowSampler slow(lattice, options, sliced, function);
      slow.run();
      std::size_t next = 0;
      for (std::size_t s = 0; s < lattice.slices.size(); ++s) {
        const Slice& slice = lattice.slices[s];
        std::vector<double> expected;
        for (const auto& [position, values] : slow.slices()[s]) expected.push_back(position);
        std::vector<double> found;
        for (const SliceNode& node : lattice.nodes_of(slice)) found.push_back(node.position_deg);
        for (std::uint32_t k = 0; k < sliced.sample_counts[s]; ++k) {
          found.push_back(place_in_degrees(lattice, slice, sliced.positions[next++]));
        }
        std::sort(found.begin(), found.end());
        EXPECT_THAT(found, testing::Pointwise(testing::DoubleNear(1e-9), expected)) << "slice " << s;
      }
    }
  }
}

TEST(AdaptiveSampling, FillsEverySliceToTheSmallestGapAndStopsThere) {
  const Lattice lattice = small_lattice();
  const SlicedBrdf sliced = sample(lattice, options_for(1000000), colourful({}));
  std::size_t next = 0;
  for (std::size_t s = 0; s < lattice.slices.size(); ++s) {
    const Slice& slice = lattice.slices[s];
    std::vector<double> positions;
    for (const SliceNode& node : lattice.nodes_of(slice)) positions.push_back(node.position_deg);
    for (std::uint32_t k = 0; k < sliced.sample_counts[s]; ++k) {
      positions.push_back(place_in_degrees(lattice, slice, sliced.positions[next++]));
    }
    std::sort(positions.begin(), positions.end());
    if (slice.boundary == Boundary::kPeriodic) positions.push_back(positions.front() + slice.length_deg);
    for (std::size_t k = 1; k < positions.size(); ++k) {
      const double gap = (positions[k] - positions[k - 1]) * slice.gap_scale;
      ASSERT_GE(gap, 1);
      ASSERT_LT(gap, 2);
    }
  }
}

TEST(AdaptiveSampling, KeepsToAnotherSmallestGap) {
  const Lattice lattice = small_lattice();
  SamplingOptions options = options_for(1000000);
  options.minimum_gap_deg = 10;
  // Of the intervals of 28 and 24 degrees between elevations, each is halved once; those of 90 degrees of a ring, an
  // axial or a diagonal slice into 8.
  const SlicedBrdf sliced = sample(lattice, options, colourful({}));
  std::size_t expected = 0;
  for (const Slice& slice : lattice.slices) expected += slice.interval_count() * (slice.kind == kHorizontal ? 1 : 7);
  EXPECT_EQ(sliced.adaptive_count(), expected);
}

TEST(AdaptiveSampling, GoesToTheFirstGapsOfTheFirstSlicesWhereNothingVaries) {
  const Lattice lattice = small_lattice();
  const SlicedBrdf sliced = sample(lattice, options_for(55 + 100), [](const auto&, std::size_t) { return 1.0; });
  std::size_t gaps = 0;
  for (std::size_t s = 0; s < lattice.slices.size() && gaps < 18; ++s) {
    for (std::uint32_t k = 0; k < lattice.slices[s].interval_count() && gaps < 18; ++k, ++gaps) {
      const auto first = std::find(sliced.positions.begin(), sliced.positions.end(), SamplePosition{k, 0x8000});
      EXPECT_NE(first, sliced.positions.end());
      EXPECT_GT(sliced.sample_counts[s], k);
    }
  }
  const auto last =
      std::find_if(sliced.sample_counts.rbegin(), sliced.sample_counts.rend(), [](auto n) { return n > 0; });
  for (auto count = last; count != sliced.sample_counts.rend(); ++count) EXPECT_GT(*count, 0U);
}

TEST(AdaptiveSampling, GathersWhereTheFunctionVariesMost) {
  const Lattice lattice = build_lattice(elevation_frame(20, 180, {.isotropic = true}).value()).value();
  const auto step = [](const DirectionPair& pair, std::size_t) {
    return pair.i.theta + pair.v.theta > 0.9 ? 1.0 : 0.0;
  };
  const SlicedBrdf sliced = sample(lattice, options_for(lattice.crossings.size() + 6), step);
  std::size_t horizontal = 0;
  for (std::size_t s = 0; s < lattice.slices.size(); ++s) {
    if (lattice.slices[s].kind == kHorizontal) horizontal += sliced.sample_counts[s];
  }
  EXPECT_EQ(horizontal, sliced.adaptive_count());
}

TEST(AdaptiveSampling, GivesTheSameBytesEveryTime) {
  const Lattice lattice = small_lattice();
  const SlicedBrdf once = sample(lattice, options_for(400, DomainKind::kLog), colourful({}), 3);
  const SlicedBrdf again = sample(lattice, options_for(400, DomainKind::kLog), colourful({}), 3);
  EXPECT_EQ(once.positions, again.positions);
  EXPECT_EQ(once.sample_counts, again.sample_counts);
  EXPECT_EQ(once.sample_values, again.sample_values);
  EXPECT_EQ(once.crossing_values, again.crossing_values);
  EXPECT_EQ(once.domain, again.domain);
}

TEST(AdaptiveSampling, WeighsRatiosInTheLogDomainAndSeesValuesFortyOrdersApart) {
  const Lattice lattice = build_lattice(elevation_frame(80, 180, {.isotropic = true}).value()).value();
  const auto spiky = [](const DirectionPair& pair, std::size_t) {
    const double turn = std::cos(pair.i.phi - pair.v.phi);
    return pair.i.theta > 1.3 && pair.v.theta > 1.3 && turn < -0.7 ? 1e12 : 1e-30;
  };
  const SlicedBrdf sliced = sample(lattice, options_for(lattice.crossings.size() + 10, DomainKind::kLog), spiky);
  const auto slice = std::find_if(lattice.slices.begin(), lattice.slices.end(), [](const Slice& s) {
    return s.kind == kDiagonal && s.boundary == Boundary::kMirrored;
  });
  EXPECT_GT(sliced.sample_counts[static_cast<std::size_t>(slice - lattice.slices.begin())], 3U);
}

TEST(AdaptiveSampling, RefusesFewerSamplesThanCrossings) {
  const auto result = sample_slices(small_lattice(), {"f"}, measure_of(colourful({}), 1), options_for(54));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUsage);
  EXPECT_THAT(result.error().message, testing::AllOf(testing::HasSubstr("54"), testing::HasSubstr("55")));
}

TEST(AdaptiveSampling, EndsWithTheErrorOfAMeasurementThatFails) {
  for (const int failing : {1, 2, 11}) {
    int calls = 0;
    const Measure measure = measure_of(colourful({}), 1);
    const auto result = sample_slices(
        small_lattice(), {"f"},
        [&](auto pairs, auto values) -> Status {
          if (++calls == failing) return Error{ErrorCode::kIo, "the lamp went out", {}};
          return measure(pairs, values);
        },
        options_for(400));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "the lamp went out");
    EXPECT_EQ(calls, failing);
  }
}

}  // namespace
}  // namespace sbrdf::internal
