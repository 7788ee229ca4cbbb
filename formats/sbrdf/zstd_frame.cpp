#include "formats/sbrdf/zstd_frame.h"

#include <zstd.h>

#include <memory>
#include <new>

namespace sbrdf::internal {
namespace {

constexpr int kLevel = 19;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

}  // namespace

std::vector<std::byte> pack_bytes(std::span<const std::byte> bytes, std::string_view dictionary) {
  const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  std::vector<std::byte> packed(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress_usingDict(context.get(), packed.data(), packed.size(), bytes.data(),
                                                   bytes.size(), dictionary.data(), dictionary.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the only way it can fail
  packed.resize(size);
  return packed;
}

std::optional<std::vector<std::byte>> unpack_bytes(std::span<const std::byte> packed, std::size_t size,
                                                   std::string_view dictionary) {
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size) return {};
  if (ZSTD_findFrameCompressedSize(packed.data(), packed.size()) != packed.size()) return {};  // one frame, no more
  const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  std::vector<std::byte> bytes(size);
  if (ZSTD_decompress_usingDict(context.get(), bytes.data(), bytes.size(), packed.data(), packed.size(),
                                dictionary.data(), dictionary.size()) != size) {
    return {};
  }
  return bytes;
}

}  // namespace sbrdf::internal
