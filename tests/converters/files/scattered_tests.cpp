#include "converters/files/scattered/scattered_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "converters/files/analytic/analytic_file.h"
#include "converters/files/format_table.h"
#include "converters/files/scattered/nearest_points.h"
#include "tests/support/dense_files.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::shared_ptr<const ByteSource> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return std::make_shared<OwnedMemorySource>(std::vector<std::byte>(bytes.begin(), bytes.end()));
}

Result<std::unique_ptr<BrdfSource>> open(const std::string& text, const Options& options = {}) {
  return open_source(bytes_of(text), options);
}

std::string found(const BrdfSource& source) {
  std::string all;
  for (const Finding& finding : source.traits().findings) {
    all += fmt::format("{} of {} {}\n", finding.count, finding.total, finding.what);
  }
  return all;
}

double value_at(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v,
                std::size_t c = 0) {
  const DirectionPair pair = {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
  std::vector<float> values(source.channel_count());
  source.evaluate(std::span(&pair, 1), values);
  return values[c];
}

bool is_measured(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v) {
  const DirectionPair pair = {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
  std::uint8_t flag = 0;
  source.measured(std::span(&pair, 1), std::span(&flag, 1));
  return flag != 0;
}

/// Directions anywhere up to 80 degrees.
std::vector<DirectionPair> random_pairs(std::size_t count, bool isotropic, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(std::cos(80 * kPi / 180), 1);
  std::uniform_real_distribution<double> turn(0, 2 * kPi);
  std::vector<DirectionPair> pairs(count);
  for (auto& [i, v] : pairs) {
    i = {std::acos(height(random)), isotropic ? 0 : turn(random)};
    v = {std::acos(height(random)), turn(random)};
  }
  return pairs;
}

/// A sample file of a source, with the angles in degrees.
std::string text_of(const BrdfSource& source, const std::vector<DirectionPair>& pairs) {
  std::vector<float> values(pairs.size() * source.channel_count());
  source.evaluate(pairs, values);
  std::string text = "# theta_i phi_i theta_v phi_v R G B\n";
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [i, v] = pairs[k];
    text += fmt::format("{} {} {} {} {} {} {}\n", degrees_from_radians(i.theta), degrees_from_radians(i.phi),
                        degrees_from_radians(v.theta), degrees_from_radians(v.phi), values[3 * k], values[3 * k + 1],
                        values[3 * k + 2]);
  }
  return text;
}

double rel_l1(const std::vector<float>& reference, const std::vector<float>& test) {
  double difference = 0;
  double sum = 0;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    difference += std::abs(reference[k] - test[k]);
    sum += std::abs(reference[k]);
  }
  return difference / sum;
}

/// The value of the sample whose directions are nearest: what one would do without thinking.
std::vector<float> nearest_values(const BrdfSource& source, const std::vector<DirectionPair>& samples,
                                  const std::vector<DirectionPair>& wanted) {
  std::vector<DirectionPair> nearest(wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    double best = 1e9;
    for (const DirectionPair& sample : samples) {
      const auto i = vector_from_direction(wanted[k].i) - vector_from_direction(sample.i);
      const auto v = vector_from_direction(wanted[k].v) - vector_from_direction(sample.v);
      const double square = i.x * i.x + i.y * i.y + i.z * i.z + v.x * v.x + v.y * v.y + v.z * v.z;
      if (square >= best) continue;
      best = square;
      nearest[k] = sample;
    }
  }
  std::vector<float> values(wanted.size() * source.channel_count());
  source.evaluate(nearest, values);
  return values;
}

TEST(ScatteredFit, IsFarBetterThanTheNearestSampleForIsotropicMaterials) {
  const auto source = open_named("kurt:wood01").value();
  const auto samples = random_pairs(1500, true, 1);
  const auto wanted = random_pairs(1000, true, 2);
  const auto fitted = open(text_of(*source, samples));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  EXPECT_TRUE((*fitted)->traits().isotropic);
  std::vector<float> reference(3000);
  std::vector<float> values(3000);
  source->evaluate(wanted, reference);
  (*fitted)->evaluate(wanted, values);
  const double error = rel_l1(reference, values);
  EXPECT_LT(error, 0.02);
  EXPECT_LT(error, rel_l1(reference, nearest_values(*source, samples, wanted)) / 3);
}

TEST(ScatteredFit, IsBetterThanTheNearestSampleForAnisotropicMaterials) {
  const auto source = open_named("kurt:fabric112").value();
  const auto samples = random_pairs(3000, false, 1);
  const auto wanted = random_pairs(500, false, 2);
  const auto fitted = open(text_of(*source, samples));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  EXPECT_FALSE((*fitted)->traits().isotropic);
  std::vector<float> reference(1500);
  std::vector<float> values(1500);
  source->evaluate(wanted, reference);
  (*fitted)->evaluate(wanted, values);
  const double error = rel_l1(reference, values);
  EXPECT_LT(error, rel_l1(reference, nearest_values(*source, samples, wanted)) * 0.6);
}

TEST(ScatteredFit, GivesBackTheSamplesOfAGoniometer) {
  const auto source = open_named("kurt:fabric112").value();
  std::vector<DirectionPair> pairs;
  for (int theta_i = 0; theta_i <= 75; theta_i += 15) {
    for (const int phi_i : {0, 90}) {
      for (int theta_v = 0; theta_v <= 80; theta_v += 20) {
        for (int phi_v = 0; phi_v < 360; phi_v += theta_v == 0 ? 360 : 20) {
          pairs.push_back({direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)});
        }
      }
    }
  }
  const auto fitted = open(text_of(*source, pairs));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  std::vector<float> reference(pairs.size() * 3);
  std::vector<float> values(pairs.size() * 3);
  source->evaluate(pairs, reference);
  (*fitted)->evaluate(pairs, values);
  EXPECT_LT(rel_l1(reference, values), 1e-4);
  EXPECT_THAT(found(**fitted), HasSubstr("predicted from others with another light direction"));
}

TEST(ScatteredFit, IsTheSameForAnyOrderOfTheSamples) {
  const auto source = open_named("kurt:wood01").value();
  auto pairs = random_pairs(200, true, 5);
  const Options options = Options().set("grid", "difference/0:15:15:30");
  const auto one = open(text_of(*source, pairs), options);
  std::reverse(pairs.begin(), pairs.end());
  const auto other = open(text_of(*source, pairs), options);
  const auto a = dense_files::values_of(**one);
  const auto b = dense_files::values_of(**other);
  EXPECT_TRUE(dense_files::same(a, b));
}

TEST(ScatteredFit, OfAConstantIsTheConstant) {
  for (const char* value : {"0.5", "-0.25", "0"}) {
    std::string text;
    for (int k = 0; k < 40; ++k) text += fmt::format("{} 0 {} {} 0.5 {}\n", k, 2 * k % 70, 9 * k, value);
    const auto fitted = open(text, Options().set("scattered-radius", "180"));
    ASSERT_TRUE(fitted.ok()) << fitted.error().message;
    EXPECT_NEAR(value_at(**fitted, 20, 0, 30, 90), 0.5, 1e-6);
    EXPECT_NEAR(value_at(**fitted, 10, 0, 20, 90, 1), std::stod(value), 1e-6);
  }
}

TEST(ScatteredFit, FollowsAnExponentialOfTheSquareOfTheHalfVector) {
  // log f_r is a polynomial of the terms that are fitted, so that it comes back wherever samples surround a pair.
  const auto pairs = random_pairs(600, true, 9);
  const auto lobe = [](const DirectionPair& pair) {
    const HalfDifference at = half_difference_from_pair(pair);
    return std::exp(-6 * at.theta_h * at.theta_h + 0.3 * at.theta_d);
  };
  std::string text;
  for (const auto& [i, v] : pairs) {
    text += fmt::format("{} 0 {} {} {}\n", degrees_from_radians(i.theta), degrees_from_radians(v.theta),
                        degrees_from_radians(v.phi), lobe({i, v}));
  }
  const auto fitted = open(text, Options().set("grid", "difference/0:0,20,40:0,25,50:30"));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  for (const double phi : {60.0, 180.0, 300.0}) {
    const double expected = lobe({direction_from_degrees(20, 0), direction_from_degrees(25, phi)});
    EXPECT_NEAR(value_at(**fitted, 20, 0, 25, phi), expected, 0.01 * expected) << phi;
  }
}

TEST(ScatteredFit, LeavesHolesWhereNoSampleIsNear) {
  std::string text;
  for (int k = 0; k < 10; ++k) text += fmt::format("30 0 {} 180 0.5\n", 20 + 2 * k);
  const auto fitted = open(text, Options().set("grid", "difference/0:10:10:20").set("scattered-radius", "8"));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  EXPECT_TRUE(is_measured(**fitted, 30, 0, 30, 180));
  EXPECT_FALSE(is_measured(**fitted, 30, 0, 30, 0));
  EXPECT_FALSE(is_measured(**fitted, 70, 0, 30, 180));
  EXPECT_THAT(found(**fitted), HasSubstr("with a sample within 8 degrees"));
}

TEST(ScatteredGrid, IsThatOfTheSamplesWhereTheirAnglesAreFew) {
  std::string text;
  for (const int i : {0, 20, 40}) {
    for (const int v : {0, 10, 25}) {
      for (const int phi : {0, 30, 60, 90, 120, 150, 180}) text += fmt::format("{} 77 {} {} 0.5\n", i, v, 77 + phi);
    }
  }
  const auto fitted = open(text);
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  const Grid& grid = (*fitted)->table()->grid;
  EXPECT_TRUE(grid.is_isotropic());
  EXPECT_THAT(grid.axes[1].nodes_deg(), ElementsAre(0, 20, 40));
  EXPECT_THAT(grid.axes[2].nodes_deg(), ElementsAre(0, 10, 25));
  EXPECT_THAT(grid.axes[3].nodes_deg(), ElementsAre(0, 30, 60, 90, 120, 150, 180));
  EXPECT_EQ(grid.axes[3].ends(), Ends::kMirrored);
  EXPECT_THAT(found(**fitted), HasSubstr("phi_i is 77 throughout: taken as isotropic; phi_v - phi_i is 0 to 180"));
}

TEST(ScatteredGrid, KeepsAnglesThatAreNoWholeDegrees) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    for (int v = 0; v < 5; ++v) {
      for (int phi = 0; phi < 48; ++phi) {
        text += fmt::format("{} {} {} {} 0.5\n", 7.1 * i, 7.5 * phi, 2.3 * v, 7.5 * (47 - phi));
      }
    }
  }
  const auto fitted = open(text);
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  const Grid& grid = (*fitted)->table()->grid;
  EXPECT_THAT(grid.axes[0].nodes_deg(), ElementsAre(0, 7.1, 14.2));
  EXPECT_EQ(grid.axes[1], parse_grid("utia")->axes[1]);
  EXPECT_EQ(grid.axes[3], parse_grid("utia")->axes[1]);
}

TEST(ScatteredGrid, HasNodesInGapsThatAreTooWideToInterpolateOver) {
  std::string text;
  for (const int phi : {0, 180}) {
    for (int v = 0; v < 80; v += 10) text += fmt::format("45 0 {} {} 0.5\n", v, phi);
  }
  const auto fitted = open(text, Options().set("scattered-radius", "5"));
  ASSERT_TRUE(fitted.ok()) << fitted.error().message;
  EXPECT_EQ((*fitted)->table()->grid.axes[1].nodes_deg().size(), 6U);   // 0, 9, ... 45
  EXPECT_EQ((*fitted)->table()->grid.axes[3].nodes_deg().size(), 19U);  // 0, 10, ... 180
  EXPECT_TRUE(is_measured(**fitted, 45, 0, 30, 180));
  EXPECT_FALSE(is_measured(**fitted, 45, 0, 50, 90));
  EXPECT_FALSE(is_measured(**fitted, 0, 0, 50, 180));
}

std::string rows(const std::string& head, const std::function<std::string(int)>& row) {
  std::string text = head;
  for (int k = 0; k < 12; ++k) text += row(k) + "\n";
  return text;
}

TEST(ScatteredColumns, AreThoseOfTheirNames) {
  const auto row = [](int k) { return fmt::format("{},0.5,{},{},{}", 90 * k % 360, 5 * k, 6 * k, 0.25); };
  for (const char* head :
       {"phi_v,550 nm,theta_i,theta_v,red\n", "# Phi_r [deg], 550 nm, Theta_i [deg], Theta_r [deg], red\n",
        "phi_out_deg,550 nm,theta_in_deg,theta_out_deg,red\n"}) {
    const auto source = open(rows(head, row));
    ASSERT_TRUE(source.ok()) << head << source.error().message;
    EXPECT_THAT((*source)->traits().channels, ElementsAre("550 nm", "red"));
    EXPECT_NEAR(value_at(**source, 20, 0, 24, 0), 0.5, 1e-6);
  }
  const auto told = open(rows("a,b,c,d,e\n", row), Options().set("scattered-columns", "phi_v,G,theta_i,theta_v,skip"));
  ASSERT_TRUE(told.ok()) << told.error().message;
  EXPECT_THAT((*told)->traits().channels, ElementsAre("G"));
  const auto wrong = open(rows("", row), Options().set("scattered-columns", "phi_v,G,theta_i,theta_v"));
  EXPECT_THAT(wrong.error().message, HasSubstr("4 names for 5 columns"));
  const auto some = open(rows("phi_v,a,theta_i,b,c\n", row));
  EXPECT_EQ(some.error().code, ErrorCode::kUsage);
  EXPECT_THAT(some.error().message, HasSubstr("theta_v stands not among the columns"));
}

TEST(ScatteredColumns, InOrderAreAnglesAndChannels) {
  const auto source = open(rows("", [](int k) { return fmt::format("{} 0 {} {} 1 2 3 4", 5 * k, 6 * k, 30 * k); }));
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_THAT((*source)->traits().channels, ElementsAre("channel 1", "channel 2", "channel 3", "channel 4"));
  EXPECT_NEAR(value_at(**source, 10, 0, 12, 60, 3), 4, 1e-6);
}

TEST(ScatteredAngles, InRadiansAreSaidOrAskedFor) {
  const auto row = [](int k) { return fmt::format("{} 0 {} {} 0.5", 0.1 * k, 0.12 * k, 0.5 * k); };
  const auto unsaid = open(rows("", row));
  EXPECT_EQ(unsaid.error().code, ErrorCode::kUsage);
  EXPECT_THAT(unsaid.error().message, HasSubstr("--scattered-angles"));
  for (const auto& source : {open(rows("", row), Options().set("scattered-angles", "radians")).value().get(),
                             open(rows("theta_i_rad phi_i_rad theta_v_rad phi_v_rad Y\n", row)).value().get()}) {
    EXPECT_NE(source, nullptr);
  }
  const auto radians = open(rows("", row), Options().set("scattered-angles", "radians")).value();
  EXPECT_THAT(found(*radians), HasSubstr("angles in radians"));
  EXPECT_TRUE(open(rows("", row), Options().set("scattered-angles", "degrees")).ok());
  const auto wild = open("10 0 200 0 1\n");
  EXPECT_EQ(wild.error().code, ErrorCode::kInvalidFile);
  EXPECT_THAT(wild.error().message, HasSubstr("line 1: theta_v 200"));
}

TEST(ScatteredQuantity, WithACosineIsDividedByIt) {
  const auto row = [](int k) { return fmt::format("{} 0 {} 90 {}", 5 * k, 6 * k, 0.5 * std::cos(6 * k * kPi / 180)); };
  const auto source = open(rows("", row) + "10 0 90 0 0\n", Options().set("scattered-quantity", "f_r-cos"));
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_NEAR(value_at(**source, 40, 0, 48, 90), 0.5, 1e-6);
  EXPECT_THAT(found(**source), HasSubstr("1 of 13 samples at theta_v = 90 degrees"));
}

TEST(ScatteredSamples, ThatAreLeftOutOrMergedAreCounted) {
  const auto source = open(
      "10 0 20 0 0.4\n10 0 20 0 0.6\n10 360 20 360 0.5\n10 0 -20 180 0.5\n10 0 95 0 7\n120 0 0 0 7\n10 0 30 0 0.5\n");
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_THAT(found(**source), HasSubstr("5 of 7 samples, angles in degrees, f_r\n"));
  EXPECT_THAT(found(**source), HasSubstr("2 of 7 samples below the horizon"));
  EXPECT_THAT(found(**source), HasSubstr("1 of 7 samples with a theta below 0"));
  EXPECT_THAT(found(**source),
              HasSubstr("3 of 5 samples that repeat the directions of others in an isotropic material"));
  EXPECT_THAT(found(**source), HasSubstr("differ by a relative L1 of 10 %"));
  EXPECT_NEAR(value_at(**source, 10, 0, 20, 0), 0.5, 1e-6);
  EXPECT_THAT(open("10 0 95 0 7\n").error().message, HasSubstr("no sample lies above the horizon"));
}

TEST(ScatteredSamples, ThatAreNoNumbersAreRefusedByLineAndColumn) {
  EXPECT_EQ(open("1 2 3 4 5\n1 2 3 4 nan\n").error().message, "line 2: column 5 is 'nan', not finite");
  EXPECT_EQ(open("1 2 3 4 5\n\n1 2 3 x 5\n").error().message, "line 3: column 4 is 'x', no number");
  EXPECT_EQ(open("1 2 3 4 5\n1 2 3 4\n").error().message, "line 2: 4 fields instead of 5");
  EXPECT_THAT(open("1 2 3 4 1e300\n").error().message, HasSubstr("line 1: column 5 is above"));
  EXPECT_THAT(open("1 2 3 4 -5\n").error().message, HasSubstr("positive"));
}

TEST(ScatteredSamples, OfEachTruncationGiveATableOrAnError) {
  const std::string text = "# c\ntheta_i,phi_i,theta_v,phi_v,Y\n10,0,20,30,0.5\n20,0,30,60,0.25\n";
  const Options options = Options().set("grid", "difference/0:45:45:90");
  for (std::size_t size = 1; size <= text.size(); ++size) static_cast<void>(open(text.substr(0, size), options));
  EXPECT_TRUE(open(text, options).ok());
}

TEST(ScatteredGrid, IsNoLargerThanMemoryMayBe) {
  const auto large = open("10 0 20 30 0.5\n", Options().set("grid", "0.5:0.5:0.5:0.5"));
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().code, ErrorCode::kUnsupported);
}

TEST(Scattered, RefusesSamplesOfWhichNoneIsPositive) {
  for (const char* value : {"-0.5", "0", "-0.0"}) {
    std::string text;
    for (int k = 0; k < 20; ++k) text += fmt::format("{} 0 {} 90 {}\n", 10 + k, 80 - k, value);
    const auto none = open(text);
    ASSERT_FALSE(none.ok()) << value;
    EXPECT_EQ(none.error().code, ErrorCode::kInvalidFile);
    EXPECT_THAT(none.error().message, HasSubstr("none of 20 samples has a positive value"));
    EXPECT_TRUE(open(text + "5 0 5 0 0.25\n").ok()) << value;
  }
}

TEST(Scattered, SaysThatSamplesAreFew) {
  std::string text = "10 0 20 30 0.5\n";
  EXPECT_THAT(found(*open(text).value()), HasSubstr("1 of 1 samples at different directions, fewer than the 8"));
  for (int k = 1; k < 7; ++k) text += fmt::format("{} 0 20 30 0.5\n", 10 + k);
  EXPECT_THAT(found(*open(text).value()), HasSubstr("7 of 7 samples at different directions, fewer than the 8"));
  EXPECT_THAT(found(*open(text + "10 0 20 30 0.5\n").value()), HasSubstr("fewer than the 8"));  // one of them again
  EXPECT_THAT(found(*open(text + "50 0 20 30 0.5\n").value()), testing::Not(HasSubstr("fewer than")));
}

TEST(NearestPoints, FindsWhatLookingAtAllFinds) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coarse(0, 9);
  std::vector<SamplePlace> points(500);
  for (SamplePlace& point : points) {
    for (double& coordinate : point) coordinate = coarse(random);
  }
  std::vector<std::uint32_t> groups(points.size());
  for (std::size_t k = 0; k < groups.size(); ++k) groups[k] = static_cast<std::uint32_t>(k % 7);
  const NearestPoints tree(points);
  for (int turn = 0; turn < 50; ++turn) {
    const SamplePlace place = {coarse(random) + 0.5, coarse(random) * 1.0, coarse(random) + 0.25, coarse(random) * 1.0};
    std::vector<Neighbour> all;
    for (std::uint32_t k = 0; k < points.size(); ++k) {
      double square = 0;
      for (std::size_t axis = 0; axis < 4; ++axis) square += std::pow(points[k][axis] - place[axis], 2);
      if (groups[k] != 3) all.push_back({square, k});
    }
    std::sort(all.begin(), all.end());
    std::vector<Neighbour> nearest;
    tree.find(place, 12, nearest, groups, 3);
    ASSERT_EQ(nearest.size(), 12U);
    for (std::size_t k = 0; k < nearest.size(); ++k) EXPECT_EQ(nearest[k].point, all[k].point);
  }
}

}  // namespace
}  // namespace sbrdf::internal
