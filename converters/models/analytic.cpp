#include "converters/models/analytic.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

namespace {

using Colour = std::array<double, 3>;

/// A lobe with its constants multiplied out.
struct Lobe {
  Colour weight;  ///< k_s / (4 pi m_x m_y)
  double f_0;
  double sharpness_x;  ///< 1 / m_x^2
  double sharpness_y;
  double alpha;
  double square_x;  ///< m_x^2
  double square_y;
};

/// i and v after the step back from the horizon, as every lobe needs them.
struct Geometry {
  glm::dvec3 sum;     ///< i + v, along the half vector
  double cosines;     ///< (l.n)(v.n)
  double square_z;    ///< of sum
  double square_sum;  ///< |sum|^2
};

glm::dvec3 stepped_back(const Direction& w) {
  return vector_from_direction({std::min(w.theta, kPi / 2 - kAnalyticGrazing), w.phi});
}

/// Of a vector of any length above the horizon, normalised.
glm::dvec3 stepped_back(const glm::dvec3& w) {
  static const double least_z = std::sin(kAnalyticGrazing);
  static const double most_radius = std::cos(kAnalyticGrazing);
  const double square = w.x * w.x + w.y * w.y;
  const double length = std::sqrt(square + w.z * w.z);
  if (w.z >= least_z * length) return w / length;
  const double radius = std::sqrt(square);
  return {w.x * (most_radius / radius), w.y * (most_radius / radius), least_z};
}

/// Of vectors that were stepped back.
Geometry geometry_of(const glm::dvec3& i, const glm::dvec3& v) {
  const glm::dvec3 sum = i + v;
  const double square_z = sum.z * sum.z;
  return {sum, i.z * v.z, square_z, sum.x * sum.x + sum.y * sum.y + square_z};
}

/// What all lobes take of a pair.
struct Terms {
  double fall;    ///< (1 - v.h)^5
  double common;  ///< 1 / (cos^4 theta_h (v.h))
  double view_half;
  double log_cosines;  ///< where a lobe needs it
};

/// A lobe's value but for its weight: a formula for each kind.
template <LobeKind kind>
double strength_of(const Lobe& lobe, const Geometry& g, const Terms& terms, const glm::dvec3& i, const glm::dvec3& v) {
  const double slope = (g.sum.x * g.sum.x * lobe.sharpness_x + g.sum.y * g.sum.y * lobe.sharpness_y) / g.square_z;
  if constexpr (kind == LobeKind::kWard) return terms.common / terms.view_half * std::exp(-slope);
  const double fresnel = lobe.f_0 + (1 - lobe.f_0) * terms.fall;
  if constexpr (kind == LobeKind::kKurt) {
    // Beckmann's exponential and the power of the cosines in one exp.
    return terms.common * fresnel * std::exp(-slope - lobe.alpha * terms.log_cosines);
  }
  const auto root = [&](const glm::dvec3& w) {
    return std::sqrt(1 + (w.x * w.x * lobe.square_x + w.y * w.y * lobe.square_y) / (w.z * w.z));
  };
  const double masking = 2 / (root(i) + root(v));
  return terms.common * terms.view_half * fresnel * masking / ((1 + slope) * (1 + slope) * g.cosines);
}

template <LobeKind kind>
class AnalyticSource final : public BrdfSource {
 public:
  explicit AnalyticSource(const AnalyticModel& model) {
    for (std::size_t c = 0; c < diffuse_.size(); ++c) diffuse_[c] = model.k_d[c] / kPi;
    bool isotropic = true;
    for (const AnalyticLobe& lobe : model.lobes) {
      const double scale = 1 / (4 * kPi * lobe.m_x * lobe.m_y);
      lobes_.push_back({{lobe.k_s[0] * scale, lobe.k_s[1] * scale, lobe.k_s[2] * scale},
                        lobe.f_0,
                        1 / (lobe.m_x * lobe.m_x),
                        1 / (lobe.m_y * lobe.m_y),
                        lobe.alpha,
                        lobe.m_x * lobe.m_x,
                        lobe.m_y * lobe.m_y});
      isotropic = isotropic && lobe.m_x == lobe.m_y;
      needs_log_ = needs_log_ || (kind == LobeKind::kKurt && lobe.alpha > 0);
    }
    traits_.format = name_of(kLobeKindNames, kind);
    traits_.description = fmt::format("{} model {}, {} lobe{}", kNames.at(static_cast<std::size_t>(kind)), model.name,
                                      lobes_.size(), lobes_.size() == 1 ? "" : "s");
    traits_.channels = {"R", "G", "B"};
    traits_.isotropic = isotropic;
    traits_.reciprocal = true;
    traits_.slice_theta_max_deg = kPaperThetaMaxDeg;  // a formula has no end; the paper's grids have
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    assert(values.size() == pairs.size() * diffuse_.size());
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const auto& [i, v] = pairs[n];
      put(above_horizon(pairs[n]) ? value_at(stepped_back(i), stepped_back(v)) : Colour{}, n, values);
    }
  }

  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override {
    assert(w_i.size() == w_v.size() && values.size() == w_i.size() * diffuse_.size());
    for (std::size_t n = 0; n < w_i.size(); ++n) {
      const bool above = above_horizon(w_i[n]) && above_horizon(w_v[n]);
      put(above ? value_at(stepped_back(glm::dvec3(w_i[n])), stepped_back(glm::dvec3(w_v[n]))) : Colour{}, n, values);
    }
  }

 private:
  static void put(const Colour& f_r, std::size_t n, std::span<float> values) {
    for (std::size_t c = 0; c < f_r.size(); ++c) {
      values[n * f_r.size() + c] = static_cast<float>(std::min<double>(f_r[c], std::numeric_limits<float>::max()));
    }
  }

  // Of vectors that were stepped back.
  [[nodiscard]] Colour value_at(const glm::dvec3& i, const glm::dvec3& v) const {
    Colour f_r = diffuse_;
    if (lobes_.empty()) return f_r;
    const Geometry g = geometry_of(i, v);
    const double view_half = std::sqrt(g.square_sum) / 2;  // v.h = |i + v| / 2
    const double x = 1 - view_half;
    const double fall = x * x * x * x * x;
    const double log_cosines = needs_log_ ? std::log(g.cosines) : 0;
    const double square_cosine = g.square_z / g.square_sum;  // of theta_h
    const Terms terms = {fall, 1 / (square_cosine * square_cosine * view_half), view_half, log_cosines};
    for (const Lobe& lobe : lobes_) {
      const double strength = strength_of<kind>(lobe, g, terms, i, v);
      for (std::size_t c = 0; c < f_r.size(); ++c) f_r[c] += lobe.weight[c] * strength;
    }
    return f_r;
  }

  static constexpr std::array<std::string_view, kLobeKindNames.size()> kNames = {"Kurt", "Ward", "GGX"};

  Colour diffuse_{};
  std::vector<Lobe> lobes_;
  bool needs_log_ = false;
  SourceTraits traits_;
};

}  // namespace

std::size_t shape_count(LobeKind kind) { return kind == LobeKind::kKurt ? 4 : kind == LobeKind::kWard ? 2 : 3; }

std::unique_ptr<BrdfSource> make_analytic_source(const AnalyticModel& model) {
  assert(check_analytic(model).ok());
  if (model.kind == LobeKind::kWard) return std::make_unique<AnalyticSource<LobeKind::kWard>>(model);
  if (model.kind == LobeKind::kGgx) return std::make_unique<AnalyticSource<LobeKind::kGgx>>(model);
  return std::make_unique<AnalyticSource<LobeKind::kKurt>>(model);
}

}  // namespace sbrdf::internal
