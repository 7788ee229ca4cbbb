#include "formats/texture/exr_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "formats/core/byte_sink.h"
#include "formats/table/exr_image.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 3;
constexpr std::string_view kAttribute = "software";
constexpr std::string_view kText = "sbrdf";

std::vector<std::string> channel_names() { return {"R", "G", "B"}; }

std::size_t number_size(TexelFormat format) { return format == TexelFormat::kRgba16f ? 2 : 4; }

/// Colours out of texels, or into them; what lies between stays as it is.
void copy_colours(const std::byte* from, std::size_t from_step, std::byte* to, std::size_t to_step, std::size_t size,
                  std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) std::copy_n(from + k * from_step, size, to + k * to_step);
}

}  // namespace

Result<std::vector<std::byte>> write_exr_texture(const Texture& texture) {
  if (Status sound = check_texture(texture); !sound) return sound.error();
  if (texture.format == TexelFormat::kE5b9g9r9 || texel_block(texture.format).side > 1) {
    return unsupported(fmt::format("EXR of texels in {}; float and half texels can be written",
                                   name_of(kTexelFormatNames, texture.format)));
  }
  const std::size_t colour = kChannels * number_size(texture.format);
  const std::size_t texel = texel_block(texture.format).bytes;
  const ExrWriter::Image image{.width = texture.width,
                               .height = texture.height,
                               .channels = channel_names(),
                               .half = texture.format == TexelFormat::kRgba16f,
                               .attribute = std::string(kAttribute),
                               .text = std::string(kText)};
  if (Status possible = ExrWriter::check(image); !possible) return possible.error();
  MemorySink sink;
  const auto writer = ExrWriter::create(sink, image);
  if (!writer) return writer.error();
  const auto texels = std::as_bytes(std::span(texture.bytes));
  std::vector<std::byte> row(texture.width * colour);
  for (std::size_t y = 0; y < texture.height; ++y) {
    copy_colours(&texels[y * texture.width * texel], texel, row.data(), colour, colour, texture.width);
    if (Status written = (*writer)->write_row(row); !written) return written.error();
  }
  if (Status finished = (*writer)->finish(kText); !finished) return finished.error();
  return std::move(sink).take();
}

Result<Texture> read_exr_texture(std::shared_ptr<const ByteSource> bytes, const MemoryLimit& limit) {
  const std::uint64_t file_size = bytes->size();
  const auto reader = ExrReader::open(std::move(bytes), {});
  if (!reader) return reader.error();
  const ExrHeader& header = (*reader)->header();
  const std::array<std::string_view, kChannels> sorted = {"B", "G", "R"};
  const bool rgb = std::equal(header.channels.begin(), header.channels.end(), sorted.begin(), sorted.end(),
                              [](const ExrChannel& channel, std::string_view name) { return channel.name == name; });
  const bool half = header.channels.front().half;
  const bool alike = std::all_of(header.channels.begin(), header.channels.end(),
                                 [&](const ExrChannel& channel) { return channel.half == half; });
  if (!rgb || !alike) return unsupported("an OpenEXR image whose channels are not R, G and B of one type");
  const TexelFormat format = half ? TexelFormat::kRgba16f : TexelFormat::kRgb32f;
  if (Status fits = check_texture_sides(format, header.width, header.height); !fits) return fits.error();
  Texture texture{format, header.width, header.height, {}};
  const std::size_t count = std::size_t{header.width} * header.height;
  const std::size_t colour = kChannels * number_size(format);
  const std::size_t size = texture_bytes(format, header.width, header.height);
  const std::uint64_t needed = size + count * colour + 4 * header.block_size;
  if (needed > limit.of(file_size)) {
    return unsupported(fmt::format("an OpenEXR image that takes {} bytes of memory in a file of {}; the limit is {}",
                                   needed, file_size, limit.of(file_size)));
  }
  std::vector<std::byte> colours(count * colour);
  if (Status read = (*reader)->read(channel_names(), half, colours); !read) return read.error();
  constexpr std::array<std::uint8_t, 8> kHalfOnes = {0x00, 0x3C, 0x00, 0x3C, 0x00, 0x3C, 0x00, 0x3C};
  texture.bytes.resize(size);
  if (half) {  // for the alpha of each
    for (std::size_t k = 0; k < size; ++k) texture.bytes[k] = kHalfOnes[k % kHalfOnes.size()];
  }
  auto* const texels = reinterpret_cast<std::byte*>(texture.bytes.data());
  copy_colours(colours.data(), colour, texels, texel_block(format).bytes, colour, count);
  return texture;
}

}  // namespace sbrdf::internal
