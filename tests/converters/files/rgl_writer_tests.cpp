#include "converters/files/rgl/rgl_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "converters/files/format_table.h"
#include "converters/files/rgl/rgl.h"
#include "converters/files/rgl/rgl_spectral.h"
#include "formats/core/parallel.h"
#include "formats/rgl/tensor_file.h"
#include "tests/support/function_source.h"
#include "tests/support/rgl_small_material.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal::rgl_testing {
namespace {

using testing::HasSubstr;

struct Written {
  Bytes bytes;
  Report report;
};

Result<Written> write(const BrdfSource& source, const Options& options, const Progress& progress = {}) {
  MemorySink sink;
  Written written;
  const Format& format = **find_writer(".bsdf");
  if (Status saved = save_source(format, source, sink, options, written.report, progress); !saved) return saved.error();
  written.bytes = std::move(sink).take();
  return written;
}

/// Little work.
Options small() { return Options().set("rgl-size", "12").set("rgl-warp-size", "24").set("rgl-theta", "6"); }
Options small_anisotropic() { return small().set("rgl-size", "10").set("rgl-phi", "9"); }

std::optional<Remark> remark(const Report& report, std::string_view key) {
  const auto found = std::ranges::find(report.remarks, key, &Remark::key);
  return found == report.remarks.end() ? std::nullopt : std::optional(*found);
}

/// Microfacets after Trowbridge and Reitz, roughness `a` along the tangent and `b` across it, on a diffuse base; no
/// shadowing. In closed form.
double rough(const DirectionPair& pair, double a, double b, double diffuse) {
  const glm::dvec3 i = vector_from_direction(pair.i);
  const glm::dvec3 v = vector_from_direction(pair.v);
  const glm::dvec3 h = {i.x + v.x, i.y + v.y, i.z + v.z};
  const double size = h.x * h.x + h.y * h.y + h.z * h.z;
  const double stretched = (h.x * h.x / (a * a) + h.y * h.y / (b * b) + h.z * h.z) / size;
  return diffuse / kPi + 1 / (kPi * a * b * stretched * stretched) / (4 * (0.1 + i.z) * (0.1 + v.z));
}

FunctionSource isotropic(std::vector<std::string> channels = {"R", "G", "B"}) {
  return FunctionSource(
      [](const DirectionPair& pair, std::size_t channel) {
        return rough(pair, 0.3, 0.3, 0.1 + 0.2 * static_cast<double>(channel % 3));
      },
      {true, true, std::move(channels)});
}

/// Relative L1 [%] over random pairs up to 80 degrees, worked out here.
double difference_percent(const BrdfSource& f, const BrdfSource& r) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> theta(0, radians_from_degrees(80));
  std::uniform_real_distribution<double> phi(0, 2 * kPi);
  std::vector<DirectionPair> pairs(20000);
  for (DirectionPair& pair : pairs) pair = {{theta(random), phi(random)}, {theta(random), phi(random)}};
  std::vector<float> expected(pairs.size() * f.channel_count());
  std::vector<float> found(pairs.size() * r.channel_count());
  f.evaluate(pairs, expected);
  r.evaluate(pairs, found);
  EXPECT_EQ(expected.size(), found.size());
  double difference = 0;
  double sum = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    difference += std::abs(expected[n] - found[n]);
    sum += std::abs(expected[n]);
  }
  return 100 * difference / sum;
}

std::unique_ptr<BrdfSource> read(const Bytes& bytes, const Options& options = {}) {
  auto source = open_rgl(std::make_shared<OwnedMemorySource>(bytes), options);
  EXPECT_TRUE(source.ok()) << source.error().message;
  return source.ok() ? *std::move(source) : nullptr;
}

template <class T>
std::vector<T> elements_of(const TensorFile& tensors, std::string_view name) {
  const TensorField* field = tensors.find(name);
  if (field == nullptr) return {};
  std::vector<T> values(field->bytes.size() / sizeof(T));
  std::memcpy(values.data(), field->bytes.data(), field->bytes.size());
  return values;
}

TEST(RglWriter, ComesNearARoughMaterial) {
  const FunctionSource source = isotropic();
  const auto written = write(source, small());
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto back = read(written->bytes);
  EXPECT_TRUE(back->traits().isotropic);
  EXPECT_LT(difference_percent(source, *back), 2.0);
  EXPECT_EQ(remark(written->report, "copied"), std::nullopt);
  ASSERT_TRUE(remark(written->report, "resampling_rel_l1_percent").has_value());
}

TEST(RglWriter, ComesNearerWithMoreNodes) {
  const FunctionSource source = isotropic();
  const auto few = write(source, small());
  const auto many = write(source, small().set("rgl-size", "24").set("rgl-theta", "12").set("rgl-warp-size", "48"));
  const double coarse = difference_percent(source, *read(few->bytes));
  const double fine = difference_percent(source, *read(many->bytes));
  EXPECT_LT(fine, 0.6 * coarse);
  EXPECT_LT(fine, 0.6);
}

TEST(RglWriter, GivesADiffuseMaterialBackUpToGrazing) {
  const FunctionSource source([](const DirectionPair&, std::size_t channel) { return 0.1 * double(1 + channel); },
                              {true, true, {"R", "G", "B"}});
  const auto back =
      read(write(source, small().set("rgl-theta", "10").set("rgl-size", "20").set("rgl-warp-size", "40"))->bytes);
  for (const double theta_i : {0.0, 20.0, 45.0, 70.0, 80.0}) {
    for (const double theta_v : {0.0, 30.0, 60.0, 75.0, 80.0}) {
      for (const double phi_v : {0.0, 90.0, 175.0, 300.0}) {
        const std::array<float, 3> f = evaluate(*back, pair_from_degrees(theta_i, 0, theta_v, phi_v));
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_NEAR(f[c], 0.1 * double(1 + c), 0.02 * double(1 + c)) << theta_i << " " << theta_v << " " << phi_v;
        }
      }
    }
  }
}

TEST(RglWriter, KeepsBothAzimuthsOfAnAnisotropicMaterial) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t channel) { return rough(pair, 0.5, 0.25, 0.1 * double(1 + channel)); });
  const auto written = write(source, small_anisotropic());
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto back = read(written->bytes);
  EXPECT_FALSE(back->traits().isotropic);
  EXPECT_LT(difference_percent(source, *back), 6.0);
  const std::vector<float> phi_i = elements_of<float>(*parse_tensor_file(written->bytes), "phi_i");
  ASSERT_EQ(phi_i.size(), 9U);
  EXPECT_FLOAT_EQ(phi_i.front(), static_cast<float>(-kPi));
  EXPECT_FLOAT_EQ(phi_i.back(), static_cast<float>(kPi));
  // Along the tangent it is twice as wide as across.
  const float along = evaluate(*back, pair_from_degrees(10, 0, 40, 180))[0];
  const float across = evaluate(*back, pair_from_degrees(10, 90, 40, 270))[0];
  EXPECT_GT(along, 1.5F * across);
}

TEST(RglWriter, ClosesTheTurnOfAnAnisotropicMaterial) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) {
    return rough(pair, 0.5, 0.25, 0.2) * (1.5 + std::cos(pair.i.phi));
  });
  const auto written = write(source, small_anisotropic());
  const TensorFile tensors = *parse_tensor_file(written->bytes);
  const std::vector<float> rgb = elements_of<float>(tensors, "rgb");
  const std::size_t slice = rgb.size() / 9;
  EXPECT_TRUE(std::equal(rgb.begin(), rgb.begin() + std::ptrdiff_t(slice), rgb.end() - std::ptrdiff_t(slice)));
}

TEST(RglWriter, HasTheFieldsOfPublishedFilesEachAtAMultipleOfEight) {
  const auto written = write(isotropic(), small());
  const Result<TensorFile> tensors = parse_tensor_file(written->bytes);
  ASSERT_TRUE(tensors.ok());
  using Shape = std::vector<std::uint64_t>;
  const std::vector<std::pair<std::string_view, Shape>> expected = {
      {"version", {2}},           {"description", {10}}, {"phi_i", {1}},           {"theta_i", {6}},
      {"sigma", {2, 128}},        {"ndf", {2, 128}},     {"vndf", {1, 6, 24, 24}}, {"luminance", {1, 6, 12, 12}},
      {"rgb", {1, 6, 3, 12, 12}}, {"jacobian", {1}},     {"valid", {108}}};
  ASSERT_EQ(tensors->fields.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(tensors->fields[k].name, expected[k].first);
    EXPECT_EQ(tensors->fields[k].shape, expected[k].second) << expected[k].first;
    EXPECT_EQ(tensors->fields[k].offset % 8, 0U) << expected[k].first;
  }
  EXPECT_EQ(elements_of<std::uint32_t>(*tensors, "version"), (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(tensors->find("jacobian")->bytes[0], std::byte{1});
}

TEST(RglWriter, EverySliceCanBeDrawnFrom) {
  // Black but for a narrow lobe.
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return rough(pair, 0.02, 0.02, 0); },
                              {true, true, {"R", "G", "B"}});
  const auto written = write(source, small());
  const TensorFile tensors = *parse_tensor_file(written->bytes);
  for (const auto& [name, cells] : {std::pair{"vndf", 24 * 24}, std::pair{"luminance", 12 * 12}}) {
    const std::vector<float> values = elements_of<float>(tensors, name);
    ASSERT_EQ(values.size(), std::size_t(6 * cells));
    EXPECT_GE(*std::ranges::min_element(values), 0.0F) << name;
    for (std::size_t slice = 0; slice < 6; ++slice) {
      const auto first = values.begin() + std::ptrdiff_t(slice) * cells;
      EXPECT_GT(std::accumulate(first, first + cells, 0.0), 0.0) << name << " " << slice;
    }
  }
}

TEST(RglWriter, GivesNothingNegativeWhereTheSourceIsNot) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return rough(pair, 0.1, 0.1, 0.001); },
                              {true, true, {"R", "G", "B"}});
  const auto back = read(write(source, small())->bytes);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> theta(0, radians_from_degrees(85));
  std::uniform_real_distribution<double> phi(0, 2 * kPi);
  std::size_t negative = 0;
  for (int n = 0; n < 20000; ++n) {
    negative += evaluate(*back, {{theta(random), 0}, {theta(random), phi(random)}})[0] < 0 ? 1 : 0;
  }
  EXPECT_LE(negative, 5U);
}

TEST(RglWriter, CopiesItsOwnKindUnlessAnOptionIsGiven) {
  SmallMaterial material;
  material.jacobian = 1;
  const Bytes file = emit(material.fields());
  const auto source = read(file);
  const auto copied = write(*source, {});
  EXPECT_EQ(copied->bytes, file);
  EXPECT_TRUE(remark(copied->report, "copied").has_value());
  const auto again = write(*source, small());
  EXPECT_NE(again->bytes, file);
  EXPECT_EQ(remark(again->report, "copied"), std::nullopt);
  // Read in another way, the file does not say what the source says.
  EXPECT_EQ(remark(write(*read(file, Options().set("negatives", "clamp")), small())->report, "copied"), std::nullopt);
}

TEST(RglWriter, KeepsTheTablesOfAnRglFileWhoseColoursAloneAreResampled) {
  const FunctionSource rough_source = isotropic();
  const Bytes file = write(rough_source, small())->bytes;
  const auto source = read(file);
  const auto again = write(*source, Options().set("rgl-size", "12"));
  ASSERT_TRUE(again.ok()) << again.error().message;
  const TensorFile before = *parse_tensor_file(file);
  const TensorFile after = *parse_tensor_file(again->bytes);
  for (const char* name : {"theta_i", "sigma", "ndf", "vndf"}) {
    EXPECT_EQ(elements_of<float>(before, name), elements_of<float>(after, name)) << name;
  }
  EXPECT_LT(difference_percent(*source, *read(again->bytes)), 0.1);
}

TEST(RglWriter, KeepsTheTablesOfAnRglFileThatIsReadWithoutItsNegatives) {
  SmallMaterial material;
  material.jacobian = 1;
  material.rgb = [](std::size_t, std::size_t channel, std::size_t x, std::size_t y) {
    return channel == 1 && x == 0 ? -1.0F : float(1 + x + y);
  };
  const Bytes file = emit(material.fields());
  const TensorFile before = *parse_tensor_file(file);
  for (const char* negatives : {"keep", "clamp", "unmeasured"}) {
    const Options options = Options().set("negatives", negatives);
    const auto source = read(file, options);
    ASSERT_NE(source->stored(kRglTables), nullptr) << negatives;
    const auto again = write(*source, options);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(remark(again->report, "copied"), std::nullopt) << negatives;
    const TensorFile after = *parse_tensor_file(again->bytes);
    for (const char* name : {"theta_i", "sigma", "ndf", "vndf"}) {
      EXPECT_EQ(elements_of<float>(before, name), elements_of<float>(after, name)) << negatives << " " << name;
    }
  }
}

TEST(RglWriter, RepeatsAnOnlyChannelAndRefusesOtherNumbers) {
  const FunctionSource grey = isotropic({"Y"});
  const auto written = write(grey, small());
  ASSERT_TRUE(written.ok()) << written.error().message;
  EXPECT_TRUE(remark(written->report, "channel_repeated").has_value());
  const std::array<float, 3> f = evaluate(*read(written->bytes), pair_from_degrees(30, 0, 40, 100));
  EXPECT_EQ(f[0], f[1]);
  EXPECT_EQ(f[0], f[2]);
  for (const std::vector<std::string>& channels : {std::vector<std::string>{"a", "b"}, {"a", "b", "c", "d"}}) {
    EXPECT_EQ(write(isotropic(channels), small()).error().code, ErrorCode::kUnsupported);
  }
  EXPECT_EQ(write(grey, small().set("rgl-values", "spectra")).error().code, ErrorCode::kUnsupported);
}

TEST(RglWriter, WritesWavelengthsAsSpectraOrAsColours) {
  const FunctionSource source = isotropic({"400 nm", "500.5 nm", "600 nm", "700 nm"});
  const auto spectral = write(source, small());
  ASSERT_TRUE(spectral.ok()) << spectral.error().message;
  const auto back = read(spectral->bytes);
  EXPECT_EQ(back->traits().channels, source.traits().channels);
  EXPECT_LT(difference_percent(source, *back), 2.0);
  const auto colours = write(source, small().set("rgl-values", "rgb"));
  ASSERT_TRUE(colours.ok()) << colours.error().message;
  const auto rgb = read(colours->bytes);
  EXPECT_EQ(rgb->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  // Weighing before and after comes to the same.
  EXPECT_LT(difference_percent(*read(spectral->bytes, Options().set("spectral", "rgb")), *rgb), 1.0);
  const FunctionSource infrared = isotropic({"800 nm", "900 nm"});
  EXPECT_TRUE(write(infrared, small()).ok());
  EXPECT_EQ(write(infrared, small().set("rgl-values", "rgb")).error().code, ErrorCode::kUnsupported);
}

// Green is below 0 where the viewer leans to one side.
TEST(RglNegatives, AreKeptMadeZeroOrLeftOutOfWhatIsWritten) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t channel) {
        return rough(pair, 0.5, 0.5, 0.3) *
               (channel == 1 ? std::sin(pair.v.theta) * std::cos(pair.v.phi - pair.i.phi) : 1);
      },
      {true, false, {"R", "G", "B"}});
  const DirectionPair negative = pair_from_degrees(10, 0, 45, 180);
  const DirectionPair positive = pair_from_degrees(10, 0, 45, 0);
  const auto keep = write(source, small());
  EXPECT_LT(evaluate(*read(keep->bytes), negative)[1], -0.05F);
  EXPECT_GT(remark(keep->report, "negative_pairs")->value, 100);
  const auto clamp = write(source, small().set("negatives", "clamp"));
  EXPECT_GE(evaluate(*read(clamp->bytes), negative)[1], 0.0F);
  EXPECT_LT(evaluate(*read(clamp->bytes), negative)[1], 0.05F);
  const auto unmeasured = write(source, small().set("negatives", "unmeasured"));
  ASSERT_TRUE(unmeasured.ok()) << unmeasured.error().message;
  for (const auto* written : {&keep, &clamp, &unmeasured}) {
    std::array<float, 3> expected{};
    source.evaluate(std::span(&positive, 1), expected);
    EXPECT_NEAR(evaluate(*read((*written)->bytes), positive)[1], expected[1], 0.1 * expected[1]);
  }
}

TEST(RglWriter, RefusesWhatIsNotFiniteOrNowherePositive) {
  const auto constant = [](double value) {
    return FunctionSource([value](const DirectionPair&, std::size_t) { return value; }, {true, true, {"R", "G", "B"}});
  };
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 3e38}) {
    const auto written = write(constant(value), small());
    ASSERT_FALSE(written.ok()) << value;
    EXPECT_THAT(written.error().message, HasSubstr("theta_i")) << value;
  }
  for (const double value : {0.0, -1.0}) {
    const auto written = write(constant(value), small());
    ASSERT_FALSE(written.ok()) << value;
    EXPECT_THAT(written.error().message, HasSubstr("positive")) << value;
  }
}

/// Nothing is measured on one side, where values are wild.
class HalfMeasured final : public BrdfSource {
 public:
  [[nodiscard]] const SourceTraits& traits() const override { return inner_.traits(); }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    inner_.evaluate(pairs, values);
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = is_hole(pairs[n / 3]) ? 1e6F : values[n];
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    for (std::size_t n = 0; n < pairs.size(); ++n) flags[n] = is_hole(pairs[n]) ? 0 : 1;
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override {
    return MaskGrid{MaskFrame::kAngles, {30, 1, 30, 36}};
  }

 private:
  static bool is_hole(const DirectionPair& pair) { return pair.v.theta > 1.2; }
  FunctionSource inner_ = isotropic();
};

TEST(RglWriter, FillsWhatWasNotMeasuredAndCountsIt) {
  const HalfMeasured source;
  const auto written = write(source, small());
  ASSERT_TRUE(written.ok()) << written.error().message;
  EXPECT_GT(remark(written->report, "unmeasured_pairs")->value, 100);
  EXPECT_LT(evaluate(*read(written->bytes), pair_from_degrees(20, 0, 78, 90))[0], 10.0F);
}

TEST(RglWriter, WritesTheSameBytesOnAnyNumberOfThreads) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return rough(pair, 0.5, 0.25, 0.2); });
  const auto several = write(source, small_anisotropic().set("rgl-theta", "4").set("rgl-phi", "5"));
  const ThreadLimit limit(1);
  EXPECT_EQ(write(source, small_anisotropic().set("rgl-theta", "4").set("rgl-phi", "5"))->bytes, several->bytes);
}

TEST(RglWriter, StopsWhenAskedAndPassesOnThatWritingFailed) {
  const Progress stop = {[](double) { return false; }};
  EXPECT_EQ(write(isotropic(), small(), stop).error().message, interrupted_error().message);
  class FullSink final : public ByteSink {
    [[nodiscard]] Status write(std::uint64_t, std::span<const std::byte>) override { return io_error("full"); }
  } sink;
  Report report;
  EXPECT_EQ(save_rgl(isotropic(), sink, small(), report).error().message, "full");
}

TEST(RglWriter, RefusesSizesThatMakeTooManyNodes) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return rough(pair, 0.5, 0.25, 0.2); });
  for (const Options& options : {Options().set("rgl-size", "256").set("rgl-theta", "128"),
                                 Options().set("rgl-size", "128").set("rgl-phi", "361"),
                                 Options().set("rgl-warp-size", "1024").set("rgl-theta", "128")}) {
    const auto written = write(source, options);
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().code, ErrorCode::kUsage);
    EXPECT_THAT(written.error().message, HasSubstr("--rgl-size"));
  }
}

TEST(RglWriter, ComesNearAMeasuredMaterialFromItsValuesAlone) {
  SBRDF_FIND_TEST_DATA(path, "rgl/acrylic_felt_green_rgb.bsdf");
  const auto source = load_rgl(read_bytes(path)).value();
  const auto written =
      write(*source, Options().set("rgl-theta", "12").set("rgl-size", "24").set("rgl-warp-size", "48"));
  EXPECT_LT(difference_percent(*source, *read(written->bytes)), 1.5);
}

// Spectral files.

/// Of three wavelengths; colour of a node: its channel and place.
std::vector<Field> spectral_fields(const std::vector<float>& wavelengths) {
  SmallMaterial material;
  material.rgb = [](std::size_t slice, std::size_t channel, std::size_t x, std::size_t y) {
    return float(1 + slice + 2 * channel) + 0.25F * float(x + 2 * y);
  };
  std::vector<Field> fields = material.fields();
  named(fields, "rgb").name = "spectra";
  fields.push_back(floats("wavelengths", {wavelengths.size()}, wavelengths));
  return fields;
}

TEST(RglSpectral, HasAChannelForEachWavelength) {
  const auto source = load(spectral_fields({430, 550.5, 670}));
  EXPECT_EQ(source->traits().channels, (std::vector<std::string>{"430 nm", "550.5 nm", "670 nm"}));
  std::vector<Field> rgb = spectral_fields({430, 550.5, 670});
  rgb.pop_back();
  named(rgb, "spectra").name = "rgb";
  const DirectionPair pair = pair_from_degrees(30, 0, 50, 120);
  EXPECT_EQ(evaluate(*source, pair), evaluate(*load(rgb), pair));
}

TEST(RglSpectral, BecomesTheColourThatItsWeightsSay) {
  const std::vector<float> wavelengths = {430, 550.5, 670};
  const Bytes file = emit(spectral_fields(wavelengths));
  const auto rgb = read(file, Options().set("spectral", "rgb"));
  EXPECT_EQ(rgb->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(rgb->stored("rgl"), nullptr) << "the file says something else";
  EXPECT_NE(read(file)->stored("rgl"), nullptr);
  const DirectionPair pair = pair_from_degrees(30, 0, 50, 120);
  const std::array<float, 3> spectrum = evaluate(*read(file), pair);
  const std::array<float, 3> colour = evaluate(*rgb, pair);
  const std::vector<double> weights = rgl_rgb_weights(wavelengths);
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += weights[3 * c + k] * spectrum[k];
    EXPECT_NEAR(colour[c], sum, 1e-5 * std::abs(sum));
  }
}

TEST(RglSpectral, AFlatSpectrumIsGreyAndColoursAreWhereTheyBelong) {
  std::vector<float> wavelengths(41);
  for (std::size_t k = 0; k < wavelengths.size(); ++k) wavelengths[k] = 380 + 10 * float(k);
  const std::vector<double> weights = rgl_rgb_weights(wavelengths);
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t k = 0; k < 41; ++k) sum += weights[41 * c + k];
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  // CIE 15: D65 x y at 550 nm is 104.046 x 0.99495, of a sum over all wavelengths of 1056.7 (every 10 nm).
  const auto luminance = [&](std::size_t k) {
    return 0.2126 * weights[k] + 0.7152 * weights[41 + k] + 0.0722 * weights[82 + k];
  };
  EXPECT_NEAR(luminance(17), 104.046 * 0.99495 / 1056.7, 2e-3);
  EXPECT_GT(weights[25], 5 * std::abs(weights[41 + 25])) << "630 nm is red";
  EXPECT_GT(weights[41 + 15], 0.05) << "530 nm is green";
  EXPECT_GT(weights[82 + 7], 5 * std::abs(weights[7])) << "450 nm is blue";
}

TEST(RglSpectral, NeedsWavelengthsOfWhatIsVisibleForColours) {
  for (const std::vector<float>& wavelengths : {std::vector<float>{440, 550, 700}, {400, 500, 660}}) {
    const Bytes file = emit(spectral_fields(wavelengths));
    EXPECT_TRUE(load_rgl(file).ok());
    const auto colours = load_rgl(file, Negatives::kKeep, RglSpectral::kRgb);
    ASSERT_FALSE(colours.ok());
    EXPECT_EQ(colours.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(colours.error().message, HasSubstr("nm"));
  }
}

TEST(RglSpectral, RejectsEveryTruncatedPrefixAndBadWavelengths) {
  const Bytes file = emit(spectral_fields({430, 550.5, 670}));
  ASSERT_TRUE(load_rgl(file).ok());
  for (std::size_t size = 0; size < file.size(); ++size) ASSERT_FALSE(load_rgl(prefix_of(file, size)).ok()) << size;
  for (const std::vector<float>& wavelengths :
       {std::vector<float>{430, 430, 670}, {0, 500, 600}, {430, 550}, {700, 600, 500}, {430, 500, NAN}}) {
    const auto bad = load_rgl(emit(spectral_fields(wavelengths)));
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error().code, ErrorCode::kInvalidFile);
  }
}

TEST(RglSpectral, NamesAPolarisedMaterial) {
  const std::vector<Field> fields = {floats("theta_h", {1}, {0}), floats("wvls", {1}, {500}),
                                     floats("M", {1, 4, 4}, std::vector<float>(16))};
  const auto source = load_rgl(emit(fields));
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(source.error().message, HasSubstr("polarised"));
}

TEST(RglSpectral, NamesOfChannelsAreWavelengths) {
  const std::vector<std::string> names = {"400 nm", "450.5 nm", "1e3 nm"};
  EXPECT_EQ(wavelengths_of_channels(names), (std::vector<float>{400, 450.5F, 1000}));
  for (const std::vector<std::string>& other :
       {std::vector<std::string>{"R"}, {"400"}, {"500 nm", "400 nm"}, {"-1 nm"}, {"400 nm", "x nm"}}) {
    EXPECT_EQ(wavelengths_of_channels(other), std::nullopt);
  }
}

}  // namespace
}  // namespace sbrdf::internal::rgl_testing
