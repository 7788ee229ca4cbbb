#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "converters/files/rgl/rgl.h"
#include "formats/rgl/rgl_material.h"
#include "formats/rgl/tensor_file.h"
#include "tests/support/rgl_small_material.h"

namespace sbrdf::internal::rgl_testing {
namespace {

using testing::HasSubstr;

/// Where the elements of a field begin in what `emit` makes of the fields.
std::size_t elements_offset(const std::vector<Field>& fields, std::string_view name) {
  std::size_t offset = kFirstEntry;
  for (const Field& field : fields) offset += entry_size(field);
  for (const Field& field : fields) {
    if (field.name == name) break;
    offset += field.elements.size();
  }
  return offset;
}

void set_float(std::vector<Field>& fields, std::string_view name, std::size_t position, float value) {
  std::memcpy(named(fields, name).elements.data() + position * sizeof(float), &value, sizeof(float));
}

void fill_floats(std::vector<Field>& fields, std::string_view name, float value) {
  const std::size_t count = named(fields, name).elements.size() / sizeof(float);
  for (std::size_t i = 0; i < count; ++i) set_float(fields, name, i, value);
}

Error load_error(const std::vector<Field>& fields) {
  const auto source = load_rgl(emit(fields));
  EXPECT_FALSE(source.ok());
  return source.ok() ? Error{} : source.error();
}

TEST(RglParse, RecognisesATensorFileByContent) {
  EXPECT_TRUE(recognises_rgl(emit(SmallMaterial().fields())));
  for (const std::string_view text : {"", "tensor_file", "tensor file\n 1.0 and more text than a header has", "MERL"}) {
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    EXPECT_FALSE(recognises_rgl(bytes));
    EXPECT_FALSE(load_rgl(bytes).ok());
  }
}

TEST(RglParse, NamesAFourierBsdf) {
  const std::string file = "SCATFUN\x01" + std::string(64, '\0');
  const auto bytes = std::as_bytes(std::span(file));
  EXPECT_TRUE(recognises_rgl(bytes));
  const auto source = load_rgl(bytes);
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(source.error().message, HasSubstr("Fourier BSDF"));
}

TEST(RglParse, RejectsEveryTruncatedPrefixOfAMaterial) {
  const Bytes file = emit(SmallMaterial().fields());
  ASSERT_TRUE(load_rgl(file).ok());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Bytes prefix = prefix_of(file, size);
    const auto source = load_rgl(prefix);
    ASSERT_FALSE(source.ok()) << size;
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidFile) << size;
  }
}

TEST(RglParse, NamesAMissingField) {
  for (const std::string_view name : {"phi_i", "theta_i", "sigma", "ndf", "vndf", "rgb", "jacobian"}) {
    std::vector<Field> fields = SmallMaterial().fields();
    std::erase_if(fields, [&](const Field& field) { return field.name == name; });
    const Error error = load_error(fields);
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_THAT(error.message, HasSubstr("\"" + std::string(name) + "\" is missing"));
  }
}

TEST(RglParse, NeedsNeitherDescriptionNorLuminance) {
  std::vector<Field> fields = SmallMaterial().fields();
  EXPECT_EQ(load(fields)->traits().description, "small material");
  std::erase_if(fields, [](const Field& field) { return field.name == "description"; });
  EXPECT_EQ(load(fields)->traits().description, "RGL material");
}

TEST(RglParse, ShowsADescriptionOnOneLine) {
  std::vector<Field> fields = SmallMaterial().fields();
  named(fields, "description").elements[5] = std::byte{'\n'};
  EXPECT_EQ(load(fields)->traits().description, "small?material");
}

TEST(RglParse, RejectsAFieldOfTheWrongTypeOrDimensionCount) {
  for (const std::string_view name : {"phi_i", "theta_i", "sigma", "ndf", "vndf", "rgb", "jacobian"}) {
    const std::string quoted = "\"" + std::string(name) + "\"";
    std::vector<Field> fields = SmallMaterial().fields();
    Field& field = named(fields, name);
    field.type = field.type == TensorType::kF32 ? TensorType::kI32 : TensorType::kI8;
    EXPECT_THAT(load_error(fields).message, testing::AllOf(HasSubstr(quoted), HasSubstr("is of type i")));
    fields = SmallMaterial().fields();
    named(fields, name).shape.push_back(1);
    EXPECT_THAT(load_error(fields).message, testing::AllOf(HasSubstr(quoted), HasSubstr("dimensions, must have")));
    fields = SmallMaterial().fields();
    named(fields, name).shape.clear();
    EXPECT_THAT(load_error(fields).message, testing::AllOf(HasSubstr(quoted), HasSubstr("has 0 dimensions")));
  }
}

TEST(RglParse, RejectsExtentsThatDisagreeOrAreTooSmall) {
  const std::map<std::string, std::size_t> axis_count = {{"phi_i", 1}, {"theta_i", 1}, {"sigma", 2},   {"ndf", 2},
                                                         {"vndf", 4},  {"rgb", 5},     {"jacobian", 1}};
  for (const auto& [name, count] : axis_count) {
    for (std::size_t axis = 0; axis < count; ++axis) {
      std::vector<Field> fields = SmallMaterial().fields();
      named(fields, name).shape[axis] = 0;
      const Error error = load_error(fields);
      EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
      EXPECT_THAT(error.message, HasSubstr("\"" + name + "\": shape[" + std::to_string(axis) + "] is 0, must be"));
    }
  }
  for (const auto& [name, axis] :
       {std::pair{"vndf", 3}, {"vndf", 2}, {"rgb", 4}, {"rgb", 3}, {"sigma", 1}, {"ndf", 0}}) {
    std::vector<Field> fields = SmallMaterial().fields();
    named(fields, name).shape[static_cast<std::size_t>(axis)] = 1;
    EXPECT_THAT(load_error(fields).message, HasSubstr("is 1, must be at least 2"));
  }
  for (const auto& [name, axis] : {std::pair{"vndf", 1}, {"rgb", 1}, {"rgb", 2}}) {
    std::vector<Field> fields = SmallMaterial().fields();
    named(fields, name).shape[static_cast<std::size_t>(axis)] = 2;
    EXPECT_THAT(load_error(fields).message, HasSubstr("is 2, must be 3"));
  }
}

TEST(RglParse, RejectsMoreSlicesThanTheAxesHave) {
  std::vector<Field> fields = SmallMaterial().fields();
  named(fields, "theta_i").shape[0] = 2;
  EXPECT_EQ(load_error(fields).message, "field \"vndf\": shape[1] is 3, must be 2");
}

TEST(RglParse, RejectsAValueThatIsNotFiniteByIndexAndOffset) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
    for (const std::string_view name : {"phi_i", "theta_i", "sigma", "ndf", "vndf", "rgb"}) {
      std::vector<Field> fields = SmallMaterial().fields();
      const std::size_t last = named(fields, name).elements.size() / sizeof(float) - 1;
      set_float(fields, name, last, value);
      const Error error = load_error(fields);
      EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
      EXPECT_THAT(error.message, HasSubstr("\"" + std::string(name) + "\""));
      EXPECT_EQ(error.offset, elements_offset(fields, name) + last * sizeof(float));
    }
  }
  std::vector<Field> fields = SmallMaterial().fields();
  set_float(fields, "rgb", 1 + 2 * (1 + 2 * (2 + 3 * 1)), std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(load_error(fields).message, "field \"rgb\": index [0, 1, 2, 1, 1] is not a finite number");
}

TEST(RglParse, RejectsAnAxisThatDoesNotRise) {
  std::vector<Field> fields = SmallMaterial().fields();
  set_float(fields, "theta_i", 1, 0);
  Error error = load_error(fields);
  EXPECT_EQ(error.message, "field \"theta_i\": index [1] does not rise above the one before");
  EXPECT_EQ(error.offset, elements_offset(fields, "theta_i") + 4);
  SmallMaterial material;
  material.phi_i = {0.5f, 0.25f};
  EXPECT_THAT(load_error(material.fields()).message, HasSubstr("\"phi_i\": index [1] does not rise"));
}

TEST(RglParse, RejectsAnAxisOutsideItsRange) {
  SmallMaterial material;
  material.theta_i = {-0.1f, 0.5f};
  EXPECT_THAT(load_error(material.fields()).message, HasSubstr("outside [0.0"));
  material.theta_i = {0, 30, 60};
  EXPECT_THAT(load_error(material.fields()).message, HasSubstr("index [1] is 30.0"));
  material.theta_i = {0, 1.5707965f};
  EXPECT_TRUE(load_rgl(emit(material.fields())).ok());
  material.phi_i = {0, 6.3f};
  EXPECT_THAT(load_error(material.fields()).message, HasSubstr("\"phi_i\""));
}

TEST(RglParse, RejectsValuesThatCannotBeABrdf) {
  const auto with = [](std::string_view name, std::size_t position, float value) {
    std::vector<Field> fields = SmallMaterial().fields();
    set_float(fields, name, position, value);
    return load_error(fields);
  };
  EXPECT_EQ(with("sigma", 3, 0).message, "field \"sigma\": index [1, 1] is not a positive area");
  EXPECT_EQ(with("sigma", 2, -1).message, "field \"sigma\": index [1, 0] is not a positive area");
  EXPECT_EQ(with("vndf", 17, -1e-30f).message, "field \"vndf\": index [0, 1, 1, 1] is a negative density");

  std::vector<Field> fields = SmallMaterial().fields();
  for (std::size_t i = 12; i < 24; ++i) set_float(fields, "vndf", i, 0);
  const Error error = load_error(fields);
  EXPECT_EQ(error.message, "field \"vndf\": index [0, 1, 0, 0] begins a slice that is all zero");
  EXPECT_EQ(error.offset, elements_offset(fields, "vndf") + 48);
}

TEST(RglParse, RejectsAMaterialThatIsNowherePositive) {
  for (const std::string_view name : {"rgb", "ndf"}) {
    std::vector<Field> fields = SmallMaterial().fields();
    fill_floats(fields, name, 0);
    EXPECT_EQ(load_error(fields).message, "field \"" + std::string(name) + "\": holds no value above zero");
    fill_floats(fields, name, -1);
    const Error error = load_error(fields);
    EXPECT_EQ(error.message, "field \"" + std::string(name) + "\": holds negative values only");
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_EQ(error.offset, elements_offset(fields, name));
  }
}

TEST(RglParse, RefusesASpectralMaterialWithoutAWavelengthForEachChannel) {
  std::vector<Field> fields = SmallMaterial().fields();
  named(fields, "rgb").name = "spectra";
  EXPECT_THAT(load_error(fields).message, HasSubstr("wavelengths"));
  fields.push_back(floats("wavelengths", {2}, {400, 500}));
  const Error error = load_error(fields);
  EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
  EXPECT_THAT(error.message, testing::AnyOf(HasSubstr("wavelengths"), HasSubstr("spectra")));
}

TEST(RglParse, RefusesAzimuthsThatAreNoPartOfATurn) {
  SmallMaterial material;
  material.phi_i = {-3.1415927f, -2.6f, -2.0943952f};
  Error error = load_error(material.fields());
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_THAT(error.message, HasSubstr("\"phi_i\""));
  material.phi_i = {0, 0.8f, 1.5707963f};
  EXPECT_EQ(load_error(material.fields()).code, ErrorCode::kUnsupported);
}

TEST(RglParse, SurvivesEveryByteOfASmallFileBeingChanged) {
  SmallMaterial material;
  material.jacobian = 1;
  const Bytes good = emit(material.fields());
  const DirectionPair pair = pair_from_degrees(40, 10, 60, 200);
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
      Bytes file = good;
      file[at] ^= static_cast<std::byte>(flip);
      const auto source = load_rgl(file);
      if (!source.ok()) {
        EXPECT_FALSE(source.error().message.empty());
        continue;
      }
      for (const float value : evaluate(**source, pair)) EXPECT_TRUE(std::isfinite(value)) << at;
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal::rgl_testing
