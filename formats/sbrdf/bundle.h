#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

// Many sliced BRDF files in one, specs/sbrdfz.md. What their chunks hold is of no concern here.

inline constexpr std::array<std::uint8_t, 8> kBundleMagic = {0x89, 'S', 'B', 'R', 'D', 'Z', 0x0D, 0x0A};
inline constexpr std::uint16_t kBundleMajor = 1;
inline constexpr std::uint16_t kBundleMinor = 0;
inline constexpr std::size_t kBundleHeaderSize = 32;
inline constexpr std::uint32_t kMaxBundleIndexSize = 1U << 24U;
inline constexpr std::uint64_t kMostMaterials = std::uint64_t{1} << 20U;

/// True when the magic is there, whatever follows.
[[nodiscard]] bool is_bundle(std::span<const std::byte> bytes);

/// One material of a bundle. Sizes in bytes.
struct BundleEntry {
  std::string name;
  std::uint32_t index_size = 0;   ///< of the file's index
  std::uint32_t stored_size = 0;  ///< of the head in the bundle, without its checksum
  std::uint64_t body_size = 0;
  std::uint64_t offset = 0;  ///< in the bundle, of the head; checksum and body follow

  /// Of the head once decompressed: major, minor and index.
  [[nodiscard]] std::uint64_t head_size() const { return std::uint64_t{2} + index_size; }
  [[nodiscard]] bool is_compressed() const { return stored_size < head_size(); }
  /// Of the `.sbrdf` file.
  [[nodiscard]] std::uint64_t file_size() const;
  /// Of all that the bundle holds for this material alone, its entry in the index left out.
  [[nodiscard]] std::uint64_t bundled_size() const;
};

/// Finds materials in a bundle: `open` reads header and index, `material` the dictionary, once, and one head.
/// Immutable; all members may be called from several threads at once.
class BundleReader {
 public:
  /// `source` must live as long as the reader and the materials. `limit` is for each material by itself. Refuses,
  /// before it allocates what they ask for, sizes that do not fit the file. kUnsupported for a newer major version
  /// [SZ-1-3]; kInvalidFile for what breaks another rule of sections 1 and 2.
  [[nodiscard]] static Result<BundleReader> open(const ByteSource& source, const MemoryLimit& limit = {});

  BundleReader(BundleReader&&) noexcept;
  BundleReader& operator=(BundleReader&&) noexcept;
  ~BundleReader();

  /// Rising by name.
  [[nodiscard]] const std::vector<BundleEntry>& entries() const { return entries_; }
  [[nodiscard]] const std::string& version() const { return version_; }
  [[nodiscard]] std::uint64_t index_size() const { return index_size_; }
  /// 0 where there is none.
  [[nodiscard]] std::uint64_t dictionary_size() const { return dictionary_size_; }

  /// kUsage, with the names nearest to it, where there is no such material.
  [[nodiscard]] Result<const BundleEntry*> find(std::string_view name) const;

  /// The `.sbrdf` file as it was: its beginning in memory, the body in the bundle. The reader may go before it.
  /// kInvalidFile where head or dictionary are damaged [SZ-3-2], [SZ-4-1], [SZ-4-2]; kUnsupported where the head would
  /// unpack to more than the limit allows for what the bundle stores of the material. Whether the file itself is a
  /// valid one is for its reader to say.
  [[nodiscard]] Result<std::unique_ptr<ByteSource>> material(std::string_view name) const;
  [[nodiscard]] Result<std::unique_ptr<ByteSource>> material(const BundleEntry& entry) const;

 private:
  struct Dictionary;
  BundleReader(const ByteSource& source, std::uint64_t index_size, const MemoryLimit& limit);
  [[nodiscard]] Status parse_index(std::span<const std::byte> index, bool newer_minor);
  [[nodiscard]] Status place_materials(bool newer_minor);
  [[nodiscard]] Result<std::span<const std::byte>> dictionary() const;
  [[nodiscard]] Result<std::vector<std::byte>> head(const BundleEntry& entry) const;

  const ByteSource* source_;
  MemoryLimit limit_;
  std::string version_;
  std::uint64_t index_size_;
  std::uint64_t dictionary_size_ = 0;
  std::vector<BundleEntry> entries_;
  std::unique_ptr<Dictionary> dictionary_;
};

/// What goes into a bundle. `file` is a whole `.sbrdf` file.
struct BundleInput {
  std::string name;
  std::span<const std::byte> file;
};

/// Whether a material may have this name [SZ-2-3]: kUsage, with the reason, otherwise.
[[nodiscard]] Status check_material_name(std::string_view name);

/// The bytes of a bundle, whatever the order of the inputs. kUsage without inputs, for a name that may not be or is
/// there twice; kInvalidFile where the head of a file is damaged; kUnsupported for what a bundle
/// has no room for. Messages name the material.
[[nodiscard]] Result<std::vector<std::byte>> emit_bundle(std::span<const BundleInput> inputs);

}  // namespace sbrdf::internal
