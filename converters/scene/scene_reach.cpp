#include "converters/scene/scene_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "codec/atlas/part/reached_cells.h"
#include "formats/core/directions.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr double kPiece = 1.5;  // degrees from the middle of a piece to its corners, as directions of its frame turn
constexpr double kBent = 1.2;   // how much more they may turn between corner and corner
constexpr int kMostSplits = 9;
constexpr std::size_t kMostPieces = std::size_t{1} << 20U;
constexpr double kBin = 3;  // degrees: places that are seen alike count once

/// A piece of a surface that a camera sees: how, and how far directions in its frame turn on it [degrees].
struct Piece {
  SurfacePoint middle;
  std::array<SurfacePoint, 4> corners;
  glm::dvec3 view{};  ///< towards the camera, in the frame of the middle
  double turned = 0;
};

double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  return degrees_from_radians(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

/// From the middle of `piece` to its corners, how far a direction of the world turns in their frames.
template <class DirectionAt>
double turned(const Piece& piece, const DirectionAt& direction_at) {
  const glm::dvec3 middle = piece.middle.local(direction_at(piece.middle));
  double most = 0;
  for (const SurfacePoint& corner : piece.corners) {
    most = std::max(most, degrees_between(middle, corner.local(direction_at(corner))));
  }
  return most;
}

glm::dvec3 to_light(const SceneLight& light, const SurfacePoint& point) {
  return light.far ? light.at : unit_or(light.at - point.position, point.normal);
}

/// Splits surfaces until they hardly turn.
class Pieces {
 public:
  Pieces(const Scene& scene, const SceneCamera& camera, std::vector<Piece>& pieces, ProgressCounter& looks)
      : scene_(scene), camera_(camera), pieces_(pieces), looks_(looks) {}

  /// False where there are too many, or the work should stop.
  bool add(const Patch& patch, int splits = 0) {
    if (!looks_.advance()) return false;
    const Piece piece = look_at(patch);
    if (!is_in_view(piece) || faces_away(piece)) return true;
    if (piece.turned <= kPiece || splits == kMostSplits) {
      pieces_.push_back(piece);
      return pieces_.size() <= kMostPieces;
    }
    const std::array<Patch, 4> quarters = patch.split();
    return std::all_of(quarters.begin(), quarters.end(),
                       [&](const Patch& quarter) { return add(quarter, splits + 1); });
  }

 private:
  [[nodiscard]] Piece look_at(const Patch& patch) const {
    Piece piece;
    piece.middle = patch.at(0.5, 0.5);
    piece.corners = {patch.at(0, 0), patch.at(1, 0), patch.at(0, 1), patch.at(1, 1)};
    const auto view = [&](const SurfacePoint& point) {
      return unit_or(camera_.position - point.position, point.normal);
    };
    piece.view = piece.middle.local(view(piece.middle));
    piece.turned = turned(piece, view);
    for (const SceneLight& light : scene_.lights) {
      piece.turned = std::max(piece.turned, turned(piece, [&](const SurfacePoint& p) { return to_light(light, p); }));
    }
    if (scene_.environment) {
      piece.turned = std::max({piece.turned, turned(piece, [&](const SurfacePoint&) { return piece.middle.normal; }),
                               turned(piece, [&](const SurfacePoint&) { return piece.middle.tangent; })});
    }
    return piece;
  }

  // Whether a ball about the piece reaches into the pyramid that the camera sees.
  [[nodiscard]] bool is_in_view(const Piece& piece) const {
    double radius = 0;
    for (const SurfacePoint& corner : piece.corners) {
      radius = std::max(radius, kBent * glm::length(corner.position - piece.middle.position));
    }
    const glm::dvec3 way = piece.middle.position - camera_.position;
    const double ahead = glm::dot(way, camera_.forward);
    const auto within = [&](double aside, double tangent) {
      return (std::abs(aside) - ahead * tangent) / std::sqrt(1 + tangent * tangent) <= radius;
    };
    return ahead >= -radius && within(glm::dot(way, camera_.right), camera_.tan_half_width) &&
           within(glm::dot(way, camera_.up), camera_.tan_half_height);
  }

  [[nodiscard]] static bool faces_away(const Piece& piece) {
    return degrees_between(piece.view, {0, 0, 1}) > 90 + kBent * piece.turned;
  }

  const Scene& scene_;
  const SceneCamera& camera_;
  std::vector<Piece>& pieces_;
  ProgressCounter& looks_;
};

/// What the cells of a piece depend on, in bins of kBin degrees: pieces that agree count once.
using Key = std::array<int, 9>;

Key key_of(const Piece& piece, bool with_frame) {
  const auto bin = [](double x) { return static_cast<int>(std::lround(x / radians_from_degrees(kBin))); };
  const glm::dvec3& v = piece.view;
  Key key = {bin(v.x), bin(v.y), bin(v.z)};
  if (!with_frame) return key;
  const SurfacePoint& m = piece.middle;
  return {key[0],          key[1],           key[2],           bin(m.normal.x), bin(m.normal.y),
          bin(m.normal.z), bin(m.tangent.x), bin(m.tangent.y), bin(m.tangent.z)};
}

DirectionPair pair_of(glm::dvec3 w_i, glm::dvec3 w_v) {
  w_i.z = std::max(w_i.z, 0.0);
  w_v.z = std::max(w_v.z, 0.0);
  return {direction_from_vector(w_i), direction_from_vector(w_v)};
}

class SceneReach {
 public:
  SceneReach(const Scene& scene, const AtlasLayout& axes) : scene_(scene), axes_(axes), found_(cell_counts(axes)) {}

  Result<AtlasCells> find(const Progress& progress) {
    StepwiseProgress steps(progress);
    std::vector<Piece> pieces;
    if (Status cut = cut_up(steps.step(kShareOfCutting), pieces); !cut) return cut.error();
    drop_repeated(pieces);
    ProgressCounter counter(steps.step(1), pieces.size());
    parallel_blocks(pieces.size(), kBlock, [&](std::size_t first, std::size_t size) {
      if (counter.stopped()) return;
      ReachedCells reach(axes_);
      for (std::size_t k = first; k < first + size && counter.advance(); ++k) add(pieces[k], reach);
      const std::scoped_lock lock(mutex_);
      found_.add_all(reach.cells());
    });
    if (counter.stopped()) return interrupted_error();
    if (found_.size() == 0) return usage_error("the scene has no place that a camera sees and light reaches");
    return std::move(found_);
  }

 private:
  static constexpr std::size_t kBlock = 64;
  static constexpr double kShareOfCutting = 0.3;

  Status cut_up(const Progress& progress, std::vector<Piece>& pieces) const {
    ProgressCounter looks(progress, kMostPieces + kMostPieces / 3);
    for (const SceneCamera& camera : scene_.cameras) {
      Pieces seen(scene_, camera, pieces, looks);
      for (const Patch& patch : scene_.patches) {
        if (seen.add(patch)) continue;
        if (looks.stopped()) return interrupted_error();
        return unsupported("the scene has more than a million pieces of surface in view");
      }
    }
    return ok_status();
  }

  // Only an environment makes each piece dear, and only what it leaves dark makes the frame matter.
  void drop_repeated(std::vector<Piece>& pieces) const {
    if (!scene_.environment || !scene_.lights.empty()) return;
    const bool with_frame = !scene_.environment->everywhere();
    std::set<Key> keys;
    std::vector<Piece> kept;
    for (Piece& piece : pieces) {
      // Under light from everywhere an isotropic material does not tell azimuths of the view apart.
      if (!with_frame && axes_.symmetries.isotropic) {
        piece.view = {std::hypot(piece.view.x, piece.view.y), 0, piece.view.z};
      }
      if (!keys.insert(key_of(piece, with_frame)).second) continue;
      piece.turned += kBin;
      kept.push_back(piece);
    }
    pieces = std::move(kept);
  }

  void add(const Piece& piece, ReachedCells& reach) const {
    const double margin = kBent * std::min(piece.turned, kPiece + kBin);
    const auto add_light = [&](const glm::dvec3& light, double spread) {
      if (degrees_between(light, {0, 0, 1}) <= 90 + margin + spread)
        reach.add(pair_of(light, piece.view), margin + spread);
    };
    for (const SceneLight& light : scene_.lights) add_light(piece.middle.local(to_light(light, piece.middle)), 0);
    if (!scene_.environment) return;
    const Environment& sky = *scene_.environment;
    // From the middle of a cell to its corner.
    const double spread = 0.71 * 360 / sky.width;
    for (std::uint32_t row = 0; row < sky.height; ++row) {
      for (std::uint32_t column = 0; column < sky.width; ++column) {
        if (sky.lit[std::size_t{row} * sky.width + column])
          add_light(piece.middle.local(sky.direction(column, row)), spread);
      }
    }
  }

  const Scene& scene_;
  const AtlasLayout& axes_;
  AtlasCells found_;
  std::mutex mutex_;
};

}  // namespace

Result<AtlasCells> reach_of_scene(const Scene& scene, const AtlasLayout& axes, const Progress& progress) {
  return SceneReach(scene, axes).find(progress);
}

}  // namespace sbrdf::internal
