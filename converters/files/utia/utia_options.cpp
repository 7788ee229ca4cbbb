#include <array>

#include "converters/files/utia/srgb.h"
#include "converters/files/utia/utia.h"
#include "converters/files/value_options.h"
#include "formats/core/named.h"

namespace sbrdf::internal {
namespace {

constexpr std::array kGammaNames = {Named{"none", UtiaGamma::kNone}, Named{"srgb-before", UtiaGamma::kSrgbBefore},
                                    Named{"srgb-after", UtiaGamma::kSrgbAfter}};
constexpr auto kGammaChoices = names_of(kGammaNames);
constexpr std::array<std::string_view, 2> kBeyondChoices = {"held", "extrapolated"};
constexpr std::array<std::string_view, 2> kGridChoices = {"standard", "dense"};
constexpr std::array<std::string_view, 3> kUnmeasuredChoices = {"nan", "zero", "refuse"};

constexpr std::array kOptions = {
    OptionSpec{.name = "utia-grid",
               .kind = OptionKind::kChoice,
               .choices = kGridChoices,
               .fallback = "dense for an IN that is a table of these directions, else standard",
               .meaning = "Directions of a UTIA table: theta every 15 degrees to 75 and phi every 7.5 (2 MB), or both "
                          "every 2, theta to 86 (1.5 GB)"},
    OptionSpec{.name = "utia-gamma",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kBoth,
               .choices = kGammaChoices,
               .fallback = "none",
               .meaning = "Whether numbers are encoded by the curve of sRGB, to be decoded before or after they are "
                          "interpolated; the file does not tell"},
    OptionSpec{.name = "utia-scale",
               .kind = OptionKind::kNumber,
               .use = OptionUse::kBoth,
               .unit = "X",
               .range = {1e-4, 1e4},
               .fallback = "1",
               .meaning = "f_r = X x number, after --utia-white and --utia-gamma"},
    OptionSpec{.name = "utia-white",
               .kind = OptionKind::kNumber,
               .use = OptionUse::kBoth,
               .unit = "W",
               .range = {1e-4, 1e4},
               .fallback = "1",
               .meaning = "The number that stands for 1: numbers are divided by W before they are decoded"},
    OptionSpec{.name = "utia-beyond",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kBeyondChoices,
               .fallback = "held",
               .meaning = "Values beyond the last theta: the last one, or the straight line through the last two, 0 "
                          "where it would become negative"},
    OptionSpec{.name = "utia-unmeasured",
               .kind = OptionKind::kChoice,
               .choices = kUnmeasuredChoices,
               .fallback = "nan",
               .meaning = "What stands at directions that IN did not measure: NaN, which other readers may not expect, "
                          "0, or no file at all"},
    negatives_option(OptionUse::kBoth),
    non_finite_option(OptionUse::kBoth),
};

}  // namespace

std::span<const OptionSpec> utia_options() { return kOptions; }

UtiaConventions utia_conventions(const Options& options) {
  UtiaConventions conventions;
  conventions.gamma = value_of(kGammaNames, options.text("utia-gamma").value_or("")).value_or(UtiaGamma::kNone);
  conventions.scale = options.number("utia-scale").value_or(1);
  conventions.white = options.number("utia-white").value_or(1);
  conventions.extrapolated = options.text("utia-beyond") == "extrapolated";
  return conventions;
}

double utia_value(double number, const UtiaConventions& conventions) {
  const double part = number / conventions.white;
  return conventions.scale * (conventions.gamma == UtiaGamma::kNone ? part : srgb_decoded(part));
}

double utia_number(double value, const UtiaConventions& conventions) {
  const double part = value / conventions.scale;
  return conventions.white * (conventions.gamma == UtiaGamma::kNone ? part : srgb_encoded(part));
}

}  // namespace sbrdf::internal
