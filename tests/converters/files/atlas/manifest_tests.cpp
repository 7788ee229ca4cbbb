// Manifests of atlases: what is written is read again, and what is wrong is refused, whatever it is.
#include "converters/files/atlas/manifest.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/bake.h"
#include "codec/atlas/part/reached_cells.h"
#include "codec/atlas/texel_range.h"
#include "converters/files/atlas/atlas_file.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/container.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"
#include "tests/converters/in_folder.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

/// Of directions up to a theta, if one is given, the others left out, in a dense table.
Atlas bake(const FrameSpec& spec, DomainKind domain, bool blocks, TexelRange range, double theta_max_deg = 0) {
  const SampledBrdf sampled = sample_function(
      spec, 100, domain,
      [&](const DirectionPair& pair, std::size_t channel) {
        return analytic_brdf(pair, spec.symmetries) * (1 + static_cast<double>(channel));
      },
      3);
  const AtlasLayout axes = atlas_axes(sampled.lattice);
  ReachedCells reach(axes);
  reach.add_up_to(theta_max_deg);
  const AtlasCells cells = theta_max_deg > 0 ? reach.cells() : AtlasCells();
  Atlas atlas = bake_atlas(sampled.sliced, sampled.lattice,
                           {.tolerance = 0.05, .blocks = blocks, .dense = theta_max_deg > 0, .cells = cells})
                    .value();
  use_range(atlas, range);
  return atlas;
}

/// With and without rings, blocks, scales for each tile, and mirrors; the first is the smallest.
const std::vector<Atlas>& atlases() {
  static const std::vector<Atlas> kMade = {
      bake(elevation_frame(40, 180, {.isotropic = true, .mirror_x = true}).value(), DomainKind::kLog, false,
           TexelRange::kUnsigned),
      bake(elevation_frame(40, 180, {}).value(), DomainKind::kLog, true, TexelRange::kSigned),
      bake(half_difference_frame({0, 10, 40}, {0, 40}, {0, 90, 180, 270}, {0, 90}, {.mirror_x = true}),
           DomainKind::kLinear, false, TexelRange::kUnsigned),
      bake(half_difference_frame({0, 5, 40}, {0, 15, 40}, {0}, {0, 90}, {.isotropic = true, .mirror_x = true}),
           DomainKind::kLog, true, TexelRange::kAsIs),
      bake(half_difference_frame({0, 5, 40}, {0, 15, 40}, {0}, {0, 90}, {.isotropic = true, .mirror_x = true}),
           DomainKind::kLog, false, TexelRange::kUnsigned, 10),
  };
  return kMade;
}

const AtlasFiles kFiles = {"leaf.exr", "leaf.glsl", TexelFormat::kRgb32f, 4711};

Json manifest_of(const Atlas& atlas) { return Json::parse(emit_manifest(atlas, kFiles, {{"note", "more"}})); }

void expect_same(const Atlas& a, const Atlas& b) {
  EXPECT_EQ(a.layout.frame, b.layout.frame);
  EXPECT_EQ(a.layout.symmetries, b.layout.symmetries);
  EXPECT_EQ(a.layout.theta_max_deg, b.layout.theta_max_deg);
  EXPECT_EQ(a.layout.blocks, b.layout.blocks);
  EXPECT_EQ(a.layout.cells, b.layout.cells);
  EXPECT_EQ(a.layout.width, b.layout.width);
  EXPECT_EQ(a.layout.height, b.layout.height);
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    EXPECT_EQ(a.layout.axes[axis].nodes_deg, b.layout.axes[axis].nodes_deg);
    EXPECT_EQ(a.layout.axes[axis].texels, b.layout.axes[axis].texels);
    EXPECT_EQ(a.layout.axes[axis].root_spacing, b.layout.axes[axis].root_spacing);
  }
  // And what follows from these, scales, and values, to the last bit.
  ASSERT_EQ(b.layout.tables.size(), a.layout.tables.size());
  ASSERT_EQ(b.scales.size(), a.scales.size());
  Atlas with_texels = b;
  with_texels.texels = a.texels;
  const AtlasEvaluator before(a);
  const AtlasEvaluator after(with_texels);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(0, kPi / 2);
  for (int k = 0; k < 500; ++k) {
    const DirectionPair pair = {{angle(random), 4 * angle(random)}, {angle(random), 4 * angle(random)}};
    std::array<float, 3> expected{};
    std::array<float, 3> values{};
    before.evaluate(pair, expected);
    after.evaluate(pair, values);
    ASSERT_EQ(values, expected);
  }
}

TEST(Manifest, ComesBackAsItWasWritten) {
  for (const Atlas& atlas : atlases()) {
    const std::string text = emit_manifest(atlas, kFiles, {{"note", "more"}});
    EXPECT_TRUE(recognises_manifest(text));
    const Result<AtlasManifest> read = parse_manifest(text);
    ASSERT_TRUE(read) << read.error().message;
    expect_same(atlas, read->atlas);
    EXPECT_EQ(read->files.texture, "leaf.exr");
    EXPECT_EQ(read->files.shader, "leaf.glsl");
    EXPECT_EQ(read->files.texel, TexelFormat::kRgb32f);
    EXPECT_EQ(read->files.texture_bytes, 4711U);
    EXPECT_EQ(read->json["note"], "more");
    EXPECT_EQ(emit_manifest(read->atlas, read->files, {{"note", "more"}}), text);
  }
}

TEST(Manifest, IsReadInAnyOrderOfMembersAndWithWhitespace) {
  for (const Atlas& atlas : atlases()) {
    const nlohmann::json sorted = nlohmann::json::parse(manifest_of(atlas).dump());
    EXPECT_TRUE(recognises_manifest("\n " + manifest_of(atlas).dump(1)));
    EXPECT_FALSE(recognises_manifest(R"({"sbrdf": "material"})"));
    EXPECT_FALSE(recognises_manifest(R"({"sbrdf")"));
    for (const int indent : {-1, 2}) {
      const Result<AtlasManifest> read = parse_manifest(sorted.dump(indent));
      ASSERT_TRUE(read) << read.error().message;
      expect_same(atlas, read->atlas);
    }
  }
}

/// Calls `visit(place, parent, key)` for all members and elements, however deep.
void for_each_place(const Json& json, const Json::json_pointer& at,
                    const std::function<void(const Json::json_pointer&)>& visit) {
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) {
    const Json::json_pointer place = json.is_array() ? at / std::stoul(key) : at / key;
    visit(place);
    for_each_place(value, place, visit);
  }
}

/// Whatever is accepted has to be fit for evaluation with any texels.
void expect_safe(const Result<AtlasManifest>& read, const std::string& what) {
  if (!read) {
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidFile) << what;
    return;
  }
  Atlas atlas = read->atlas;
  ASSERT_LE(std::size_t{atlas.layout.width} * atlas.layout.height, std::size_t{1} << 20U) << what;
  const std::size_t count = std::size_t{atlas.layout.width} * atlas.layout.height * 3;
  for (const float texel : {0.0F, 1.0F, -3e38F, 3e38F}) {
    atlas.texels.assign(count, texel);
    for (std::size_t k = 0; k < count; k += 7) atlas.texels[k] = -texel;
    const AtlasEvaluator evaluator(atlas);
    for (const double theta_i : {0.0, 0.1, 0.7, kPi / 2}) {
      for (const double theta_v : {0.0, 0.4, kPi / 2}) {
        for (const double phi : {0.0, 1.0, 3.3, 6.2}) {
          std::array<float, 3> values{};
          evaluator.evaluate({{theta_i, 0.5}, {theta_v, phi}}, values);
          for (const float v : values) ASSERT_TRUE(std::isfinite(v)) << what;
        }
      }
    }
  }
}

TEST(Manifest, IsRefusedWithoutAnyOfItsMembers) {
  for (const Atlas& atlas : atlases()) {
    const Json whole = manifest_of(atlas);
    int removed = 0;
    for_each_place(whole, Json::json_pointer(""), [&](const Json::json_pointer& place) {
      if (place.to_string() == "/note") return;
      Json json = whole;
      Json& parent = json.at(place.parent_pointer());
      if (parent.is_array()) {
        parent.erase(std::stoul(place.back()));
      } else {
        parent.erase(place.back());
      }
      const Result<AtlasManifest> read = parse_manifest(json.dump());
      EXPECT_FALSE(read) << place.to_string();
      if (read) return;
      ++removed;
      EXPECT_EQ(read.error().code, ErrorCode::kInvalidFile);
      EXPECT_THAT(read.error().message, HasSubstr("'")) << "the member is named";
      // Without these more texels would be there, and the texture has other sides.
      const bool optional = place.back() == "cells" || place.back() == "dense_along";
      const std::string named = optional ? "texture" : place.back();
      if (place.parent_pointer().empty()) {
        EXPECT_THAT(read.error().message, HasSubstr("'" + named + "'"));
      }
    });
    EXPECT_GT(removed, 60);
  }
}

TEST(Manifest, IsRefusedOrSafeWithAnyMemberReplaced) {
  const double kHuge = std::numeric_limits<double>::max();
  const std::vector<Json> others = {nullptr,
                                    "text",
                                    true,
                                    -1,
                                    0,
                                    0.5,
                                    kHuge,
                                    -kHuge,
                                    1e38,
                                    -3e38,
                                    1e-45,
                                    65536,
                                    4097,
                                    18446744073709551615ULL,
                                    Json::array(),
                                    Json::object(),
                                    Json::array({1, 2, 3, 4}),
                                    Json::array({nullptr}),
                                    "../../a"};
  for (const Atlas& atlas : atlases()) {
    const Json whole = manifest_of(atlas);
    for_each_place(whole, Json::json_pointer(""), [&](const Json::json_pointer& place) {
      if (place.to_string() == "/note" || testing::Test::HasFatalFailure()) return;
      for (const Json& other : others) {
        Json json = whole;
        json.at(place) = other;
        const std::string what = place.to_string() + " = " + other.dump();
        const Result<AtlasManifest> read = parse_manifest(json.dump());
        const bool number = whole.at(place).is_number() && other.is_number();
        const bool same_kind = number || whole.at(place).type() == other.type();
        if (!same_kind) {
          EXPECT_FALSE(read) << what;
        }
        expect_safe(read, what);
      }
    });
  }
}

TEST(Manifest, IsRefusedWithNumbersThatNoJsonHas) {
  const std::string text = emit_manifest(atlases()[0], kFiles, {});
  for (const char* number : {"NaN", "nan", "Infinity", "-inf", "1e999", "0x10", "01", "1."}) {
    const std::string with = std::string("\"theta_max_deg\":") + number;
    std::string changed = text;
    const std::size_t at = changed.find("\"theta_max_deg\":80.0");
    ASSERT_NE(at, std::string::npos);
    changed.replace(at, std::string("\"theta_max_deg\":80.0").size(), with);
    EXPECT_FALSE(parse_manifest(changed)) << number;
  }
}

TEST(Manifest, NamesFilesOfItsOwnFolderOnly) {
  for (const std::string& name :
       {std::string("a/b.exr"), std::string("../a.exr"), std::string("/a.exr"), std::string("a\\b.exr"), std::string(),
        std::string("."), std::string(".."), std::string("a.exr\0b", 7), std::string("a/")}) {
    for (const char* place : {"/texture/file", "/shader"}) {
      Json json = manifest_of(atlases()[0]);
      json.at(Json::json_pointer(place)) = name;
      const Result<AtlasManifest> read = parse_manifest(json.dump());
      ASSERT_FALSE(read) << place << " " << name;
      EXPECT_THAT(read.error().message, HasSubstr("no plain file name"));
    }
  }
}

TEST(Manifest, IsRefusedForOtherTables) {
  Json json = manifest_of(atlases()[1]);
  json["tables"][1]["x"] = 4;
  EXPECT_THAT(parse_manifest(json.dump()).error().message, HasSubstr("'tables' does not follow"));
  json = manifest_of(atlases()[1]);
  json["ring"]["y"] = 0;
  EXPECT_THAT(parse_manifest(json.dump()).error().message, HasSubstr("'ring' does not follow"));
  json = manifest_of(atlases()[1]);
  json["texture"]["width"] = json["texture"]["width"].get<int>() + 4;
  EXPECT_THAT(parse_manifest(json.dump()).error().message, HasSubstr("other sides"));
  json = manifest_of(atlases()[1]);
  json["version"] = 2;
  EXPECT_THAT(parse_manifest(json.dump()).error().message, HasSubstr("'version' is not 1"));
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  all.reserve(text.size() * times);
  for (std::size_t k = 0; k < times; ++k) all += text;
  return all;
}

/// So deep that recursion would overflow the stack, in several places; so many members that looking for each would not
/// end.
TEST(Manifest, IsRefusedInNoTimeWhereItIsDeepOrFull) {
  constexpr std::size_t kMany = std::size_t{1} << 19U;
  const auto begun = std::chrono::steady_clock::now();
  const std::string text = emit_manifest(atlases()[1], kFiles, {});
  std::vector<std::string> nasty = {repeated("[", kMany), repeated("[", kMany) + repeated("]", kMany),
                                    repeated("{\"a\":", kMany), "[" + repeated("0,", kMany) + "0]"};
  std::string members = "{\"sbrdf\":\"atlas\"";
  for (std::size_t k = 0; k < kMany; ++k) members += ",\"" + std::to_string(k) + "\":0";
  nasty.push_back(members + "}");
  for (const char* place : {"\"tables\":[{", "\"ring\":{", "\"shader\":", "\"axes\":[", "\"values\":{"}) {
    const std::size_t at = text.find(place);
    ASSERT_NE(at, std::string::npos) << place;
    const std::string before = text.substr(0, at + std::string(place).size());
    const bool member = before.back() == '{';
    nasty.push_back(before + (member ? "\"a\":" : "") + repeated("[", kMany) + repeated("]", kMany) + "," +
                    text.substr(before.size()));
  }
  for (const std::string& each : nasty) {
    const Result<AtlasManifest> read = parse_manifest(each);
    ASSERT_FALSE(read) << each.substr(0, 60);
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidFile);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(60));
}

TEST(Manifest, IsRefusedWhereAxesAskForATextureThatNobodyHas) {
  Json nodes = Json::array();
  Json texels = Json::array();
  for (int k = 0; k < 4096; ++k) {
    nodes.push_back(k * 0.01);
    texels.push_back(k * 16);
  }
  Json json = manifest_of(atlases()[1]);
  for (Json& axis : json["frame"]["axes"]) {
    axis["nodes_deg"] = nodes;
    axis["texels"] = texels;
  }
  const Result<AtlasManifest> read = parse_manifest(json.dump());
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("no texture of 16384 x 16384"));
}

TEST(Manifest, IsRefusedOrSafeWhereverItsTextIsCutOrABitIsFlipped) {
  for (const std::size_t which : {0U, 2U}) {
    const std::string text = emit_manifest(atlases()[which], kFiles, {});
    for (std::size_t size = 0; size + 1 < text.size(); size += 13) {
      EXPECT_FALSE(parse_manifest(text.substr(0, size))) << size;
    }
    std::mt19937 random(2);
    for (int k = 0; k < 3000 && !testing::Test::HasFatalFailure(); ++k) {
      std::string changed = text;
      const std::size_t at = random() % text.size();
      changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 7));
      expect_safe(parse_manifest(changed), std::to_string(at));
    }
  }
}

TEST(Manifest, IsWrittenWhateverBytesNamesHave) {
  const std::string text = emit_manifest(atlases()[0], kFiles, {{"source", {{"name", "caf\xe9.binary"}}}});
  const Result<AtlasManifest> read = parse_manifest(text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->json["source"]["name"], "caf\xEF\xBF\xBD.binary");
}

Texture texture_of(TexelFormat format, std::uint32_t width, std::uint32_t height, std::span<const float> texels) {
  TexelCounts counts;
  return encode_texels(format, width, height, texels, counts).value();
}

std::string error_of(const std::shared_ptr<InFolder>& folder) {
  const Result<std::unique_ptr<BrdfSource>> opened = open_atlas(folder, {});
  return opened ? "" : opened.error().message;
}

TEST(AtlasFile, IsRefusedWithTexelsOfAnotherTexture) {
  const Atlas& atlas = atlases()[1];
  const Texture texture = texture_of(TexelFormat::kRgb32f, atlas.layout.width, atlas.layout.height, atlas.texels);
  AtlasFiles files = kFiles;
  files.texels_crc32 = checksum(std::as_bytes(std::span(texture.bytes)));
  const auto folder = std::make_shared<InFolder>(emit_manifest(atlas, files, {}));
  folder->files["leaf.exr"] = write_exr_texture(texture).value();
  EXPECT_EQ(error_of(folder), "");
  Texture other = texture;
  other.bytes[0] ^= 1U;
  folder->files["leaf.exr"] = write_exr_texture(other).value();
  EXPECT_THAT(error_of(folder), HasSubstr("leaf.exr has other texels"));
}

TEST(AtlasFile, IsOpenedWithTheTextureThatBelongsToIt) {
  const Atlas& atlas = atlases()[1];
  const auto folder = std::make_shared<InFolder>(emit_manifest(atlas, kFiles, {}));
  EXPECT_THAT(error_of(folder), HasSubstr("leaf.exr, is not in its folder"));
  const auto [width, height] = std::pair(atlas.layout.width, atlas.layout.height);
  const Texture texture = texture_of(TexelFormat::kRgb32f, width, height, atlas.texels);
  folder->files["leaf.exr"] = write_exr_texture(texture).value();
  const Result<std::unique_ptr<BrdfSource>> opened = open_atlas(folder, {});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  const DirectionPair pair = {{0.5, 0.3}, {0.9, 2}};
  std::array<float, 3> expected{};
  std::array<float, 3> values{};
  AtlasEvaluator(atlas).evaluate(pair, expected);
  (*opened)->evaluate(std::span(&pair, 1), values);
  EXPECT_EQ(values, expected);
}

TEST(AtlasFile, IsRefusedWithAnotherTexture) {
  const Atlas& atlas = atlases()[1];
  const auto folder = std::make_shared<InFolder>(emit_manifest(atlas, kFiles, {}));
  std::vector<std::byte>& file = folder->files["leaf.exr"];
  const auto [width, height] = std::pair(atlas.layout.width, atlas.layout.height);
  std::vector<float> longer = atlas.texels;
  longer.resize(std::size_t{width} * (height + 4) * 3);
  file = write_exr_texture(texture_of(TexelFormat::kRgb32f, width, height + 4, longer)).value();
  EXPECT_THAT(error_of(folder), HasSubstr("leaf.exr has "));
  EXPECT_THAT(error_of(folder), HasSubstr("and the manifest says " + std::to_string(width)));
  file = write_ktx2(texture_of(TexelFormat::kRgba16f, width, height, atlas.texels), {}).value();
  EXPECT_THAT(error_of(folder), HasSubstr("leaf.exr has rgba16f texels, and the manifest says rgb32f"));
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Texture texture = texture_of(TexelFormat::kRgb32f, width, height, atlas.texels);
    const std::size_t texel = std::size_t{width} + 2;
    std::memcpy(texture.bytes.data() + texel * 12 + 4, &wrong, sizeof wrong);
    file = write_exr_texture(texture).value();
    EXPECT_THAT(error_of(folder), HasSubstr("not finite, at column 2 of row 1"));
  }
  file = write_exr_texture(texture_of(TexelFormat::kRgb32f, width, height, atlas.texels)).value();
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, file.size() / 2, file.size() - 1}) {
    const std::vector<std::byte> whole = file;
    file.resize(size);
    EXPECT_THAT(error_of(folder), HasSubstr("leaf.exr")) << size;
    file = whole;
  }
}

}  // namespace
}  // namespace sbrdf::internal
