#include "codec/material/grey_shares.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr double kLeastGrey = 0.01;  // of the mean grey
constexpr double kRoom = 1.25;       // times what the values at hand need
constexpr double kLargestShare = 4;

double grey_of(std::span<const float> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

GreyShares::GreyShares(std::vector<float> shares) : shares_(std::move(shares)) {
  const double sum = std::accumulate(shares_.begin(), shares_.end(), 0.0);
  if (sum > 0) divisor_ = static_cast<double>(shares_.size()) + sum;
}

void GreyShares::add(std::span<float> values) const {
  if (!active()) return;
  for (std::size_t first = 0; first < values.size(); first += shares_.size()) {
    const std::span<float> pair = values.subspan(first, shares_.size());
    const double grey = grey_of(pair);
    for (std::size_t c = 0; c < pair.size(); ++c) {
      if (shares_[c] > 0) pair[c] = static_cast<float>(pair[c] + static_cast<double>(shares_[c]) * grey);
    }
  }
}

GreyShares choose_grey_shares(std::span<const float> values, std::size_t channel_count) {
  double mean = 0;
  for (std::size_t k = 0; k < values.size(); k += channel_count) {
    mean += std::max(0.0, grey_of(values.subspan(k, channel_count)));
  }
  mean /= std::max(1.0, static_cast<double>(values.size() / channel_count));
  std::vector<double> need(channel_count, 0);
  for (std::size_t k = 0; k < values.size(); k += channel_count) {
    const double grey = grey_of(values.subspan(k, channel_count));
    if (!(grey > 0 && grey >= kLeastGrey * mean)) continue;
    for (std::size_t c = 0; c < channel_count; ++c) need[c] = std::max(need[c], -values[k + c] / grey);
  }
  std::vector<float> shares;
  for (const double n : need) {
    shares.push_back(static_cast<float>(
        n > 0 ? std::min(kLargestShare, std::ceil(n * kRoom * GreyShares::kSteps + 1) / GreyShares::kSteps) : 0));
  }
  GreyShares chosen(std::move(shares));
  return chosen.active() ? chosen : GreyShares();
}

}  // namespace sbrdf::internal
