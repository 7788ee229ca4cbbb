#include "codec/series/series_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "codec/evaluation/tables/slice_tables.h"
#include "codec/material/value_domain.h"
#include "formats/core/directions.h"
#include "formats/core/parallel.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {
namespace {

constexpr double kLeastGapDeg = 0.002;
constexpr float kMostValue = 0x1p120F;  // [1/sr]: no series that means anything comes near

/// 0 to 1, dense at both ends.
double chebyshev_point(std::size_t k, std::size_t gaps) {
  return 0.5 - 0.5 * std::cos(kPi * static_cast<double>(k) / static_cast<double>(gaps));
}

template <class Place>
std::vector<double> polar_nodes(std::uint32_t functions, std::uint32_t fineness, double end_deg, const Place& place) {
  if (functions == 1) return {0};
  const std::size_t gaps = std::size_t{functions} * fineness;
  std::vector<double> nodes = {0};
  for (std::size_t k = 1; k < gaps; ++k) {
    const double node = place(chebyshev_point(k, gaps));
    if (node - nodes.back() >= kLeastGapDeg && end_deg - node >= kLeastGapDeg) nodes.push_back(node);
  }
  nodes.push_back(end_deg);
  return nodes;
}

std::vector<double> azimuth_nodes(std::uint32_t functions, std::uint32_t fineness, double turn_deg) {
  if (functions == 1) return {0};
  const std::size_t gaps = std::size_t{2} * functions * fineness;
  std::vector<double> nodes;
  for (std::size_t k = 0; k <= gaps; ++k) {
    nodes.push_back(turn_deg * static_cast<double>(k) / static_cast<double>(gaps));
  }
  return nodes;
}

/// Fills the table. What the series is at a node is worked out in three steps, each over one axis more: over theta_d,
/// over theta_h, over both azimuths.
class TableMaker {
 public:
  TableMaker(const SeriesBrdf& brdf, const SeriesBasis& basis, const std::array<std::vector<double>, kAxisCount>& nodes)
      : brdf_(brdf), basis_(basis), nodes_(nodes), map_(brdf.domain(), 0) {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      factors_[axis].resize(nodes[axis].size());
      for (std::size_t k = 0; k < nodes[axis].size(); ++k) {
        Coordinates x{};
        x[axis] = nodes[axis][k];
        evaluate_factors(basis, brdf.warp, x, factors_[axis][k]);
      }
    }
    make_waves();
    colours_.resize(brdf.channel_count() * brdf.field_count());
    for (std::size_t c = 0; c < brdf.channel_count(); ++c) {
      colours_[c * brdf.field_count()] = static_cast<float>(brdf.mean_colour[c] / kColourUnit);
      for (std::size_t j = 0; j < brdf.component_count; ++j) {
        colours_[c * brdf.field_count() + 1 + j] = static_cast<float>(brdf.component(j, c));
      }
    }
  }

  void fill(std::vector<float>& values) const {
    const std::size_t channels = brdf_.channel_count();
    const std::size_t inner = nodes_[kAxial].size() * nodes_[kDiagonal].size() * channels;
    values.resize(inner * nodes_[kHorizontal].size() * nodes_[kVertical].size());
    parallel_for(nodes_[kHorizontal].size(), [&](std::uint64_t d) {
      const std::vector<double> along_h = sum_over_theta_d(static_cast<std::size_t>(d));
      for (std::size_t h = 0; h < nodes_[kVertical].size(); ++h) {
        const std::size_t first = inner * (h * nodes_[kHorizontal].size() + static_cast<std::size_t>(d));
        fill_azimuths(sum_over_theta_h(along_h, static_cast<std::size_t>(d), h),
                      std::span(values).subspan(first, inner));
      }
    });
  }

 private:
  // Without the parts that depend on the polar angles.
  void make_waves() {
    for (const double phi_d : nodes_[kDiagonal]) {
      for (const double phi_h : nodes_[kAxial]) {
        for (const Harmonic& each : basis_.harmonics) {
          waves_.push_back(static_cast<float>(each.wave(radians_from_degrees(phi_h), radians_from_degrees(phi_d))));
        }
      }
    }
  }

  // [field][harmonic][a]
  [[nodiscard]] std::vector<double> sum_over_theta_d(std::size_t d) const {
    const std::size_t stride = basis_.shape.theta_h;
    std::vector<double> sums(brdf_.field_count() * basis_.harmonics.size() * stride);
    const double step = brdf_.step();
    for (std::size_t f = 0; f < brdf_.field_count(); ++f) {
      for (std::size_t n = 0; n < basis_.terms.size(); ++n) {
        const std::int32_t q = brdf_.coefficients[f][n];
        if (q == 0) continue;
        const SeriesTerm& term = basis_.terms[n];
        sums[(f * basis_.harmonics.size() + term.harmonic) * stride + term.a] +=
            step * q * factors_[kHorizontal][d].theta_d[term.b];
      }
    }
    return sums;
  }

  // [field][harmonic]
  [[nodiscard]] std::vector<float> sum_over_theta_h(std::span<const double> sums, std::size_t d, std::size_t h) const {
    const double at_h = std::sqrt(std::sin(radians_from_degrees(nodes_[kVertical][h])));
    const double at_d = std::sqrt(std::sin(radians_from_degrees(nodes_[kHorizontal][d])));
    const std::size_t stride = basis_.shape.theta_h;
    std::vector<float> amplitudes;
    for (std::size_t f = 0; f < brdf_.field_count(); ++f) {
      for (std::size_t k = 0; k < basis_.harmonics.size(); ++k) {
        double sum = 0;
        for (std::size_t a = 0; a < stride; ++a) {
          sum += sums[(f * basis_.harmonics.size() + k) * stride + a] * factors_[kVertical][h].theta_h[a];
        }
        const Harmonic& each = basis_.harmonics[k];
        sum *= (each.j == 2 * each.k ? 1 : at_h) * (each.k == 0 ? 1 : at_d);
        amplitudes.push_back(static_cast<float>(sum));
      }
    }
    return amplitudes;
  }

  void fill_azimuths(std::span<const float> amplitudes, std::span<float> values) const {
    const std::size_t fields = brdf_.field_count();
    const std::size_t harmonics = basis_.harmonics.size();
    std::vector<float> field(fields);
    const std::size_t channels = brdf_.channel_count();
    for (std::size_t at = 0; at * channels < values.size(); ++at) {
      const float* wave = waves_.data() + at * harmonics;
      for (std::size_t f = 0; f < fields; ++f) {
        float sum = 0;
        for (std::size_t k = 0; k < harmonics; ++k) sum += amplitudes[f * harmonics + k] * wave[k];
        field[f] = sum;
      }
      const float mean = brdf_.mean_of(map_, field[0]);
      for (std::size_t c = 0; c < channels; ++c) {
        const float* colour = colours_.data() + c * fields;
        float part = colour[0];
        for (std::size_t f = 1; f < fields; ++f) part += colour[f] * field[f];
        const float f_r = std::clamp(mean * part, brdf_.negative ? -kMostValue : 0.0F, kMostValue);
        values[at * channels + c] = map_.forward(f_r);
      }
    }
  }

  const SeriesBrdf& brdf_;
  const SeriesBasis& basis_;
  const std::array<std::vector<double>, kAxisCount>& nodes_;
  DomainMap<float> map_;
  std::array<std::vector<BasisFactors>, kAxisCount> factors_;
  std::vector<float> waves_;    ///< [phi_d][phi_h][harmonic]
  std::vector<float> colours_;  ///< [channel][field]: the mean one, and each component
};

}  // namespace

std::array<std::vector<double>, kAxisCount> table_nodes(const SeriesBrdf& brdf) {
  const Warp& warp = brdf.warp;
  const SeriesShape& shape = brdf.shape;
  return {azimuth_nodes(shape.phi_h, brdf.fineness, 360), azimuth_nodes(shape.phi_d, brdf.fineness, 180),
          polar_nodes(shape.theta_d, brdf.fineness, warp.theta_max_deg, [&](double v) { return warp.theta_d_deg(v); }),
          polar_nodes(shape.theta_h, brdf.fineness, warp.theta_max_deg, [&](double u) { return warp.theta_h_deg(u); })};
}

std::size_t table_bytes(const SeriesBrdf& brdf) {
  const auto nodes = table_nodes(brdf);
  std::size_t bytes = brdf.channel_count() * sizeof(float);
  for (const std::vector<double>& axis : nodes) bytes *= axis.size();
  return bytes;
}

Result<VectorEvaluator> make_table(const SeriesBrdf& brdf, std::uint64_t allowed) {
  const Result<SeriesBasis> basis = make_basis(brdf.shape, brdf.symmetries);
  if (!basis) return basis.error();
  if (Status fits = check_memory(static_cast<double>(table_bytes(brdf)), allowed); !fits) return fits.error();
  const auto nodes = table_nodes(brdf);
  SlicedBrdf what;  // of which only this is looked at
  what.channels = brdf.channels;
  what.domain = brdf.domain();
  what.frame.id = FrameId::kHalfDifference;
  SliceTables tables(what, std::make_shared<const LatticeTables>(FrameId::kHalfDifference, nodes));
  tables.form = SliceTables::Form::kDense;
  const float most = std::numeric_limits<float>::max();
  tables.add_groups(what.domain, std::vector<ValueRange>(brdf.channel_count(), {brdf.negative ? -most : 0, most}));
  TableMaker(brdf, *basis, nodes).fill(tables.crossing_values);
  tables.crossing_values.resize(tables.crossing_values.size() + SliceTables::kLanes);
  return VectorEvaluator(std::move(tables));
}

}  // namespace sbrdf::internal
