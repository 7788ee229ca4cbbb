#include "converters/stress/stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <utility>

#include "converters/stress/stress_materials.h"

namespace sbrdf {
namespace {

using namespace stress;

constexpr std::array kFrames = {FrameId::kElevation, FrameId::kHalfDifference};
constexpr std::array kDomains = {DomainKind::kLinear, DomainKind::kLog};
constexpr double kLogLimit = 2e-5;     ///< of the exact value
constexpr double kLinearLimit = 1e-5;  ///< of the local maximum

double limit_of(DomainKind domain) { return domain == DomainKind::kLog ? kLogLimit : kLinearLimit; }
std::string unit_of(DomainKind domain) {
  return domain == DomainKind::kLog ? "error relative to exact" : "error / local maximum";
}

/// Collects the cases of one row. A NaN stays.
class Tally {
 public:
  void add(double error) {
    ++cases_;
    if (!std::isnan(worst_) && !(error <= worst_)) worst_ = error;
  }
  /// For rows whose worst is the number of cases that are wrong.
  void count(bool right) {
    ++cases_;
    worst_ += right ? 0 : 1;
  }
  [[nodiscard]] StressRow row(std::string what, double limit) const {
    return {"", std::move(what), cases_, worst_, limit, cases_ > 0 && worst_ <= limit};
  }

 private:
  std::uint64_t cases_ = 0;
  double worst_ = 0;
};

/// One row's frame, domain, random numbers, and the evaluation on trial.
struct Trial {
  FrameId frame;
  DomainKind domain;
  std::mt19937_64 random;
  const StressSubject& subject;

  [[nodiscard]] Channels<float> at(const Material& material, const Coordinates& x) const {
    Channels<float> values;
    material.rounded.evaluate_at(x, values);
    return distorted(values);
  }
  [[nodiscard]] Channels<float> operator()(const Material& material, const DirectionPair& pair) const {
    Channels<float> values;
    material.rounded.evaluate(pair, values);
    return distorted(values);
  }
  [[nodiscard]] Channels<float> distorted(Channels<float> values) const {
    if (subject.distort) {
      for (float& value : values) value = subject.distort(value);
    }
    return values;
  }
  /// Uniform in [low, high).
  double draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
};

/// The same bits, and numbers.
bool same_bits(const Channels<float>& a, const Channels<float>& b) {
  const bool numbers = std::none_of(a.begin(), a.end(), [](float value) { return std::isnan(value); });
  return numbers && std::memcmp(a.data(), b.data(), sizeof a) == 0;
}

double relative(double difference, double scale) { return difference == 0 ? 0 : std::abs(difference) / scale; }

/// Float against exact, by the rule of the domain.
void add_errors(Tally& tally, const Trial& trial, const Material& material, const DirectionPair& pair) {
  const Channels<float> values = trial(material, pair);
  Channels<long double> exact;
  material.exact.evaluate(pair, exact);
  Channels<double> scale;
  if (material.is_log()) {
    std::transform(exact.begin(), exact.end(), scale.begin(), [](long double e) { return static_cast<double>(e); });
  } else {
    scale = local_maximum(material, geometry(material.lattice.spec.id).coordinates(pair));
  }
  for (std::size_t c = 0; c < kChannels; ++c) {
    tally.add(relative(static_cast<double>(static_cast<long double>(values[c]) - exact[c]), std::abs(scale[c])));
  }
}

StressRow check_theta(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, kurt("Fabric112"));
  Tally tally;
  for (const double theta_i : {0.0, 80.0, 89.9, 90.0}) {
    for (const double theta_v : {0.0, 35.0, 80.0, 89.9, 90.0}) {
      for (int k = 0; k < 40; ++k) {
        const double phi = trial.draw(0, 360);
        // Both in the same azimuth, opposite, and any.
        const double phi_v = k % 4 == 0 ? phi : k % 4 == 1 ? phi + 180 : trial.draw(0, 360);
        const DirectionPair pair = {direction_from_degrees(theta_i, phi), direction_from_degrees(theta_v, phi_v)};
        add_errors(tally, trial, material, pair);
        add_errors(tally, trial, material, {pair.v, pair.i});
      }
    }
  }
  return tally.row("theta 0, 80, 89.9, 90: " + unit_of(trial.domain), limit_of(trial.domain));
}

StressRow check_turns(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {700, trial.domain}, smooth);
  std::uniform_int_distribution<int> phi(0, 360 * 64 - 1);  // in 64ths of a degree: whole turns added are exact
  Tally tally;
  for (int n = 0; n < 200; ++n) {
    const double theta_i = trial.draw(0, 90), theta_v = trial.draw(0, 90);
    const double phi_i = phi(trial.random) / 64.0, phi_v = phi(trial.random) / 64.0;
    const auto turned = [&](int turns_i, int turns_v) {
      return trial(material, {direction_from_degrees(theta_i, phi_i + 360.0 * turns_i),
                              direction_from_degrees(theta_v, phi_v + 360.0 * turns_v)});
    };
    const Channels<float> plain = turned(0, 0);
    for (int i = -3; i <= 3; ++i) {
      for (int v = -3; v <= 3; ++v) tally.count(same_bits(plain, turned(i, v)));
    }
  }
  return tally.row("phi + 360 k, k = -3..3: other bits", 0);
}

StressRow check_range(Trial& trial) {
  Tally tally;
  for (const double usual : {1e-30, 1e-3, 1e6}) {
    // Most values are `usual`, so that the reference of the log domain is; the others lie anywhere.
    const auto wild = [&](const DirectionPair& /*pair*/) {
      Channels<double> f;
      for (double& value : f) {
        const double kind = trial.draw(0, 10);
        value = kind < 6 ? usual : kind < 7 ? 1e12 : kind < 8 ? 1e-30 : std::pow(10, trial.draw(-30, 12));
      }
      return f;
    };
    const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, wild);
    for (int k = 0; k < 1500; ++k) {
      for (const float value : trial(material, random_pair(trial.random))) {
        tally.count(std::isfinite(value) && value >= 0);
      }
    }
  }
  return tally.row("samples 1e-30 to 1e12: not finite or negative", 0);
}

StressRow check_zeros(Trial& trial) {
  const auto with_zeros = [](const DirectionPair& pair) {
    Channels<double> f = smooth(pair);
    for (double& value : f) {
      if (pair.i.theta + pair.v.theta > 1.8 || std::fmod(value * 1000, 1) < 0.2) value = 0;
    }
    return f;
  };
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, with_zeros);
  Tally tally;
  for_each_sample(material, [&](const Coordinates& x, std::span<const float> measured) {
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      if (measured[c] == 0) tally.add(std::abs(static_cast<double>(values[c])));
    }
  });
  return tally.row("at samples that are 0: largest value", 0);
}

StressRow check_constants(Trial& trial) {
  constexpr std::array<Channels<float>, 2> kConstants = {
      {{0.1F, 1e-30F, 1e12F, 0.0F}, {0.7182818F, 1.0F / 3, 16777215.0F, 3e-7F}}};
  Tally tally;
  for (const auto& constants : kConstants) {
    const Channels<double> f = {constants[0], constants[1], constants[2], constants[3]};
    const Material material =
        sample(coarse_frame(trial.frame, false), {400, trial.domain}, [&](const DirectionPair& /*pair*/) { return f; });
    for (int k = 0; k < 1000; ++k) tally.count(same_bits(trial(material, random_pair(trial.random)), constants));
  }
  return tally.row("8 constants, 1e-30 to 1e12 and 0: other bits", 0);
}

/// a + b (x + y) + c x y of the two polar coordinates.
Channels<double> bilinear(double x, double y) {
  return {1 + 0.01 * (x + y) + 0.0003 * x * y, 5 - 0.01 * (x + y), 0.5 + 0.0002 * x * y,
          2 - 0.005 * (x + y) + 0.0001 * x * y};
}

StressRow check_linear(Trial& trial) {
  const bool elevation = trial.frame == FrameId::kElevation;
  // Half/difference: only as far as no slice runs below the horizon, where it ends in another value.
  const FrameSpec spec = elevation
                             ? coarse_frame(trial.frame, false)
                             : half_difference_frame({0, 15, 40}, {0, 20, 40}, {0, 90, 180, 270}, {0, 60, 120}, {});
  const auto function = [&](const DirectionPair& pair) {
    const HalfDifference half = half_difference_from_pair(pair);
    return elevation ? bilinear(degrees_from_radians(pair.i.theta), degrees_from_radians(pair.v.theta))
                     : bilinear(degrees_from_radians(half.theta_h), degrees_from_radians(half.theta_d));
  };
  const Material material = sample(spec, {700, trial.domain}, function);
  Tally tally;
  for (int k = 0; k < 3000; ++k) {
    const Coordinates x = random_coordinates(trial.random, material.lattice);
    const Channels<double> expected = bilinear(x[kHorizontal], x[kVertical]);
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(std::abs(values[c] - expected[c]) / material.largest[c]);
    }
  }
  // Samples are floats: seven of them, each rounded, and the sum's own roundings.
  return tally.row("linear in each theta: error / largest sample", 1e-6);
}

StressRow check_reciprocity(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, kurt("Fabric112"));
  Tally tally;
  for (int k = 0; k < 4000; ++k) {
    DirectionPair pair = random_pair(trial.random);
    if (k % 3 == 0) pair.v.theta = pair.i.theta;
    if (k % 5 == 0) pair.i.theta = 0;
    if (k % 7 == 0) pair.v.theta = kPi / 2;
    tally.count(same_bits(trial(material, pair), trial(material, {pair.v, pair.i})));
  }
  return tally.row("f(i,v) and f(v,i): different bits", 0);
}

StressRow check_isotropy(Trial& trial) {
  const Material material = sample(fine_frame(trial.frame, true), {1500, trial.domain}, isotropic_kurt());
  Tally tally;
  for (int k = 0; k < 3000; ++k) {
    const DirectionPair pair = random_pair(trial.random);
    const double turn = trial.draw(0, 2 * kPi);
    const Channels<float> plain = trial(material, pair);
    const Channels<float> turned =
        trial(material, {{pair.i.theta, pair.i.phi + turn}, {pair.v.theta, pair.v.phi + turn}});
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(relative(static_cast<double>(plain[c]) - turned[c], std::abs(static_cast<double>(plain[c]))));
    }
  }
  return tally.row("both directions turned: relative change", kLogLimit);
}

StressRow check_continuity(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, smooth);
  const ClampDetector detector(material);
  Tally tally;
  const auto compare = [&](const Coordinates& a, const Coordinates& b) {
    const auto clamped_a = detector.clamped(a);
    const auto clamped_b = detector.clamped(b);
    const Channels<float> value_a = trial.at(material, a);
    const Channels<float> value_b = trial.at(material, b);
    const Channels<double> local = local_maximum(material, a);
    for (std::size_t c = 0; c < kChannels; ++c) {
      // The least and the greatest of the slices change from cell to cell by definition.
      if (clamped_a[c] || clamped_b[c]) continue;
      tally.add(relative(static_cast<double>(value_a[c]) - value_b[c], local[c]));
    }
  };
  for (int k = 0; k < 100; ++k) {
    // The shorter step is below what floats see of a cell, the longer one is not.
    const Coordinates x = random_coordinates(trial.random, material.lattice);
    for (const double step : {1e-9, 1e-5}) for_each_boundary(material.lattice, x, step, compare);
  }
  return tally.row("across every node, no clamp: jump / local maximum", 1e-4);
}

StressRow check_minimum_gap(Trial& trial) {
  const FrameSpec spec = trial.frame == FrameId::kElevation
                             ? elevation_frame_from_nodes({0, 80}, {0}, {0, 180}, {.isotropic = true})
                             : half_difference_frame({0, 40}, {0, 40}, {0}, {0, 90}, {.isotropic = true});
  const Material material = sample(spec, {1'000'000, trial.domain, 0.02}, isotropic_kurt());
  Tally tally;
  tally.count(material.full);
  for_each_sample(material, [&](const Coordinates& x, std::span<const float> measured) {
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(relative(static_cast<double>(values[c]) - measured[c], std::abs(static_cast<double>(measured[c]))));
    }
  });
  for (int k = 0; k < 500; ++k) {
    for (const float value : trial(material, random_pair(trial.random))) tally.add(std::isfinite(value) ? 0 : 1);
  }
  // Linear values come back as they are; logarithms were rounded once and raised again.
  return tally.row("gaps of 0.02 deg, full: relative error at samples", trial.domain == DomainKind::kLog ? 2e-6 : 0);
}

StressRow check_single(Trial& trial) {
  Tally tally;
  for (unsigned bits = 0; bits < 16; ++bits) {
    const auto list = [&](unsigned bit, std::vector<double> nodes) {
      return ((bits >> bit) & 1U) != 0 ? nodes : std::vector<double>{0};
    };
    const FrameSpec spec =
        trial.frame == FrameId::kElevation
            ? elevation_frame_from_nodes(list(3, {0, 80}), list(0, {0, 200}), list(1, {0, 100, 260}), {})
            : half_difference_frame(list(3, {0, 50}), list(2, {0, 40}), list(0, {0, 200}), list(1, {0, 100}), {});
    for (const std::uint64_t samples : {0U, 12U}) {
      const Material material = sample(spec, {samples, trial.domain}, smooth);
      for (int k = 0; k < 100; ++k) add_errors(tally, trial, material, random_pair(trial.random));
    }
  }
  return tally.row("axes and slices of one sample: " + unit_of(trial.domain), limit_of(trial.domain));
}

StressRow check_spikes(Trial& trial) {
  const auto spiky = [&](const DirectionPair& /*pair*/) {
    Channels<double> f;
    for (double& value : f) {
      const double kind = trial.draw(0, 10);
      value = kind < 1 ? 1e6 : kind < 2 ? 0 : kind < 3 ? 1e3 : 1;
    }
    return f;
  };
  Tally tally;
  for (const std::uint64_t samples : {0U, 800U, 1600U}) {
    const Material material = sample(coarse_frame(trial.frame, false), {samples, trial.domain}, spiky);
    for (int k = 0; k < 2000; ++k) {
      for (const float value : trial(material, random_pair(trial.random))) {
        tally.count(std::isfinite(value) && value >= 0);
      }
    }
  }
  return tally.row("0, 1, 1e3 and 1e6 side by side: not finite or negative", 0);
}

StressRow check_accuracy(Trial& trial) {
  Tally tally;
  const auto judge = [&](const Brdf& function, bool isotropic) {
    const Material material = sample(fine_frame(trial.frame, isotropic), {4000, trial.domain}, function);
    for (int k = 0; k < 1500; ++k) add_errors(tally, trial, material, random_pair(trial.random));
  };
  for (const char* name : {"Brushed alum", "Fabric112", "Red velvet", "Yellow satin"}) judge(kurt(name), false);
  judge(isotropic_kurt(), true);
  return tally.row("5 Kurt materials, 4,000 samples: " + unit_of(trial.domain), limit_of(trial.domain));
}

struct Topic {
  std::string_view name;
  StressRow (*check)(Trial&);
  bool linear_only = false;
};

constexpr std::array kTopics = {
    Topic{"theta", check_theta},
    Topic{"turns", check_turns},
    Topic{"range", check_range},
    Topic{"zeros", check_zeros},
    Topic{"constants", check_constants},
    Topic{"linear", check_linear, true},
    Topic{"reciprocity", check_reciprocity},
    Topic{"isotropy", check_isotropy},
    Topic{"continuity", check_continuity},
    Topic{"minimum gap", check_minimum_gap},
    Topic{"single samples", check_single},
    Topic{"spikes", check_spikes},
    Topic{"accuracy", check_accuracy},
};

}  // namespace

std::vector<std::string> stress_topics() {
  std::vector<std::string> names;
  for (const Topic& topic : kTopics) names.emplace_back(topic.name);
  return names;
}

std::vector<StressRow> run_stress(std::uint64_t seed, const Progress& progress, const StressSubject& subject) {
  ProgressCounter counter(progress, kTopics.size() * kFrames.size() * kDomains.size());
  std::vector<StressRow> rows;
  for (const Topic& topic : kTopics) {
    for (const FrameId frame : kFrames) {
      for (const DomainKind domain : kDomains) {
        const bool wanted = subject.topic.empty() || subject.topic == topic.name;
        if (wanted && !(topic.linear_only && domain != DomainKind::kLinear)) {
          Trial trial = {frame, domain, std::mt19937_64(seed), subject};
          StressRow row = topic.check(trial);
          row.name = std::string(topic.name) + ", " + std::string(geometry(frame).name()) +
                     (domain == DomainKind::kLog ? ", log" : ", linear");
          rows.push_back(std::move(row));
        }
        if (!counter.advance()) return rows;
      }
    }
  }
  return rows;
}

}  // namespace sbrdf
