#include "codec/fit/value_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "codec/fit/reconstruction.h"
#include "codec/material/value_map.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr int kRounds = 3;        // of weighing
constexpr int kSteps = 6;         // of conjugate gradients in each
constexpr double kPrior = 0.01;   // how much a sample holds to its own value, beside what directions say of it
constexpr double kShared = 0.1;   // part of the mean sample's hold that each has at least
constexpr double kSmall = 0.2;    // of the mean residual: smaller ones are not told apart
constexpr double kLargest = 1.0;  // residuals beyond say nothing about how far off f is

constexpr std::size_t kBlock = 1024;  // directions that one task looks at

constexpr std::size_t kFewestDirections = 6'000;
constexpr std::size_t kMostDirections = 60'000;
constexpr std::size_t kDirectionsPerSample = 30;

/// What is fitted, all channels, channel fastest.
struct Problem {
  std::size_t channels = 0;
  std::vector<Coordinates> places;  ///< of the unknowns
  std::vector<double> start;        ///< values of the unknowns in the value domain
  std::vector<double> wanted;       ///< of the rows
  std::vector<double> gains;        ///< of the rows: what an error in the value domain costs
};

/// N channels of the problem from `channel` on, by iteration.
template <std::size_t N>
class ChannelFit {
 public:
  ChannelFit(const Reconstruction& map, const Problem& problem, std::size_t channel)
      : map_(map), change_(map.unknown_count() * N, 0), residual_(map.row_count() * N), gains_(residual_.size()) {
    std::vector<double> start(change_.size());
    for (std::size_t k = 0; k < map.unknown_count(); ++k) {
      std::copy_n(problem.start.data() + k * problem.channels + channel, N, start.data() + k * N);
    }
    map.apply<N>(start, residual_);
    for (std::size_t row = 0; row < map.row_count(); ++row) {
      const std::size_t from = row * problem.channels + channel;
      for (std::size_t c = 0; c < N; ++c) {
        residual_[row * N + c] = problem.wanted[from + c] - residual_[row * N + c];
        gains_[row * N + c] = problem.gains[from + c];
      }
    }
  }

  /// What is to be added to the unknowns.
  const std::vector<double>& run() {
    for (int round = 0; round < kRounds; ++round) {
      weigh();
      descend();
    }
    return change_;
  }

 private:
  using Numbers = std::array<double, N>;

  // The square of a residual times its weight is then its size times its gain.
  void weigh() {
    Numbers sum{};
    Numbers gain{};
    for (std::size_t k = 0; k < residual_.size(); ++k) {
      sum[k % N] += gains_[k] * std::min(std::abs(residual_[k]), kLargest);
      gain[k % N] += gains_[k];
    }
    weights_.resize(residual_.size());
    for (std::size_t k = 0; k < residual_.size(); ++k) {
      const double mean = gain[k % N] > 0 ? sum[k % N] / gain[k % N] : 0;
      const double size = std::max(std::abs(residual_[k]), kSmall * mean);
      weights_[k] = size > 0 ? gains_[k] / size : 0;
    }
    diagonal_.assign(change_.size(), 0);
    map_.add_squares<N>(weights_, diagonal_);
    Numbers mean{};
    for (std::size_t k = 0; k < diagonal_.size(); ++k)
      mean[k % N] += diagonal_[k] * N / static_cast<double>(diagonal_.size());
    prior_.resize(change_.size());
    for (std::size_t k = 0; k < prior_.size(); ++k) prior_[k] = kPrior * (diagonal_[k] + kShared * mean[k % N]);
  }

  // Preconditioned conjugate gradients on (A^T W A + prior) change = A^T W (wanted - A start), from `change_` on.
  void descend() {
    std::vector<double> weighted(residual_.size());
    std::vector<double> gradient(change_.size());
    for (std::size_t k = 0; k < residual_.size(); ++k) weighted[k] = weights_[k] * residual_[k];
    map_.apply_transposed<N>(weighted, gradient);
    for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] -= prior_[k] * change_[k];
    std::vector<double> step(change_.size(), 0);
    std::vector<double> rows(residual_.size());
    std::vector<double> image(change_.size());
    Numbers before{};
    for (int k = 0; k < kSteps; ++k) {
      const Numbers now = turn(gradient, before, step);
      map_.apply<N>(step, rows);
      for (std::size_t r = 0; r < rows.size(); ++r) weighted[r] = weights_[r] * rows[r];
      map_.apply_transposed<N>(weighted, image);
      for (std::size_t u = 0; u < image.size(); ++u) image[u] += prior_[u] * step[u];
      advance(now, step, image, rows, gradient);
      before = now;
    }
  }

  // The next direction, conjugate to those before; returns gradient x preconditioned gradient.
  Numbers turn(const std::vector<double>& gradient, const Numbers& before, std::vector<double>& step) const {
    Numbers now{};
    const auto preconditioned = [&](std::size_t u) {
      const double scale = diagonal_[u] + prior_[u];
      return scale > 0 ? gradient[u] / scale : 0;
    };
    for (std::size_t u = 0; u < gradient.size(); ++u) now[u % N] += gradient[u] * preconditioned(u);
    for (std::size_t u = 0; u < gradient.size(); ++u) {
      const double kept = before[u % N] > 0 ? now[u % N] / before[u % N] : 0;
      step[u] = preconditioned(u) + kept * step[u];
    }
    return now;
  }

  void advance(const Numbers& now, const std::vector<double>& step, const std::vector<double>& image,
               const std::vector<double>& rows, std::vector<double>& gradient) {
    Numbers curvature{};
    for (std::size_t u = 0; u < step.size(); ++u) curvature[u % N] += step[u] * image[u];
    Numbers length{};
    for (std::size_t c = 0; c < N; ++c) length[c] = curvature[c] > 0 ? now[c] / curvature[c] : 0;
    for (std::size_t u = 0; u < step.size(); ++u) {
      change_[u] += length[u % N] * step[u];
      gradient[u] -= length[u % N] * image[u];
    }
    for (std::size_t r = 0; r < rows.size(); ++r) residual_[r] -= length[r % N] * rows[r];
  }

  const Reconstruction& map_;
  std::vector<double> change_;
  std::vector<double> residual_;  ///< wanted less what is reached
  std::vector<double> gains_;
  std::vector<double> weights_;
  std::vector<double> diagonal_;
  std::vector<double> prior_;
};

// What an error of 1 in the value domain costs: its size in f, by the weight of the direction, in each error as a part
// of what the error is before. So sqrt(MRE x relative L1) becomes a sum to first order.
std::vector<double> gains_of(const SlicedBrdf& sliced, const HeldBack& directions, const std::vector<float>& stored,
                             const HeldBackError& error, Objective objective) {
  const std::size_t channels = sliced.channel_count();
  const double floor = mre_floor(directions);
  const double total = 100 * floor * static_cast<double>(channels);
  const double of_l1 = objective == Objective::kMre ? 0 : 1 / (total * std::max(error.rel_l1_percent, 1e-9));
  const double of_mre =
      objective == Objective::kRelL1 ? 0 : 1 / (static_cast<double>(channels) * std::max(error.mre_percent, 1e-9));
  const bool log = sliced.domain.kind == DomainKind::kLog;
  std::vector<float> floors(channels, 0);
  for (std::size_t c = 0; log && c < channels; ++c) floors[c] = sliced.domain.floor(c);
  std::vector<double> gains(directions.values.size());
  for (std::size_t k = 0; k < gains.size(); ++k) {
    const double slope = log ? std::max(std::abs(stored[k]), floors[k % channels]) : 1.0F;
    const double size = std::max(std::abs(static_cast<double>(directions.values[k])), floor);
    gains[k] = directions.weights[k / channels] * slope * (of_l1 + of_mre / size);
  }
  return gains;
}

Problem make_problem(const SlicedBrdf& sliced, const Lattice& lattice, std::span<const SliceSamples> slices,
                     const HeldBack& directions, Objective objective, Reconstruction& map) {
  const std::size_t channels = sliced.channel_count();
  Problem problem;
  problem.channels = channels;
  const FrameGeometry& frame = geometry(lattice.spec.id);
  const ValueMap<double> values(sliced, lattice);
  std::vector<float> stored = directions.values;
  sliced.grey_shares.add(stored);
  problem.wanted.resize(stored.size());
  std::vector<Coordinates> rows(directions.pairs.size());
  for_all(rows.size(), kBlock, [&](std::size_t row) {
    rows[row] = frame.coordinates(directions.pairs[row]);
    values.forward(rows[row], std::span(stored).subspan(row * channels, channels),
                   std::span(problem.wanted).subspan(row * channels, channels));
  });
  map.set_rows(rows);
  problem.gains = gains_of(sliced, directions, stored, judge(Evaluator(sliced, lattice), directions), objective);
  problem.places.resize(map.unknown_count());
  problem.start.resize(map.unknown_count() * channels);
  const auto set = [&](std::size_t unknown, const Coordinates& x, const float* f) {
    problem.places[unknown] = x;
    values.forward(x, {f, channels}, std::span(problem.start).subspan(unknown * channels, channels));
  };
  for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
    set(k, lattice.crossings[k], sliced.crossing_values.data() + k * channels);
  }
  for (std::size_t slice = 0; slice < slices.size(); ++slice) {
    for (std::size_t s = 0; s < slices[slice].size(); ++s) {
      if (slices[slice].places[s].fraction == 0) continue;
      set(map.unknown_at(slice, s), coordinates_on(lattice.slices[slice], slices[slice].positions_deg[s]),
          slices[slice].values.data() + s * channels);
    }
  }
  return problem;
}

}  // namespace

std::size_t fit_directions(std::size_t sample_count) {
  return std::clamp(kDirectionsPerSample * sample_count, kFewestDirections, kMostDirections);
}

SlicedBrdf fit_values(const SlicedBrdf& sliced, const Lattice& lattice, const HeldBack& directions,
                      Objective objective) {
  // Zero everywhere: no error has a size that others could be held against.
  if (all_zero(directions)) return sliced;
  const std::size_t channels = sliced.channel_count();
  std::vector<SliceSamples> slices = gather_slices(sliced, lattice);
  Reconstruction map(sliced, lattice, slices);
  Problem problem = make_problem(sliced, lattice, slices, directions, objective, map);
  const auto add_change = [&]<std::size_t N>(std::size_t channel) {
    const std::vector<double> change = ChannelFit<N>(map, problem, channel).run();
    for (std::size_t k = 0; k < change.size(); ++k) problem.start[k / N * channels + channel + k % N] += change[k];
  };
  std::size_t channel = 0;
  for (; channel + 3 <= channels; channel += 3) add_change.template operator()<3>(channel);
  for (; channel < channels; ++channel) add_change.template operator()<1>(channel);

  const ValueMap<double> values(sliced, lattice);
  for_all(map.unknown_count(), kBlock, [&](std::size_t k) {
    const auto row = std::span(problem.start).subspan(k * channels, channels);
    for (std::size_t c = 0; c < channels; ++c) values.inverse(problem.places[k], c, row.subspan(c, 1));
  });
  const std::vector<float> fitted(problem.start.begin(), problem.start.end());
  SlicedBrdf result = sliced;
  std::copy_n(fitted.begin(), result.crossing_values.size(), result.crossing_values.begin());
  for (std::size_t slice = 0; slice < slices.size(); ++slice) {
    for (std::size_t s = 0; s < slices[slice].size(); ++s) {
      std::copy_n(fitted.begin() + static_cast<std::ptrdiff_t>(map.unknown_at(slice, s) * channels), channels,
                  slices[slice].values.begin() + static_cast<std::ptrdiff_t>(s * channels));
    }
  }
  scatter_slices(slices, result);
  return result;
}

}  // namespace sbrdf::internal
