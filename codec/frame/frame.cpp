#include "codec/frame/frame.h"

#include <cassert>
#include <cmath>

#include "codec/frame/frame_geometries.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMaxNodes = 4096;
constexpr double kLeastSpacingDeg = 1e-3;  // far above what node_units takes for one node

Error frame_error(const std::string& what) { return invalid_file("frame: " + what); }

Status check_axis(const Axis& axis, double node_period) {
  const auto& nodes = axis.nodes_deg;
  if (nodes.empty()) return frame_error("axis " + axis.name + " has no node");
  if (nodes.size() > kMaxNodes) {
    return frame_error("axis " + axis.name + " has " + std::to_string(nodes.size()) + " nodes; at most " +
                       std::to_string(kMaxNodes) + " are allowed");
  }
  const double end = node_period > 0 ? node_period : 90.0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const bool rising = k == 0 ? nodes[k] == 0 : nodes[k] >= nodes[k - 1] + kLeastSpacingDeg;
    const bool inside = node_period > 0 ? nodes[k] <= end - kLeastSpacingDeg : nodes[k] <= end;
    if (!rising || !inside) {  // also catches NaN
      return frame_error("axis " + axis.name + ", node " + std::to_string(k) + ": " + std::to_string(nodes[k]) +
                         " degrees; nodes must begin with 0, rise by 0.001 or more, and stay " +
                         (node_period > 0 ? "below " : "within ") + std::to_string(end));
    }
  }
  return ok_status();
}

// Files state it in hundredths.
Status check_theta_max(double theta_max_deg) {
  const bool hundredths = std::round(theta_max_deg * 100) / 100 == theta_max_deg;
  if (hundredths && theta_max_deg > 0 && theta_max_deg <= 90) return ok_status();
  return frame_error("theta_max is " + std::to_string(theta_max_deg) +
                     " degrees; it must be in (0, 90], in whole hundredths");
}

// Exchanging the directions turns u into 360 - u. Where the two elevations change places the value would jump if the
// cell on the other side were another one.
Status check_exchange(const Axis& axis) {
  const auto& nodes = axis.nodes_deg;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    if (node_units(nodes[nodes.size() - k]) == node_units(360 - nodes[k])) continue;
    return frame_error("axis " + axis.name + ", node " + std::to_string(k) + ": " + std::to_string(nodes[k]) +
                       " degrees has no counterpart at 360 degrees less that");
  }
  return ok_status();
}

}  // namespace

ServedRange served_range(std::span<const double> padded, double node_deg) {
  std::size_t k = 0;
  while (k + 1 < padded.size() && padded[k] < node_deg) ++k;
  if (k > 0 && node_deg - padded[k - 1] < padded[k] - node_deg) --k;
  return {k > 0 ? 0.5 * (padded[k - 1] + padded[k]) : padded[k],
          k + 1 < padded.size() ? 0.5 * (padded[k] + padded[k + 1]) : padded[k]};
}

const FrameGeometry* find_geometry(FrameId id) {
  switch (id) {
    case FrameId::kElevation:
      return &elevation_geometry();
    case FrameId::kHalfDifference:
      return &half_difference_geometry();
  }
  return nullptr;
}

const FrameGeometry& geometry(FrameId id) {
  const FrameGeometry* found = find_geometry(id);
  assert(found != nullptr);
  return *found;
}

Status check_frame(const FrameSpec& spec) {
  const FrameGeometry* frame = find_geometry(spec.id);
  if (frame == nullptr) {
    return unsupported("frame: unknown id " + std::to_string(static_cast<int>(spec.id)));
  }
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (Status status = check_axis(spec.axes[axis], frame->node_period(axis)); !status) return status;
  }
  if (spec.symmetries.isotropic && spec.axes[kAxial].nodes_deg.size() != 1) {
    return frame_error("an isotropic material has one node on axis " + spec.axes[kAxial].name);
  }
  if (spec.id == FrameId::kHalfDifference) return check_theta_max(spec.theta_max_deg);
  if (spec.axes[kHorizontal].nodes_deg != spec.axes[kVertical].nodes_deg) {
    return frame_error("theta_i and theta_v must have the same nodes");
  }
  if (spec.axes[kVertical].nodes_deg.back() != spec.theta_max_deg) {
    return frame_error("theta_max is not the last elevation");
  }
  return check_exchange(spec.axes[kDiagonal]);
}

}  // namespace sbrdf::internal
