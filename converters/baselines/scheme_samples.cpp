#include "converters/baselines/scheme_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include <glm/geometric.hpp>

#include "codec/frame/frame.h"
#include "converters/baselines/barycentric.h"
#include "converters/baselines/rbf.h"
#include "converters/source/reciprocity.h"
#include "formats/core/directions.h"
#include "formats/core/interrupted.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBlock = 4096;  // pairs that are interpolated together

std::vector<DirectionPair> reciprocal_pairs(const UniformScheme& scheme) {
  std::vector<DirectionPair> pairs;
  pairs.reserve(scheme.reciprocal_pair_count());
  const std::vector<Direction> directions = scheme_angles(scheme);
  for (std::size_t high = 0; high < directions.size(); ++high) {
    for (std::size_t low = 0; low <= high; ++low) pairs.push_back({directions[low], directions[high]});
  }
  return pairs;
}

std::string text_of(const Interpolation& interpolation) {
  if (interpolation.kind == Interpolation::Kind::kBarycentric) return "barycentric";
  return fmt::format("radial basis functions, kernel {}", name_of(kRbfKernelNames, interpolation.kernel));
}

Status check_measured(const BrdfSource& source, std::span<const DirectionPair> pairs) {
  if (!source.mask_grid()) return ok_status();
  std::vector<std::uint8_t> flags(pairs.size());
  source.measured(pairs, flags);
  const auto missing = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 0));
  if (missing == 0) return ok_status();
  return unsupported(fmt::format("{} of the scheme's {} pairs were not measured", missing, pairs.size()));
}

}  // namespace

Result<SchemeSamples> sample_scheme(const BrdfSource& source, const UniformScheme& scheme, const Progress& progress) {
  const SymmetrisedSource symmetrised(source);
  const BrdfSource& reciprocal = source.traits().reciprocal ? source : symmetrised;
  const std::vector<DirectionPair> pairs = reciprocal_pairs(scheme);
  if (Status measured = check_measured(reciprocal, pairs); !measured) return measured.error();
  const SourceTraits& traits = source.traits();
  SchemeSamples samples = {scheme, traits.description, traits.theta_max_deg, traits.channels, {}};
  const std::size_t channels = samples.channels.size();
  samples.values.resize(pairs.size() * channels);
  constexpr std::size_t kAtOnce = 65536;
  ProgressCounter counter(progress, pairs.size());
  for (std::size_t first = 0; first < pairs.size(); first += kAtOnce) {
    const std::span some = std::span(pairs).subspan(first, std::min(kAtOnce, pairs.size() - first));
    evaluate_in_parallel(reciprocal, some, std::span(samples.values).subspan(first * channels, some.size() * channels));
    if (!counter.advance(some.size())) return interrupted_error();
  }
  return samples;
}

Result<std::unique_ptr<SchemeSource>> SchemeSource::make(SchemeSamples samples, const Interpolation& interpolation) {
  if (interpolation.kind == Interpolation::Kind::kRbf) return make_rbf(std::move(samples), interpolation.kernel);
  return BarycentricSource::make(std::move(samples));
}

SchemeSource::SchemeSource(SchemeSamples samples, const Interpolation& interpolation, std::string beyond)
    : samples_(std::move(samples)), interpolation_(interpolation) {
  const UniformScheme& scheme = samples_.scheme;
  traits_.format = "hdf5";
  if (!samples_.description.empty()) traits_.description = samples_.description + "; ";
  traits_.description +=
      fmt::format("{} uniform samples (scheme {}, {} directions), {}", scheme.reciprocal_pair_count(), scheme.name,
                  scheme.direction_count(), text_of(interpolation));
  traits_.channels = samples_.channels;
  traits_.reciprocal = true;
  traits_.theta_max_deg = std::min(samples_.theta_max_deg, scheme.rings.back().theta_deg);
  traits_.slice_theta_max_deg = traits_.theta_max_deg;
  traits_.beyond_theta_max = std::move(beyond);
}

// `vectors_of(k, i, v)` says whether pair k is above the horizon, and sets its vectors if so.
template <class VectorsOf>
void SchemeSource::evaluate_each(std::size_t count, const VectorsOf& vectors_of, std::span<float> values) const {
  std::vector<glm::dvec3> w_i(std::min(kBlock, count));
  std::vector<glm::dvec3> w_v(w_i.size());
  std::vector<std::uint8_t> above(w_i.size());
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t size = std::min(kBlock, count - first);
    for (std::size_t k = 0; k < size; ++k) {
      w_i[k] = w_v[k] = {0, 0, 1};
      above[k] = vectors_of(first + k, w_i[k], w_v[k]) ? 1 : 0;
    }
    const std::span<float> block = values.subspan(first * channel_count(), size * channel_count());
    interpolate(std::span(w_i).first(size), std::span(w_v).first(size), block);
    for (std::size_t k = 0; k < size; ++k) {
      if (above[k] == 0) std::ranges::fill(block.subspan(k * channel_count(), channel_count()), 0.0F);
    }
  }
}

void SchemeSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  const auto vectors_of = [&](std::size_t k, glm::dvec3& w_i, glm::dvec3& w_v) {
    if (!above_horizon(pairs[k])) return false;
    w_i = vector_from_direction(pairs[k].i);
    w_v = vector_from_direction(pairs[k].v);
    return true;
  };
  evaluate_each(pairs.size(), vectors_of, values);
}

void SchemeSource::evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                    std::span<float> values) const {
  const auto vectors_of = [&](std::size_t k, glm::dvec3& i, glm::dvec3& v) {
    if (!above_horizon(w_i[k]) || !above_horizon(w_v[k])) return false;
    i = glm::normalize(glm::dvec3(w_i[k]));
    v = glm::normalize(glm::dvec3(w_v[k]));
    return true;
  };
  evaluate_each(w_i.size(), vectors_of, values);
}

}  // namespace sbrdf::internal
