#include "codec/importance/importance_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {

namespace {

constexpr double kBelowOne = 1 - 0x1p-53;
constexpr float kLeastDrawnHeight = 1e-6F;  // z of a direction that rounding would leave on the horizon

double unit_interval(double u) { return u > 0 ? std::min(u, kBelowOne) : 0.0; }

// P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and Square", 1997: what lies close stays close.
glm::dvec3 cosine_direction(const glm::dvec2& u) {
  const double x = 2 * u.x - 1;
  const double y = 2 * u.y - 1;
  const bool flat = std::abs(x) > std::abs(y);
  const double radius = flat ? x : y;
  if (radius == 0) return {0, 0, 1};
  const double angle = flat ? kPi / 4 * (y / x) : kPi / 2 - kPi / 4 * (x / y);
  return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - radius * radius)};
}

}  // namespace

double ImportanceGrid::azimuth_step() const {
  return (symmetry == IncidenceSymmetry::kIsotropic ? kPi : 2 * kPi) / static_cast<double>(azimuths);
}

double ImportanceGrid::azimuth_i_step() const {
  const auto count = static_cast<double>(azimuths_i);
  switch (symmetry) {
    case IncidenceSymmetry::kNone:
      return 2 * kPi / count;
    case IncidenceSymmetry::kHalfTurn:
      return kPi / count;
    case IncidenceSymmetry::kQuarter:
      return kPi / 2 / (count - 1);
    case IncidenceSymmetry::kIsotropic:
      break;
  }
  return 2 * kPi;
}

/// A sum of at most four nodes.
struct ImportanceTable::Blend {
  struct Part {
    const float* marginal = nullptr;  ///< up to the end of each azimuth
    const float* rings = nullptr;     ///< of an azimuth, up to the end of each ring
    double weight = 0;
  };
  std::array<Part, 4> parts;
  std::size_t count = 0;
  double cosine_share = 0;

  [[nodiscard]] std::span<const Part> used() const { return std::span(parts).first(count); }

  /// What lies up to the end of an azimuth, by the table alone.
  [[nodiscard]] double up_to(std::size_t azimuth) const {
    double sum = 0;
    for (const Part& part : used()) sum += part.weight * static_cast<double>(part.marginal[azimuth]);
    return sum;
  }
};

namespace {

/// One azimuth of a blend, each of whose nodes ends at the horizon.
struct Row {
  struct Part {
    const float* rings = nullptr;
    double weight = 0;  ///< so that all of them up to the horizon make the azimuth's mass
  };
  std::array<Part, 4> parts;
  std::size_t count = 0;
  double mass = 0;
  std::size_t last = 0;  ///< the ring that the horizon lies in

  [[nodiscard]] double up_to(std::size_t ring) const {
    double sum = 0;
    for (const Part& part : std::span(parts).first(count)) sum += part.weight * static_cast<double>(part.rings[ring]);
    return sum;
  }
};

/// The least k in [0, last] for which `is_behind(k)`, true from some k on; `last` where it is true of none. Always
/// takes as many steps, without branches, which nobody could foresee.
template <class IsBehind>
std::size_t first_behind(std::size_t last, const IsBehind& is_behind) {
  std::size_t at = 0;
  for (std::size_t left = last; left > 0;) {
    const std::size_t half = (left + 1) / 2;
    at += is_behind(at + half - 1) ? 0 : half;
    left -= half;
  }
  return at;
}

std::size_t ring_of(const std::vector<double>& radii, double radius) {
  return first_behind(radii.size() - 2, [&](std::size_t ring) { return radii[ring + 1] > radius; });
}

double up_to_radius(const float* rings, std::size_t ring, double share) {
  const double before = ring == 0 ? 0.0 : static_cast<double>(rings[ring - 1]);
  return before + share * (static_cast<double>(rings[ring]) - before);
}

/// Where a radius lies in its ring.
double share_of(const std::vector<double>& radii, std::size_t ring, double radius) {
  return (radius - radii[ring]) / (radii[ring + 1] - radii[ring]);
}

template <class Part>
Row row_of(std::span<const Part> parts, const ImportanceGrid& grid, std::size_t azimuth, double horizon) {
  Row row;
  row.last = ring_of(grid.radii, horizon);
  const double share = share_of(grid.radii, row.last, horizon);
  for (const Part& part : parts) {
    const double before = azimuth == 0 ? 0.0 : static_cast<double>(part.marginal[azimuth - 1]);
    const double mass = part.weight * (static_cast<double>(part.marginal[azimuth]) - before);
    const float* rings = part.rings + azimuth * grid.rings();
    row.parts[row.count++] = {rings, mass / up_to_radius(rings, row.last, share)};
    row.mass += mass;
  }
  return row;
}

}  // namespace

ImportanceTable::ImportanceTable(ImportanceGrid grid, std::vector<float> nodes)
    : grid_(std::move(grid)), nodes_(std::move(nodes)) {
  assert(nodes_.size() == grid_.nodes() * grid_.node_size());
}

std::size_t ImportanceTable::bytes() const {
  return sizeof(*this) + nodes_.capacity() * sizeof(float) +
         (grid_.cosines.capacity() + grid_.radii.capacity()) * sizeof(double);
}

ImportanceTable::Blend ImportanceTable::blend(const Incidence& incidence) const {
  const std::vector<double>& cosines = grid_.cosines;
  const double cosine = incidence.w_i().z;
  const std::size_t theta = first_behind(cosines.size() - 2, [&](std::size_t k) { return cosines[k + 1] < cosine; });
  const double t = std::clamp((cosines[theta] - cosine) / (cosines[theta] - cosines[theta + 1]), 0.0, 1.0);
  std::size_t phi = 0;
  double p = 0;
  if (grid_.azimuths_i > 1) {
    const double at = incidence.azimuth() / grid_.azimuth_i_step();
    phi = std::min(static_cast<std::size_t>(at), grid_.azimuths_i - 1);
    p = std::clamp(at - static_cast<double>(phi), 0.0, 1.0);
  }
  Blend blend;
  for (const auto& [phi_at, phi_weight] : {std::pair{phi, 1 - p}, std::pair{(phi + 1) % grid_.azimuths_i, p}}) {
    for (const auto& [theta_at, theta_weight] : {std::pair{theta, 1 - t}, std::pair{theta + 1, t}}) {
      const double weight = phi_weight * theta_weight;
      if (weight == 0) continue;
      const float* node = nodes_.data() + (phi_at * cosines.size() + theta_at) * grid_.node_size();
      blend.parts[blend.count++] = {node + 1, node + 1 + grid_.azimuths, weight};
      blend.cosine_share += weight * static_cast<double>(node[0]);
    }
  }
  return blend;
}

PolarPlace ImportanceTable::draw(const Blend& blend, const MirrorPolar& polar, const glm::dvec2& u) const {
  const std::size_t last = grid_.azimuths - 1;
  const double at = u.x * blend.up_to(last);
  const std::size_t azimuth = first_behind(last, [&](std::size_t k) { return blend.up_to(k) > at; });
  const double before = azimuth == 0 ? 0.0 : blend.up_to(azimuth - 1);
  const double turned = unit_interval((at - before) / (blend.up_to(azimuth) - before));
  const double angle = (static_cast<double>(azimuth) + turned) * grid_.azimuth_step();
  const glm::dvec2 heading(std::cos(angle), std::sin(angle));
  const double horizon = polar.horizon(heading);
  const Row row = row_of(blend.used(), grid_, azimuth, horizon);
  const double along = u.y * row.mass;
  const std::size_t ring = first_behind(row.last, [&](std::size_t k) { return row.up_to(k) > along; });
  const double inner = ring == 0 ? 0.0 : row.up_to(ring - 1);
  const double part = unit_interval((along - inner) / (row.up_to(ring) - inner));
  const double radius = grid_.radii[ring] + part * (grid_.radii[ring + 1] - grid_.radii[ring]);
  return {heading, std::min(radius, horizon)};
}

double ImportanceTable::table_pdf(const Blend& blend, const MirrorPolar& polar, const glm::dvec3& w_v) const {
  const bool halved = grid_.symmetry == IncidenceSymmetry::kIsotropic;
  const PolarPlace place = polar.place(w_v);
  double angle = std::atan2(place.heading.y, place.heading.x);
  if (angle < 0) angle = halved ? -angle : angle + 2 * kPi;
  const double step = grid_.azimuth_step();
  const std::size_t azimuth = std::min(static_cast<std::size_t>(angle / step), grid_.azimuths - 1);
  const Row row = row_of(blend.used(), grid_, azimuth, polar.horizon(place.heading));
  const std::size_t ring = std::min(ring_of(grid_.radii, place.radius), row.last);
  const double mass = row.up_to(ring) - (ring == 0 ? 0.0 : row.up_to(ring - 1));
  const double area = step * (grid_.radii[ring + 1] - grid_.radii[ring]);
  return (halved ? 0.5 : 1.0) * mass / area * polar.density(w_v);
}

double ImportanceTable::density(const Blend& blend, const MirrorPolar& polar, const glm::dvec3& w_v) const {
  const double length = glm::length(w_v);
  if (!(w_v.z > 0) || !std::isfinite(length)) return 0;
  const glm::dvec3 w = w_v / length;
  const double cosine = blend.cosine_share * w.z / kPi;
  if (blend.cosine_share >= 1) return cosine;
  return cosine + (1 - blend.cosine_share) * table_pdf(blend, polar, w);
}

float ImportanceTable::pdf(const glm::vec3& w_i, const glm::vec3& w_v) const {
  const std::optional<Incidence> incidence = Incidence::fold(w_i, grid_.symmetry);
  if (!incidence) return 0;
  const MirrorPolar polar(incidence->w_i(), grid_.stretch);
  return static_cast<float>(density(blend(*incidence), polar, incidence->to_table(w_v)));
}

DrawnDirection ImportanceTable::sample(const glm::vec3& w_i, const glm::dvec2& u) const {
  const std::optional<Incidence> incidence = Incidence::fold(w_i, grid_.symmetry);
  if (!incidence) return {};
  const Blend around = blend(*incidence);
  const MirrorPolar polar(incidence->w_i(), grid_.stretch);
  glm::dvec2 left(unit_interval(u.x), unit_interval(u.y));
  glm::dvec3 w_v;
  if (left.x < around.cosine_share) {
    w_v = cosine_direction({left.x / around.cosine_share, left.y});
  } else {
    left.x = unit_interval((left.x - around.cosine_share) / (1 - around.cosine_share));
    const bool halved = grid_.symmetry == IncidenceSymmetry::kIsotropic;
    const bool other_side = halved && left.x >= 0.5;
    if (halved) left.x = unit_interval(2 * (other_side ? 1 - left.x : left.x));
    w_v = polar.direction(draw(around, polar, left));
    if (other_side) w_v.y = -w_v.y;
  }
  DrawnDirection drawn = {glm::vec3(incidence->from_table(w_v)), 0};
  drawn.w_v.z = std::max(drawn.w_v.z, kLeastDrawnHeight);
  // Of the direction as it was rounded, so that whoever asks for its density later is told the same.
  drawn.pdf = static_cast<float>(density(around, polar, incidence->to_table(drawn.w_v)));
  return drawn;
}

}  // namespace sbrdf::internal
