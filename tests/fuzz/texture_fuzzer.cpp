#include <algorithm>
#include <cmath>
#include <memory>

#include "formats/texture/dds.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"
#include "tests/fuzz/require.h"

// The readers of textures: what they accept has the size that it claims, is written again, and comes back.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr MemoryLimit kLimit = {.bytes = std::uint64_t{64} << 20U};

void require_same(const Result<Texture>& back, const Texture& texture) {
  require(back.ok(), "what is written is read");
  require(back->format == texture.format && back->width == texture.width && back->height == texture.height,
          "format and sides come back");
  require(back->bytes == texture.bytes, "texels come back");
}

void exercise_texels(const Texture& texture) {
  const Result<std::vector<float>> rgb = decode_texels(texture);
  if (!rgb) return;
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(rgb->begin(), rgb->end(), finite)) return;
  TexelCounts counts;
  const auto again = encode_texels(texture.format, texture.width, texture.height, *rgb, counts);
  require(again.ok() && counts.clamped == 0 && counts.negative == 0, "finite texels fit their format");
  const Result<std::vector<float>> back = decode_texels(*again);
  require(back.ok() && std::all_of(back->begin(), back->end(), finite), "and stay finite");
  // Blocks are compressed once more, which may lose something.
  if (texel_block(texture.format).side == 1) require(*back == *rgb, "and are the same again");
}

void run(const Bytes& bytes) {
  Result<Texture> texture = read_ktx2(bytes, kLimit);
  if (!texture) texture = read_dds(bytes);
  if (!texture) texture = read_exr_texture(std::make_shared<MemorySource>(bytes), kLimit);
  if (!texture) return;
  require(check_texture(*texture).ok(), "a texture has the size that it claims");
  if (texture->bytes.size() > 100000) return;
  exercise_texels(*texture);
  for (const bool zstd : {false, true}) {
    const auto file = write_ktx2(*texture, {zstd, {{"key", "text"}}});
    require(file.ok() == (texture->format != TexelFormat::kRgb32f), "KTX2 holds all formats but one");
    if (file) require_same(read_ktx2(*file, kLimit), *texture);
  }
  if (const auto file = write_dds(*texture)) require_same(read_dds(*file), *texture);
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
