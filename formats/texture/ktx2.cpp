#include "formats/texture/ktx2.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/zstd_frame.h"
#include "formats/texture/ktx2_descriptor.h"

namespace sbrdf::internal {
namespace {

constexpr std::array<std::uint8_t, 12> kIdentifier = {0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32,
                                                      0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A};
constexpr std::uint32_t kNone = 0;
constexpr std::uint32_t kZstd = 2;
/// Identifier, header, index, and the index of one level: sections 3.1 to 3.9.
constexpr std::uint64_t kHeadSize = 104;
constexpr std::uint64_t kLongestKeys = std::uint64_t{1} << 24U;
constexpr std::string_view kOrientation = "KTXorientation";
constexpr std::string_view kWriter = "KTXwriter";
constexpr std::string_view kFromTopLeft = "rd";

std::uint64_t padded(std::uint64_t size, std::uint64_t step) { return (size + step - 1) / step * step; }

std::uint64_t level_alignment(TexelFormat format, bool zstd) {
  return zstd ? 1 : std::lcm<std::uint64_t>(texel_block(format).bytes, 4);
}

Error wrong(std::string_view what, std::uint64_t offset) { return invalid_file(fmt::format("KTX2: {}", what), offset); }
Error other(std::string_view what, std::uint64_t offset) { return unsupported(fmt::format("KTX2: {}", what), offset); }

/// Where the parts of a file lie and how large they are; in the order of the file.
struct Head {
  std::uint32_t vk_format = 0;
  std::uint32_t type_size = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t faces = 1;
  std::uint32_t packing = kNone;
  std::uint32_t descriptor_offset = kHeadSize;
  std::uint32_t descriptor_size = 0;
  std::uint32_t keys_offset = 0;
  std::uint32_t keys_size = 0;
  std::uint64_t level_offset = 0;
  std::uint64_t level_size = 0;
  std::uint64_t level_unpacked = 0;
};

void pad(ByteWriter& out, std::uint64_t step) {
  while (out.size() % step != 0) out.number(std::uint8_t{0});
}

void emit_head(const Head& head, ByteWriter& out) {
  out.bytes(std::as_bytes(std::span(kIdentifier)));
  for (const std::uint32_t number : {head.vk_format, head.type_size, head.width, head.height, 0U /* depth */,
                                     0U /* layers */, head.faces, 1U /* levels */, head.packing, head.descriptor_offset,
                                     head.descriptor_size, head.keys_offset, head.keys_size}) {
    out.number(number);
  }
  // Of the data that some ways of packing need for all levels: none.
  for (const std::uint64_t number :
       {std::uint64_t{0}, std::uint64_t{0}, head.level_offset, head.level_size, head.level_unpacked}) {
    out.number(number);
  }
}

/// `head` tells of the format, the sides and the packing, and where `level` is packed what it was before.
std::vector<std::byte> emit_file(Head head, std::span<const std::byte> descriptor, std::span<const std::byte> keys,
                                 std::span<const std::byte> level, std::uint64_t alignment) {
  head.descriptor_size = static_cast<std::uint32_t>(descriptor.size());
  head.keys_offset = static_cast<std::uint32_t>(kHeadSize + descriptor.size());
  head.keys_size = static_cast<std::uint32_t>(keys.size());
  head.level_offset = padded(head.keys_offset + keys.size(), alignment);
  head.level_size = level.size();
  ByteWriter out;
  emit_head(head, out);
  out.bytes(descriptor);
  out.bytes(keys);
  pad(out, alignment);
  out.bytes(level);
  return std::move(out).take();
}

bool has_zero(std::string_view text) { return text.find('\0') != std::string_view::npos; }

Result<std::vector<std::byte>> emit_keys(const Ktx2Options& options) {
  std::map<std::string_view, std::string_view> sorted = {{kOrientation, kFromTopLeft}, {kWriter, "sbrdf"}};
  for (const auto& [key, text] : options.keys) {
    if (key.empty() || has_zero(key) || has_zero(text))
      return usage_error("a KTX2 key or its text is empty or no text");
    if (key.starts_with("KTX") || key.starts_with("ktx")) {
      return usage_error(fmt::format("\"{}\": KTX2 keeps keys that begin with KTX or ktx for itself", key));
    }
    if (!sorted.emplace(key, text).second) return usage_error(fmt::format("the KTX2 key \"{}\" stands twice", key));
  }
  ByteWriter out;
  for (const auto& [key, text] : sorted) {
    out.number(static_cast<std::uint32_t>(key.size() + text.size() + 2));
    for (const std::string_view part : {key, text}) {
      out.text(part);
      out.number(std::uint8_t{0});
    }
    pad(out, 4);
    if (out.size() > kLongestKeys) return usage_error("KTX2 keys of more than 16 MiB");
  }
  return std::move(out).take();
}

/// Walks through a file from its start.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes), in_(bytes) {}

  Result<Texture> read(const MemoryLimit& limit) {
    if (!recognises_ktx2(bytes_)) return wrong("the file does not begin as one", 0);
    for (const auto step : {&Reader::read_head, &Reader::check_layout, &Reader::check_descriptor, &Reader::check_keys,
                            &Reader::check_padding}) {
      if (Status sound = (this->*step)(); !sound) return sound.error();
    }
    return read_level(limit);
  }

 private:
  Status read_head() {
    in_.bytes(kIdentifier.size());
    for (std::uint32_t* number : {&head_.vk_format, &head_.type_size, &head_.width, &head_.height}) *number = in_.u32();
    const std::array<std::uint32_t, 4> counts = {in_.u32(), in_.u32(), in_.u32(), in_.u32()};
    for (std::uint32_t* number :
         {&head_.packing, &head_.descriptor_offset, &head_.descriptor_size, &head_.keys_offset, &head_.keys_size}) {
      *number = in_.u32();
    }
    const std::array<std::uint64_t, 2> global = {in_.u64(), in_.u64()};
    for (std::uint64_t* number : {&head_.level_offset, &head_.level_size, &head_.level_unpacked}) *number = in_.u64();
    if (!in_.ok()) return in_.error();

    const std::optional<Ktx2Format> format = ktx2_format_of_number(head_.vk_format);
    if (!format) return other(fmt::format("VkFormat {} is not read", head_.vk_format), 12);
    format_ = format->format;
    if (head_.type_size != format->type_size) {
      return wrong(fmt::format("typeSize is {}, its format has {}", head_.type_size, format->type_size), 16);
    }
    constexpr std::array<std::uint32_t, 4> kOne = {0, 0, 1, 1};
    constexpr std::array<const char*, 4> kNames = {"a volume", "several layers", "several faces", "several levels"};
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (counts[k] != kOne[k]) {
        return other(fmt::format("a texture of {}; those of one 2-D image are read", kNames[k]), 28 + 4 * k);
      }
    }
    if (head_.packing != kNone && head_.packing != kZstd) {
      return other(fmt::format("supercompression scheme {}; none and zstd are read", head_.packing), 44);
    }
    if (global[0] != 0 || global[1] != 0) return wrong("global data of a way of packing that has none", 64);
    return ok_status();
  }

  // Every part begins where the one before it ends, and the last one ends with the file.
  Status check_layout() {
    if (Status fits = check_texture_sides(format_, head_.width, head_.height); !fits) {
      return other(fits.error().message, 20);
    }
    if (head_.descriptor_offset != kHeadSize) return wrong("the descriptor does not follow the header", 48);
    const std::uint64_t descriptor_end = kHeadSize + head_.descriptor_size;
    if (descriptor_end > bytes_.size()) return cut("the descriptor");
    if (head_.keys_offset != (head_.keys_size == 0 ? 0 : descriptor_end)) {
      return wrong("the keys do not follow the descriptor", 56);
    }
    keys_end_ = descriptor_end + head_.keys_size;
    if (keys_end_ > bytes_.size()) return cut("the list of keys");
    if (head_.level_offset != padded(keys_end_, level_alignment(format_, head_.packing == kZstd))) {
      return wrong("the texels do not follow the keys", 80);
    }
    if (head_.level_unpacked != texture_bytes(format_, head_.width, head_.height)) {
      return wrong(
          fmt::format("{} bytes of texels for {} x {} of them", head_.level_unpacked, head_.width, head_.height), 96);
    }
    if (head_.packing == kNone && head_.level_size != head_.level_unpacked) {
      return wrong("the size of the texels is not that of them unpacked, though they are not packed", 88);
    }
    if (head_.level_offset > bytes_.size() || head_.level_size > bytes_.size() - head_.level_offset) {
      return cut("the texels");
    }
    if (head_.level_offset + head_.level_size < bytes_.size()) {
      return wrong("bytes after the end of the texels", head_.level_offset + head_.level_size);
    }
    return ok_status();
  }

  [[nodiscard]] Error cut(std::string_view part) const {
    return wrong(fmt::format("truncated: {} would end behind the end of the file", part), bytes_.size());
  }

  Status check_descriptor() {
    const std::vector<std::byte> expected = ktx2_descriptor(format_);
    const auto found = bytes_.subspan(kHeadSize, head_.descriptor_size);
    const auto differ = std::mismatch(expected.begin(), expected.end(), found.begin(), found.end());
    if (differ.first == expected.end() && differ.second == found.end()) return ok_status();
    return other("the descriptor says something else about this format than is usual",
                 kHeadSize + static_cast<std::uint64_t>(differ.second - found.begin()));
  }

  Status check_keys() {
    ByteReader in(bytes_.first(keys_end_));
    in.bytes(keys_end_ - head_.keys_size);
    std::optional<std::string> before;
    while (in.remaining() > 0) {
      const std::uint64_t offset = in.offset();
      const std::string pair = in.text(in.u32());
      const std::string padding = in.text(padded(in.offset(), 4) - in.offset());
      if (!in.ok()) return wrong("a key is longer than the list of keys", offset);
      const std::size_t end = pair.find('\0');
      if (end == 0 || end == std::string::npos) return wrong("a key is empty or has no end", offset);
      if (padding.find_first_not_of('\0') != std::string::npos) return wrong("padding that is not zero", offset);
      std::string key = pair.substr(0, end);
      if (before && key <= *before) return wrong("the keys are not sorted, or one stands twice", offset);
      if (key == kOrientation && pair.substr(end + 1) != std::string(kFromTopLeft) + '\0') {
        return other("rows that do not go down or texels that do not go to the right", offset);
      }
      before = std::move(key);
    }
    return ok_status();
  }

  Status check_padding() {
    for (std::uint64_t k = keys_end_; k < head_.level_offset; ++k) {
      if (bytes_[k] != std::byte{0}) return wrong("padding that is not zero", k);
    }
    return ok_status();
  }

  Result<Texture> read_level(const MemoryLimit& limit) {
    const auto level = bytes_.subspan(head_.level_offset);
    Texture texture{format_, head_.width, head_.height, {}};
    const auto keep = [&](std::span<const std::byte> texels) {
      const auto* const first = reinterpret_cast<const std::uint8_t*>(texels.data());
      texture.bytes.assign(first, first + texels.size());
    };
    if (head_.packing == kNone) {
      keep(level);
      return texture;
    }
    const std::uint64_t most = limit.of(bytes_.size());
    if (head_.level_unpacked > most) {
      return other(
          fmt::format("{} bytes of texels in a file of {}; the limit is {}", head_.level_unpacked, bytes_.size(), most),
          96);
    }
    const std::optional<std::vector<std::byte>> unpacked = unpack_bytes(level, head_.level_unpacked);
    if (!unpacked) return wrong("the texels are not one zstd frame of their size", head_.level_offset);
    keep(*unpacked);
    return texture;
  }

  std::span<const std::byte> bytes_;
  ByteReader in_;
  Head head_;
  TexelFormat format_ = TexelFormat::kRgba32f;
  std::uint64_t keys_end_ = 0;
};

}  // namespace

Result<std::vector<std::byte>> write_ktx2(const Texture& texture, const Ktx2Options& options) {
  if (Status sound = check_texture(texture); !sound) return sound.error();
  const std::optional<Ktx2Format> format = ktx2_format_of(texture.format);
  if (!format) {
    return unsupported("KTX2 of three floats a texel, which graphics cards do not take; rgba32f has an alpha of 1");
  }
  const Result<std::vector<std::byte>> keys = emit_keys(options);
  if (!keys) return keys.error();
  const std::vector<std::byte> descriptor = ktx2_descriptor(texture.format);
  const auto plain = std::as_bytes(std::span(texture.bytes));
  const std::vector<std::byte> packed = options.zstd ? pack_bytes(plain, kZstdQuick) : std::vector<std::byte>();
  const auto level = options.zstd ? std::span<const std::byte>(packed) : plain;

  Head head;
  head.vk_format = format->vk_format;
  head.type_size = format->type_size;
  head.width = texture.width;
  head.height = texture.height;
  head.packing = options.zstd ? kZstd : kNone;
  head.level_unpacked = plain.size();
  return emit_file(head, descriptor, *keys, level, level_alignment(texture.format, options.zstd));
}

Result<std::vector<std::byte>> write_ktx2_cube(const CubeTexture& texture) {
  constexpr std::uint32_t kFaces = 6;
  const Ktx2CubeFormat format = ktx2_format_of(texture.texel);
  const std::uint64_t texels = std::uint64_t{kFaces} * texture.side * texture.side;
  if (texture.side == 0 || texture.side > kLongestTextureSide || texture.bytes.size() != texels * format.texel_bytes) {
    return usage_error(fmt::format("{} bytes for a cube map of {} texels of {} bytes", texture.bytes.size(), texels,
                                   format.texel_bytes));
  }
  const Result<std::vector<std::byte>> keys = emit_keys({});
  if (!keys) return keys.error();
  Head head;
  head.vk_format = format.vk_format;
  head.type_size = format.type_size;
  head.width = head.height = texture.side;
  head.faces = kFaces;
  head.level_unpacked = texture.bytes.size();
  return emit_file(head, ktx2_descriptor(texture.texel), *keys, std::as_bytes(std::span(texture.bytes)),
                   std::lcm<std::uint64_t>(format.texel_bytes, 4));
}

bool recognises_ktx2(std::span<const std::byte> head) {
  const auto identifier = std::as_bytes(std::span(kIdentifier));
  return head.size() >= identifier.size() && std::equal(identifier.begin(), identifier.end(), head.begin());
}

Result<Texture> read_ktx2(std::span<const std::byte> bytes, const MemoryLimit& limit) {
  return Reader(bytes).read(limit);
}

}  // namespace sbrdf::internal
