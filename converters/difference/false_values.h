#pragma once

#include <cstdint>
#include <span>

#include "converters/difference/error_sums.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

inline constexpr double kFalseFactor = 3;
inline constexpr double kStrictFactor = 1.5;
inline constexpr double kNeighbourhoodDeg = 3;

/// Which false values are looked for.
enum class FalseValueSearch : std::uint8_t {
  kNone,
  kFar,  ///< those of `count`: few values need a look at what is around, so it takes little time
  kAll,  ///< the strict counts, too: with a poor test longer than all the rest of a comparison
};

/// Values of a test that its reference has nowhere near: streaks and sparks of a reconstruction. What a reference has
/// near a pair are its values there and where one of the two directions, light or viewer, is moved by at most 3
/// degrees: on rings every half degree with points half a degree apart, above the horizon; and at the mirror direction
/// of the other one where that is so near.
struct FalseValues {
  /// Values above 3 times the largest |f| near them over all channels. A value that is no number counts in each count.
  std::uint64_t count = 0;
  double worst_factor = 0;  ///< of these, the largest |r| over that |f|; infinite where that is 0
  ValuePlace worst;
  /// Values above 1.5 times the largest |f| near them in their own channel.
  std::uint64_t too_large = 0;
  /// Values below the least f near them in their own channel: below 2/3 of it, or 1.5 times it where it is negative.
  std::uint64_t too_small = 0;
  double strict_worst = 0;  ///< of both, the farthest beyond the bound, in units of the largest |f|
  ValuePlace strict_worst_at;
  bool complete = true;  ///< false: not all directions were looked at, since so many were found, or none was

  [[nodiscard]] std::uint64_t strict_count() const { return too_large + too_small; }
  /// The first of equally bad ones stays.
  void add(const FalseValues& other);
};

/// Counts the false among the values `r` (one for each channel) at a pair where the reference is `f`. The reference is
/// evaluated around the pair only where a value is false by `f` itself.
void find_false_values(const BrdfSource& reference, const DirectionPair& pair, std::span<const float> f,
                       std::span<const float> r, FalseValueSearch search, FalseValues& found);

}  // namespace sbrdf::internal
