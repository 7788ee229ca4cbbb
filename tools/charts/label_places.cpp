#include "tools/charts/label_places.h"

#include <algorithm>
#include <array>
#include <limits>

namespace sbrdf::internal {
namespace {

constexpr double kGap = 8;       // from the point to the label [pixels]
constexpr double kAscent = 0.8;  // of the size, above the base line

double area(const Box& box) { return std::max(box.right - box.left, 0.0) * std::max(box.bottom - box.top, 0.0); }

double overlap(const Box& a, const Box& b) {
  return area(
      {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right), std::min(a.bottom, b.bottom)});
}

}  // namespace

double LabelPlaces::lost_area(const Box& label) const {
  double lost = area(label) - overlap(label, bounds_);
  for (const Box& box : taken_) lost += overlap(label, box);
  return lost;
}

Spot LabelPlaces::place(Spot point, double width, double size) {
  // From the point to the middle of the label, in units of its half size and the gap.
  constexpr std::array<Spot, 12> kSides = {
      {{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}, {1, -2}, {1, 2}, {-1, -2}, {-1, 2}}};
  Box best{};
  double least = std::numeric_limits<double>::infinity();
  for (const Spot& side : kSides) {
    const Spot middle = {point.x + side.x * (width / 2 + kGap), point.y + side.y * (size / 2 + kGap)};
    const Box label = {middle.x - width / 2, middle.y - size / 2, middle.x + width / 2, middle.y + size / 2};
    const double lost = lost_area(label);
    if (lost >= least) continue;
    least = lost;
    best = label;
  }
  keep_free(best);
  return {best.left, best.top + kAscent * size + (1 - kAscent) * size / 2};
}

}  // namespace sbrdf::internal
