#pragma once

#include <array>
#include <cstdint>

#include "converters/files/options.h"
#include "formats/core/named.h"

namespace sbrdf::internal {

// What becomes of values that are no reflectance, on the way into or out of a table. Formats that have a use for these
// options declare them here, so that they mean the same everywhere.

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

[[nodiscard]] constexpr OptionSpec negatives_option(OptionUse use) {
  return {.name = "negatives",
          .kind = OptionKind::kChoice,
          .use = use,
          .choices = kNegativesChoices,
          .fallback = "keep",
          .meaning =
              "Values below 0 of a .binary or .bsdf IN and of a .binary OUT: keep them, make them 0, or take the "
              "pair of directions for unmeasured"};
}
[[nodiscard]] constexpr OptionSpec non_finite_option(OptionUse use) {
  return {.name = "non-finite",
          .kind = OptionKind::kChoice,
          .use = use,
          .choices = kNonFiniteChoices,
          .fallback = "unmeasured as IN, refuse as OUT",
          .meaning =
              "NaN and infinite values of a .binary IN or OUT: refuse the file, or take the pair of directions "
              "for unmeasured"};
}

/// `non_finite` where the option was not given.
[[nodiscard]] inline ValuePolicy policy_of(const Options& options, NonFinite non_finite) {
  return {value_of(kNegativesNames, options.text("negatives").value_or("keep")).value_or(Negatives::kKeep),
          value_of(kNonFiniteNames, options.text("non-finite").value_or("")).value_or(non_finite)};
}

}  // namespace sbrdf::internal
