#include "codec/atlas/paper/paper_textures.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "codec/atlas/slice_values.h"
#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 3;
constexpr std::uint64_t kMostSide = 16384;  // of common graphics cards
constexpr double kSameNodeDeg = 1e-6;

/// Fills the texels. Sides are set.
class Filling {
 public:
  Filling(const SliceValues& values, PaperTextures& textures) : values_(values), textures_(textures) {}

  void fill() {
    for (PaperTexture& texture : textures_.textures) {
      texture.texels.resize(std::size_t{texture.width} * texture.height * kChannels);
    }
    const auto elevations = static_cast<std::uint32_t>(textures_.elevations_deg.size());
    parallel_for(std::uint64_t{elevations} * elevations, [&](std::uint64_t k) {
      const auto i = static_cast<std::uint32_t>(k / elevations);
      const auto j = static_cast<std::uint32_t>(k % elevations);
      if (i <= j) fill_area(i, j);
    });
    parallel_for(std::uint64_t{elevations} * textures_.azimuth_count, [&](std::uint64_t k) {
      fill_horizontal(static_cast<std::uint32_t>(k % elevations), static_cast<std::uint32_t>(k / elevations));
    });
    const SliceValues::Value normal = values_.at({});
    std::transform(normal.begin(), normal.end(), textures_.at_normal.begin(),
                   [](double v) { return static_cast<float>(v); });
  }

 private:
  [[nodiscard]] double azimuth(std::uint32_t node) const { return node * textures_.azimuth_step_deg(); }

  void fill_area(std::uint32_t i, std::uint32_t j) {
    Coordinates x{};
    x[kHorizontal] = textures_.elevations_deg[j];
    x[kVertical] = textures_.elevations_deg[i];
    const std::uint32_t left = paper_area(i, j) * (textures_.azimuth_count + 1);
    for (std::uint32_t node = 0; node <= textures_.azimuth_count; ++node) {
      x[kDiagonal] = azimuth(node);
      for (std::uint32_t k = 0; k <= 2 * textures_.azimuth_count; ++k) {
        x[kAxial] = azimuth(k);
        put(PaperTextureKind::kCrossings, left + node, k, x);
      }
      for (std::uint32_t row = 0; row < kPaperAzimuthRows; ++row) {
        x[kAxial] = 2.0 * row;
        put(PaperTextureKind::kAxial, left + node, row, x);
      }
      for (std::uint32_t row = 0; row < kPaperAzimuthRows; ++row) {
        // (s, u) and (s + 360, u - 360) are the same directions, and the lattice ends at u = 360.
        Coordinates y = x;
        const bool second_half = 2 * row >= 360;
        y[kAxial] = azimuth(node) + (second_half ? 360 : 0);
        y[kDiagonal] = 2.0 * row - (second_half ? 360 : 0);
        put(PaperTextureKind::kDiagonal, left + node, row, y);
      }
    }
  }

  void fill_horizontal(std::uint32_t i, std::uint32_t u_node) {
    const std::uint32_t columns = 2 * textures_.azimuth_count + 1;
    Coordinates x{};
    x[kVertical] = textures_.elevations_deg[i];
    x[kDiagonal] = azimuth(u_node);
    for (std::uint32_t k = 0; k < columns; ++k) {
      x[kAxial] = azimuth(k);
      for (std::uint32_t row = 0; row < kPaperElevationRows; ++row) {
        x[kHorizontal] = row;
        put(PaperTextureKind::kHorizontal, u_node * columns + k, i * kPaperElevationRows + row, x);
      }
    }
  }

  void put(PaperTextureKind kind, std::uint32_t x, std::uint32_t y, const Coordinates& coordinates) {
    PaperTexture& texture = textures_.texture(kind);
    const SliceValues::Value v = values_.at(coordinates);
    float* texel = texture.texels.data() + (std::size_t{y} * texture.width + x) * kChannels;
    for (std::size_t c = 0; c < kChannels; ++c) texel[c] = static_cast<float>(v[c]);
  }

  const SliceValues& values_;
  PaperTextures& textures_;
};

/// Padded nodes are 0, step, 2 step, ... up to `end`.
bool are_regular(const std::vector<double>& nodes, double step, double end) {
  if (nodes.size() != static_cast<std::size_t>(std::lround(end / step)) + 1) return false;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (std::abs(nodes[k] - static_cast<double>(k) * step) > kSameNodeDeg) return false;
  }
  return true;
}

Status check_fits(const SlicedBrdf& sliced, const Lattice& lattice) {
  const std::string needs = "the paper's textures hold slices of the elevation frame at a placement e_s/a_s: ";
  if (lattice.spec.id != FrameId::kElevation) {
    return unsupported(needs + "this material has the frame " + std::string(geometry(lattice.spec.id).name()));
  }
  const std::vector<double>& s = lattice.nodes[kAxial];
  const std::vector<double>& u = lattice.nodes[kDiagonal];
  const double step = u.size() < 2 ? 720 : 360.0 / static_cast<double>(u.size() - 1);
  if (!are_regular(u, step, 360)) {
    return unsupported(needs + "the axial slices of this material are not equally far apart");
  }
  if (!lattice.spec.symmetries.isotropic && !are_regular(s, step, 720)) {
    return unsupported(needs +
                       "the diagonal slices of this material are not as many as the axial ones, equally far "
                       "apart");
  }
  if (lattice.nodes[kHorizontal].back() > kPaperMostThetaDeg) {
    return unsupported(
        "the paper's texture of horizontal slices has 90 rows of 1 degree, up to theta_v = 89, and the "
        "slices of this material go up to " +
        std::to_string(lattice.nodes[kHorizontal].back()) + " degrees; sample it with --theta-max 89");
  }
  return check_atlas_channels(sliced.channel_count());
}

}  // namespace

std::uint64_t PaperTextures::texel_count() const {
  std::uint64_t count = 0;
  for (const PaperTexture& texture : textures) count += std::uint64_t{texture.width} * texture.height;
  return count;
}

Status lay_out_paper(PaperTextures& textures) {
  const std::uint64_t elevations = textures.elevations_deg.size();
  const std::uint64_t azimuths = textures.azimuth_count;
  const std::uint64_t areas = elevations * (elevations + 1) / 2;
  const auto set = [&](PaperTextureKind kind, std::uint64_t width, std::uint64_t height) {
    PaperTexture& texture = textures.texture(kind);
    texture.width = static_cast<std::uint32_t>(width);
    texture.height = static_cast<std::uint32_t>(height);
    return std::max(width, height) <= kMostSide;
  };
  bool fits = set(PaperTextureKind::kCrossings, areas * (azimuths + 1), 2 * azimuths + 1);
  fits = set(PaperTextureKind::kAxial, areas * (azimuths + 1), kPaperAzimuthRows) && fits;
  fits = set(PaperTextureKind::kDiagonal, areas * (azimuths + 1), kPaperAzimuthRows) && fits;
  fits = set(PaperTextureKind::kHorizontal, azimuths * (2 * azimuths + 1), elevations * kPaperElevationRows) && fits;
  if (fits) return ok_status();
  return unsupported("the paper's textures of " + std::to_string(elevations) + " elevations and " +
                     std::to_string(azimuths) + " slices of each kind have sides of more than " +
                     std::to_string(kMostSide) + " texels");
}

Result<PaperTextures> bake_paper_textures(const SlicedBrdf& sliced, const Lattice& lattice) {
  if (Status fits = check_fits(sliced, lattice); !fits) return fits.error();
  PaperTextures textures;
  const std::vector<double>& elevations = lattice.nodes[kVertical];
  textures.elevations_deg.assign(elevations.begin() + 1, elevations.end());
  textures.azimuth_count = static_cast<std::uint32_t>(lattice.nodes[kDiagonal].size() - 1);
  textures.isotropic = lattice.spec.symmetries.isotropic;
  if (Status laid = lay_out_paper(textures); !laid) return laid.error();
  textures.domain = domain_of(sliced, lattice);
  Filling(SliceValues(sliced, lattice), textures).fill();
  return textures;
}

}  // namespace sbrdf::internal
