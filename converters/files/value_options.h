#pragma once

#include "converters/files/options.h"
#include "converters/tables/value_policy.h"

namespace sbrdf::internal {

// Options of a ValuePolicy, declared once so that they mean the same for each format that has a use for them.

[[nodiscard]] constexpr OptionSpec negatives_option(OptionUse use) {
  return {.name = "negatives",
          .kind = OptionKind::kChoice,
          .use = use,
          .choices = kNegativesChoices,
          .fallback = "keep, or clamp for an OUT in which they mean unmeasured",
          .meaning =
              "Values below 0 of a measured IN and of an OUT that is a table: keep them, make them 0, or take the "
              "pair of directions for unmeasured"};
}
[[nodiscard]] constexpr OptionSpec non_finite_option(OptionUse use) {
  return {
      .name = "non-finite",
      .kind = OptionKind::kChoice,
      .use = use,
      .choices = kNonFiniteChoices,
      .fallback = "unmeasured as IN, refuse as OUT",
      .meaning =
          "NaN and infinite values of an IN or OUT that is a table: refuse the file, or take the pair of directions "
          "for unmeasured"};
}

/// `non_finite` and `negatives` where the option was not given.
[[nodiscard]] inline ValuePolicy policy_of(const Options& options, NonFinite non_finite,
                                           Negatives negatives = Negatives::kKeep) {
  return {value_of(kNegativesNames, options.text("negatives").value_or("")).value_or(negatives),
          value_of(kNonFiniteNames, options.text("non-finite").value_or("")).value_or(non_finite)};
}

}  // namespace sbrdf::internal
