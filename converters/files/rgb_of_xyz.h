#pragma once

#include <array>

namespace sbrdf::internal {

/// Linear sRGB of CIE XYZ under D65 (IEC 61966-2-1): a row for each of R, G, B.
inline constexpr std::array<std::array<double, 3>, 3> kRgbOfXyz = {
    {{3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}}};

}  // namespace sbrdf::internal
