#include "converters/slicing/metadata.h"

#include <cctype>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;
using testing::ElementsAreArray;

std::string trimmed(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '`'; });
  return text;
}

/// "key, type, unit" of each row of the table of keys in specs/sbrdf.md.
std::vector<std::string> rows_of_specification() {
  std::ifstream file(std::string(SBRDF_SOURCE_DIR) + "/specs/sbrdf.md");
  std::vector<std::string> rows;
  bool in_table = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| key |")) in_table = true;
    if (!line.starts_with("|")) in_table = false;
    if (!in_table || line.starts_with("|---") || line.starts_with("| key |")) continue;
    std::istringstream cells(line.substr(1));
    std::string row;
    for (int k = 0; k < 3; ++k) {
      std::string cell;
      std::getline(cells, cell, '|');
      row += (k > 0 ? ", " : "") + trimmed(cell);
    }
    rows.push_back(row);
  }
  return rows;
}

std::string path_of(const MetadataKey& key) {
  return (key.in.empty() ? "" : std::string(key.in) + ".") + std::string(key.name);
}

TEST(MetadataKeys, AreThoseOfTheSpecificationWithTypeAndUnit) {
  std::vector<std::string> expected;
  for (const MetadataKey& key : metadata_keys()) {
    expected.push_back(path_of(key) + ", " + std::string(metadata_type_name(key.type)) + ", " + std::string(key.unit));
  }
  EXPECT_GE(expected.size(), 20U);
  EXPECT_THAT(rows_of_specification(), ElementsAreArray(expected));
}

bool is_of(MetadataType type, const Json& value) {
  switch (type) {
    case MetadataType::kText:
      return value.is_string();
    case MetadataType::kNumber:
      return value.is_number() || value.is_null();
    case MetadataType::kCount:
      return value.is_number_unsigned();
    case MetadataType::kBoolean:
      return value.is_boolean();
    case MetadataType::kObject:
      return value.is_object();
    case MetadataType::kList:
      return value.is_array();
  }
  return false;
}

/// Where the members of an object under this key are listed.
std::string_view listed_under(std::string_view key) {
  if (key == "error_before_rounding" || key == "error_of_whole") return "error";
  return key == "extracted_before" ? "extracted" : key;
}

/// Checks the members of an object that stands under `in`, and those of its own objects; adds the paths to `seen`.
void check_members(std::string_view in, const Json& object, std::set<std::string>& seen) {
  for (const auto& [name, value] : object.items()) {
    const auto keys = metadata_keys();
    const auto row = std::find_if(keys.begin(), keys.end(),
                                  [&, &key = name](const MetadataKey& k) { return k.in == in && k.name == key; });
    ASSERT_NE(row, keys.end()) << in << "." << name;
    EXPECT_TRUE(is_of(row->type, value)) << path_of(*row) << ": " << value;
    seen.insert(path_of(*row));
    if (value.is_object()) check_members(listed_under(name), value, seen);
    if (!value.is_array()) continue;
    for (const Json& member : value) {
      if (member.is_object()) check_members(listed_under(name), member, seen);
    }
  }
}

std::string metadata_in(MetadataDetail detail) {
  SourceTraits traits;
  traits.format = "test";
  traits.description = "a source";
  traits.findings = {{"cells with a negative channel", 3, 10}};
  SliceOptions options;
  options.metadata = detail;
  options.source_sha256 = "0123456789abcdef0123456789abcdef";
  options.command = "sbrdf convert a b";
  SliceReport report;
  report.filled_samples = 2;
  report.error = {std::numeric_limits<double>::infinity(), 2.34567};
  report.error_values_all_zero = true;
  return metadata_of_slicing(traits, options, report);
}

std::string full_metadata() { return metadata_in(MetadataDetail::kFull); }

TEST(Metadata, OfLeanFilesTellWhatUsersMustKnow) {
  const std::string lean = metadata_in(MetadataDetail::kLean);
  EXPECT_EQ(lean, lean_metadata(full_metadata()));
  const Json json = Json::parse(lean);
  EXPECT_EQ(json["source"], Json::parse(R"({"format": "test", "sha256": "0123456789abcdef"})"));
  EXPECT_EQ(json["error"]["rel_l1_percent"], 2.346);
  EXPECT_EQ(json["findings"].size(), 1U);
  EXPECT_FALSE(json.contains("command"));
  EXPECT_EQ(metadata_in(MetadataDetail::kNone), "");
}

TEST(Metadata, HasTheKeysOfTheTableAndNoOthers) {
  const std::string sampled = full_metadata();
  const std::string copied = metadata_of_copy(sampled, 0.01);
  const std::string part = metadata_of_part(sampled, {40, 3, 1.5});
  std::set<std::string> seen;
  for (const std::string& text : {sampled, copied, part, metadata_of_part(part, {30, 2, 0.5})}) {
    check_members("", Json::parse(text), seen);
  }
  for (const MetadataKey& key : metadata_keys()) EXPECT_TRUE(seen.contains(path_of(key))) << path_of(key);
}

TEST(Metadata, OfACopyKeepsTheErrorUnderAnotherNameAndAllPrecisions) {
  const Json first = Json::parse(metadata_of_copy(full_metadata(), 0.01));
  EXPECT_FALSE(first.contains("error"));
  EXPECT_EQ(first["error_before_rounding"]["rel_l1_percent"], 2.346);
  EXPECT_EQ(first["coded_before_percent"], Json::parse("[1.0]"));
  const Json second = Json::parse(metadata_of_copy(first.dump(), 0.25));
  EXPECT_EQ(second["error_before_rounding"], first["error_before_rounding"]);
  EXPECT_EQ(second["coded_before_percent"], Json::parse("[1.0, 25.0]"));
}

TEST(Metadata, OfAPartOfAPartHasTheLesserOfBoth) {
  const std::string part = metadata_of_part(full_metadata(), {40, 3, 1.5});
  const Json json = Json::parse(metadata_of_part(part, {60, 2, 0.5}));
  EXPECT_FALSE(json.contains("error"));
  EXPECT_TRUE(json.contains("error_of_whole"));
  EXPECT_EQ(json["extracted"], Json::parse(R"({"theta_max_deg": 40.0, "max_level": 2,
                                               "difference_from_whole_percent": 0.5})"));
  EXPECT_EQ(json["extracted_before"][0]["theta_max_deg"], 40.0);
}

// Whoever wrote the file may have put anything anywhere.
TEST(Metadata, OfCopiesAndPartsTakesAnyTypeUnderAnyKey) {
  std::vector<std::string> names = {"other"};
  for (const MetadataKey& key : metadata_keys()) names.emplace_back(key.name);
  for (const std::string& name : names) {
    for (const char* value : {"null", "true", "1", "-1e300", R"("x")", "[]", "[[1]]", "{}", R"({"theta_max_deg":"x"})",
                              R"({"max_level":[]})", R"({"max_level":-1})"}) {
      const std::string text = R"({")" + name + R"(":)" + value + "}";
      EXPECT_TRUE(Json::parse(metadata_of_copy(text, 0.1)).is_object()) << text;
      const Json part = Json::parse(metadata_of_part(text, {40, 3, 1.5}));
      EXPECT_LE(part["extracted"]["theta_max_deg"], 40.0) << text;
      EXPECT_LE(part["extracted"]["max_level"], 3U) << text;
    }
  }
  for (const char* text : {"", "no JSON", "[]", "1", "{", "\xff"}) {
    EXPECT_EQ(metadata_of_copy(text, 0.1), text);
    EXPECT_EQ(Json::parse(metadata_of_part(text, {40, 3, 1.5})).size(), 1U) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
