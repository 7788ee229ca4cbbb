#include "converters/files/hdf5/hdf5_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "converters/files/format_table.h"
#include "converters/tables/dense_table.h"
#include "formats/table/hdf5/table.h"
#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using small_files::Bytes;
using small_files::source_of;
using testing::HasSubstr;

Hdf5Head small_head() {
  Hdf5Head head;
  head.frame = "angles";
  head.axes = {{{"theta_i", {0, 45, 90}, "held", "angle"},
                {"phi_i", {0, 180}, "360", "angle"},
                {"theta_v", {0, 90}, "held", "angle"},
                {"phi_v", {0, 120, 240}, "360", "angle"}}};
  head.channels = {"550 nm", "650 nm"};
  return head;
}

/// Numbers rise from 1.
Bytes file_of(const Hdf5Head& head) {
  MemorySink sink;
  auto writer = Hdf5TableWriter::create(sink, head, {1, 2, 2, 2, 2}, 4).value();
  Hdf5Extent shape{};
  for (std::size_t k = 0; k < 4; ++k) shape[k] = head.axes[k].nodes_deg.size();
  shape[4] = head.channels.size();
  std::vector<double> values(shape[0] * shape[1] * shape[2] * shape[3] * shape[4]);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = 1 + static_cast<double>(k);
  EXPECT_TRUE(writer->write({}, shape, values).ok());
  EXPECT_TRUE(writer->finish("{}").ok());
  return std::move(sink).take();
}

// The library looks for a file of the name that bytes in memory are opened under.
TEST(Hdf5, IsReadWhateverLiesInTheFolder) {
  const std::filesystem::path before = std::filesystem::current_path();
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("sbrdf_hdf5_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::filesystem::current_path(folder);
  for (const char* name : {"table.h5", "in memory"}) std::ofstream(name) << "something else";
  EXPECT_TRUE(open_hdf5(source_of(file_of(small_head())), {}));
  std::filesystem::current_path(before);
  std::filesystem::remove_all(folder);
}

TEST(Hdf5, GivesBackNodesNamesAndNumbers) {
  const auto source = open_hdf5(source_of(file_of(small_head())), {}).value();
  EXPECT_EQ(source->traits().channels, (std::vector<std::string>{"550 nm", "650 nm"}));
  const DenseTable& table = *source->table();
  EXPECT_EQ(table.grid.axes[0].nodes_deg(), (std::vector<double>{0, 45, 90}));
  EXPECT_EQ(table.grid.axes[1].ends(), Ends::kFullTurn);
  const std::array<GridNode, 2> nodes = {{{0, 0, 0, 0}, {2, 1, 1, 2}}};
  std::array<double, 4> values{};
  table.values->gather(nodes, values);
  EXPECT_EQ(values, (std::array<double, 4>{1, 2, 71, 72}));
}

TEST(Hdf5, CarriesHowFarValuesAreGood) {
  Hdf5Head head = small_head();
  head.theta_max_deg = 80;
  head.beyond = "made up";
  const auto source = open_hdf5(source_of(file_of(head)), {}).value();
  EXPECT_EQ(source->traits().theta_max_deg, 80);
  EXPECT_EQ(source->traits().beyond_theta_max, "made up");
}

TEST(Hdf5, RefusesHeadsThatMeanNothing) {
  const auto refusal = [](const auto& change) {
    Hdf5Head head = small_head();
    change(head);
    const auto source = open_hdf5(source_of(file_of(head)), {});
    return source.ok() ? std::string("taken") : source.error().message;
  };
  EXPECT_THAT(refusal([](Hdf5Head& h) { h.frame = "sideways"; }), HasSubstr("\"sideways\" is no frame"));
  EXPECT_THAT(refusal([](Hdf5Head& h) { h.axes[1].ends = "open"; }), HasSubstr("\"open\" is no end"));
  EXPECT_THAT(refusal([](Hdf5Head& h) { h.axes[1].spacing = "cube"; }), HasSubstr("\"cube\" no spacing"));
  EXPECT_THAT(refusal([](Hdf5Head& h) {
                h.axes[0].nodes_deg = {0, 50, 50};
              }),
              HasSubstr("nodes of theta_i do not rise"));
  EXPECT_THAT(refusal([](Hdf5Head& h) { h.axes[0].nodes_deg[1] = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("nodes of theta_i do not rise"));
  EXPECT_THAT(refusal([](Hdf5Head& h) {
                h.axes[3].nodes_deg = {0, 120, 360};
              }),
              HasSubstr("nodes of phi_v do not rise"));
  EXPECT_THAT(refusal([](Hdf5Head& h) { h.theta_max_deg = 91; }), HasSubstr("theta_max"));
}

TEST(Hdf5, GridIsAboutWhatIsWrittenWhereTheFileTellsItsOwn) {
  const Options other = Options().set("grid", "30:90:30:90");
  const auto source = open_hdf5(source_of(file_of(small_head())), other).value();
  EXPECT_EQ(source->table()->grid.axes[0].nodes_deg(), (std::vector<double>{0, 45, 90}));
}

TEST(Hdf5, CopiesOnlyTheTableThatIsFoundWithoutAsking) {
  EXPECT_NE(open_hdf5(source_of(file_of(small_head())), {}).value()->stored("hdf5"), nullptr);
  const Options named = Options().set("hdf5-dataset", "f_r");
  EXPECT_EQ(open_hdf5(source_of(file_of(small_head())), named).value()->stored("hdf5"), nullptr);
}

TEST(Hdf5, RefusesEveryTruncatedFile) {
  const Bytes whole = file_of(small_head());
  for (std::size_t size = 0; size < whole.size(); size += size < 2000 ? 1 : 37) {
    const auto source =
        open_hdf5(source_of(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), {});
    ASSERT_FALSE(source.ok()) << size << " of " << whole.size();
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidFile);
  }
}

TEST(Hdf5, SaysThatAFileIsTruncated) {
  Bytes file = file_of(small_head());
  file.resize(file.size() - 100);
  EXPECT_THAT(open_hdf5(source_of(file), {}).error().message, HasSubstr("truncated"));
}

TEST(Hdf5, ClosesAzimuthsThatGoRoundWhereTheFileSaysNothing) {
  Hdf5Head head = small_head();
  head.axes[1].ends = head.axes[3].ends = "held";
  const auto source = open_hdf5(source_of(file_of(head)), {}).value();
  EXPECT_EQ(source->table()->grid.axes[3].ends(), Ends::kFullTurn);
  EXPECT_THAT(source->traits().findings.at(1).what, HasSubstr("phi_v go all the way round"));
  EXPECT_EQ(source->stored("hdf5"), nullptr);
}

TEST(Hdf5, NamesADamagedChunk) {
  Bytes file = file_of(small_head());
  // Deflated chunks begin with 78 5E: a wrong byte behind the first of them breaks its checksum.
  const std::array<std::byte, 2> magic = {std::byte{0x78}, std::byte{0x5E}};
  const auto at = std::search(file.begin(), file.end(), magic.begin(), magic.end());
  ASSERT_NE(at, file.end());
  *(at + 8) ^= std::byte{0xFF};
  EXPECT_THAT(open_hdf5(source_of(file), {}).error().message, HasSubstr("a part of the table cannot be read"));
}

TEST(Hdf5, SaysWhatADatasetWithoutOurAttributesNeeds) {
  Hdf5Head head = small_head();
  Bytes file = file_of(head);
  // The word that makes it one of ours.
  const std::string_view word = "dense table";
  const auto* text = std::as_bytes(std::span(word)).data();
  auto at = std::search(file.begin(), file.end(), text, text + word.size());
  ASSERT_NE(at, file.end());
  *at = std::byte{'D'};
  EXPECT_THAT(open_hdf5(source_of(file), {}).error().message, HasSubstr("by --grid"));
  EXPECT_THAT(open_hdf5(source_of(file), Options().set("grid", "30:90:30:90")).error().message,
              HasSubstr("the dataset has 3 entries along dimension 0"));
  const auto taken = open_hdf5(source_of(file), Options().set("grid", "45:180:90:120"));
  ASSERT_TRUE(taken.ok()) << taken.error().message;
  EXPECT_EQ((*taken)->stored("hdf5"), nullptr);
}

}  // namespace
}  // namespace sbrdf::internal
