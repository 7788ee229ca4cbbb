#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/frame/frame.h"
#include "codec/material/value_domain.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// A BRDF as a short series in half/difference angles: what a transform leaves of a dense table. specs/sbrdf.md,
// section 14. With u and v what `Warp` makes of theta_h and theta_d, T_n Chebyshev polynomials and H harmonics of the
// azimuths, each field is
//
//     F = sum over terms of  step x q  x  T_a(2 u - 1) T_b(2 v - 1) H(phi_h, phi_d)
//
// The first field is the value (log domain) of the mean Y of all channels; the others, z_1 ... z_J, are how far the
// colour is from the mean one: f_c = Y (mean_c + sum z_j component_jc).

inline constexpr std::size_t kMostSeriesTerms = std::size_t{1} << 16U;
inline constexpr std::uint32_t kMostPolynomials = 64;  ///< along one polar axis
inline constexpr std::uint32_t kMostHarmonics = 32;    ///< along one azimuth
inline constexpr std::uint32_t kMostComponents = 8;
inline constexpr double kColourUnit = 32;  ///< of mean colours
/// Below this part of the reference, 2^-3, values are told apart by their difference: see ValueDomain.
inline constexpr int kSeriesFloorHalvings = 3;

/// How many functions there are along each axis. A term of degrees a, b and orders j, k belongs to the series if
/// a / theta_h + b / theta_d + j / phi_h + |k| / phi_d < 1. All are 1 or more; phi_h is 1 for isotropic materials.
struct SeriesShape {
  std::uint32_t theta_h = 1;
  std::uint32_t theta_d = 1;
  std::uint32_t phi_h = 1;
  std::uint32_t phi_d = 1;

  bool operator==(const SeriesShape&) const = default;
};

/// H: cos(j phi_h + 2 k phi_d), or sin of it, where the azimuths still mean something: at theta_h = 0 only phi_h +
/// phi_d does, at theta_d = 0 only phi_h. What depends on more than that is multiplied by sqrt(sin theta_h) if j is not
/// 2 k, and by sqrt(sin theta_d) if k is not 0.
struct Harmonic {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  std::int32_t j = 0;  ///< of phi_h, 0 or more
  std::int32_t k = 0;  ///< of 2 phi_d
  bool sine = false;
  std::uint32_t lower =
      kNone;  ///< the one with one order less, in the list of harmonics: what this one is likely to be

  /// Without its factors of theta; azimuths in radians.
  [[nodiscard]] double wave(double phi_h, double phi_d) const;
};

struct SeriesTerm {
  std::uint32_t a = 0;  ///< degree along theta_h
  std::uint32_t b = 0;  ///< degree along theta_d
  std::uint32_t harmonic = 0;
  std::uint32_t level = 0;  ///< 0 to kSeriesLevels - 1: what a coarser version of the material leaves out
};
inline constexpr std::uint32_t kSeriesLevels = 8;

/// The terms of a shape, in the order in which they are coded: by level, harmonic, b and a.
struct SeriesBasis {
  SeriesShape shape;
  std::vector<Harmonic> harmonics;
  std::vector<SeriesTerm> terms;
  std::vector<std::uint32_t> numbers;  ///< of the term [harmonic][b][a]; Harmonic::kNone where there is none

  [[nodiscard]] std::uint32_t number(std::uint32_t harmonic, std::uint32_t b, std::uint32_t a) const {
    return numbers[(std::size_t{harmonic} * shape.theta_d + b) * shape.theta_h + a];
  }
};
/// kUnsupported where there are more terms than can be, or a number of `shape` is beyond its limit.
[[nodiscard]] Result<SeriesBasis> make_basis(const SeriesShape& shape, const Symmetries& symmetries);

/// What makes polynomials of few degrees fit: the highlight, whatever its width, takes the greater part of u, where the
/// logarithm of a microfacet lobe, log(1 + (theta / width)^2), is a straight line; v is a power of theta_d.
struct Warp {
  double theta_max_deg = kPaperThetaMaxDeg;
  std::uint8_t width_step = 0;  ///< width = 2^(step / 8 - 6) degrees, up to 2^25.9: none at all
  std::uint8_t power_step = 0;  ///< power = (step + 1) / 8

  [[nodiscard]] double width_deg() const;
  [[nodiscard]] double power() const { return (power_step + 1) / 8.0; }
  [[nodiscard]] double u(double theta_h_deg) const;
  [[nodiscard]] double v(double theta_d_deg) const;
  [[nodiscard]] double theta_h_deg(double u) const;
  [[nodiscard]] double theta_d_deg(double v) const;

  bool operator==(const Warp&) const = default;
};

/// Values of all functions of a basis at one place: their products are those of its terms.
struct BasisFactors {
  std::array<double, kMostPolynomials> theta_h{};
  std::array<double, kMostPolynomials> theta_d{};
  std::vector<double> harmonics;
};
void evaluate_factors(const SeriesBasis& basis, const Warp& warp, const Coordinates& x, BasisFactors& factors);

/// The content of a dense file.
struct SeriesBrdf {
  Symmetries symmetries;
  std::vector<std::string> channels;
  SeriesShape shape;
  Warp warp;
  std::int32_t reference_step = 0;        ///< of the log domain of Y: 2^(step / 8) [1/sr]
  std::int32_t most_step = 0;             ///< |Y| is kept at or below the value of this logarithm, in eighths
  bool negative = false;                  ///< f may be below 0; else it is kept from that
  std::uint8_t fineness = 6;              ///< nodes of the table for each function along an axis, see make_table
  std::vector<std::int32_t> mean_colour;  ///< of all channels, in 32nds of Y
  std::uint32_t component_count = 0;      ///< J
  std::uint8_t colour_turn = 0;           ///< of three channels: the first component, see `component`
  std::vector<std::vector<std::int8_t>> components;     ///< of other numbers of channels: each, per channel, in 127ths
  std::uint8_t coefficient_step = 0;                    ///< of all fields: 2^(-step / 8)
  std::vector<std::vector<std::int32_t>> coefficients;  ///< q of each field, term by term
  std::string metadata;                                 ///< a JSON object; how the file came to be

  [[nodiscard]] std::size_t channel_count() const { return channels.size(); }
  [[nodiscard]] std::size_t field_count() const { return 1 + std::size_t{component_count}; }
  /// How much of channel `c` there is in a component. Those of three channels are turned by colour_turn / 256 of half a
  /// turn in the plane in which colours sum to 0, and stand at a right angle.
  [[nodiscard]] double component(std::size_t j, std::size_t c) const;
  [[nodiscard]] double step() const;
  /// How many are not 0.
  [[nodiscard]] std::size_t coefficient_count() const;
  /// Y where the first field is `v`, kept within its bounds. `map` is that of the domain.
  template <class Real>
  [[nodiscard]] Real mean_of(const DomainMap<Real>& map, Real v) const {
    const Real most = static_cast<Real>(most_step) / 8;
    const Real zero = map.forward(0);
    return map.inverse(std::clamp(v, negative ? std::min(most, 2 * zero - most) : std::min(most, zero), most));
  }
  /// The log domain of Y, and of every channel.
  [[nodiscard]] ValueDomain domain() const;
};

}  // namespace sbrdf::internal
