#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

// KTX 2.0 files (Khronos KTX File Format Specification 2.0) that hold one 2-D texture of one level.

struct Ktx2Options {
  bool zstd = false;  ///< packs the texels as one zstd frame; not every engine unpacks it
  /// Keys with a text each, beside KTXorientation ("rd": rows from the top, each from the left) and KTXwriter
  /// ("sbrdf"). In any order.
  std::vector<std::pair<std::string, std::string>> keys = {};
};

/// The bytes of a file. kUnsupported for kRgb32f, which graphics cards do not take: encode kRgba32f. kUsage where a key
/// is empty, stands twice or begins with KTX or ktx, and where a key or text holds a zero byte; errors as of
/// check_texture().
[[nodiscard]] Result<std::vector<std::byte>> write_ktx2(const Texture& texture, const Ktx2Options& options = {});

/// A cube map of one level: what a texel is, and all texels face by face (+x, -x, +y, -y, +z, -z), rows from the top.
struct CubeTexture {
  enum class Texel : std::uint8_t {
    kRgb8,    ///< three numbers of 8 bits, 255 standing for 1
    kRgb16f,  ///< three half floats
  };
  Texel texel = Texel::kRgb8;
  std::uint32_t side = 0;
  std::vector<std::uint8_t> bytes;
};
/// The bytes of a file. kUsage where `bytes` has another size than sides and texels say.
[[nodiscard]] Result<std::vector<std::byte>> write_ktx2_cube(const CubeTexture& texture);

/// The file begins as a KTX 2.0 file does.
[[nodiscard]] bool recognises_ktx2(std::span<const std::byte> head);

/// The texture of a file as write_ktx2() writes them, of any keys. Nothing is allocated before all sizes have been
/// compared with those of the bytes.
///
/// kInvalidFile where the file is cut off, goes on behind the texels or contradicts itself; kUnsupported, saying what,
/// for other formats, several levels, layers or faces, volumes, other ways of packing, another orientation, another
/// descriptor of the format, and where unpacking would take more than `limit`. Both with the offset.
[[nodiscard]] Result<Texture> read_ktx2(std::span<const std::byte> bytes, const MemoryLimit& limit = {});

}  // namespace sbrdf::internal
