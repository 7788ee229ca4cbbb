#include "converters/slicing/metadata_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace sbrdf::internal {
namespace {

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  for (; times > 0; --times) all += text;
  return all;
}

std::string nested(std::size_t depth) { return repeated("[", depth) + repeated("]", depth); }

std::string list_of(std::size_t count) { return "[0" + repeated(",0", count - 1) + "]"; }

TEST(ParseMetadata, GivesTheValuesOfAnOrdinaryText) {
  const auto json = parse_metadata(R"({"a": [1, -2.5, true, null], "b": {"c": "d"}})");
  EXPECT_EQ(json["a"].size(), 4U);
  EXPECT_EQ(json["b"]["c"], "d");
}

TEST(ParseMetadata, GivesOneStringForWhatIsNoJson) {
  for (const std::string text : {"", "{", "[1,]", "nothing", "{} {}", "\xff\xfe"}) {
    EXPECT_TRUE(parse_metadata(text).is_string()) << text;
  }
}

TEST(ParseMetadata, GivesOneStringForWhatIsNestedTooDeep) {
  EXPECT_TRUE(parse_metadata(nested(64)).is_array());
  EXPECT_TRUE(parse_metadata(nested(65)).is_string());
  EXPECT_TRUE(parse_metadata(nested(8'000'000)).is_string());
  EXPECT_TRUE(parse_metadata(repeated(R"({"a":)", 1000)).is_string());
}

TEST(ParseMetadata, GivesOneStringForTooManyValues) {
  EXPECT_TRUE(parse_metadata(list_of(4095)).is_array());  // the list is a value too
  EXPECT_TRUE(parse_metadata(list_of(4096)).is_string());
  EXPECT_TRUE(parse_metadata(list_of(8'000'000)).is_string());
  std::string keys = "{";
  for (int k = 0; k < 100'000; ++k) keys += "\"" + std::to_string(k) + "\":0,";
  EXPECT_TRUE(parse_metadata(keys + R"("":0})").is_string());
}

}  // namespace
}  // namespace sbrdf::internal
