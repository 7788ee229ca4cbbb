#include "converters/files/klems/klems_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/value_options.h"
#include "formats/core/named.h"
#include "formats/klems/klems.h"

namespace sbrdf::internal {
namespace {

/// Whose azimuth an incident patch has.
enum class Incident : std::uint8_t {
  kPropagation,  ///< of the way that the light goes: the same patch in and out is the mirror direction
  kLight,        ///< of the direction to the light
};
constexpr std::array kIncidentNames = {Named{"propagation", Incident::kPropagation}, Named{"light", Incident::kLight}};
constexpr auto kIncidentChoices = names_of(kIncidentNames);

/// How azimuths grow, seen from the side that the light comes from.
enum class Azimuth : std::uint8_t { kCounterClockwise, kClockwise };
constexpr std::array kAzimuthNames = {Named{"counter-clockwise", Azimuth::kCounterClockwise},
                                      Named{"clockwise", Azimuth::kClockwise}};
constexpr auto kAzimuthChoices = names_of(kAzimuthNames);

constexpr auto kSideChoices = names_of(kKlemsSideNames);
constexpr auto kBandChoices = names_of(kKlemsBandNames);

constexpr std::array kOptions = {
    negatives_option(OptionUse::kRead),
    OptionSpec{.name = "klems-side",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kSideChoices,
               .fallback = "front",
               .meaning = "The side that the light comes from, as the file calls it"},
    OptionSpec{.name = "klems-band",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kBandChoices,
               .fallback = "visible",
               .meaning = "The band of wavelengths that values are a mean over"},
    OptionSpec{.name = "klems-transmission",
               .kind = OptionKind::kFlag,
               .use = OptionUse::kRead,
               .meaning =
                   "Read the transmission from that side, not the reflection; its outgoing directions count from "
                   "the normal of the other side"},
    OptionSpec{.name = "klems-incident",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kIncidentChoices,
               .fallback = "propagation",
               .meaning =
                   "The azimuth of an incident patch is that of the way that light goes, so that the same patch in "
                   "and out is the mirror direction, or that of the direction to the light"},
    OptionSpec{.name = "klems-azimuth",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kAzimuthChoices,
               .fallback = "counter-clockwise",
               .meaning = "How azimuths of patches grow, seen from the side that the light comes from"},
};

class KlemsSource final : public BrdfSource {
 public:
  KlemsSource(KlemsMatrix matrix, const KlemsChoice& choice, Incident incident, Azimuth azimuth, Negatives negatives)
      : matrix_(std::move(matrix)),
        turn_(incident == Incident::kPropagation ? 180 : 0),
        sign_(azimuth == Azimuth::kCounterClockwise ? 1 : -1),
        negatives_(negatives) {
    const std::size_t rows = matrix_.incident.patch_count();
    traits_.format = "klems";
    traits_.description =
        fmt::format("Klems matrix, {} x {} patches, {} {} from the {}{}", rows, matrix_.outgoing.patch_count(),
                    name_of(kKlemsBandNames, choice.band), choice.transmission ? "transmission" : "reflection",
                    name_of(kKlemsSideNames, choice.side), matrix_.material.empty() ? "" : ", " + matrix_.material);
    traits_.channels = {choice.band == KlemsBand::kVisible ? "Y" : "solar"};
    add_hemispherical(choice.transmission ? "transmittance" : "reflectance");
    add_negatives();
  }

  [[nodiscard]] bool has_light() const {
    return std::any_of(matrix_.values.begin(), matrix_.values.end(), [](double value) { return value > 0; });
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    assert(values.size() == pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const double value = above_horizon(pairs[k]) ? value_of_pair(pairs[k]) : 0;
      values[k] = static_cast<float>(negatives_ == Negatives::kKeep ? value : std::max(value, 0.0));
    }
  }

  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      flags[k] = has_holes_ && above_horizon(pairs[k]) && value_of_pair(pairs[k]) < 0 ? 0 : 1;
    }
  }

  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override {
    if (!has_holes_) return std::nullopt;
    return MaskGrid{MaskFrame::kAngles, {36, 72, 36, 72}};
  }

 private:
  [[nodiscard]] double value_of_pair(const DirectionPair& pair) const {
    const double phi_i = sign_ * degrees_from_radians(pair.i.phi) + turn_;
    const double phi_v = sign_ * degrees_from_radians(pair.v.phi);
    const std::size_t in = matrix_.incident.patch_of(degrees_from_radians(pair.i.theta), phi_i);
    const std::size_t out = matrix_.outgoing.patch_of(degrees_from_radians(pair.v.theta), phi_v);
    return matrix_.value(in, out);
  }

  // Of a column of the matrix in the file, as a rule: what leaves for a unit that arrives.
  [[nodiscard]] double hemispherical(std::size_t incident_patch) const {
    double sum = 0;
    for (std::size_t out = 0; out < matrix_.outgoing.patch_count(); ++out) {
      sum += matrix_.value(incident_patch, out) * matrix_.outgoing.projected_solid_angle(out);
    }
    return sum;
  }

  void add_hemispherical(std::string_view name) {
    double largest = 0;
    std::size_t where = 0;
    std::uint64_t above = 0;
    const std::size_t count = matrix_.incident.patch_count();
    for (std::size_t in = 0; in < count; ++in) {
      const double sum = hemispherical(in);
      if (sum > 1) ++above;
      if (sum > largest) {
        largest = sum;
        where = in;
      }
    }
    const KlemsBasis::Patch patch = matrix_.incident.patch(where);
    traits_.findings.push_back(
        {fmt::format(
             "incident patches with a hemispherical {} above 1; the largest is {:.4g}, of patch {} (theta {:g} to "
             "{:g} degrees)",
             name, largest, where + 1, patch.ring.lower_deg, patch.ring.upper_deg),
         above, count});
  }

  void add_negatives() {
    const auto negative = static_cast<std::uint64_t>(
        std::count_if(matrix_.values.begin(), matrix_.values.end(), [](double value) { return value < 0; }));
    has_holes_ = negative > 0 && negatives_ == Negatives::kUnmeasured;
    if (negative == 0) return;
    const std::string done = negatives_ == Negatives::kKeep    ? ""
                             : negatives_ == Negatives::kClamp ? ", 0 in their place"
                                                               : ", taken as unmeasured";
    traits_.findings.push_back({"negative values" + done, negative, matrix_.values.size()});
  }

  KlemsMatrix matrix_;
  double turn_;  ///< from the direction to the light to the azimuth of its patch [degrees]
  double sign_;
  Negatives negatives_;
  bool has_holes_ = false;
  SourceTraits traits_;
};

}  // namespace

Result<std::unique_ptr<BrdfSource>> open_klems(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  if (bytes->size() > kKlemsLargestFile) {
    return unsupported(fmt::format("XML of {} bytes; at most {} are read", bytes->size(), kKlemsLargestFile));
  }
  const Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(bytes));
  if (!viewed) return viewed.error();
  const KlemsChoice choice = {
      value_of(kKlemsSideNames, options.text("klems-side").value_or("")).value_or(KlemsSide::kFront),
      value_of(kKlemsBandNames, options.text("klems-band").value_or("")).value_or(KlemsBand::kVisible),
      options.has("klems-transmission")};
  Result<KlemsMatrix> matrix = parse_klems((*viewed)->view().value(), choice);
  if (!matrix) return matrix.error();
  auto source = std::make_unique<KlemsSource>(
      *std::move(matrix), choice,
      value_of(kIncidentNames, options.text("klems-incident").value_or("")).value_or(Incident::kPropagation),
      value_of(kAzimuthNames, options.text("klems-azimuth").value_or("")).value_or(Azimuth::kCounterClockwise),
      policy_of(options, NonFinite::kRefuse).negatives);
  if (!source->has_light()) return invalid_file("no value of the matrix is positive");
  return std::unique_ptr<BrdfSource>(std::move(source));
}

std::span<const OptionSpec> klems_options() { return kOptions; }

}  // namespace sbrdf::internal
