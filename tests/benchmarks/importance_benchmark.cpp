// Importance sampling, material by material and for five directions of the light: whether directions are drawn as the
// density says (chi-square of a million), what the density integrates to, how much smaller the variance of
// f_r cos theta_v / pdf is than with directions drawn by the cosine, bytes and time. Prints Markdown.
//   importance_benchmark [--samples N] NAME ...      files, or kurt:NAME; with 0 samples only bytes and times
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "codec/search/random_pairs.h"
#include "converters/files/by_name.h"
#include "converters/source/vector_brdf.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/hemisphere_bins.h"

namespace {

using namespace sbrdf::internal;

constexpr std::array kThetas = {0.0, 30.0, 60.0, 75.0, 85.0};
constexpr double kPhi = 20;
std::size_t sample_count = 1'000'000;
std::uint64_t seed = 1;

struct Row {
  double chance = 0;    ///< of a larger chi-square
  double integral = 0;  ///< of the density
  double variance = 0;  ///< relative to the square of the mean
  double cosine_variance = 0;
  double largest = 0;  ///< of f_r cos / pdf, over the mean
};

double mean_of(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum / static_cast<double>(values.size());
}

Row measure(const ImportanceTable& table, const VectorBrdf& brdf, const glm::vec3& w_i) {
  const auto density = [&](const glm::dvec3& w) { return static_cast<double>(table.pdf(w_i, glm::vec3(w))); };
  const HemisphereBins bins(density, {-w_i.x, -w_i.y, w_i.z}, 1.0 / 256, 2e-6);
  std::vector<double> counts(bins.masses().size());
  std::mt19937_64 random(seed++);
  std::vector<float> values(brdf.channels);
  double sum = 0;
  double squares = 0;
  double cosine_squares = 0;
  double largest = 0;
  for (std::size_t k = 0; k < sample_count; ++k) {
    const double u = draw_uniform(random, 1);
    const DrawnDirection drawn = table.sample(w_i, {u, draw_uniform(random, 1)});
    ++counts[bins.find(glm::dvec3(drawn.w_v))];
    brdf.evaluate(std::span(&w_i, 1), std::span(&drawn.w_v, 1), values);
    const double f = mean_of(values);
    const auto cosine = static_cast<double>(drawn.w_v.z);
    const double weight = f * cosine / static_cast<double>(drawn.pdf);
    sum += weight;
    largest = std::max(largest, weight);
    squares += weight * weight;
    cosine_squares += f * weight * kPi;  // of (f pi)^2 with the density cos / pi
  }
  const auto count = static_cast<double>(sample_count);
  const double square = (sum / count) * (sum / count);
  return {chi_square_chance(bins.masses(), counts), bins.total(), squares / count / square - 1,
          cosine_squares / count / square - 1, largest / (sum / count)};
}

struct Times {
  double sample = 0;  ///< [ns]
  double pdf = 0;
  double evaluate = 0;
};

Times time(const ImportanceTable& table, const VectorBrdf& brdf) {
  constexpr std::size_t kCount = 20'000;
  std::vector<glm::vec3> w_i;
  std::vector<glm::dvec2> u;
  std::mt19937_64 random(2);
  for (std::size_t k = 0; k < kCount; ++k) {
    const double x = draw_uniform(random, 1);
    w_i.emplace_back(vector_from_direction(draw_pair(random, 85).i));
    u.emplace_back(x, draw_uniform(random, 1));
  }
  std::vector<glm::vec3> w_v(kCount);
  std::vector<float> pdf(kCount);
  std::vector<float> values(brdf.channels);
  const auto ns = [](double seconds) { return 1e9 * seconds / kCount; };
  Times times;
  times.sample = ns(median_seconds([&] {
    for (std::size_t k = 0; k < kCount; ++k) w_v[k] = table.sample(w_i[k], u[k]).w_v;
  }));
  times.pdf = ns(median_seconds([&] {
    for (std::size_t k = 0; k < kCount; ++k) pdf[k] = table.pdf(w_i[k], w_v[k]);
  }));
  times.evaluate = ns(median_seconds([&] {
    for (std::size_t k = 0; k < kCount; ++k) {
      brdf.evaluate(std::span(&w_i[k], 1), std::span(&w_v[k], 1), values);
      pdf[k] = values[0];
    }
  }));
  return times;
}

struct Measured {
  std::string name;
  std::vector<Row> rows;
  double build_ms = 0;
  std::size_t bytes = 0;
  Times times;
};

std::string short_name(const std::string& name) {
  std::string last = name.substr(name.find_last_of("/:") + 1);
  if (const std::string end = "_rgb.bsdf"; last.ends_with(end)) last.resize(last.size() - end.size());
  return last;
}

template <class Column>
void print(const char* title, const std::vector<Measured>& all, const char* format, const Column& column) {
  std::printf("\n%s\n\n| material |", title);
  for (const double theta : kThetas) std::printf(" %.0f |", theta);
  std::printf("\n|---|---|---|---|---|---|\n");
  for (const Measured& one : all) {
    std::printf("| %s |", one.name.c_str());
    for (const Row& row : one.rows) {
      std::printf(" ");
      std::printf(format, column(row));
      std::printf(" |");
    }
    std::printf("\n");
  }
}

void print_distributions(const std::vector<Measured>& all) {
  print("Variance, over that of directions by the cosine:", all, "%.2g",
        [](const Row& row) { return row.variance / row.cosine_variance; });
  print("Variance over the square of the mean:", all, "%.2g", [](const Row& row) { return row.variance; });
  print("The same of directions by the cosine:", all, "%.2g", [](const Row& row) { return row.cosine_variance; });
  print("Largest of all over the mean:", all, "%.2g", [](const Row& row) { return row.largest; });
  print("Chi-square, the chance of a larger one:", all, "%.3f", [](const Row& row) { return row.chance; });
  print("Integral of the density, less 1:", all, "%.1e", [](const Row& row) { return row.integral - 1; });
}

void print_costs(const std::vector<Measured>& all) {
  std::printf("\n| material | bytes | made in, ms | evaluation, ns | sample / evaluation | pdf / evaluation |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const Measured& one : all) {
    const Times& times = one.times;
    std::printf("| %s | %zu | %.0f | %.0f | %.2f | %.2f |\n", one.name.c_str(), one.bytes, one.build_ms, times.evaluate,
                times.sample / times.evaluate, times.pdf / times.evaluate);
  }
}

Measured measure(const BrdfSource& source, const std::string& name) {
  const VectorBrdf brdf = vector_brdf_of(source);
  const double start = processor_seconds();
  const ImportanceTable table = make_importance_table(brdf);
  Measured one = {short_name(name), {}, 1000 * (processor_seconds() - start), table.bytes(), {}};
  for (const double theta : kThetas) {
    if (sample_count == 0) break;
    one.rows.push_back(measure(table, brdf, glm::vec3(vector_from_direction(direction_from_degrees(theta, kPhi)))));
  }
  one.times = time(table, brdf);
  return one;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Measured> all;
  int first = 1;
  if (argc > 2 && std::string(argv[1]) == "--samples") {
    sample_count = std::strtoull(argv[2], nullptr, 10);
    first = 3;
  }
  for (int k = first; k < argc; ++k) {
    const auto opened = open_source(std::string(argv[k]));
    if (!opened) {
      std::fprintf(stderr, "%s: %s\n", argv[k], opened.error().message.c_str());
      return 1;
    }
    all.push_back(measure(*opened->source, argv[k]));
  }
  if (sample_count > 0) print_distributions(all);
  print_costs(all);
  return 0;
}
