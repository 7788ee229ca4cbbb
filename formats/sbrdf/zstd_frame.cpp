#include "formats/sbrdf/zstd_frame.h"

#include <zstd.h>

#include <new>

namespace sbrdf::internal {

std::vector<std::byte> pack_bytes(std::span<const std::byte> bytes, int level) {
  std::vector<std::byte> packed(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the only way it can fail
  packed.resize(size);
  return packed;
}

std::optional<std::vector<std::byte>> unpack_bytes(std::span<const std::byte> packed, std::size_t size) {
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size) return {};
  if (ZSTD_findFrameCompressedSize(packed.data(), packed.size()) != packed.size()) return {};  // one frame, no more
  std::vector<std::byte> bytes(size);
  if (ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size()) != size) return {};
  return bytes;
}

}  // namespace sbrdf::internal
