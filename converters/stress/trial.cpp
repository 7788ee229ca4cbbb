#include "converters/stress/trial.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sbrdf::internal::stress {

double limit_of(DomainKind domain) { return domain == DomainKind::kLog ? kLogLimit : kLinearLimit; }

std::string unit_of(DomainKind domain) {
  return domain == DomainKind::kLog ? "error relative to exact" : "error / local maximum";
}

void Tally::add(double error) {
  ++cases_;
  if (!std::isnan(worst_) && !(error <= worst_)) worst_ = error;
}

void Tally::count(bool right) {
  ++cases_;
  worst_ += right ? 0 : 1;
}

StressRow Tally::row(std::string what, double limit) const {
  return {"", std::move(what), cases_, worst_, limit, cases_ > 0 && worst_ <= limit};
}

Channels<float> Trial::at(const Material& material, const Coordinates& x) const {
  Channels<float> values;
  if (evaluation == StressEvaluation::kKernel) {
    material.kernel.evaluate_at(x, values);
  } else {
    material.rounded.evaluate_at(x, values);
  }
  return distorted(values);
}

Channels<float> Trial::operator()(const Material& material, const DirectionPair& pair) const {
  if (above_horizon(pair)) return at(material, geometry(material.lattice.spec.id).coordinates(pair));
  return distorted({});
}

Channels<float> Trial::distorted(Channels<float> values) const {
  if (subject.distort) {
    for (float& value : values) value = subject.distort(value);
  }
  return values;
}

double Trial::draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

bool same_bits(const Channels<float>& a, const Channels<float>& b) {
  const bool numbers = std::none_of(a.begin(), a.end(), [](float value) { return std::isnan(value); });
  return numbers && std::memcmp(a.data(), b.data(), sizeof a) == 0;
}

double relative(double difference, double scale) { return difference == 0 ? 0 : std::abs(difference) / scale; }

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

}  // namespace sbrdf::internal::stress
