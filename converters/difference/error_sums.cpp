#include "converters/difference/error_sums.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sbrdf::internal {
namespace {

double sum_ratio_percent(double difference, double reference) {
  return difference == 0 ? 0 : 100 * difference / reference;
}

void set_percentiles(ErrorFigures& figures, const LogHistogram& relative) {
  figures.relative_p99_percent = 100 * relative.quantile(0.99);
  figures.relative_p999_percent = 100 * relative.quantile(0.999);
}

}  // namespace

std::string place_text(const ValuePlace& place, const std::vector<std::string>& channels) {
  const auto degrees = [](double radians) { return fmt::format("{:.6g}", degrees_from_radians(radians)); };
  const DirectionPair& pair = place.pair;
  return fmt::format("{} at theta_i {}, phi_i {}, theta_v {}, phi_v {} degrees: f {:.4g}, r {:.4g} 1/sr",
                     channels[place.channel], degrees(pair.i.theta), degrees(pair.i.phi), degrees(pair.v.theta),
                     degrees(pair.v.phi), place.reference, place.test);
}

double relative_error(double f, double r, double floor) {
  const double denominator = std::max(std::abs(f), floor);
  return denominator == 0 ? -1 : std::abs(f - r) / denominator;  // a NaN is let through, so that it shows
}

void ErrorSums::Extreme::take(double candidate, const ValuePlace& place) {
  if (std::isnan(value) || !(candidate > value || std::isnan(candidate))) return;
  value = candidate;
  at = place;
}

void ErrorSums::add(const ValuePlace& value, double weight, double cosines) {
  const double f = value.reference;
  const double d = std::abs(f - value.test);
  const double relative = relative_error(f, value.test, floor_);
  if (!(relative < 0)) {
    relative_ += weight * relative;
    relative_weight_ += weight;
    ++relative_count_;
    largest_relative_.take(relative, value);
  }
  difference_ += weight * d;
  reference_ += weight * std::abs(f);
  cosine_difference_ += weight * cosines * d;
  cosine_reference_ += weight * cosines * std::abs(f);
  squares_ += weight * d * d;
  weight_ += weight;
  largest_.take(d, value);
  max_reference_ = std::max(max_reference_, std::abs(f));
  ++count_;
}

void ErrorSums::add(const ErrorSums& other) {
  relative_ += other.relative_;
  relative_weight_ += other.relative_weight_;
  difference_ += other.difference_;
  reference_ += other.reference_;
  cosine_difference_ += other.cosine_difference_;
  cosine_reference_ += other.cosine_reference_;
  squares_ += other.squares_;
  weight_ += other.weight_;
  largest_.take(other.largest_.value, other.largest_.at);
  largest_relative_.take(other.largest_relative_.value, other.largest_relative_.at);
  max_reference_ = std::max(max_reference_, other.max_reference_);
  relative_count_ += other.relative_count_;
  count_ += other.count_;
}

ErrorFigures ErrorSums::figures() const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  ErrorFigures result;
  result.mre_percent = relative_count_ > 0 ? 100 * relative_ / relative_weight_ : kNone;
  result.rel_l1_percent = sum_ratio_percent(difference_, reference_);
  result.cosine_rel_l1_percent = sum_ratio_percent(cosine_difference_, cosine_reference_);
  result.rmse = std::sqrt(squares_ / weight_);
  result.max_abs = largest_.value;
  result.max_abs_at = largest_.at;
  result.max_relative_percent = relative_count_ > 0 ? 100 * largest_relative_.value : kNone;
  result.max_relative_at = largest_relative_.at;
  result.psnr_db =
      result.rmse == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(max_reference_ / result.rmse);
  result.mre_values = relative_count_;
  result.mre_left_out = count_ - relative_count_;
  return result;
}

void ChannelErrors::add(const WeightedPair& at, std::span<const float> f, std::span<const float> r,
                        std::span<LogHistogram> relative) {
  const double cosines = cos_i_.of(at.pair.i.theta) * cos_v_.of(at.pair.v.theta);
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    sums_[c].add({at.pair, c, f[c], r[c]}, at.weight, cosines);
    const double error = relative_error(f[c], r[c], floor_);
    if (!(error < 0)) relative[c].add(error, at.weight);
  }
}

void ChannelErrors::add(const ChannelErrors& other) {
  for (std::size_t c = 0; c < sums_.size(); ++c) sums_[c].add(other.sums_[c]);
}

std::vector<ErrorFigures> ChannelErrors::channels(std::span<const LogHistogram> relative) const {
  std::vector<ErrorFigures> figures;
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    figures.push_back(sums_[c].figures());
    set_percentiles(figures.back(), relative[c]);
  }
  return figures;
}

ErrorFigures ChannelErrors::all(std::span<const LogHistogram> relative) const {
  ErrorSums sums(floor_);
  LogHistogram together;
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    sums.add(sums_[c]);
    together.add(relative[c]);
  }
  ErrorFigures figures = sums.figures();
  set_percentiles(figures, together);
  return figures;
}

ErrorFigures figures_of(const HeldBack& held_back, std::span<const float> values) {
  const std::size_t count = held_back.pairs.size();
  if (count == 0) return {};
  const std::size_t channels = values.size() / count;
  const std::span<const float> reference = held_back.values;
  ChannelErrors errors(channels, mre_floor(held_back));
  std::vector<LogHistogram> relative(channels);
  for (std::size_t k = 0; k < count; ++k) {
    errors.add({held_back.pairs[k], held_back.weights[k] * static_cast<double>(count)},
               reference.subspan(k * channels, channels), values.subspan(k * channels, channels), relative);
  }
  return errors.all(relative);
}

}  // namespace sbrdf::internal
