#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "converters/difference/error_sums.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A difference between a source and itself seen another way: 100 x sum |f - f'| / sum (|f| + |f'|) / 2, and where
/// |f - f'| is largest (`reference` is f, `test` is f').
struct SelfDifference {
  double percent = 0;
  ValuePlace worst;
};

/// Over theta in 0, 5, ... up to the smaller of 80 degrees and theta_max, azimuths every 10 degrees, measured pairs
/// only: what reciprocity_difference_percent says where theta_max is 80 or more. 0 where the traits say so.
[[nodiscard]] SelfDifference reciprocity_of(const BrdfSource& source);

/// Of negative values, of pairs that were not measured, and of colours out of gamut: some channel below 0 while another
/// is above. In percent of all pairs above the horizon, and weighted by solid angle.
struct Shares {
  std::uint64_t count = 0;  ///< nodes or pairs that were looked at
  double negative_percent = 0, negative_solid_percent = 0;
  double unmeasured_percent = 0, unmeasured_solid_percent = 0;
  double gamut_percent = 0, gamut_solid_percent = 0;
  std::uint64_t not_finite = 0;  ///< values that are NaN or infinite though measured
  std::optional<ValuePlace>
      worst_gamut;  ///< of these the least f cos theta_i cos theta_v; `test` is the largest channel
};

/// Adds up Shares.
class ShareSums {
 public:
  /// `weight` counts the pair, `solid` is its solid angle; a pair that was not measured has NaN in the first channel
  /// and `measured` false.
  void add(const DirectionPair& pair, std::span<const double> colour, bool measured, double weight, double solid);
  void add(const ShareSums& other);
  [[nodiscard]] Shares shares() const;

 private:
  struct Kind {
    double weight = 0;
    double solid = 0;
    void add(const Kind& other) {
      weight += other.weight;
      solid += other.solid;
    }
  };
  Kind all_, negative_, unmeasured_, gamut_;
  double worst_ = 0;  ///< least f cos cos
  Shares found_;      ///< counts and the place only
};

/// What light and viewer changing places does to the values of a channel, and what that tells. Asymmetry is
/// (f - f') / (|f| + |f'|) for f' = f(v,i), in [-1, 1].
struct ChannelExchange {
  double asymmetry = 0;    ///< root of its mean square
  double agreement = 0;    ///< correlation with the sum over all channels, each divided by its asymmetry
  double with_others = 0;  ///< correlation with that sum less this channel: near -1 where i and v are exchanged
};

/// What a source is at pairs drawn at random up to its theta_max, many of them near the mirror direction and weighed in
/// return (HighlightDraw).
struct PairChecks {
  std::uint64_t pairs = 0;  ///< that were measured
  SelfDifference isotropy;  ///< f' after a turn of both directions by an angle drawn at random
  SelfDifference mirror_x;  ///< f' after phi -> -phi of both
  SelfDifference mirror_y;  ///< f' after phi -> 180 - phi of both
  Shares shares;
  std::vector<ChannelExchange> channels;
  std::size_t odd_channel = 0;     ///< the one with the least `with_others`
  double agreement_if_turned = 0;  ///< the least agreement of all channels if i and v changed places in that one
  /// Medians of |log f(i,v) - log f(v,i)| over pairs whose cosines differ by a factor of 1.2 or more: as it is, and
  /// with f divided by cos theta_v and by cos theta_i. A cosine that was multiplied in makes one of these near 0.
  double exchange_log = 0;
  double exchange_log_without_cos_v = 0;
  double exchange_log_without_cos_i = 0;
  /// log f(i,v) - log f(v,i) = slope (log cos theta_v - log cos theta_i), least squares.
  double exchange_slope = 0;
};
[[nodiscard]] PairChecks check_pairs(const BrdfSource& source);

/// How f_r grows towards the horizon: p of f_r ~ (cos theta_v)^-p, the median over lights at 15, 30, 45 and 60 degrees
/// and views to all sides, between two thetas. 0 is a value that stays, 1 a pole like that of a value divided by its
/// cosine.
struct GrazingGrowth {
  double from_deg = 0, to_deg = 0;
  double power = 0;
};
[[nodiscard]] std::vector<GrazingGrowth> grazing_growth(const BrdfSource& source);

}  // namespace sbrdf::internal
