#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/core/result.h"
#include "formats/rgl/rgl_material.h"

namespace sbrdf::internal {

// Wavelengths of RGL materials: as names of channels, and as colours.

/// "550 nm", "360.5 nm".
[[nodiscard]] std::string rgl_channel_name(float wavelength_nm);
/// The other way: the wavelengths of all channels [nm], where every name is such a number, positive and rising; nothing
/// otherwise.
[[nodiscard]] std::optional<std::vector<float>> wavelengths_of_channels(std::span<const std::string> names);

/// Wavelengths from which colours are worked out begin here or before and end there or beyond [nm]: outside, the eye
/// sees less than 1 % of the light.
inline constexpr double kRglColoursFromNm = 430;
inline constexpr double kRglColoursToNm = 670;

/// What each wavelength counts in R, G and B of linear sRGB: [channel, wavelength].
///
/// The colour of the material under daylight D65 to the standard observer of CIE 1931 (2 degrees): X, Y and Z are
/// integrals of spectrum x D65 x curve over 380 to 780 nm, divided by that of D65 x y; the spectrum is linear between
/// the wavelengths and held at both ends. Then IEC 61966-2-1. White is D65, as of sRGB itself: a spectrum that is the
/// same everywhere is grey, and its R, G and B are its own value. Rows add up to 1.
[[nodiscard]] std::vector<double> rgl_rgb_weights(std::span<const float> wavelengths_nm);

/// Turns a spectral material into an RGB one: as evaluation is linear in the colours, the same as weighing values.
/// kUnsupported where the wavelengths leave out part of kRglColoursFromNm to kRglColoursToNm; kInvalidFile where no
/// colour is positive or one is beyond the range of float.
[[nodiscard]] Status reduce_to_rgb(RglMaterial& material);

}  // namespace sbrdf::internal
