#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "formats/core/half.h"
#include "formats/texture/bc6h/bc6h.h"
#include "formats/texture/bc6h/block.h"

namespace sbrdf::internal {

/// What a decoded block is off, from the definition of the metrics.
inline double bc6h_error(const Bc6hTexels& wanted, const Bc6hTexels& decoded, Bc6hMetric metric) {
  const auto number = [&](std::uint16_t half) {
    if (metric == Bc6hMetric::kLinear) return static_cast<double>(float_from_half(half));
    return half >= 0x8000 ? 0x8000 - static_cast<double>(half) : static_cast<double>(half);
  };
  double sum = 0;
  for (std::size_t k = 0; k < 16; ++k) {
    for (std::size_t c = 0; c < 3; ++c) sum += std::pow(number(wanted[k][c]) - number(decoded[k][c]), 2);
  }
  return sum;
}

/// A search that takes its time: every mode and partition from several starts, by random steps of endpoints. It shares
/// nothing with the encoder but what a block means.
class LongBc6hSearch {
 public:
  LongBc6hSearch(const Bc6hTexels& texels, bool is_signed, Bc6hMetric metric, std::uint32_t seed)
      : is_signed_(is_signed), metric_(metric), draw_(seed) {
    for (std::size_t k = 0; k < 16; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        wanted_[k][c] = number(texels[k][c]);
        const auto size = static_cast<std::int32_t>(texels[k][c] & 0x7FFF) * (is_signed ? 32 : 64) / 31;
        mixed_[k][c] = texels[k][c] >= 0x8000 ? -size : size;
      }
    }
  }

  /// The least error found. `steps`: of each of `starts` starts of each mode and partition; the `best` of these go on
  /// for `more_steps`.
  double run(int starts, int steps, std::size_t best, int more_steps) {
    std::vector<State> states;
    for (std::uint8_t mode = 0; mode < kBc6hModeCount; ++mode) {
      const std::uint8_t partitions = kBc6hModes[mode].region_count == 2 ? kBc6hPartitionCount : 1;
      for (std::uint8_t partition = 0; partition < partitions; ++partition) {
        State found{.error = std::numeric_limits<float>::max()};
        for (int start = 0; start < starts; ++start) {
          State state = start_at(mode, partition);
          climb(state, steps);
          if (state.error < found.error) found = state;
        }
        states.push_back(found);
      }
    }
    std::sort(states.begin(), states.end(), [](const State& a, const State& b) { return a.error < b.error; });
    states.resize(std::min(states.size(), best));
    double least = std::numeric_limits<double>::max();
    for (State& state : states) {
      climb(state, more_steps);
      least = std::min(least, static_cast<double>(state.error));
    }
    return least;
  }

  /// The least error found from a block on.
  double run_from(const Bc6hBytes& bytes, int steps) {
    const Bc6hBlock block = *parse_bc6h_block(bytes, is_signed_);
    State state{.mode = block.mode, .partition = block.partition, .endpoints = block.endpoints};
    state.error = error_of(state);
    climb(state, steps);
    return state.error;
  }

 private:
  struct State {
    std::uint8_t mode = 0;
    std::uint8_t partition = 0;
    std::array<Bc6hEndpoint, 4> endpoints{};
    float error = 0;
  };

  [[nodiscard]] float number(std::uint16_t half) const {
    if (metric_ == Bc6hMetric::kLinear) return float_from_half(half);
    return half >= 0x8000 ? 0x8000 - static_cast<float>(half) : static_cast<float>(half);
  }

  [[nodiscard]] bool allowed(const State& state) const {
    const Bc6hMode& mode = kBc6hModes[state.mode];
    const std::int32_t largest = (1 << (is_signed_ ? mode.endpoint_bits - 1 : mode.endpoint_bits)) - 1;
    for (const Bc6hEndpoint& end : state.endpoints) {
      for (const std::int32_t value : end) {
        if (value > largest || value < (is_signed_ ? -largest : 0)) return false;
      }
    }
    return fits_bc6h(mode, state.endpoints);
  }

  [[nodiscard]] float error_of(const State& state) const {
    const Bc6hMode& mode = kBc6hModes[state.mode];
    const int count = mode.index_count();
    std::array<std::array<std::array<float, 3>, 16>, 2> palettes{};
    for (std::size_t region = 0; region < mode.region_count; ++region) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto a = unquantise_bc6h(state.endpoints[2 * region][c], mode.endpoint_bits, is_signed_);
        const auto b = unquantise_bc6h(state.endpoints[2 * region + 1][c], mode.endpoint_bits, is_signed_);
        for (int k = 0; k < count; ++k) {
          const auto index = static_cast<std::size_t>(k);
          const int weight = count == 8 ? kBc6hWeights3[index] : kBc6hWeights4[index];
          palettes[region][index][c] = number(finish_bc6h(mix_bc6h(a, b, weight), is_signed_));
        }
      }
    }
    float sum = 0;
    for (std::size_t k = 0; k < 16; ++k) {
      const bool two = mode.region_count == 2;
      const std::size_t region = two ? kBc6hPartitions[state.partition] >> k & 1 : 0;
      const bool anchor = k == 0 || (two && k == kBc6hAnchors[state.partition]);
      float least = std::numeric_limits<float>::max();
      for (int index = 0; index < (anchor ? count / 2 : count); ++index) {
        const auto& colour = palettes[region][static_cast<std::size_t>(index)];
        float off = 0;
        for (std::size_t c = 0; c < 3; ++c) off += (wanted_[k][c] - colour[c]) * (wanted_[k][c] - colour[c]);
        least = std::min(least, off);
      }
      sum += least;
    }
    return sum;
  }

  [[nodiscard]] std::int32_t uniform(std::int32_t low, std::int32_t high) {
    return std::uniform_int_distribution<std::int32_t>(low, high)(draw_);
  }

  // Both ends of each region at texels of it; differences are cut where they have to be.
  [[nodiscard]] State start_at(std::uint8_t position, std::uint8_t partition) {
    const Bc6hMode& mode = kBc6hModes[position];
    State state{.mode = position, .partition = partition};
    for (std::size_t e = 0; e < 2U * mode.region_count; ++e) {
      std::size_t texel = 0;
      do {
        texel = static_cast<std::size_t>(uniform(0, 15));
      } while (mode.region_count == 2 && (kBc6hPartitions[partition] >> texel & 1U) != e / 2);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::int32_t largest = (1 << (is_signed_ ? mode.endpoint_bits - 1 : mode.endpoint_bits)) - 1;
        std::int32_t value = std::clamp(mixed_[texel][c] / (1 << (16 - mode.endpoint_bits)), -largest, largest);
        const std::int32_t limit = 1 << (mode.delta_bits[c] - 1);
        const std::int32_t base = state.endpoints[0][c];
        if (mode.transformed && e > 0) value = std::clamp(value, base - limit, base + limit - 1);
        state.endpoints[e][c] = value;
      }
    }
    if (mode.region_count == 1 && mode.transformed) state.endpoints[2] = state.endpoints[3] = state.endpoints[0];
    state.error = error_of(state);
    return state;
  }

  // Steps of one number, of an endpoint, or of all of them; small ones mostly.
  void climb(State& state, int steps) {
    const std::int32_t last = 2 * kBc6hModes[state.mode].region_count - 1;
    for (int step = 0; step < steps; ++step) {
      State next = state;
      const std::int32_t kind = uniform(0, 5);
      const std::int32_t reach = 1 << std::max(0, uniform(-6, 6));
      const std::int32_t only = uniform(0, last);
      const std::int32_t other = uniform(0, last);
      const std::int32_t channel = uniform(0, 2);
      const std::int32_t shift = uniform(-reach, reach);
      for (std::int32_t e = 0; e <= last; ++e) {
        if (kind != 5 && e != only && (kind < 3 || e != other)) continue;
        for (std::int32_t c = 0; c < 3; ++c) {
          if (kind < 2 && c != channel) continue;
          next.endpoints[static_cast<std::size_t>(e)][static_cast<std::size_t>(c)] +=
              kind == 5 ? (c == channel ? shift : 0) : uniform(-reach, reach);
        }
      }
      if (kind == 3)
        std::swap(next.endpoints[static_cast<std::size_t>(only)], next.endpoints[static_cast<std::size_t>(other)]);
      if (!allowed(next)) continue;
      next.error = error_of(next);
      if (next.error <= state.error) state = next;
    }
  }

  bool is_signed_;
  Bc6hMetric metric_;
  std::mt19937 draw_;
  std::array<std::array<float, 3>, 16> wanted_{};
  std::array<std::array<std::int32_t, 3>, 16> mixed_{};
};

}  // namespace sbrdf::internal
