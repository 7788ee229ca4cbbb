#include "formats/table/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kTiled = 0x200;
constexpr std::uint32_t kLongNames = 0x400;
constexpr std::uint32_t kDeep = 0x800;
constexpr std::uint32_t kMultiPart = 0x1000;
constexpr std::size_t kLongestName = 255;
constexpr std::size_t kMostChannels = 4096;
/// An attribute that an image has to have, once, and what its value is.
struct Needed {
  std::string_view name;
  std::string_view type;
  std::size_t size;  ///< of the value [bytes]; 0 where it varies
};
constexpr std::array kNeeded = {Needed{"channels", "chlist", 0},        Needed{"compression", "compression", 1},
                                Needed{"dataWindow", "box2i", 16},      Needed{"displayWindow", "box2i", 16},
                                Needed{"lineOrder", "lineOrder", 1},    Needed{"pixelAspectRatio", "float", 4},
                                Needed{"screenWindowCenter", "v2f", 8}, Needed{"screenWindowWidth", "float", 4}};

/// Rows that are packed together, of each compression that is read: none, RLE, ZIPS, ZIP, PIZ, PXR24.
constexpr std::array<std::uint64_t, 6> kRowsOfBlock = {1, 1, 1, 16, 32, 16};

Error wrong(std::string_view what, std::uint64_t offset) {
  return invalid_file(fmt::format("OpenEXR header: {}", what), offset);
}

class HeaderWalker {
 public:
  HeaderWalker(std::span<const std::byte> start, std::uint64_t file_size, std::string_view attribute)
      : in_(start), start_(start), file_size_(file_size), attribute_(attribute) {}

  Result<ParsedExrHeader> walk() {
    if (Status known = check_version(); !known) return known.error();
    while (true) {
      const std::uint64_t offset = in_.offset();
      const std::string name = text();
      if (!in_.ok()) return cut();
      if (name.empty()) break;
      if (name.size() > kLongestName) return wrong("an attribute with a name of more than 255 bytes", offset);
      if (Status taken = take_attribute(name); !taken) return taken.error();
    }
    for (const Needed& needed : kNeeded) {
      if (!seen_.contains(std::string(needed.name))) {
        return wrong(fmt::format("\"{}\" is missing", needed.name), in_.offset());
      }
    }
    if (Status fits = check_blocks(); !fits) return fits.error();
    const auto header = start_.first(in_.offset());
    parsed_.plain.assign(header.begin(), header.end());
    for (const std::size_t offset : to_hide_) parsed_.plain[offset] = std::byte{'?'};
    return std::move(parsed_);
  }

 private:
  [[nodiscard]] Error cut() const {
    if (start_.size() < file_size_) {
      return unsupported(fmt::format("an OpenEXR header of more than {} bytes", kExrLongestHeader), in_.offset());
    }
    return wrong("truncated", in_.offset());
  }

  // Up to the next zero.
  std::string text() {
    const auto rest = start_.subspan(in_.offset());
    const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
    std::string result = in_.text(static_cast<std::uint64_t>(end - rest.begin()));
    in_.u8();
    return result;
  }

  Status check_version() {
    const std::uint32_t magic = in_.u32();
    const std::uint32_t version = in_.u32();
    if (!in_.ok()) return in_.error();
    if (magic != kMagic) return wrong("the file does not begin as one", 0);
    if ((version & 0xFFU) != kVersion) {
      return unsupported(fmt::format("OpenEXR version {}; only version 2 is read", version & 0xFFU), 4);
    }
    const std::array<std::pair<std::uint32_t, const char*>, 3> kinds = {
        {{kMultiPart, "of several parts"}, {kDeep, "of deep pixels"}, {kTiled, "in tiles"}}};
    for (const auto& [flag, name] : kinds) {
      if ((version & flag) != 0) {
        return unsupported(fmt::format("an OpenEXR image {}; those of one part in scan lines are read", name), 4);
      }
    }
    if ((version & ~(0xFFU | kLongNames)) != 0) return unsupported("an OpenEXR image of a kind that is not known", 4);
    return ok_status();
  }

  Status take_attribute(const std::string& name) {
    const std::size_t type_offset = in_.offset();
    const std::string type = text();
    const std::int32_t size = in_.i32();
    const std::size_t offset = in_.offset();
    if (!in_.ok() || size < 0 || static_cast<std::uint64_t>(size) > in_.remaining()) {
      return size < 0 ? wrong(fmt::format("\"{}\" has a negative size", name), type_offset) : cut();
    }
    if (type.empty()) return wrong("an attribute without a type", type_offset);
    const std::span<const std::byte> value = in_.bytes(static_cast<std::uint64_t>(size));
    if (!seen_.insert(name).second) return wrong("an attribute stands twice", type_offset);
    const auto* const needed =
        std::find_if(kNeeded.begin(), kNeeded.end(), [&](const Needed& known) { return known.name == name; });
    if (needed == kNeeded.end()) {
      to_hide_.push_back(type_offset);
      if (name == attribute_ && type == "string") {
        parsed_.header.text.assign(reinterpret_cast<const char*>(value.data()), value.size());
      }
      return ok_status();
    }
    // The library takes as many bytes as the type has, and goes on from there.
    if (type != needed->type || (needed->size != 0 && value.size() != needed->size)) {
      return wrong(fmt::format("\"{}\" has another type or size", name), type_offset);
    }
    if (name == "channels") return take_channels(value, offset);
    if (name == "compression") return take_compression(value, offset);
    if (name == "dataWindow") return take_window(value, offset);
    return ok_status();
  }

  Status take_channels(std::span<const std::byte> value, std::size_t offset) {
    ByteReader in(value);
    while (true) {
      const auto rest = value.subspan(in.offset());
      const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
      const std::string name = in.text(static_cast<std::uint64_t>(end - rest.begin()));
      in.u8();
      if (!in.ok()) return wrong("the list of channels is cut off", offset);
      if (name.empty()) break;
      const std::int32_t type = in.i32();
      in.u32();  // whether values are perceived linearly, and three bytes that are not used
      const std::int32_t x_step = in.i32();
      const std::int32_t y_step = in.i32();
      if (!in.ok()) return wrong("the list of channels is cut off", offset);
      if (name.size() > kLongestName) return wrong("a channel with a name of more than 255 bytes", offset);
      if (type != 1 && type != 2) return unsupported("an OpenEXR image with a channel of whole numbers", offset);
      if (x_step != 1 || y_step != 1) {
        return unsupported("an OpenEXR image with a channel that has fewer pixels than others", offset);
      }
      if (parsed_.header.channels.size() == kMostChannels) return unsupported("more than 4096 channels", offset);
      const bool twice = std::any_of(parsed_.header.channels.begin(), parsed_.header.channels.end(),
                                     [&](const ExrChannel& other) { return other.name == name; });
      if (twice) return wrong("two channels have the same name", offset);
      parsed_.header.channels.push_back({name, type == 1});
    }
    if (parsed_.header.channels.empty()) return wrong("no channels", offset);
    if (in.remaining() > 0) return wrong("bytes after the list of channels", offset);
    return ok_status();
  }

  Status take_compression(std::span<const std::byte> value, std::size_t offset) {
    const auto kind = value.empty() ? std::size_t{255} : std::to_integer<std::size_t>(value.front());
    if (kind >= kRowsOfBlock.size()) {
      return unsupported("an OpenEXR image with B44, DWA or unknown compression, which changes values", offset);
    }
    rows_of_block_ = kRowsOfBlock[kind];
    return ok_status();
  }

  Status take_window(std::span<const std::byte> value, std::size_t offset) {
    ByteReader in(value);
    const std::array<std::int64_t, 4> window = {in.i32(), in.i32(), in.i32(), in.i32()};
    if (!in.ok()) return wrong("the data window is cut off", offset);
    const std::int64_t width = window[2] - window[0] + 1;
    const std::int64_t height = window[3] - window[1] + 1;
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
    const bool far = std::any_of(window.begin(), window.end(), [](std::int64_t v) { return std::abs(v) > kMost / 2; });
    if (width < 1 || height < 1 || far) return wrong("the data window is empty or too large", offset);
    parsed_.header.width = static_cast<std::uint32_t>(width);
    parsed_.header.height = static_cast<std::uint32_t>(height);
    return ok_status();
  }

  // For each block of rows the file says where it lies, and the block itself begins with its place and size.
  Status check_blocks() {
    const std::uint64_t blocks = (parsed_.header.height + rows_of_block_ - 1) / rows_of_block_;
    const std::uint64_t left = file_size_ - in_.offset();
    if (left / 17 < blocks) {
      return invalid_file(
          fmt::format("truncated OpenEXR file: {} rows cannot lie in {} bytes", parsed_.header.height, left),
          file_size_);
    }
    std::uint64_t pixel = 0;
    for (const ExrChannel& channel : parsed_.header.channels) pixel += channel.half ? 2 : 4;
    const std::uint64_t block = pixel * parsed_.header.width * rows_of_block_;
    if (block > std::numeric_limits<std::int32_t>::max())
      return unsupported("OpenEXR rows of too many bytes", in_.offset());
    parsed_.header.block_size = block;
    return ok_status();
  }

  ByteReader in_;
  std::span<const std::byte> start_;
  std::uint64_t file_size_;
  std::string attribute_;
  ParsedExrHeader parsed_;
  std::set<std::string> seen_;
  std::vector<std::size_t> to_hide_;
  std::uint64_t rows_of_block_ = 1;
};

}  // namespace

bool recognises_exr(std::span<const std::byte> head) {
  ByteReader in(head);
  return in.u32() == kMagic && in.ok();
}

Result<ParsedExrHeader> parse_exr_header(const ByteSource& bytes, std::string_view attribute) {
  const Result<std::vector<std::byte>> start = read_start(bytes, kExrLongestHeader);
  if (!start) return start.error();
  return HeaderWalker(*start, bytes.size(), attribute).walk();
}

}  // namespace sbrdf::internal
