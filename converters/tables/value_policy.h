#pragma once

#include <array>
#include <cstdint>

#include "formats/core/named.h"

namespace sbrdf::internal {

// What becomes of values that are no reflectance, on the way into or out of a table.

/// Of a value below 0 in one channel or some.
enum class Negatives : std::uint8_t {
  kKeep,        ///< it stays
  kClamp,       ///< it becomes 0
  kUnmeasured,  ///< the whole pair of directions counts as not measured
};
/// Of a NaN, an infinity, or a value that no float holds.
enum class NonFinite : std::uint8_t {
  kRefuse,      ///< an error
  kUnmeasured,  ///< the whole pair of directions counts as not measured
};

inline constexpr std::array kNegativesNames = {Named{"keep", Negatives::kKeep}, Named{"clamp", Negatives::kClamp},
                                               Named{"unmeasured", Negatives::kUnmeasured}};
inline constexpr std::array kNonFiniteNames = {Named{"refuse", NonFinite::kRefuse},
                                               Named{"unmeasured", NonFinite::kUnmeasured}};
inline constexpr auto kNegativesChoices = names_of(kNegativesNames);
inline constexpr auto kNonFiniteChoices = names_of(kNonFiniteNames);

struct ValuePolicy {
  Negatives negatives = Negatives::kKeep;
  NonFinite non_finite = NonFinite::kRefuse;
};

}  // namespace sbrdf::internal
