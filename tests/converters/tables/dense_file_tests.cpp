#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/dense/table_head.h"
#include "formats/core/half.h"
#include "tests/support/dense_files.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using dense_files::awkward_table;
using dense_files::Bytes;
using dense_files::find_remark;
using dense_files::open;
using dense_files::same;
using dense_files::save;
using dense_files::values_of;
using testing::ElementsAre;
using testing::HasSubstr;

// What NPY, EXR and CSV files have in common.

const std::vector<std::string> kExtensions = {".npy", ".exr", ".csv"};

TEST(DenseFiles, GiveBackEveryFloatAndNodeWhateverWayTheyWent) {
  const auto table = awkward_table<float>();
  for (const std::string& first : kExtensions) {
    const auto saved = save(first, *table);
    ASSERT_TRUE(saved.ok()) << first << saved.error().message;
    EXPECT_NE(find_remark(saved->report, "same_nodes"), nullptr);
    EXPECT_EQ(find_remark(saved->report, "unmeasured_nodes")->value, 2);
    const auto opened = open(saved->files);
    ASSERT_TRUE(opened.ok()) << first << opened.error().message;
    EXPECT_EQ((*opened)->table()->grid, table->table()->grid) << first;
    EXPECT_EQ((*opened)->table()->type, ValueType::kFloat32) << first;
    EXPECT_THAT((*opened)->traits().channels, ElementsAre("R", "G", "B"));
    EXPECT_TRUE(same(values_of(**opened), values_of(*table))) << first;
    for (const std::string& second : kExtensions) {
      const auto again = open(save(second, **opened)->files);
      EXPECT_EQ((*again)->table()->grid, table->table()->grid) << first << second;
      EXPECT_TRUE(same(values_of(**again), values_of(*table))) << first << second;
    }
  }
}

TEST(DenseFiles, GiveBackEveryDoubleWhereTheyHaveThem) {
  const auto table = awkward_table<double>();
  for (const char* extension : {".npy", ".csv"}) {
    const auto opened = open(save(extension, *table)->files);
    ASSERT_TRUE(opened.ok()) << extension << opened.error().message;
    EXPECT_EQ((*opened)->table()->type, ValueType::kFloat64);
    EXPECT_TRUE(same(values_of(**opened), values_of(*table))) << extension;
  }
  const auto rounded = save(".exr", *table);
  EXPECT_NE(find_remark(rounded->report, "rounded_to_bits"), nullptr);
  EXPECT_EQ(find_remark(rounded->report, "vanished_numbers")->value, 2);  // the least double, and the least normal one
  const auto refused = save(".exr", *table, Options().set("type", "float64"));
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
}

TEST(DenseFiles, HoldHalvesWithWhatTheyLoseCounted) {
  const auto table = awkward_table<float>();
  const std::vector<double> before = values_of(*table);
  for (const std::string& extension : kExtensions) {
    const auto saved = save(extension, *table, Options().set("type", "float16"));
    ASSERT_TRUE(saved.ok()) << extension << saved.error().message;
    std::uint64_t vanished = 0;
    std::uint64_t clamped = 0;
    const auto opened = open(saved->files);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    EXPECT_EQ((*opened)->table()->type, ValueType::kFloat16) << extension;
    const std::vector<double> after = values_of(**opened);
    for (std::size_t k = 0; k < before.size(); ++k) {
      if (std::isnan(before[k])) continue;
      vanished += before[k] != 0 && after[k] == 0 ? 1 : 0;
      EXPECT_NEAR(after[k], std::min(before[k], kHalfLargest), 6e-8 + std::abs(before[k]) / 2000) << k;
    }
    for (std::size_t node = 0; node < before.size() / 3; ++node) {
      clamped += *std::max_element(&before[3 * node], &before[3 * node] + 3) > kHalfLargest ? 1 : 0;
    }
    EXPECT_GT(vanished, 0U);
    EXPECT_EQ(find_remark(saved->report, "vanished_numbers")->value, vanished) << extension;
    EXPECT_EQ(find_remark(saved->report, "clamped_nodes")->value, clamped) << extension;
    const auto again = save(extension, **opened);
    EXPECT_EQ(again->files.at(""), saved->files.at("")) << extension;
    for (const std::string& other : kExtensions) {
      EXPECT_EQ(find_remark(save(other, **opened)->report, "resampling_mre_percent"), nullptr) << extension << other;
    }
  }
}

TEST(DenseFiles, AreCopiedAsTheyAreUnlessSomethingElseIsAskedFor) {
  const auto table = awkward_table<float>();
  for (const std::string& extension : kExtensions) {
    auto files = save(extension, *table)->files;
    const auto opened = open(files);
    const auto copy = save(extension, **opened);
    EXPECT_NE(find_remark(copy->report, "copied"), nullptr) << extension;
    EXPECT_EQ(copy->files.at(""), files.at("")) << extension;
    const auto clamped = save(extension, **opened, Options().set("negatives", "clamp"));
    EXPECT_EQ(find_remark(clamped->report, "copied"), nullptr) << extension;
    const std::vector<double> values = values_of(**open(clamped->files));
    EXPECT_TRUE(std::none_of(values.begin(), values.end(), [](double v) { return v < 0; })) << extension;
    const auto read_clamped = open(files, Options().set("negatives", "clamp"));
    EXPECT_EQ(find_remark(save(extension, **read_clamped)->report, "copied"), nullptr) << extension;
    const auto other_grid = save(extension, **opened, Options().set("grid", "difference/0:30:30:60"));
    EXPECT_EQ((*open(other_grid->files))->traits().shape, (std::vector<std::uint32_t>{1, 4, 4, 6})) << extension;
    EXPECT_NE(find_remark(other_grid->report, "resampling_mre_percent"), nullptr) << extension;
  }
}

/// The description of a table whose azimuths are these, held at their ends.
std::string held_azimuths(const std::string& nodes) {
  const auto theta = [](const char* name) {
    return std::string(R"({"name": ")") + name +
           R"(", "unit": "degree", "ends": "held", "spacing": "angle", "nodes": [0, 90]})";
  };
  const auto phi = [&](const char* name) {
    return std::string(R"({"name": ")") + name +
           R"(", "unit": "degree", "ends": "held", "spacing": "angle", "nodes": )" + nodes + "}";
  };
  return R"({"sbrdf": "dense table", "version": 1, "frame": "angles", "axes": [)" + theta("theta_i") + ", " +
         phi("phi_i") + ", " + theta("theta_v") + ", " + phi("phi_v") +
         R"(], "channels": ["Y"], "quantity": "f_r, without cosine", "unit": "1/sr", "unmeasured": "NaN"})";
}

TEST(DenseFiles, CloseAzimuthsThatGoRound) {
  const Grid grid = {GridFrame::kAngles,
                     {GridAxis({0, 90}), GridAxis({0, 120, 240}), GridAxis({0, 90}), GridAxis({0, 120, 240})}};
  std::vector<float> values(36);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = 1 + static_cast<float>(k % 3);  // 1, 2, 3 along phi_v
  DenseDescription description;
  description.channels = {"Y"};
  const auto table = DenseSource::make(table_in_memory(grid, 1, std::move(values)), std::move(description)).value();
  const auto opened_with = [&](const std::string& nodes) {
    auto files = save(".npy", *table)->files;
    const std::string text = held_azimuths(nodes);
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    files[".json"] = Bytes(bytes.begin(), bytes.end());
    return open(files).value();
  };
  const auto value_at = [](const BrdfSource& source, double phi_v) {
    const DirectionPair pair = {direction_from_degrees(45, 0), direction_from_degrees(45, phi_v)};
    float value = 0;
    source.evaluate(std::span(&pair, 1), std::span(&value, 1));
    return value;
  };
  const auto closed = opened_with("[0, 120, 240]");
  EXPECT_FLOAT_EQ(value_at(*closed, 300), 2);  // between 3 and 1
  ASSERT_EQ(closed->traits().findings.size(), 2);
  EXPECT_THAT(closed->traits().findings[1].what, HasSubstr("nodes of phi_v go all the way round"));
  EXPECT_EQ(closed->table()->grid.axes[3].ends(), Ends::kFullTurn);
  EXPECT_EQ(find_remark(save(".npy", *closed)->report, "copied"), nullptr);  // the description is another one
  for (const char* nodes : {"[0, 60, 120]", "[0, 119, 240]", "[0, 120, 239]"}) {
    const auto held = opened_with(nodes);
    EXPECT_FLOAT_EQ(value_at(*held, 250), 3) << nodes;
    EXPECT_TRUE(held->traits().findings.empty()) << nodes;
  }
}

TEST(DenseFiles, SayWhyNoValueIsPositive) {
  const auto refusal = [](std::vector<double> values) {
    const Grid grid = {GridFrame::kAngles, {GridAxis({0, 45}), GridAxis({0}), GridAxis({0, 45}), GridAxis({0})}};
    DenseDescription description;
    description.channels = {"Y"};
    return DenseSource::make(table_in_memory(grid, 1, std::move(values)), std::move(description)).error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal({2e38, 2e38, 2e38, 0}), HasSubstr("3 of 4 nodes have one that is infinite or beyond 1e+38"));
  EXPECT_THAT(refusal({nan, nan, -1, -1}),
              HasSubstr("2 of 4 nodes above the horizon are unmeasured; 2 of 4 nodes have a "
                        "negative one"));
  EXPECT_EQ(refusal({0, 0, 0, 0}), "no value of the table is positive");
}

TEST(DenseFiles, HoldAnyNumberOfChannels) {
  std::vector<std::string> spectrum;
  for (int k = 0; k < 31; ++k) spectrum.push_back(std::to_string(900 + 10 * k) + " nm");
  for (const std::vector<std::string>& channels :
       {spectrum, {"Y"}, {"B", "G", "R", "a name of more than 31 characters, well"}}) {
    const auto table = awkward_table<float>(channels);
    for (const std::string& extension : kExtensions) {
      if (extension == ".csv" && channels.size() == 4) continue;
      const auto saved = save(extension, *table);
      ASSERT_TRUE(saved.ok()) << extension << saved.error().message;
      const auto opened = open(saved->files);
      ASSERT_TRUE(opened.ok()) << extension << opened.error().message;
      EXPECT_EQ((*opened)->traits().channels, channels) << extension;
      EXPECT_TRUE(same(values_of(**opened), values_of(*table))) << extension;
    }
  }
  EXPECT_EQ(save(".csv", *awkward_table<float>({"a,b"})).error().code, ErrorCode::kUnsupported);
}

TEST(DenseFiles, SayWhatInterpolationCostsAndCarryTheReport) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t c) {
    return (1 + static_cast<double>(c)) * std::exp(-pair.v.theta * pair.i.theta);
  });
  for (const std::string& extension : kExtensions) {
    const auto saved = save(extension, source, Options().set("grid", "30:90:30:90"));
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    ASSERT_NE(find_remark(saved->report, "resampling_rel_l1_percent"), nullptr);
    EXPECT_GT(find_remark(saved->report, "resampling_rel_l1_percent")->value, 0.1);
    std::string text;
    for (const auto& [suffix, bytes] : saved->files)
      text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_THAT(text, HasSubstr(R"("report":{"findings":[],"remarks":[{)")) << extension;
    EXPECT_THAT(text, HasSubstr(R"({"key":"nodes","value":256.0)")) << extension;
  }
}

TEST(DenseFiles, OfNothingButNumbersThatVanishAreNotWritten) {
  const FunctionSource faint([](const DirectionPair&, std::size_t) { return 1e-9; });
  for (const std::string& extension : kExtensions) {
    const auto saved = save(extension, faint, Options().set("grid", "30:90:30:90").set("type", "float16"));
    ASSERT_FALSE(saved.ok());
    EXPECT_THAT(saved.error().message, HasSubstr("positive as a float16 number"));
  }
}

TEST(DenseFiles, RefuseEveryTruncation) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return 0.1 + pair.v.theta; });
  for (const std::string& extension : kExtensions) {
    auto files = save(extension, source, Options().set("grid", "90:180:90:180"))->files;
    ASSERT_TRUE(open(files).ok());
    const Bytes whole = files.at("");
    // The last line of text may go without its end, and there the last digits may.
    const std::size_t end = whole.size() - (extension == ".csv" ? 20 : 0);
    for (std::size_t size = 0; size < end; ++size) {
      files[""] = Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(open(files).ok()) << extension << " " << size;
    }
  }
}

// ---- NPY ----

TEST(NpyFile, NeedsItsNodesFromSomewhere) {
  const auto table = awkward_table<float>();
  auto files = save(".npy", *table)->files;
  const Bytes array = files.at("");
  files.erase(".json");
  EXPECT_EQ(open(files).error().code, ErrorCode::kUsage);
  EXPECT_THAT(open(files).error().message, HasSubstr("--grid"));
  const auto told = open(files, Options().set("grid", "difference/0,100:0,0.25,60:5,80:0,1,180"));
  ASSERT_TRUE(told.ok()) << told.error().message;
  EXPECT_TRUE(same(values_of(**told), values_of(*table)));
  const auto copied = save(".npy", **told);
  EXPECT_EQ(copied->files.at(""), array);
  EXPECT_EQ((*open(copied->files))->table()->grid, (*told)->table()->grid);
  const auto other = open(files, Options().set("grid", "difference/0,100:0,0.25,60:5,80:0,1"));
  EXPECT_EQ(other.error().code, ErrorCode::kUsage);
  EXPECT_THAT(other.error().message, HasSubstr("(2, 3, 2, 3, 3)"));
}

TEST(NpyFile, RefusesAHeadOfAnotherArray) {
  auto files = save(".npy", *awkward_table<float>())->files;
  const auto other = save(".npy", *awkward_table<float>({"Y"}))->files;
  files[".json"] = other.at(".json");
  EXPECT_THAT(open(files).error().message, HasSubstr("not that of the .json file beside it"));
  files[".json"] = {std::byte{'{'}};
  EXPECT_THAT(open(files).error().message, HasSubstr("the .json file beside it: description of the table"));
  EXPECT_EQ(open(files).error().code, ErrorCode::kInvalidFile);
}

TEST(NpyFile, WithoutPlaceForItsHeadSaysSo) {
  MemorySink sink;
  Report report;
  ASSERT_TRUE(save_source(*find_writer(".npy").value(), *awkward_table<float>(), sink, {}, report).ok());
  EXPECT_NE(find_remark(report, "axes_lost"), nullptr);
}

// ---- EXR ----

TEST(ExrFile, OfUtiaSizeIsUtiasImage) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t) { return 1 + pair.i.theta + pair.v.phi / 10; });
  auto files = save(".exr", source, Options().set("grid", "utia"))->files;
  std::string text(reinterpret_cast<const char*>(files.at("").data()), files.at("").size());
  const std::size_t name = text.find("sbrdf");
  files.at("")[name] = std::byte{'x'};
  const auto opened = open(files);
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  EXPECT_EQ((*opened)->table()->grid, parse_grid("utia").value());
  EXPECT_THAT((*opened)->traits().findings.at(0).what, HasSubstr("UTIA"));
  EXPECT_THAT(open(files, Options().set("grid", "utia-dense")).error().message, HasSubstr("7920 x 7920"));
}

TEST(ExrFile, OfOtherSizeNeedsItsNodesFromSomewhere) {
  auto files = save(".exr", *awkward_table<float>())->files;
  std::string text(reinterpret_cast<const char*>(files.at("").data()), files.at("").size());
  files.at("")[text.find("sbrdf")] = std::byte{'x'};
  EXPECT_EQ(open(files).error().code, ErrorCode::kUsage);
  const auto told = open(files, Options().set("grid", "difference/0,100:0,0.25,60:5,80:0,1,180"));
  ASSERT_TRUE(told.ok()) << told.error().message;
  EXPECT_THAT((*told)->traits().channels, ElementsAre("R", "G", "B"));
  EXPECT_TRUE(same(values_of(**told), values_of(*awkward_table<float>())));
}

TEST(ExrFile, RefusesOtherKindsOfImages) {
  const auto files = save(".exr", *awkward_table<float>())->files;
  const auto with_byte = [&](std::size_t at, int value) {
    auto changed = files;
    changed.at("")[at] = static_cast<std::byte>(value);
    return open(changed).error();
  };
  EXPECT_THAT(with_byte(4, 3).message, HasSubstr("version 3"));
  EXPECT_THAT(with_byte(5, 0x02).message, HasSubstr("tiles"));
  EXPECT_THAT(with_byte(5, 0x08).message, HasSubstr("deep"));
  EXPECT_THAT(with_byte(5, 0x10).message, HasSubstr("several parts"));
  EXPECT_EQ(with_byte(5, 0x80).code, ErrorCode::kUnsupported);
  const std::string text(reinterpret_cast<const char*>(files.at("").data()), files.at("").size());
  const std::size_t compression = text.find("compression") + 12 + 12 + 4;
  EXPECT_THAT(with_byte(compression, 8).message, HasSubstr("DWA"));
  const std::size_t width = text.find("dataWindow") + 11 + 6 + 4 + 8;
  EXPECT_FALSE(open([&] {
                 auto changed = files;
                 changed.at("")[width + 3] = std::byte{0x3F};
                 return changed;
               }())
                   .ok());
}

TEST(ExrFile, TakesNoMoreMemoryThanAllowed) {
  const FunctionSource source([](const DirectionPair&, std::size_t) { return 0.5; });
  const auto files = save(".exr", source, Options().set("grid", "10:30:10:30"))->files;
  Options little;
  little.memory.bytes = 10000;
  EXPECT_EQ(open(files, little).error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(open(files).ok());
}

// ---- CSV ----

std::map<std::string, Bytes> csv_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {{"", Bytes(bytes.begin(), bytes.end())}};
}

TEST(CsvFile, RefusesLinesOfOtherNodesByNumber) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t) { return 0.1 + pair.v.theta; },
                              {true, true, {"Y"}});
  const auto files = save(".csv", source, Options().set("grid", "difference/0:30:30:90"))->files;
  const std::string text(reinterpret_cast<const char*>(files.at("").data()), files.at("").size());
  const auto message = [&](std::string_view from, std::string_view to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    const auto opened = open(csv_of(changed));
    return opened.ok() ? "read" : opened.error().message;
  };
  EXPECT_EQ(message("theta_i,phi_i", "# between\n\ntheta_i,phi_i"), "read");
  EXPECT_EQ(message("\n0,0,0,90,0.1\n", "\n0, 0.0, 0,9e1 , nan\r\n"), "read");
  EXPECT_THAT(message("0,0,0,90,", "0,0,0,91,"), HasSubstr("line 4: phi_v is '91' where the next node has 90"));
  EXPECT_THAT(message("0,0,0,90,", "0,0,x,90,"), HasSubstr("line 4: theta_v is 'x'"));
  EXPECT_THAT(message("0,0,0,90,0.1", "0,0,0,90,"), HasSubstr("line 4: Y is '', no number"));
  EXPECT_THAT(message("0,0,0,90,0.1", "0,0,0,90,0.1,2"), HasSubstr("line 4: 6 fields instead of 5"));
  EXPECT_THAT(message("phi_v,Y", "phi_v,X"), HasSubstr("line 2: not the names of the head"));
  EXPECT_THAT(message("\n0,0,0,90,0.1\n", "\n"), HasSubstr("line 4: phi_v is '180'"));
  EXPECT_THAT(open(csv_of(text + "0,0,0,0,1\n")).error().message, HasSubstr("more lines"));
}

TEST(CsvFile, SaysTheDirectionsOfNodesOfAnyFrame) {
  const FunctionSource source([](const DirectionPair&, std::size_t) { return 0.5; }, {true, true, {"Y"}});
  for (const char* grid : {"half-difference/0:30:30:60", "mirror/0:30:90:45", "difference/0,200:30:30:90"}) {
    const auto saved = save(".csv", source, Options().set("grid", grid));
    ASSERT_TRUE(saved.ok()) << grid << saved.error().message;
    EXPECT_TRUE(open(saved->files).ok()) << grid << open(saved->files).error().message;
  }
}

}  // namespace
}  // namespace sbrdf::internal
