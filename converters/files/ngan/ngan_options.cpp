#include <fmt/format.h>

#include <algorithm>

#include "converters/files/ngan/ngan.h"
#include "converters/files/value_options.h"
#include "formats/core/named.h"
#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

constexpr std::array kChannelNames = {Named{"planar", false}, Named{"interleaved", true}};
constexpr std::array kPositionNames = {Named{"centre", false}, Named{"edge", true}};
constexpr std::array kOtherHalfNames = {Named{"tangent", NganOtherHalf::kTangent},
                                        Named{"plane", NganOtherHalf::kPlane},
                                        Named{"unmeasured", NganOtherHalf::kUnmeasured}};
constexpr auto kChannelChoices = names_of(kChannelNames);
constexpr auto kPositionChoices = names_of(kPositionNames);
constexpr auto kOtherHalfChoices = names_of(kOtherHalfNames);

Status check_shape(std::string_view text) {
  const auto shape = parse_ngan_shape_option(text);
  return shape ? ok_status() : Status(shape.error());
}

constexpr std::array kOptions = {
    OptionSpec{.name = "ngan-shape",
               .unit = "TI,TO,PD,PI",
               .fallback = "that of an IN that is such a table, else 45,45,72,36",
               .check = check_shape,
               .meaning = "Bins along theta_in (of the light), theta_out, phi_out - phi_in and phi_in, each 1 to 4096; "
                          "PI is 1 for an isotropic IN"},
    OptionSpec{.name = "ngan-half",
               .kind = OptionKind::kFlag,
               .meaning = "Write half data: phi_out - phi_in from 0 to 180 degrees only, for a material that is "
                          "symmetric about its tangent; PD bins cover that half"},
    OptionSpec{.name = "ngan-channels",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kBoth,
               .choices = kChannelChoices,
               .fallback = "planar",
               .meaning = "Whether channels stand one after the other or side by side in each bin; the file does not "
                          "tell"},
    OptionSpec{.name = "ngan-position",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kBoth,
               .choices = kPositionChoices,
               .fallback = "centre",
               .meaning = "Whether values belong to the centres of their bins or to the lower edges, along all four "
                          "angles; the file does not tell"},
    OptionSpec{.name = "ngan-scale",
               .kind = OptionKind::kNumber,
               .use = OptionUse::kBoth,
               .unit = "X",
               .range = {1e-4, 1e4},
               .fallback = "1",
               .meaning = "f_r = number in the file x X"},
    OptionSpec{.name = "ngan-other-half",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kOtherHalfChoices,
               .fallback = "tangent",
               .meaning = "What half data mean for phi_out - phi_in beyond 180 degrees: the mirror image about the "
                          "tangent, that about the plane of incidence, or nothing"},
    negatives_option(OptionUse::kWrite),
    non_finite_option(OptionUse::kBoth),
};

}  // namespace

std::span<const OptionSpec> ngan_options() { return kOptions; }

NganConventions ngan_conventions(const Options& options) {
  NganConventions conventions;
  conventions.interleaved = value_of(kChannelNames, options.text("ngan-channels").value_or("")).value_or(false);
  conventions.at_edges = value_of(kPositionNames, options.text("ngan-position").value_or("")).value_or(false);
  conventions.scale = options.number("ngan-scale").value_or(1);
  conventions.other_half =
      value_of(kOtherHalfNames, options.text("ngan-other-half").value_or("")).value_or(NganOtherHalf::kTangent);
  return conventions;
}

Result<std::array<std::uint32_t, 4>> parse_ngan_shape_option(std::string_view text) {
  std::array<std::uint32_t, 4> shape{};
  std::string_view rest = text;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    const std::size_t end = axis + 1 < shape.size() ? rest.find(',') : rest.size();
    const auto count = end == std::string_view::npos ? std::nullopt : parse_count(rest.substr(0, end));
    if (!count || *count < 1 || *count > kNganMaxCount) {
      return usage_error(fmt::format("'{}' is not four counts of 1 to {} such as 45,45,72,36", text, kNganMaxCount));
    }
    shape[axis] = static_cast<std::uint32_t>(*count);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return shape;
}

}  // namespace sbrdf::internal
