#include "converters/stress/stress_materials.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "codec/material/value_domain.h"
#include "codec/sampling/adaptive_sampling.h"
#include "converters/models/analytic.h"

namespace sbrdf::internal::stress {
namespace {

Brdf brdf_of(const AnalyticModel& model) {
  const std::shared_ptr<const BrdfSource> source = make_analytic_source(model);
  return [source](const DirectionPair& pair) {
    std::array<float, 3> rgb{};
    source->evaluate(std::span(&pair, 1), rgb);
    return Channels<double>{rgb[0], rgb[1], rgb[2], 0.5 * (static_cast<double>(rgb[0]) + rgb[2])};
  };
}

/// The same places with every value mapped by `map(value, channel)`, in the linear domain.
template <class Map>
SlicedBrdf with_values(const SlicedBrdf& sliced, const Map& map) {
  SlicedBrdf mapped = sliced;
  mapped.domain = {};
  for (auto* values : {&mapped.crossing_values, &mapped.sample_values}) {
    for (std::size_t k = 0; k < values->size(); ++k) (*values)[k] = map((*values)[k], k % kChannels);
  }
  return mapped;
}

/// What the slices of a material interpolate, times a sign, as a material of its own.
SlicedBrdf interpolated_values(const SlicedBrdf& sliced, float sign) {
  std::vector<DomainMap<double>> maps;
  for (std::size_t c = 0; c < kChannels; ++c) maps.emplace_back(sliced.domain, c);
  return with_values(sliced, [&](float f, std::size_t c) { return sign * static_cast<float>(maps[c].forward(f)); });
}

void add_enclosing(const Slice& slice, const SliceSamples& samples, double position, Channels<double>& most) {
  const auto& positions = samples.positions_deg;
  const auto after = static_cast<std::size_t>(
      std::upper_bound(positions.begin(), positions.end(), fold(slice, position)) - positions.begin());
  const std::size_t n = samples.size();
  const std::size_t left = after > 0 ? after - 1 : 0;
  const std::size_t right = after < n ? after : slice.boundary == Boundary::kPeriodic ? 0 : n - 1;
  for (std::size_t c = 0; c < kChannels; ++c) {
    most[c] = std::max({most[c], std::abs(static_cast<double>(samples.values[left * kChannels + c])),
                        std::abs(static_cast<double>(samples.values[right * kChannels + c]))});
  }
}

std::array<std::uint32_t, kAxisCount> cell_at(const Lattice& lattice, const Coordinates& x) {
  std::array<std::uint32_t, kAxisCount> cell{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const auto& nodes = lattice.nodes[axis];
    if (nodes.size() < 2) continue;
    cell[axis] =
        static_cast<std::uint32_t>(std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x[axis]) - nodes.begin() - 1);
  }
  return cell;
}

}  // namespace

Material::Material(Lattice lattice_of_it, SlicedBrdf sliced_of_it)
    : lattice(std::move(lattice_of_it)),
      sliced(std::move(sliced_of_it)),
      slices(gather_slices(sliced, lattice)),
      rounded(sliced, lattice),
      kernel(sliced, lattice),
      exact(sliced, lattice) {
  for (const auto* values : {&sliced.crossing_values, &sliced.sample_values}) {
    for (std::size_t k = 0; k < values->size(); ++k) {
      largest[k % kChannels] = std::max(largest[k % kChannels], std::abs(static_cast<double>((*values)[k])));
    }
  }
}

Material sample(const FrameSpec& spec, const Sampling& sampling, const Brdf& function) {
  const Measure measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Channels<double> f = function(pairs[k]);
      for (std::size_t c = 0; c < kChannels; ++c) values[k * kChannels + c] = static_cast<float>(f[c]);
    }
    return ok_status();
  };
  Lattice lattice = build_lattice(spec).value();
  SamplingOptions options;
  options.sample_count = std::max<std::uint64_t>(sampling.sample_count, lattice.crossings.size());
  options.domain = sampling.domain;
  options.minimum_gap_deg = sampling.minimum_gap_deg;
  SlicedBrdf sliced = sample_slices(lattice, {"a", "b", "c", "d"}, measure, options).value();
  Material material(std::move(lattice), std::move(sliced));
  material.full = material.sliced.sample_count() < options.sample_count;
  return material;
}

FrameSpec coarse_frame(FrameId id, bool isotropic) {
  const Symmetries symmetries = {.isotropic = isotropic};
  if (id == FrameId::kElevation) return elevation_frame(28, 90, symmetries).value();
  return half_difference_frame({0, 12, 40, 90}, {0, 40, 90},
                               isotropic ? std::vector<double>{0} : std::vector<double>{0, 90, 180, 270},
                               {0, 45, 90, 135}, symmetries);
}

FrameSpec fine_frame(FrameId id, bool isotropic) {
  const Symmetries symmetries = {.isotropic = isotropic};
  if (id == FrameId::kElevation) return elevation_frame(isotropic ? 10 : 20, isotropic ? 30 : 60, symmetries).value();
  return half_difference_frame(
      {0, 4, 10, 20, 40, 90}, {0, 30, 60, 80, 90},
      isotropic ? std::vector<double>{0} : std::vector<double>{0, 45, 90, 135, 180, 225, 270, 315}, {0, 45, 90, 135},
      symmetries);
}

Channels<double> smooth(const DirectionPair& pair) {
  const glm::dvec3 i = vector_from_direction(pair.i);
  const glm::dvec3 v = vector_from_direction(pair.v);
  const double along = i.x * v.x;
  const double across = i.y * v.y;
  const double twist = (i.z - v.z) * (i.x * v.y - i.y * v.x);
  const double level = 0.3 * (i.z + v.z) + 0.4 * i.z * v.z + 0.9 * along + 0.3 * across + 0.7 * twist +
                       0.4 * (i.x * v.y + i.y * v.x) + 0.27 * (i.x + v.x) - 0.33 * (i.y + v.y);
  return {std::exp(level), std::exp(1.3 * level), std::exp(-0.8 * level), std::exp(1.6 * level)};
}

Brdf kurt(std::string_view name) { return brdf_of(kurt_material(name).value()); }

Brdf isotropic_kurt() {
  AnalyticModel model;
  model.name = "isotropic";
  model.k_d = {0.1, 0.05, 0.02};
  model.lobes = {{.k_s = {0.3, 0.2, 0.4}, .f_0 = 0.5, .m_x = 0.15, .m_y = 0.15, .alpha = 0.3}};
  return brdf_of(model);
}

DirectionPair random_pair(std::mt19937_64& random, double theta_max_deg) {
  std::uniform_real_distribution<double> theta(0, theta_max_deg);
  std::uniform_real_distribution<double> phi(0, 360);
  const Direction i = direction_from_degrees(theta(random), phi(random));
  return {i, direction_from_degrees(theta(random), phi(random))};
}

Coordinates random_coordinates(std::mt19937_64& random, const Lattice& lattice) {
  std::uniform_real_distribution<double> share(0, 1);
  Coordinates x{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = share(random) * lattice.nodes[axis].back();
  return x;
}

void for_each_sample(const Material& material, const Visit& visit) {
  for (std::size_t s = 0; s < material.slices.size(); ++s) {
    const SliceSamples& samples = material.slices[s];
    for (std::size_t k = 0; k < samples.size(); ++k) {
      Coordinates x = coordinates_on(material.lattice.slices[s], samples.positions_deg[k]);
      // Only [0, 360] of the elevation frame's u is padded: a turn more of u is a turn more of s.
      if (x[kDiagonal] > 360) {
        x[kDiagonal] -= 360;
        x[kAxial] += x[kAxial] >= 360 ? -360 : 360;
      }
      visit(x, std::span(samples.values).subspan(k * kChannels, kChannels));
    }
  }
}

void for_each_boundary(const Lattice& lattice, const Coordinates& x, double step, const Compare& compare) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const auto& nodes = lattice.nodes[axis];
    Coordinates below = x;
    Coordinates above = x;
    for (std::size_t node = 1; node + 1 < nodes.size(); ++node) {
      below[axis] = nodes[node] - step;
      above[axis] = nodes[node] + step;
      compare(below, above);
    }
    if (axis > kDiagonal || nodes.size() == 1) continue;
    below[axis] = nodes.back() - step;
    above[axis] = step;
    // In the elevation frame a turn of u turns s, too.
    if (axis == kDiagonal && lattice.spec.id == FrameId::kElevation) below[kAxial] += x[kAxial] < 360 ? 360 : -360;
    compare(below, above);
  }
}

Channels<double> local_maximum(const Material& material, const Coordinates& x) {
  const Lattice& lattice = material.lattice;
  const auto cell = cell_at(lattice, x);
  Channels<double> most{};
  std::size_t lists = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (lattice.nodes[axis].size() < 2) continue;
    ++lists;
    for (std::uint32_t bits = 0; bits < 16; ++bits) {
      if (((bits >> axis) & 1U) != 0) continue;
      std::uint32_t line = 0;
      for (std::size_t a = 0; a < kAxisCount; ++a) {
        if (a == axis) continue;
        const std::uint32_t step = lattice.nodes[a].size() > 1 ? (bits >> a) & 1U : 0;
        line += (cell[a] + step) * lattice.line_strides[axis][a];
      }
      const LineReference& reference = lattice.lines[axis][line];
      if (reference.is_constant()) {
        for (std::size_t c = 0; c < kChannels; ++c) {
          const float f = material.sliced.crossing_values[reference.crossing() * kChannels + c];
          most[c] = std::max(most[c], std::abs(static_cast<double>(f)));
        }
      } else {
        add_enclosing(lattice.slices[reference.target], material.slices[reference.target],
                      reference.sign * x[axis] + reference.offset_deg, most);
      }
    }
  }
  return lists > 0 ? most : material.largest;
}

// Without the lower clamp -E(-v) is the sum where E(v) is not, and the other way round.
ClampDetector::ClampDetector(const Material& material)
    : values_(interpolated_values(material.sliced, 1), material.lattice),
      negated_(interpolated_values(material.sliced, -1), material.lattice) {}

std::array<bool, kChannels> ClampDetector::clamped(const Coordinates& x) const {
  Channels<long double> value;
  Channels<long double> negated;
  values_.evaluate_at(x, value);
  negated_.evaluate_at(x, negated);
  std::array<bool, kChannels> result{};
  for (std::size_t c = 0; c < kChannels; ++c) {
    result[c] = std::abs(value[c] + negated[c]) > 1e-12L * (std::abs(value[c]) + std::abs(negated[c]));
  }
  return result;
}

}  // namespace sbrdf::internal::stress
