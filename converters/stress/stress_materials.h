#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string_view>
#include <vector>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/vector_evaluator.h"
#include "codec/frame/lattice.h"
#include "codec/material/slice_samples.h"
#include "codec/material/sliced_brdf.h"

// Materials, frames and places for the stress suite (converters/stress/stress.h).

namespace sbrdf::internal::stress {

/// Evaluators take channels by threes and the rest one by one; four need both ways.
inline constexpr std::size_t kChannels = 4;
template <class Real>
using Channels = std::array<Real, kChannels>;
using Brdf = std::function<Channels<double>(const DirectionPair& pair)>;

/// A sampled function and its evaluations.
struct Material {
  Material(Lattice lattice_of_it, SlicedBrdf sliced_of_it);

  Lattice lattice;
  SlicedBrdf sliced;
  std::vector<SliceSamples> slices;
  Evaluator rounded;
  VectorEvaluator kernel;
  BasicEvaluator<long double> exact;
  Channels<double> largest{};  ///< largest |f_r| of the samples
  bool full = false;           ///< no more samples could be placed

  [[nodiscard]] bool is_log() const { return sliced.domain.kind == DomainKind::kLog; }
};

struct Sampling {
  std::uint64_t sample_count = 0;  ///< at least the crossings are sampled
  DomainKind domain = DomainKind::kLinear;
  double minimum_gap_deg = 1;
};

[[nodiscard]] Material sample(const FrameSpec& spec, const Sampling& sampling, const Brdf& function);

/// A frame over all directions with some hundred crossings. phi_d has a node wherever phi_h has one: at theta_h = 0
/// only phi_h + phi_d matters, and samples must lie on the lattice there, too.
[[nodiscard]] FrameSpec coarse_frame(FrameId id, bool isotropic);
/// With enough nodes for a Kurt material at some thousand samples.
[[nodiscard]] FrameSpec fine_frame(FrameId id, bool isotropic);

/// Positive, smooth, reciprocal, anisotropic, between 0.1 and 30.
[[nodiscard]] Channels<double> smooth(const DirectionPair& pair);
/// A material of the Kurt model's table, whose three channels are followed by the mean of two.
[[nodiscard]] Brdf kurt(std::string_view name);
/// A Kurt lobe that is the same along and across the tangent.
[[nodiscard]] Brdf isotropic_kurt();

[[nodiscard]] DirectionPair random_pair(std::mt19937_64& random, double theta_max_deg = 90);
/// A point of the padded lattice, below the horizon as well.
[[nodiscard]] Coordinates random_coordinates(std::mt19937_64& random, const Lattice& lattice);

/// Each sample of each slice, its crossings included: coordinates on the padded lattice and the values measured there.
using Visit = std::function<void(const Coordinates& x, std::span<const float> values)>;
void for_each_sample(const Material& material, const Visit& visit);

/// The two sides, `step` degrees away, of each inner node of each axis and of the turn of azimuths, where the other
/// coordinates are those of x.
using Compare = std::function<void(const Coordinates& below, const Coordinates& above)>;
void for_each_boundary(const Lattice& lattice, const Coordinates& x, double step, const Compare& compare);

/// The local maximum of each channel: of the at most 32 slices that are combined at x the largest |f_r| among the two
/// samples of each that enclose x.
[[nodiscard]] Channels<double> local_maximum(const Material& material, const Coordinates& x);

/// Tells where a cell's sum of slices is held back by the least or the greatest of them.
class ClampDetector {
 public:
  explicit ClampDetector(const Material& material);
  [[nodiscard]] std::array<bool, kChannels> clamped(const Coordinates& x) const;

 private:
  BasicEvaluator<long double> values_;
  BasicEvaluator<long double> negated_;
};

}  // namespace sbrdf::internal::stress
