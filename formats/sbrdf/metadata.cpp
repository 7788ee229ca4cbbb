#include "formats/sbrdf/metadata.h"

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

std::string_view metadata_dictionary() {
  return R"("findings":[{"what":"negative stored rgb values","count":,"total":}]"symmetrised":true,)"
         R"("refinement":"measured","domain":"linear","colour":"channels as in the source, linear",)"
         R"({"source":{"format":"merl","description":"MERL table, isotropic, half/difference angles","sha256":")"
         R"({"source":{"format":"kurt","description":"Kurt model , 2 lobes"},"command":"sbrdf convert kurt:)"
         R"({"source":{"format":"rgl","description":"RGL material, isotropic, RGB","sha256":")"
         R"("command":"sbrdf convert .bsdf .sbrdf --samples --precision 0.1% --placement 14/36",)"
         R"("quantity":"f_r, 1/sr, without cosine","colour":"channels as in the source, linear",)"
         R"("precision_percent":0.1,"symmetrised":false,"reciprocity_residual_percent":0.0,"refinement":"true",)"
         R"("zero_values":0,"negative_values":0,"error":{"mre_percent":0.,"rel_l1_percent":0.,"directions":12000,)"
         R"("measured_on":"random directions that took no part in any choice, theta up to 80 degrees"}})";
}

std::vector<std::byte> pack_metadata(std::string_view text) {
  const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  const std::string_view dictionary = metadata_dictionary();
  std::vector<std::byte> packed(ZSTD_compressBound(text.size()));
  const std::size_t size = ZSTD_compress_usingDict(context.get(), packed.data(), packed.size(), text.data(),
                                                   text.size(), dictionary.data(), dictionary.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the only way it can fail
  packed.resize(size);
  return packed;
}

std::optional<std::string> unpack_metadata(std::span<const std::byte> packed, std::size_t size) {
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size) return {};
  if (ZSTD_findFrameCompressedSize(packed.data(), packed.size()) != packed.size()) return {};  // one frame, no more
  const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  const std::string_view dictionary = metadata_dictionary();
  std::string text(size, '\0');
  if (ZSTD_decompress_usingDict(context.get(), text.data(), text.size(), packed.data(), packed.size(),
                                dictionary.data(), dictionary.size()) != size) {
    return {};
  }
  return text;
}

}  // namespace sbrdf::internal
