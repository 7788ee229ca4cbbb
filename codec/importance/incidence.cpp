#include "codec/importance/incidence.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "codec/importance/mirror_polar.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

std::optional<Incidence> Incidence::fold(const glm::dvec3& w_i, IncidenceSymmetry symmetry) {
  const double length = glm::length(w_i);
  if (!(w_i.z > 0) || !std::isfinite(length)) return std::nullopt;
  Incidence incidence;
  glm::dvec3 w = w_i / length;
  const double across = std::sqrt(w.x * w.x + w.y * w.y);
  if (symmetry == IncidenceSymmetry::kIsotropic && across > 0) {
    incidence.x_ = {w.x / across, w.y / across, 0};
    incidence.y_ = {-incidence.x_.y, incidence.x_.x, 0};
  }
  const bool behind = w.y < 0 || (w.y == 0 && w.x < 0);
  if (symmetry == IncidenceSymmetry::kHalfTurn && behind) {
    incidence.x_.x = -1;
    incidence.y_.y = -1;
  }
  if (symmetry == IncidenceSymmetry::kQuarter) {
    incidence.x_.x = w.x < 0 ? -1 : 1;
    incidence.y_.y = w.y < 0 ? -1 : 1;
  }
  w = incidence.to_table(w);
  if (symmetry == IncidenceSymmetry::kIsotropic) w.y = 0;
  w.z = std::max(w.z, MirrorPolar::kLeastHeight);
  incidence.w_i_ = glm::normalize(w);
  return incidence;
}

double Incidence::azimuth() const {
  const double azimuth = std::atan2(w_i_.y, w_i_.x);
  return azimuth < 0 ? azimuth + 2 * kPi : azimuth;
}

}  // namespace sbrdf::internal
