#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sbrdf::internal {

/// A place among samples: at most four coordinates, those that are not used 0.
using SamplePlace = std::array<double, 4>;

/// A point that was found, and the square of its distance.
struct Neighbour {
  double square = 0;
  std::uint32_t point = 0;

  bool operator<(const Neighbour& other) const {
    return square < other.square || (square == other.square && point < other.point);
  }
};

/// Finds the points next to a place: a k-d tree. Immutable; several threads may ask at once.
class NearestPoints {
 public:
  /// At most 2^32 - 1 points, all finite.
  explicit NearestPoints(std::vector<SamplePlace> points);

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const SamplePlace& point(std::uint32_t index) const { return points_[index]; }

  static constexpr std::uint32_t kNoGroup = std::numeric_limits<std::uint32_t>::max();
  /// The `most` nearest points, or all where there are fewer, the nearest first; of those at the same distance the ones
  /// with the least index. Points of `group` are left out: `groups` has the group of each point, or is empty.
  void find(const SamplePlace& place, std::size_t most, std::vector<Neighbour>& found,
            std::span<const std::uint32_t> groups = {}, std::uint32_t group = kNoGroup) const;

 private:
  struct Node {
    std::uint32_t first = 0, count = 0;  ///< of order_
    std::uint32_t low = 0, high = 0;     ///< children; 0: a leaf
    std::uint8_t axis = 0;
    double split = 0;
  };
  struct Search;

  std::uint32_t build(std::uint32_t first, std::uint32_t count);
  void visit(std::uint32_t node, Search& search) const;

  std::vector<SamplePlace> points_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace sbrdf::internal
