#include "formats/rgl/tensor_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/rgl_small_material.h"

namespace sbrdf::internal::rgl_testing {
namespace {

using testing::HasSubstr;

/// Positions within the entry of the first field, which is called "a".
constexpr std::size_t kDimensionsAt = kFirstEntry + 3;
constexpr std::size_t kTypeAt = kDimensionsAt + 2;
constexpr std::size_t kOffsetAt = kTypeAt + 1;
constexpr std::size_t kShapeAt = kOffsetAt + 8;

Bytes file_with_one_field(const Shape& shape = {2, 3}) { return emit({floats("a", shape, {1, 2, 3, 4, 5, 6})}); }

template <class T>
void overwrite(Bytes& file, std::size_t offset, T value) {
  ASSERT_LE(offset + sizeof(T), file.size());
  std::memcpy(file.data() + offset, &value, sizeof(T));
}

Error parse_error(const Bytes& file) {
  const auto tensors = parse_tensor_file(file);
  EXPECT_FALSE(tensors.ok());
  return tensors.ok() ? Error{} : tensors.error();
}

TEST(RglParse, FindsEveryFieldOfATensorFile) {
  const Bytes file = emit({floats("a", {2, 3}, {1, 2, 3, 4, 5, 6}),
                           {"counts", TensorType::kU16, {2}, bytes_of(std::vector<std::uint16_t>{7, 8})},
                           {"one", TensorType::kF64, {}, bytes_of(std::vector<double>{9})},
                           {"none", TensorType::kU8, {4, 0}, {}}});
  const auto tensors = parse_tensor_file(file);
  ASSERT_TRUE(tensors.ok()) << tensors.error().message;
  ASSERT_EQ(tensors->fields.size(), 4u);
  const TensorField* a = tensors->find("a");
  ASSERT_NE(a, nullptr);
  EXPECT_EQ(a->type, TensorType::kF32);
  EXPECT_EQ(a->shape, (Shape{2, 3}));
  EXPECT_EQ(a->entry_offset, kFirstEntry);
  EXPECT_EQ(a->bytes.data(), file.data() + a->offset);
  EXPECT_EQ(Bytes(a->bytes.begin(), a->bytes.end()), bytes_of(std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(tensors->find("counts")->bytes.size(), 4u);
  EXPECT_EQ(tensors->find("one")->bytes.size(), 8u);
  EXPECT_EQ(tensors->find("none")->bytes.size(), 0u);
  EXPECT_EQ(tensors->find("other"), nullptr);
}

TEST(RglParse, KnowsTheSizeOfEveryElementType) {
  constexpr std::array<std::string_view, 11> names = {"u8",  "i8",  "u16", "i16", "u32", "i32",
                                                      "u64", "i64", "f16", "f32", "f64"};
  constexpr std::array<std::size_t, 11> sizes = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto type = static_cast<TensorType>(i + 1);
    EXPECT_EQ(tensor_type_name(type), names[i]);
    EXPECT_EQ(tensor_type_size(type), sizes[i]);
    EXPECT_TRUE(parse_tensor_file(emit({{"a", type, {3}, Bytes(3 * sizes[i])}})).ok());
    EXPECT_FALSE(parse_tensor_file(emit({{"a", type, {3}, Bytes(3 * sizes[i] - 1)}})).ok());
  }
}

TEST(RglParse, RejectsEveryTruncatedPrefixOfATensorFile) {
  const Bytes file = file_with_one_field();
  ASSERT_TRUE(parse_tensor_file(file).ok());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Error error = parse_error(prefix_of(file, size));
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile) << size;
    EXPECT_TRUE(error.offset.has_value()) << size;
  }
}

TEST(RglParse, RejectsAHeaderThatEndsWithinAShape) {
  Bytes file = file_with_one_field();
  overwrite(file, kOffsetAt, std::uint64_t{0});
  for (std::size_t size = kShapeAt; size < kShapeAt + 16; ++size) {
    EXPECT_THAT(parse_error(prefix_of(file, size)).message, HasSubstr("truncated")) << size;
  }
}

TEST(RglParse, AcceptsBytesAfterTheLastField) {
  Bytes file = file_with_one_field();
  file.resize(file.size() + 5);
  EXPECT_TRUE(parse_tensor_file(file).ok());
}

TEST(RglParse, RejectsWhatIsNoTensorFile) {
  for (const std::string_view text : {"", "tensor_file", "tensor file\n 1.0 and more text than a header has", "MERL"}) {
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    const auto tensors = parse_tensor_file(bytes);
    ASSERT_FALSE(tensors.ok());
    EXPECT_EQ(tensors.error().code, ErrorCode::kInvalidFile);
    EXPECT_EQ(tensors.error().offset, 0u);
  }
}

TEST(RglParse, RefusesAnotherVersion) {
  for (const std::size_t at : {std::size_t{12}, std::size_t{13}}) {
    Bytes file = file_with_one_field();
    overwrite(file, at, std::uint8_t{2});
    const Error error = parse_error(file);
    EXPECT_EQ(error.code, ErrorCode::kUnsupported);
    EXPECT_EQ(error.offset, 12u);
  }
}

TEST(RglParse, RejectsAFieldCountBeyondTheHeader) {
  Bytes file = file_with_one_field();
  overwrite(file, 14, std::uint32_t{1000});
  EXPECT_EQ(parse_error(file).code, ErrorCode::kInvalidFile);
  overwrite(file, 14, std::numeric_limits<std::uint32_t>::max());
  EXPECT_EQ(parse_error(file).code, ErrorCode::kUnsupported);
}

TEST(RglParse, RejectsAnUnknownElementType) {
  for (const int type : {0, 12, 255}) {
    Bytes file = file_with_one_field();
    overwrite(file, kTypeAt, static_cast<std::uint8_t>(type));
    const Error error = parse_error(file);
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_EQ(error.offset, kTypeAt);
    EXPECT_THAT(error.message, HasSubstr("field 0 \"a\""));
  }
}

TEST(RglParse, RefusesMoreDimensionsThanTheLimit) {
  Bytes file = file_with_one_field();
  overwrite(file, kDimensionsAt, std::uint16_t{17});
  EXPECT_EQ(parse_error(file).code, ErrorCode::kUnsupported);
  overwrite(file, kDimensionsAt, std::uint16_t{65535});
  const Error error = parse_error(file);
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_EQ(error.offset, kDimensionsAt);
}

TEST(RglParse, RejectsAnExtentBeyondTheFile) {
  for (const std::uint64_t extent :
       {std::uint64_t{4}, std::uint64_t{1} << 31, std::uint64_t{1} << 63, std::numeric_limits<std::uint64_t>::max()}) {
    Bytes file = file_with_one_field();
    overwrite(file, kShapeAt + 8, extent);
    const Error error = parse_error(file);
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_EQ(error.offset, kShapeAt + 8);
    EXPECT_THAT(error.message, HasSubstr("shape[1]"));
  }
}

TEST(RglParse, RejectsShapesThatOnlyFitByWrapping) {
  const std::uint64_t two_to_32 = std::uint64_t{1} << 32;
  const std::uint64_t two_to_62 = std::uint64_t{1} << 62;
  const std::vector<Shape> shapes = {
      {two_to_32, two_to_32}, {two_to_62, 4}, {4, two_to_62}, {2, two_to_62 + 1}, {3, 0xaaaaaaaaaaaaaaac}};
  for (const Shape& shape : shapes) {
    const Error error = parse_error(file_with_one_field(shape));
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_THAT(error.message, HasSubstr("asks for more than"));
  }
}

TEST(RglParse, RejectsAnOffsetOutsideTheElements) {
  const Bytes good = file_with_one_field();
  for (const std::uint64_t offset : {std::uint64_t{good.size() - 23}, std::uint64_t{good.size()},
                                     std::uint64_t{good.size() + 1}, std::numeric_limits<std::uint64_t>::max()}) {
    Bytes file = good;
    overwrite(file, kOffsetAt, offset);
    EXPECT_EQ(parse_error(file).code, ErrorCode::kInvalidFile) << offset;
  }
  Bytes file = good;
  overwrite(file, kOffsetAt, std::uint64_t{kShapeAt});
  EXPECT_THAT(parse_error(file).message, HasSubstr("inside the header"));
}

TEST(RglParse, RejectsASingleElementAtTheEndOfTheFile) {
  Bytes file = emit({{"a", TensorType::kF64, {}, Bytes(8)}});
  ASSERT_TRUE(parse_tensor_file(file).ok());
  overwrite(file, kOffsetAt, std::uint64_t{file.size()});
  EXPECT_EQ(parse_error(file).code, ErrorCode::kInvalidFile);
}

TEST(RglParse, RejectsNamesThatAreEmptyOrRepeated) {
  EXPECT_THAT(parse_error(emit({floats("", {1}, {1})})).message, HasSubstr("has no name"));
  const Error error = parse_error(emit({floats("a", {1}, {1}), floats("b", {1}, {1}), floats("a", {1}, {1})}));
  EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
  EXPECT_THAT(error.message, HasSubstr("field 2 \"a\""));
}

TEST(RglParse, ShowsHostileNamesOnOneShortLine) {
  const std::string name = "line\nbreak\x1b[31m\xff" + std::string(60000, 'x');
  Bytes file = emit({floats(name, {1}, {1})});
  overwrite(file, kFirstEntry + 2 + name.size() + 2, std::uint8_t{0});
  const Error error = parse_error(file);
  EXPECT_LT(error.message.size(), 120u);
  EXPECT_TRUE(std::ranges::all_of(error.message, [](char c) { return c >= 0x20 && c < 0x7f; })) << error.message;
}

}  // namespace
}  // namespace sbrdf::internal::rgl_testing
