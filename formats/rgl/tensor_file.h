#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Type of the elements of a field; the numbers are those on disk.
enum class TensorType : std::uint8_t { kU8 = 1, kI8, kU16, kI16, kU32, kI32, kU64, kI64, kF16, kF32, kF64 };

/// Bytes of one element.
[[nodiscard]] std::size_t tensor_type_size(TensorType type);
/// As in the specification: "u8", "f32".
[[nodiscard]] std::string_view tensor_type_name(TensorType type);

/// More fields or dimensions than these are refused: published files have 11 fields and 5 dimensions.
inline constexpr std::uint32_t kTensorMaxFieldCount = 1024;
inline constexpr std::uint16_t kTensorMaxDimensionCount = 16;

/// One named array. `name` and `bytes` are views into the parsed file.
struct TensorField {
  std::string_view name;  ///< any bytes but not empty: show it through printable_text
  TensorType type = TensorType::kU8;
  std::vector<std::uint64_t> shape;  ///< slowest axis first; empty for a single element; a zero makes the field empty
  std::span<const std::byte>
      bytes;                 ///< the elements, last axis fastest, exactly as many as `shape` asks for; not aligned
  std::uint64_t offset = 0;  ///< of `bytes` in the file
  std::uint64_t entry_offset = 0;  ///< of the field's entry in the header
};

/// All fields of a file, in the order of its header. Owns no bytes: valid as long as those that were parsed.
struct TensorFile {
  std::vector<TensorField> fields;

  /// The field of that name, or nullptr.
  [[nodiscard]] const TensorField* find(std::string_view name) const;
};

/// The bytes begin with the magic of a tensor file.
[[nodiscard]] bool is_tensor_file(std::span<const std::byte> bytes);

/// Reads the header of a tensor file (specs/rgl.md, section 1) and finds the elements of every field. Copies no
/// elements and allocates nothing for sizes that the file merely claims. The elements themselves are not judged.
/// kInvalidFile: wrong magic, a header that is cut off, unknown element type, empty or repeated name, a field whose
/// elements are not wholly between the header and the end of the file. kUnsupported: a version other than 1.0, more
/// fields or dimensions than the limits above. Messages name the field.
Result<TensorFile> parse_tensor_file(std::span<const std::byte> bytes);

/// A field to be written. The caller keeps the bytes, exactly as many as type and shape ask for.
struct TensorOutput {
  std::string_view name;
  TensorType type = TensorType::kU8;
  std::vector<std::uint64_t> shape;
  std::span<const std::byte> bytes;
};

/// Where the elements of each field begin in a file of these fields, in their order, and last the size of the file.
/// Every field begins at a multiple of kTensorAlignment, as in published files: readers that map a file rely on it.
inline constexpr std::uint64_t kTensorAlignment = 8;
[[nodiscard]] std::vector<std::uint64_t> tensor_offsets(std::span<const TensorOutput> fields);

/// A whole file of version 1.0. Names are unique and not empty; there are no more fields and dimensions than the
/// limits.
[[nodiscard]] std::vector<std::byte> emit_tensor_file(std::span<const TensorOutput> fields);

/// `text` on one line of ASCII: other bytes become '?', and what exceeds `max_size` becomes "...".
[[nodiscard]] std::string printable_text(std::string_view text, std::size_t max_size);

}  // namespace sbrdf::internal
