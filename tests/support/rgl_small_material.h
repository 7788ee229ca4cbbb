#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "converters/files/rgl/rgl.h"
#include "formats/core/byte_reader.h"
#include "formats/core/directions.h"
#include "formats/rgl/rgl_material.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal::rgl_testing {

using Bytes = std::vector<std::byte>;
using Shape = std::vector<std::uint64_t>;

constexpr std::string_view kMagicWithZero("tensor_file\0", 12);
constexpr std::size_t kFirstEntry = 18;

struct Field {
  std::string name;
  TensorType type;
  Shape shape;
  Bytes elements;
};

template <class T>
inline Bytes bytes_of(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

inline Field floats(std::string name, Shape shape, const std::vector<float>& values) {
  return {std::move(name), TensorType::kF32, std::move(shape), bytes_of(values)};
}

inline std::size_t entry_size(const Field& field) { return 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size(); }

/// The elements follow the header without padding, so that most of them are not aligned.
inline Bytes emit(const std::vector<Field>& fields) {
  std::size_t offset = kFirstEntry;
  for (const Field& field : fields) offset += entry_size(field);
  ByteWriter out;
  out.text(kMagicWithZero);
  out.number(std::uint8_t{1});
  out.number(std::uint8_t{0});
  out.number(static_cast<std::uint32_t>(fields.size()));
  for (const Field& field : fields) {
    out.number(static_cast<std::uint16_t>(field.name.size()));
    out.text(field.name);
    out.number(static_cast<std::uint16_t>(field.shape.size()));
    out.number(static_cast<std::uint8_t>(field.type));
    out.number(static_cast<std::uint64_t>(offset));
    for (const std::uint64_t extent : field.shape) out.number(extent);
    offset += field.elements.size();
  }
  for (const Field& field : fields) out.bytes(field.elements);
  return std::move(out).take();
}

/// A vector of exactly the right capacity, so that the sanitizer sees every read past its end.
inline Bytes prefix_of(const Bytes& file, std::size_t size) {
  return {file.begin(), file.begin() + std::ptrdiff_t(size)};
}

/// A material small enough to break in every place: white and without a warp unless a test says otherwise.
struct SmallMaterial {
  std::vector<float> phi_i = {0};
  std::vector<float> theta_i = {0, 0.75f, 1.5707963f};
  RglGrid vndf_grid = {4, 3};
  RglGrid rgb_grid = {2, 2};
  std::uint8_t jacobian = 0;
  std::function<float(std::size_t slice, std::size_t x, std::size_t y)> vndf = [](auto...) { return 1.0f; };
  std::function<float(std::size_t slice, std::size_t channel, std::size_t x, std::size_t y)> rgb = [](auto...) {
    return 1.0f;
  };
  std::vector<float> sigma = {0.5f, 0.25f, 0.5f, 0.25f};
  std::vector<float> ndf = {3, 1, 3, 1};

  [[nodiscard]] std::vector<Field> fields() const {
    const std::size_t slice_count = phi_i.size() * theta_i.size();
    std::vector<float> vndf_values;
    std::vector<float> rgb_values;
    for (std::size_t slice = 0; slice < slice_count; ++slice) {
      for (std::size_t y = 0; y < vndf_grid.y_count; ++y) {
        for (std::size_t x = 0; x < vndf_grid.x_count; ++x) vndf_values.push_back(vndf(slice, x, y));
      }
      for (std::size_t channel = 0; channel < 3; ++channel) {
        for (std::size_t y = 0; y < rgb_grid.y_count; ++y) {
          for (std::size_t x = 0; x < rgb_grid.x_count; ++x) rgb_values.push_back(rgb(slice, channel, x, y));
        }
      }
    }
    const std::string words = "small material";
    return {{"description", TensorType::kU8, {words.size()}, bytes_of(std::vector<char>(words.begin(), words.end()))},
            floats("phi_i", {phi_i.size()}, phi_i),
            floats("theta_i", {theta_i.size()}, theta_i),
            floats("sigma", {2, 2}, sigma),
            floats("ndf", {2, 2}, ndf),
            floats("vndf", {phi_i.size(), theta_i.size(), vndf_grid.y_count, vndf_grid.x_count}, vndf_values),
            {"jacobian", TensorType::kU8, {1}, {std::byte{jacobian}}},
            floats("rgb", {phi_i.size(), theta_i.size(), 3, rgb_grid.y_count, rgb_grid.x_count}, rgb_values)};
  }
};

inline Field& named(std::vector<Field>& fields, std::string_view name) {
  return *std::ranges::find(fields, name, &Field::name);
}

inline std::unique_ptr<BrdfSource> load(const std::vector<Field>& fields) {
  auto source = load_rgl(emit(fields));
  EXPECT_TRUE(source.ok()) << source.error().message;
  return source.ok() ? std::move(source).value() : nullptr;
}

inline std::array<float, 3> evaluate(const BrdfSource& source, const DirectionPair& pair) {
  std::array<float, 3> values{};
  source.evaluate(std::span(&pair, 1), values);
  return values;
}

inline DirectionPair pair_from_degrees(double theta_i, double phi_i, double theta_v, double phi_v) {
  return {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
}

}  // namespace sbrdf::internal::rgl_testing
