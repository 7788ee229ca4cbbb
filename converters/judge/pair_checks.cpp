#include "converters/judge/pair_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "codec/search/random_pairs.h"
#include "converters/judge/compared_pairs.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kDrawn = 16384;
constexpr double kReciprocityStepDeg = 5;
constexpr double kReciprocityPhiStepDeg = 10;
/// Pairs whose cosines are nearer to each other say nothing about a cosine that was multiplied in.
const double kCosinesApart = std::log(1.2);

std::vector<float> values_at(const BrdfSource& source, std::span<const DirectionPair> pairs) {
  std::vector<float> values(pairs.size() * source.channel_count());
  evaluate_in_parallel(source, pairs, values);
  for (float& value : values) {
    if (!std::isfinite(value)) value = 0;  // counted by the shares
  }
  return values;
}

template <class Change>
std::vector<DirectionPair> changed(std::span<const DirectionPair> pairs, const Change& change) {
  std::vector<DirectionPair> result;
  result.reserve(pairs.size());
  for (const DirectionPair& pair : pairs) result.push_back(change(pair));
  return result;
}

DirectionPair exchanged(const DirectionPair& pair) { return {pair.v, pair.i}; }

void drop_unmeasured(const BrdfSource& source, std::vector<DirectionPair>& pairs, std::vector<double>* weights) {
  if (!source.mask_grid()) return;
  std::vector<std::uint8_t> flags(pairs.size());
  std::vector<std::uint8_t> back(pairs.size());
  source.measured(pairs, flags);
  source.measured(changed(pairs, exchanged), back);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (flags[k] == 0 || back[k] == 0) continue;
    if (weights != nullptr) (*weights)[kept] = (*weights)[k];
    pairs[kept++] = pairs[k];
  }
  pairs.resize(kept);
  if (weights != nullptr) weights->resize(kept);
}

/// `weights` may be empty: all 1.
SelfDifference difference(std::span<const DirectionPair> pairs, std::span<const double> weights,
                          std::span<const float> f, std::span<const float> other) {
  SelfDifference result;
  if (pairs.empty()) return result;
  const std::size_t channels = f.size() / pairs.size();
  double differences = 0;
  double sum = 0;
  double largest = 0;
  for (std::size_t k = 0; k < f.size(); ++k) {
    const double weight = weights.empty() ? 1 : weights[k / channels];
    const double a = f[k];
    const double b = other[k];
    const double apart = std::abs(a - b);
    differences += weight * apart;
    sum += weight * 0.5 * (std::abs(a) + std::abs(b));
    if (apart <= largest) continue;
    largest = apart;
    result.worst = {pairs[k / channels], k % channels, a, b};
  }
  result.percent = sum > 0 ? 100 * differences / sum : 0;
  return result;
}

/// The draw, and what the source is there and with light and viewer exchanged.
struct Sample {
  std::vector<DirectionPair> pairs;
  std::vector<double> weights;
  std::vector<float> there;
  std::vector<float> back;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void check_exchange(const Sample& sample, std::size_t channels, PairChecks& checks) {
  std::vector<double> as_is;
  std::vector<double> without_v;
  std::vector<double> without_i;
  double products = 0;
  double squares = 0;
  for (std::size_t k = 0; k < sample.there.size(); ++k) {
    const DirectionPair& pair = sample.pairs[k / channels];
    const double ratio = std::log(std::cos(pair.v.theta) / std::cos(pair.i.theta));
    if (!(std::abs(ratio) >= kCosinesApart) || sample.there[k] <= 0 || sample.back[k] <= 0) continue;
    const double step = std::log(static_cast<double>(sample.there[k])) - std::log(static_cast<double>(sample.back[k]));
    as_is.push_back(std::abs(step));
    without_v.push_back(std::abs(step - ratio));
    without_i.push_back(std::abs(step + ratio));
    products += sample.weights[k / channels] * step * ratio;
    squares += sample.weights[k / channels] * ratio * ratio;
  }
  checks.exchange_log = median(std::move(as_is));
  checks.exchange_log_without_cos_v = median(std::move(without_v));
  checks.exchange_log_without_cos_i = median(std::move(without_i));
  checks.exchange_slope = squares > 0 ? products / squares : 0;
}

/// The asymmetries of all channels at all pairs of a sample, each channel divided by its root mean square.
class Asymmetries {
 public:
  Asymmetries(const Sample& sample, std::size_t channels)
      : sample_(sample), sizes_(channels, 0), values_(sample.there.size()) {
    for (const double weight : sample.weights) weights_ += weight;
    for (std::size_t k = 0; k < values_.size(); ++k) {
      const double a = sample.there[k];
      const double b = sample.back[k];
      const double sum = std::abs(a) + std::abs(b);
      values_[k] = sum > 0 ? (a - b) / sum : 0;
      sizes_[k % channels] += sample.weights[k / channels] * values_[k] * values_[k];
    }
    for (double& size : sizes_) size = std::sqrt(size / weights_);
    for (std::size_t k = 0; k < values_.size(); ++k)
      values_[k] *= sizes_[k % channels] > 0 ? 1 / sizes_[k % channels] : 0;
  }

  [[nodiscard]] double size(std::size_t channel) const { return sizes_[channel]; }

  /// Mean products of each channel with the sum of all, and last the mean square of that sum. `turned` counts with the
  /// other sign; none where it is no channel.
  [[nodiscard]] std::vector<double> products_with_sum(std::size_t turned) const {
    const std::size_t channels = sizes_.size();
    std::vector<double> products(channels + 1, 0);
    for (std::size_t pair = 0; pair < sample_.pairs.size(); ++pair) {
      const double* const own = values_.data() + pair * channels;
      double sum = 0;
      for (std::size_t c = 0; c < channels; ++c) sum += c == turned ? -own[c] : own[c];
      for (std::size_t c = 0; c < channels; ++c) {
        products[c] += sample_.weights[pair] * sum * (c == turned ? -own[c] : own[c]);
      }
      products[channels] += sample_.weights[pair] * sum * sum;
    }
    for (double& product : products) product /= weights_;
    return products;
  }

 private:
  const Sample& sample_;
  double weights_ = 0;
  std::vector<double> sizes_;
  std::vector<double> values_;
};

void check_channels(const Sample& sample, std::size_t channels, PairChecks& checks) {
  const Asymmetries asymmetries(sample, channels);
  const auto ratio = [](double product, double square) { return square > 0 ? product / std::sqrt(square) : 0; };
  const std::vector<double> products = asymmetries.products_with_sum(channels);
  const double square = products[channels];
  checks.channels.assign(channels, {});
  for (std::size_t c = 0; c < channels; ++c) {
    ChannelExchange& channel = checks.channels[c];
    channel.asymmetry = asymmetries.size(c);
    if (channel.asymmetry == 0) continue;
    channel.agreement = ratio(products[c], square);
    // Less the channel itself, whose mean square is 1.
    channel.with_others = ratio(products[c] - 1, square - 2 * products[c] + 1);
    if (channel.with_others < checks.channels[checks.odd_channel].with_others) checks.odd_channel = c;
  }
  const std::vector<double> turned = asymmetries.products_with_sum(checks.odd_channel);
  checks.agreement_if_turned = 1;
  for (std::size_t c = 0; c < channels; ++c) {
    checks.agreement_if_turned = std::min(checks.agreement_if_turned, ratio(turned[c], turned[channels]));
  }
}

Shares shares_of_draw(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<const double> weights) {
  const std::size_t channels = source.channel_count();
  std::vector<float> values(pairs.size() * channels);
  evaluate_in_parallel(source, pairs, values);
  std::vector<std::uint8_t> flags(pairs.size(), 1);
  if (source.mask_grid()) source.measured(pairs, flags);
  ShareSums sums;
  std::vector<double> colour(channels);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (std::size_t c = 0; c < channels; ++c) colour[c] = values[k * channels + c];
    const double solid = std::sin(pairs[k].i.theta) * std::sin(pairs[k].v.theta);
    sums.add(pairs[k], colour, flags[k] != 0, weights[k], weights[k] * solid);
  }
  return sums.shares();
}

}  // namespace

void ShareSums::add(const DirectionPair& pair, std::span<const double> colour, bool measured, double weight,
                    double solid) {
  const Kind own = {weight, solid};
  ++found_.count;
  all_.add(own);
  if (!measured) {
    unmeasured_.add(own);
    return;
  }
  std::size_t least = 0;
  std::size_t most = 0;
  for (std::size_t c = 0; c < colour.size(); ++c) {
    if (!std::isfinite(colour[c])) {
      ++found_.not_finite;
      return;
    }
    if (colour[c] < colour[least]) least = c;
    if (colour[c] > colour[most]) most = c;
  }
  if (colour[least] >= 0) return;
  negative_.add(own);
  if (colour[most] <= 0) return;
  gamut_.add(own);
  const double seen = colour[least] * std::cos(pair.i.theta) * std::cos(pair.v.theta);
  if (found_.worst_gamut && seen >= worst_) return;
  worst_ = seen;
  found_.worst_gamut = {pair, least, colour[least], colour[most]};
}

void ShareSums::add(const ShareSums& other) {
  all_.add(other.all_);
  negative_.add(other.negative_);
  unmeasured_.add(other.unmeasured_);
  gamut_.add(other.gamut_);
  found_.count += other.found_.count;
  found_.not_finite += other.found_.not_finite;
  if (!other.found_.worst_gamut || (found_.worst_gamut && other.worst_ >= worst_)) return;
  worst_ = other.worst_;
  found_.worst_gamut = other.found_.worst_gamut;
}

Shares ShareSums::shares() const {
  Shares shares = found_;
  const auto percent = [](double part, double whole) { return whole > 0 ? 100 * part / whole : 0; };
  const auto set = [&](const Kind& kind, double& plain, double& solid) {
    plain = percent(kind.weight, all_.weight);
    solid = percent(kind.solid, all_.solid);
  };
  set(negative_, shares.negative_percent, shares.negative_solid_percent);
  set(unmeasured_, shares.unmeasured_percent, shares.unmeasured_solid_percent);
  set(gamut_, shares.gamut_percent, shares.gamut_solid_percent);
  return shares;
}

SelfDifference reciprocity_of(const BrdfSource& source) {
  if (source.traits().reciprocal) return {};
  const double theta_max = std::min(80.0, source.traits().theta_max_deg);
  const double phi_i_end = source.traits().isotropic ? kReciprocityPhiStepDeg : 360;
  std::vector<DirectionPair> pairs;
  for (double theta_i = 0; theta_i <= theta_max; theta_i += kReciprocityStepDeg) {
    for (double theta_v = 0; theta_v <= theta_i; theta_v += kReciprocityStepDeg) {
      for (double phi_i = 0; phi_i < phi_i_end; phi_i += kReciprocityPhiStepDeg) {
        for (double phi_v = 0; phi_v < 360; phi_v += kReciprocityPhiStepDeg) {
          pairs.push_back({direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)});
        }
      }
    }
  }
  drop_unmeasured(source, pairs, nullptr);
  return difference(pairs, {}, values_at(source, pairs), values_at(source, changed(pairs, exchanged)));
}

PairChecks check_pairs(const BrdfSource& source) {
  std::mt19937_64 random(11);
  // A table whose one theta is 0 still has a direction to look at.
  const HighlightDraw draw(std::max(source.traits().theta_max_deg, 0.01));
  Sample sample;
  for (std::size_t k = 0; k < kDrawn; ++k) {
    const WeightedPair drawn = draw(random);
    sample.pairs.push_back(drawn.pair);
    sample.weights.push_back(drawn.weight);
  }
  PairChecks checks;
  checks.shares = shares_of_draw(source, sample.pairs, sample.weights);
  drop_unmeasured(source, sample.pairs, &sample.weights);
  checks.pairs = sample.pairs.size();
  sample.there = values_at(source, sample.pairs);
  const auto seen = [&](const auto& change) {
    return difference(sample.pairs, sample.weights, sample.there, values_at(source, changed(sample.pairs, change)));
  };
  checks.isotropy = seen([&](const DirectionPair& pair) {
    const double turn = draw_uniform(random, 2 * kPi);
    return DirectionPair{{pair.i.theta, pair.i.phi + turn}, {pair.v.theta, pair.v.phi + turn}};
  });
  checks.mirror_x = seen([](const DirectionPair& pair) {
    return DirectionPair{{pair.i.theta, -pair.i.phi}, {pair.v.theta, -pair.v.phi}};
  });
  checks.mirror_y = seen([](const DirectionPair& pair) {
    return DirectionPair{{pair.i.theta, kPi - pair.i.phi}, {pair.v.theta, kPi - pair.v.phi}};
  });
  if (checks.pairs == 0) return checks;
  sample.back = values_at(source, changed(sample.pairs, exchanged));
  check_exchange(sample, source.channel_count(), checks);
  check_channels(sample, source.channel_count(), checks);
  return checks;
}

std::vector<GrazingGrowth> grazing_growth(const BrdfSource& source) {
  constexpr std::array kThetas = {85.0, 88.0, 89.5, 89.99};
  std::vector<std::vector<float>> values;
  for (const double theta : kThetas) {
    std::vector<DirectionPair> pairs;
    for (const double theta_i : {15, 30, 45, 60}) {
      for (double phi_i = 0; phi_i < (source.traits().isotropic ? 1 : 360); phi_i += 60) {
        for (double phi_v = 0; phi_v < 360; phi_v += 30) {
          pairs.push_back({direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta, phi_v)});
        }
      }
    }
    values.push_back(values_at(source, pairs));
  }
  std::vector<GrazingGrowth> result;
  for (std::size_t k = 0; k + 1 < kThetas.size(); ++k) {
    const double steps =
        std::log(std::cos(radians_from_degrees(kThetas[k])) / std::cos(radians_from_degrees(kThetas[k + 1])));
    std::vector<double> powers;
    for (std::size_t n = 0; n < values[k].size(); ++n) {
      if (values[k][n] <= 0 || values[k + 1][n] <= 0) continue;
      powers.push_back(std::log(static_cast<double>(values[k + 1][n]) / values[k][n]) / steps);
    }
    result.push_back({kThetas[k], kThetas[k + 1], median(std::move(powers))});
  }
  return result;
}

}  // namespace sbrdf::internal
