#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/frame/frame.h"
#include "codec/mask/direction_mask.h"
#include "codec/material/grey_shares.h"
#include "codec/material/value_domain.h"

namespace sbrdf::internal {

struct Lattice;

/// Place of an adaptive sample on its slice: in which interval between neighbouring crossings, and how far along, as a
/// fraction of 2^16. Samples come from halving intervals, so the fraction is exact.
struct SamplePosition {
  static constexpr std::uint32_t kOne = 1U << 16U;
  std::uint32_t interval = 0;
  std::uint32_t fraction = 0;  ///< 1 .. kOne - 1

  auto operator<=>(const SamplePosition&) const = default;
};

/// The deepest that halvings go: 2^16 parts of an interval.
inline constexpr int kMaxDepth = 16;
/// How often an interval between crossings was halved to come to this fraction of it: 1 for its middle, 2 for its
/// quarters, and so on up to kMaxDepth; 0 for a crossing.
[[nodiscard]] int depth_of(std::uint32_t fraction);

/// A profile over the half vector's angle that is taken off before slices are made and added again at the end: slices
/// then hold v - g, which is smooth where a highlight is not. Half/difference frame and log domain only.
struct Guide {
  /// Over which angle: tan(angle) = tan(theta_h) x r(phi_h), r an ellipse with semi-axes 1 and 1/ratio (ratio > 1: the
  /// highlight is `ratio` times as wide along y as along x; below 1 the other way). 1 for an isotropic material.
  double ratio = 1;
  std::vector<SamplePosition> places;  ///< on the theta_h axis: fraction 0 at its nodes, all of which are there
  std::vector<float> values;           ///< in the value domain, channel fastest

  bool operator==(const Guide&) const = default;
};

/// The angle [degrees] over which a guide runs, at frame coordinates of the half/difference frame.
[[nodiscard]] double guide_angle_deg(double ratio, const Coordinates& x);

/// What a file can hold.
inline constexpr std::size_t kMaxChannels = 4096;
inline constexpr std::size_t kMaxMetadataSize = std::size_t{1} << 24U;
inline constexpr std::size_t kMaxAdaptiveCount = std::size_t{1} << 26U;
inline constexpr std::size_t kMaxGuideCount = std::size_t{1} << 20U;
inline constexpr std::size_t kMaxMaskSize = std::size_t{1} << 27U;      ///< bytes of the runs of a mask: any mask fits
inline constexpr std::size_t kMaxChannelNames = std::size_t{1} << 20U;  ///< bytes of all names together

/// Bounds of the values of one channel [1/sr].
struct ValueRange {
  float least = 0;
  float most = 0;

  bool operator==(const ValueRange&) const = default;
};

/// The content of a sliced file: measured values and where they lie. How crossings and slices are numbered follows from
/// `frame` (see Lattice).
struct SlicedBrdf {
  FrameSpec frame;
  ValueDomain domain;
  std::optional<Guide> guide;
  std::vector<std::string> channels;
  GreyShares grey_shares;                    ///< all values here are f_r with these added
  std::vector<float> crossing_values;        ///< f_r [1/sr], crossing by crossing, channel fastest
  std::vector<std::uint32_t> sample_counts;  ///< adaptive samples on each slice
  std::vector<SamplePosition> positions;     ///< slice by slice, rising on each
  std::vector<float> sample_values;          ///< f_r [1/sr] of the adaptive samples, channel fastest
  std::string metadata;                      ///< a JSON object; how the file came to be
  /// Which directions were not measured, so that what is said of them was filled in; none: all were measured.
  std::shared_ptr<const DirectionMask> mask;
  /// Of all samples of the material, per channel. Only where this holds a part of them; empty: what is here is all.
  std::vector<ValueRange> whole_ranges;

  [[nodiscard]] std::size_t channel_count() const { return channels.size(); }
  [[nodiscard]] std::size_t crossing_count() const { return crossing_values.size() / channels.size(); }
  [[nodiscard]] std::size_t adaptive_count() const { return positions.size(); }
  [[nodiscard]] std::size_t guide_count() const { return guide ? guide->places.size() : 0; }
  [[nodiscard]] std::size_t sample_count() const { return crossing_count() + adaptive_count() + guide_count(); }
};

/// Per channel, crossings included: whole_ranges, or what the values here span.
[[nodiscard]] std::vector<ValueRange> value_ranges(const SlicedBrdf& sliced);

/// Checks that the arrays fit each other and the lattice, positions rise, stay inside and are
/// halvings (of an interval, or of a half that a sample bounds), and values are finite.
[[nodiscard]] Status check_sliced(const SlicedBrdf& sliced, const Lattice& lattice);

}  // namespace sbrdf::internal
