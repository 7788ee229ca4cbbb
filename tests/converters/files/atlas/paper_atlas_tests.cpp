#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "converters/files/atlas/manifest.h"
#include "converters/files/atlas/paper/make_paper.h"
#include "converters/files/atlas/paper/paper_manifest.h"
#include "converters/models/analytic.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

DecodedSliced sliced_of(const BrdfSource& source, const Placement& placement, std::uint64_t samples) {
  SliceOptions options;
  options.stop = SampleCount{samples};
  options.structure = placement;
  options.domain = DomainKind::kLog;
  options.fit_values = false;
  options.precision = 0.001;
  Result<Slicing> slicing = slice_source(source, options);
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing.value().sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
}

struct KurtCase {
  std::string name;
  double mre_percent, rel_l1_percent;  ///< at most, against the slices
};

/// What these are off their slices is nearly all at theta_i below the first elevation, 14 degrees (see PaperEvaluator).
TEST(PaperAtlas, OfKurtMaterialsIsNearTheirSlices) {
  for (const auto& [name, mre, rel_l1] :
       {KurtCase{"wood01", 0.2, 0.2}, KurtCase{"fabric112", 0.5, 0.5}, KurtCase{"Brushed alum", 2, 18}}) {
    const auto source = make_analytic_source(kurt_material(name).value());
    const DecodedSliced sliced = sliced_of(*source, {14, 36}, 8911);
    const Result<MadePaper> made =
        make_paper(sliced, *source, {.texel = TexelFormat::kRgb32f, .container = AtlasContainer::kExr});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->texel_bytes(), 284'571U * 12);
    EXPECT_LE(made->errors.mre_percent, mre) << name;
    EXPECT_LE(made->errors.rel_l1_percent, rel_l1) << name;
    EXPECT_GT(made->errors.mre_percent, mre / 10) << name;  // a bound that says something
  }
}

TEST(PaperAtlas, TakesHalfFloatsWhereTheyFitAndSaysWhereNot) {
  const auto source = make_analytic_source(kurt_material("fabric112").value());
  DecodedSliced sliced = sliced_of(*source, {28, 180}, 300);
  const AtlasOptions half = {.texel = TexelFormat::kRgba16f, .container = AtlasContainer::kKtx2};
  const AtlasOptions full = {.texel = TexelFormat::kRgb32f, .container = AtlasContainer::kDds};
  const MadePaper rounded = make_paper(sliced, *source, half).value();
  const MadePaper exact = make_paper(sliced, *source, full).value();
  EXPECT_EQ(exact.packed.front().format, TexelFormat::kRgba32f);
  EXPECT_NEAR(rounded.errors.mre_percent, exact.errors.mre_percent, 0.1);
  sliced.sliced.domain = {};
  sliced.sliced.domain.kind = DomainKind::kLinear;
  for (float& value : sliced.sliced.crossing_values) value = 1e5F;
  const Result<MadePaper> beyond = make_paper(sliced, *source, half);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(make_paper(sliced, *source, full));
}

TEST(PaperAtlas, RefusesTexelsWithoutASign) {
  for (const TexelFormat texel : {TexelFormat::kE5b9g9r9, TexelFormat::kBc6hUnsigned}) {
    const Status status = check_paper_options({.texel = texel, .container = AtlasContainer::kKtx2});
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kUsage);
  }
}

PaperTextures small_textures() {
  PaperTextures textures;
  textures.elevations_deg = {28, 56, 80};
  textures.azimuth_count = 2;
  textures.at_normal = {0.5F, -1.25F, 3};
  textures.domain.most = {9, 9, 9};
  textures.domain.reference = textures.domain.floor = {1, 1, 1};
  EXPECT_TRUE(lay_out_paper(textures));
  return textures;
}

Json small_manifest() {
  const PaperFiles files = {{"a.exr", "b.exr", "c.exr", "d.exr"}, {1, 2, 3, 4}, TexelFormat::kRgb32f};
  return Json::parse(emit_paper_manifest(small_textures(), files, {{"errors", 1}}));
}

TEST(PaperManifest, ComesBackAsItWasWritten) {
  const std::string text = manifest_text(small_manifest());
  EXPECT_TRUE(recognises_manifest(text));
  EXPECT_EQ(manifest_layout(text).value(), "paper");
  const Result<PaperManifest> read = parse_paper_manifest(text);
  ASSERT_TRUE(read) << read.error().message;
  const PaperTextures expected = small_textures();
  EXPECT_EQ(read->textures.elevations_deg, expected.elevations_deg);
  EXPECT_EQ(read->textures.azimuth_count, 2U);
  EXPECT_EQ(read->textures.at_normal, expected.at_normal);
  EXPECT_EQ(read->textures.texel_count(), expected.texel_count());
  EXPECT_EQ(read->files.names[3], "d.exr");
  EXPECT_FALSE(parse_manifest(text)) << "is no engine layout";
}

void expect_refused(const Json& json, const std::string& member) {
  const Result<PaperManifest> read = parse_paper_manifest(json.dump());
  ASSERT_FALSE(read) << member;
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidFile);
  EXPECT_NE(read.error().message.find("'" + member + "'"), std::string::npos) << read.error().message;
}

TEST(PaperManifest, RefusesEveryMissingMember) {
  const Json whole = small_manifest();
  for (const auto& [name, value] : whole.items()) {
    const bool needed = name != "first_row" && name != "filter" && name != "colour_space" && name != "errors";
    Json damaged = whole;
    damaged.erase(name);
    EXPECT_EQ(!parse_paper_manifest(damaged.dump()), needed) << name;
  }
}

TEST(PaperManifest, RefusesWhatCannotBeAndNamesIt) {
  const auto with = [](const char* pointer, const Json& value) {
    Json json = small_manifest();
    json[Json::json_pointer(pointer)] = value;
    return json;
  };
  expect_refused(with("/layout", "engine"), "layout");
  expect_refused(with("/frame/id", "half-difference"), "id");
  expect_refused(with("/frame/azimuth_count", 0), "azimuth_count");
  expect_refused(with("/frame/azimuth_count", 3), "crossings");
  expect_refused(with("/frame/azimuth_count", 4096), "frame");
  expect_refused(with("/frame/elevations_deg", Json::array()), "elevations_deg");
  expect_refused(with("/frame/elevations_deg", {28, 28, 80}), "elevations_deg");
  expect_refused(with("/frame/elevations_deg", {28, 56, 90}), "elevations_deg");
  expect_refused(with("/textures/axial/file", "../x.exr"), "file");
  expect_refused(with("/textures/axial/width", 17), "axial");
  expect_refused(with("/texel", "rgb8"), "texel");
  expect_refused(with("/at_normal", {1, 2}), "at_normal");
  expect_refused(with("/values/domain", "root"), "domain");
}

}  // namespace
}  // namespace sbrdf::internal
