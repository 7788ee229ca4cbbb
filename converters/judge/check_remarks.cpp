#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "converters/judge/plausibility.h"

namespace sbrdf::internal {
namespace {

constexpr double kMerlScale = 1500;
constexpr double kSurelyTooLarge = 20;          ///< of an albedo; the darkest material times 1500
constexpr double kSurelyTooSmall = 1.0 / 1500;  ///< a white one by 1500
constexpr double kVeryUnreciprocal = 50;        ///< percent
constexpr double kCosineGain = 0.55;            ///< of the median difference, as it is
constexpr double kCosineLeast = 0.1;            ///< median difference of logarithms
constexpr double kSlopeSlack = 0.5;
constexpr double kAsymmetryLeast = 0.005;
constexpr double kAgainst = -0.5;
constexpr double kWith = 0.6;
constexpr double kPole = 0.9;
constexpr double kManyNegative = 5;    ///< percent, out of gamut not counted
constexpr double kMuchNoise = 0.01;    ///< of the nodes
constexpr double kRadianThetas = 1.6;  ///< [degrees] pi / 2, and a little more

std::string direction_text(const Direction& i) {
  return fmt::format("theta_i {:g}, phi_i {:g} degrees", degrees_from_radians(i.theta), degrees_from_radians(i.phi));
}

class Remarker {
 public:
  Remarker(const CheckReport& report, const SourceTraits& traits) : report_(report), traits_(traits) {}

  std::vector<CheckRemark> run() {
    albedo();
    scale();
    reciprocity();
    cosine();
    exchange();
    grazing();
    shares();
    spikes();
    unit();
    return std::move(remarks_);
  }

 private:
  void add(const char* topic, bool suspicious, std::string text) {
    remarks_.push_back({topic, std::move(text), suspicious});
  }
  [[nodiscard]] bool counts(const Albedo& albedo) const {
    return degrees_from_radians(albedo.i.theta) <= traits_.theta_max_deg + 1e-9;
  }
  [[nodiscard]] const std::string& name(std::size_t channel) const { return traits_.channels[channel]; }

  void albedo() {
    std::size_t lights = 0;
    std::size_t above = 0;
    std::size_t above_with_rest = 0;
    std::size_t inexact = 0;
    std::uint64_t not_finite = report_.pairs.shares.not_finite;
    double highest = 0;
    for (const Albedo& albedo : report_.albedos) {
      not_finite += albedo.not_finite;
      if (!albedo.reached) ++inexact;
      if (!counts(albedo)) continue;
      ++lights;
      bool some = false;
      bool some_with_rest = false;
      for (std::size_t c = 0; c < albedo.measured.size(); ++c) {
        some = some || albedo.measured[c] - albedo.error[c] > 1;
        some_with_rest = some_with_rest || albedo.total(c) - albedo.error[c] > 1;
        highest = std::max(highest, albedo.total(c));
      }
      above += some ? 1 : 0;
      above_with_rest += some_with_rest ? 1 : 0;
    }
    if (above > 0) {
      add("albedo", true,
          fmt::format("more light comes back than came in for {} of {} directions of the light: {:.4g} times as much "
                      "in {} at {}",
                      above, lights, report_.highest_albedo, name(report_.highest_channel),
                      direction_text(report_.highest_at)));
    } else if (above_with_rest > 0) {
      add("albedo", false,
          fmt::format("the albedo is above 1 (up to {:.4g}) for {} of {} directions of the light, but only with what "
                      "was made up beyond theta_max = {:g} degrees; without it the highest is {:.4g}",
                      highest, above_with_rest, lights, traits_.theta_max_deg, report_.highest_albedo));
    }
    if (inexact > 0) {
      add("accuracy", false,
          fmt::format("{} of {} albedos are not as accurate as was asked; their errors are given", inexact,
                      report_.albedos.size()));
    }
    if (not_finite > 0) add("not finite", true, fmt::format("{} values are NaN or infinite", not_finite));
  }

  void scale() {
    double typical = 0;  // of the brightest channel, the median over lights
    for (std::size_t c = 0; c < traits_.channels.size(); ++c) {
      std::vector<double> values;
      for (const Albedo& albedo : report_.albedos) {
        if (counts(albedo) && albedo.i.theta < 1.1) values.push_back(albedo.measured[c]);
      }
      if (values.empty()) return;
      std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
      typical = std::max(typical, values[values.size() / 2]);
    }
    if (typical > kSurelyTooLarge) {
      add("scale", true,
          fmt::format("values are far too large: the median albedo up to 60 degrees is {:.4g}; a 1500th of it, the "
                      "scale of MERL tables, would be {:.4g}",
                      typical, typical / kMerlScale));
    } else if (typical > 1.001 && typical <= kPi) {
      add("scale", true,
          fmt::format("the median albedo up to 60 degrees is {:.4g}; divided by pi, as where f_r pi was stored, it "
                      "would be {:.4g}",
                      typical, typical / kPi));
    } else if (typical > 0 && typical < kSurelyTooSmall) {
      add("scale", true,
          fmt::format("values are far too small: the median albedo up to 60 degrees is {:.4g}; 1500 times as much, as "
                      "where the scale of MERL tables was taken twice, would be {:.4g}",
                      typical, typical * kMerlScale));
    }
  }

  void reciprocity() {
    if (traits_.reciprocal || report_.reciprocity.percent <= kVeryUnreciprocal) return;
    add("reciprocity", true,
        fmt::format("f(i,v) and f(v,i) differ by {:.4g} %: {}", report_.reciprocity.percent,
                    place_text(report_.reciprocity.worst, traits_.channels)));
  }

  void cosine() {
    const PairChecks& pairs = report_.pairs;
    if (traits_.reciprocal || pairs.exchange_log < kCosineLeast) return;
    const bool v = pairs.exchange_log_without_cos_v < pairs.exchange_log_without_cos_i;
    const double rest = v ? pairs.exchange_log_without_cos_v : pairs.exchange_log_without_cos_i;
    const double slope = v ? pairs.exchange_slope : -pairs.exchange_slope;
    if (rest > kCosineGain * pairs.exchange_log || std::abs(slope - 1) > kSlopeSlack) return;
    add("cosine", true,
        fmt::format("{}: f(i,v) and f(v,i) differ by a factor of {:.3g} (median), and of {:.3g} once f is divided by "
                    "cos {}; the difference follows the cosines with the power {:.2f}",
                    v ? "cos theta_v seems to be multiplied in"
                      : "cos theta_i seems to be multiplied in, or a "
                        "cosine of the view divided out",
                    std::exp(pairs.exchange_log), std::exp(rest), v ? "theta_v" : "theta_i", slope));
  }

  void exchange() {
    const PairChecks& pairs = report_.pairs;
    if (traits_.reciprocal || pairs.channels.size() < 3) return;
    for (const ChannelExchange& channel : pairs.channels) {
      if (channel.asymmetry < kAsymmetryLeast) return;
    }
    const double against = pairs.channels[pairs.odd_channel].with_others;
    if (against > kAgainst || pairs.agreement_if_turned < kWith) return;
    add("exchange", true,
        fmt::format(
            "light and viewer seem to be exchanged in {}: what exchanging them changes there is the opposite of "
            "what it changes in the other channels (correlation {:.2f}); turned round, every channel agrees "
            "with all together ({:.2f} or more)",
            name(pairs.odd_channel), against, pairs.agreement_if_turned));
  }

  void grazing() {
    const auto& growth = report_.grazing;
    const bool pole = growth.back().power >= kPole;
    const bool held = std::abs(growth.back().power) < 0.01 &&
                      std::all_of(growth.begin(), growth.end() - 1, [](const auto& g) { return g.power >= kPole; });
    if (!pole && !held) return;
    const GrazingGrowth& at = pole ? growth.back() : growth.front();
    const bool made_up = traits_.theta_max_deg <= at.from_deg;
    add("grazing", !made_up,
        fmt::format(
            "f_r grows like 1 / cos theta_v to the power {:.2f} from theta_v {:g} to {:g} degrees{}", at.power,
            at.from_deg, at.to_deg,
            made_up ? fmt::format(", beyond theta_max = {:g} degrees, where values are made up", traits_.theta_max_deg)
                    : ", as what was divided by a cosine that it did not have, and some models"));
  }

  void shares() {
    const Shares& shares = report_.shares;
    const char* of = report_.shares_of_nodes ? "of the nodes" : "of the directions";
    if (shares.negative_percent > 0) {
      add("negative", shares.negative_percent - shares.gamut_percent > kManyNegative,
          fmt::format("some channel is negative in {:.3g} % {} ({:.3g} % by solid angle)", shares.negative_percent, of,
                      shares.negative_solid_percent));
    }
    if (shares.worst_gamut) {
      const ValuePlace& worst = *shares.worst_gamut;
      const DirectionPair& pair = worst.pair;
      add("gamut", false,
          fmt::format("colours are out of gamut in {:.3g} % {} ({:.3g} % by solid angle): {} is {:.4g} 1/sr beside "
                      "{:.4g} in another channel at theta_i {:.4g}, phi_i {:.4g}, theta_v {:.4g}, phi_v {:.4g}",
                      shares.gamut_percent, of, shares.gamut_solid_percent, name(worst.channel), worst.reference,
                      worst.test, degrees_from_radians(pair.i.theta), degrees_from_radians(pair.i.phi),
                      degrees_from_radians(pair.v.theta), degrees_from_radians(pair.v.phi)));
    }
    if (shares.unmeasured_percent > 0) {
      add("unmeasured", false,
          fmt::format("{:.3g} % {} were not measured ({:.3g} % by solid angle)", shares.unmeasured_percent, of,
                      shares.unmeasured_solid_percent));
    }
  }

  void spikes() {
    if (!report_.spikes) return;
    const SpikeSearch& found = *report_.spikes;
    if (found.count > 0) {
      const Spike& worst = found.worst.front();
      add("spikes", true,
          fmt::format("{} of {} nodes stand out from all around them; the farthest is {} {:.4g} at {}, where the nodes "
                      "around have {:.4g} to {:.4g} 1/sr",
                      found.count, found.nodes, name(worst.channel), worst.value, worst.place, worst.least,
                      worst.largest));
    }
    if (static_cast<double>(found.too_noisy) > kMuchNoise * static_cast<double>(found.nodes)) {
      add("noise", false,
          fmt::format("{} of {} nodes lie where so many stand out that single ones cannot be told",
                      std::min(found.too_noisy, found.nodes), found.nodes));
    }
  }

  void unit() {
    if (traits_.theta_max_deg > kRadianThetas) return;
    add("unit", true,
        fmt::format("theta ends at {:.4g} degrees: radians may have been taken as degrees", traits_.theta_max_deg));
  }

  const CheckReport& report_;
  const SourceTraits& traits_;
  std::vector<CheckRemark> remarks_;
};

}  // namespace

std::vector<CheckRemark> remarks_on(const CheckReport& report, const SourceTraits& traits) {
  return Remarker(report, traits).run();
}

}  // namespace sbrdf::internal
