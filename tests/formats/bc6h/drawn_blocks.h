#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string_view>

#include "formats/core/half.h"
#include "formats/texture/bc6h/bc6h.h"

namespace sbrdf::internal {

/// Kinds of blocks that an encoder is tried on.
inline constexpr std::array<std::string_view, 5> kBc6hBlockKinds = {"smooth", "edges", "highlight", "signed", "noise"};

/// A block of one of these kinds; `draw` says which. Values are around 1, and negative ones only in "signed".
inline Bc6hTexels draw_bc6h_block(std::string_view kind, std::mt19937& draw) {
  std::uniform_real_distribution<double> one(-1, 1);
  const double angle = 3.2 * one(draw);
  const double offset = 2 * one(draw);
  // Of the logarithm: a level, two slopes and a curvature for each side and channel; channels are nearly alike.
  std::array<std::array<std::array<double, 4>, 3>, 2> sides{};
  for (auto& side : sides) {
    std::array<double, 4> common{};
    for (std::size_t k = 0; k < 4; ++k) common[k] = (k == 0 ? 3.0 : k == 3 ? 0.02 : 0.15) * one(draw);
    for (auto& channel : side) {
      for (std::size_t k = 0; k < 4; ++k)
        channel[k] = common[k] * (1 + 0.15 * one(draw)) + (k == 0 ? 0.4 * one(draw) : 0);
    }
  }
  const double sharpness = std::exp(1.5 * one(draw));
  Bc6hTexels texels{};
  for (std::size_t k = 0; k < 16; ++k) {
    const double x = static_cast<double>(k % 4) - 1.5;
    const double y = static_cast<double>(k / 4) - 1.5;
    const bool beyond = kind == "edges" && std::cos(angle) * x + std::sin(angle) * y > offset;
    const double peak = 6 / (1 + sharpness * ((x - offset) * (x - offset) + y * y));
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& s = sides[beyond ? 1 : 0][c];
      double value = std::exp(s[0] + s[1] * x + s[2] * y + s[3] * x * y + 0.01 * one(draw));
      if (kind == "highlight") value = std::exp(s[0] - 2) + std::exp(s[1] + peak);
      if (kind == "signed") value = s[0] * x + s[1] * y + s[2];
      if (kind == "noise") value = std::exp(2 * one(draw));
      texels[k][c] = half_from_float(static_cast<float>(value));
    }
  }
  return texels;
}

}  // namespace sbrdf::internal
