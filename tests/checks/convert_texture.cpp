// Writes and reads textures, for comparison with readers that are not ours.
//
// usage: convert_texture write FORMAT WIDTH HEIGHT IN OUT [KEY=TEXT ...]
//        convert_texture read IN OUT
//   IN or OUT is .rgb (float32, three a texel), .texels (their bytes), .ktx2, .zstd.ktx2, .dds or .exr
// `write` prints how many channels were clamped and how many negative; `read` prints format, width and height.
// Exit codes: those of ErrorCode, with the message on stderr.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/texture/dds.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

Result<Bytes> load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return io_error(path + " cannot be read");
  const std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto bytes = std::as_bytes(std::span(content));
  return Bytes(bytes.begin(), bytes.end());
}

Status save(const std::string& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) return io_error(path + " cannot be written");
  return ok_status();
}

Result<Bytes> emit(const Texture& texture, std::string_view path, Ktx2Options options) {
  options.zstd = path.ends_with(".zstd.ktx2");
  if (path.ends_with(".ktx2")) return write_ktx2(texture, options);
  if (path.ends_with(".dds")) return write_dds(texture);
  if (path.ends_with(".exr")) return write_exr_texture(texture);
  if (path.ends_with(".rgb")) {
    const Result<std::vector<float>> rgb = decode_texels(texture);
    if (!rgb) return rgb.error();
    const auto bytes = std::as_bytes(std::span(*rgb));
    return Bytes(bytes.begin(), bytes.end());
  }
  const auto bytes = std::as_bytes(std::span(texture.bytes));
  return Bytes(bytes.begin(), bytes.end());
}

Result<Texture> parse(Bytes bytes) {
  if (recognises_ktx2(bytes)) return read_ktx2(bytes);
  if (recognises_dds(bytes)) return read_dds(bytes);
  return read_exr_texture(std::make_shared<OwnedMemorySource>(std::move(bytes)));
}

Status write(std::span<char*> words) {
  const auto format = value_of(kTexelFormatNames, words[0]);
  if (!format) return usage_error("no such format");
  const auto width = static_cast<std::uint32_t>(std::stoul(words[1]));
  const auto height = static_cast<std::uint32_t>(std::stoul(words[2]));
  const Result<Bytes> content = load(words[3]);
  if (!content) return content.error();
  const auto* const first = reinterpret_cast<const std::uint8_t*>(content->data());
  Result<Texture> texture(Texture{*format, width, height, std::vector<std::uint8_t>(first, first + content->size())});
  TexelCounts counts;
  if (std::string_view(words[3]).ends_with(".rgb")) {
    std::vector<float> rgb(content->size() / sizeof(float));
    std::memcpy(rgb.data(), content->data(), rgb.size() * sizeof(float));
    texture = encode_texels(*format, width, height, rgb, counts);
  }
  if (!texture) return texture.error();
  Ktx2Options options;
  for (const std::string word : words.subspan(5)) {
    const std::size_t end = word.find('=');
    options.keys.emplace_back(word.substr(0, end), word.substr(end + 1));
  }
  const Result<Bytes> file = emit(*texture, words[4], options);
  if (!file) return file.error();
  std::cout << counts.clamped << ' ' << counts.negative << '\n';
  return save(words[4], *file);
}

Status read(std::span<char*> words) {
  Result<Bytes> content = load(words[0]);
  if (!content) return content.error();
  const Result<Texture> texture = parse(*std::move(content));
  if (!texture) return texture.error();
  const Result<Bytes> out = emit(*texture, words[1], {});
  if (!out) return out.error();
  std::cout << name_of(kTexelFormatNames, texture->format) << ' ' << texture->width << ' ' << texture->height << '\n';
  return save(words[1], *out);
}

Status run(std::span<char*> words) {
  if (words.size() >= 6 && words[0] == std::string_view("write")) return write(words.subspan(1));
  if (words.size() == 3 && words[0] == std::string_view("read")) return read(words.subspan(1));
  return usage_error("usage: convert_texture write FORMAT WIDTH HEIGHT IN OUT [KEY=TEXT ...] | read IN OUT");
}

}  // namespace
}  // namespace sbrdf::internal

int main(int count, char** arguments) {
  using namespace sbrdf::internal;
  try {
    const Status done = run(std::span(arguments, static_cast<std::size_t>(count)).subspan(1));
    if (done) return 0;
    std::cerr << done.error().message << '\n';
    return static_cast<int>(done.error().code);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(ErrorCode::kIo);
  }
}
