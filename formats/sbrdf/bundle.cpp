#include "formats/sbrdf/bundle.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/head_packing.h"

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kHeaderChecked =
    kBundleHeaderSize - kChecksumSize;  // the header's own checksum stands at its end
constexpr std::uint64_t kLeastEntrySize = 5;
constexpr unsigned kCountBits = 63;
constexpr std::uint64_t kMostDictionary = std::uint64_t{1} << 20U;
constexpr std::size_t kLongestName = 255;
constexpr std::size_t kNamesListed = 5;
constexpr std::size_t kNamesCompared = 4096;  // with more, finding the nearest takes too long

Error refuse(const char* clause, const std::string& what, std::optional<std::uint64_t> offset = {}) {
  return invalid_file(std::string("[") + clause + "] " + what, offset);
}

Error named(const std::string& name, Error error) {
  error.message = "material '" + name + "': " + error.message;
  return error;
}

/// The next code point of UTF-8 text, removed from it; nothing where it is none.
std::optional<std::uint32_t> take_code_point(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t size = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if ((first >= 0x80 && first < 0xC2) || first > 0xF4 || size > text.size()) return {};
  std::uint32_t point = size == 1 ? first : first & (0x7FU >> size);
  for (const char c : text.substr(1, size - 1)) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) != 0x80) return {};
    point = (point << 6U) | (byte & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  if (point < kLeast[size] || point > 0x10FFFF || (point >= 0xD800 && point < 0xE000)) return {};
  text.remove_prefix(size);
  return point;
}

/// Why a material may not have this name; nothing if it may.
std::optional<std::string> fault_of_name(std::string_view name) {
  if (name.empty()) return "an empty name";
  if (name.size() > kLongestName) return "a name of " + std::to_string(name.size()) + " bytes; 255 are the most";
  if (name == "." || name == "..") return "the name '" + std::string(name) + "'";
  while (!name.empty()) {
    const std::optional<std::uint32_t> point = take_code_point(name);
    if (!point) return "a name that is not UTF-8";
    if (*point == '/') return "a name with '/' in it";
    if (*point < 0x20 || (*point >= 0x7F && *point < 0xA0)) return "a name with a control character in it";
  }
  return {};
}

/// Insertions, removals and replacements of bytes that make one name of another.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t k = 0; k < b.size(); ++k) {
      const std::size_t replaced = diagonal + (a[i] == b[k] ? 0 : 1);
      diagonal = row[k + 1];
      row[k + 1] = std::min({replaced, row[k] + 1, row[k + 1] + 1});
    }
  }
  return row.back();
}

/// "a, b, c", of few enough names to be read; the first ones where there is nothing to be near to.
std::string nearest_names(const std::vector<BundleEntry>& entries, std::string_view name) {
  std::vector<std::pair<std::size_t, std::string_view>> names;
  for (const BundleEntry& entry : entries) {
    const bool compared = entries.size() <= kNamesCompared && !name.empty() && name.size() <= kLongestName;
    names.emplace_back(compared ? distance(name, entry.name) : 0, entry.name);
  }
  const std::size_t count = std::min(kNamesListed, names.size());
  std::partial_sort(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count), names.end());
  std::string text;
  for (std::size_t k = 0; k < count; ++k) text.append(k == 0 ? "" : ", ").append(names[k].second);
  return text;
}

/// The first bytes of a `.sbrdf` file, from its head as a bundle has it.
Bytes front_of_file(std::span<const std::byte> head) {
  const auto version = [&](std::size_t k) { return static_cast<std::uint8_t>(head[k]); };
  return emit_head(head.subspan(2), version(0), version(1));
}

/// A file whose beginning is in memory and whose end is in the bundle.
class MaterialSource final : public ByteSource {
 public:
  MaterialSource(const ByteSource& bundle, Bytes front, const BundleEntry& entry)
      : bundle_(bundle),
        front_(std::move(front)),
        body_offset_(entry.offset + entry.stored_size + kChecksumSize),
        body_size_(entry.body_size),
        stored_size_(entry.bundled_size()) {}

  [[nodiscard]] std::uint64_t size() const override { return front_.size() + body_size_; }
  [[nodiscard]] std::uint64_t stored_size() const override { return stored_size_; }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    if (offset < front_.size()) {
      const auto part = std::span(front_).subspan(static_cast<std::size_t>(offset));
      const std::size_t count = std::min(part.size(), target.size());
      std::copy_n(part.begin(), count, target.begin());
      target = target.subspan(count);
      offset += count;
    }
    if (target.empty()) return ok_status();
    return bundle_.read(body_offset_ + (offset - front_.size()), target);
  }

 private:
  const ByteSource& bundle_;
  Bytes front_;
  std::uint64_t body_offset_;
  std::uint64_t body_size_;
  std::uint64_t stored_size_;
};

struct BundleHead {
  std::uint16_t minor = 0;
  std::string version;
  Bytes index;
};

Result<BundleHead> read_bundle_head(const ByteSource& source) {
  const Result<Bytes> header = read_range(source, 0, std::min<std::uint64_t>(kBundleHeaderSize, source.size()));
  if (!header) return header.error();
  if (!is_bundle(*header)) return refuse("SZ-1-1", "not a bundle of sliced BRDFs: wrong magic", 0);
  ByteReader in(*header);
  in.bytes(kBundleMagic.size());
  const std::uint16_t major = in.u16();
  const std::uint16_t minor = in.u16();
  const std::uint32_t index_size = in.u32();
  const std::uint64_t file_size = in.u64();
  const std::uint32_t index_checksum = in.u32();
  const std::uint32_t header_checksum = in.u32();
  if (!in.ok()) return refuse("SZ-1-4", "truncated: the header has 32 bytes", source.size());
  if (checksum(std::span(*header).first(kHeaderChecked)) != header_checksum) {
    return refuse("SZ-1-2", "the header is damaged: its checksum does not match", kHeaderChecked);
  }
  const std::string version = std::to_string(major) + "." + std::to_string(minor);
  if (major > kBundleMajor || major == 0) {
    return unsupported("[SZ-1-3] version " + version + "; this program reads version 1 bundles", 8);
  }
  if (file_size != source.size()) {
    return refuse(
        "SZ-1-4",
        "the file has " + std::to_string(source.size()) + " bytes, its header says " + std::to_string(file_size), 16);
  }
  if (index_size > kMaxBundleIndexSize || index_size > file_size - kBundleHeaderSize) {
    return refuse("SZ-1-5", "an index of " + std::to_string(index_size) + " bytes does not fit", 12);
  }
  Result<Bytes> index = read_range(source, kBundleHeaderSize, index_size);
  if (!index) return index.error();
  if (checksum(*index) != index_checksum) {
    return refuse("SZ-1-6", "the index is damaged: its checksum does not match", kBundleHeaderSize);
  }
  return BundleHead{minor, version, *std::move(index)};
}

/// The sizes of one material. Those that are out of range become such that check_sizes refuses them.
void take_sizes(ByteReader& in, BundleEntry& entry) {
  const auto narrow = [](std::uint64_t value) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(value, UINT32_MAX));
  };
  entry.index_size = narrow(in.count(kCountBits));
  entry.stored_size = narrow(in.count(kCountBits));
  entry.body_size = in.count(kCountBits);
}

Status check_sizes(const BundleEntry& entry) {
  if (entry.index_size > kMaxIndexSize) {
    return refuse("SZ-2-5", "an index of " + std::to_string(entry.index_size) + " bytes");
  }
  const std::uint64_t head_size = entry.head_size();
  if (entry.stored_size > head_size || entry.stored_size < least_stored_size(head_size)) {
    return refuse("SZ-2-6",
                  "a head of " + std::to_string(head_size) + " bytes stored in " + std::to_string(entry.stored_size));
  }
  return ok_status();
}

}  // namespace

/// Read when it is first needed.
struct BundleReader::Dictionary {
  std::mutex mutex;
  std::optional<Bytes> bytes;
};

bool is_bundle(std::span<const std::byte> bytes) {
  return bytes.size() >= kBundleMagic.size() &&
         std::memcmp(bytes.data(), kBundleMagic.data(), kBundleMagic.size()) == 0;
}

std::uint64_t BundleEntry::file_size() const { return head_size_of(index_size) + body_size; }

std::uint64_t BundleEntry::bundled_size() const { return stored_size + kChecksumSize + body_size; }

BundleReader::BundleReader(const ByteSource& source, std::uint64_t index_size, const MemoryLimit& limit)
    : source_(&source), limit_(limit), index_size_(index_size), dictionary_(std::make_unique<Dictionary>()) {}
BundleReader::BundleReader(BundleReader&&) noexcept = default;
BundleReader& BundleReader::operator=(BundleReader&&) noexcept = default;
BundleReader::~BundleReader() = default;

Result<BundleReader> BundleReader::open(const ByteSource& source, const MemoryLimit& limit) {
  const Result<BundleHead> head = read_bundle_head(source);
  if (!head) return head.error();
  const bool newer_minor = head->minor > kBundleMinor;
  BundleReader reader(source, head->index.size(), limit);
  reader.version_ = head->version;
  if (Status parsed = reader.parse_index(head->index, newer_minor); !parsed) return parsed.error();
  if (Status placed = reader.place_materials(newer_minor); !placed) return placed.error();
  return reader;
}

Status BundleReader::parse_index(std::span<const std::byte> index, bool newer_minor) {
  ByteReader in(index);
  const std::uint64_t count = in.count(kCountBits);
  dictionary_size_ = in.count(kCountBits);
  if (in.ok() && (count == 0 || count > kMostMaterials || count > index.size() / kLeastEntrySize)) {
    return refuse("SZ-2-2",
                  std::to_string(count) + " materials in an index of " + std::to_string(index.size()) + " bytes");
  }
  if (dictionary_size_ > kMostDictionary) {
    return refuse("SZ-3-1", "a dictionary of " + std::to_string(dictionary_size_) + " bytes");
  }
  for (std::uint64_t k = 0; k < count && in.ok(); ++k) {
    BundleEntry entry;
    entry.name = in.text(in.count(kCountBits));
    take_sizes(in, entry);
    if (!in.ok()) break;
    if (const auto fault = fault_of_name(entry.name))
      return refuse("SZ-2-3", "material " + std::to_string(k) + " has " + *fault);
    if (Status sizes = check_sizes(entry); !sizes) return named(entry.name, sizes.error());
    if (!entries_.empty() && entries_.back().name >= entry.name) {
      return refuse("SZ-2-4", "the name '" + entry.name + "' behind '" + entries_.back().name + "'");
    }
    entries_.push_back(std::move(entry));
  }
  if (!in.ok()) return refuse("SZ-2-1", "the index is cut off, or a count in it is not written as it must be");
  if (in.remaining() != 0 && !newer_minor) {
    return refuse("SZ-2-1", std::to_string(in.remaining()) + " bytes behind the end of the index");
  }
  return ok_status();
}

Status BundleReader::place_materials(bool newer_minor) {
  std::uint64_t offset = kBundleHeaderSize + index_size_;
  // Never a sum that could wrap.
  const auto pass = [&](std::uint64_t size) {
    const bool fits = size <= source_->size() - offset;
    if (fits) offset += size;
    return fits;
  };
  bool fits = dictionary_size_ == 0 || pass(dictionary_size_ + kChecksumSize);
  for (BundleEntry& entry : entries_) {
    entry.offset = offset;
    fits = fits && pass(entry.stored_size + kChecksumSize) && pass(entry.body_size);
  }
  if (!fits || (offset != source_->size() && !newer_minor)) {
    return refuse("SZ-2-7", "dictionary and materials do not end where the file of " + std::to_string(source_->size()) +
                                " bytes ends");
  }
  const bool compressed =
      std::any_of(entries_.begin(), entries_.end(), [](const BundleEntry& entry) { return entry.is_compressed(); });
  if (dictionary_size_ != 0 && !compressed) return refuse("SZ-3-3", "a dictionary that no head is compressed with");
  return ok_status();
}

Result<const BundleEntry*> BundleReader::find(std::string_view name) const {
  const auto found =
      std::lower_bound(entries_.begin(), entries_.end(), name,
                       [](const BundleEntry& entry, std::string_view wanted) { return entry.name < wanted; });
  if (found != entries_.end() && found->name == name) return &*found;
  const std::string names = nearest_names(entries_, name);
  const std::string count = std::to_string(entries_.size());
  return usage_error((name.empty() ? "a bundle of " + count + " materials; say which behind a ':'"
                                   : "no material '" + std::string(name) + "' among the " + count + " of this bundle") +
                     (entries_.size() <= kNamesListed ? ": " : ", such as ") + names);
}

Result<std::span<const std::byte>> BundleReader::dictionary() const {
  if (dictionary_size_ == 0) return std::span<const std::byte>();
  const std::scoped_lock lock(dictionary_->mutex);
  if (!dictionary_->bytes) {
    const std::uint64_t offset = kBundleHeaderSize + index_size_;
    Result<Bytes> bytes = read_range(*source_, offset, dictionary_size_ + kChecksumSize);
    if (!bytes) return bytes.error();
    const auto content = std::span(*bytes).first(static_cast<std::size_t>(dictionary_size_));
    ByteReader end(std::span<const std::byte>(*bytes).subspan(content.size()));
    if (checksum(content) != end.u32()) {
      return refuse("SZ-3-2", "the dictionary is damaged: its checksum does not match", offset);
    }
    bytes->resize(content.size());
    dictionary_->bytes = *std::move(bytes);
  }
  return std::span<const std::byte>(*dictionary_->bytes);
}

Result<std::vector<std::byte>> BundleReader::head(const BundleEntry& entry) const {
  constexpr double kCopies = 6;  // packed, unpacked, at the front of the file, in the memory of who reads that
  const double needed = kCopies * static_cast<double>(entry.head_size());
  if (Status enough = check_memory(needed, limit_.of(entry.bundled_size())); !enough) return enough.error();
  Result<Bytes> bytes = read_range(*source_, entry.offset, entry.stored_size + kChecksumSize);
  if (!bytes) return bytes.error();
  const auto stored = std::span(*bytes).first(entry.stored_size);
  ByteReader end(std::span<const std::byte>(*bytes).subspan(stored.size()));
  if (checksum(stored) != end.u32()) {
    return refuse("SZ-4-1", "the head is damaged: its checksum does not match", entry.offset);
  }
  if (!entry.is_compressed()) {
    bytes->resize(stored.size());
    return bytes;
  }
  const Result<std::span<const std::byte>> shared = dictionary();
  if (!shared) return shared.error();
  std::optional<Bytes> unpacked = unpack_head(stored, static_cast<std::size_t>(entry.head_size()), *shared);
  if (!unpacked) return refuse("SZ-4-2", "the head does not decompress to the size in the index", entry.offset);
  return *std::move(unpacked);
}

Result<std::unique_ptr<ByteSource>> BundleReader::material(const BundleEntry& entry) const {
  const Result<Bytes> unpacked = head(entry);
  if (!unpacked) return named(entry.name, unpacked.error());
  return std::unique_ptr<ByteSource>(std::make_unique<MaterialSource>(*source_, front_of_file(*unpacked), entry));
}

Result<std::unique_ptr<ByteSource>> BundleReader::material(std::string_view name) const {
  const Result<const BundleEntry*> entry = find(name);
  if (!entry) return entry.error();
  return material(**entry);
}

Status check_material_name(std::string_view name) {
  if (const auto fault = fault_of_name(name)) return usage_error("a material cannot have " + *fault);
  return ok_status();
}

}  // namespace sbrdf::internal
