#include "formats/zemax/zemax.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string with_replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("no '" + from + "' in the text");
  return text.replace(at, from.size(), to);
}

std::string without_carriage_returns(std::string text) {
  std::erase(text, '\r');
  return text;
}

const std::string kZemaxText = without_carriage_returns(small_files::zemax_text());

TEST(ZemaxParse, ReadsTheHeaderAndTheBlocksInOrder) {
  const auto table = parse_zemax(kZemaxText);
  ASSERT_TRUE(table.ok()) << table.error().message;
  EXPECT_EQ(table->symmetry, ZemaxSymmetry::kAsymmetrical4d);
  EXPECT_EQ(table->scatter, ZemaxScatter::kBrdf);
  EXPECT_EQ(table->channel_count(), 1U);
  EXPECT_THAT(table->rotations, ElementsAre(0, 180));
  EXPECT_THAT(table->incidences, ElementsAre(10, 60));
  EXPECT_THAT(table->azimuths, ElementsAre(0, 90, 180, 270, 360));
  EXPECT_THAT(table->radials, ElementsAre(0, 20, 90, 180));
  EXPECT_THAT(table->tis, ElementsAre(0.5, 0.5, 0.5, 0.5));
  ASSERT_EQ(table->values.size(), 80U);
  EXPECT_EQ(table->values[1], 0.29);
  EXPECT_EQ(table->values[4], 0.30);
  EXPECT_EQ(table->values[20 + 9], 0.27);  // second block, third row, second column
}

TEST(ZemaxParse, TakesAnyLetterCaseLineEndCommentAndBreakInAList) {
  const auto expected = parse_zemax(kZemaxText).value();
  std::string shouted = kZemaxText;
  for (char& c : shouted) c = static_cast<char>(std::toupper(c));
  for (const std::string& text :
       {small_files::zemax_text(), shouted, "\xEF\xBB\xBF# comment\n\n  # another \xC3\xA9\n" + kZemaxText,
        with_replaced(kZemaxText, "90\t180\t270", "90 \n# between\n 180\t \t270"),
        with_replaced(kZemaxText, "TIS\t0.5", "tis   5e-1 "), with_replaced(kZemaxText, "DataEnd\n", "DataEnd"),
        kZemaxText + "\n\n# the end\n", with_replaced(kZemaxText, "0.29", "+.29"),
        with_replaced(kZemaxText, "ScatterRadial\t4\n", "ScatterRadial 4 ")}) {
    const auto table = parse_zemax(text);
    ASSERT_TRUE(table.ok()) << table.error().message;
    EXPECT_EQ(table->values, expected.values);
    EXPECT_EQ(table->azimuths, expected.azimuths);
  }
}

TEST(ZemaxParse, ReadsTristimulusValuesOneAfterTheOther) {
  const std::size_t data = kZemaxText.find("Monochrome\nDataBegin");
  const std::string blocks = kZemaxText.substr(data + 11);
  std::string text = with_replaced(kZemaxText.substr(0, data), "Monochrome", "XYZ");
  for (const char* name : {"TristimulusX\n", "TristimulusY\n", "TristimulusZ\n"}) {
    text += name + with_replaced(blocks, "0.30", std::string(name).substr(11, 1) == "Z" ? "7.5" : "0.30");
  }
  const auto table = parse_zemax(text);
  ASSERT_TRUE(table.ok()) << table.error().message;
  EXPECT_EQ(table->channel_count(), 3U);
  ASSERT_EQ(table->values.size(), 240U);
  EXPECT_EQ(table->values[0], 0.30);
  EXPECT_EQ(table->values[160], 7.5);
  EXPECT_EQ(table->tis.size(), 12U);
  EXPECT_THAT(parse_zemax(with_replaced(text, "TristimulusZ", "TristimulusY")).error().message,
              HasSubstr("'TristimulusY' where TristimulusZ is to stand"));
}

TEST(ZemaxParse, RefusesWhatIsWrongWithLineAndPlace) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {with_replaced(kZemaxText, "Source\tMeasured\n", ""), "Source is missing"},
      {with_replaced(kZemaxText, "ScatterRadial\t4\n0\t20\t90\t180\n", ""), "ScatterRadial is missing"},
      {with_replaced(kZemaxText, "ScatterType", "Symmetry"), "line 4: Symmetry stands there twice"},
      {with_replaced(kZemaxText, "ScatterType", "ScatterKind"), "line 4: 'ScatterKind' is no keyword of the header"},
      {with_replaced(kZemaxText, "\tBRDF", ""), "line 4: ScatterType has no value"},
      {with_replaced(kZemaxText, "BRDF", "BSDF"), "ScatterType is 'BSDF', which is none of BRDF, BTDF"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t3"),
       "2 angles of SampleRotation, but 3 are announced"},
      {with_replaced(kZemaxText, "ScatterRadial\t4", "ScatterRadial\t5"),
       "4 angles of ScatterRadial, but 5 are announced"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t1"), "more than the 1 angles of SampleRotation"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t0"), "not by a count of 1 to 65536"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t-1"), "not by a count"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t60000"),
       "60000 angles of SampleRotation, but only"},
      {with_replaced(kZemaxText, "SampleRotation\t2", "SampleRotation\t99999999999999999999"), "not by a count"},
      {with_replaced(kZemaxText, "10\t60", "10\t91"), "is 91, must be 0 to 90 degrees"},
      {with_replaced(kZemaxText, "10\t60", "-1\t60"), "is -1, must be 0 to 90 degrees"},
      {with_replaced(kZemaxText, "10\t60", "60\t60"), "must rise, but 60 follows 60"},
      {with_replaced(kZemaxText, "20\t90\t180", "20\t90\t181"), "must be 0 to 180 degrees"},
      {with_replaced(kZemaxText, "0\t90\t180\t270\t360", "-90\t90\t180\t270\t360"), "ScatterAzimuth spans 450 degrees"},
      {with_replaced(kZemaxText, "Asymmetrical4D", "PlaneSymmetrical"),
       "PlaneSymmetrical files list azimuths of 0 to 180"},
      {with_replaced(kZemaxText, "10\t60", "nan\t60"), "'nan' is no finite number"},
      {with_replaced(kZemaxText, "0.29", "NaN"), "'NaN' is no finite number"},
      {with_replaced(kZemaxText, "0.29", "inf"), "'inf' is no finite number"},
      {with_replaced(kZemaxText, "0.29", "1e999"), "'1e999' is no finite number"},
      {with_replaced(kZemaxText, "0.29", "1e38"), "is beyond 1e+37"},
      {with_replaced(kZemaxText, "0.29", "0x1p3"), "'0x1p3' is no finite number"},
      {with_replaced(kZemaxText, "0.29", "0,29"), "'0,29' is no finite number"},
      {with_replaced(kZemaxText, "0.29\t", ""),
       "3 numbers, not the 4 of ScatterRadial, at rotation 0, incidence 10, azimuth 0"},
      {with_replaced(kZemaxText, "0.29", "0.29 0.29"), "line 17: more numbers than the 4 of ScatterRadial"},
      {with_replaced(kZemaxText, "TIS\t0.5", "TIS"), "line 16: a number is missing"},
      {with_replaced(kZemaxText, "TIS\t0.5", "TIS 0.5 0.5"), "nothing may follow the value of TIS"},
      {with_replaced(kZemaxText, "0.30\t0.29\t0.24\t0.10\nTIS", "TIS"), "0 numbers, not the 4"},
      {with_replaced(kZemaxText, "DataEnd", "0.30\t0.29\t0.24\t0.10\nDataEnd"), "'0.30' where DataEnd is to stand"},
      {with_replaced(kZemaxText, "DataBegin", "DataStart"), "'DataStart' where DataBegin is to stand"},
      {kZemaxText + "x", "nothing may follow the last DataEnd"},
      {"", "the file ends early: no values follow the header"},
  };
  for (const auto& [text, message] : cases) {
    const auto table = parse_zemax(text);
    ASSERT_FALSE(table.ok()) << message;
    EXPECT_EQ(table.error().code, ErrorCode::kInvalidFile);
    EXPECT_THAT(table.error().message, HasSubstr(message));
    ASSERT_TRUE(table.error().offset.has_value());
    EXPECT_LE(*table.error().offset, text.size());
  }
  EXPECT_EQ(parse_zemax(with_replaced(kZemaxText, "0.29", "NaN")).error().offset, kZemaxText.find("0.30\t0.29"));
}

TEST(ZemaxParse, HoldsHugeCountsAgainstTheBytesThatAreLeft) {
  std::string list;
  for (int k = 0; k < 2000; ++k) list += std::to_string(k * 0.04) + " ";
  const std::string text =
      "Source M\nSymmetry Asymmetrical\nSpectralContent Monochrome\nScatterType BRDF\nSampleRotation 2000\n" + list +
      "\nAngleOfIncidence 2000\n" + list + "\nScatterAzimuth 2000\n" + list + "\nScatterRadial 2000\n" + list +
      "\nMonochrome\nDataBegin\n";
  EXPECT_THAT(parse_zemax(text).error().message, HasSubstr("2000 x 2000 x 2000 x 2000 values"));
}

TEST(ZemaxParse, RefusesEachTruncation) {
  const std::string text = kZemaxText.substr(0, kZemaxText.rfind("DataEnd") + 7);
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(parse_zemax(text.substr(0, size)).ok()) << size;
  }
  EXPECT_TRUE(parse_zemax(text).ok());
}

TEST(ZemaxParse, TakesValuesTooSmallForADoubleAsZero) {
  EXPECT_EQ(parse_zemax(with_replaced(kZemaxText, "0.29", "1e-400"))->values[1], 0);
}

TEST(ZemaxRecognise, WantsTwoKeywordsAtTheBeginning) {
  const auto recognised = [](const std::string& text) { return recognises_zemax(small_files::bytes_of(text)); };
  EXPECT_TRUE(recognised(kZemaxText));
  EXPECT_TRUE(recognised("# c\n\nsource\tx\nSYMMETRY y"));
  EXPECT_TRUE(recognised("SampleRotation 2\n0 1\nAngleOfIncidence 3\n"));
  for (const char* text : {"", "# only a comment\n", "Source Measured\n", "Source,Symmetry\nSymmetry,Source\n",
                           "theta_i phi_i\nSource a\nSymmetry b\n", "Source\nSymmetry\n", "1 2 3\n4 5 6\n"}) {
    EXPECT_FALSE(recognised(text)) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
