#include "formats/texture/dds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "formats/core/byte_reader.h"
#include "formats/core/named.h"

namespace sbrdf::internal {
namespace {

// Names and values are those of the guide.
constexpr std::string_view kMagic = "DDS ";
constexpr std::uint32_t kHeaderSize = 124;
constexpr std::uint32_t kPixelFormatSize = 32;
constexpr std::size_t kTexelOffset = 4 + kHeaderSize + 20;
constexpr std::uint32_t kFlags = 0x1 | 0x2 | 0x4 | 0x1000 | 0x20000;  // caps, height, width, pixel format, mip count
constexpr std::uint32_t kFlagPitch = 0x8;
constexpr std::uint32_t kFlagLinearSize = 0x80000;
constexpr std::uint32_t kFourCc = 0x4;
constexpr std::string_view kDx10 = "DX10";
constexpr std::uint32_t kCapsTexture = 0x1000;
constexpr std::uint32_t kTexture2d = 3;

struct DxgiFormat {
  TexelFormat format;
  std::uint32_t number;
};
constexpr std::array kFormats = {DxgiFormat{TexelFormat::kRgba32f, 2}, DxgiFormat{TexelFormat::kE5b9g9r9, 67},
                                 DxgiFormat{TexelFormat::kBc6hUnsigned, 95}, DxgiFormat{TexelFormat::kBc6hSigned, 96}};

Error wrong(std::string_view what, std::uint64_t offset) { return invalid_file(fmt::format("DDS: {}", what), offset); }
Error other(std::string_view what, std::uint64_t offset) { return unsupported(fmt::format("DDS: {}", what), offset); }

void zeros(ByteWriter& out, std::size_t numbers) {
  for (std::size_t k = 0; k < numbers; ++k) out.number(std::uint32_t{0});
}

struct Head {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t dxgi = 0;
};

Status check_magic_and_size(ByteReader& in) {
  const std::string magic = in.text(kMagic.size());
  const std::uint32_t size = in.u32();
  if (!in.ok()) return in.error();
  if (magic != kMagic) return wrong("the file does not begin as one", 0);
  if (size != kHeaderSize) return wrong(fmt::format("a header of {} bytes, not {}", size, kHeaderSize), 4);
  return ok_status();
}

Status check_pixel_format(ByteReader& in) {
  const std::uint64_t offset = in.offset();
  const std::uint32_t size = in.u32();
  const std::uint32_t flags = in.u32();
  const std::string four = in.text(4);
  in.bytes(20);  // masks of channels
  if (!in.ok()) return in.error();
  if (size != kPixelFormatSize) return wrong(fmt::format("a pixel format of {} bytes, not 32", size), offset);
  if ((flags & kFourCc) == 0 || four != kDx10) return other("only files with a DX10 header are read", offset + 4);
  return ok_status();
}

Status check_dx10(ByteReader& in, Head& head) {
  const std::uint64_t offset = in.offset();
  head.dxgi = in.u32();
  const std::uint32_t dimension = in.u32();
  const std::uint32_t kind = in.u32();
  const std::uint32_t layers = in.u32();
  in.u32();  // what alpha means
  if (!in.ok()) return in.error();
  if (dimension != kTexture2d) return other("a texture that is not 2-D", offset + 4);
  if (kind != 0) return other("a cube map", offset + 8);
  if (layers != 1) return other("a texture of several layers", offset + 12);
  return ok_status();
}

Result<Head> parse_head(ByteReader& in) {
  if (Status sound = check_magic_and_size(in); !sound) return sound.error();
  Head head;
  in.u32();  // flags
  head.height = in.u32();
  head.width = in.u32();
  in.u32();  // pitch
  const std::uint32_t depth = in.u32();
  const std::uint32_t levels = in.u32();
  in.bytes(44);  // reserved
  if (!in.ok()) return in.error();
  if (depth > 1) return other("a volume", 24);
  if (levels > 1) return other("a texture of several levels", 28);
  if (Status sound = check_pixel_format(in); !sound) return sound.error();
  in.bytes(20);  // capabilities
  if (Status sound = check_dx10(in, head); !sound) return sound.error();
  return head;
}

}  // namespace

Result<std::vector<std::byte>> write_dds(const Texture& texture) {
  if (Status sound = check_texture(texture); !sound) return sound.error();
  const auto* const row = std::find_if(kFormats.begin(), kFormats.end(),
                                       [&](const DxgiFormat& known) { return known.format == texture.format; });
  if (texture.format == TexelFormat::kRgba16f) {
    return unsupported("half floats in DDS, which two common readers take for something else; KTX2 and EXR hold them");
  }
  if (row == kFormats.end()) return unsupported("DDS of three floats a texel; rgba32f has an alpha of 1");
  const TexelBlock block = texel_block(texture.format);
  const bool blocks = block.side > 1;
  ByteWriter out;
  out.text(kMagic);
  out.number(kHeaderSize);
  out.number(kFlags | (blocks ? kFlagLinearSize : kFlagPitch));
  out.number(texture.height);
  out.number(texture.width);
  // Of blocks the size of all; else that of a row. 32 bits are all it has, and readers know better.
  out.number(blocks ? static_cast<std::uint32_t>(texture.bytes.size()) : texture.width * block.bytes);
  zeros(out, 1);                 // depth
  out.number(std::uint32_t{1});  // levels
  zeros(out, 11);
  out.number(kPixelFormatSize);
  out.number(kFourCc);
  out.text(kDx10);
  zeros(out, 5);
  out.number(kCapsTexture);
  zeros(out, 4);
  for (const std::uint32_t number : {row->number, kTexture2d, 0U, 1U, 0U}) out.number(number);
  out.bytes(std::as_bytes(std::span(texture.bytes)));
  return std::move(out).take();
}

bool recognises_dds(std::span<const std::byte> head) {
  ByteReader in(head);
  return in.text(kMagic.size()) == kMagic && in.u32() == kHeaderSize;
}

Result<Texture> read_dds(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const Result<Head> head = parse_head(in);
  if (!head) return head.error();
  const auto* const row = std::find_if(kFormats.begin(), kFormats.end(),
                                       [&](const DxgiFormat& known) { return known.number == head->dxgi; });
  if (row == kFormats.end()) return other(fmt::format("DXGI format {} is not read", head->dxgi), kTexelOffset - 20);
  if (Status fits = check_texture_sides(row->format, head->width, head->height); !fits) {
    return other(fits.error().message, 12);
  }
  const std::size_t expected = texture_bytes(row->format, head->width, head->height);
  if (in.remaining() != expected) {
    return wrong(fmt::format("{}: {} x {} texels need {} bytes, {} are there",
                             in.remaining() < expected ? "truncated" : "bytes after the end of the texels", head->width,
                             head->height, expected, in.remaining()),
                 kTexelOffset + std::min(in.remaining(), expected));
  }
  const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes.data()) + kTexelOffset;
  return Texture{row->format, head->width, head->height, std::vector<std::uint8_t>(first, first + expected)};
}

}  // namespace sbrdf::internal
