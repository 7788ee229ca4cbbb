#include "formats/rgl/rgl_material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kDescriptionMaxSize = 200;
/// Files store pi/2 and pi as float, from either side.
constexpr double kAngleSlack = 1e-5;

/// What a field must have along one axis.
struct Extent {
  std::uint64_t count;
  bool or_more = false;
};
constexpr Extent kNodes = {2, true};

Error field_error(const TensorField& field, const std::string& message, std::uint64_t offset) {
  return invalid_file("field \"" + std::string(field.name) + "\": " + message, offset);
}

/// "[0, 3, 1]" for a position in the elements of `field`.
std::string index_text(const TensorField& field, std::size_t position) {
  std::string text = "]";
  for (std::size_t axis = field.shape.size(); axis-- > 0;) {
    const auto extent = static_cast<std::size_t>(field.shape[axis]);
    text.insert(0, (axis > 0 ? ", " : "") + std::to_string(position % extent));
    position /= extent;
  }
  return "[" + text;
}

Error value_error(const TensorField& field, std::size_t position, const std::string& message) {
  return field_error(field, "index " + index_text(field, position) + " " + message,
                     field.offset + position * tensor_type_size(field.type));
}

/// The field of that name, type and shape.
Result<const TensorField*> require(const TensorFile& tensors, std::string_view name, TensorType type,
                                   std::initializer_list<Extent> shape) {
  const TensorField* field = tensors.find(name);
  if (field == nullptr) return invalid_file("field \"" + std::string(name) + "\" is missing");
  if (field->type != type) {
    return field_error(
        *field,
        "is of type " + std::string(tensor_type_name(field->type)) + ", must be " + std::string(tensor_type_name(type)),
        field->entry_offset);
  }
  if (field->shape.size() != shape.size()) {
    return field_error(
        *field, "has " + std::to_string(field->shape.size()) + " dimensions, must have " + std::to_string(shape.size()),
        field->entry_offset);
  }
  std::size_t axis = 0;
  for (const Extent& extent : shape) {
    const std::uint64_t found = field->shape[axis];
    if (extent.or_more ? found < extent.count : found != extent.count) {
      return field_error(*field,
                         "shape[" + std::to_string(axis) + "] is " + std::to_string(found) + ", must be " +
                             (extent.or_more ? "at least " : "") + std::to_string(extent.count),
                         field->entry_offset);
    }
    ++axis;
  }
  return field;
}

/// Elements of an f32 field, each of them finite.
Result<std::vector<float>> copy_floats(const TensorField& field) {
  std::vector<float> values(field.bytes.size() / sizeof(float));
  std::memcpy(values.data(), field.bytes.data(), values.size() * sizeof(float));
  const auto bad = std::ranges::find_if_not(values, [](float value) { return std::isfinite(value); });
  if (bad != values.end()) {
    return value_error(field, static_cast<std::size_t>(bad - values.begin()), "is not a finite number");
  }
  return values;
}

Result<std::vector<float>> require_floats(const TensorFile& tensors, std::string_view name,
                                          std::initializer_list<Extent> shape) {
  const Result<const TensorField*> field = require(tensors, name, TensorType::kF32, shape);
  if (!field) return field.error();
  return copy_floats(**field);
}

RglGrid grid_of(const TensorField& field) {
  const std::size_t axis_count = field.shape.size();
  return {static_cast<std::size_t>(field.shape[axis_count - 1]), static_cast<std::size_t>(field.shape[axis_count - 2])};
}

/// The nodes of an axis.
Status read_rising(const TensorFile& tensors, std::string_view name, std::vector<float>& values) {
  Result<std::vector<float>> read = require_floats(tensors, name, {{1, true}});
  if (!read) return read.error();
  values = std::move(read).value();
  const auto fall = std::ranges::adjacent_find(values, std::ranges::greater_equal());
  if (fall == values.end()) return ok_status();
  return value_error(*tensors.find(name), static_cast<std::size_t>(fall - values.begin()) + 1,
                     "does not rise above the one before");
}

/// One angular axis: rising, within [low, high].
Status read_axis(const TensorFile& tensors, std::string_view name, double low, double high,
                 std::vector<float>& values) {
  if (Status read = read_rising(tensors, name, values); !read) return read;
  const auto outside = std::ranges::find_if(
      values, [&](float value) { return value < low - kAngleSlack || value > high + kAngleSlack; });
  if (outside == values.end()) return ok_status();
  return value_error(*tensors.find(name), static_cast<std::size_t>(outside - values.begin()),
                     "is " + std::to_string(*outside) + " radians, outside [" + std::to_string(low) + ", " +
                         std::to_string(high) + "]");
}

/// One table with its grid.
Status read_table(const TensorFile& tensors, std::string_view name, std::initializer_list<Extent> shape, RglGrid& grid,
                  std::vector<float>& values) {
  Result<std::vector<float>> read = require_floats(tensors, name, shape);
  if (!read) return read.error();
  values = std::move(read).value();
  grid = grid_of(*tensors.find(name));
  return ok_status();
}

std::string_view colour_name(const RglMaterial& material) { return material.spectral() ? "spectra" : "rgb"; }

/// Of a spectral file; nothing is read where there is a field "rgb".
Status read_wavelengths(const TensorFile& tensors, std::vector<float>& wavelengths) {
  if (tensors.find("rgb") != nullptr || tensors.find("spectra") == nullptr) return ok_status();
  if (Status read = read_rising(tensors, "wavelengths", wavelengths); !read) return read;
  const TensorField& field = *tensors.find("wavelengths");
  if (wavelengths.front() <= 0) return value_error(field, 0, "is not a positive length");
  if (wavelengths.size() <= kRglMaxWavelengthCount) return ok_status();
  return Error{ErrorCode::kUnsupported,
               "field \"wavelengths\": " + std::to_string(wavelengths.size()) + " wavelengths, the limit is " +
                   std::to_string(kRglMaxWavelengthCount),
               field.entry_offset};
}

Status read_tables(const TensorFile& tensors, RglMaterial& material) {
  const Extent phi_count = {material.phi_i.size()};
  const Extent theta_count = {material.theta_i.size()};
  Status status = read_table(tensors, "sigma", {kNodes, kNodes}, material.sigma_grid, material.sigma);
  if (!status) return status;
  status = read_table(tensors, "ndf", {kNodes, kNodes}, material.ndf_grid, material.ndf);
  if (!status) return status;
  status = read_table(tensors, "vndf", {phi_count, theta_count, kNodes, kNodes}, material.vndf_grid, material.vndf);
  if (!status) return status;
  return read_table(tensors, colour_name(material),
                    {phi_count, theta_count, {material.channel_count()}, kNodes, kNodes}, material.colour_grid,
                    material.colours);
}

Status check_density(const TensorField& field, const RglGrid& grid, const std::vector<float>& values) {
  const auto negative = std::ranges::find_if(values, [](float value) { return value < 0; });
  if (negative != values.end()) {
    return value_error(field, static_cast<std::size_t>(negative - values.begin()), "is a negative density");
  }
  const std::size_t cell_count = grid.cell_count();
  for (std::size_t start = 0; start < values.size(); start += cell_count) {
    const std::span<const float> slice(values.data() + start, cell_count);
    if (std::ranges::all_of(slice, [](float value) { return value == 0; })) {
      return value_error(field, start, "begins a slice that is all zero");
    }
  }
  return ok_status();
}

Status check_some_positive(const TensorField& field, const std::vector<float>& values) {
  const float largest = std::ranges::max(values);
  if (largest > 0) return ok_status();
  return field_error(field, largest == 0 ? "holds no value above zero" : "holds negative values only", field.offset);
}

Status check_tables(const TensorFile& tensors, const RglMaterial& material) {
  const auto flat = std::ranges::find_if(material.sigma, [](float value) { return value <= 0; });
  if (flat != material.sigma.end()) {
    return value_error(*tensors.find("sigma"), static_cast<std::size_t>(flat - material.sigma.begin()),
                       "is not a positive area");
  }
  Status status = check_density(*tensors.find("vndf"), material.vndf_grid, material.vndf);
  if (!status) return status;
  status = check_some_positive(*tensors.find("ndf"), material.ndf);
  if (!status) return status;
  return check_some_positive(*tensors.find(colour_name(material)), material.colours);
}

std::string read_description(const TensorFile& tensors) {
  const TensorField* field = tensors.find("description");
  if (field == nullptr || field->type != TensorType::kU8) return {};
  return printable_text({reinterpret_cast<const char*>(field->bytes.data()), field->bytes.size()}, kDescriptionMaxSize);
}

/// Another format in the same container: Mueller matrices M at half and difference angles (Baek et al., "Image-Based
/// Acquisition and Modeling of Polarimetric Reflectance", 2020).
std::optional<Error> polarised_error(const TensorFile& tensors) {
  const TensorField* matrices = tensors.find("M");
  if (tensors.find("phi_i") != nullptr || matrices == nullptr) return std::nullopt;
  return Error{
      ErrorCode::kUnsupported,
      R"(field "M": a polarised material (pBSDF, Mueller matrices); only unpolarised RGL materials can be read)",
      matrices->entry_offset};
}

std::uint64_t negative_count(const std::vector<float>& values) {
  return static_cast<std::uint64_t>(std::ranges::count_if(values, [](float value) { return value < 0; }));
}

}  // namespace

Result<RglMaterial> parse_rgl_material(const TensorFile& tensors) {
  if (std::optional<Error> error = polarised_error(tensors)) return *std::move(error);
  RglMaterial material;
  material.description = read_description(tensors);
  Status status = read_axis(tensors, "phi_i", -2 * kPi, 2 * kPi, material.phi_i);
  if (!status) return status.error();
  status = read_axis(tensors, "theta_i", 0, kPi / 2, material.theta_i);
  if (!status) return status.error();
  status = read_wavelengths(tensors, material.wavelengths);
  if (!status) return status.error();
  status = read_tables(tensors, material);
  if (!status) return status.error();
  const Result<const TensorField*> jacobian = require(tensors, "jacobian", TensorType::kU8, {{1}});
  if (!jacobian) return jacobian.error();
  material.jacobian = (*jacobian)->bytes[0] != std::byte{0};
  status = check_tables(tensors, material);
  if (!status) return status.error();
  material.negative_colour_count = negative_count(material.colours);
  material.negative_ndf_count = negative_count(material.ndf);
  return material;
}

std::vector<std::byte> emit_rgl_material(const RglMaterial& material, const RglSampling& sampling) {
  constexpr std::array<std::uint32_t, 2> kVersion = {1, 0};
  const std::uint8_t jacobian = material.jacobian ? 1 : 0;
  std::vector<TensorOutput> fields;
  const auto add = [&](std::string_view name, TensorType type, std::vector<std::uint64_t> shape, const auto& values) {
    fields.push_back({name, type, std::move(shape), std::as_bytes(std::span(values))});
  };
  const std::uint64_t phi_count = material.phi_i.size();
  const std::uint64_t theta_count = material.theta_i.size();
  const auto& [colour_x, colour_y] = material.colour_grid;
  add("version", TensorType::kU32, {2}, kVersion);
  add("description", TensorType::kU8, {material.description.size()}, material.description);
  add("phi_i", TensorType::kF32, {phi_count}, material.phi_i);
  add("theta_i", TensorType::kF32, {theta_count}, material.theta_i);
  add("sigma", TensorType::kF32, {material.sigma_grid.y_count, material.sigma_grid.x_count}, material.sigma);
  add("ndf", TensorType::kF32, {material.ndf_grid.y_count, material.ndf_grid.x_count}, material.ndf);
  add("vndf", TensorType::kF32, {phi_count, theta_count, material.vndf_grid.y_count, material.vndf_grid.x_count},
      material.vndf);
  add("luminance", TensorType::kF32, {phi_count, theta_count, colour_y, colour_x}, sampling.luminance);
  if (material.spectral()) add("wavelengths", TensorType::kF32, {material.wavelengths.size()}, material.wavelengths);
  add(colour_name(material), TensorType::kF32, {phi_count, theta_count, material.channel_count(), colour_y, colour_x},
      material.colours);
  add("jacobian", TensorType::kU8, {1}, std::span<const std::uint8_t, 1>(&jacobian, 1));
  add("valid", TensorType::kU8, {sampling.valid.size()}, sampling.valid);
  return emit_tensor_file(fields);
}

}  // namespace sbrdf::internal
