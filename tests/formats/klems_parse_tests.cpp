#include "formats/klems/klems.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

Result<KlemsMatrix> parse(const std::string& text, const KlemsChoice& choice = {}) {
  return parse_klems(small_files::bytes_of(text), choice);
}

const std::string kKlemsText = small_files::klems_text();

/// A file that names a basis without defining it, with `count` numbers.
std::string undefined(const std::string& name, std::size_t count) {
  const std::size_t first = kKlemsText.find("<AngleBasisBlock>");
  const std::size_t end = kKlemsText.find("</AngleBasis>");
  std::string text = replaced(kKlemsText.substr(0, first) + kKlemsText.substr(end), "Five", name);
  const std::size_t numbers = text.find("<ScatteringData>") + 16;
  std::string list;
  for (std::size_t k = 0; k < count; ++k) list += "0.1\n";
  return text.substr(0, numbers) + list + text.substr(text.find("</ScatteringData>"));
}

TEST(KlemsBasis, FindsPatchesByRingAndAzimuth) {
  const KlemsBasis full(known_klems_rings("lbnl/KLEMS full", 0));
  ASSERT_EQ(full.patch_count(), 145U);
  EXPECT_EQ(full.patch_of(0, 77), 0U);
  EXPECT_EQ(full.patch_of(4.999, 200), 0U);
  EXPECT_EQ(full.patch_of(5, 0), 1U);          // a bound belongs to the outer ring
  EXPECT_EQ(full.patch_of(5 - 1e-12, 0), 1U);  // and so does what rounding makes of it
  EXPECT_EQ(full.patch_of(10, 22.4), 1U);
  EXPECT_EQ(full.patch_of(10, 22.6), 2U);
  EXPECT_EQ(full.patch_of(10, -22.4), 1U);
  EXPECT_EQ(full.patch_of(10, 340), 1U);
  EXPECT_EQ(full.patch_of(10, 337), 8U);
  EXPECT_EQ(full.patch_of(90, 330), 144U);
  EXPECT_EQ(full.patch_of(90, 360 * 5 + 30), 134U);
}

TEST(KlemsBasis, CentresLieInTheirPatches) {
  for (const auto& [name, count] : {std::pair("LBNL/Klems Full", 145), std::pair("LBNL/Klems Half", 77),
                                    std::pair("LBNL/Klems Half", 73), std::pair("LBNL/Klems Quarter", 41)}) {
    const KlemsBasis basis(known_klems_rings(name, static_cast<std::size_t>(count)));
    ASSERT_EQ(basis.patch_count(), static_cast<std::size_t>(count)) << name;
    double sum = 0;
    for (std::size_t k = 0; k < basis.patch_count(); ++k) {
      const KlemsBasis::Patch patch = basis.patch(k);
      EXPECT_EQ(basis.patch_of((patch.ring.lower_deg + patch.ring.upper_deg) / 2, patch.phi_deg), k);
      sum += basis.projected_solid_angle(k);
    }
    EXPECT_NEAR(sum, std::numbers::pi, 1e-12) << name;
  }
  EXPECT_TRUE(known_klems_rings("LBNL/Klems Half", 75).empty());
  EXPECT_TRUE(known_klems_rings("LBNL/Klems Eighth", 145).empty());
}

TEST(KlemsParse, ColumnsAreIncidentUnlessTheFileSaysRows) {
  const auto columns = parse(kKlemsText);
  ASSERT_TRUE(columns.ok()) << columns.error().message;
  EXPECT_EQ(columns->material, "small");
  EXPECT_EQ(columns->incident.patch_count(), 5U);
  EXPECT_EQ(columns->value(1, 0), 0.02);  // the second number of the first line
  EXPECT_EQ(columns->value(0, 1), 0.06);
  const auto rows = parse(replaced(kKlemsText, ">Columns<", "> rows <"));
  EXPECT_EQ(rows->value(0, 1), 0.02);
  EXPECT_EQ(rows->value(1, 0), 0.06);
}

TEST(KlemsParse, KnowsTheBasesThatFilesOnlyName) {
  for (const auto& [name, count] : {std::pair("LBNL/Klems Full", 145), std::pair("LBNL/klems half", 77),
                                    std::pair("LBNL/Klems Half", 73), std::pair("LBNL/Klems Quarter", 41)}) {
    const auto matrix = parse(undefined(name, static_cast<std::size_t>(count * count)));
    ASSERT_TRUE(matrix.ok()) << name << ": " << matrix.error().message;
    EXPECT_EQ(matrix->outgoing.patch_count(), static_cast<std::size_t>(count));
    EXPECT_FALSE(parse(undefined(name, static_cast<std::size_t>(count * count - 1))).ok());
  }
}

TEST(KlemsParse, TakesTheBlockThatIsAskedForAndListsTheOthers) {
  const KlemsChoice back = {.side = KlemsSide::kBack};
  EXPECT_EQ(parse(kKlemsText, back).error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(parse(kKlemsText, back).error().message,
              HasSubstr("no visible reflection back in the file, which holds Visible Reflection Front"));
  const std::string transmission = replaced(kKlemsText, "Reflection Front", "Transmission Front");
  EXPECT_THAT(parse(transmission).error().message, HasSubstr("--klems-transmission reads a transmission"));
  EXPECT_TRUE(parse(transmission, {.transmission = true}).ok());
  const std::string solar = replaced(replaced(kKlemsText, "Visible", "SOLAR"), "Reflection Front", "reflection back");
  EXPECT_TRUE(parse(solar, {.side = KlemsSide::kBack, .band = KlemsBand::kSolar}).ok());
  const std::size_t block = kKlemsText.find("<WavelengthData>");
  const std::string twice = kKlemsText.substr(0, block) +
                            kKlemsText.substr(block, kKlemsText.find("</Layer>") - block) + kKlemsText.substr(block);
  EXPECT_THAT(parse(twice).error().message, HasSubstr("two blocks of visible reflection front"));
}

TEST(KlemsParse, RefusesWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {replaced(kKlemsText, "0.25", ""), "24 numbers in ScatteringData of Visible Reflection Front, where 5 x 5 = 25"},
      {replaced(kKlemsText, "0.25", "0.25 1"), "26 numbers"},
      {replaced(kKlemsText, "0.08, ", " , "), "a number of ScatteringData is missing behind 7"},
      {replaced(kKlemsText, "0.08", "nan"), "number 8 of ScatteringData is 'nan'"},
      {replaced(kKlemsText, "0.08", "1e999"), "number 8"},
      {replaced(kKlemsText, "0.08", "0.0.8"), "number 8"},
      {replaced(kKlemsText, ">Columns<", ">Diagonal<"), "IncidentDataStructure is 'Diagonal'"},
      {replaced(kKlemsText, ">Columns<", "><"), "IncidentDataStructure is ''"},
      {replaced(kKlemsText, "<nPhis>4<", "<nPhis>0<"), "nPhis of a ring is '0'"},
      {replaced(kKlemsText, "<nPhis>4<", "<nPhis>4000000000<"), "not 1 to 3600"},
      {replaced(kKlemsText, "<nPhis>4<", "<nPhis>5<"),
       "25 numbers in ScatteringData of Visible Reflection Front, where 6 x 6"},
      {replaced(kKlemsText, "<LowerTheta>30<", "<LowerTheta>31<"),
       "a ring spans theta 31 to 90, where it should go on from 30"},
      {replaced(kKlemsText, "<UpperTheta>90<", "<UpperTheta>80<"), "end at 80, not at 90 degrees"},
      {replaced(kKlemsText, "<LowerTheta>30</LowerTheta>", ""), "a ring of an AngleBasis without ThetaBounds"},
      {replaced(kKlemsText, "<RowAngleBasis>Five<", "<RowAngleBasis>Six<"),
       "RowAngleBasis is 'Six', which the file does not"},
      {replaced(kKlemsText, "<RowAngleBasis>Five<", "<RowAngleBasis><"), "RowAngleBasis is missing"},
      {replaced(kKlemsText, "<Layer>", "<Sheet>"), "not whole XML"},
      {replaced(replaced(kKlemsText, "<Optical>", "<O>"), "</Optical>", "</O>"), "no Layer with WavelengthData"},
      {"<?xml version=\"1.0\"?><a/>", "no root element WindowElement"},
      {"", "not whole XML"},
  };
  for (const auto& [text, message] : cases) {
    const auto matrix = parse(text);
    ASSERT_FALSE(matrix.ok()) << message;
    EXPECT_EQ(matrix.error().code, ErrorCode::kInvalidFile) << message;
    EXPECT_THAT(matrix.error().message, HasSubstr(message));
  }
  EXPECT_EQ(parse(replaced(kKlemsText, "0.25", "")).error().offset, kKlemsText.find("<ScatteringData>") + 1);
}

TEST(KlemsParse, NamesTensorTreesAndOtherKindsOfValues) {
  const auto tree = parse(replaced(kKlemsText, ">Columns<", ">TensorTree4<"));
  EXPECT_EQ(tree.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(tree.error().message, HasSubstr("a tensor tree (TensorTree4)"));
  const auto fractions = parse(replaced(kKlemsText, ">BTDF<", ">Fractional Diffuse<"));
  EXPECT_EQ(fractions.error().code, ErrorCode::kUnsupported);
}

TEST(KlemsParse, RefusesEachTruncation) {
  const std::string text = kKlemsText.substr(0, kKlemsText.rfind('>') + 1);
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(parse(text.substr(0, size)).ok()) << size;
  }
  EXPECT_TRUE(parse(text).ok());
}

TEST(KlemsRecognise, LooksBehindADoctypeAndReadsNothingOfIt) {
  const std::size_t root = kKlemsText.find("<WindowElement");
  const auto with = [&](const std::string& doctype) {
    return kKlemsText.substr(0, root) + doctype + kKlemsText.substr(root);
  };
  for (const char* doctype :
       {"<!DOCTYPE WindowElement>", "<!DOCTYPE WindowElement SYSTEM \"a>b.dtd\">",
        "<!DOCTYPE WindowElement PUBLIC 'x' 'y'>\n", "<!DOCTYPE WindowElement [<!ENTITY a \"]>\"> <!ENTITY b 'x'>]>"}) {
    EXPECT_TRUE(recognises_klems(small_files::bytes_of(with(doctype)))) << doctype;
    const auto parsed = parse(with(doctype));
    ASSERT_TRUE(parsed.ok()) << doctype << parsed.error().message;
    EXPECT_EQ(parsed->values, parse(kKlemsText)->values);
  }
  for (const char* doctype : {"<!DOCTYPE WindowElement", "<!DOCTYPE [", "<!DOCTYPE \">", "<!DOCTYPE html><html>"}) {
    EXPECT_FALSE(recognises_klems(small_files::bytes_of(with(doctype)))) << doctype;
  }
}

TEST(KlemsRecognise, LooksForTheRootElement) {
  const auto recognised = [](const std::string& text) { return recognises_klems(small_files::bytes_of(text)); };
  EXPECT_TRUE(recognised(kKlemsText));
  EXPECT_TRUE(recognised("\xEF\xBB\xBF \n<!-- a --><?b?>\n<WindowElement>"));
  for (const char* text : {"", "<WindowElementType>", "<WindowElement", "<?xml <WindowElement>", "<!-- <WindowElement>",
                           "<a><WindowElement>", "WindowElement"}) {
    EXPECT_FALSE(recognised(text)) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
