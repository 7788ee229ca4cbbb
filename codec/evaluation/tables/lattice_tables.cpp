#include "codec/evaluation/tables/lattice_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBucketsForCell = 8;

bool is_azimuth(std::size_t axis) { return axis == kAxial || axis == kDiagonal; }

}  // namespace

/// Fills the tables of one lattice.
class LatticeTables::Maker {
 public:
  explicit Maker(LatticeTables& tables) : tables_(tables), longest_deg_(longest_period_deg(tables.frame)) {}

  void make(const Lattice& lattice) {
    tables_.corners = lattice.corners;
    tables_.corner_strides = lattice.corner_strides;
    add_axes(lattice.nodes);
    number_lines(lattice);
    for (const PoleRing& ring : pole_rings(lattice)) add_ring(ring);
    add_lanes();
    end();
  }

  void make(const std::array<std::vector<double>, kAxisCount>& nodes) {
    std::uint32_t stride = 1;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      tables_.corner_strides[axis] = stride;
      stride *= static_cast<std::uint32_t>(nodes[axis].size());
    }
    add_axes(nodes);
    add_corner_steps();
    end();
  }

 private:
  void end() { tables_.cells.resize(tables_.cells.size() + 1); }  // vectors are read from any cell on

  void add_axes(const std::array<std::vector<double>, kAxisCount>& all_nodes) {
    tables_.axial_stays = all_nodes[kAxial].size() < 2;
    for (std::uint32_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double>& nodes = all_nodes[axis];
      tables_.last_turn[axis] = polar_turn(std::min(nodes.back(), 90.0));
      if (is_azimuth(axis)) {
        const bool ends = nodes.size() > 1 && nodes.back() < longest_deg_;
        tables_.last_turn[axis] = ends ? azimuth_turn(nodes.back(), longest_deg_) : 0xFFFFFFFFU;
      }
      const TurnRule rule = turn_rule(tables_.frame, axis);
      tables_.turn_scale[axis] = rule.scale;
      tables_.turn_bias[axis] = rule.bias;
      tables_.turn_flip[axis] = rule.flip;
      std::vector<std::int32_t> places;
      for (const double node : nodes) places.push_back(is_azimuth(axis) ? azimuth_place(node) : polar_place(node));
      if (places.size() < 2) places = {0, kLastPlace};
      tables_.first_cell[axis] = static_cast<std::uint32_t>(tables_.cells.size());
      const PlaceSearch search = add_cells(places);
      tables_.first_bucket[axis] = search.first_bucket;
      tables_.bucket_shift[axis] = search.bucket_shift;
      if (nodes.size() > 1) tables_.axes.push_back(axis);
    }
  }

  // The end of a turn is 0 again, but the last place here.
  [[nodiscard]] std::int32_t azimuth_place(double degrees) const {
    return degrees >= longest_deg_ ? kLastPlace : place_of_turn(azimuth_turn(degrees, longest_deg_));
  }

  PlaceSearch add_cells(const std::vector<std::int32_t>& places) {
    const auto first = static_cast<std::uint32_t>(tables_.cells.size());
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      const bool last = k + 2 == places.size();
      const auto width = static_cast<float>(std::max(1, places[k + 1] - places[k]));
      tables_.cells.push_back({places[k], last ? kBeyond : places[k + 1], width});
    }
    std::vector<std::int32_t> begins(places.begin(), places.end() - 1);
    begins.push_back(kBeyond);
    const std::size_t first_new = tables_.cell_buckets.size();
    const PlaceSearch search = add_place_search(begins, 0, places.back(), kBucketsForCell, tables_.cell_buckets);
    for (std::size_t k = first_new; k < tables_.cell_buckets.size(); ++k) tables_.cell_buckets[k].first += first;
    return search;
  }

  void number_lines(const Lattice& lattice) {
    std::uint32_t number = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      tables_.first_line[axis] = number * kLineWords;
      for (std::size_t a = 0; a < kAxisCount; ++a) {
        tables_.line_strides[axis][a] = lattice.line_strides[axis][a] * kLineWords;
      }
      if (lattice.nodes[axis].size() > 1) number += static_cast<std::uint32_t>(lattice.lines[axis].size());
    }
    tables_.line_count = number;
    tables_.guide_line = number * kLineWords;
  }

  void add_ring(const PoleRing& from) {
    Ring ring;
    ring.polar_axis = static_cast<std::uint32_t>(from.merging.polar_axis);
    ring.ring_axis = static_cast<std::uint32_t>(from.merging.ring_axis);
    ring.other_azimuth = static_cast<std::uint32_t>(from.other_azimuth());
    ring.along = static_cast<std::uint32_t>(from.along);
    ring.difference = from.merging.sign < 0;
    ring.turn_shift = periods_log2(longest_deg_, from.merging.period_deg);
    std::vector<std::int32_t> places;
    for (const PoleRing::Node& node : from.nodes) {
      places.push_back(&node == &from.nodes.back()
                           ? kLastPlace
                           : place_of_turn(azimuth_turn(node.position_deg, longest_deg_) << ring.turn_shift));
      ring.node_tables.push_back({node.corner, tables_.first_line[from.along] + node.line * kLineWords});
    }
    ring.first_cell = static_cast<std::uint32_t>(tables_.cells.size());
    ring.search = add_cells(places);
    tables_.rings.push_back(std::move(ring));
  }

  void add_lanes() {
    const std::size_t moving = tables_.axes.size();
    const std::size_t along = lines_along(moving);
    for (std::size_t lane = 0; lane < moving * along; ++lane) {
      const std::uint32_t axis = tables_.axes[lane / along];
      const Strides& strides = tables_.line_strides[axis];
      tables_.lane_axis[lane] = axis;
      std::uint32_t first = tables_.first_line[axis];
      std::size_t bit = 0;
      for (std::size_t m = 0; m < moving; ++m) {
        const std::uint32_t stride = strides[tables_.axes[m]];  // 0 along the line itself
        tables_.lane_strides[tables_.axes[m]][lane] = stride;
        if (m == lane / along) continue;
        if ((lane % along >> bit & 1U) != 0) first += stride;
        ++bit;
      }
      tables_.lane_first[lane] = first;
    }
    for (std::size_t lane = moving * along; moving == 3 && lane < kLinesOfThree; ++lane) {
      tables_.lane_axis[lane] = kVertical;
      tables_.lane_first[lane] = tables_.guide_line;
    }
    add_corner_steps();
  }

  void add_corner_steps() {
    for (std::size_t corner = 0; corner < tables_.corner_steps.size(); ++corner) {
      for (std::size_t m = 0; m < tables_.axes.size(); ++m) {
        if ((corner >> m & 1U) != 0) tables_.corner_steps[corner] += tables_.corner_strides[tables_.axes[m]];
      }
    }
  }

  LatticeTables& tables_;
  double longest_deg_;
};

LatticeTables::LatticeTables(const Lattice& lattice) : frame(lattice.spec.id) { Maker(*this).make(lattice); }

LatticeTables::LatticeTables(FrameId id, const std::array<std::vector<double>, kAxisCount>& nodes) : frame(id) {
  Maker(*this).make(nodes);
}

std::size_t LatticeTables::bytes() const {
  std::size_t of_rings = 0;
  for (const Ring& ring : rings) of_rings += ring.node_tables.size() * sizeof(ring.node_tables[0]);
  return sizeof(LatticeTables) + of_rings + cells.size() * sizeof(Cell) + cell_buckets.size() * sizeof(PlaceBucket) +
         corners.size() * sizeof(std::uint32_t);
}

}  // namespace sbrdf::internal
