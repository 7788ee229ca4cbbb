#include "converters/bench/quality.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <random>
#include <string>

#include <fmt/format.h>

#include "codec/search/random_pairs.h"
#include "converters/difference/error_sums.h"
#include "converters/judge/compare.h"
#include "converters/source/reciprocity.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kDrawSeed = 1;
constexpr double kFloorShare = 0.01;  // of the mean |f|, as for held-back directions
constexpr std::array<std::size_t, 4> kBatchSizes = {1, 3, 16, 1000};

/// What a contender is judged against.
class Judge {
 public:
  Judge(const Contender& contender, const BrdfSource& source) : source_(source) {
    if (contender.is_reciprocal() && !source.traits().reciprocal) mean_.emplace(source);
  }
  [[nodiscard]] const BrdfSource& source() const { return mean_ ? static_cast<const BrdfSource&>(*mean_) : source_; }

 private:
  const BrdfSource& source_;
  std::optional<SymmetrisedSource> mean_;
};

DirectionPair pair_of(const VectorPairs& pairs, std::size_t k) {
  return {direction_from_vector(glm::dvec3(pairs.i[k])), direction_from_vector(glm::dvec3(pairs.v[k]))};
}

VectorPairs measured_pairs(const VectorPairs& pairs, const BrdfSource& source) {
  VectorPairs kept;
  const std::size_t count = std::min(pairs.size(), kVerifiedPairs);
  std::vector<DirectionPair> angles;
  for (std::size_t k = 0; k < count; ++k) angles.push_back(pair_of(pairs, k));
  std::vector<std::uint8_t> flags(count, 1);
  source.measured(angles, flags);
  for (std::size_t k = 0; k < count; ++k) {
    if (flags[k] == 0) continue;
    kept.i.push_back(pairs.i[k]);
    kept.v.push_back(pairs.v[k]);
  }
  return kept;
}

std::vector<float> in_batches(const Contender& contender, const VectorPairs& pairs, std::size_t size) {
  const std::size_t channels = contender.channel_count();
  std::vector<float> values(pairs.size() * channels);
  for (std::size_t first = 0; first < pairs.size(); first += size) {
    const std::size_t count = std::min(size, pairs.size() - first);
    contender.evaluate(std::span(pairs.i).subspan(first, count), std::span(pairs.v).subspan(first, count),
                       std::span(values).subspan(first * channels, count * channels));
  }
  return values;
}

/// Where, and what stands there beside what should.
std::string place_of(const VectorPairs& pairs, std::size_t value, const BrdfSource& source, float f, float r) {
  const std::size_t channels = source.channel_count();
  const ValuePlace place = {pair_of(pairs, value / channels), value % channels, f, r};
  return place_text(place, source.traits().channels);
}

Status check_bits(const Contender& contender, const VectorPairs& pairs, const std::vector<float>& values,
                  const BrdfSource& source) {
  for (const std::size_t size : kBatchSizes) {
    const std::vector<float> others = in_batches(contender, pairs, size);
    if (std::memcmp(others.data(), values.data(), values.size() * sizeof(float)) == 0) continue;
    std::size_t k = 0;
    while (std::bit_cast<std::uint32_t>(others[k]) == std::bit_cast<std::uint32_t>(values[k])) ++k;
    return difference_error(fmt::format("a batch of {} pairs gives other bits than a larger one: {}", size,
                                        place_of(pairs, k, source, values[k], others[k])));
  }
  return ok_status();
}

/// Median of the relative errors.
Status check_values(const VectorPairs& pairs, const std::vector<float>& values, const BrdfSource& source,
                    double wild_percent) {
  std::vector<float> expected(values.size());
  source.evaluate_vectors(pairs.i, pairs.v, expected);
  double sum = 0;
  for (const float f : expected) sum += std::abs(static_cast<double>(f));
  const double floor = kFloorShare * sum / static_cast<double>(expected.size());
  std::vector<std::pair<double, std::size_t>> errors;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double error = relative_error(expected[k], values[k], floor);
    if (error >= 0) errors.emplace_back(error, k);
  }
  if (errors.empty()) return ok_status();  // 0 everywhere: nothing can be wild
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  if (100 * middle->first <= wild_percent) return ok_status();
  const std::size_t k = middle->second;
  return difference_error(fmt::format("half of the values are off by more than {:.4g} %, such as {}",
                                      100 * middle->first, place_of(pairs, k, source, expected[k], values[k])));
}

}  // namespace

VectorPairs draw_vector_pairs(std::size_t count, double theta_max_deg) {
  std::mt19937_64 random(kDrawSeed);
  VectorPairs pairs;
  for (std::size_t k = 0; k < count; ++k) {
    const DirectionPair pair = draw_pair(random, theta_max_deg);
    pairs.i.emplace_back(vector_from_direction(pair.i));
    pairs.v.emplace_back(vector_from_direction(pair.v));
  }
  return pairs;
}

Status verify(const Contender& contender, const BrdfSource& source, const VectorPairs& pairs, double wild_percent) {
  if (contender.channel_count() != source.channel_count()) {
    return difference_error(
        fmt::format("has {} channels where the source has {}", contender.channel_count(), source.channel_count()));
  }
  const Judge judge(contender, source);
  const VectorPairs verified = measured_pairs(pairs, source);
  if (verified.size() == 0) return ok_status();
  const std::vector<float> values = in_batches(contender, verified, verified.size());
  const auto bad = std::find_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
  if (bad != values.end()) {
    std::vector<float> expected(values.size());
    judge.source().evaluate_vectors(verified.i, verified.v, expected);
    const auto k = static_cast<std::size_t>(bad - values.begin());
    return difference_error("a value is not finite: " + place_of(verified, k, source, expected[k], values[k]));
  }
  if (Status same = check_bits(contender, verified, values, source); !same) return same;
  return check_values(verified, values, judge.source(), wild_percent);
}

Result<Quality> measure_quality(const Contender& contender, const BrdfSource& source, const QualityOptions& options,
                                const Progress& progress) {
  const Judge judge(contender, source);
  const ContenderSource test(contender, source);
  CompareOptions grid;
  grid.theta_max_deg = options.theta_max_deg;
  grid.random_count = options.pairs;
  grid.false_values = FalseValueSearch::kNone;
  CompareOptions off_grid = grid;
  off_grid.directions = CompareDirections::kHighlight;
  StepwiseProgress steps(progress);
  const Result<Comparison> on = compare_sources(judge.source(), test, grid, steps.step(0.5));
  if (!on) return on.error();
  const Result<Comparison> off = compare_sources(judge.source(), test, off_grid, steps.step(1));
  if (!off) return off.error();
  return Quality{on->mre_percent, on->rel_l1_percent, off->mre_percent, off->rel_l1_percent};
}

}  // namespace sbrdf::internal
