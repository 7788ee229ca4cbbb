#include "converters/files/scattered/local_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMostTerms = 15;
/// Places closer than this are one [radians].
constexpr double kSame = 1e-7;
/// Weights stop to grow at this share of the distance to the farthest neighbour.
constexpr double kCore = 0.02;
/// Keeps slopes small along which the neighbours say nothing; against the sum of all weights.
constexpr double kRidge = 1e-3;
/// How far beyond the values of the neighbours a result may lie, against their range.
constexpr double kOvershoot = 0.25;
constexpr std::array kScales = {1.0, 0.5, 0.25, 0.125};
/// Few terms, and all of the second degree.
struct Shape {
  bool curved;
  std::size_t neighbours;
};
constexpr std::array kShapes = {Shape{false, 8}, Shape{false, 16}, Shape{true, 20}, Shape{true, 32}, Shape{true, 48}};
/// Samples that are predicted to choose settings, and to say how good they are.
constexpr std::size_t kTried = 400;
constexpr std::size_t kJudged = 2000;
/// A goniometer measures more views than this for a light.
constexpr std::size_t kViewsOfLight = 4;

using Terms = std::array<double, kMostTerms>;
using Matrix = std::array<Terms, kMostTerms>;

// Solves matrix x = (1, 0, 0, ...), of which the matrix is symmetric and positive.
Terms solve_first(Matrix matrix, std::size_t size) {
  for (std::size_t k = 0; k < size; ++k) {  // Cholesky: matrix = L L^T, L in the lower half
    for (std::size_t j = 0; j < k; ++j) matrix[k][k] -= matrix[k][j] * matrix[k][j];
    matrix[k][k] = std::sqrt(std::max(matrix[k][k], 1e-300));
    for (std::size_t i = k + 1; i < size; ++i) {
      for (std::size_t j = 0; j < k; ++j) matrix[i][k] -= matrix[i][j] * matrix[k][j];
      matrix[i][k] /= matrix[k][k];
    }
  }
  Terms x{};
  x[0] = 1;
  for (std::size_t k = 0; k < size; ++k) {
    for (std::size_t j = 0; j < k; ++j) x[k] -= matrix[k][j] * x[j];
    x[k] /= matrix[k][k];
  }
  for (std::size_t k = size; k-- > 0;) {
    for (std::size_t j = k + 1; j < size; ++j) x[k] -= matrix[j][k] * x[j];
    x[k] /= matrix[k][k];
  }
  return x;
}

std::size_t term_count(std::size_t axes, bool curved) { return curved ? 1 + axes + axes * (axes + 1) / 2 : axes + 2; }

void list_terms(const SamplePlace& offset, std::size_t axes, bool curved, Terms& terms) {
  terms[0] = 1;
  std::copy_n(offset.begin(), axes, terms.begin() + 1);
  if (!curved) {
    terms[axes + 1] = offset[0] * offset[0] + offset[1] * offset[1];
    return;
  }
  std::size_t at = axes + 1;
  for (std::size_t i = 0; i < axes; ++i) {
    for (std::size_t j = 0; j <= i; ++j) terms[at++] = offset[i] * offset[j];
  }
}

/// What share each neighbour has in the value at a place. They add up to 1.
void shares_at(const NearestPoints& tree, const SamplePlace& place, std::span<const Neighbour> found, std::size_t axes,
               bool curved, std::span<double> shares) {
  const std::size_t size = term_count(axes, curved);
  const double radius = std::sqrt(found.back().square) * 1.01;
  std::vector<Terms> terms(found.size());
  Matrix matrix{};
  double sum = 0;
  for (std::size_t n = 0; n < found.size(); ++n) {
    const SamplePlace& at = tree.point(found[n].point);
    Terms& term = terms[n];
    SamplePlace offset{};
    for (std::size_t axis = 0; axis < axes; ++axis) offset[axis] = (at[axis] - place[axis]) / radius;
    list_terms(offset, axes, curved, term);
    const double square = found[n].square / (radius * radius);
    shares[n] = (1 - square) * (1 - square) / (square + kCore * kCore);
    sum += shares[n];
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j <= i; ++j) matrix[i][j] += shares[n] * term[i] * term[j];
    }
  }
  for (std::size_t i = 1; i < size; ++i) matrix[i][i] += kRidge * sum;
  const Terms solution = solve_first(matrix, size);
  for (std::size_t n = 0; n < found.size(); ++n) {
    shares[n] *= std::inner_product(terms[n].begin(), terms[n].begin() + static_cast<std::ptrdiff_t>(size),
                                    solution.begin(), 0.0);
  }
}

std::size_t stride_of(std::size_t count, std::size_t most) { return (count + most - 1) / most; }

}  // namespace

LocalFit::LocalFit(const Samples& samples, bool isotropic)
    : isotropic_(isotropic), channels_(samples.channels.size()), near_({}), plain_({}) {
  merge(samples);
  group(samples);
  plain_ = NearestPoints(points_);
  choose_settings();
}

SamplePlace LocalFit::place_of(const DirectionPair& pair) const {
  const HalfDifference at = half_difference_from_pair(pair);
  if (isotropic_) return {at.theta_h * std::cos(at.phi_d), at.theta_h * std::sin(at.phi_d), at.theta_d, 0};
  const double psi = at.phi_d + at.phi_h;
  return {at.theta_h * std::cos(at.phi_h), at.theta_h * std::sin(at.phi_h), at.theta_d * std::cos(psi),
          at.theta_d * std::sin(psi)};
}

void LocalFit::merge(const Samples& samples) {
  using Key = std::array<std::int64_t, 4>;
  const std::size_t count = samples.pairs.size();
  std::vector<SamplePlace> places(count);
  std::vector<std::pair<Key, std::uint32_t>> keys(count);
  for (std::size_t k = 0; k < count; ++k) {
    places[k] = place_of(samples.pairs[k]);
    for (std::size_t axis = 0; axis < 4; ++axis) keys[k].first[axis] = std::llround(places[k][axis] / kSame);
    keys[k].second = static_cast<std::uint32_t>(k);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<double> sums(channels_);
  double difference = 0;
  double reference = 0;
  for (std::size_t first = 0; first < count;) {
    std::size_t end = first;
    std::fill(sums.begin(), sums.end(), 0.0);
    for (; end < count && keys[end].first == keys[first].first; ++end) {
      for (std::size_t c = 0; c < channels_; ++c) sums[c] += samples.values[keys[end].second * channels_ + c];
    }
    points_.push_back(places[keys[first].second]);
    first_rows_.push_back(keys[first].second);
    for (const double sum : sums) values_.push_back(sum / static_cast<double>(end - first));
    for (std::size_t k = first; k < end && end - first > 1; ++k) {
      for (std::size_t c = 0; c < channels_; ++c) {
        const double mean = sums[c] / static_cast<double>(end - first);
        difference += std::abs(samples.values[keys[k].second * channels_ + c] - mean);
        reference += std::abs(mean);
      }
    }
    repeated_ += end - first - 1;
    first = end;
  }
  if (reference > 0) repeated_percent_ = 100 * difference / reference;
}

void LocalFit::group(const Samples& samples) {
  using Key = std::array<std::int64_t, 2>;
  std::vector<Key> lights(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Direction& i = samples.pairs[first_rows_[k]].i;
    const bool turned = isotropic_ || i.theta == 0;
    lights[k] = {std::llround(i.theta / kSame), turned ? 0 : std::llround(i.phi / kSame)};
  }
  std::vector<Key> distinct = lights;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  held_back_.by_light = distinct.size() > 1 && distinct.size() * kViewsOfLight <= points_.size();
  groups_.resize(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto own = std::lower_bound(distinct.begin(), distinct.end(), lights[k]) - distinct.begin();
    groups_[k] = static_cast<std::uint32_t>(held_back_.by_light ? own : static_cast<std::ptrdiff_t>(k));
  }
}

std::vector<SamplePlace> LocalFit::scaled_points(double scale) const {
  std::vector<SamplePlace> scaled = points_;
  for (SamplePlace& place : scaled) {
    place[2] *= scale;
    place[3] *= scale;
  }
  return scaled;
}

void LocalFit::choose_settings() {
  std::optional<double> best;
  for (const double scale : kScales) {
    NearestPoints tree(scaled_points(scale));
    for (const Shape& shape : kShapes) {
      const Settings settings = {scale, shape.neighbours, shape.curved};
      const double found = score(tree, settings, kTried);
      if (best && found >= *best) continue;
      best = found;
      settings_ = settings;
    }
  }
  near_ = NearestPoints(scaled_points(settings_.difference_scale));
  static_cast<void>(score(near_, settings_, kJudged));  // for what it notes in held_back_
}

// The mean of |f - r| / (|f| + |r|), in which neither highlights nor faint values outweigh the rest.
double LocalFit::score(const NearestPoints& tree, const Settings& settings, std::size_t most) {
  if (points_.size() < 2) return 0;
  const std::size_t stride = stride_of(points_.size(), most);
  const std::size_t count = (points_.size() + stride - 1) / stride;
  struct Sums {
    double relative = 0, difference = 0, reference = 0, distance = 0;
  };
  std::vector<Sums> parts(count);
  parallel_for(count, [&](std::uint64_t k) {
    const auto own = static_cast<std::uint32_t>(k * stride);
    std::vector<Neighbour> found;
    std::vector<double> values(channels_);
    tree.find(tree.point(own), settings.neighbours, found, groups_, groups_[own]);
    fit(tree, tree.point(own), found, settings.curved, values);
    for (std::size_t c = 0; c < channels_; ++c) {
      const double f = values_[own * channels_ + c];
      const double difference = std::abs(f - values[c]);
      if (difference > 0) parts[k].relative += difference / (std::abs(f) + std::abs(values[c]));
      parts[k].difference += difference;
      parts[k].reference += std::abs(f);
    }
    plain_.find(points_[own], 1, found, groups_, groups_[own]);
    parts[k].distance = std::sqrt(2 * found.front().square);
  });
  Sums all;
  std::vector<double> distances;
  for (const Sums& part : parts) {
    all.relative += part.relative;
    all.difference += part.difference;
    all.reference += part.reference;
    distances.push_back(part.distance);
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  held_back_.samples = count;
  held_back_.rel_l1_percent = all.reference > 0 ? 100 * all.difference / all.reference : 0;
  held_back_.spacing_deg = degrees_from_radians(*middle);
  return all.relative;
}

void LocalFit::fit(const NearestPoints& tree, const SamplePlace& place, std::span<const Neighbour> found, bool curved,
                   std::span<double> values) const {
  const std::size_t axes = isotropic_ ? 3 : 4;
  std::vector<double> shares(found.size(), 0);
  if (found.size() == 1 || found.front().square < kSame * kSame) {
    shares[0] = 1;
  } else {
    shares_at(tree, place, found, axes, curved, shares);
  }
  for (std::size_t c = 0; c < channels_; ++c) {
    double low = values_[found[0].point * channels_ + c];
    double high = low;
    for (const Neighbour& neighbour : found) {
      low = std::min(low, values_[neighbour.point * channels_ + c]);
      high = std::max(high, values_[neighbour.point * channels_ + c]);
    }
    const bool logarithmic = low > 0;
    double sum = 0;
    for (std::size_t n = 0; n < found.size(); ++n) {
      const double value = values_[found[n].point * channels_ + c];
      sum += shares[n] * (logarithmic ? std::log(value) : value);
    }
    if (logarithmic) {
      low = std::log(low);
      high = std::log(high);
    }
    const double room = kOvershoot * (high - low);
    const bool some_negative = !logarithmic && low < 0;
    sum = std::clamp(sum, logarithmic || some_negative ? low - room : low, high + room);
    values[c] = logarithmic ? std::exp(sum) : sum;
  }
}

void LocalFit::value_at(const DirectionPair& pair, std::span<double> values) const {
  SamplePlace place = place_of(pair);
  place[2] *= settings_.difference_scale;
  place[3] *= settings_.difference_scale;
  std::vector<Neighbour> found;
  near_.find(place, settings_.neighbours, found);
  fit(near_, place, found, settings_.curved, values);
}

double LocalFit::distance_deg(const DirectionPair& pair) const {
  std::vector<Neighbour> found;
  plain_.find(place_of(pair), 1, found);
  return degrees_from_radians(std::sqrt(2 * found.front().square));
}

}  // namespace sbrdf::internal
