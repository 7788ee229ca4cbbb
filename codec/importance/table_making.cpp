// Makes the table: what a BRDF says at the corners of all cells of all nodes.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "codec/importance/grid_choice.h"
#include "codec/importance/importance_table.h"
#include "formats/core/directions.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {

namespace {

constexpr double kLeastCosineShare = 1.0 / 32;
constexpr double kLeastOfMean = 1e-4;  // of a cell or an azimuth: so much of the mean of all

/// A corner of cells, by the area of polar coordinates.
struct Corner {
  double light = 0;    ///< f_r cos theta_v
  double diffuse = 0;  ///< cos theta_v
  bool above = false;  ///< the horizon
};

/// A node, cell by cell.
struct Cells {
  std::vector<double> heights;  ///< mass by area; azimuth slow, ring fast
  std::vector<double> areas;    ///< above the horizon
  double mass = 0;
  double cosine_share = 1;
};

class NodeMaker {
 public:
  NodeMaker(const VectorBrdf& brdf, const ImportanceGrid& grid, const glm::dvec3& w_i)
      : grid_(grid), polar_(w_i, grid.stretch), closed_(grid.symmetry == IncidenceSymmetry::kIsotropic) {
    evaluate(brdf, w_i);
    for (std::size_t a = 0; a < grid_.azimuths; ++a) {
      const double horizon = polar_.horizon(heading(static_cast<double>(a) + 0.5));
      for (std::size_t r = 0; r < grid_.rings(); ++r) {
        const double above = std::min(grid_.radii[r + 1], horizon) - grid_.radii[r];
        areas_.push_back(std::max(above, 0.0) * grid_.azimuth_step() * (closed_ ? 2 : 1));
      }
    }
  }

  /// Of some levels of f_r that are left to the cosine, the one with the least variance.
  void write(std::span<float> node) const {
    Cells best;
    double least = std::numeric_limits<double>::infinity();
    for (const double level : levels()) {
      Cells cells = cells_above(level);
      const double variance = second_moment(cells);
      if (variance < least) {
        least = variance;
        best = std::move(cells);
      }
    }
    store(best, node);
  }

 private:
  [[nodiscard]] glm::dvec2 heading(double azimuths) const {
    const double angle = azimuths * grid_.azimuth_step();
    return {std::cos(angle), std::sin(angle)};
  }
  [[nodiscard]] std::size_t corner_azimuths() const { return grid_.azimuths + 1; }
  [[nodiscard]] const Corner& corner(std::size_t azimuth, std::size_t ring) const {
    return corners_[azimuth * grid_.radii.size() + ring];
  }
  [[nodiscard]] std::array<const Corner*, 4> corners_of(std::size_t azimuth, std::size_t ring) const {
    return {&corner(azimuth, ring), &corner(azimuth, ring + 1), &corner(azimuth + 1, ring),
            &corner(azimuth + 1, ring + 1)};
  }

  void evaluate(const VectorBrdf& brdf, const glm::dvec3& w_i) {
    corners_.resize(corner_azimuths() * grid_.radii.size());
    std::vector<glm::vec3> w_v;
    std::vector<std::size_t> places;
    const std::size_t own_azimuths = closed_ ? corner_azimuths() : grid_.azimuths;
    for (std::size_t a = 0; a < own_azimuths; ++a) {
      const glm::dvec2 along = heading(static_cast<double>(a));
      const double horizon = polar_.horizon(along);
      for (std::size_t r = 0; r < grid_.radii.size() && grid_.radii[r] < horizon; ++r) {
        const glm::dvec3 v = polar_.direction({along, grid_.radii[r]});
        if (!(v.z > 0)) break;
        Corner& corner = corners_[a * grid_.radii.size() + r];
        corner.diffuse = v.z / polar_.density(v);
        corner.above = true;
        places.push_back(a * grid_.radii.size() + r);
        w_v.emplace_back(v);
      }
    }
    weights_.resize(w_v.size());
    weigh(brdf, std::vector<glm::vec3>(w_v.size(), glm::vec3(w_i)), w_v, weights_);
    for (std::size_t k = 0; k < places.size(); ++k) {
      corners_[places[k]].light = weights_[k] * corners_[places[k]].diffuse;
    }
    if (closed_) return;
    std::copy_n(corners_.begin(), grid_.radii.size(),
                corners_.begin() + static_cast<std::ptrdiff_t>(grid_.azimuths * grid_.radii.size()));
  }

  /// Candidates for what of f_r is diffuse.
  [[nodiscard]] std::vector<double> levels() const {
    std::vector<double> sorted = weights_;
    std::sort(sorted.begin(), sorted.end());
    std::vector<double> levels = {0};
    if (sorted.empty()) return levels;
    for (const double share : {0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9}) {
      levels.push_back(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
    }
    return levels;
  }

  /// What is left above a level. The root of the mean square of the corners: among densities that are the same all over
  /// a cell the one with the least variance.
  [[nodiscard]] Cells cells_above(double level) const {
    Cells cells;
    cells.areas = areas_;
    for (std::size_t a = 0; a < grid_.azimuths; ++a) {
      double height = 0;
      for (std::size_t r = 0; r < grid_.rings(); ++r) {
        double squares = 0;
        double count = 0;
        for (const Corner* corner : corners_of(a, r)) {
          if (!corner->above) continue;
          const double rest = std::max(corner->light - level * corner->diffuse, 0.0);
          squares += rest * rest;
          ++count;
        }
        // Where all corners are below the horizon, what was last above it: a neighbouring node may see it.
        if (count > 0) height = std::sqrt(squares / count);
        cells.heights.push_back(height);
        cells.mass += height * cells.areas[a * grid_.rings() + r];
      }
    }
    const double diffuse = level * kPi;
    const double share = diffuse + cells.mass > 0 ? diffuse / (diffuse + cells.mass) : 1;
    cells.cosine_share = cells.mass > 0 ? std::max(share, kLeastCosineShare) : 1;
    return cells;
  }

  /// Of f_r cos / pdf, as the corners have it.
  [[nodiscard]] double second_moment(const Cells& cells) const {
    double sum = 0;
    const double table = cells.mass > 0 ? (1 - cells.cosine_share) / cells.mass : 0;
    for (std::size_t a = 0; a < grid_.azimuths; ++a) {
      for (std::size_t r = 0; r < grid_.rings(); ++r) {
        const std::size_t cell = a * grid_.rings() + r;
        double moment = 0;
        double count = 0;
        for (const Corner* corner : corners_of(a, r)) {
          if (!corner->above) continue;
          const double pdf = cells.cosine_share / kPi * corner->diffuse + table * cells.heights[cell];
          if (pdf > 0) moment += corner->light * corner->light / pdf;
          ++count;
        }
        if (count > 0) sum += moment / count * cells.areas[cell];
      }
    }
    return sum;
  }

  void store(const Cells& cells, std::span<float> node) const {
    node[0] = static_cast<float>(cells.cosine_share);
    std::vector<double> rows;
    for (std::size_t a = 0; a < grid_.azimuths; ++a) {
      const std::span heights = std::span(cells.heights).subspan(a * grid_.rings(), grid_.rings());
      const std::span areas = std::span(cells.areas).subspan(a * grid_.rings(), grid_.rings());
      rows.push_back(std::inner_product(heights.begin(), heights.end(), areas.begin(), 0.0));
      std::vector<double> masses;
      for (std::size_t r = 0; r < grid_.rings(); ++r) {
        masses.push_back(heights[r] * (grid_.radii[r + 1] - grid_.radii[r]));
      }
      accumulate(masses, node.subspan(1 + grid_.azimuths + a * grid_.rings(), grid_.rings()));
    }
    accumulate(rows, node.subspan(1, grid_.azimuths));
  }

  /// Sums up to each, with 1 in all; none is 0.
  static void accumulate(std::span<const double> masses, std::span<float> sums) {
    const auto count = static_cast<double>(masses.size());
    const double all = std::accumulate(masses.begin(), masses.end(), 0.0);
    const double least = all > 0 ? kLeastOfMean * all / count : 1;
    double whole = 0;
    for (const double mass : masses) whole += std::max(mass, least);
    double sum = 0;
    for (std::size_t k = 0; k < masses.size(); ++k) {
      sum += std::max(masses[k], least);
      sums[k] = static_cast<float>(sum / whole);
    }
    sums.back() = 1;
  }

  const ImportanceGrid& grid_;
  MirrorPolar polar_;
  bool closed_;  ///< the azimuths do not run around
  std::vector<Corner> corners_;
  std::vector<double> weights_;  ///< f_r of those above the horizon
  std::vector<double> areas_;
};

}  // namespace

ImportanceTable make_importance_table(const VectorBrdf& brdf) {
  const ImportanceGrid grid = choose_importance_grid(brdf);
  std::vector<float> nodes(grid.nodes() * grid.node_size());
  parallel_for(grid.nodes(), [&](std::uint64_t node) {
    const double cosine = grid.cosines[node % grid.cosines.size()];
    const double azimuth = grid.azimuth_i_step() * static_cast<double>(node / grid.cosines.size());
    const glm::dvec3 w_i = vector_from_direction({std::acos(cosine), azimuth});
    NodeMaker(brdf, grid, w_i).write(std::span(nodes).subspan(node * grid.node_size(), grid.node_size()));
  });
  return {grid, std::move(nodes)};
}

}  // namespace sbrdf::internal
