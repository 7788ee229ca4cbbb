#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/series/series.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// A dense file: the container of sliced files with an index of another kind, and no chunks. specs/sbrdf.md, section 14.

/// Whether this is a container with such an index, whatever else is wrong with it: by the frame, its first byte.
[[nodiscard]] bool is_series_file(const ByteSource& source);

/// The bytes of a file. `brdf` is one that decode_series could have given.
[[nodiscard]] std::vector<std::byte> encode_series(const SeriesBrdf& brdf);

/// Terms of levels above `most_level` are left out.
[[nodiscard]] Result<SeriesBrdf> decode_series(const ByteSource& source, std::uint32_t most_level = kSeriesLevels);

}  // namespace sbrdf::internal
