#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "converters/files/format_table.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

TEST(FormatsCommand, PrintsWhatEachCanHoldWithin120Columns) {
  const std::string text = run_sbrdf({"formats"}).out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120) << line;
  const std::size_t holds = text.find("can hold");
  ASSERT_NE(holds, std::string::npos);
  for (const Format& format : formats()) {
    const std::size_t row = text.find("\n" + std::string(format.name) + " ", holds);
    ASSERT_NE(row, std::string::npos) << format.name;
    const std::string line = text.substr(row + 1, text.find('\n', row + 1) - row);
    EXPECT_THAT(line, HasSubstr(std::string(format.holds.channels)));
    std::istringstream words(line);
    std::string name, anisotropic, non_reciprocal, unmeasured, negatives;
    words >> name >> anisotropic >> non_reciprocal >> unmeasured >> negatives;
    EXPECT_EQ(anisotropic, format.holds.anisotropic ? "yes" : "-") << line;
    EXPECT_EQ(non_reciprocal, format.holds.non_reciprocal ? "yes" : "-") << line;
    EXPECT_EQ(unmeasured, format.holds.unmeasured ? "yes" : "-") << line;
    EXPECT_EQ(negatives, format.holds.negatives ? "yes" : "-") << line;
  }
}

TEST(FormatsCommand, PrintsEveryOptionOfEachFormatAsJson) {
  const auto json = run_sbrdf({"formats", "--json"}).json()["formats"];
  ASSERT_EQ(json.size(), formats().size());
  for (std::size_t k = 0; k < json.size(); ++k) {
    const Format& format = formats()[k];
    EXPECT_EQ(json[k]["name"], format.name);
    EXPECT_EQ(json[k]["page"], format.page);
    EXPECT_EQ(json[k]["holds"]["channels"], format.holds.channels);
    EXPECT_EQ(json[k]["holds"]["values"], format.holds.values);
    EXPECT_EQ(json[k]["holds"]["anisotropic"], format.holds.anisotropic);
    ASSERT_EQ(json[k]["options"].size(), format.options.size());
    for (std::size_t o = 0; o < format.options.size(); ++o) {
      EXPECT_EQ(json[k]["options"][o]["name"], format.options[o].name);
      EXPECT_EQ(json[k]["options"][o]["meaning"], format.options[o].meaning);
      EXPECT_EQ(json[k]["options"][o].contains("choices"), format.options[o].kind == OptionKind::kChoice);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
