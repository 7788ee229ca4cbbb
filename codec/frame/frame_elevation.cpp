#include <array>
#include <cmath>
#include <utility>

#include "codec/frame/frame_geometries.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kS = kAxial;
constexpr std::size_t kU = kDiagonal;
constexpr std::size_t kThetaV = kHorizontal;
constexpr std::size_t kThetaI = kVertical;

// At theta_i = 0 only phi_v = (s - u) / 2 matters, at theta_v = 0 only phi_i = (s + u) / 2.
void take_out_what_does_not_matter(AffineLine& line, bool isotropic) {
  const bool i_at_pole = stays_at_zero(line, kThetaI);
  const bool v_at_pole = stays_at_zero(line, kThetaV);
  if (isotropic) drop_axis(line, kS);
  if ((i_at_pole && v_at_pole) || (isotropic && (i_at_pole || v_at_pole))) {
    drop_axis(line, kS);
    drop_axis(line, kU);
  } else if (i_at_pole || v_at_pole) {
    const int sign = i_at_pole ? -1 : 1;
    line.offset[kS] += sign * line.offset[kU];
    line.slope[kS] += sign * line.slope[kU];
    drop_axis(line, kU);
  }
}

// (s + 360, u + 360) and (s + 720, u) are (s, u). So one of the two can be brought into [0, 360), which takes the other
// along by as many half periods, and that one into [0, 720). The one that stays is the first, because what moves along
// a line needs no single place.
void wrap_azimuths(AffineLine& line, bool isotropic) {
  if (isotropic) {
    line.offset[kU] = wrap_node(line.offset[kU], 360);
    return;
  }
  const std::size_t fixed = line.slope[kU] != 0 ? kS : kU;
  const std::size_t other = fixed == kS ? kU : kS;
  const double wrapped = wrap_node(line.offset[fixed], 360);
  if (wrapped != line.offset[fixed]) {
    // A whole turn of one is a whole turn of the other.
    line.offset[other] += std::round((wrapped - line.offset[fixed]) / 360) * 360;
  }
  line.offset[fixed] = wrapped;
  line.offset[other] = wrap_node(line.offset[other], 720);
}

// Reciprocity: (s, u, theta_v, theta_i) and (s, -u, theta_i, theta_v) are one measurement.
AffineLine exchanged(AffineLine line) {
  std::swap(line.offset[kThetaI], line.offset[kThetaV]);
  std::swap(line.slope[kThetaI], line.slope[kThetaV]);
  line.offset[kU] = -line.offset[kU];
  line.slope[kU] = -line.slope[kU];
  return line;
}

class ElevationGeometry final : public FrameGeometry {
 public:
  std::string_view name() const override { return "elevation"; }
  std::array<std::string_view, kAxisCount> axis_names() const override { return {"s", "u", "theta_v", "theta_i"}; }
  double node_period(std::size_t axis) const override { return axis <= kDiagonal ? 360 : 0; }
  double line_period(std::size_t axis, const Symmetries& symmetries) const override {
    if (axis > kDiagonal) return 0;
    return symmetries.isotropic ? 360 : 720;
  }
  double arc_scale(std::size_t axis) const override { return axis <= kDiagonal ? 0.5 : 1; }

  double share_served(std::size_t /*axis*/, std::span<const double> padded, double node) const override {
    const ServedRange range = served_range(padded, node);
    return range.end_deg - range.begin_deg;
  }

  Coordinates coordinates(const DirectionPair& pair) const override {
    double s = degrees_from_radians(pair.i.phi) + degrees_from_radians(pair.v.phi);
    double u = degrees_from_radians(pair.i.phi) - degrees_from_radians(pair.v.phi);
    double theta_i = degrees_from_radians(pair.i.theta);
    double theta_v = degrees_from_radians(pair.v.theta);
    // f(i,v) = f(v,i): one order for both, chosen without rounding so that both give the same bits.
    if (theta_i > theta_v) {
      std::swap(theta_i, theta_v);
      u = -u;
    } else if (theta_i == theta_v) {
      u = std::abs(u);
    }
    // At the pole only phi_v = (s - u) / 2 matters; u = 0 is where its ring was measured.
    if (theta_i == 0) {
      s -= u;
      u = 0;
    }
    const double turns = std::floor(u / 360);
    u -= 360 * turns;
    s = wrap(s - 360 * turns, 720);
    return {s, u, theta_v, theta_i};
  }

  DirectionPair directions(const Coordinates& x, double /*theta_max_deg*/) const override {
    return {direction_from_degrees(x[kThetaI], 0.5 * (x[kS] + x[kU])),
            direction_from_degrees(x[kThetaV], 0.5 * (x[kS] - x[kU]))};
  }

  std::span<const Merging> mergings() const override {
    static constexpr std::array<Merging, 2> kMergings = {Merging{kThetaI, kS, -1, 720}, Merging{kThetaV, kS, 1, 720}};
    return kMergings;
  }

  Images images(const AffineLine& line, const Symmetries& symmetries) const override {
    Images images;
    for (unsigned bits = 0; bits < 8; ++bits) {
      const bool exchange = (bits & 1U) != 0;
      const bool mirror_x = (bits & 2U) != 0;
      const bool mirror_y = (bits & 4U) != 0;
      if ((mirror_x && !symmetries.mirror_x) || (mirror_y && !symmetries.mirror_y)) continue;
      AffineLine image = exchange ? exchanged(line) : line;
      if (mirror_x) image = mirror_azimuths(image, 0);
      if (mirror_y) image = mirror_azimuths(image, 360);
      take_out_what_does_not_matter(image, symmetries.isotropic);
      wrap_azimuths(image, symmetries.isotropic);
      images.lines[images.count++] = image;
    }
    return images;
  }
};

std::vector<double> azimuths(double step_deg) {
  std::vector<double> nodes(static_cast<std::size_t>(std::lround(360 / step_deg)));
  for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k] = static_cast<double>(k) * step_deg;
  return nodes;
}

std::string degrees_text(double degrees) {
  std::string text = std::to_string(degrees);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " degrees";
}

Error placement_error(const std::string& what) { return usage_error("placement: " + what); }

}  // namespace

const FrameGeometry& elevation_geometry() {
  static const ElevationGeometry instance;
  return instance;
}

Result<FrameSpec> elevation_frame(double elevation_step_deg, double azimuth_step_deg, const Symmetries& symmetries,
                                  double theta_max_deg) {
  if (!(theta_max_deg > 0 && theta_max_deg <= 90)) return placement_error("theta_max must be in (0, 90] degrees");
  if (!(elevation_step_deg >= 0.5 && elevation_step_deg <= theta_max_deg)) {
    return placement_error("the elevation step must be between 0.5 degrees and theta_max, " +
                           degrees_text(theta_max_deg));
  }
  const double slices = 360 / azimuth_step_deg;
  if (!(azimuth_step_deg >= 1 && azimuth_step_deg <= 360) || std::abs(slices - std::round(slices)) > 1e-9) {
    return placement_error("the azimuth step must be between 1 and 360 degrees and divide 360");
  }
  std::vector<double> elevations = {0};
  for (int k = 1; k * elevation_step_deg < theta_max_deg - 1e-9; ++k) elevations.push_back(k * elevation_step_deg);
  elevations.push_back(theta_max_deg);
  std::vector<double> u = azimuths(azimuth_step_deg);
  std::vector<double> s = symmetries.isotropic ? std::vector<double>{0} : u;
  return elevation_frame_from_nodes(std::move(elevations), std::move(s), std::move(u), symmetries);
}

FrameSpec elevation_frame_from_nodes(std::vector<double> elevations_deg, std::vector<double> s_nodes_deg,
                                     std::vector<double> u_nodes_deg, const Symmetries& symmetries) {
  FrameSpec spec;
  spec.id = FrameId::kElevation;
  if (!elevations_deg.empty()) spec.theta_max_deg = elevations_deg.back();
  spec.axes[kS] = {"s", std::move(s_nodes_deg)};
  spec.axes[kU] = {"u", std::move(u_nodes_deg)};
  spec.axes[kThetaV] = {"theta_v", elevations_deg};
  spec.axes[kThetaI] = {"theta_i", std::move(elevations_deg)};
  spec.symmetries = symmetries;
  return spec;
}

}  // namespace sbrdf::internal
