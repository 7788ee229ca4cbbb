#include "formats/core/half.h"

#include <Imath/half.h>

namespace sbrdf::internal {

float float_from_half(std::uint16_t bits) { return imath_half_to_float(bits); }
std::uint16_t half_from_float(float value) { return imath_float_to_half(value); }

}  // namespace sbrdf::internal
