#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/coding/chunk_layout.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

/// A sliced BRDF with the lattice that its frame gives.
struct DecodedSliced {
  SlicedBrdf sliced;
  Lattice lattice;
  std::string version = {};  ///< of the container, such as "1.0"; empty for what was not read from one
  double precision = 0;      ///< the bound that the file keeps, see EncodeOptions
};

/// How the samples of a file are spread over chunks.
enum class ChunkSize : std::uint8_t {
  kAuto,   ///< whole below kSplitFrom samples, split from there on
  kWhole,  ///< one chunk: the smallest file, of which nothing can be read by itself
  kSplit,  ///< small blocks, for loading regions and levels of detail
};
inline constexpr std::size_t kSplitFrom = 65'536;

struct EncodeOptions {
  /// Largest relative error of every stored f_r, 1e-6 to 0.5, rounded down to millionths; exact zeros stay zero. 0:
  /// lossless, the float32 values as they are (a negative zero becomes zero). Where a bound cannot be kept, as for some
  /// values below 2^-126, the file is lossless.
  double precision = 0;
  ChunkSize chunks = ChunkSize::kAuto;
};

/// The bytes of a sliced BRDF file (specs/sbrdf.md). `sliced` has passed check_sliced with `lattice`, which is that of
/// its frame. The same input gives the same bytes on any machine; only the metadata depend on the version of zlib.
[[nodiscard]] std::vector<std::byte> encode_sliced(const SlicedBrdf& sliced, const Lattice& lattice,
                                                   const EncodeOptions& options = {});

/// How much of a file is samples, and how little it could be with the same predictions and contexts.
struct CodingCost {
  std::uint64_t stream_bytes = 0;  ///< chunks of samples, crossings and guide, checksums left out
  double entropy_bytes = 0;        ///< empirical entropy of tokens and flags in their contexts, plus the plain bits
};
[[nodiscard]] CodingCost coding_cost(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options);

/// The inverse. What comes back satisfies check_frame and check_sliced. kUnsupported where that would take more memory
/// than `limit` allows.
[[nodiscard]] Result<DecodedSliced> decode_sliced(std::span<const std::byte> bytes, const MemoryLimit& limit = {});

}  // namespace sbrdf::internal
