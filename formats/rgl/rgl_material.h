#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/core/result.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal {

/// Always R, G, B.
inline constexpr std::size_t kRglChannelCount = 3;
/// A material with at most this many azimuths of incidence is isotropic.
inline constexpr std::size_t kRglIsotropicMaxPhiCount = 2;

/// Nodes of a table over the unit square, both ends included; x runs fastest. At least 2 along each axis.
struct RglGrid {
  std::size_t x_count = 0;
  std::size_t y_count = 0;

  [[nodiscard]] std::size_t cell_count() const { return x_count * y_count; }
};

/// What an RGB file of the RGL material database holds and evaluation needs (specs/rgl.md, section 2). Every value is
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
  RglGrid rgb_grid;
  std::vector<float> rgb;  ///< [phi_i, theta_i, channel, y, x] in warped coordinates; negative where out of gamut
  std::uint64_t negative_rgb_count = 0;
  std::uint64_t negative_ndf_count = 0;

  [[nodiscard]] bool isotropic() const { return phi_i.size() <= kRglIsotropicMaxPhiCount; }
};

/// Copies the fields of an RGB material out of a tensor file. kInvalidFile: a field is missing or has the wrong type or
/// shape; an axis does not rise or leaves its range; a value is NaN or infinite; sigma is not positive; vndf is
/// negative, or all zero in one slice; rgb or ndf is nowhere positive. kUnsupported: spectral materials.
/// The message names the field and the index, the offset is the value's own.
Result<RglMaterial> parse_rgl_material(const TensorFile& tensors);

}  // namespace sbrdf::internal
