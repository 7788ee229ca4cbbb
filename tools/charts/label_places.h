#pragma once

#include <vector>

#include "tools/charts/svg.h"

namespace sbrdf::internal {

/// An upright rectangle of a picture [pixels].
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;
};

/// A square around a spot, `half` to each side.
[[nodiscard]] inline Box around(Spot centre, double half) {
  return {centre.x - half, centre.y - half, centre.x + half, centre.y + half};
}

/// Finds places for labels beside points, one after the other: the first of some around the point at which nothing else
/// is, or where least else is.
class LabelPlaces {
 public:
  /// Labels stay inside `bounds`.
  explicit LabelPlaces(const Box& bounds) : bounds_(bounds) {}

  /// Something stands here already.
  void keep_free(const Box& box) { taken_.push_back(box); }
  /// Where text of this width and size begins, on its base line. It is kept free from then on.
  [[nodiscard]] Spot place(Spot point, double width, double size);

 private:
  /// Area of a label that is covered or lies outside [pixels squared].
  [[nodiscard]] double lost_area(const Box& label) const;

  Box bounds_;
  std::vector<Box> taken_;
};

}  // namespace sbrdf::internal
