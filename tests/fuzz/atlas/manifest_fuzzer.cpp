#include <memory>
#include <random>
#include <string>

#include "converters/files/atlas/atlas_file.h"
#include "converters/files/atlas/manifest.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/require.h"

// Manifests of atlases: what is accepted evaluates to finite values with any finite texels, and is written and read
// again as it is.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr std::size_t kMostTexels = std::size_t{1} << 18U;

/// Texels of all sizes that floats have, most of them such as atlases hold.
void fill(Atlas& atlas, std::size_t seed) {
  std::minstd_rand random(static_cast<std::minstd_rand::result_type>(seed));
  atlas.texels.resize(std::size_t{atlas.layout.width} * atlas.layout.height * 3);
  for (float& texel : atlas.texels) {
    const auto drawn = static_cast<float>(random() % 4096) / 4096;
    const auto kind = random() % 64;
    texel = kind == 0 ? 3e38F * (2 * drawn - 1) : kind < 8 ? 30 * (2 * drawn - 1) : drawn;
  }
}

void run(const Bytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  static_cast<void>(recognises_manifest(text));
  Result<AtlasManifest> manifest = parse_manifest(text);
  if (!manifest) {
    require(manifest.error().code == ErrorCode::kInvalidFile, "what is refused is no valid manifest");
    return;
  }
  const AtlasFiles& files = manifest->files;
  require(files.texture.find('/') == std::string::npos, "a texture lies in the folder of its manifest");
  const std::string written = emit_manifest(manifest->atlas, files, {});
  const Result<AtlasManifest> again = parse_manifest(written);
  require(again.ok(), "what is written is read");
  require(emit_manifest(again->atlas, again->files, {}) == written, "and is the same again");
  Atlas& atlas = manifest->atlas;
  if (std::size_t{atlas.layout.width} * atlas.layout.height > kMostTexels) return;
  fill(atlas, bytes.size());
  evaluate_everywhere(AtlasSource(std::move(atlas), "fuzzed"));
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
