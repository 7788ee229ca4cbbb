#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "converters/files/value_options.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Files of the RGL material database (Dupuy & Jakob, "An Adaptive Parameterization for Efficient Material Acquisition
// and Rendering", 2018), specs/rgl.md. Nothing is lost in reading: values are evaluated as the database's own loader
// does, but without clipping colours that lie out of gamut, so they may be negative. Not reciprocal.

/// Smallest cosine that f_r cos(theta_v) is divided by; reached at 89.99994 degrees.
inline constexpr double kRglMinCosine = 1e-6;

/// How far values are good for anything: f_r has a pole at the horizon, specs/rgl.md.
inline constexpr double kRglThetaMaxDeg = 80;

/// Files that load_rgl should be asked about: the bytes begin with the magic of a tensor file, or with that of a
/// Fourier BSDF, another format that ends in .bsdf and that load_rgl refuses by its name. The first 12 bytes suffice.
[[nodiscard]] bool recognises_rgl(std::span<const std::byte> bytes);

/// What a spectral file becomes.
enum class RglSpectral : std::uint8_t {
  kChannels,  ///< a channel for each wavelength, named by it: "550 nm"
  kRgb,       ///< R, G, B of linear sRGB, see rgl_spectral.h
};
inline constexpr std::array kRglSpectralNames = {Named{"channels", RglSpectral::kChannels},
                                                 Named{"rgb", RglSpectral::kRgb}};

/// `negatives` says what becomes of values below 0: they stay, become 0, or make the pair of directions unmeasured.
///
/// The material as a source with the channels R, G, B, or those of a spectral file; keeps nothing of the bytes.
/// Findings: stored colours and ndf values that are negative, where there are any. Fails as parse_tensor_file and
/// parse_rgl_material do; kUnsupported also for a Fourier BSDF, for azimuths of incidence that span neither a full, a
/// half nor a quarter turn, and for RglSpectral::kRgb of wavelengths that leave out too much of what is visible.
///
/// Values near grazing: the file holds f_r cos(theta_v), which does not vanish at theta_v = pi/2, so f_r has a pole
/// there. cos(theta_v) is held at kRglMinCosine from below, which keeps f_r finite. At theta_i = 0 the azimuth is 0,
/// whatever is written.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> load_rgl(std::span<const std::byte> bytes,
                                                           Negatives negatives = Negatives::kKeep,
                                                           RglSpectral spectral = RglSpectral::kChannels);

/// What stored() is asked for the file whose tables a source reads, also where options of reading change the values.
inline constexpr std::string_view kRglTables = "rgl tables";

/// The same for a file: the row of the format table. Options: negatives, spectral. The source keeps the bytes, as
/// stored(kRglTables) and, where options change nothing, as stored("rgl").
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_rgl(std::shared_ptr<const ByteSource> bytes,
                                                           const Options& options = {});

}  // namespace sbrdf::internal
