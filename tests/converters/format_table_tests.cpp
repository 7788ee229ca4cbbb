#include "converters/files/format_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "codec/file/encoder.h"
#include "converters/files/analytic/analytic_file.h"
#include "converters/files/foreign.h"
#include "tests/support/function_source.h"
#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using small_files::Bytes;
using small_files::bytes_of;
using small_files::source_of;
using testing::HasSubstr;

const Format& row(std::string_view name) {
  for (const Format& format : formats()) {
    if (format.name == name) return format;
  }
  throw std::runtime_error("no such row");
}

/// A value that each option may have; options of free text are listed.
std::vector<std::string> values_of(const OptionSpec& option) {
  const std::map<std::string_view, std::vector<std::string>> texts = {
      {"placement", {"search", "paper", "14/36", "2.5/7.5"}},
      {"precision", {"lossless", "0.1%", "0.1", "50%", "0.0001%"}},
      {"merl-shape", {"1,1,1", "90,90,180", "4096,4096,4096"}},
      {"ngan-shape", {"1,1,1,1", "45,45,72,36", "4096,4096,4096,4096"}},
      {"material", {"a"}},
      {"grid", {"5:10:5:10", "utia", "merl", "difference/0:5:5:10", "0,1,90:0,90:0,45:0,180", "mirror/90:15:30:10"}},
      {"hdf5-dataset", {"f_r", "group/table"}},
      {"scheme", {"1", "14", "30"}},
      {"scattered-columns", {"theta_i,theta_v,phi_v,Y", "skip,phi_v,phi_i,theta_i,theta_v,R,G,B"}},
  };
  switch (option.kind) {
    case OptionKind::kNumber:
      return {std::to_string(option.range.most), std::to_string(option.range.least + (option.range.open ? 0.001 : 0))};
    case OptionKind::kCount:
      return {std::to_string(option.counts.least), std::to_string(option.counts.most)};
    case OptionKind::kChoice:
      return {option.choices.begin(), option.choices.end()};
    case OptionKind::kFlag:
      return {""};
    case OptionKind::kText:
      break;
  }
  return texts.at(option.name);
}

std::vector<std::string> values_against(const OptionSpec& option) {
  const std::map<std::string_view, std::vector<std::string>> texts = {
      {"placement", {"", "14", "14/", "/36", "14/36/2", "-14/36", "0/36", "nan/36", "14/inf", " 14/36", "auto"}},
      {"precision", {"", "%", "0", "51%", "0.00001%", "1e400", "Lossless"}},
      {"merl-shape", {"", "90", "90,90", "90,90,", "90,90,180,", "0,1,1", "1,4097,1", "90x90x180", "1, 1, 1"}},
      {"ngan-shape", {"", "90", "45,45,72", "45,45,72,", "45,45,72,36,", "0,1,1,1", "1,1,1,4097", "1, 1,1,1"}},
      {"material", {}},
      {"grid",
       {"", "5", "5:10:5", "5:10:5:10:5", "7:10:5:10", "-5:10:5:10", "0,95:0:0:0", "5,4:0:0:0", "x:1:1:1",
        "polar/5:5:5:5", "UTIA", "5:0,360:5:10", "nan:1:1:1", "1e-9:1:1:1"}},
      {"hdf5-dataset", {}},
      {"scheme", {"", "0", "31", "14 ", "x", "nowhere.json"}},
      {"scattered-columns", {"", "theta_i,theta_v,phi_v", "theta_i,phi_i,theta_v,Y", "theta_i,theta_v,phi_v,phi_v,Y"}},
  };
  switch (option.kind) {
    case OptionKind::kNumber:
      return {"", "x", "1e999", std::to_string(option.range.least - 1), std::to_string(option.range.most + 1)};
    case OptionKind::kCount:
      return {"", "x", "-1", "1e4", std::to_string(option.counts.most + 1), "99999999999999999999999"};
    case OptionKind::kChoice:
      return {"", "x", std::string(option.choices.front()) + " "};
    case OptionKind::kFlag:
      return {"yes"};
    case OptionKind::kText:
      break;
  }
  return texts.at(option.name);
}

/// What reading a small file of a format needs to be told.
Options reading_options(const Format& format) {
  Options options;
  if (format.capabilities.has(Capability::kManyMaterials)) options.set("material", "b");
  if (format.name == "npy") options.set("grid", std::string(small_files::kSmallGrid));
  return options;
}

OptionUse use_of(const OptionSpec& option) { return option.use == OptionUse::kBoth ? OptionUse::kWrite : option.use; }

TEST(FormatTable, CapabilitiesSayWhatARowHas) {
  std::set<std::string_view> names, written;
  for (const Format& format : formats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    // What is read is known by its content: RGL and Zemax files are both .bsdf. What is written needs its own.
    if (format.save != nullptr) {
      EXPECT_TRUE(written.insert(format.extension).second) << format.extension;
    }
    EXPECT_EQ(format.capabilities.has(Capability::kRead), format.open != nullptr) << format.name;
    EXPECT_EQ(format.capabilities.has(Capability::kWrite), format.save != nullptr) << format.name;
    EXPECT_EQ(format.capabilities.has(Capability::kManyMaterials), format.material != nullptr) << format.name;
    EXPECT_NE(format.recognise, nullptr) << format.name;
    const auto found = find_writer(format.extension);
    EXPECT_EQ(found.ok() && *found == &format, format.save != nullptr) << format.name;
  }
}

TEST(FormatTable, FindsWritersWhateverTheLetterCaseAndListsThem) {
  EXPECT_EQ((*find_writer(".BiNaRy"))->name, "merl");
  for (const char* extension : {"", ".", ".json", ".binar", ".binaryy", "binary"}) {
    const auto writer = find_writer(extension);
    ASSERT_FALSE(writer.ok()) << extension;
    EXPECT_EQ(writer.error().code, ErrorCode::kUsage);
    EXPECT_THAT(writer.error().message, HasSubstr(".sbrdf, .binary"));
  }
}

TEST(FormatOptions, EachIsAcceptedWithEachValueThatItMayHave) {
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      for (const std::string& value : values_of(option)) {
        const Options options = Options().set(std::string(option.name), value);
        const Status accepted = check_options(options, format.options, use_of(option), "files");
        EXPECT_TRUE(accepted.ok()) << option.name << " " << value << ": " << accepted.error().message;
      }
    }
  }
}

TEST(FormatOptions, EachRefusesOtherValuesByItsName) {
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      for (const std::string& value : values_against(option)) {
        const Options options = Options().set(std::string(option.name), value);
        const Status accepted = check_options(options, format.options, use_of(option), "files");
        ASSERT_FALSE(accepted.ok()) << option.name << " '" << value << "'";
        EXPECT_EQ(accepted.error().code, ErrorCode::kUsage);
        EXPECT_THAT(accepted.error().message, testing::StartsWith("--" + std::string(option.name) + ": "));
      }
    }
  }
}

TEST(FormatOptions, WhatIsNotDeclaredIsRefusedByName) {
  const auto source = make_analytic_source(parse_analytic_json(small_files::kKurtJson).value());
  for (const Format& format : formats()) {
    for (const char* name : {"no-such-option", "sample", "Samples", ""}) {
      const Options options = Options().set(name, "1");
      const std::string named = "--" + std::string(name) + " is no option of " + std::string(format.extension);
      const auto opened = open_source(source_of(small_files::of(format.name)), options);
      ASSERT_FALSE(opened.ok());
      EXPECT_EQ(opened.error().code, ErrorCode::kUsage);
      EXPECT_THAT(opened.error().message, HasSubstr(named));
      if (format.save == nullptr) continue;
      MemorySink sink;
      Report report;
      const Status saved = save_source(format, *source, sink, options, report);
      ASSERT_FALSE(saved.ok());
      EXPECT_THAT(saved.error().message, HasSubstr(named));
    }
  }
}

TEST(FormatOptions, OfWritingAreNoneOfReadingAndTheOtherWayRound) {
  const auto opened = open_source(source_of(small_files::merl()), Options().set("merl-shape", "2,3,4"));
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("--merl-shape is no option of .binary files that are read"));
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      const OptionUse other = option.use == OptionUse::kRead ? OptionUse::kWrite : OptionUse::kRead;
      EXPECT_EQ(find_option(format.options, option.name, other) != nullptr, option.use == OptionUse::kBoth);
    }
  }
}

// The program has one option of each name: rows that share a name mean the same.
TEST(FormatOptions, AreExplainedAndMeanTheSameInAllRows) {
  std::map<std::string_view, std::string_view> meanings = {{"json", ""}, {"help", ""}};
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      EXPECT_EQ(meanings.try_emplace(option.name, option.meaning).first->second, option.meaning) << option.name;
      EXPECT_FALSE(option.meaning.empty()) << option.name;
      EXPECT_EQ(option.choices.empty(), option.kind != OptionKind::kChoice) << option.name;
      const bool shows_its_value = option.kind == OptionKind::kChoice || option.kind == OptionKind::kFlag;
      EXPECT_EQ(option.unit.empty(), shows_its_value) << option.name;
    }
  }
}

TEST(FormatOptions, StandOnThePageOfTheFormat) {
  for (const Format& format : formats()) {
    const std::filesystem::path page = std::filesystem::path(SBRDF_SOURCE_DIR) / "specs" / format.page;
    std::ifstream file(page);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_FALSE(text.empty()) << page;
    for (const OptionSpec& option : format.options) {
      EXPECT_NE(text.find("`--" + std::string(option.name) + "`"), std::string::npos) << option.name << " in " << page;
    }
  }
}

TEST(Options, KeepTheLastValueInTheFirstPlace) {
  Options options;
  options.set("a", "1").set("b").set("a", "3");
  ASSERT_EQ(options.all().size(), 2U);
  EXPECT_EQ(options.all()[0], std::pair(std::string("a"), std::string("3")));
  EXPECT_EQ(options.number("a"), 3);
  EXPECT_EQ(options.count("a"), 3U);
  EXPECT_TRUE(options.has("b"));
  EXPECT_EQ(options.text("c"), std::nullopt);
  EXPECT_EQ(options.number("c"), std::nullopt);
}

TEST(Recognise, IsSureOfItsOwnFilesAndInARowAlone) {
  for (const Format& format : formats()) {
    const Bytes file = small_files::of(format.name);
    const auto head = std::span(file).first(std::min(file.size(), kHeadSize));
    for (const Format& other : formats()) {
      EXPECT_EQ(other.recognise(head, file.size()) == Match::kWhole, &other == &format)
          << format.name << " " << other.name;
    }
    const auto found = recognise(MemorySource(file));
    ASSERT_TRUE(found.ok()) << format.name;
    EXPECT_EQ(*found, &format);
  }
}

TEST(Recognise, ReadsTheBeginningOnly) {
  for (const Format& format : formats()) {
    Bytes file = small_files::of(format.name);
    const CallbackSource source(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) -> Status {
      EXPECT_LE(offset + target.size(), kHeadSize) << format.name;
      return MemorySource(file).read(offset, target);
    });
    EXPECT_TRUE(recognise(source).ok()) << format.name;
  }
}

TEST(Recognise, ReadsOnInTextThatNoRowIsSureOf) {
  for (const auto& [format, comment] : std::map<std::string, std::string>{{"zemax", "# a long line of comment\n"},
                                                                          {"klems", "<!-- a long comment -->\n"}}) {
    std::string text;
    while (text.size() < 60000) text += comment;
    const Bytes file =
        bytes_of(text + (format == "zemax" ? small_files::zemax_text() : small_files::klems_text().substr(39)));
    const auto found = recognise(MemorySource(file));
    ASSERT_TRUE(found.ok()) << format << ": " << found.error().message;
    EXPECT_EQ((*found)->name, format);
    std::uint64_t furthest = 0;
    const CallbackSource source(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) -> Status {
      furthest = std::max(furthest, offset + target.size());
      return MemorySource(file).read(offset, target);
    });
    EXPECT_TRUE(recognise(source).ok());
    EXPECT_LE(furthest, kTextHeadSize);
  }
}

TEST(Recognise, TellsTheFormatsThatEndInBsdfApart) {
  EXPECT_EQ((*recognise(MemorySource(small_files::of("rgl"))))->name, "rgl");
  EXPECT_EQ((*recognise(MemorySource(small_files::of("zemax"))))->name, "zemax");
  const Bytes fourier = bytes_of(std::string("SCATFUN\1", 8) + std::string(600, '\0'));
  EXPECT_THAT(open_source(source_of(fourier)).error().message, HasSubstr("Fourier BSDF"));
}

TEST(Recognise, PassesOnThatReadingFailed) {
  const CallbackSource source(100, [](std::uint64_t, std::span<std::byte>) -> Status { return io_error("gone"); });
  EXPECT_EQ(recognise(source).error().code, ErrorCode::kIo);
}

std::string refusal_of(const Bytes& file) {
  const auto found = recognise(MemorySource(file));
  return found.ok() ? "recognised as " + std::string((*found)->name) : found.error().message;
}

TEST(Recognise, NamesWhatIsCertainlyNoBrdf) {
  const std::map<std::string, std::vector<std::string>> files = {
      {"a web page (HTML)",
       {"<!DOCTYPE html>\n<html>", "<!doctype HTML PUBLIC>", "  \r\n\t<HTML lang=\"en\">", "\xEF\xBB\xBF<html>",
        "<!-- saved from -->\n<!-- twice --><head>", "<body>x", std::string("<html>\0\1\2", 9)}},
      {"a Git LFS pointer", {"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"}},
      {"the description of a dense table", {R"({"sbrdf":"dense table","version":1})"}},
      {"gzip-compressed", {std::string("\x1F\x8B\x08\0\0\0\0\0", 8), "\x1F\x8B"}},
      {"an XML file without the root element WindowElement",
       {"<?xml version=\"1.0\"?>\n<svg>", "\xEF\xBB\xBF<?xml version=\"1.0\"?><WindowElements>"}},
      {"a zip archive", {std::string("PK\3\4\x14\0\0\0", 8), std::string("PK\5\6\0\0", 6)}},
      {"zstd-compressed", {std::string("\x28\xB5\x2F\xFD\x04\0", 6)}},
      {"XZ-compressed", {std::string("\xFD\x37zXZ\0\0\4", 8)}},
      {"AppleDouble", {std::string("\0\5\x16\7\0\2\0\0Mac OS X", 16)}},
      {"empty", {""}},
      {"a text file", {"theta_i,phi_i\n1,2\n", "<xml version", "PK", "version 2", "<!-- only a comment -->", "\t\r\n"}},
      {"not recognised", {"\x01\x02\x03\x04 nothing that anybody knows \x7F\xFF", "\x1F", std::string(40, '\0')}},
  };
  for (const auto& [name, contents] : files) {
    for (const std::string& content : contents) EXPECT_THAT(refusal_of(bytes_of(content)), HasSubstr(name)) << content;
  }
}

TEST(Recognise, AsksTheReaderWhatIsWrongWithADamagedFile) {
  Bytes cut = small_files::merl();
  cut.pop_back();
  EXPECT_EQ((*recognise(MemorySource(cut)))->name, "merl");
  EXPECT_THAT(open_source(source_of(cut)).error().message, HasSubstr("truncated MERL file"));
  const Bytes json = bytes_of(R"({"name": "no parameters"})");
  EXPECT_THAT(open_source(source_of(json)).error().message, HasSubstr("k_d is missing"));
}

TEST(OpenSource, KeepsTheBytesThatItReadsFrom) {
  for (const Format& format : formats()) {
    if (format.name == "atlas") continue;  // its texels are in a file beside it
    const Options options = reading_options(format);
    auto bytes = source_of(small_files::of(format.name));
    const auto source = open_source(bytes, options);
    ASSERT_TRUE(source.ok()) << format.name << ": " << source.error().message;
    bytes.reset();
    const std::vector<DirectionPair> pairs = {{{0.3, 0.1}, {0.4, 2}}};
    std::vector<float> values((*source)->channel_count());
    (*source)->evaluate(pairs, values);
    EXPECT_GT(values[0], 0) << format.name;
  }
}

TEST(OpenSource, TakesSourcesThatHaveNoView) {
  for (const Format& format : formats()) {
    if (format.name == "atlas") continue;  // its texels are in a file beside it
    const Options options = reading_options(format);
    const auto file = std::make_shared<Bytes>(small_files::of(format.name));
    const auto called = std::make_shared<CallbackSource>(
        file->size(), [file](std::uint64_t offset, std::span<std::byte> target) -> Status {
          return MemorySource(*file).read(offset, target);
        });
    EXPECT_TRUE(open_source(called, options).ok()) << format.name;
  }
}

TEST(OpenSource, PassesOnThatReadingFailed) {
  for (const Format& format : formats()) {
    const Bytes file = small_files::of(format.name);
    const auto broken =
        std::make_shared<CallbackSource>(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) -> Status {
          if (offset + target.size() > 40 && target.size() != std::min(kHeadSize, file.size())) return io_error("gone");
          return MemorySource(file).read(offset, target);
        });
    // Files that are shorter than a head are read whole.
    if (file.size() <= kHeadSize) continue;
    const Options options = reading_options(format);
    const auto source = open_source(broken, options);
    ASSERT_FALSE(source.ok()) << format.name;
    EXPECT_EQ(source.error().code, ErrorCode::kIo) << format.name << ": " << source.error().message;
  }
}

TEST(OpenBundle, NeedsTheNameOfAMaterial) {
  const Bytes file = small_files::bundle();
  EXPECT_THAT(open_source(source_of(file)).error().message, HasSubstr("2 materials"));
  const auto missing = open_source(source_of(file), Options().set("material", "c"));
  EXPECT_EQ(missing.error().code, ErrorCode::kUsage);
  EXPECT_THAT(missing.error().message, HasSubstr("no material 'c'"));
}

TEST(OpenBundle, GivesTheFileOfAMaterial) {
  const auto material = row("sbrdfz").material(source_of(small_files::bundle()), "a", {});
  ASSERT_TRUE(material.ok());
  EXPECT_EQ(read_range(**material, 0, (*material)->size()).value(), small_files::sliced());
}

TEST(OpenNamed, FindsBuiltInSourcesWithoutAFile) {
  EXPECT_TRUE(is_named("kurt:wood01"));
  EXPECT_FALSE(is_named("./kurt:wood01"));
  EXPECT_TRUE(open_named("kurt:wood01").ok());
  EXPECT_EQ(open_named("kurt:wood99").error().code, ErrorCode::kUsage);
  EXPECT_EQ(file_in_name("kurt:some/path.JSON"), "some/path.JSON");
  for (const char* text : {"kurt:wood01", "kurt:.json", "some.json", "kurt:json", "kurt:"}) {
    EXPECT_EQ(file_in_name(text), std::nullopt) << text;
  }
}

TEST(OpenKurtFile, RefusesLargeFilesUnread) {
  bool read = false;
  const CallbackSource large(kAnalyticLargestFile + 1, [&](std::uint64_t, std::span<std::byte>) -> Status {
    read = true;
    return ok_status();
  });
  const auto source = open_analytic_file(large);
  ASSERT_FALSE(source.ok());
  EXPECT_THAT(source.error().message, HasSubstr("at most 1048576"));
  EXPECT_FALSE(read);
}

struct SavedFile {
  Bytes bytes;
  Report report;
};

/// Little work for any writer.
Options small_options(std::string_view format) {
  if (format == "merl") return Options().set("merl-shape", "6,6,6");
  if (format == "ngan") return Options().set("ngan-shape", "3,3,6,4");
  if (format == "sbrdf") return Options().set("samples", "60").set("placement", "40/180");
  if (format == "rgl") return Options().set("rgl-size", "8").set("rgl-warp-size", "16").set("rgl-theta", "3");
  if (find_option(row(format).options, "grid", OptionUse::kWrite) != nullptr)
    return Options().set("grid", std::string(small_files::kSmallGrid));
  return {};
}

/// With nothing to choose and nothing fitted, too.
Options plain_options(std::string_view format) {
  const Options small = small_options(format);
  return format == "sbrdf" ? Options(small).set("values", "measured").set("precision", "lossless") : small;
}

Result<SavedFile> save(std::string_view format, const BrdfSource& source, const Options& options = {},
                       const Progress& progress = {}) {
  MemorySink sink;
  SavedFile saved;
  if (Status done = save_source(row(format), source, sink, options, saved.report, progress); !done) return done.error();
  saved.bytes = std::move(sink).take();
  return saved;
}

TEST(SaveSource, ReportsBytesAndFindingsOfTheSource) {
  Bytes file = small_files::merl();
  for (std::size_t c = 0; c < 3; ++c) std::memset(file.data() + 12 + 8 * 24 * c, 0xBF, 8);  // a mark
  const auto source = open_source(source_of(file)).value();
  for (const char* format : {"merl", "sbrdf"}) {
    const auto saved = save(format, *source, plain_options(format));
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    EXPECT_EQ(saved->report.bytes, saved->bytes.size());
    ASSERT_EQ(saved->report.findings.size(), 2U);  // a mark, and that it lies above the horizon
    EXPECT_EQ(saved->report.findings[0].count, 1U);
    EXPECT_EQ(saved->report.findings[1].count, 1U);
  }
}

TEST(SaveSource, RefusesWhatCannotBeWrittenAndWhatContradictsItself) {
  const auto source = make_analytic_source(parse_analytic_json(small_files::kKurtJson).value());
  EXPECT_EQ(save("kurt", *source).error().code, ErrorCode::kUnsupported);
  const auto both = save("sbrdf", *source, Options().set("samples", "50").set("target-mre", "3"));
  EXPECT_EQ(both.error().code, ErrorCode::kUsage);
  EXPECT_THAT(both.error().message, testing::AllOf(HasSubstr("--samples"), HasSubstr("--target-mre")));
}

TEST(SaveSource, CopiesWithoutResamplingWhereAFormatHoldsJustThis) {
  const Bytes merl = small_files::merl();
  const auto table = open_source(source_of(merl)).value();
  EXPECT_EQ(save("merl", *table)->bytes, merl);
  EXPECT_EQ(save("merl", *table, Options().set("merl-shape", "2,3,4"))->bytes, merl);
  const auto resampled = save("merl", *table, Options().set("merl-shape", "2,3,5"));
  EXPECT_EQ(resampled->bytes.size(), merl_file_size({2, 3, 5}));
  const Bytes sliced = small_files::sliced();
  const auto slices = open_source(source_of(sliced)).value();
  ASSERT_NE(slices->sliced(), nullptr);
  EXPECT_EQ(save("sbrdf", *slices)->bytes, sliced);
  EXPECT_EQ(save("sbrdf", *slices, Options().set("chunks", "split"))->report.remarks[0].key, "copied");
  EXPECT_NE(save("sbrdf", *slices, Options().set("samples", "300").set("placement", "40/180").set("values", "measured"))
                ->report.remarks[0]
                .key,
            "copied");
}

TEST(SaveSource, WritesProvenanceIntoMetadata) {
  const auto source = make_analytic_source(parse_analytic_json(small_files::kKurtJson).value());
  Options options = Options().set("samples", "40").set("placement", "40/180").set("metadata", "full");
  options.provenance = {"what was asked for", "0123"};
  const auto file = open_source(source_of(save("sbrdf", *source, options)->bytes)).value();
  EXPECT_THAT(file->sliced()->sliced.metadata, HasSubstr(R"("command":"what was asked for")"));
  EXPECT_THAT(file->sliced()->sliced.metadata, HasSubstr(R"("sha256":"0123")"));
}

TEST(SaveSource, StopsWhenAsked) {
  const Progress stop = {[](double) { return false; }};
  const auto model = make_analytic_source(parse_analytic_json(small_files::kKurtJson).value());
  const auto table = open_source(source_of(small_files::merl({30, 30, 30}))).value();
  for (const BrdfSource* source : {model.get(), table.get()}) {
    const auto saved = save("merl", *source, {}, stop);
    ASSERT_FALSE(saved.ok());
    EXPECT_EQ(saved.error().message, interrupted_error().message);
  }
  EXPECT_EQ(save("sbrdf", *model, plain_options("sbrdf"), stop).error().message, interrupted_error().message);
}

TEST(SaveSource, PassesOnThatWritingFailed) {
  class FullSink final : public ByteSink {
   public:
    explicit FullSink(std::uint64_t room) : room_(room) {}
    [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
      return offset + bytes.size() > room_ ? Status(io_error("full")) : ok_status();
    }

   private:
    std::uint64_t room_;
  };
  const auto model = make_analytic_source(parse_analytic_json(small_files::kKurtJson).value());
  const auto table = open_source(source_of(small_files::merl())).value();
  for (const char* format : {"merl", "sbrdf"}) {
    for (const BrdfSource* source : {model.get(), table.get()}) {
      for (const std::uint64_t room : {0, 12, 100}) {
        FullSink sink(room);
        Report report;
        EXPECT_EQ(save_source(row(format), *source, sink, plain_options(format), report).error().message, "full");
      }
    }
  }
}

// What comes out of `save` goes into `open`, for any source that has three channels or one.
TEST(SaveSource, WritesNothingThatOpenRefuses) {
  const auto constant = [](double value, std::vector<std::string> channels) {
    FunctionTraits traits{true, true, std::move(channels)};
    return FunctionSource([value](const DirectionPair&, std::size_t) { return value; }, traits);
  };
  for (const Format& format : formats()) {
    if (format.save == nullptr) continue;
    for (const double value : {0.3, 1e-44, 3e38, 1e38, 0.0, -0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
      for (const std::vector<std::string>& channels : {std::vector<std::string>{"R", "G", "B"}, {"Y"}}) {
        const auto source = constant(value, channels);
        const auto saved = save(format.name, source, small_options(format.name));
        EXPECT_TRUE(saved.ok() || value != 0.3) << format.name << ": " << saved.error().message;
        if (!saved) continue;
        const auto opened = open_source(source_of(saved->bytes), reading_options(format));
        EXPECT_TRUE(opened.ok()) << format.name << " " << value << ": " << opened.error().message;
      }
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
