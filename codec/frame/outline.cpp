#include "codec/frame/outline.h"

#include <cstddef>

namespace sbrdf::internal {
namespace {

// A list over [0, end] and its mirror image over [end, 2 end), the last node at 2 end being the first again.
std::vector<double> mirror_list(const std::vector<double>& list, double end) {
  std::vector<double> full = list;
  for (std::size_t k = list.size(); k-- > 0;) {
    const double image = 2 * end - list[k];
    if (image > full.back() + 1e-9 && image < 2 * end - 1e-9) full.push_back(image);
  }
  return full;
}

}  // namespace

double outline_end(FrameId id, std::size_t axis) {
  if (axis > kDiagonal) return 0;
  return id == FrameId::kElevation ? 180 : 90;
}

FrameSpec expand_outline(const FrameOutline& outline) {
  const auto& lists = outline.lists;
  const bool isotropic = outline.symmetries.isotropic;
  if (outline.id == FrameId::kElevation) {
    return elevation_frame_from_nodes(lists[kHorizontal],
                                      isotropic ? std::vector<double>{0} : mirror_list(lists[kAxial], 180),
                                      mirror_list(lists[kDiagonal], 180), outline.symmetries);
  }
  std::vector<double> phi_h = {0};
  if (!isotropic) {
    std::vector<double> half = mirror_list(lists[kAxial], 90);
    half.push_back(180);
    phi_h = mirror_list(half, 180);
  }
  return half_difference_frame(lists[kVertical], lists[kHorizontal], phi_h, mirror_list(lists[kDiagonal], 90),
                               outline.symmetries, outline.theta_max_deg);
}

}  // namespace sbrdf::internal
