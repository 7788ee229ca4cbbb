#pragma once

#include <span>
#include <string>
#include <vector>

#include "codec/lattice.h"
#include "codec/sliced_brdf.h"
#include "formats/core/result.h"

namespace sbrdf {

/// A sliced BRDF with the lattice that its frame gives.
struct DecodedSliced {
  SlicedBrdf sliced;
  Lattice lattice;
  std::string version = {};  ///< of the container, such as "0.1"; empty for what was not read from one
};

/// The bytes of a sliced BRDF file (specs/sbrdf.md). Values are kept exactly.
[[nodiscard]] std::vector<std::byte> encode_sliced(const SlicedBrdf& sliced);

/// The inverse. What comes back has passed check_frame and check_sliced.
[[nodiscard]] Result<DecodedSliced> decode_sliced(std::span<const std::byte> bytes);

}  // namespace sbrdf
