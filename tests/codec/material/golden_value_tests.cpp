// Values of f_r that shall never change: tests/vectors/evaluate/NAME.csv belongs to
// tests/vectors/sbrdf/accept/NAME.sbrdf. The files are frozen. With SBRDF_RECORD_GOLDEN_VALUES in the environment,
// those that are missing are written by the long double evaluator; the other tests here judge what was written.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/vector_evaluator.h"
#include "codec/file/encoder.h"
#include "tests/support/literal_evaluator.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

/// Both frames, both domains, negatives and zeros, shares of grey, guides, mirrors, isotropic and not.
constexpr std::array kNames = {"elevation-crossings-only",
                               "elevation-isotropic-lossless",
                               "elevation-isotropic-odd-steps",
                               "elevation-linear",
                               "elevation-log-lossless",
                               "elevation-mirrors-zeros",
                               "grey-shares",
                               "grey-shares-guide",
                               "guide",
                               "guide-ratio",
                               "half-difference-isotropic-lossless",
                               "half-difference-linear",
                               "half-difference-log",
                               "half-difference-negatives"};

using Degrees = std::array<double, 4>;  // theta_i, phi_i, theta_v, phi_v

struct Row {
  Degrees degrees{};
  std::vector<double> values;
};

DirectionPair pair_of(const Degrees& d) {
  return {direction_from_degrees(d[0], d[1]), direction_from_degrees(d[2], d[3])};
}

std::filesystem::path vectors() { return std::filesystem::path(SBRDF_SOURCE_DIR) / "tests" / "vectors"; }

std::filesystem::path golden_file(const std::string& name) { return vectors() / "evaluate" / (name + ".csv"); }

DecodedSliced material(const std::string& name) {
  return decode_sliced(read_bytes(vectors() / "sbrdf" / "accept" / (name + ".sbrdf"))).value();
}

std::vector<Row> read_golden(const std::string& name) {
  std::ifstream file(golden_file(name));
  std::string line;
  if (!std::getline(file, line)) throw std::runtime_error("cannot read " + golden_file(name).string());
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::vector<double> numbers;
    for (std::string cell; std::getline(text, cell, ',');) numbers.push_back(std::stod(cell));
    Row row;
    std::copy_n(numbers.begin(), 4, row.degrees.begin());
    row.values.assign(numbers.begin() + 4, numbers.end());
    rows.push_back(std::move(row));
  }
  return rows;
}

double drawn(std::mt19937_64& random, double end) {
  return std::floor(static_cast<double>(random() % 1'000'000) / 1e6 * end * 100) / 100;
}

Degrees degrees_of(const DirectionPair& pair) {
  return {degrees_from_radians(pair.i.theta), degrees_from_radians(pair.i.phi), degrees_from_radians(pair.v.theta),
          degrees_from_radians(pair.v.phi)};
}

/// Anywhere; at poles, in the mirror direction and where the elevations are the same; on borders of cells and beside
/// them; beyond the frame, on the horizon and below it.
std::vector<Degrees> places(const Lattice& lattice) {
  std::mt19937_64 random(lattice.crossings.size());
  const auto anywhere = [&]() -> Degrees {
    return {drawn(random, 80), drawn(random, 360), drawn(random, 80), drawn(random, 360)};
  };
  std::vector<Degrees> all = {{0, 0, 0, 0},      {0, 77, 0, 13},  {80, 10, 80, 190}, {90, 0, 45, 120},
                              {90, 30, 90, 210}, {95, 0, 10, 50}, {20, 5, 90.5, 60}};
  for (int k = 0; k < 60; ++k) all.push_back(anywhere());
  for (int k = 0; k < 6; ++k) {
    const Degrees d = anywhere();
    all.insert(all.end(), {{0, d[1], d[2], d[3]},
                           {d[0], d[1], 0, d[3]},
                           {d[0], d[1], d[0], d[3]},
                           {d[0], d[1], d[0], d[1]},
                           {d[0], d[1], d[0], d[1] < 180 ? d[1] + 180 : d[1] - 180},
                           {d[0] / 8 + 80, d[1], d[2], d[3]}});
  }
  for (int k = 0; k < 60; ++k) {
    Coordinates x{};
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double>& nodes = lattice.nodes[axis];
      const double share = static_cast<double>(random() % 1000) / 1000;
      x[axis] = random() % 3 == 0 ? share * nodes.back() : nodes[random() % nodes.size()];
    }
    all.push_back(degrees_of(directions_at(lattice.spec, x)));
  }
  return all;
}

template <class Real>
std::vector<Real> evaluate(const BasicEvaluator<Real>& evaluator, const Degrees& degrees) {
  std::vector<Real> values(evaluator.channel_count());
  evaluator.evaluate(pair_of(degrees), values);
  return values;
}

std::string shortest(double v) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v).ptr};
}

void write_golden(const std::string& name) {
  const auto decoded = material(name);
  const BasicEvaluator<long double> exact(decoded.sliced, decoded.lattice);
  std::filesystem::create_directories(golden_file(name).parent_path());
  std::ofstream out(golden_file(name));
  out << "theta_i,phi_i,theta_v,phi_v";
  for (std::size_t c = 0; c < exact.channel_count(); ++c) out << ",f_r_" << c;
  out << '\n';
  for (const Degrees& degrees : places(decoded.lattice)) {
    out << shortest(degrees[0]);
    for (std::size_t k = 1; k < 4; ++k) out << ',' << shortest(degrees[k]);
    for (const long double v : evaluate(exact, degrees)) {
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), ",%.9Lg", v);
      out << text.data();
    }
    out << '\n';
  }
}

float largest_value(const SlicedBrdf& sliced) {
  float most = 0;
  for (const auto* values : {&sliced.crossing_values, &sliced.sample_values}) {
    for (const float v : *values) most = std::max(most, std::abs(v));
  }
  return most;
}

TEST(GoldenValues, AreWrittenOnlyWhereTheyAreMissing) {
  const bool records = std::getenv("SBRDF_RECORD_GOLDEN_VALUES") != nullptr;
  for (const std::string name : kNames) {
    if (records && !std::filesystem::exists(golden_file(name))) write_golden(name);
    EXPECT_GT(read_golden(name).size(), 150U) << name;
  }
}

TEST(GoldenValues, AreThoseOfTheEvaluator) {
  for (const std::string name : kNames) {
    const auto decoded = material(name);
    const Evaluator evaluator(decoded.sliced, decoded.lattice);
    const double most = largest_value(decoded.sliced);
    for (const Row& row : read_golden(name)) {
      const std::vector<float> values = evaluate(evaluator, row.degrees);
      ASSERT_EQ(values.size(), row.values.size()) << name;
      for (std::size_t c = 0; c < values.size(); ++c) {
        const double bound = std::max(2e-5 * std::abs(row.values[c]), 4e-7 * most);
        EXPECT_NEAR(values[c], row.values[c], bound) << name << testing::PrintToString(row.degrees);
      }
    }
  }
}

TEST(GoldenValues, AreThoseOfTheVectorEvaluator) {
  for (const std::string name : kNames) {
    const auto decoded = material(name);
    const VectorEvaluator evaluator(decoded.sliced, decoded.lattice);
    const double most = largest_value(decoded.sliced);
    for (const Row& row : read_golden(name)) {
      const DirectionPair pair = pair_of(row.degrees);
      if (!above_horizon(pair)) continue;
      std::vector<float> values(evaluator.channel_count());
      evaluator.evaluate_at(geometry(decoded.lattice.spec.id).coordinates(pair), values);
      for (std::size_t c = 0; c < values.size(); ++c) {
        const double bound = std::max(2e-5 * std::abs(row.values[c]), 4e-7 * most);
        EXPECT_NEAR(values[c], row.values[c], bound) << name << testing::PrintToString(row.degrees);
      }
    }
  }
}

// f_c = w_c - share_c g with g = sum w / (C + sum share).
void take_off(std::span<const float> shares, std::vector<long double>& w) {
  if (shares.empty()) return;
  const long double sum = std::accumulate(w.begin(), w.end(), 0.0L);
  const long double grey =
      sum / (static_cast<long double>(w.size()) + std::accumulate(shares.begin(), shares.end(), 0.0L));
  for (std::size_t c = 0; c < w.size(); ++c) w[c] -= shares[c] * grey;
}

TEST(GoldenValues, AreThoseOfALiteralReadingOfTheEquations) {
  for (const std::string name : kNames) {
    const auto decoded = material(name);
    LiteralEvaluator literal(decoded.sliced, decoded.lattice);
    const double most = largest_value(decoded.sliced);
    for (const Row& row : read_golden(name)) {
      const DirectionPair pair = pair_of(row.degrees);
      std::vector<long double> values(row.values.size(), 0);
      for (std::size_t c = 0; c < values.size() && above_horizon(pair); ++c) {
        values[c] = literal(plain_coordinates(pair, decoded.lattice.spec.id), c).value;
      }
      take_off(decoded.sliced.grey_shares.shares(), values);
      for (std::size_t c = 0; c < row.values.size(); ++c) {
        const long double expected = values[c];
        // Nine digits were written; both round places to double, in ways of their own.
        const double bound = 6e-9 * std::abs(row.values[c]) + 1e-9 * most;
        EXPECT_NEAR(static_cast<double>(expected), row.values[c], bound) << name << testing::PrintToString(row.degrees);
      }
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
