#include "converters/models/kurt.h"

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
};

/// i and v after the step back from the horizon, as every lobe needs them.
struct Geometry {
  glm::dvec3 sum;     ///< i + v, along the half vector
  double cosines;     ///< (l.n)(v.n)
  double square_z;    ///< of sum
  double square_sum;  ///< |sum|^2
};

Geometry geometry_of(const DirectionPair& pair) {
  const auto stepped_back = [](const Direction& w) {
    return vector_from_direction({std::min(w.theta, kPi / 2 - kKurtGrazing), w.phi});
  };
  const glm::dvec3 i = stepped_back(pair.i);
  const glm::dvec3 v = stepped_back(pair.v);
  const glm::dvec3 sum = i + v;
  const double square_z = sum.z * sum.z;
  return {sum, i.z * v.z, square_z, sum.x * sum.x + sum.y * sum.y + square_z};
}

class KurtSource final : public BrdfSource {
 public:
  explicit KurtSource(const KurtModel& model) {
    for (std::size_t c = 0; c < diffuse_.size(); ++c) diffuse_[c] = model.k_d[c] / kPi;
    bool isotropic = true;
    for (const KurtLobe& lobe : model.lobes) {
      const double scale = 1 / (4 * kPi * lobe.m_x * lobe.m_y);
      lobes_.push_back({{lobe.k_s[0] * scale, lobe.k_s[1] * scale, lobe.k_s[2] * scale},
                        lobe.f_0,
                        1 / (lobe.m_x * lobe.m_x),
                        1 / (lobe.m_y * lobe.m_y),
                        lobe.alpha});
      isotropic = isotropic && lobe.m_x == lobe.m_y;
      needs_log_ = needs_log_ || lobe.alpha > 0;
    }
    traits_.format = "kurt";
    traits_.description =
        fmt::format("Kurt model {}, {} lobe{}", model.name, lobes_.size(), lobes_.size() == 1 ? "" : "s");
    traits_.channels = {"R", "G", "B"};
    traits_.isotropic = isotropic;
    traits_.reciprocal = true;
    traits_.slice_theta_max_deg = kPaperThetaMaxDeg;  // a formula has no end; the paper's grids have
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    assert(values.size() == pairs.size() * diffuse_.size());
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const Colour f_r = above_horizon(pairs[n]) ? value_at(pairs[n]) : Colour{};
      for (std::size_t c = 0; c < f_r.size(); ++c) {
        values[n * f_r.size() + c] = static_cast<float>(std::min<double>(f_r[c], std::numeric_limits<float>::max()));
      }
    }
  }

 private:
  [[nodiscard]] Colour value_at(const DirectionPair& pair) const {
    Colour f_r = diffuse_;
    if (lobes_.empty()) return f_r;
    const Geometry g = geometry_of(pair);
    const double view_half = std::sqrt(g.square_sum) / 2;  // v.h = |i + v| / 2
    const double x = 1 - view_half;
    const double fall = x * x * x * x * x;
    const double log_cosines = needs_log_ ? std::log(g.cosines) : 0;
    const double square_cosine = g.square_z / g.square_sum;  // of theta_h
    const double common = 1 / (square_cosine * square_cosine * view_half);
    for (const Lobe& lobe : lobes_) {
      // Beckmann's exponential and the power of the cosines in one exp.
      const double slope = (g.sum.x * g.sum.x * lobe.sharpness_x + g.sum.y * g.sum.y * lobe.sharpness_y) / g.square_z;
      const double fresnel = lobe.f_0 + (1 - lobe.f_0) * fall;
      const double strength = common * fresnel * std::exp(-slope - lobe.alpha * log_cosines);
      for (std::size_t c = 0; c < f_r.size(); ++c) f_r[c] += lobe.weight[c] * strength;
    }
    return f_r;
  }

  Colour diffuse_{};
  std::vector<Lobe> lobes_;
  bool needs_log_ = false;
  SourceTraits traits_;
};

}  // namespace

std::unique_ptr<BrdfSource> make_kurt_source(const KurtModel& model) {
  assert(check_kurt_model(model).ok());
  return std::make_unique<KurtSource>(model);
}

}  // namespace sbrdf::internal
