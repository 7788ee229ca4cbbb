#include "tools/conversion/folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;
using testing::IsEmpty;

class Listing : public testing::Test {
 protected:
  void add(const std::string& name, std::string_view text = "anything") const {
    fs::create_directories(fs::path(folder_ / name).parent_path());
    write_bytes(folder_ / name, bytes_of(text));
  }
  [[nodiscard]] FolderContent list(bool recursive = false) const {
    const Result<FolderContent> content =
        list_folder(folder_.path().string(), {.extension = ".sbrdf", .recursive = recursive, .ignored = {}});
    EXPECT_TRUE(content) << content.error().message;
    return *content;
  }
  static std::vector<std::string> outs(const FolderContent& content) {
    std::vector<std::string> names;
    for (const FolderFile& file : content.files) names.push_back(file.name + " " + file.out);
    return names;
  }
  static std::vector<std::string> skipped(const FolderContent& content) {
    std::vector<std::string> names;
    for (const SkippedFile& file : content.skipped) names.push_back(file.name + ": " + file.reason);
    return names;
  }

  const ScratchFolder folder_;
};

TEST_F(Listing, GivesEachFileTheExtensionOfTheOutputsInTheOrderOfNames) {
  for (const char* name : {"c.binary", "b.two.bsdf", "a", "D.BINARY"}) add(name);
  EXPECT_THAT(outs(list()), ElementsAre("D.BINARY D.sbrdf", "a a.sbrdf", "b.two.bsdf b.two.sbrdf", "c.binary c.sbrdf"));
}

TEST_F(Listing, KeepsWholeNamesWhereShortOnesWouldClash) {
  for (const char* name : {"a.binary", "a.bsdf", "a.binary.x", "b.binary", "a.binary.sbrdf"}) add(name);
  EXPECT_THAT(outs(list()), ElementsAre("a.binary a.binary.sbrdf", "a.binary.sbrdf a.binary.sbrdf.sbrdf",
                                        "a.binary.x a.binary.x.sbrdf", "a.bsdf a.bsdf.sbrdf", "b.binary b.sbrdf"));
}

TEST_F(Listing, DoesNotCountDocumentsAmongWhatClashes) {
  add("a.binary");
  add("a.png");
  EXPECT_THAT(outs(list()), ElementsAre("a.binary a.sbrdf"));
}

TEST_F(Listing, SkipsWhatNobodyWouldConvertAndSaysWhy) {
  for (const char* name : {"a.binary", "x.npy", "x.npy.json", "sub/b.binary", ".hidden.binary", "README", "readme.MD",
                           "LICENSE.txt", "Licence", "picture.PNG", "index.html"}) {
    add(name);
  }
  const FolderContent content = list();
  EXPECT_THAT(outs(content), ElementsAre("a.binary a.sbrdf", "x.npy x.sbrdf"));
  EXPECT_EQ(content.files[0].sidecar, "");
  EXPECT_EQ(content.files[1].sidecar, "x.npy.json");
  EXPECT_THAT(skipped(content),
              ElementsAre(".hidden.binary: its name begins with a dot", "LICENSE.txt: it is a document",
                          "Licence: it is a document", "README: it is a document", "index.html: it is a document",
                          "picture.PNG: it is a document", "readme.MD: it is a document", "sub: it is a folder",
                          "x.npy.json: it belongs to x.npy"));
}

TEST_F(Listing, SkipsNothingThatHoldsABrdfOrHasTheNameOfOne) {
  const std::string kurt = R"({"name": "n", "k_d": [0.1, 0.1, 0.1], "lobes": []})";
  add("README.txt", kurt);
  add("page.binary", "<!doctype html><html></html>");
  add("parameters.json", "broken");
  EXPECT_THAT(outs(list()),
              ElementsAre("README.txt README.sbrdf", "page.binary page.sbrdf", "parameters.json parameters.sbrdf"));
}

TEST_F(Listing, TakesLinksToNothingForFilesAndPipesForNone) {
  fs::create_symlink("nowhere", folder_ / "link.binary");
  ASSERT_EQ(run_command({"mkfifo", folder_ / "pipe.binary"}).exit_code, 0);
  const FolderContent content = list();
  EXPECT_THAT(outs(content), ElementsAre("link.binary link.sbrdf"));
  EXPECT_THAT(skipped(content), ElementsAre("pipe.binary: it is no ordinary file"));
}

TEST_F(Listing, EntersSubfoldersWhereAskedTo) {
  for (const char* name : {"b.binary", "sub/b.binary", "sub/deep/c.bsdf", ".git/d.binary"}) add(name);
  fs::create_directory_symlink(folder_.path(), folder_ / "sub/up");
  const FolderContent content = list(true);
  EXPECT_THAT(outs(content),
              ElementsAre("b.binary b.sbrdf", "sub/b.binary sub/b.sbrdf", "sub/deep/c.bsdf sub/deep/c.sbrdf"));
  EXPECT_THAT(skipped(content), ElementsAre(".git: its name begins with a dot", "sub/up: it is a folder"));
}

TEST_F(Listing, RefusesAFolderWithNothingToConvert) {
  add("README");
  const Result<FolderContent> content =
      list_folder(folder_.path().string(), {.extension = ".sbrdf", .recursive = false, .ignored = {}});
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().code, ErrorCode::kUsage);
  const Result<FolderContent> missing =
      list_folder(folder_ / "missing", {.extension = ".sbrdf", .recursive = false, .ignored = {}});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kIo);
}

TEST(ShardText, IsANumberAndACount) {
  const Result<Shard> shard = parse_shard("2/3");
  ASSERT_TRUE(shard);
  EXPECT_EQ(shard->number, 2);
  EXPECT_EQ(shard->count, 3);
  for (const char* text :
       {"", "/", "1", "0/3", "4/3", "1/0", "0/0", "-1/3", "1/3/3", "1 /3", "a/b", "1/3x", "6/18446744073709551615"}) {
    EXPECT_FALSE(parse_shard(text)) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
