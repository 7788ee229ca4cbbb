#include "converters/judge/albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace sbrdf::internal {
namespace {

/// Distances of the first borders from the mirror direction [degrees].
constexpr std::array kGradesDeg = {0.005, 0.02, 0.08, 0.32, 1.28, 5.12};
constexpr double kWidestThetaDeg = 10;
constexpr double kWidestPhiDeg = 20;
/// Rectangles narrower than this [radians] are not halved: there is a step, which nothing makes smaller.
constexpr double kNarrowest = 1e-7;

// Genz & Malik 1980, section 2, for two dimensions, with weights of a square of area 1.
constexpr std::size_t kPoints = 17;
const double kNear = std::sqrt(9.0 / 70);
const double kFar = std::sqrt(9.0 / 10);
const double kCorner = std::sqrt(9.0 / 19);
constexpr std::array<double, 5> kWeights7 = {-3816.0 / 19683, 980.0 / 6561, 1020.0 / 19683, 200.0 / 19683,
                                             6859.0 / 19683 / 4};
constexpr std::array<double, 5> kWeights5 = {-971.0 / 729, 245.0 / 486, 65.0 / 1458, 25.0 / 729, 0};

struct RulePoint {
  double x, y;  ///< in [-1, 1]
  std::size_t orbit;
};
const std::array<RulePoint, kPoints> kRule = {{{0, 0, 0},
                                               {-kNear, 0, 1},
                                               {kNear, 0, 1},
                                               {0, -kNear, 1},
                                               {0, kNear, 1},
                                               {-kFar, 0, 2},
                                               {kFar, 0, 2},
                                               {0, -kFar, 2},
                                               {0, kFar, 2},
                                               {-kFar, -kFar, 3},
                                               {-kFar, kFar, 3},
                                               {kFar, -kFar, 3},
                                               {kFar, kFar, 3},
                                               {-kCorner, -kCorner, 4},
                                               {-kCorner, kCorner, 4},
                                               {kCorner, -kCorner, 4},
                                               {kCorner, kCorner, 4}}};

/// A rectangle of directions [radians]; phi counts from that of the light.
struct Rectangle {
  std::array<double, 2> theta, phi;
  bool beyond = false;     ///< theta_max
  bool halve_phi = false;  ///< the function bends more along phi
  double worst_error = 0;  ///< of all channels, in units of what is allowed of the whole
  std::size_t slot = 0;    ///< where its sums lie
};

// Sorted, without repetitions, and with further borders where two are farther apart than `widest`.
std::vector<double> with_gaps_filled(std::vector<double> borders, double widest) {
  std::sort(borders.begin(), borders.end());
  std::vector<double> filled = {borders.front()};
  for (const double border : borders) {
    const double gap = border - filled.back();
    if (gap < 1e-9) continue;
    const double from = filled.back();
    const double parts = std::ceil(gap / widest);
    for (double k = 1; k < parts; ++k) filled.push_back(from + gap * k / parts);
    filled.push_back(border);
  }
  return filled;
}

std::vector<double> theta_borders(double theta_i_deg, double theta_max_deg) {
  std::vector<double> borders = {0, theta_i_deg, 90};
  if (theta_max_deg > 0 && theta_max_deg < 90) borders.push_back(theta_max_deg);
  for (const double grade : kGradesDeg) {
    for (const double border : {theta_i_deg - grade, theta_i_deg + grade}) {
      if (border > 0 && border < 90) borders.push_back(border);
    }
  }
  return with_gaps_filled(std::move(borders), kWidestThetaDeg);
}

// From the light's azimuth: 0 leads back to it, -180 and 180 to the mirror direction.
std::vector<double> phi_borders(double theta_i_deg) {
  std::vector<double> borders = {-180, 0, 180};
  const double sine = std::sin(radians_from_degrees(theta_i_deg));
  for (const double grade : kGradesDeg) {
    if (grade >= 90 * sine) continue;
    for (const double border : {grade / sine, 180 - grade / sine}) {
      borders.push_back(border);
      borders.push_back(-border);
    }
  }
  return with_gaps_filled(std::move(borders), kWidestPhiDeg);
}

class Integral {
 public:
  Integral(const BrdfSource& source, const Direction& i, const AlbedoOptions& options)
      : source_(source), i_(i), options_(options), channels_(source.channel_count()) {
    result_.i = i;
  }

  Albedo run() {
    std::vector<Rectangle> next = first_rectangles();
    for (;;) {
      measure(next);
      rectangles_.insert(rectangles_.end(), next.begin(), next.end());
      add_up();
      if (result_.reached) break;
      next = halved();
      if (next.empty()) break;
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::vector<Rectangle> first_rectangles() {
    const double theta_max = radians_from_degrees(source_.traits().theta_max_deg);
    const double theta_i_deg = degrees_from_radians(i_.theta);
    const std::vector<double> thetas = theta_borders(theta_i_deg, source_.traits().theta_max_deg);
    const std::vector<double> phis = phi_borders(theta_i_deg);
    std::vector<Rectangle> rectangles;
    for (std::size_t t = 0; t + 1 < thetas.size(); ++t) {
      for (std::size_t p = 0; p + 1 < phis.size(); ++p) {
        Rectangle made;
        made.theta = {radians_from_degrees(thetas[t]), radians_from_degrees(thetas[t + 1])};
        made.phi = {radians_from_degrees(phis[p]), radians_from_degrees(phis[p + 1])};
        made.beyond = 0.5 * (made.theta[0] + made.theta[1]) > theta_max;
        made.slot = slots_++;
        rectangles.push_back(made);
      }
    }
    return rectangles;
  }

  void measure(std::vector<Rectangle>& rectangles) {
    std::vector<DirectionPair> pairs;
    pairs.reserve(rectangles.size() * kPoints);
    for (const Rectangle& at : rectangles) {
      for (const RulePoint& point : kRule) {
        pairs.push_back({i_,
                         {0.5 * ((1 - point.x) * at.theta[0] + (1 + point.x) * at.theta[1]),
                          i_.phi + 0.5 * ((1 - point.y) * at.phi[0] + (1 + point.y) * at.phi[1])}});
      }
    }
    values_.resize(pairs.size() * channels_);
    evaluate_in_parallel(source_, pairs, values_);
    count_unmeasured(pairs);
    result_.evaluations += pairs.size();
    sums_.resize(slots_ * channels_);
    errors_.resize(slots_ * channels_);
    for (std::size_t k = 0; k < rectangles.size(); ++k) measure_one(rectangles[k], std::span(pairs), k);
  }

  void count_unmeasured(std::span<const DirectionPair> pairs) {
    if (!source_.mask_grid()) return;
    std::vector<std::uint8_t> flags(pairs.size());
    source_.measured(pairs, flags);
    result_.unmeasured += static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), 0));
  }

  void measure_one(Rectangle& at, std::span<const DirectionPair> pairs, std::size_t number) {
    const double area = (at.theta[1] - at.theta[0]) * (at.phi[1] - at.phi[0]);
    std::array<double, 2> bends = {0, 0};
    for (std::size_t c = 0; c < channels_; ++c) {
      std::array<double, kPoints> f{};
      double sum7 = 0;
      double sum5 = 0;
      for (std::size_t k = 0; k < kPoints; ++k) {
        const std::size_t point = number * kPoints + k;
        const double theta = pairs[point].v.theta;
        const float value = values_[point * channels_ + c];
        if (!std::isfinite(value)) ++result_.not_finite;
        f[k] = std::isfinite(value) ? value * std::cos(theta) * std::sin(theta) : 0;
        sum7 += kWeights7[kRule[k].orbit] * f[k];
        sum5 += kWeights5[kRule[k].orbit] * f[k];
      }
      // Differences of the fourth order: where the rule of degree 5 is wrong.
      bends[0] += std::abs(f[1] + f[2] - 2 * f[0] - (f[5] + f[6] - 2 * f[0]) / 7);
      bends[1] += std::abs(f[3] + f[4] - 2 * f[0] - (f[7] + f[8] - 2 * f[0]) / 7);
      sums_[at.slot * channels_ + c] = sum7 * area;
      errors_[at.slot * channels_ + c] = std::abs(sum7 - sum5) * area;
    }
    const double across = std::sin(0.5 * (at.theta[0] + at.theta[1])) * (at.phi[1] - at.phi[0]);
    const bool alike = std::abs(bends[0] - bends[1]) <= 1e-6 * (bends[0] + bends[1]);
    at.halve_phi = alike ? across > at.theta[1] - at.theta[0] : bends[1] > bends[0];
  }

  // The sums in the order of the rectangles, so that they are the same each time.
  void add_up() {
    result_.measured.assign(channels_, 0);
    result_.beyond.assign(channels_, 0);
    result_.error.assign(channels_, 0);
    for (const Rectangle& at : rectangles_) {
      std::vector<double>& part = at.beyond ? result_.beyond : result_.measured;
      for (std::size_t c = 0; c < channels_; ++c) {
        part[c] += sums_[at.slot * channels_ + c];
        result_.error[c] += errors_[at.slot * channels_ + c];
      }
    }
    std::vector<double> allowed(channels_);
    result_.reached = true;
    for (std::size_t c = 0; c < channels_; ++c) {
      allowed[c] = options_.accuracy * std::max(1.0, std::abs(result_.total(c)));
      result_.reached = result_.reached && result_.error[c] <= allowed[c];
    }
    for (Rectangle& at : rectangles_) {
      at.worst_error = 0;
      for (std::size_t c = 0; c < channels_; ++c) {
        at.worst_error = std::max(at.worst_error, errors_[at.slot * channels_ + c] / allowed[c]);
      }
    }
  }

  // Takes out the worst rectangles, so many that what is left makes half of the allowed error, and halves them.
  [[nodiscard]] std::vector<Rectangle> halved() {
    const std::uint64_t left = options_.most_evaluations - std::min(options_.most_evaluations, result_.evaluations);
    const std::uint64_t most = left / (2 * kPoints);
    std::vector<std::size_t> order(rectangles_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return rectangles_[a].worst_error > rectangles_[b].worst_error;
    });
    double rest = 0;
    for (const Rectangle& at : rectangles_) rest += at.worst_error;
    std::vector<Rectangle> halves;
    std::vector<bool> gone(rectangles_.size(), false);
    for (const std::size_t k : order) {
      if (rest <= 0.5 || halves.size() / 2 >= most) break;
      rest -= rectangles_[k].worst_error;
      gone[k] = append_halves(rectangles_[k], halves);
    }
    std::size_t kept = 0;
    for (std::size_t k = 0; k < rectangles_.size(); ++k) {
      if (!gone[k]) rectangles_[kept++] = rectangles_[k];
    }
    rectangles_.resize(kept);
    return halves;
  }

  bool append_halves(const Rectangle& whole, std::vector<Rectangle>& halves) {
    Rectangle first = whole;
    Rectangle second = whole;
    const auto split = [&](std::array<double, 2> Rectangle::*side) {
      const double middle = 0.5 * ((whole.*side)[0] + (whole.*side)[1]);
      (first.*side)[1] = (second.*side)[0] = middle;
      return middle - (whole.*side)[0] > kNarrowest;
    };
    if (!split(whole.halve_phi ? &Rectangle::phi : &Rectangle::theta)) return false;
    second.slot = slots_++;
    halves.push_back(first);
    halves.push_back(second);
    return true;
  }

  const BrdfSource& source_;
  Direction i_;
  AlbedoOptions options_;
  std::size_t channels_;
  std::vector<Rectangle> rectangles_;
  std::size_t slots_ = 0;
  std::vector<double> sums_;    ///< of each slot, channel fastest
  std::vector<double> errors_;  ///< likewise
  std::vector<float> values_;
  Albedo result_;
};

}  // namespace

Albedo directional_albedo(const BrdfSource& source, const Direction& i, const AlbedoOptions& options) {
  return Integral(source, i, options).run();
}

}  // namespace sbrdf::internal
