#include "formats/rgl/tensor_file.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kMagic = "tensor_file\0"sv;
constexpr std::size_t kVersionOffset = kMagic.size();
constexpr std::size_t kFieldCountOffset = kVersionOffset + 2;
constexpr std::size_t kShownNameSize = 40;

struct TypeRow {
  std::string_view name;
  std::size_t size;
};
constexpr std::array<TypeRow, 12> kTypes = {{{"invalid", 0},
                                             {"u8", 1},
                                             {"i8", 1},
                                             {"u16", 2},
                                             {"i16", 2},
                                             {"u32", 4},
                                             {"i32", 4},
                                             {"u64", 8},
                                             {"i64", 8},
                                             {"f16", 2},
                                             {"f32", 4},
                                             {"f64", 8}}};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string label(std::uint32_t index, std::string_view name) {
  std::string text = "field " + std::to_string(index);
  if (!name.empty()) text += " \"" + printable_text(name, kShownNameSize) + "\"";
  return text + ": ";
}

Error truncated(const ByteReader& in, const std::string& where) {
  Error error = in.error();
  error.message = where + error.message;
  return error;
}

/// Bytes of all elements. Each extent is held against what is left of the file, since the product of hostile extents
/// can wrap to a size that fits.
Result<std::uint64_t> field_size(const TensorField& field, std::uint64_t file_size, std::uint64_t shape_offset,
                                 const std::string& where) {
  if (std::ranges::find(field.shape, std::uint64_t{0}) != field.shape.end()) return std::uint64_t{0};
  const std::uint64_t element_size = tensor_type_size(field.type);
  const std::uint64_t available_count = (file_size - field.offset) / element_size;
  std::uint64_t count = 1;
  for (std::size_t axis = 0; axis < field.shape.size(); ++axis) {
    if (field.shape[axis] > available_count / count) {
      return invalid_file(where + "shape[" + std::to_string(axis) + "] = " + std::to_string(field.shape[axis]) +
                              " asks for more than the " + std::to_string(file_size - field.offset) +
                              " bytes between the field's offset and the end of the file",
                          shape_offset + axis * sizeof(std::uint64_t));
    }
    count *= field.shape[axis];
  }
  if (count > available_count)
    return invalid_file(where + "its element lies beyond the end of the file", field.entry_offset);
  return count * element_size;
}

/// One entry of the header. `bytes` stays empty where the field is.
Result<TensorField> parse_field(ByteReader& in, std::span<const std::byte> file, std::uint32_t index) {
  TensorField field;
  field.entry_offset = in.offset();
  const std::uint16_t name_size = in.u16();
  field.name = text_of(in.bytes(name_size));
  const std::string where = label(index, field.name);
  const std::size_t dimension_offset = in.offset();
  const std::uint16_t dimension_count = in.u16();
  const std::uint8_t type = in.u8();
  const std::size_t offset_offset = in.offset();
  field.offset = in.u64();
  if (!in.ok()) return truncated(in, where);

  if (name_size == 0) return invalid_file(where + "has no name", field.entry_offset);
  if (dimension_count > kTensorMaxDimensionCount) {
    return unsupported(where + "has " + std::to_string(dimension_count) + " dimensions, the limit is " +
                           std::to_string(kTensorMaxDimensionCount),
                       dimension_offset);
  }
  if (type == 0 || type >= kTypes.size()) {
    return invalid_file(where + "unknown element type " + std::to_string(type), dimension_offset + 2);
  }
  field.type = static_cast<TensorType>(type);
  if (field.offset > file.size()) {
    return invalid_file(where + "its offset " + std::to_string(field.offset) + " is beyond the end of the file",
                        offset_offset);
  }

  const std::size_t shape_offset = in.offset();
  field.shape.resize(dimension_count);
  for (std::uint64_t& extent : field.shape) extent = in.u64();
  if (!in.ok()) return truncated(in, where);
  const Result<std::uint64_t> size = field_size(field, file.size(), shape_offset, where);
  if (!size) return size.error();
  field.bytes = file.subspan(static_cast<std::size_t>(field.offset), static_cast<std::size_t>(*size));
  return field;
}

/// What can be checked only once the whole header is known.
Status check_placement(const TensorFile& tensors, std::size_t header_size) {
  for (std::size_t index = 0; index < tensors.fields.size(); ++index) {
    const TensorField& field = tensors.fields[index];
    if (field.offset >= header_size || field.bytes.empty()) continue;
    return invalid_file(label(static_cast<std::uint32_t>(index), field.name) + "its offset " +
                            std::to_string(field.offset) + " is inside the header, which ends at " +
                            std::to_string(header_size),
                        field.entry_offset);
  }
  return ok_status();
}

/// Magic, version and the count of fields.
Result<std::uint32_t> parse_prologue(ByteReader& in) {
  if (text_of(in.bytes(kMagic.size())) != kMagic) return invalid_file("not a tensor file: the magic is missing", 0);
  const int major = in.u8();
  const int minor = in.u8();
  const std::uint32_t field_count = in.u32();
  if (!in.ok()) return truncated(in, "tensor file header: ");
  if (major != 1 || minor != 0) {
    return unsupported(
        "tensor file version " + std::to_string(major) + "." + std::to_string(minor) + ", only 1.0 is known",
        kVersionOffset);
  }
  if (field_count > kTensorMaxFieldCount) {
    return unsupported("tensor file with " + std::to_string(field_count) + " fields, the limit is " +
                           std::to_string(kTensorMaxFieldCount),
                       kFieldCountOffset);
  }
  return field_count;
}

}  // namespace

std::size_t tensor_type_size(TensorType type) { return kTypes[static_cast<std::size_t>(type)].size; }
std::string_view tensor_type_name(TensorType type) { return kTypes[static_cast<std::size_t>(type)].name; }

const TensorField* TensorFile::find(std::string_view name) const {
  const auto found = std::ranges::find(fields, name, &TensorField::name);
  return found == fields.end() ? nullptr : &*found;
}

bool is_tensor_file(std::span<const std::byte> bytes) {
  return bytes.size() >= kMagic.size() && text_of(bytes.first(kMagic.size())) == kMagic;
}

Result<TensorFile> parse_tensor_file(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const Result<std::uint32_t> field_count = parse_prologue(in);
  if (!field_count) return field_count.error();
  TensorFile tensors;
  for (std::uint32_t index = 0; index < *field_count; ++index) {
    Result<TensorField> field = parse_field(in, bytes, index);
    if (!field) return field.error();
    if (tensors.find(field->name) != nullptr) {
      return invalid_file(label(index, field->name) + "the name was used before", field->entry_offset);
    }
    tensors.fields.push_back(std::move(field).value());
  }
  const Status placed = check_placement(tensors, in.offset());
  if (!placed) return placed.error();
  return tensors;
}

std::vector<std::uint64_t> tensor_offsets(std::span<const TensorOutput> fields) {
  const auto aligned = [](std::uint64_t at) {
    return (at + kTensorAlignment - 1) / kTensorAlignment * kTensorAlignment;
  };
  std::uint64_t at = kMagic.size() + 2 + sizeof(std::uint32_t);
  for (const TensorOutput& field : fields) {
    at += sizeof(std::uint16_t) + field.name.size() + sizeof(std::uint16_t) + 1 + sizeof(std::uint64_t) +
          sizeof(std::uint64_t) * field.shape.size();
  }
  std::vector<std::uint64_t> offsets;
  for (const TensorOutput& field : fields) {
    offsets.push_back(aligned(at));
    at = offsets.back() + field.bytes.size();
  }
  offsets.push_back(at);
  return offsets;
}

std::vector<std::byte> emit_tensor_file(std::span<const TensorOutput> fields) {
  const std::vector<std::uint64_t> offsets = tensor_offsets(fields);
  ByteWriter out;
  out.text(kMagic);
  out.number(std::uint8_t{1});
  out.number(std::uint8_t{0});
  out.number(static_cast<std::uint32_t>(fields.size()));
  for (std::size_t k = 0; k < fields.size(); ++k) {
    out.number(static_cast<std::uint16_t>(fields[k].name.size()));
    out.text(fields[k].name);
    out.number(static_cast<std::uint16_t>(fields[k].shape.size()));
    out.number(static_cast<std::uint8_t>(fields[k].type));
    out.number(offsets[k]);
    for (const std::uint64_t extent : fields[k].shape) out.number(extent);
  }
  for (std::size_t k = 0; k < fields.size(); ++k) {
    while (out.size() < offsets[k]) out.number(std::uint8_t{0});
    out.bytes(fields[k].bytes);
  }
  return std::move(out).take();
}

std::string printable_text(std::string_view text, std::size_t max_size) {
  std::string shown(text.substr(0, max_size));
  std::ranges::replace_if(
      shown, [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  if (text.size() > max_size) shown += "...";
  return shown;
}

}  // namespace sbrdf::internal
