#include "formats/texture/bc6h/trial.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/texture/bc6h/kernel.h"

namespace sbrdf::internal {

namespace {

Bc6hScale scale_of(std::uint8_t mode, const Bc6hOptions& options) {
  return {.endpoint_bits = kBc6hModes[mode].endpoint_bits,
          .index_count = kBc6hModes[mode].index_count(),
          .is_signed = options.is_signed,
          .metric = options.metric};
}

std::int32_t largest_endpoint(int endpoint_bits, bool is_signed) {
  return (std::int32_t{1} << (is_signed ? endpoint_bits - 1 : endpoint_bits)) - 1;
}

// The endpoint that means the nearest number. All but the smallest and the largest mean the middle of their step.
std::int32_t quantise(float mixed, int endpoint_bits, bool is_signed) {
  const float size = is_signed ? std::abs(mixed) : std::max(mixed, 0.0F);
  const std::int32_t last = largest_endpoint(endpoint_bits, is_signed);
  const float steps =
      std::min(size * static_cast<float>(std::int32_t{1} << endpoint_bits) / 65536, static_cast<float>(last) + 1);
  std::int32_t value = 0;
  if (endpoint_bits == 16) {
    value = static_cast<std::int32_t>(steps + 0.5F);
  } else {
    value = static_cast<std::int32_t>(steps);
    if (value == 0 && steps > 0.75F) value = 1;
    if (value >= last && steps < static_cast<float>(last) + 0.25F) value = last - 1;
  }
  value = std::min(value, last);
  return mixed < 0 ? -value : value;
}

std::array<Bc6hEnds, 3> ends_of(const Bc6hTrial& trial, std::size_t region) {
  const Bc6hEndpoint& first = trial.endpoints[2 * region];
  const Bc6hEndpoint& second = trial.endpoints[2 * region + 1];
  return {{{first[0], second[0]}, {first[1], second[1]}, {first[2], second[2]}}};
}

void judge(std::span<const Bc6hRegion> regions, const Bc6hScale& scale, Bc6hTrial& trial) {
  for (std::size_t k = 0; k < regions.size(); ++k) {
    trial.errors[k] = match_bc6h(regions[k], scale, ends_of(trial, k)).error;
  }
}

// Weights that make squared differences of mixed colours the errors that they are just now: slopes of the chord from
// what is wanted to what is there.
Bc6hRows chord_weights(const Bc6hRegion& region, const Bc6hScale& scale, const Bc6hTrial& trial, std::size_t k,
                       const Bc6hMatch& match) {
  Bc6hRows weights = region.fit_weight;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::int32_t a = unquantise_bc6h(trial.endpoints[2 * k][c], scale.endpoint_bits, scale.is_signed);
    const std::int32_t b = unquantise_bc6h(trial.endpoints[2 * k + 1][c], scale.endpoint_bits, scale.is_signed);
    // In steps of a half, as slopes are.
    const float step = scale.is_signed ? 31.0F / 32 : 31.0F / 64;
    for (std::size_t at = 0; at < region.size; ++at) {
      const std::int32_t mixed = mix_bc6h(a, b, scale.weights()[match.indices[at]]);
      const float off = (static_cast<float>(mixed) - region.mixed[c][at]) * step;
      if (std::abs(off) < 2) continue;
      const float value = bc6h_metric_value(scale.metric, finish_bc6h(mixed, scale.is_signed));
      const float slope = (value - region.value[c][at]) / off;
      weights[c][at] = region.weight[at] * slope * slope;
    }
  }
  return weights;
}

// Whether a mode can store a channel of all endpoints.
bool fits(const Bc6hMode& mode, bool is_signed, std::size_t channel, const std::array<std::int32_t, 4>& values) {
  const std::int32_t largest = largest_endpoint(mode.endpoint_bits, is_signed);
  const std::int32_t limit = std::int32_t{1} << (mode.delta_bits[channel] - 1);
  for (std::size_t e = 0; e < 2U * mode.region_count; ++e) {
    if (values[e] > largest || values[e] < (is_signed ? -largest : 0)) return false;
    const std::int32_t delta = values[e] - values[0];
    if (mode.transformed && e > 0 && (delta < -limit || delta >= limit)) return false;
  }
  return true;
}

std::array<std::int32_t, 4> channel_of(const Bc6hTrial& trial, std::size_t channel) {
  std::array<std::int32_t, 4> values{};
  for (std::size_t e = 0; e < 4; ++e) values[e] = trial.endpoints[e][channel];
  return values;
}

// A region, one channel of which is moved while the others stay.
class ChannelSearch {
 public:
  ChannelSearch(const Bc6hRegion& region, const Bc6hOptions& options, std::size_t k, std::size_t channel,
                Bc6hTrial& trial)
      : region_(region),
        scale_(scale_of(trial.mode, options)),
        k_(k),
        channel_(channel),
        trial_(trial),
        others_(other_channels_bc6h(region, scale_, ends_of(trial, k), channel)) {}

  // Whether a step made it better.
  bool step() {
    const std::size_t first = 2 * k_;
    std::array<std::int32_t, 4> values = channel_of(trial_, channel_);
    const Bc6hEnds here = {values[first], values[first + 1]};
    std::array<Bc6hEnds, 8> ends{};
    std::array<float, 8> errors{};
    std::size_t count = 0;
    for (std::int32_t a = -1; a <= 1; ++a) {
      for (std::int32_t b = -1; b <= 1; ++b) {
        values[first] = here[0] + a;
        values[first + 1] = here[1] + b;
        if ((a == 0 && b == 0) || !fits(kBc6hModes[trial_.mode], scale_.is_signed, channel_, values)) continue;
        ends[count++] = {values[first], values[first + 1]};
      }
    }
    channel_errors_bc6h(region_, scale_, others_, channel_, std::span(ends).first(count), errors);
    const auto best = std::min_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(count));
    if (count == 0 || !(*best < trial_.errors[k_])) return false;
    trial_.errors[k_] = *best;
    for (std::size_t end = 0; end < 2; ++end) {
      trial_.endpoints[first + end][channel_] = ends[static_cast<std::size_t>(best - errors.begin())][end];
    }
    return true;
  }

 private:
  const Bc6hRegion& region_;
  Bc6hScale scale_;
  std::size_t k_;
  std::size_t channel_;
  Bc6hTrial& trial_;
  Bc6hOthers others_;
};

// Moves all channels of a region's endpoints at once. Whether that made it better.
bool move_together(const Bc6hRegion& region, const Bc6hOptions& options, std::size_t k, Bc6hTrial& trial) {
  const Bc6hScale scale = scale_of(trial.mode, options);
  Bc6hTrial best = trial;
  for (std::int32_t a = -1; a <= 1; ++a) {
    for (std::int32_t b = -1; b <= 1; ++b) {
      if (a == 0 && b == 0) continue;
      Bc6hTrial next = trial;
      bool fit = true;
      for (std::size_t c = 0; c < 3; ++c) {
        next.endpoints[2 * k][c] += a;
        next.endpoints[2 * k + 1][c] += b;
        fit = fit && fits(kBc6hModes[trial.mode], options.is_signed, c, channel_of(next, c));
      }
      if (!fit) continue;
      next.errors[k] = match_bc6h(region, scale, ends_of(next, k)).error;
      if (next.errors[k] < best.errors[k]) best = next;
    }
  }
  if (!(best.errors[k] < trial.errors[k])) return false;
  trial = best;
  return true;
}

// Whether it got better.
bool polish_region(const Bc6hRegion& region, const Bc6hOptions& options, std::size_t k, Bc6hTrial& trial) {
  constexpr int kMostRounds = 8;
  bool better = false;
  for (int round = 0; round < kMostRounds; ++round) {
    bool now = false;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      ChannelSearch search(region, options, k, channel, trial);
      while (search.step()) now = true;
    }
    if (!now) now = move_together(region, options, k, trial);
    if (!now) break;
    better = true;
  }
  return better;
}

// Rounds a line and moves it as far as the other endpoints ask for. Whether there is a place for it.
bool put_line(const Bc6hLine& line, std::size_t k, bool is_signed, Bc6hTrial& trial) {
  const Bc6hMode& mode = kBc6hModes[trial.mode];
  for (std::size_t c = 0; c < 3; ++c) {
    std::int32_t& first = trial.endpoints[2 * k][c];
    std::int32_t& second = trial.endpoints[2 * k + 1][c];
    first = quantise(line.first[c], mode.endpoint_bits, is_signed);
    second = quantise(line.second[c], mode.endpoint_bits, is_signed);
    if (!mode.transformed) continue;
    const std::int32_t limit = std::int32_t{1} << (mode.delta_bits[c] - 1);
    const std::int32_t& base = trial.endpoints[0][c];
    if (k == 0 && mode.region_count == 2) {
      const auto [low, high] = std::minmax(trial.endpoints[2][c], trial.endpoints[3][c]);
      first = std::clamp(first, high - limit + 1, low + limit);
    }
    if (k == 1) first = std::clamp(first, base - limit, base + limit - 1);
    second = std::clamp(second, base - limit, base + limit - 1);
    if (!fits(mode, is_signed, c, channel_of(trial, c))) return false;
  }
  return true;
}

}  // namespace

Bc6hTrial make_bc6h_trial(std::span<const Bc6hRegion> regions, std::span<const Bc6hLine> lines, std::uint8_t mode,
                          std::uint8_t partition, const Bc6hOptions& options) {
  const Bc6hMode& kind = kBc6hModes[mode];
  Bc6hTrial trial{.mode = mode, .partition = partition};
  bool too_far = false;
  bool too_wide = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::int32_t limit = std::int32_t{1} << (kind.delta_bits[c] - 1);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      trial.endpoints[2 * k][c] = quantise(lines[k].first[c], kind.endpoint_bits, options.is_signed);
      trial.endpoints[2 * k + 1][c] = quantise(lines[k].second[c], kind.endpoint_bits, options.is_signed);
    }
    if (!kind.transformed) continue;
    const std::int32_t base = trial.endpoints[0][c];
    std::int32_t low = base;
    std::int32_t high = base;
    for (std::size_t e = 1; e < 2 * lines.size(); ++e) {
      std::int32_t& value = trial.endpoints[e][c];
      low = std::min(low, value);
      high = std::max(high, value);
      value = std::clamp(value, base - limit, base + limit - 1);
    }
    too_far = too_far || low < base - limit || high >= base + limit;
    too_wide = too_wide || high - low >= 2 * limit;
  }
  trial.wants_other_start = too_far && !too_wide;
  judge(regions, scale_of(mode, options), trial);
  return trial;
}

void refit_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options, int rounds, Bc6hTrial& trial) {
  const Bc6hScale scale = scale_of(trial.mode, options);
  for (int round = 0; round < rounds; ++round) {
    std::array<Bc6hLine, 2> lines;
    for (std::size_t k = 0; k < regions.size(); ++k) {
      const Bc6hMatch match = match_bc6h(regions[k], scale, ends_of(trial, k));
      const bool straight = options.metric == Bc6hMetric::kLog;
      lines[k] =
          straight ? fit_bc6h_line(regions[k], regions[k].fit_weight, match.indices, scale)
                   : fit_bc6h_line(regions[k], chord_weights(regions[k], scale, trial, k, match), match.indices, scale);
      orient_bc6h_line(regions[k], lines[k]);
    }
    const Bc6hTrial next =
        make_bc6h_trial(regions, std::span(lines).first(regions.size()), trial.mode, trial.partition, options);
    if (!(next.error() < trial.error())) return;
    trial = next;
  }
}

void try_bc6h_lines(std::span<const Bc6hRegion> regions, std::span<const Bc6hLine> lines, std::size_t k,
                    const Bc6hOptions& options, std::size_t polished, Bc6hTrial& trial) {
  const Bc6hScale scale = scale_of(trial.mode, options);
  std::vector<Bc6hTrial> others;
  for (const Bc6hLine& line : lines) {
    Bc6hTrial other = trial;
    if (!put_line(line, k, options.is_signed, other)) continue;
    other.errors[k] = match_bc6h(regions[k], scale, ends_of(other, k)).error;
    others.push_back(other);
  }
  const auto end = others.begin() + static_cast<std::ptrdiff_t>(std::min(others.size(), polished));
  std::partial_sort(others.begin(), end, others.end(),
                    [&](const Bc6hTrial& a, const Bc6hTrial& b) { return a.errors[k] < b.errors[k]; });
  constexpr float kWorthPolishing = 4;
  for (auto other = others.begin(); other != end && other->errors[k] <= kWorthPolishing * trial.errors[k]; ++other) {
    polish_region(regions[k], options, k, *other);
    if (other->errors[k] < trial.errors[k]) trial = *other;
  }
}

void polish_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options, Bc6hTrial& trial) {
  // A region may get room for its differences when the other one has moved.
  constexpr int kMostRounds = 2;
  for (int round = 0; round < kMostRounds; ++round) {
    bool better = false;
    for (std::size_t k = 0; k < regions.size(); ++k) better = polish_region(regions[k], options, k, trial) || better;
    if (!better || regions.size() == 1) return;
  }
}

Bc6hBytes emit_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options, const Bc6hTrial& trial) {
  const Bc6hScale scale = scale_of(trial.mode, options);
  Bc6hBlock block{.mode = trial.mode, .partition = trial.partition, .endpoints = trial.endpoints};
  for (std::size_t k = 0; k < regions.size(); ++k) {
    const Bc6hMatch match = match_bc6h(regions[k], scale, ends_of(trial, k));
    for (std::size_t at = 0; at < regions[k].size; ++at) {
      block.indices[regions[k].texels[at]] = static_cast<std::uint8_t>(match.indices[at]);
    }
  }
  return emit_bc6h_block(block);
}

}  // namespace sbrdf::internal
