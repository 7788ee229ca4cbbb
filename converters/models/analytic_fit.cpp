#include "converters/models/analytic_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <unsupported/Eigen/NonLinearOptimization>

#include "converters/source/reciprocity.h"
#include "formats/core/directions.h"
#include "formats/core/interrupted.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kPairs = 4000;
constexpr std::size_t kFewestPairs = 100;
constexpr std::size_t kTrialPairs = 600;  // that starts are compared on
constexpr std::size_t kFinished = 4;      // starts that are followed to their end, on all pairs
constexpr int kTrialEvaluations = 60;
constexpr int kMostEvaluations = 600;
constexpr double kFloorShare = 1e-3;      // of a channel's mean, in the logarithm
constexpr double kMostExponent = 13;      // logarithms of parameters: within 1e-6 and 1e6
constexpr double kLeastRoughness = 0.02;  // of a start
constexpr double kMostRoughness = 2;
constexpr double kSame = 1.01;  // of the best rms: the same minimum

constexpr Index kChannels = 3;
// The root of k_s of R, G, B; log f_0, log m_x, log m_y; the root of alpha. What may be 0 is a square, since there a
// logarithm would have to go on for ever. What a formula does not have stays where it is: its derivative is 0.
constexpr Index kLobeParameters = 7;

Index index_of(std::size_t k) { return static_cast<Index>(k); }

/// The squares of a direction's two slopes.
struct Slopes {
  double x;
  double y;
};

/// What the formulae take of a pair (specs/kurt.md, specs/models.md), and what the source has there.
struct Pair {
  Slopes half;         ///< (tan theta_h cos phi_h)^2 and (tan theta_h sin phi_h)^2
  double common;       ///< 1 / (4 pi cos^4 theta_h (v.h))
  double log_cosines;  ///< of (l.n)(v.n)
  double fall;         ///< (1 - v.h)^5
  double view_half;    ///< v.h
  double cosines;      ///< (l.n)(v.n)
  Slopes light, viewer;
  std::array<double, kChannels> f;
};

Slopes slopes_of(const glm::dvec3& w) { return {w.x * w.x / (w.z * w.z), w.y * w.y / (w.z * w.z)}; }

Pair pair_of(const glm::dvec3& i, const glm::dvec3& v) {
  const glm::dvec3 h = glm::normalize(i + v);
  const double view_half = glm::dot(v, h);
  const double square = h.z * h.z;
  const double x = 1 - view_half;
  return {{h.x * h.x / square, h.y * h.y / square},
          1 / (4 * kPi * square * square * view_half),
          std::log(i.z * v.z),
          x * x * x * x * x,
          view_half,
          i.z * v.z,
          slopes_of(i),
          slopes_of(v),
          {}};
}

/// Of the pairs, in turn: anywhere, and where light and viewer mirror each other about a half vector near the normal.
std::vector<DirectionPair> draw_pairs(double theta_max) {
  std::mt19937_64 random(1);
  const auto share = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  const double least_z = std::cos(theta_max);
  std::vector<DirectionPair> pairs;
  while (pairs.size() < kPairs) {
    const Direction i = {theta_max * share(), 2 * kPi * share()};
    if (pairs.size() % 2 == 0) {
      pairs.push_back({i, {theta_max * share(), 2 * kPi * share()}});
      continue;
    }
    // Highlights of any width: the tangent of theta_h is spread over its logarithm.
    const double tangent = 0.003 * std::pow(1000, share());
    const double azimuth = 2 * kPi * share();
    const glm::dvec3 h = glm::normalize(glm::dvec3(tangent * std::cos(azimuth), tangent * std::sin(azimuth), 1));
    const glm::dvec3 light = vector_from_direction(i);
    const glm::dvec3 viewer = 2 * glm::dot(light, h) * h - light;
    if (viewer.z > least_z) pairs.push_back({i, direction_from_vector(viewer)});
  }
  return pairs;
}

/// The measured ones of drawn pairs, with their values.
std::vector<Pair> sample_pairs(const BrdfSource& source) {
  const double theta_max = radians_from_degrees(std::min(source.traits().slice_theta_max_deg, 89.0));
  const std::vector<DirectionPair> drawn = draw_pairs(theta_max);
  const std::size_t channels = source.channel_count();
  std::vector<float> values(drawn.size() * channels);
  evaluate_in_parallel(source, drawn, values);
  std::vector<std::uint8_t> measured(drawn.size(), 1);
  if (source.mask_grid()) source.measured(drawn, measured);
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    if (measured[k] == 0) continue;
    Pair pair = pair_of(vector_from_direction(drawn[k].i), vector_from_direction(drawn[k].v));
    for (std::size_t c = 0; c < pair.f.size(); ++c) {
      pair.f[c] = std::max(0.0F, values[k * channels + (channels == 1 ? 0 : c)]);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

/// The metric, and its derivative by f.
class Scale {
 public:
  Scale(FitMetric metric, std::span<const Pair> pairs) : metric_(metric) {
    for (std::size_t c = 0; c < floor_.size(); ++c) {
      double sum = 0;
      for (const Pair& pair : pairs) sum += pair.f[c];
      mean_[c] = std::max(sum / static_cast<double>(pairs.size()), 1e-9);
      floor_[c] = kFloorShare * mean_[c];
    }
  }
  [[nodiscard]] double of(double f, std::size_t c) const {
    return metric_ == FitMetric::kLog ? std::log(f + floor_[c]) : std::cbrt(f);
  }
  [[nodiscard]] double slope(double f, std::size_t c) const {
    if (metric_ == FitMetric::kLog) return 1 / (f + floor_[c]);
    const double root = std::cbrt(std::max(f, floor_[c]));
    return 1 / (3 * root * root);
  }
  [[nodiscard]] double mean(std::size_t c) const { return mean_[c]; }

 private:
  FitMetric metric_;
  std::array<double, kChannels> mean_{};
  std::array<double, kChannels> floor_{};
};

double bounded_exp(double logarithm) { return std::exp(std::clamp(logarithm, -kMostExponent, kMostExponent)); }

double bounded_square(double root) { return std::min(root * root, kParameterLargest); }

/// What stands behind k_s and Fresnel's term, and its relative derivatives by log m_x, log m_y and alpha.
struct Shape {
  double value;
  double by_x;
  double by_y;
  double by_alpha;
};

/// A lobe as its formula takes it, from its parameters.
struct Lobe {
  Lobe(LobeKind of, const double* p)
      : kind(of),
        k_s{bounded_square(p[0]), bounded_square(p[1]), bounded_square(p[2])},
        f_0(bounded_exp(p[3])),
        square_x(std::pow(bounded_exp(p[4]), 2)),
        square_y(std::pow(bounded_exp(p[5]), 2)),
        alpha(std::min(p[6] * p[6], kLargestAlpha)) {}

  [[nodiscard]] Shape shape(const Pair& pair) const {
    if (kind == LobeKind::kGgx) return ggx_shape(pair);
    const double x = pair.half.x / square_x;
    const double y = pair.half.y / square_y;
    const double common = pair.common / std::sqrt(square_x * square_y);
    if (kind == LobeKind::kWard) return {common / pair.view_half * std::exp(-x - y), 2 * x - 1, 2 * y - 1, 0};
    return {common * std::exp(-x - y - alpha * pair.log_cosines), 2 * x - 1, 2 * y - 1, -pair.log_cosines};
  }
  [[nodiscard]] double fresnel(const Pair& pair) const {
    return kind == LobeKind::kWard ? 1 : f_0 + (1 - f_0) * pair.fall;
  }
  /// By log f_0.
  [[nodiscard]] double fresnel_slope(const Pair& pair) const {
    return kind == LobeKind::kWard ? 0 : f_0 * (1 - pair.fall);
  }

  LobeKind kind;
  std::array<double, kChannels> k_s;
  double f_0;
  double square_x;
  double square_y;
  double alpha;

 private:
  [[nodiscard]] Shape ggx_shape(const Pair& pair) const {
    const double x = pair.half.x / square_x;
    const double y = pair.half.y / square_y;
    const double spread = 1 + x + y;
    const double light = std::sqrt(1 + pair.light.x * square_x + pair.light.y * square_y);
    const double viewer = std::sqrt(1 + pair.viewer.x * square_x + pair.viewer.y * square_y);
    const double masking = 2 / (light + viewer);
    const double value =
        pair.common * pair.view_half * masking / (spread * spread * pair.cosines * std::sqrt(square_x * square_y));
    const double masked_x = masking / 2 * square_x * (pair.light.x / light + pair.viewer.x / viewer);
    const double masked_y = masking / 2 * square_y * (pair.light.y / light + pair.viewer.y / viewer);
    return {value, 4 * x / spread - 1 - masked_x, 4 * y / spread - 1 - masked_y, 0};
  }
};

/// Differences in the metric and their derivatives by the parameters, as Eigen's minimiser asks for them. Parameters:
/// the roots of k_d of R, G, B, then those of each lobe.
class Differences {
 public:
  using Scalar = double;
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = MatrixXd;
  [[maybe_unused]] static constexpr int InputsAtCompileTime = Eigen::Dynamic;  // NOLINT: names that Eigen asks for
  [[maybe_unused]] static constexpr int ValuesAtCompileTime = Eigen::Dynamic;  // NOLINT

  Differences(std::span<const Pair> pairs, const AnalyticFitOptions& options, const Scale& scale)
      : pairs_(pairs), kind_(options.kind), lobes_(options.lobes), scale_(scale) {}

  [[nodiscard]] int inputs() const { return static_cast<int>(kChannels + index_of(lobes_) * kLobeParameters); }
  [[nodiscard]] int values() const { return static_cast<int>(kChannels * index_of(pairs_.size())); }

  int operator()(const VectorXd& p, VectorXd& differences) const {
    const std::vector<Lobe> lobes = lobes_of(p);
    for (std::size_t n = 0; n < pairs_.size(); ++n) {
      std::array<double, kChannels> f = diffuse(p);
      for (const Lobe& lobe : lobes) {
        const double s = lobe.shape(pairs_[n]).value * lobe.fresnel(pairs_[n]);
        for (std::size_t c = 0; c < f.size(); ++c) f[c] += lobe.k_s[c] * s;
      }
      for (std::size_t c = 0; c < f.size(); ++c) {
        differences[row(n, c)] = scale_.of(f[c], c) - scale_.of(pairs_[n].f[c], c);
      }
    }
    return 0;
  }

  int df(const VectorXd& p, MatrixXd& slopes) const {
    const std::vector<Lobe> lobes = lobes_of(p);
    slopes.setZero();
    for (std::size_t n = 0; n < pairs_.size(); ++n) {
      const Pair& pair = pairs_[n];
      std::array<double, kChannels> f = diffuse(p);
      for (std::size_t c = 0; c < f.size(); ++c) slopes(row(n, c), index_of(c)) = 2 * p[index_of(c)] / kPi;
      for (std::size_t l = 0; l < lobes.size(); ++l) {
        const Lobe& lobe = lobes[l];
        const Index first = kChannels + index_of(l) * kLobeParameters;
        const Shape shape = lobe.shape(pair);
        const double s = shape.value * lobe.fresnel(pair);
        const double root = p[first + 6];
        for (std::size_t c = 0; c < f.size(); ++c) {
          const double value = lobe.k_s[c] * s;
          f[c] += value;
          slopes(row(n, c), first + index_of(c)) = 2 * p[first + index_of(c)] * s;
          slopes(row(n, c), first + 3) = lobe.k_s[c] * shape.value * lobe.fresnel_slope(pair);
          slopes(row(n, c), first + 4) = value * shape.by_x;
          slopes(row(n, c), first + 5) = value * shape.by_y;
          slopes(row(n, c), first + 6) = value * shape.by_alpha * 2 * root;
        }
      }
      for (std::size_t c = 0; c < f.size(); ++c) slopes.row(row(n, c)) *= scale_.slope(f[c], c);
    }
    return 0;
  }

  [[nodiscard]] std::vector<Lobe> lobes_of(const VectorXd& p) const {
    std::vector<Lobe> lobes;
    for (std::size_t l = 0; l < lobes_; ++l) {
      lobes.emplace_back(kind_, p.data() + kChannels + index_of(l) * kLobeParameters);
    }
    return lobes;
  }
  [[nodiscard]] static std::array<double, kChannels> diffuse(const VectorXd& p) {
    return {bounded_square(p[0]) / kPi, bounded_square(p[1]) / kPi, bounded_square(p[2]) / kPi};
  }

 private:
  static Index row(std::size_t pair, std::size_t channel) { return kChannels * index_of(pair) + index_of(channel); }

  std::span<const Pair> pairs_;
  LobeKind kind_;
  std::size_t lobes_;
  const Scale& scale_;
};

/// Number `index` of a sequence that fills [0, 1) evenly (Halton's, of a prime).
double spread(std::uint64_t index, std::uint64_t prime) {
  double result = 0;
  double part = 1;
  for (std::uint64_t k = index + 1; k > 0; k /= prime) {
    part /= static_cast<double>(prime);
    result += part * static_cast<double>(k % prime);
  }
  return result;
}

/// Roughness of every lobe, and the weights that fit best with it.
VectorXd start_at(std::uint64_t number, std::span<const Pair> pairs, const AnalyticFitOptions& options,
                  const Scale& scale) {
  static constexpr std::array<std::uint64_t, 2 * kMostFitLobes> kPrimes = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  const std::size_t lobes = options.lobes;
  VectorXd p = VectorXd::Zero(kChannels + index_of(lobes) * kLobeParameters);
  for (std::size_t l = 0; l < lobes; ++l) {
    double* lobe = p.data() + kChannels + index_of(l) * kLobeParameters;
    const auto roughness = [&](std::size_t which) {
      return std::log(kLeastRoughness) +
             spread(number, kPrimes[2 * l + which]) * std::log(kMostRoughness / kLeastRoughness);
    };
    lobe[3] = std::log(0.3);
    lobe[4] = roughness(0);
    lobe[5] = roughness(1);
    lobe[6] = 0.5;
  }
  const Differences shape(pairs, options, scale);
  const std::vector<Lobe> made = shape.lobes_of(p);
  const Index terms = 1 + index_of(lobes);
  for (std::size_t c = 0; c < kChannels; ++c) {
    // Relative differences, squared; a little is added so that lobes that are alike share the weight.
    MatrixXd normal = 1e-6 * MatrixXd::Identity(terms, terms);
    VectorXd right = VectorXd::Zero(terms);
    for (const Pair& pair : pairs) {
      const double weight = 1 / (pair.f[c] + 0.1 * scale.mean(c));
      VectorXd row(terms);
      row[0] = weight / kPi;
      for (std::size_t l = 0; l < lobes; ++l) {
        row[1 + index_of(l)] = weight * made[l].shape(pair).value * made[l].fresnel(pair);
      }
      normal += row * row.transpose();
      right += weight * pair.f[c] * row;
    }
    const VectorXd found = normal.ldlt().solve(right);
    const double least = 0.01 * scale.mean(c);
    p[index_of(c)] = std::sqrt(std::max(found[0], least));
    for (std::size_t l = 0; l < lobes; ++l) {
      p[kChannels + index_of(l) * kLobeParameters + index_of(c)] = std::sqrt(std::max(found[1 + index_of(l)], least));
    }
  }
  return p;
}

struct Candidate {
  VectorXd p;
  double rms = 0;
};

Candidate improved(VectorXd p, const Differences& differences, int evaluations) {
  Differences copy = differences;
  Eigen::LevenbergMarquardt<Differences> minimiser(copy);
  minimiser.parameters.maxfev = evaluations;
  minimiser.parameters.ftol = 1e-12;
  minimiser.parameters.xtol = 1e-10;
  minimiser.minimize(p);
  const double rms = minimiser.fnorm / std::sqrt(static_cast<double>(differences.values()));
  return {std::move(p), std::isfinite(rms) ? rms : std::numeric_limits<double>::max()};
}

AnalyticModel model_of(const VectorXd& p, const Differences& differences, LobeKind kind) {
  AnalyticModel model;
  model.kind = kind;
  for (std::size_t c = 0; c < model.k_d.size(); ++c) model.k_d[c] = bounded_square(p[index_of(c)]);
  for (const Lobe& lobe : differences.lobes_of(p)) {
    AnalyticLobe one = {lobe.k_s, lobe.f_0, std::sqrt(lobe.square_x), std::sqrt(lobe.square_y), lobe.alpha};
    if (kind != LobeKind::kKurt) one.alpha = 0;
    if (kind == LobeKind::kWard) one.f_0 = 1;
    model.lobes.push_back(one);
  }
  std::sort(model.lobes.begin(), model.lobes.end(),
            [](const AnalyticLobe& a, const AnalyticLobe& b) { return a.m_x * a.m_y > b.m_x * b.m_y; });
  return model;
}

}  // namespace

Result<AnalyticFit> fit_analytic(const BrdfSource& source, const AnalyticFitOptions& options,
                                 const Progress& progress) {
  const std::size_t channels = source.channel_count();
  if (channels != 1 && channels != 3) {
    return unsupported(fmt::format("the model has three channels, and this material has {}", channels));
  }
  const SymmetrisedSource symmetrised(source);
  const std::vector<Pair> pairs = sample_pairs(source.traits().reciprocal ? source : symmetrised);
  if (pairs.size() < kFewestPairs) {
    return unsupported(fmt::format("only {} of {} pairs of directions were measured", pairs.size(), kPairs));
  }
  const Scale scale(options.metric, pairs);
  const std::span<const Pair> few = std::span(pairs).first(std::min(kTrialPairs, pairs.size()));
  const Differences trial(few, options, scale);
  const Differences whole(pairs, options, scale);
  ProgressCounter counter(progress, 2 * options.starts);
  std::vector<Candidate> candidates(options.starts);
  parallel_for(options.starts, [&](std::uint64_t k) {
    if (counter.stopped()) return;
    candidates[k] = improved(start_at(k, few, options, scale), trial, kTrialEvaluations);
    counter.advance();
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rms < b.rms; });
  candidates.resize(std::min(kFinished, candidates.size()));
  parallel_for(candidates.size(), [&](std::uint64_t k) {
    if (counter.stopped()) return;
    candidates[k] = improved(std::move(candidates[k].p), whole, kMostEvaluations);
    counter.advance(options.starts / candidates.size());
  });
  if (counter.stopped()) return interrupted_error();
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [](const Candidate& a, const Candidate& b) { return a.rms < b.rms; });
  AnalyticFit fit;
  fit.model = model_of(best->p, whole, options.kind);
  fit.rms = best->rms;
  fit.pairs = pairs.size();
  fit.finished = candidates.size();
  fit.same_minimum = static_cast<std::size_t>(std::count_if(
      candidates.begin(), candidates.end(), [&](const Candidate& one) { return one.rms <= kSame * best->rms + 1e-9; }));
  return fit;
}

}  // namespace sbrdf::internal
