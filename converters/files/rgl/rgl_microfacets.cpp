#include "converters/files/rgl/rgl_microfacets.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "converters/files/rgl/rgl_angles.h"
#include "converters/files/rgl/rgl_tables.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kProfile = 128;  // nodes along x of ndf and sigma, as in published files
constexpr std::size_t kTurn = 64;      // azimuths of ndf, without the one that closes the turn
constexpr std::size_t kSigmaProfile = 48;
constexpr std::size_t kSigmaTurn = 24;
constexpr int kIterations = 24;
/// Beyond this f_r is taken as it is here: models grow without bound towards the horizon.
constexpr double kLargestTheta = radians_from_degrees(80);
/// Least density of normals, of the largest.
constexpr double kLeastNormals = 1e-9;
/// Share of a density of visible normals that is the same everywhere.
constexpr double kEvenShare = 1e-3;
/// Power of the density that the paper has.
constexpr double kPower = 0.5;
/// Share of what is denser towards the horizon: isotropic, anisotropic.
constexpr double kGrazingShare = 0.3;
constexpr double kAnisotropicGrazingShare = 0.5;
/// How near the horizon that becomes even, above it and below [cosine of theta_v].
constexpr double kGrazingCosine = 0.1;

double unit(std::size_t k, std::size_t count) { return static_cast<double>(k) / static_cast<double>(count - 1); }

/// |f_r| cos(theta) where light and viewer are the same, at each node of a grid; one row for all where isotropic.
std::vector<double> retroreflection(const BrdfSource& source, const RglGrid& grid, bool isotropic) {
  std::vector<DirectionPair> pairs;
  for (std::size_t n = 0; n < grid.cell_count(); ++n) {
    const double y = isotropic ? 0.5 : unit(n / grid.x_count, grid.y_count);
    const double theta = theta_from_unit(unit(n % grid.x_count, grid.x_count));
    const Direction m = {std::min(theta, kLargestTheta), phi_from_unit(y)};
    pairs.push_back({m, m});
  }
  const std::size_t channels = source.channel_count();
  std::vector<float> values(pairs.size() * channels);
  evaluate_in_parallel(source, pairs, values);
  std::vector<double> result(pairs.size());
  for (std::size_t n = 0; n < values.size(); ++n) {
    const double value = std::abs(static_cast<double>(values[n]));
    if (std::isfinite(value)) result[n / channels] += value / static_cast<double>(channels);
  }
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    result[n] *= std::cos(theta_from_unit(unit(n % grid.x_count, grid.x_count)));
  }
  return result;
}

/// Integrals of ndf(m) max(i.m, 0) over m.
class ProjectedArea {
 public:
  explicit ProjectedArea(bool isotropic)
      : grid_(isotropic ? RglGrid{kProfile, 2} : RglGrid{kSigmaProfile, kSigmaTurn + 1}) {
    for (std::size_t row = 0; row < kTurn; ++row) {
      for (std::size_t x = 0; x < kProfile; ++x) {
        const Direction m = {theta_from_unit(unit(x, kProfile)), phi_from_unit(unit(row, kTurn + 1))};
        const double width = (x == 0 || x + 1 == kProfile ? 0.5 : 1.0) / (kProfile - 1) / kTurn;
        normals_.push_back(vector_from_direction(m));
        weights_.push_back(2 * kPi * kPi * unit(x, kProfile) * std::sin(m.theta) * width);
      }
    }
  }

  [[nodiscard]] const RglGrid& grid() const { return grid_; }

  /// `ndf` has kTurn rows or more of kProfile.
  [[nodiscard]] std::vector<double> operator()(std::span<const double> ndf) const {
    std::vector<double> sigma(grid_.cell_count());
    parallel_for(sigma.size(), [&](std::uint64_t n) {
      const double y = unit(n / grid_.x_count, grid_.y_count);
      const glm::dvec3 i = vector_from_direction(
          {theta_from_unit(unit(n % grid_.x_count, grid_.x_count)), phi_from_unit(grid_.y_count == 2 ? 0.5 : y)});
      for (std::size_t k = 0; k < normals_.size(); ++k) {
        const glm::dvec3& m = normals_[k];
        sigma[n] += std::max(0.0, i.x * m.x + i.y * m.y + i.z * m.z) * weights_[k] * ndf[k];
      }
    });
    return sigma;
  }

 private:
  RglGrid grid_;
  std::vector<glm::dvec3> normals_;
  std::vector<double> weights_;
};

/// Where f_r cos(theta_v) of a diffuse material asks for nodes: its relative bend grows towards the horizon, its bend
/// along x with x. Below the horizon a few are enough.
double grazing_density(const RglPoint& u, double cosine) {
  const double below = std::min(cosine, 0.0) / kGrazingCosine;
  return (0.3 + u.x) / (std::sqrt(std::max(cosine, 0.0) + kGrazingCosine) * (1 + below * below));
}

std::vector<float> floats_of(std::span<const double> values) { return {values.begin(), values.end()}; }

/// Normals are scaled so that those within sight of the normal make an area of 1.
void scale_to_unit_area(const ProjectedArea& area, std::vector<double>& ndf, std::vector<double>& sigma) {
  sigma = area(ndf);
  const double at_normal = sigma[0];
  for (double& value : ndf) value /= at_normal;
  for (double& value : sigma) value /= at_normal;
}

}  // namespace

double fill_microfacets(const BrdfSource& source, RglMaterial& material) {
  const bool isotropic = material.isotropic();
  const RglGrid normals = {kProfile, kTurn + 1};
  const std::vector<double> retro = retroreflection(source, normals, isotropic);
  const auto peak = static_cast<std::size_t>(std::max_element(retro.begin(), retro.end()) - retro.begin());
  const double largest = retro[peak];
  const bool black = !(largest > 0);
  std::vector<double> f(retro.size(), 1.0);
  if (!black) {
    std::transform(retro.begin(), retro.end(), f.begin(), [&](double value) { return value / largest; });
  }
  const ProjectedArea area(isotropic);
  std::vector<double> sigma(area.grid().cell_count(), 1.0);
  std::vector<double> ndf(f.size());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const RglTable at(area.grid(), floats_of(sigma));
    for (std::size_t n = 0; n < ndf.size(); ++n) {
      ndf[n] = f[n] * at.at({unit(n % kProfile, kProfile), unit(n / kProfile, normals.y_count)});
    }
    scale_to_unit_area(area, ndf, sigma);
  }
  const double least = kLeastNormals * *std::max_element(ndf.begin(), ndf.end());
  for (double& value : ndf) value = std::max(value, least);
  scale_to_unit_area(area, ndf, sigma);
  for (double& value : sigma) value = std::max(value, 1e-6);

  material.jacobian = true;
  material.ndf_grid = isotropic ? RglGrid{kProfile, 2} : normals;
  material.ndf = floats_of(std::span(ndf).first(material.ndf_grid.cell_count()));
  material.sigma_grid = area.grid();
  material.sigma = floats_of(sigma);
  const RglPoint at_peak = {unit(peak % kProfile, kProfile), unit(peak / kProfile, normals.y_count)};
  return black ? 0 : 4 * largest * RglTable(area.grid(), material.sigma).at(at_peak) / ndf[peak];
}

void fill_visible_normals(std::size_t size, RglMaterial& material) {
  material.vndf_grid = {size, size};
  const std::size_t cells = material.vndf_grid.cell_count();
  material.vndf.resize(material.slice_count() * cells);
  const RglTable ndf(material.ndf_grid, material.ndf);
  const double share = material.isotropic() ? kGrazingShare : kAnisotropicGrazingShare;
  parallel_for(material.slice_count(), [&](std::uint64_t slice) {
    const std::size_t thetas = material.theta_i.size();
    const Direction i = {material.theta_i[slice % thetas], material.phi_i[slice / thetas]};
    std::vector<double> lobe(cells);
    std::vector<double> grazing(cells);
    double lobe_sum = 0;
    double grazing_sum = 0;
    for (std::size_t n = 0; n < cells; ++n) {
      const RglPoint u = {unit(n % size, size), unit(n / size, size)};
      const RglReflection reflected = rgl_reflection(i, u);
      lobe_sum += lobe[n] = std::pow(ndf.at(u) * reflected.solid_angle, kPower);
      grazing_sum += grazing[n] = grazing_density(u, reflected.v.z);
    }
    for (std::size_t n = 0; n < cells; ++n) {
      const double density = (1 - share - kEvenShare) * lobe[n] / lobe_sum + share * grazing[n] / grazing_sum +
                             kEvenShare / static_cast<double>(cells);
      material.vndf[slice * cells + n] = static_cast<float>(density);
    }
  });
}

}  // namespace sbrdf::internal
