#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sbrdf::internal {

/// What is added to channels so that they do not change sign: out-of-gamut colours have a channel far below zero beside
/// others far above, and neither logarithms nor their splines pass through zero well. With the grey g, the mean of all
/// channels of a pair of directions, a material stores and interpolates
///
///   w_c = f_c + share_c g        and gives back        f_c = w_c - share_c g,   g = sum w / (C + sum share)
///
/// Shares of 0 leave a channel as it is, bit for bit.
class GreyShares {
 public:
  /// Shares are whole numbers of these parts of 1, so many at most: as a file has them.
  static constexpr float kSteps = 64;
  static constexpr std::uint32_t kMostSteps = 1024;

  GreyShares() = default;
  /// One share for each channel, none negative; or none at all.
  explicit GreyShares(std::vector<float> shares);

  /// Whether any channel changes.
  [[nodiscard]] bool active() const { return divisor_ > 0; }
  [[nodiscard]] std::span<const float> shares() const { return shares_; }

  /// f becomes w, pair by pair, channel fastest.
  void add(std::span<float> values) const;
  /// w of one pair becomes f.
  template <class Real>
  void take_off(std::span<Real> values) const {
    if (!active()) return;
    Real sum = 0;
    for (const Real w : values) sum += w;
    const Real grey = sum / static_cast<Real>(divisor_);
    for (std::size_t c = 0; c < values.size(); ++c) {
      if (shares_[c] > 0) values[c] -= static_cast<Real>(shares_[c]) * grey;
    }
  }

  bool operator==(const GreyShares&) const = default;

 private:
  std::vector<float> shares_;
  double divisor_ = 0;  ///< C + sum of shares; 0 where none is above 0
};

/// The shares with which no channel of these values (channel fastest) is negative, with some room to spare, as far as
/// shares of at most 4 can do it: pairs whose grey is below a hundredth of the mean grey, where noise decides about the
/// sign, do not count. In steps of 1/64, and 0 for a channel that is never negative. None where no channel is.
[[nodiscard]] GreyShares choose_grey_shares(std::span<const float> values, std::size_t channel_count);

}  // namespace sbrdf::internal
