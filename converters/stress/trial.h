#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "converters/stress/stress.h"
#include "converters/stress/stress_materials.h"

// What the checks of the stress suite have in common.

namespace sbrdf::internal::stress {

inline constexpr double kLogLimit = 2e-5;     ///< of the exact value
inline constexpr double kLinearLimit = 1e-5;  ///< of the local maximum

/// What float evaluation is to keep within, and in which unit: see stress.h.
[[nodiscard]] double limit_of(DomainKind domain);
[[nodiscard]] std::string unit_of(DomainKind domain);

/// Collects the cases of one row. A NaN stays.
class Tally {
 public:
  /// A case with this error, 0 or more.
  void add(double error);
  /// For rows whose worst is the number of cases that are wrong.
  void count(bool right);
  /// The row, without its name. Passed: there were cases, and none is above the limit.
  [[nodiscard]] StressRow row(std::string what, double limit) const;

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
  StressEvaluation evaluation = StressEvaluation::kPlain;

  /// The material at a place of the padded lattice, by float evaluation, as the subject of the trial gives it back.
  [[nodiscard]] Channels<float> at(const Material& material, const Coordinates& x) const;
  /// The same for a pair of directions.
  [[nodiscard]] Channels<float> operator()(const Material& material, const DirectionPair& pair) const;
  [[nodiscard]] Channels<float> distorted(Channels<float> values) const;
  /// Uniform in [low, high).
  double draw(double low, double high);
};

/// The same bits, and numbers.
[[nodiscard]] bool same_bits(const Channels<float>& a, const Channels<float>& b);

/// |difference| / scale; 0 where there is no difference, whatever the scale.
[[nodiscard]] double relative(double difference, double scale);

/// Float against exact at a pair, by the rule of the domain: one case for each channel.
void add_errors(Tally& tally, const Trial& trial, const Material& material, const DirectionPair& pair);

}  // namespace sbrdf::internal::stress
