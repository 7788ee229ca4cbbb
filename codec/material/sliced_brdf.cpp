#include "codec/material/sliced_brdf.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {
namespace {

Status check_finite(std::span<const float> values, const char* name) {
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == values.end()) return ok_status();
  return invalid_file(std::string(name) + " " + std::to_string(bad - values.begin()) + " is not finite");
}

Status check_sizes(const SlicedBrdf& sliced, const Lattice& lattice) {
  if (sliced.channels.empty() || sliced.channels.size() > kMaxChannels) {
    return invalid_file(std::to_string(sliced.channels.size()) + " channels; 1 to 4096 can be stored");
  }
  if (sliced.metadata.size() > kMaxMetadataSize) return invalid_file("metadata of more than 2^24 bytes");
  std::size_t name_bytes = 0;
  for (const std::string& name : sliced.channels) name_bytes += name.size();
  if (name_bytes > kMaxChannelNames) return invalid_file("channel names of more than 2^20 bytes");
  if (sliced.adaptive_count() > kMaxAdaptiveCount || sliced.guide_count() > kMaxGuideCount) {
    return invalid_file("more than 2^26 samples, or 2^20 of a guide");
  }
  const std::size_t channels = sliced.channel_count();
  if (sliced.crossing_values.size() != lattice.crossings.size() * channels) {
    return invalid_file("the frame has " + std::to_string(lattice.crossings.size()) + " crossings of " +
                        std::to_string(channels) + " channels, but there are " +
                        std::to_string(sliced.crossing_values.size()) + " values");
  }
  if (sliced.sample_counts.size() != lattice.slices.size()) {
    return invalid_file("the frame has " + std::to_string(lattice.slices.size()) + " slices, but there are " +
                        std::to_string(sliced.sample_counts.size()) + " sample counts");
  }
  if (sliced.sample_values.size() != sliced.positions.size() * channels) {
    return invalid_file(std::to_string(sliced.positions.size()) + " samples with " +
                        std::to_string(sliced.sample_values.size()) + " values");
  }
  return ok_status();
}

// Of the two ends of the gap that a sample halved, the one that is no further up the tree of halvings must be there; it
// answers for the other.
bool is_halving(std::span<const SamplePosition> on_slice, const SamplePosition& place) {
  const int depth = depth_of(place.fraction);
  if (depth <= 1) return true;
  const std::uint32_t half = SamplePosition::kOne >> static_cast<unsigned>(depth);
  const SamplePosition left = {place.interval, place.fraction - half};
  const SamplePosition right = {place.interval, place.fraction + half};
  return std::binary_search(on_slice.begin(), on_slice.end(), depth_of(left.fraction) == depth - 1 ? left : right);
}

Status check_positions(const SlicedBrdf& sliced, const Lattice& lattice) {
  std::uint64_t next = 0;
  for (std::size_t k = 0; k < lattice.slices.size(); ++k) {
    const std::uint64_t end = next + sliced.sample_counts[k];
    if (end > sliced.positions.size()) return invalid_file("sample counts exceed the number of samples");
    for (std::uint64_t p = next; p < end; ++p) {
      const SamplePosition& position = sliced.positions[p];
      const bool inside = position.interval < lattice.slices[k].interval_count() && position.fraction > 0 &&
                          position.fraction < SamplePosition::kOne;
      if (!inside || (p > next && !(sliced.positions[p - 1] < position))) {
        return invalid_file("slice " + std::to_string(k) + ", sample " + std::to_string(p - next) +
                            ": position outside the slice or out of order");
      }
    }
    const auto on_slice = std::span(sliced.positions).subspan(next, end - next);
    for (const SamplePosition& position : on_slice) {
      if (!is_halving(on_slice, position)) {
        return invalid_file("slice " + std::to_string(k) + ": a sample at " + std::to_string(position.fraction) +
                            "/65536 of its interval, but not at the half that it halves");
      }
    }
    next = end;
  }
  if (next != sliced.positions.size()) return invalid_file("more samples than the sample counts say");
  return ok_status();
}

Status check_domain(const SlicedBrdf& sliced) {
  const ValueDomain& domain = sliced.domain;
  if (domain.kind == DomainKind::kLinear) {
    if (domain.reference.empty()) return ok_status();
    return invalid_file("the linear domain has no references");
  }
  if (domain.kind != DomainKind::kLog) return unsupported("unknown value domain");
  const auto positive = [](float v) { return std::isfinite(v) && v > 0; };
  if (domain.reference.size() != sliced.channel_count() ||
      !std::all_of(domain.reference.begin(), domain.reference.end(), positive)) {
    return invalid_file("the log domain needs a positive reference for every channel");
  }
  if (domain.floor_halvings < 0 || domain.floor_halvings > kMaxFloorHalvings) {
    return invalid_file("the floor of the log domain is 0 to 255 halvings below the reference");
  }
  return ok_status();
}

Status check_guide(const SlicedBrdf& sliced, const Lattice& lattice) {
  if (!sliced.guide) return ok_status();
  const Guide& guide = *sliced.guide;
  if (lattice.spec.id != FrameId::kHalfDifference || sliced.domain.kind != DomainKind::kLog) {
    return invalid_file("a guide needs the half/difference frame and the log domain");
  }
  if (!(guide.ratio >= 1e-3 && guide.ratio <= 1e3)) return invalid_file("the guide's ratio must be in [0.001, 1000]");
  if (lattice.spec.symmetries.isotropic && guide.ratio != 1) return invalid_file("an isotropic guide has the ratio 1");
  std::uint32_t nodes = 0;
  for (std::size_t k = 0; k < guide.places.size(); ++k) {
    const SamplePosition& place = guide.places[k];
    if (place.fraction == 0) ++nodes;
    const bool inside = place.fraction < SamplePosition::kOne && place.interval + 1 == nodes &&
                        (place.fraction == 0 || nodes < lattice.nodes[kVertical].size());
    if (!inside || (k > 0 && !(guide.places[k - 1] < place)) || !is_halving(guide.places, place)) {
      return invalid_file("the guide's sample " + std::to_string(k) + ": outside the axis, out of order or no halving");
    }
  }
  if (nodes != lattice.nodes[kVertical].size() || guide.values.size() != guide.places.size() * sliced.channel_count()) {
    return invalid_file("the guide has " + std::to_string(guide.places.size()) + " samples at " +
                        std::to_string(nodes) + " nodes, and " + std::to_string(guide.values.size()) + " values");
  }
  return check_finite(guide.values, "guide value");
}

}  // namespace

int depth_of(std::uint32_t fraction) {
  return fraction == 0 ? 0 : kMaxDepth - static_cast<int>(std::countr_zero(fraction));
}

// An anisotropic highlight has level lines that are ellipses in the plane z = 1, into which the half vector h is
// projected at tan(theta_h) (cos phi_h, sin phi_h). With b times the width along y as along x (b = ratio > 1) points of
// one level have the same
//
//   tan(angle) = tan(theta_h) sqrt(cos^2 phi_h + sin^2 phi_h / b^2)
//
// and for b < 1 the other axis is the wide one: b cos phi_h stands in place of cos phi_h, and sin phi_h is whole.
// Either way the angle is theta_h at most, so it stays on the guide's axis. Written with atan2, it is good up to 90
// degrees.
double guide_angle_deg(double ratio, const Coordinates& x) {
  if (ratio == 1) return x[kVertical];  // the bits of the coordinate itself
  const double phi_h = radians_from_degrees(x[kAxial]);
  const double along_x = std::cos(phi_h) * std::min(1.0, ratio);
  const double along_y = std::sin(phi_h) / std::max(1.0, ratio);
  const double theta_h = radians_from_degrees(x[kVertical]);
  return degrees_from_radians(std::atan2(std::sin(theta_h) * std::hypot(along_x, along_y), std::cos(theta_h)));
}

std::vector<ValueRange> value_ranges(const SlicedBrdf& sliced) {
  if (!sliced.whole_ranges.empty()) return sliced.whole_ranges;
  const std::size_t channels = sliced.channel_count();
  std::vector<ValueRange> ranges(channels);
  for (std::size_t c = 0; c < channels && c < sliced.crossing_values.size(); ++c) {
    ranges[c] = {sliced.crossing_values[c], sliced.crossing_values[c]};
  }
  for (const auto* values : {&sliced.crossing_values, &sliced.sample_values}) {
    for (std::size_t first = 0; first + channels <= values->size(); first += channels) {
      for (std::size_t c = 0; c < channels; ++c) {
        ranges[c].least = std::min(ranges[c].least, (*values)[first + c]);
        ranges[c].most = std::max(ranges[c].most, (*values)[first + c]);
      }
    }
  }
  return ranges;
}

Status check_sliced(const SlicedBrdf& sliced, const Lattice& lattice) {
  if (Status status = check_sizes(sliced, lattice); !status) return status;
  if (Status status = check_domain(sliced); !status) return status;
  if (Status status = check_guide(sliced, lattice); !status) return status;
  if (Status status = check_positions(sliced, lattice); !status) return status;
  if (Status status = check_finite(sliced.crossing_values, "crossing value"); !status) return status;
  return check_finite(sliced.sample_values, "sample value");
}

}  // namespace sbrdf::internal
