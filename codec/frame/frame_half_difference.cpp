#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "codec/frame/frame_geometries.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPhiH = kAxial;
constexpr std::size_t kPhiD = kDiagonal;
constexpr std::size_t kThetaD = kHorizontal;
constexpr std::size_t kThetaH = kVertical;

// Lattice points below the horizon need a value that lets slices pass smoothly into the directions that count. Each
// direction's theta is kept near the largest that the frame covers; the last bit of the way is eased, because a hard
// stop would put a kink into every slice.
constexpr double kEaseDeg = 1;

double eased_theta(double theta, double theta_max_deg) {
  const double limit = radians_from_degrees(ease_from_deg(theta_max_deg));
  if (theta <= limit) return theta;
  const double ease = radians_from_degrees(kEaseDeg);
  return std::min(limit + ease * (1 - std::exp((limit - theta) / ease)), kPi / 2);
}

// At theta_d = 0 both directions are the half vector; at theta_h = 0 only phi_h + phi_d matters.
void take_out_what_does_not_matter(AffineLine& line, bool isotropic) {
  if (isotropic) drop_axis(line, kPhiH);
  if (stays_at_zero(line, kThetaD)) drop_axis(line, kPhiD);
  if (!stays_at_zero(line, kThetaH)) return;
  if (isotropic) {
    drop_axis(line, kPhiD);
    return;
  }
  if (!stays_at_zero(line, kThetaD)) {
    line.offset[kPhiD] += line.offset[kPhiH];
    line.slope[kPhiD] += line.slope[kPhiH];
  }
  drop_axis(line, kPhiH);
}

class HalfDifferenceGeometry final : public FrameGeometry {
 public:
  std::string_view name() const override { return "half-difference"; }
  std::array<std::string_view, kAxisCount> axis_names() const override {
    return {"phi_h", "phi_d", "theta_d", "theta_h"};
  }
  double node_period(std::size_t axis) const override {
    if (axis == kPhiH) return 360;
    return axis == kPhiD ? 180 : 0;
  }
  double line_period(std::size_t axis, const Symmetries& /*symmetries*/) const override { return node_period(axis); }
  double arc_scale(std::size_t /*axis*/) const override { return 1; }

  double share_served(std::size_t axis, std::span<const double> padded, double node) const override {
    const ServedRange range = served_range(padded, node);
    if (axis < kThetaD) return range.end_deg - range.begin_deg;
    // Around a pole azimuths lie close: the solid angle counts.
    return degrees_from_radians(std::cos(radians_from_degrees(range.begin_deg)) -
                                std::cos(radians_from_degrees(range.end_deg)));
  }

  Coordinates coordinates(const DirectionPair& pair) const override {
    // f(i,v) = f(v,i): one order for both gives the same bits.
    const bool exchange = std::tie(pair.i.theta, pair.i.phi) > std::tie(pair.v.theta, pair.v.phi);
    const HalfDifference angles = half_difference_from_pair(exchange ? DirectionPair{pair.v, pair.i} : pair);
    return {degrees_from_radians(angles.phi_h), wrap(degrees_from_radians(angles.phi_d), 180),
            degrees_from_radians(angles.theta_d), degrees_from_radians(angles.theta_h)};
  }

  DirectionPair directions(const Coordinates& x, double theta_max_deg) const override {
    DirectionPair pair = pair_from_half_difference({radians_from_degrees(x[kThetaH]), radians_from_degrees(x[kPhiH]),
                                                    radians_from_degrees(x[kThetaD]), radians_from_degrees(x[kPhiD])});
    pair.i.theta = eased_theta(pair.i.theta, theta_max_deg);
    pair.v.theta = eased_theta(pair.v.theta, theta_max_deg);
    return pair;
  }

  std::span<const Merging> mergings() const override {
    static constexpr std::array<Merging, 1> kMergings = {Merging{kThetaH, kPhiD, 1, 180}};
    return kMergings;
  }

  // Reciprocity turns phi_d by 180, which is its period here: it adds no image.
  Images images(const AffineLine& line, const Symmetries& symmetries) const override {
    Images images;
    for (unsigned bits = 0; bits < 4; ++bits) {
      const bool mirror_x = (bits & 1U) != 0;
      const bool mirror_y = (bits & 2U) != 0;
      if ((mirror_x && !symmetries.mirror_x) || (mirror_y && !symmetries.mirror_y)) continue;
      AffineLine image = line;
      if (mirror_x) image = mirror_azimuths(image, 0);
      if (mirror_y) image = mirror_azimuths(image, 180);
      take_out_what_does_not_matter(image, symmetries.isotropic);
      image.offset[kPhiH] = wrap_node(image.offset[kPhiH], 360);
      image.offset[kPhiD] = wrap_node(image.offset[kPhiD], 180);
      images.lines[images.count++] = image;
    }
    return images;
  }
};

}  // namespace

const FrameGeometry& half_difference_geometry() {
  static const HalfDifferenceGeometry instance;
  return instance;
}

FrameSpec half_difference_frame(std::vector<double> theta_h_deg, std::vector<double> theta_d_deg,
                                std::vector<double> phi_h_deg, std::vector<double> phi_d_deg,
                                const Symmetries& symmetries, double theta_max_deg) {
  FrameSpec spec;
  spec.id = FrameId::kHalfDifference;
  spec.theta_max_deg = theta_max_deg;
  spec.axes[kPhiH] = {"phi_h", std::move(phi_h_deg)};
  spec.axes[kPhiD] = {"phi_d", std::move(phi_d_deg)};
  spec.axes[kThetaD] = {"theta_d", std::move(theta_d_deg)};
  spec.axes[kThetaH] = {"theta_h", std::move(theta_h_deg)};
  spec.symmetries = symmetries;
  return spec;
}

}  // namespace sbrdf::internal
