#include "converters/files/rgl/rgl_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <utility>

#include "converters/files/rgl/rgl_angles.h"
#include "converters/files/rgl/rgl_least_squares.h"
#include "converters/files/rgl/rgl_tables.h"
#include "converters/tables/dense_source.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

/// Incidences within a panel, along phi_i and theta_i, from its first slices to just before the next.
constexpr int kPhiParts = 2;
constexpr int kThetaParts = 3;
/// Pairs along each side of the square, for each node of the colours: isotropic, anisotropic.
constexpr double kPairsIsotropic = 2;
constexpr double kPairsAnisotropic = 1.5;
/// No light and no viewer closer to the horizon than this is looked at [cosine].
constexpr double kLeastCosine = 5e-3;
/// Half directions closer to the normal have no azimuth to speak of.
constexpr double kLeastX = 1e-4;
constexpr double kPeakWeight = 4;  ///< of pairs there
/// Relative errors are of values this far from the horizon or more [cosine]: nearer, f_r cos(theta_v) falls to 0.
constexpr double kWeighedCosine = 0.03;
/// Least denominator of relative errors, of the mean in a panel.
constexpr double kWeighedSize = 0.01;

/// A place among the slices, and what of it lies on the square.
struct Incidence {
  Direction i;
  RglSlices slices;
};

/// Tables that the colours do not change.
struct Surface {
  explicit Surface(const RglMaterial& of)
      : material(of), sigma(of.sigma_grid, of.sigma), ndf(of.ndf_grid, of.ndf), warp(of.vndf_grid, of.vndf) {}

  [[nodiscard]] Incidence incidence(double phi_i, double theta_i) const {
    return {{theta_i, phi_i}, rgl_slices(material.phi_i, material.theta_i, phi_i, theta_i)};
  }
  /// ndf / (4 sigma).
  [[nodiscard]] double jacobian(const Direction& i, const RglPoint& u_m) const {
    const double y = material.isotropic() ? 0.5 : unit_from_phi(i.phi);
    return ndf.at(u_m) / (4 * sigma.at({unit_from_theta(i.theta), y}));
  }

  const RglMaterial& material;
  RglTable sigma;
  RglTable ndf;
  RglWarp warp;
};

/// What one panel takes from the source.
class PanelSampler {
 public:
  PanelSampler(const BrdfSource& source, const Surface& surface, const RglFitRequest& request)
      : source_(source),
        surface_(surface),
        request_(request),
        channels_(source.channel_count()),
        theta_max_(radians_from_degrees(source.traits().theta_max_deg) + 1e-9) {}

  /// Panel k of the least squares. Nothing where a value is not finite: `bad` tells where.
  void sample(std::size_t k, RglPanel& panel, RglFitLosses& losses, std::optional<DirectionPair>& bad) const {
    std::vector<RglPoint> squares;  // warped
    std::vector<Incidence> incidences;
    std::vector<DirectionPair> pairs;
    std::vector<double> jacobians;
    draw(k, [&](const Incidence& incidence, const RglPoint& s, const RglPoint& u_m, const Direction& v) {
      squares.push_back(s);
      incidences.push_back(incidence);
      pairs.push_back({incidence.i, v});
      jacobians.push_back(surface_.jacobian(incidence.i, u_m));
    });
    std::vector<float> values(pairs.size() * channels_);
    source_.evaluate(pairs, values);
    std::vector<std::uint8_t> measured(pairs.size(), 1);
    if (source_.mask_grid()) source_.measured(pairs, measured);
    std::vector<double> targets(values.size());
    std::vector<double> weights(pairs.size());
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const std::span<float> f = std::span(values).subspan(n * channels_, channels_);
      if (!is_finite(f)) {
        bad = pairs[n];
        return;
      }
      const bool negative = count(pairs[n], measured[n] != 0, f, losses);
      const double cosine = std::cos(pairs[n].v.theta);
      double size = 0;
      for (std::size_t c = 0; c < channels_; ++c) {
        const double value = request_.negatives == Negatives::kClamp ? std::max(f[c], 0.0F) : f[c];
        targets[n * channels_ + c] = value * cosine / (jacobians[n] * request_.size);
        size += std::abs(targets[n * channels_ + c]);
      }
      weights[n] = negative && request_.negatives == Negatives::kUnmeasured
                       ? -1
                       : size / static_cast<double>(channels_) * std::max(1.0, kWeighedCosine / cosine);
    }
    add(squares, incidences, weigh(weights), targets, panel);
  }

 private:
  static bool is_finite(std::span<const float> f) {
    return std::all_of(f.begin(), f.end(), [](float value) { return std::abs(value) <= kTableLargest; });
  }

  /// Whether a channel is below 0.
  bool count(const DirectionPair& pair, bool measured, std::span<const float> f, RglFitLosses& losses) const {
    const bool negative = *std::min_element(f.begin(), f.end()) < 0;
    ++losses.pairs;
    losses.unmeasured += measured ? 0 : 1;
    losses.negative += negative ? 1 : 0;
    losses.positive += *std::max_element(f.begin(), f.end()) > 0 ? 1 : 0;
    losses.beyond_theta_max += std::max(pair.i.theta, pair.v.theta) > theta_max_ ? 1 : 0;
    return negative;
  }

  /// Sizes become weights; a size below 0 counts for nothing.
  static std::vector<double> weigh(std::vector<double> sizes) {
    double sum = 0;
    std::size_t count = 0;
    for (const double size : sizes) {
      sum += std::max(size, 0.0);
      count += size >= 0 ? 1 : 0;
    }
    const double least = std::max(kWeighedSize * sum / static_cast<double>(std::max<std::size_t>(count, 1)), 1e-12);
    for (double& size : sizes) size = size < 0 ? 0 : 1 / (std::max(size, least) * std::max(size, least));
    return sizes;
  }

  /// Pairs above the horizon of the panel: jittered points of the warped square for each incidence.
  template <class Take>
  void draw(std::size_t k, const Take& take) const {
    const RglMaterial& material = surface_.material;
    const std::size_t thetas = material.theta_i.size() - 1;
    const bool isotropic = material.isotropic();
    const std::size_t phi = isotropic ? 0 : k / thetas;
    const std::size_t theta = k % thetas;
    const auto side = static_cast<std::size_t>(std::lround(static_cast<double>(material.colour_grid.x_count) *
                                                           (isotropic ? kPairsIsotropic : kPairsAnisotropic)));
    std::minstd_rand random(static_cast<std::uint32_t>(k + 1));
    std::uniform_real_distribution<double> within(0, 1);
    const int last = theta + 1 == thetas ? kThetaParts : kThetaParts - 1;
    for (int p = 0; p < (isotropic ? 1 : kPhiParts); ++p) {
      for (int t = 0; t <= last; ++t) {
        const double phi_i = isotropic ? 0 : between(material.phi_i, phi, static_cast<double>(p) / kPhiParts);
        const double theta_i = between(material.theta_i, theta, static_cast<double>(t) / kThetaParts);
        const Incidence incidence = surface_.incidence(phi_i, std::min(theta_i, std::acos(kLeastCosine)));
        // And a column where the half direction is the normal, the peak of most materials.
        for (std::size_t n = 0; n < side * (side + 1); ++n) {
          const double x =
              n < side * side ? (static_cast<double>(n % side) + within(random)) / static_cast<double>(side) : 0;
          const std::size_t row = n < side * side ? n / side : n - side * side;
          const RglPoint s = {x, (static_cast<double>(row) + within(random)) / static_cast<double>(side)};
          RglPoint u_m = surface_.warp.warp(s, incidence.slices);
          u_m.x = std::max(u_m.x, kLeastX);
          const RglReflection reflected = rgl_reflection(incidence.i, u_m);
          if (reflected.v.z < kLeastCosine || reflected.cosine <= 0) continue;
          take(incidence, s, u_m, direction_from_vector(reflected.v));
        }
      }
    }
  }

  static double between(std::span<const float> nodes, std::size_t k, double fraction) {
    return nodes[k] + fraction * (nodes[k + 1] - nodes[k]);
  }

  void add(const std::vector<RglPoint>& squares, const std::vector<Incidence>& incidences,
           const std::vector<double>& weights, const std::vector<double>& targets, RglPanel& panel) const {
    panel.reserve(squares.size());
    for (std::size_t n = 0; n < squares.size(); ++n) {
      if (weights[n] == 0) continue;
      const RglCell cell = rgl_cell(surface_.material.colour_grid, squares[n]);
      RglEquation equation;
      equation.first = static_cast<std::uint32_t>(cell.first);
      equation.weight = static_cast<float>(squares[n].x == 0 ? kPeakWeight * weights[n] : weights[n]);
      const RglSlices& slices = incidences[n].slices;
      equation.x = static_cast<float>(cell.weight[1] + cell.weight[3]);
      equation.y = static_cast<float>(cell.weight[2] + cell.weight[3]);
      for (std::size_t i = 0; i < slices.count; ++i) {
        equation.slice[panel.place_of(slices.index[i])] += static_cast<float>(slices.weight[i]);
      }
      panel.add(equation, std::span(targets).subspan(n * channels_, channels_));
    }
  }

  const BrdfSource& source_;
  const Surface& surface_;
  const RglFitRequest& request_;
  std::size_t channels_;
  double theta_max_;
};

void add_up(RglFitLosses& all, const RglFitLosses& part) {
  all.pairs += part.pairs;
  all.unmeasured += part.unmeasured;
  all.beyond_theta_max += part.beyond_theta_max;
  all.negative += part.negative;
  all.positive += part.positive;
}

/// The slices of each panel: two elevations at one azimuth, or at two. The last azimuth is the first again.
std::vector<RglPanel> panels_of(const RglMaterial& material, std::size_t channels) {
  const std::size_t thetas = material.theta_i.size();
  const std::size_t phis = material.isotropic() ? 1 : material.phi_i.size() - 1;
  std::vector<RglPanel> panels;
  for (std::size_t p = 0; p < phis; ++p) {
    for (std::size_t t = 0; t + 1 < thetas; ++t) {
      const std::size_t next = (p + 1) % phis;
      RglPanel panel(material.colour_grid, channels);
      panel.slices = {p * thetas + t, p * thetas + t + 1, next * thetas + t, next * thetas + t + 1};
      panel.on_file = {p * thetas + t, p * thetas + t + 1, (p + 1) * thetas + t, (p + 1) * thetas + t + 1};
      panel.slice_count = material.isotropic() ? 2 : 4;
      panels.push_back(std::move(panel));
    }
  }
  return panels;
}

Status store(const std::vector<double>& solution, const RglFitRequest& request, std::size_t channels,
             RglMaterial& material) {
  const std::size_t slice_size = channels * material.colour_grid.cell_count();
  material.colours.resize(material.slice_count() * slice_size);
  bool positive = false;
  for (std::size_t n = 0; n < material.colours.size(); ++n) {
    double value = solution[n % solution.size()] * request.size;  // the last azimuth is the first
    if (request.negatives == Negatives::kClamp) value = std::max(value, 0.0);
    if (!(std::abs(value) <= std::numeric_limits<float>::max())) {
      return invalid_file("the source's values lead to colours beyond the range of float");
    }
    material.colours[n] = static_cast<float>(value);
    positive = positive || material.colours[n] > 0;
  }
  return positive ? ok_status() : Status(invalid_file("no value of the source is positive: nothing reads such a file"));
}

double luminance_of(std::span<const float> f) {
  constexpr std::array<double, 3> kLuminance = {0.2126, 0.7152, 0.0722};  // IEC 61966-2-1
  double sum = 0;
  for (std::size_t c = 0; c < f.size(); ++c) {
    sum += (f.size() == 3 ? kLuminance[c] : 1 / static_cast<double>(f.size())) * f[c];
  }
  return std::max(sum, 0.0);
}

/// The luminance of one slice: `density` at each node, and whether its direction is above the horizon.
void sample_slice(const BrdfSource& source, const Surface& surface, std::size_t slice, std::span<double> density,
                  std::span<std::uint8_t> valid) {
  constexpr std::size_t kParts = 2;  // points along a side, between two nodes
  const RglMaterial& material = surface.material;
  const RglGrid& grid = material.colour_grid;
  const std::size_t thetas = material.theta_i.size();
  const double theta_i = std::min<double>(material.theta_i[slice % thetas], std::acos(kLeastCosine));
  const Incidence incidence = {{theta_i, material.isotropic() ? 0.0 : material.phi_i[slice / thetas]},
                               {{slice}, {1}, 1}};
  const std::size_t side = kParts * (grid.x_count - 1);
  std::vector<double> sums(grid.cell_count());
  std::vector<float> values(source.channel_count());
  for (std::size_t n = 0; n < side * side; ++n) {
    const RglPoint s = {(static_cast<double>(n % side) + 0.5) / static_cast<double>(side),
                        (static_cast<double>(n / side) + 0.5) / static_cast<double>(side)};
    const RglPoint u_m = surface.warp.warp(s, incidence.slices);
    const RglReflection reflected = rgl_reflection(incidence.i, u_m);
    double value = 0;
    if (reflected.v.z > 0 && reflected.cosine > 0) {
      const DirectionPair pair = {incidence.i, direction_from_vector(reflected.v)};
      source.evaluate(std::span(&pair, 1), values);
      value = luminance_of(values) * std::cos(pair.v.theta) * reflected.solid_angle /
              std::max(surface.warp.density(u_m, incidence.slices), 1e-30);
    }
    const RglCell cell = rgl_cell(grid, s);
    for (std::size_t tap = 0; tap < 4; ++tap) {
      const std::size_t node = cell.first + tap % 2 + tap / 2 * grid.x_count;
      density[node] += cell.weight[tap] * value;
      sums[node] += cell.weight[tap];
    }
  }
  for (std::size_t n = 0; n < grid.cell_count(); ++n) {
    density[n] /= sums[n];
    const RglPoint s = {static_cast<double>(n % grid.x_count) / static_cast<double>(grid.x_count - 1),
                        static_cast<double>(n / grid.x_count) / static_cast<double>(grid.y_count - 1)};
    const RglReflection reflected = rgl_reflection(incidence.i, surface.warp.warp(s, incidence.slices));
    valid[n] = reflected.v.z > 0 ? 1 : 0;
  }
}

}  // namespace

Result<RglFitLosses> fit_colours(const BrdfSource& source, const RglFitRequest& request, RglMaterial& material,
                                 const Progress& progress) {
  const std::size_t channels = source.channel_count();
  const Surface surface(material);
  std::vector<RglPanel> panels = panels_of(material, channels);
  std::vector<RglFitLosses> losses(panels.size());
  std::vector<std::optional<DirectionPair>> bad(panels.size());
  const PanelSampler sampler(source, surface, request);
  ProgressCounter counter(progress, panels.size());
  parallel_for(panels.size(), [&](std::uint64_t k) {
    if (counter.stopped()) return;
    sampler.sample(k, panels[k], losses[k], bad[k]);
    counter.advance();
  });
  if (counter.stopped()) return interrupted_error();
  RglFitLosses all;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    if (bad[k]) {
      return invalid_file(fmt::format(
          "the source gives a NaN, an infinity or a value above {:g} at theta_i {:g}, phi_i {:g}, theta_v {:g}, phi_v "
          "{:g} degrees",
          kTableLargest, degrees_from_radians(bad[k]->i.theta), degrees_from_radians(bad[k]->i.phi),
          degrees_from_radians(bad[k]->v.theta), degrees_from_radians(bad[k]->v.phi)));
    }
    add_up(all, losses[k]);
  }
  // Colours that continue negative ones may be positive below the horizon.
  if (all.positive == 0) return invalid_file("no value of the source is positive: nothing reads such a file");
  const std::size_t phis = material.isotropic() ? 1 : material.phi_i.size() - 1;
  std::vector<double> solution =
      solve_least_squares(panels, material.colour_grid, phis * material.theta_i.size(), channels);
  if (all.negative == 0) {
    for (const RglPanel& panel : panels) panel.lift(solution);
  }
  if (Status stored = store(solution, request, channels, material); !stored) return stored.error();
  return all;
}

RglSampling sampling_of(const BrdfSource& source, const RglMaterial& material) {
  constexpr double kEvenShare = 1e-3;  // nothing that reflects is never drawn
  const Surface surface(material);
  const std::size_t cells = material.colour_grid.cell_count();
  RglSampling sampling;
  sampling.luminance.resize(material.slice_count() * cells);
  std::vector<std::uint8_t> above(sampling.luminance.size());
  parallel_for(material.slice_count(), [&](std::uint64_t slice) {
    std::vector<double> density(cells);
    sample_slice(source, surface, slice, density, std::span(above).subspan(slice * cells, cells));
    double mean = 0;
    for (const double value : density) mean += value / static_cast<double>(cells);
    for (std::size_t n = 0; n < cells; ++n) {
      sampling.luminance[slice * cells + n] =
          static_cast<float>(mean > 0 ? (density[n] / mean + kEvenShare) / (1 + kEvenShare) : 1);
    }
  });
  sampling.valid.resize((above.size() + 7) / 8);
  for (std::size_t n = 0; n < above.size(); ++n) {
    if (above[n] != 0) sampling.valid[n / 8] = static_cast<std::uint8_t>(sampling.valid[n / 8] | (0x80U >> (n % 8)));
  }
  return sampling;
}

}  // namespace sbrdf::internal
