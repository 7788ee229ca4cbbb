#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/core/result.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal {

/// Of an RGB file: R, G, B.
inline constexpr std::size_t kRglRgbCount = 3;
/// A spectral file has at most this many wavelengths: published files have 195.
inline constexpr std::size_t kRglMaxWavelengthCount = 4096;
/// A material with at most this many azimuths of incidence is isotropic.
inline constexpr std::size_t kRglIsotropicMaxPhiCount = 2;

/// Nodes of a table over the unit square, both ends included; x runs fastest. At least 2 along each axis.
struct RglGrid {
  std::size_t x_count = 0;
  std::size_t y_count = 0;

  [[nodiscard]] std::size_t cell_count() const { return x_count * y_count; }
};

/// What a file of the RGL material database holds and evaluation needs (specs/rgl.md, section 2). Every value is
/// finite.
struct RglMaterial {
  std::string description;     ///< one printable line, may be empty
  std::vector<float> phi_i;    ///< azimuths of incidence [radians], rising
  std::vector<float> theta_i;  ///< elevations of incidence [radians], rising within [0, pi/2]
  bool jacobian = true;        ///< `rgb` is still to be multiplied by ndf / (4 sigma)
  RglGrid sigma_grid;
  std::vector<float> sigma;  ///< projected area of the microfacets, positive; [y, x] at the direction of incidence
  RglGrid ndf_grid;
  std::vector<float> ndf;  ///< density of microfacet normals; [y, x] at the half direction
  RglGrid vndf_grid;
  std::vector<float> vndf;  ///< density of visible normals, not negative, no slice all zero; [phi_i, theta_i, y, x]
  std::vector<float> wavelengths;  ///< of the channels [nm], rising; empty in an RGB file
  RglGrid colour_grid;
  std::vector<float> colours;  ///< [phi_i, theta_i, channel, y, x] in warped coordinates; negative where out of gamut
  std::uint64_t negative_colour_count = 0;
  std::uint64_t negative_ndf_count = 0;

  [[nodiscard]] bool spectral() const { return !wavelengths.empty(); }
  [[nodiscard]] std::size_t channel_count() const { return spectral() ? wavelengths.size() : kRglRgbCount; }
  [[nodiscard]] std::size_t slice_count() const { return phi_i.size() * theta_i.size(); }

  [[nodiscard]] bool isotropic() const { return phi_i.size() <= kRglIsotropicMaxPhiCount; }
};

/// Copies the fields of a material out of a tensor file: the field `rgb`, or where there is none, `spectra` and
/// `wavelengths`. kInvalidFile: a field is missing or has the wrong type or shape; an axis does not rise or leaves its
/// range; a value is NaN or infinite; sigma is not positive; vndf is negative, or all zero in one slice; the colours or
/// ndf are nowhere positive. kUnsupported: polarised materials (Mueller matrices), more wavelengths than the limit.
/// The message names the field and the index, the offset is the value's own.
Result<RglMaterial> parse_rgl_material(const TensorFile& tensors);

/// What only the drawing of samples needs: not read, but written for programs that draw.
struct RglSampling {
  std::vector<float> luminance;     ///< [phi_i, theta_i, y, x] on the grid of the colours; no slice all zero
  std::vector<std::uint8_t> valid;  ///< a bit for each of these, the highest first: the direction is above the horizon
};

/// A whole file with the fields of published files, `rgb` or `spectra` as the material has them. The tables have the
/// sizes that their grids say, and hold what parse_rgl_material takes; so the file can be read by it and by the
/// programs that specs/rgl.md names.
[[nodiscard]] std::vector<std::byte> emit_rgl_material(const RglMaterial& material, const RglSampling& sampling);

}  // namespace sbrdf::internal
