#include "codec/series/series.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMostProducts = 1U << 21U;

/// cos stays under phi -> -phi of both directions. phi -> 180 - phi makes cos(x) into cos(180 j - x), which is cos(x)
/// for even j and -cos(x) for odd; sin the other way round.
bool keeps(const Symmetries& symmetries, std::int32_t j, bool sine) {
  if (symmetries.mirror_x && sine) return false;
  return !symmetries.mirror_y || sine == (j % 2 != 0);
}

std::vector<Harmonic> list_harmonics(const SeriesShape& shape, const Symmetries& symmetries) {
  const auto most_k = static_cast<std::int32_t>(shape.phi_d) - 1;
  std::vector<Harmonic> list;
  for (std::int32_t j = 0; j < static_cast<std::int32_t>(shape.phi_h); ++j) {
    for (std::int32_t size = 0; size <= most_k; ++size) {
      // With j = 0 both signs of k are one function.
      const int signs = size == 0 || j == 0 ? 1 : 2;
      for (int sign = 0; sign < signs; ++sign) {
        const std::int32_t k = sign == 0 ? size : -size;
        for (const bool sine : {false, true}) {
          if ((sine && j == 0 && k == 0) || !keeps(symmetries, j, sine)) continue;
          list.push_back({j, k, sine});
        }
      }
    }
  }
  return list;
}

// One order less of phi_d, or, where that is 0, of phi_h: one or two less, as the symmetries leave it.
void link_harmonics(std::vector<Harmonic>& list) {
  const auto find = [&](std::int32_t j, std::int32_t k, bool sine) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const Harmonic& each) {
      return each.j == j && each.k == k && each.sine == sine;
    });
    return found == list.end() ? Harmonic::kNone : static_cast<std::uint32_t>(found - list.begin());
  };
  for (Harmonic& each : list) {
    if (each.k != 0) {
      each.lower = find(each.j, each.k - (each.k > 0 ? 1 : -1), each.sine);
    } else {
      for (std::int32_t less = 1; less <= 2 && each.lower == Harmonic::kNone; ++less) {
        each.lower = find(each.j - less, 0, each.sine);
      }
    }
  }
}

void polynomials(double x, std::uint32_t count, std::array<double, kMostPolynomials>& values) {
  values[0] = 1;
  if (count > 1) values[1] = x;
  for (std::uint32_t n = 2; n < count; ++n) values[n] = 2 * x * values[n - 1] - values[n - 2];
}

}  // namespace

Result<SeriesBasis> make_basis(const SeriesShape& shape, const Symmetries& symmetries) {
  const auto within = [](std::uint32_t count, std::uint32_t most) { return count >= 1 && count <= most; };
  if (!within(shape.theta_h, kMostPolynomials) || !within(shape.theta_d, kMostPolynomials) ||
      !within(shape.phi_h, kMostHarmonics) || !within(shape.phi_d, kMostHarmonics)) {
    return unsupported("[SD-3] a series with more functions than " + std::to_string(kMostPolynomials) +
                       " along theta, or " + std::to_string(kMostHarmonics) + " along phi, or none");
  }
  const std::uint64_t all = std::uint64_t{shape.theta_h} * shape.theta_d * shape.phi_h * shape.phi_d;
  if (all > kMostProducts) return unsupported("[SD-3] a series of " + std::to_string(all) + " products");
  SeriesBasis basis{shape, list_harmonics(shape, symmetries), {}, {}};
  link_harmonics(basis.harmonics);
  for (std::uint32_t h = 0; h < basis.harmonics.size(); ++h) {
    const Harmonic& harmonic = basis.harmonics[h];
    const std::uint64_t orders = static_cast<std::uint64_t>(harmonic.j) * (all / shape.phi_h) +
                                 static_cast<std::uint64_t>(std::abs(harmonic.k)) * (all / shape.phi_d);
    for (std::uint32_t b = 0; b < shape.theta_d; ++b) {
      for (std::uint32_t a = 0; a < shape.theta_h; ++a) {
        const std::uint64_t sum = orders + a * (all / shape.theta_h) + b * (all / shape.theta_d);
        if (sum >= all) break;
        basis.terms.push_back({a, b, h, static_cast<std::uint32_t>(kSeriesLevels * sum / all)});
        if (basis.terms.size() > kMostSeriesTerms) {
          return unsupported("[SD-3] a series of more than " + std::to_string(kMostSeriesTerms) + " terms");
        }
      }
    }
  }
  std::stable_sort(basis.terms.begin(), basis.terms.end(),
                   [](const SeriesTerm& x, const SeriesTerm& y) { return x.level < y.level; });
  basis.numbers.assign(basis.harmonics.size() * shape.theta_d * shape.theta_h, Harmonic::kNone);
  for (std::uint32_t n = 0; n < basis.terms.size(); ++n) {
    const SeriesTerm& term = basis.terms[n];
    basis.numbers[(std::size_t{term.harmonic} * shape.theta_d + term.b) * shape.theta_h + term.a] = n;
  }
  return basis;
}

double Harmonic::wave(double phi_h, double phi_d) const {
  const double angle = j * phi_h + 2 * k * phi_d;
  return sine ? std::sin(angle) : std::cos(angle);
}

double Warp::width_deg() const { return std::exp2(width_step / 8.0 - 6); }

double Warp::u(double theta_h_deg) const {
  const double x = theta_h_deg / width_deg();
  const double end = theta_max_deg / width_deg();
  return std::log1p(x * x) / std::log1p(end * end);
}

double Warp::theta_h_deg(double u) const {
  const double end = theta_max_deg / width_deg();
  return width_deg() * std::sqrt(std::expm1(u * std::log1p(end * end)));
}

double Warp::v(double theta_d_deg) const { return std::pow(theta_d_deg / theta_max_deg, power()); }

double Warp::theta_d_deg(double v) const { return theta_max_deg * std::pow(v, 1 / power()); }

void evaluate_factors(const SeriesBasis& basis, const Warp& warp, const Coordinates& x, BasisFactors& factors) {
  const double theta_h = std::min(x[kVertical], warp.theta_max_deg);
  const double theta_d = std::min(x[kHorizontal], warp.theta_max_deg);
  polynomials(2 * warp.u(theta_h) - 1, basis.shape.theta_h, factors.theta_h);
  polynomials(2 * warp.v(theta_d) - 1, basis.shape.theta_d, factors.theta_d);
  const double at_h = std::sqrt(std::sin(radians_from_degrees(theta_h)));
  const double at_d = std::sqrt(std::sin(radians_from_degrees(theta_d)));
  const double phi_h = radians_from_degrees(x[kAxial]);
  const double phi_d = radians_from_degrees(x[kDiagonal]);
  factors.harmonics.resize(basis.harmonics.size());
  for (std::size_t h = 0; h < basis.harmonics.size(); ++h) {
    const Harmonic& each = basis.harmonics[h];
    factors.harmonics[h] = each.wave(phi_h, phi_d) * (each.j == 2 * each.k ? 1 : at_h) * (each.k == 0 ? 1 : at_d);
  }
}

double SeriesBrdf::step() const { return std::exp2(-coefficient_step / 8.0); }

std::size_t SeriesBrdf::coefficient_count() const {
  std::size_t count = 0;
  for (const auto& field : coefficients) {
    count += field.size() - static_cast<std::size_t>(std::count(field.begin(), field.end(), 0));
  }
  return count;
}

double SeriesBrdf::component(std::size_t j, std::size_t c) const {
  if (channels.size() != 3) return components[j][c] / 127.0;
  const std::array<double, 3> first = {std::sqrt(1.0 / 2), -std::sqrt(1.0 / 2), 0};
  const std::array<double, 3> second = {std::sqrt(1.0 / 6), std::sqrt(1.0 / 6), -2 * std::sqrt(1.0 / 6)};
  const double turn = colour_turn * (kPi / 256) + static_cast<double>(j) * (kPi / 2);
  return std::cos(turn) * first[c] + std::sin(turn) * second[c];
}

ValueDomain SeriesBrdf::domain() const {
  ValueDomain domain;
  domain.kind = DomainKind::kLog;
  domain.reference.assign(channels.size(), static_cast<float>(std::exp2(reference_step / 8.0)));
  domain.floor_halvings = kSeriesFloorHalvings;
  return domain;
}

}  // namespace sbrdf::internal
