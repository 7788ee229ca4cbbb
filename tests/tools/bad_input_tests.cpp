#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "converters/files/format_table.h"
#include "formats/sbrdf/container.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

struct BadFile {
  std::string name;
  std::vector<std::byte> bytes;
  int exit_code = 3;
  std::string fragment;  ///< of the message
};

void PrintTo(const BadFile& file, std::ostream* out) { *out << file.name; }

std::vector<std::byte> merl_of(double value, std::size_t changed = 24) {
  std::vector<double> values(24, 0.5);
  for (std::size_t k = 0; k < changed; ++k) values[k] = value;
  return merl_bytes({2, 2, 2}, values);
}

std::vector<std::byte> first(std::vector<std::byte> bytes, std::size_t size) {
  bytes.resize(size);
  return bytes;
}

std::vector<BadFile> bad_files() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinite = std::numeric_limits<double>::infinity();
  constexpr std::int32_t lowest = std::numeric_limits<std::int32_t>::min();  // the bits of 2^31
  const std::vector<double> values(24, 0.5);
  const std::vector<std::byte> sliced = small_sliced();
  std::vector<std::byte> newer = sliced;
  newer[kContainerMagic.size()] = std::byte{9};
  std::vector<std::byte> damaged = sliced;
  damaged[sliced.size() - 1] ^= std::byte{1};
  std::vector<std::byte> longer = sliced;
  longer.push_back(std::byte{0});
  return {
      {"MerlCutInHeader", first(small_merl(), 7), 3, "(at byte 4)"},
      {"MerlCutAfterHeader", first(small_merl(), 12), 3, "need 204 bytes, the file has 12 (at byte 12)"},
      {"MerlCutInValues", first(small_merl(), 203), 3, "need 204 bytes, the file has 203 (at byte 203)"},
      {"MerlWithTrailingByte", first(small_merl(), 205), 3, "(at byte 204)"},
      {"SlicedCutInMagic", first(sliced, 5), 3, ""},
      {"SlicedCutInHead", first(sliced, 40), 3, "[SB-1-4] truncated: the file ends within its head (at byte 40)"},
      {"SlicedCutAtEnd", first(sliced, sliced.size() - 1), 3, "[SB-3-2]"},
      {"SlicedWithTrailingByte", longer, 3, "[SB-3-2]"},
      {"SlicedDamaged", damaged, 3, "checksum"},
      {"SlicedOfNewerVersion", newer, 4, "[SB-1-3]"},
      {"MerlCountOfZero", merl_bytes({0, 2, 2}, values), 3, "count of theta_h is 0, must be 1 to 4096 (at byte 0)"},
      {"MerlCountNegative", merl_bytes({2, -2, -2}, values), 3,
       "count of theta_d is -2, must be 1 to 4096 (at byte 4)"},
      {"MerlCountOfTwoToThe31", merl_bytes({2, 2, lowest}, values), 3, "phi_d is -2147483648"},
      {"MerlCountsThatOnlyMatchByWrapping", merl_bytes({2, 4, 536870913}, values), 3, "phi_d is 536870913"},
      {"MerlOfNan", merl_of(nan, 24), 3, "no value of the MERL table is positive"},
      {"MerlOfInfinity", merl_of(infinite, 24), 3, "no value of the MERL table is positive"},
      {"MerlAllZero", merl_of(0), 3, "no value of the MERL table is positive"},
      {"MerlAllNegative", merl_of(-1), 3, "no value of the MERL table is positive"},
      {"Text", bytes_of("theta_i,phi_i\n1,2\n"), 3, "text"},
      {"Empty", {}, 3, "empty"},
      {"FourierBsdf", bytes_of(std::string("SCATFUN\1", 8) + std::string(64, '\0')), 4, "Fourier"},
      {"Noise", bytes_of("\x01\x02\x03\x04 nothing that anybody knows \x7F\xFF"), 3, "not recognised"},
      {"WebPage", bytes_of("<!DOCTYPE html>\n<html><body>Not found"), 3, "this is a web page (HTML)"},
      {"XmlOfAnotherKind", bytes_of("<?xml version=\"1.0\"?>\n<scene/>"), 3, "an XML file without the root element"},
      {"KlemsCut", bytes_of("<WindowElement>\n<Optical>"), 3, "not whole XML"},
      {"ZemaxCut", bytes_of("# Sample\nSource Measured\nSymmetry PlaneSymmetrical\n"), 3, "the file ends early"},
      {"ZemaxTransmission",
       bytes_of(
           "Source a\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BTDF\nSampleRotation 1\n0\n"
           "AngleOfIncidence 1\n0\nScatterAzimuth 1\n0\nScatterRadial 1\n0\nMonochrome\nDataBegin\nTIS "
           "1\n1\nDataEnd\n"),
       4, "ScatterType is BTDF"},
      {"GitLfsPointer", bytes_of("version https://git-lfs.github.com/spec/v1\noid sha256:4d\nsize 9\n"), 3, "Git LFS"},
      {"Gzip", bytes_of(std::string("\x1F\x8B\x08\0\0\0\0\0\0\3", 10)), 3, "gzip-compressed"},
      {"Zip", bytes_of(std::string("PK\3\4\x14\0\0\0\x08\0", 10)), 3, "a zip archive"},
      {"Zstd", bytes_of(std::string("\x28\xB5\x2F\xFD\x04\0\1\0\0", 9)), 3, "zstd-compressed"},
      {"Xz", bytes_of(std::string("\xFD\x37zXZ\0\0\4", 8)), 3, "XZ-compressed"},
      {"AppleDouble", bytes_of(std::string("\0\5\x16\7\0\2\0\0Mac OS X        ", 24)), 3, "AppleDouble"},
      {"MerlOfFloat32", first(small_merl(), 12 + 4 * 24), 4, "the size of float32 values"},
      {"MerlBigEndian", merl_bytes({0x02000000, 0x02000000, 0x02000000}, values), 4, "big-endian"},
      {"JsonWithoutParameters", bytes_of(R"({"name": "n"})"), 3, "parameters of a model"},
      {"RglCutInHeader", bytes_of(std::string("tensor_file\0\1", 13)), 3, "truncated"},
  };
}

class BadFileTest : public testing::TestWithParam<BadFile> {
 protected:
  BadFileTest() { write_bytes(file_, GetParam().bytes); }

  void expect_refused(const std::vector<std::string>& arguments, const std::string& input = "") {
    const ProgramRun run = run_sbrdf(arguments, {.input = input});
    expect_failure(run, GetParam().exit_code, file_, GetParam().fragment);
    EXPECT_EQ(run.out, "");
    EXPECT_THAT(folder_.entries(), testing::ElementsAre("bad.binary"));
  }

  ScratchFolder folder_;
  std::string file_ = folder_ / "bad.binary";
};

TEST_P(BadFileTest, IsRefusedByConvertToSlices) { expect_refused({"convert", file_, folder_ / "out.sbrdf"}); }
TEST_P(BadFileTest, IsRefusedByConvertToMerl) { expect_refused({"convert", file_, folder_ / "out.binary", "--json"}); }
TEST_P(BadFileTest, IsRefusedByInfo) {
  if (GetParam().name == std::string("SlicedDamaged")) return;  // in a sample, and info reads none: see Info
  expect_refused({"info", file_});
}
TEST_P(BadFileTest, IsRefusedAsReference) { expect_refused({"compare", file_, "kurt:wood01", "--random", "9"}); }
TEST_P(BadFileTest, IsRefusedAsTest) { expect_refused({"compare", "kurt:wood01", file_, "--random", "9", "--json"}); }
TEST_P(BadFileTest, IsRefusedByEval) { expect_refused({"eval", file_}, "theta_i,phi_i,theta_v,phi_v\n1,2,3,4\n"); }

INSTANTIATE_TEST_SUITE_P(Tools, BadFileTest, testing::ValuesIn(bad_files()),
                         [](const auto& tested) { return tested.param.name; });

/// Each in memory of just that size, so that the sanitizer sees a read beyond it.
void expect_every_prefix_refused(const std::vector<std::byte>& whole) {
  ASSERT_TRUE(open_source(std::make_shared<MemorySource>(whole)).ok());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto prefix = std::make_unique<std::byte[]>(size);
    std::copy_n(whole.begin(), size, prefix.get());
    EXPECT_FALSE(open_source(std::make_shared<MemorySource>(std::span(prefix.get(), size))).ok())
        << size << " of " << whole.size() << " bytes";
  }
}

TEST(OpenSource, RefusesEveryPrefixOfAMerlFile) { expect_every_prefix_refused(small_merl()); }
TEST(OpenSource, RefusesEveryPrefixOfASlicedFile) { expect_every_prefix_refused(small_sliced()); }

class UnreadableInput : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  static std::vector<std::string> arguments(const std::string& in, const std::string& out) {
    std::vector<std::string> words = GetParam();
    for (std::string& word : words) word = word == "IN" ? in : word == "OUT" ? out : word;
    return words;
  }
};

TEST_P(UnreadableInput, IsNamedWhenMissing) {
  const ScratchFolder folder;
  const std::string in = folder / "missing.binary";
  expect_failure(run_sbrdf(arguments(in, folder / "out.sbrdf")), 2, in, "No such file or directory");
  EXPECT_THAT(folder.entries(), testing::IsEmpty());
}

TEST_P(UnreadableInput, IsNamedWhenADirectory) {
  const ScratchFolder folder;
  const std::string in = folder.path().string();
  expect_failure(run_sbrdf(arguments(in, folder / "out.sbrdf")), 2, in, "is a directory");
  EXPECT_THAT(folder.entries(), testing::IsEmpty());
}

TEST_P(UnreadableInput, IsNamedWhenItMayNotBeRead) {
  const ScratchFolder folder;
  const std::string in = folder / "secret.binary";
  write_bytes(in, small_merl());
  std::filesystem::permissions(in, std::filesystem::perms::none);
  // In the folder of the program's own temporary files nobody may write, so OUT is where they may.
  std::filesystem::create_directory(folder / "open");
  std::filesystem::permissions(folder / "open", std::filesystem::perms::all);
  expect_failure(run_sbrdf(arguments(in, folder / "open/out.sbrdf"), {.without_privileges = true}), 2, in,
                 "Permission denied");
}

TEST_P(UnreadableInput, MayBeLargerThanMemory) {
  const ScratchFolder folder;
  const std::string in = folder / "large.binary";
  write_bytes(in, small_merl());
  // A file with a hole, which takes no room on the disk.
  std::error_code error;
  std::filesystem::resize_file(in, std::uintmax_t{1} << 43, error);
  if (error) GTEST_SKIP() << "no sparse file of 8 TiB here: " << error.message();
  expect_failure(run_sbrdf(arguments(in, folder / "out.sbrdf")), 3, in,
                 "need 204 bytes, the file has 8796093022208 (at byte 204)");
}
INSTANTIATE_TEST_SUITE_P(Tools, UnreadableInput,
                         testing::Values(std::vector<std::string>{"convert", "IN", "OUT"},
                                         std::vector<std::string>{"info", "IN"},
                                         std::vector<std::string>{"compare", "IN", "kurt:wood01"},
                                         std::vector<std::string>{"compare", "kurt:wood01", "IN"},
                                         std::vector<std::string>{"eval", "IN"}),
                         [](const auto& tested) { return tested.param[0] + std::to_string(tested.index); });

TEST(KurtInput, IsRefusedWithItsName) {
  const ScratchFolder folder;
  const auto refused = [](const std::string& in, int code, const std::string& fragment) {
    expect_failure(run_sbrdf({"info", in}), code, in, fragment);
  };
  refused("kurt:fabric000", 1, "fabric112");
  refused("kurt:", 1, "");
  refused("kurt:" + (folder / "missing.json"), 2, "No such file");
  write_bytes(folder / "broken.json", bytes_of("{\"name\": "));
  refused("kurt:" + (folder / "broken.json"), 3, "");
  write_bytes(folder / "nan.json", bytes_of(R"({"name": "n", "k_d": [0, NaN, 0], "lobes": []})"));
  refused("kurt:" + (folder / "nan.json"), 3, "");
  write_bytes(folder / "rough.json", bytes_of(R"({"name": "n", "k_d": [0, 0, 0], "lobes":
      [{"k_s": [1, 1, 1], "f_0": 1, "m_x": 0, "m_y": 1, "alpha": 0}]})"));
  refused("kurt:" + (folder / "rough.json"), 3, "lobes[0].m_x");
}

}  // namespace
}  // namespace sbrdf::internal
