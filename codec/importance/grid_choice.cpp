#include "codec/importance/grid_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "formats/core/directions.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {

namespace {

constexpr double kSameSides = 0.01;  // relative difference up to which two sides are taken as one
constexpr double kMostStretched = 1.0 / 64;
// Of the rings, which share follows where the light is; the rest is spread over the angle.
constexpr double kShareByMass = 0.6;
constexpr double kFade = 0.7;  // from one ring of the pilot to the next, at most

/// Points of polar coordinates about the mirror directions of a few directions to the light.
struct Pilot {
  std::vector<glm::dvec2> slopes;
  std::vector<double> masses;  ///< light that comes back there, but for what is diffuse; 1 for each direction
};

constexpr std::size_t kRings = 48;
constexpr std::size_t kAzimuths = 24;
constexpr double kLogLeast = -11.5;  // of stretched slopes: 1e-5
constexpr double kLogMost = 4.05;    // 89 degrees
constexpr double kLogStep = (kLogMost - kLogLeast) / kRings;

double radius_of(double log_slope) { return 1 / (1 + std::exp(-2 * log_slope)); }

/// What is there almost everywhere is left to the cosine.
double diffuse_level(std::vector<double> weights) {
  if (weights.empty()) return 0;
  const auto at = weights.begin() + static_cast<std::ptrdiff_t>(weights.size() / 10);
  std::nth_element(weights.begin(), at, weights.end());
  return *at;
}

/// One direction to the light.
Pilot look(const VectorBrdf& brdf, const glm::dvec3& w_i, const Stretch& stretch) {
  const MirrorPolar polar(w_i, stretch);
  std::vector<glm::vec3> w_v;
  std::vector<double> areas;  // f_r times this is light
  Pilot pilot;
  for (std::size_t a = 0; a < kAzimuths; ++a) {
    const double azimuth = 2 * kPi * (static_cast<double>(a) + 0.5) / kAzimuths;
    const glm::dvec2 heading(std::cos(azimuth), std::sin(azimuth));
    const double horizon = polar.horizon(heading);
    for (std::size_t r = 0; r < kRings; ++r) {
      const double log_slope = kLogLeast + (static_cast<double>(r) + 0.5) * kLogStep;
      const double radius = radius_of(log_slope);
      if (radius >= horizon) break;
      const glm::dvec3 v = polar.direction({heading, radius});
      w_v.emplace_back(v);
      areas.push_back(radius * (1 - radius) * v.z / polar.density(v));  // d(radius) = 2 radius (1 - radius) d(log)
      pilot.slopes.push_back(glm::dvec2(w_i + v) / (w_i.z + v.z));
    }
  }
  const std::vector<glm::vec3> repeated(w_v.size(), glm::vec3(w_i));
  pilot.masses.resize(w_v.size());
  weigh(brdf, repeated, w_v, pilot.masses);
  const double diffuse = diffuse_level(pilot.masses);
  double sum = 0;
  for (std::size_t k = 0; k < w_v.size(); ++k) {
    pilot.masses[k] = std::max(pilot.masses[k] - diffuse, 0.0) * areas[k];
    sum += pilot.masses[k];
  }
  for (double& mass : pilot.masses) mass = sum > 0 ? mass / sum : 0;
  return pilot;
}

Pilot look_around(const VectorBrdf& brdf, IncidenceSymmetry symmetry, const Stretch& stretch) {
  std::vector<double> azimuths = {0, 45, 90, 135, 180, 225, 270, 315};
  if (symmetry == IncidenceSymmetry::kHalfTurn) azimuths.resize(4);
  if (symmetry == IncidenceSymmetry::kQuarter) azimuths.resize(3);
  if (symmetry == IncidenceSymmetry::kIsotropic) azimuths.resize(1);
  std::vector<glm::dvec3> lights;
  for (const double theta : {5.0, 35.0, 60.0, 80.0}) {
    for (const double phi : azimuths) lights.push_back(vector_from_direction(direction_from_degrees(theta, phi)));
  }
  std::vector<Pilot> looks(lights.size());
  parallel_for(lights.size(), [&](std::uint64_t k) { looks[k] = look(brdf, lights[k], stretch); });
  Pilot all;
  for (const Pilot& one : looks) {
    all.slopes.insert(all.slopes.end(), one.slopes.begin(), one.slopes.end());
    all.masses.insert(all.masses.end(), one.masses.begin(), one.masses.end());
  }
  return all;
}

/// By the second moments of half vectors, which are bounded where those of slopes need not be.
Stretch stretch_of(const Pilot& pilot, IncidenceSymmetry symmetry) {
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t k = 0; k < pilot.masses.size(); ++k) {
    const glm::dvec2& s = pilot.slopes[k];
    const double mass = pilot.masses[k] / (1 + glm::dot(s, s));
    xx += mass * s.x * s.x;
    xy += mass * s.x * s.y;
    yy += mass * s.y * s.y;
  }
  if (symmetry == IncidenceSymmetry::kQuarter) xy = 0;
  const double most = std::max(xx, yy);
  if (!(most > 0)) return {};
  const double least = most * kMostStretched * kMostStretched;
  xx = std::max(xx, least);
  const double slant = xy / std::sqrt(xx);  // Cholesky
  yy = std::max(yy - slant * slant, least);
  const double largest = std::sqrt(most);
  return {std::sqrt(xx) / largest, slant / largest, std::sqrt(yy) / largest};
}

/// Ends of rings between which there is as much of: where the light lies, in equal parts with all angles.
std::vector<double> radii_of(const Pilot& pilot, const Stretch& stretch, std::size_t rings) {
  std::array<double, kRings> masses{};
  for (std::size_t k = 0; k < pilot.masses.size(); ++k) {
    const glm::dvec2& s = pilot.slopes[k];
    const double x = s.x / stretch.xx;
    const double length = std::hypot(x, (s.y - stretch.yx * x) / stretch.yy);
    const double at = (std::log(length) - kLogLeast) / kLogStep;
    masses[static_cast<std::size_t>(std::clamp(at, 0.0, kRings - 1.0))] += pilot.masses[k];
  }
  // A highlight fades on both sides of where it was seen, and where it fades cells must not be wide: one that is lit at
  // a corner only would get far too much.
  for (std::size_t k = 1; k < kRings; ++k) masses[k] = std::max(masses[k], kFade * masses[k - 1]);
  for (std::size_t k = kRings - 1; k > 0; --k) masses[k - 1] = std::max(masses[k - 1], kFade * masses[k]);
  const double sum = std::accumulate(masses.begin(), masses.end(), 0.0);
  // Steps from 0 to 1 over an ever larger logarithm of the slope.
  std::vector<double> logs;
  std::vector<double> steps;
  double up_to = 0;
  constexpr std::size_t kFine = 4;
  for (std::size_t k = 0; k <= kRings * kFine; ++k) {
    const double log_slope = kLogLeast + static_cast<double>(k) * kLogStep / kFine;
    const double angle = std::atan(std::exp(log_slope)) / (kPi / 2);
    logs.push_back(log_slope);
    steps.push_back(sum > 0 ? kShareByMass * up_to / sum + (1 - kShareByMass) * angle : angle);
    if (k < kRings * kFine) up_to += masses[k / kFine] / kFine;
  }
  std::vector<double> radii = {0};
  for (std::size_t ring = 1; ring < rings; ++ring) {
    const double wanted = static_cast<double>(ring) / static_cast<double>(rings) * steps.back();
    const auto after = std::upper_bound(steps.begin() + 1, steps.end() - 1, wanted);
    const auto k = static_cast<std::size_t>(after - steps.begin());
    const double t = (wanted - steps[k - 1]) / (steps[k] - steps[k - 1]);
    radii.push_back(radius_of(logs[k - 1] + std::clamp(t, 0.0, 1.0) * (logs[k] - logs[k - 1])));
  }
  radii.push_back(1);
  return radii;
}

/// Pairs, every second of which is near the mirror direction, at all scales.
void some_pairs(std::vector<glm::vec3>& w_i, std::vector<glm::vec3>& w_v) {
  constexpr std::size_t kPairs = 1024;
  // R. Kronmal's additive recurrence: multiples of the powers of one number, here the root of x^5 = x + 1.
  constexpr double kRoot = 1.1673039782614187;
  for (std::size_t k = 0; k < kPairs; ++k) {
    std::array<double, 4> u;
    double step = 1;
    for (double& x : u) {
      step /= kRoot;
      x = std::fmod(0.5 + static_cast<double>(k + 1) * step, 1.0);
    }
    const glm::dvec3 i = vector_from_direction({u[0] * radians_from_degrees(85), 2 * kPi * u[1]});
    glm::dvec3 v = vector_from_direction({u[2] * radians_from_degrees(85), 2 * kPi * u[3]});
    if (k % 2 == 0) {
      const MirrorPolar polar(i, {});
      const glm::dvec2 heading(std::cos(2 * kPi * u[3]), std::sin(2 * kPi * u[3]));
      v = polar.direction({heading, std::min(radius_of(-7 + 7 * u[2]), 0.99 * polar.horizon(heading))});
    }
    w_i.emplace_back(i);
    w_v.emplace_back(v);
  }
}

/// Relative difference of what a BRDF says of pairs and of the same with x and y multiplied.
double difference(const VectorBrdf& brdf, float x, float y) {
  std::vector<glm::vec3> w_i;
  std::vector<glm::vec3> w_v;
  some_pairs(w_i, w_v);
  std::vector<double> here(w_i.size());
  std::vector<double> there(w_i.size());
  weigh(brdf, w_i, w_v, here);
  for (std::vector<glm::vec3>* all : {&w_i, &w_v}) {
    for (glm::vec3& w : *all) w *= glm::vec3(x, y, 1);
  }
  weigh(brdf, w_i, w_v, there);
  double sum = 0;
  for (std::size_t k = 0; k < here.size(); ++k) {
    const double most = std::max(here[k], there[k]);
    sum += most > 0 ? std::abs(here[k] - there[k]) / most : 0;
  }
  return sum / static_cast<double>(here.size());
}

IncidenceSymmetry symmetry_of(const VectorBrdf& brdf) {
  if (brdf.isotropic) return IncidenceSymmetry::kIsotropic;
  if (difference(brdf, -1, -1) > kSameSides) return IncidenceSymmetry::kNone;
  return difference(brdf, -1, 1) > kSameSides ? IncidenceSymmetry::kHalfTurn : IncidenceSymmetry::kQuarter;
}

/// Ever denser towards the horizon: theta = pi/2 sin(x), x in even steps, but the last one just above the horizon.
std::vector<double> cosines_of(std::size_t count) {
  std::vector<double> cosines;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = kPi / 2 * static_cast<double>(k) / static_cast<double>(count - 1);
    cosines.push_back(std::cos(std::min(kPi / 2 * std::sin(x), radians_from_degrees(89.9))));
  }
  cosines.front() = 1;
  return cosines;
}

}  // namespace

void weigh(const VectorBrdf& brdf, std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
           std::span<double> weights) {
  std::vector<float> values(w_i.size() * brdf.channels);
  brdf.evaluate(w_i, w_v, values);
  for (std::size_t k = 0; k < w_i.size(); ++k) {
    double sum = 0;
    for (const float value : std::span(values).subspan(k * brdf.channels, brdf.channels)) {
      if (value > 0 && std::isfinite(value)) sum += static_cast<double>(value);
    }
    weights[k] = sum / static_cast<double>(brdf.channels);
  }
}

ImportanceGrid choose_importance_grid(const VectorBrdf& brdf) {
  ImportanceGrid grid;
  grid.symmetry = symmetry_of(brdf);
  const bool isotropic = grid.symmetry == IncidenceSymmetry::kIsotropic;
  Pilot pilot = look_around(brdf, grid.symmetry, {});
  if (!isotropic) {
    grid.stretch = stretch_of(pilot, grid.symmetry);
    pilot = look_around(brdf, grid.symmetry, grid.stretch);
  }
  grid.cosines = cosines_of(isotropic ? 24 : 11);
  grid.azimuths = isotropic ? 24 : 32;
  grid.radii = radii_of(pilot, grid.stretch, isotropic ? 80 : 32);
  switch (grid.symmetry) {
    case IncidenceSymmetry::kNone:
      grid.azimuths_i = 22;
      break;
    case IncidenceSymmetry::kHalfTurn:
      grid.azimuths_i = 12;
      break;
    case IncidenceSymmetry::kQuarter:
      grid.azimuths_i = 7;
      break;
    case IncidenceSymmetry::kIsotropic:
      break;
  }
  return grid;
}

}  // namespace sbrdf::internal
