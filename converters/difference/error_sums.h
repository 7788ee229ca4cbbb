#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/search/held_back.h"
#include "codec/search/random_pairs.h"
#include "converters/difference/log_histogram.h"

namespace sbrdf::internal {

/// Where a value is, and what it is there.
struct ValuePlace {
  DirectionPair pair;
  std::size_t channel = 0;
  double reference = 0;  ///< [1/sr]
  double test = 0;       ///< [1/sr]
};

/// "R at theta_i 30, phi_i 0, theta_v 45, phi_v 180 degrees: f 0.25, r 0.5 1/sr", with the channel's name.
[[nodiscard]] std::string place_text(const ValuePlace& place, const std::vector<std::string>& channels);

/// Differences of a test r from a reference f. Means are over values, each with the weight of its pair; relative errors
/// |f - r| / max(|f|, floor) are of the values whose denominator is not 0. conventions.md defines each.
struct ErrorFigures {
  double mre_percent = 0;            ///< mean of the relative errors; NaN where there is none
  double rel_l1_percent = 0;         ///< 100 x sum |f - r| / sum |f|
  double cosine_rel_l1_percent = 0;  ///< the same, with cos theta_i cos theta_v before both
  double rmse = 0;                   ///< [1/sr]
  double max_abs = 0;                ///< largest |f - r| [1/sr]
  ValuePlace max_abs_at;
  double max_relative_percent = 0;  ///< largest relative error; NaN where there is none
  ValuePlace max_relative_at;
  double relative_p99_percent = 0;   ///< that 99 % of the relative errors do not exceed, to 0.4 % of itself
  double relative_p999_percent = 0;  ///< 99.9 %
  double psnr_db = 0;                ///< 20 log10(max |f| / rmse); infinite for equal sources
  std::uint64_t mre_left_out = 0;    ///< values with f = 0 and no floor: no relative error
  std::uint64_t mre_values = 0;      ///< the others
};

/// What the figures of one channel are made of, but for the percentiles. A NaN on either side shows in every figure.
class ErrorSums {
 public:
  explicit ErrorSums(double floor = 0) : floor_(floor) {}

  void add(const ValuePlace& value, double weight = 1, double cosines = 1);
  /// As if the other's values had been added one by one, up to rounding: the first of equal extremes stays.
  void add(const ErrorSums& other);

  [[nodiscard]] ErrorFigures figures() const;

 private:
  struct Extreme {
    double value = 0;
    ValuePlace at;
    void take(double candidate, const ValuePlace& place);
  };

  double floor_;
  double relative_ = 0;
  double relative_weight_ = 0;
  double difference_ = 0;
  double reference_ = 0;
  double cosine_difference_ = 0;
  double cosine_reference_ = 0;
  double squares_ = 0;
  double weight_ = 0;
  double max_reference_ = 0;
  Extreme largest_;
  Extreme largest_relative_;
  std::uint64_t relative_count_ = 0;
  std::uint64_t count_ = 0;
};

/// The relative error of a value; negative where it has none.
[[nodiscard]] double relative_error(double f, double r, double floor);

/// The sums of all channels side by side.
class ChannelErrors {
 public:
  ChannelErrors(std::size_t channel_count, double floor) : floor_(floor), sums_(channel_count, ErrorSums(floor)) {}

  /// One value for each channel. Its relative errors go into the histogram of their channel.
  void add(const WeightedPair& at, std::span<const float> f, std::span<const float> r,
           std::span<LogHistogram> relative);
  void add(const ChannelErrors& other);

  /// Of each channel; with the histograms of all that was added.
  [[nodiscard]] std::vector<ErrorFigures> channels(std::span<const LogHistogram> relative) const;
  /// Of all channels together, each counting alike.
  [[nodiscard]] ErrorFigures all(std::span<const LogHistogram> relative) const;

 private:
  /// Pairs of a grid have the same angle many times over.
  struct LastCosine {
    double angle = 0;
    double cosine = 1;
    double of(double next) {
      if (next != angle) cosine = std::cos(angle = next);
      return cosine;
    }
  };
  double floor_;
  std::vector<ErrorSums> sums_;
  LastCosine cos_i_, cos_v_;
};

/// Of values on held-back directions, all channels together, with the floor of mre_floor().
[[nodiscard]] ErrorFigures figures_of(const HeldBack& held_back, std::span<const float> values);

}  // namespace sbrdf::internal
