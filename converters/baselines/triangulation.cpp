#include "converters/baselines/triangulation.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFU;
constexpr std::size_t kStartSide = 64;   // cells of the grid of starts along x and along y
constexpr double kLeastWeight = -1e-12;  // on a side, to rounding
constexpr double kLost = 1e-6;           // of the weight of a direction where it is
constexpr double kLeastVolume = 1e-12;   // of a triangle's three directions: thinner ones have no inside

/// Where the library complains at length, which nobody reads: Triangulation::make says what is wrong.
class Complaints {
 public:
  Complaints() : file_(open_memstream(&text_, &size_)) {}
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  ~Complaints() {
    if (file_ != nullptr) std::fclose(file_);
    std::free(text_);  // NOLINT: as open_memstream asks for
  }
  [[nodiscard]] FILE* file() { return file_ == nullptr ? stderr : file_; }

 private:
  char* text_ = nullptr;
  std::size_t size_ = 0;
  FILE* file_;
};

/// The library's state, which is a C structure with a life of its own.
class Hull {
 public:
  Hull() { qh_zero(&qhull_, complaints_.file()); }
  Hull(const Hull&) = delete;
  Hull& operator=(const Hull&) = delete;
  ~Hull() {
    int kept = 0;
    int bytes = 0;
    qh_freeqhull(&qhull_, !qh_ALL);
    qh_memfreeshort(&qhull_, &kept, &bytes);
  }

  /// All facets as triangles, in any order and either way round; none where there is no hull.
  [[nodiscard]] std::vector<Triangle> facets(const std::vector<glm::dvec3>& points) {
    std::vector<coordT> coordinates;
    for (const glm::dvec3& w : points) coordinates.insert(coordinates.end(), {w.x, w.y, w.z});
    std::string command = "qhull Qt";  // facets of more than three corners are cut into triangles
    if (qh_new_qhull(&qhull_, 3, static_cast<int>(points.size()), coordinates.data(), False, command.data(), nullptr,
                     complaints_.file()) != 0) {
      return {};
    }
    std::vector<Triangle> triangles;
    for (const facetT* facet = qhull_.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[k].p);
        triangle[k] = static_cast<std::uint32_t>(qh_pointid(&qhull_, vertex->point));
      }
      triangles.push_back(triangle);
    }
    return triangles;
  }

 private:
  Complaints complaints_;
  qhT qhull_;
};

std::size_t start_cell(const glm::dvec3& w) {
  const double half = static_cast<double>(kStartSide) / 2;
  const glm::dvec2 at = glm::clamp(half * (glm::dvec2(w) + 1.0), 0.0, static_cast<double>(kStartSide) - 1);
  return static_cast<std::size_t>(at.y) * kStartSide + static_cast<std::size_t>(at.x);
}

std::size_t least_of(const glm::dvec3& v) {
  if (v.x <= v.y && v.x <= v.z) return 0;
  return v.y <= v.z ? 1 : 2;
}

double component(const glm::dvec3& v, std::size_t k) { return v[static_cast<glm::length_t>(k)]; }

}  // namespace

Result<Triangulation> Triangulation::make(const UniformScheme& scheme) {
  if (scheme.rings.size() < 2) return unsupported("a scheme of one direction has no triangles");
  Triangulation made;
  made.directions_ = scheme_directions(scheme);
  made.rim_ = static_cast<std::uint32_t>(made.directions_.size() - scheme.rings.back().count);
  const std::vector<glm::dvec3>& at = made.directions_;
  Hull hull;
  for (Triangle t : hull.facets(at)) {
    if (std::all_of(t.begin(), t.end(), [&](std::uint32_t k) { return k >= made.rim_; })) continue;  // of the base
    const double volume = glm::dot(at[t[0]], glm::cross(at[t[1]], at[t[2]]));
    if (std::abs(volume) < kLeastVolume) continue;
    if (volume < 0) std::swap(t[1], t[2]);
    made.triangles_.push_back(t);
    made.weights_of_.push_back(glm::inverse(glm::dmat3(at[t[0]], at[t[1]], at[t[2]])));
  }
  // Euler's formula says how many triangles make a disc of all directions; and each direction must be met whole.
  const bool disc = made.triangles_.size() == 2 * at.size() - scheme.rings.back().count - 2;
  if (disc) {
    made.find_neighbours();
    made.find_starts();
    if (made.meets_all_directions()) return made;
  }
  return unsupported(
      fmt::format("scheme {} cannot be triangulated: some of its directions lie outside the polygon of "
                  "its last ring, which has too few, or too near to each other",
                  scheme.name));
}

bool Triangulation::meets_all_directions() const {
  for (std::uint32_t k = 0; k < directions_.size(); ++k) {
    const Place place = place_of(directions_[k]);
    double weight = 0;
    for (std::size_t c = 0; c < 3; ++c) weight += place.triangle[c] == k ? place.weights[c] : 0;
    if (weight < 1 - kLost) return false;
  }
  return true;
}

void Triangulation::find_neighbours() {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> by_side;  // from direction to direction
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& corners = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) by_side[{corners[(k + 1) % 3], corners[(k + 2) % 3]}] = t;
  }
  for (const Triangle& corners : triangles_) {
    std::array<std::uint32_t, 3> beyond{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = by_side.find({corners[(k + 2) % 3], corners[(k + 1) % 3]});
      beyond[k] = found == by_side.end() ? kNone : found->second;
    }
    neighbours_.push_back(beyond);
  }
}

void Triangulation::find_starts() {
  starts_.resize(kStartSide * kStartSide);
  std::uint32_t last = 0;
  for (std::size_t cell = 0; cell < starts_.size(); ++cell) {
    const double half = static_cast<double>(kStartSide) / 2;
    const glm::dvec2 at = (glm::dvec2(cell % kStartSide, cell / kStartSide) + 0.5) / half - 1.0;
    const double flat = glm::dot(at, at);
    if (flat >= 1) continue;
    glm::dvec3 weights;
    const std::uint32_t found = walk(last, {at.x, at.y, std::sqrt(1 - flat)}, weights);
    if (found != kNone) last = found;
    starts_[cell] = last;
  }
}

// From triangle to triangle, through the side that the place lies farthest beyond. In a Delaunay triangulation no such
// walk comes back to where it was, but for rounding: hence the limit. kNone beyond the rim.
std::uint32_t Triangulation::walk(std::uint32_t from, const glm::dvec3& w, glm::dvec3& weights) const {
  for (std::size_t step = 0; step <= triangles_.size(); ++step) {
    weights = weights_of_[from] * w;
    const std::size_t side = least_of(weights);
    if (component(weights, side) >= kLeastWeight) return from;
    const std::uint32_t next = neighbours_[from][side];
    if (next == kNone) return kNone;
    from = next;
  }
  weights = weights_of_[from] * w;
  return from;  // as near as rounding lets it come
}

Place Triangulation::place_of(const glm::dvec3& w) const {
  const glm::dvec3 unit = glm::normalize(w);
  glm::dvec3 weights;
  const std::uint32_t found = walk(starts_[start_cell(unit)], unit, weights);
  if (found == kNone) return place_on_rim(unit);
  weights = glm::max(weights, glm::dvec3(0));
  weights /= weights.x + weights.y + weights.z;
  return {triangles_[found], {weights.x, weights.y, weights.z}};
}

Place Triangulation::place_on_rim(const glm::dvec3& w) const {
  const auto count = static_cast<std::uint32_t>(directions_.size()) - rim_;
  const double turn = std::atan2(w.y, w.x) / (2 * kPi);
  const double at = (turn - std::floor(turn)) * static_cast<double>(count);
  const std::uint32_t first = rim_ + std::min(static_cast<std::uint32_t>(at), count - 1);
  const std::uint32_t second = rim_ + (first - rim_ + 1) % count;
  const auto across = [](const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.y - a.y * b.x; };
  const double to_first = std::max(0.0, across(w, directions_[second]));
  const double to_second = std::max(0.0, across(directions_[first], w));
  const double sum = to_first + to_second;
  if (!(sum > 0)) return {{first, first, first}, {1, 0, 0}};
  return {{first, second, first}, {to_first / sum, to_second / sum, 0}};
}

}  // namespace sbrdf::internal
