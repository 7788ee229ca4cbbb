#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// What the samples of one material take on disk. All sizes in bytes; files include metadata and index.
struct CodingSizes {
  std::string material;
  std::uint64_t samples = 0;
  std::uint64_t values = 0;         ///< samples times channels
  std::uint64_t raw = 0;            ///< float32 values, and 2 + 2 bytes for the place of a sample beside the crossings
  std::uint64_t lossless = 0;       ///< .sbrdf files
  std::uint64_t tenth_percent = 0;  ///< every sample within 0.1 %
  std::uint64_t one_percent = 0;    ///< every sample within 1 %
  std::uint64_t baseline = 0;       ///< see baseline_size, at 0.1 %
  std::uint64_t stream = 0;         ///< of tenth_percent, what codes the samples
  double entropy = 0;               ///< what is left of `stream` at the empirical entropy of its residuals

  [[nodiscard]] double bits_per_value() const {
    return 8.0 * static_cast<double>(tenth_percent) / static_cast<double>(values);
  }
};

[[nodiscard]] CodingSizes coding_sizes(const std::string& material, const SlicedBrdf& sliced, const Lattice& lattice);

/// The yardstick: logarithms quantised to the same bound, differences between successive samples of a channel, bytes of
/// equal weight together, zstd -3; positions the same way. What a general tool would do with the same samples.
[[nodiscard]] std::uint64_t baseline_size(const SlicedBrdf& sliced, double bound);

}  // namespace sbrdf::internal
