#include "converters/files/scattered/chosen_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace sbrdf::internal {
namespace {

/// Angles of samples that differ by less are the same [degrees].
constexpr double kSame = 1e-6;
constexpr std::size_t kMostThetas = 91;
constexpr std::size_t kMostPhis = 180;
/// Angles that lie closer jitter about others [degrees].
constexpr double kLeastGap = 0.5;
/// Wider gaps get nodes of their own, so far apart at most [degrees].
constexpr double kWidestThetaGap = 20, kWidestPhiGap = 30, kFilledStep = 10;
constexpr std::uint64_t kMostNodes = std::uint64_t{1} << 21U;

/// Steps of theta and phi where samples lie anywhere.
struct Steps {
  double theta, phi;
};
Steps steps_for(std::size_t samples, bool isotropic) {
  if (isotropic) return samples < 200 ? Steps{10, 20} : samples < 5000 ? Steps{5, 10} : Steps{2.5, 5};
  return samples < 500 ? Steps{15, 30} : samples < 10000 ? Steps{10, 20} : Steps{5, 10};
}

/// Angles [degrees] without repetitions, rising.
std::vector<double> distinct(std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  std::vector<double> result;
  for (const double angle : angles) {
    // Radians have made 7.5 into 7.499999999999999.
    const double decimal = std::round(angle * 1e6) / 1e6;
    const double plain = std::abs(decimal - angle) < 1e-9 ? decimal : angle;
    if (result.empty() || plain - result.back() > kSame) result.push_back(plain);
  }
  return result;
}

bool jitters(const std::vector<double>& angles) {
  return std::adjacent_find(angles.begin(), angles.end(), [](double a, double b) { return b - a < kLeastGap; }) !=
         angles.end();
}

/// With more nodes in wide gaps; `end` is the angle at which the last gap ends.
std::vector<double> filled(const std::vector<double>& nodes, double widest, double end) {
  std::vector<double> result;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double next = k + 1 < nodes.size() ? nodes[k + 1] : end;
    const double gap = next - nodes[k];
    const double parts = gap > widest ? std::ceil(gap / kFilledStep) : 1;
    for (double part = 0; part < parts; ++part) result.push_back(nodes[k] + gap * part / parts);
  }
  return result;
}

std::vector<double> even(double step, double last) {
  return even_nodes(0, step, static_cast<std::size_t>(std::lround(last / step)) + 1);
}

GridAxis theta_axis(std::vector<double> angles, double step, bool own) {
  angles = distinct(std::move(angles));
  if (!own || angles.size() > kMostThetas || jitters(angles)) return GridAxis(even(step, 90));
  if (angles.front() > 0) angles.insert(angles.begin(), 0);
  return GridAxis(filled(angles, kWidestThetaGap, angles.back()));
}

GridAxis phi_axis(std::vector<double> angles, double step, bool own) {
  angles = distinct(std::move(angles));
  if (!own || angles.empty() || angles.size() > kMostPhis || jitters(angles)) {
    return GridAxis(even_nodes(0, step, static_cast<std::size_t>(std::lround(360 / step))), Ends::kFullTurn);
  }
  return GridAxis(filled(angles, kWidestPhiGap, angles.front() + 360), Ends::kFullTurn);
}

GridAxis mirrored_axis(std::vector<double> angles, double step, bool own) {
  for (double& angle : angles) angle = std::min(angle, 180.0);
  angles = distinct(std::move(angles));
  if (!own || angles.empty() || angles.size() > kMostPhis || jitters(angles)) {
    return GridAxis(even(step, 180), Ends::kMirrored);
  }
  if (angles.front() > 0) angles.insert(angles.begin(), 0);
  if (angles.back() < 180) angles.push_back(180);
  return GridAxis(filled(angles, kWidestPhiGap, 180), Ends::kMirrored);
}

struct AngleLists {
  std::vector<double> theta_i, phi_i, theta_v, phi_v, phi_difference;
};

/// An azimuth [degrees] in [0, 360), 0 where it is a full turn but for rounding.
double azimuth_deg(double phi) {
  const double turned = wrap(degrees_from_radians(phi), 360);
  return turned > 360 - kSame ? 0 : turned;
}

// Azimuths at the pole say nothing.
AngleLists lists_of(const Samples& samples) {
  AngleLists lists;
  for (const auto& [i, v] : samples.pairs) {
    lists.theta_i.push_back(degrees_from_radians(i.theta));
    lists.theta_v.push_back(degrees_from_radians(v.theta));
    if (i.theta > 0) lists.phi_i.push_back(azimuth_deg(i.phi));
    if (v.theta > 0) lists.phi_v.push_back(azimuth_deg(v.phi));
    if (v.theta > 0) lists.phi_difference.push_back(azimuth_deg(v.phi - i.phi));
  }
  return lists;
}

Grid make_grid(const AngleLists& lists, const Steps& steps, bool isotropic, bool mirrored, bool own) {
  const GridAxis theta_i = theta_axis(lists.theta_i, steps.theta, own);
  const GridAxis theta_v = theta_axis(lists.theta_v, steps.theta, own);
  if (!isotropic) {
    return {GridFrame::kAngles,
            {theta_i, phi_axis(lists.phi_i, steps.phi, own), theta_v, phi_axis(lists.phi_v, steps.phi, own)}};
  }
  const GridAxis phi =
      mirrored ? mirrored_axis(lists.phi_difference, steps.phi, own) : phi_axis(lists.phi_difference, steps.phi, own);
  return {GridFrame::kDifference, {GridAxis(), theta_i, theta_v, phi}};
}

}  // namespace

ChosenGrid choose_grid(const Samples& samples) {
  const AngleLists lists = lists_of(samples);
  const std::vector<double> azimuths = distinct(lists.phi_i);
  const bool isotropic = azimuths.size() <= 1;
  const bool mirrored = isotropic && std::all_of(lists.phi_difference.begin(), lists.phi_difference.end(),
                                                 [](double phi) { return phi <= 180 + kSame; });
  const Steps steps = steps_for(samples.pairs.size(), isotropic);
  ChosenGrid chosen;
  chosen.grid = make_grid(lists, steps, isotropic, mirrored, true);
  if (chosen.grid.node_count() > kMostNodes) chosen.grid = make_grid(lists, steps, isotropic, mirrored, false);
  if (!isotropic) {
    chosen.reason = "phi_i varies: all four angles";
  } else {
    chosen.reason =
        fmt::format("phi_i is {:g} throughout: taken as isotropic", azimuths.empty() ? 0 : azimuths.front());
    if (mirrored) chosen.reason += "; phi_v - phi_i is 0 to 180 throughout: taken as mirrored";
  }
  return chosen;
}

}  // namespace sbrdf::internal
