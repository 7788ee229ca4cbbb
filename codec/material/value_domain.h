#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sbrdf::internal {

/// The numbers stand in files and never change their meaning.
enum class DomainKind : std::uint8_t { kLinear = 1, kLog = 2 };

/// Below so many halvings of the reference there is nothing that a float could tell apart.
inline constexpr int kMaxFloorHalvings = 255;

/// In which values the slices are interpolated and summed. Stored samples are always f_r itself.
///
/// Log: v = log(f / reference) from `floor` upwards, and the tangent of that curve below it, down to f = 0, so that v
/// is smooth, can be inverted, and has a place for an exact zero, which comes back as zero. Negative values, which
/// measured data has, are the mirror image: the tangent down to -floor, and a logarithm of -f below. f = reference
/// gives v = 0, so a constant material comes back to the last bit.
///
/// At f = floor the logarithm is L = log(floor / reference) and its slope 1 / floor, so the tangent there is
///
///   v = L + (f - floor) / floor = z + f / floor        with        z = L - 1, the value of f = 0
///
/// and v - z is odd in f: f / floor for |f| < floor, else 1 + log(|f| / floor) with the sign of f.
struct ValueDomain {
  DomainKind kind = DomainKind::kLinear;
  std::vector<float> reference;  ///< log only: per channel, positive
  int floor_halvings = 0;        ///< log only, 0 to kMaxFloorHalvings

  /// Log only: the reference, halved so often, of a channel; but no less than 2^-126 unless the reference is.
  [[nodiscard]] float floor(std::size_t channel) const {
    const float halved = std::ldexp(reference[channel], -floor_halvings);
    return std::min(reference[channel], std::max(halved, std::numeric_limits<float>::min()));
  }

  bool operator==(const ValueDomain&) const = default;
};

/// A value domain for one channel and one arithmetic. Both ways rise strictly, and `inverse(forward(f))` is f up to
/// rounding; exactly so for f = 0 and f = reference, and always in the linear domain.
template <class Real>
class DomainMap {
 public:
  DomainMap() = default;
  DomainMap(const ValueDomain& domain, std::size_t channel) : log_(domain.kind == DomainKind::kLog) {
    if (!log_) return;
    reference_ = static_cast<Real>(domain.reference[channel]);
    floor_ = static_cast<Real>(domain.floor(channel));
    const long double at_floor =
        std::log(static_cast<long double>(domain.floor(channel)) / static_cast<long double>(domain.reference[channel]));
    at_floor_ = static_cast<Real>(at_floor);
    at_zero_ = static_cast<Real>(at_floor - 1.0L);
  }

  /// v of f_r [1/sr], any finite value.
  [[nodiscard]] Real forward(Real f) const {
    if (!log_) return f;
    if (f >= floor_) {
      const Real ratio = f / reference_;
      return std::isfinite(ratio) ? std::log(ratio) : std::log(f) - std::log(reference_);
    }
    if (f > -floor_) return at_floor_ - (Real(1) - f / floor_);
    return at_zero_ - Real(1) - std::log(-f / floor_);
  }

  /// f_r of v. A sum of slices may ask for more than Real holds: infinite there.
  [[nodiscard]] Real inverse(Real v) const {
    if (!log_) return v;
    if (v > kHalfRange) return reference_ * std::exp(v / 2) * std::exp(v / 2);  // exp(v) alone may be infinite
    if (v >= at_floor_) return reference_ * std::exp(v);
    if (v == at_zero_) return 0;
    if (v > at_zero_ - Real(1)) return floor_ * (Real(1) - (at_floor_ - v));
    return -floor_ * std::exp(at_zero_ - Real(1) - v);
  }

 private:
  static constexpr Real kHalfRange = 64;

  bool log_ = false;
  Real reference_ = 1;
  Real floor_ = 1;
  Real at_floor_ = 0;  ///< L above: v of the floor
  Real at_zero_ = 0;   ///< z above: v of 0; rounded once from long double, as L is
};

/// The log domain for values like these (channel fastest): the reference is the median positive value of a channel, the
/// floor `2^-floor_halvings` of it. A channel without a positive value gets reference 1.
[[nodiscard]] ValueDomain choose_log_domain(std::span<const float> values, std::size_t channel_count,
                                            int floor_halvings);

/// Below this many halvings of the median, values are told apart by their difference rather than by their ratio.
inline constexpr int kDefaultFloorHalvings = 10;

}  // namespace sbrdf::internal
