#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/core/byte_reader.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// The names of channels in the index of a file (specs/sbrdf.md, section 2): R, G, B, which most have, take one byte.

inline constexpr std::uint64_t kMostNamedChannels = 4096;

void put_channel_names(ByteWriter& out, const std::vector<std::string>& channels);
/// Refuses more than can be [SB-2-6]; a short read sticks to `in`.
[[nodiscard]] Status take_channel_names(ByteReader& in, std::vector<std::string>& channels);

}  // namespace sbrdf::internal
