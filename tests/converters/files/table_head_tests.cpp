#include "converters/files/dense/table_head.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace sbrdf::internal {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TableHead some_head() {
  TableHead head;
  head.grid.frame = GridFrame::kMirror;
  head.grid.axes = {GridAxis({0, 1.0 / 3, 100.1}, Ends::kMirrored), GridAxis({0, 30, 60.000000000000007}),
                    GridAxis({0, 90, 180, 270}, Ends::kFullTurn),
                    GridAxis({0, 1e-300, 179}, Ends::kHeld, Spacing::kRoot)};
  head.channels = {"400 nm", "\"Y\", %"};
  head.type = ValueType::kFloat64;
  return head;
}

TEST(TableHead, ComesBackToTheLastBit) {
  for (const char* report : {"", R"({"findings":[],"remarks":[{"key":"a","value":1.5,"text":"b"}]})"}) {
    TableHead head = some_head();
    head.report = report;
    const std::string text = emit_table_head(head);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    EXPECT_TRUE(begins_table_head(" " + text));
    const auto back = parse_table_head(text + "   ");
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->grid, head.grid);
    EXPECT_EQ(back->channels, head.channels);
    EXPECT_EQ(back->type, ValueType::kFloat64);
  }
}

TEST(TableHead, SaysInWordsWhatTheNumbersAre) {
  const Json json = Json::parse(emit_table_head(some_head()));
  EXPECT_EQ(json["sbrdf"], "dense table");
  EXPECT_EQ(json["frame"], "mirror");
  EXPECT_EQ(json["axes"][3]["name"], "radius");
  EXPECT_EQ(json["axes"][3]["unit"], "degree");
  EXPECT_EQ(json["axes"][3]["spacing"], "root");
  EXPECT_EQ(json["axes"][2]["ends"], "360");
  EXPECT_EQ(json["quantity"], "f_r, without cosine");
  EXPECT_EQ(json["unit"], "1/sr");
  EXPECT_EQ(json["unmeasured"], "NaN");
  EXPECT_FALSE(json.contains("report"));
}

TEST(TableHead, IsReadWhateverElseItHolds) {
  Json json = Json::parse(emit_table_head(some_head()));
  json["made by"] = {"hand"};
  json["axes"][0]["colour"] = "red";
  json.erase("type");
  EXPECT_TRUE(parse_table_head(json.dump(2)).ok());
}

ErrorCode code_after(const std::function<void(Json&)>& change) {
  Json json = Json::parse(emit_table_head(some_head()));
  change(json);
  const auto head = parse_table_head(json.dump());
  if (head.ok()) {
    ADD_FAILURE() << json.dump();
    return ErrorCode::kUsage;
  }
  EXPECT_THAT(head.error().message, HasSubstr("description of the table"));
  return head.error().code;
}

TEST(TableHead, RefusesWhatIsMissingOrCannotBe) {
  for (const char* name : {"sbrdf", "version", "frame", "axes", "channels", "quantity", "unit", "unmeasured"}) {
    EXPECT_EQ(code_after([&](Json& json) { json.erase(name); }), ErrorCode::kInvalidFile) << name;
  }
  for (const char* name : {"name", "unit", "ends", "spacing", "nodes"}) {
    EXPECT_EQ(code_after([&](Json& json) { json["axes"][1].erase(name); }), ErrorCode::kInvalidFile) << name;
  }
  const auto with_nodes = [](const Json& nodes) {
    return code_after([&](Json& json) { json["axes"][1]["nodes"] = nodes; });
  };
  for (const Json& nodes : {Json::array(), Json({30, 0}), Json({0, 0}), Json({-1, 5}), Json({0, 91}), Json({"0"}),
                            Json({nullptr}), Json(5), Json::array({true})}) {
    EXPECT_EQ(with_nodes(nodes), ErrorCode::kInvalidFile) << nodes;
  }
  EXPECT_EQ(with_nodes(Json(std::vector<int>(70000))), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["axes"][1]["ends"] = "360"; }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["axes"][0]["ends"] = "extrapolated"; }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { std::swap(json["axes"][0], json["axes"][1]); }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["axes"].push_back(json["axes"][0]); }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["channels"] = Json::array(); }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["channels"] = {"a", "a"}; }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["channels"] = {""}; }), ErrorCode::kInvalidFile);
  EXPECT_EQ(code_after([](Json& json) { json["version"] = 2; }), ErrorCode::kUnsupported);
  EXPECT_EQ(code_after([](Json& json) { json["unit"] = "1"; }), ErrorCode::kUnsupported);
  EXPECT_EQ(code_after([](Json& json) { json["quantity"] = "f_r cos"; }), ErrorCode::kUnsupported);
}

TEST(TableHead, RefusesMoreNodesThanAnyTableHas) {
  std::vector<double> many(65536);
  for (std::size_t k = 0; k < many.size(); ++k) many[k] = static_cast<double>(k) / 1000;
  EXPECT_EQ(code_after([&](Json& json) {
              for (Json& axis : json["axes"]) {
                axis["nodes"] = many;
                axis["ends"] = "held";
                axis["spacing"] = "angle";
              }
            }),
            ErrorCode::kInvalidFile);
}

TEST(TableHead, RefusesWhatIsNoJsonAndEveryTruncation) {
  const std::string text = emit_table_head(some_head());
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_FALSE(parse_table_head(text.substr(0, size)).ok()) << size;
  for (const char* other : {"[]", "null", "1", "{}", "{\"sbrdf\": 1}", "\xFF", "{\"sbrdf\":\"dense table\"} x"}) {
    EXPECT_FALSE(parse_table_head(other).ok()) << other;
    EXPECT_FALSE(begins_table_head(other) && std::string_view(other).starts_with("[")) << other;
  }
  EXPECT_EQ(parse_table_head(std::string(kLongestTableHead + 1, ' ')).error().code, ErrorCode::kUnsupported);
  EXPECT_FALSE(parse_table_head(std::string(1000000, '[')).ok());
}

}  // namespace
}  // namespace sbrdf::internal
