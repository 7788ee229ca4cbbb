#include "formats/table/number_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(NumberTableParse, ReadsCommasSemicolonsAndBlanks) {
  for (const char* text : {"1,2,-3e-1\n4,5,+6\n", "1; 2 ;-.3\r\n\r\n4;5;6.0", "  1 \t2   -0.3\n4 5 6  \n",
                           "\xEF\xBB\xBF# a comment\n%another\n1 2 -0.3\n# between\n4 5 6"}) {
    const auto table = parse_number_table(text);
    ASSERT_TRUE(table.ok()) << text << table.error().message;
    EXPECT_EQ(table->column_count, 3U);
    EXPECT_THAT(table->numbers, ElementsAre(1, 2, -0.3, 4, 5, 6)) << text;
    EXPECT_THAT(table->names, IsEmpty());
  }
}

TEST(NumberTableParse, TellsNamesFromCommentsAndLines) {
  const auto named = parse_number_table("# made by hand\ntheta [deg], 550 nm\n1,2\n\n3,4\n");
  ASSERT_TRUE(named.ok()) << named.error().message;
  EXPECT_THAT(named->names, ElementsAre("theta [deg]", "550 nm"));
  EXPECT_THAT(named->comment_names, IsEmpty());
  EXPECT_THAT(named->lines, ElementsAre(3, 5));
  const auto spectral = parse_number_table("theta_i,400,410\n1,2,3\n");
  ASSERT_TRUE(spectral.ok()) << spectral.error().message;
  EXPECT_THAT(spectral->names, ElementsAre("theta_i", "400", "410"));
  const auto commented = parse_number_table("# x\n# a  b\n1 2\n# c d\n3 4");
  ASSERT_TRUE(commented.ok());
  EXPECT_THAT(commented->comment_names, ElementsAre("a", "b"));
}

TEST(NumberTableParse, NamesLineAndColumnOfWhatIsWrong) {
  const auto message = [](const std::string& text) { return parse_number_table(text).error().message; };
  EXPECT_EQ(message("1 2\n3 x\n"), "line 2: column 2 is 'x', no number");
  EXPECT_EQ(message("1 2\n\nnan 4\n"), "line 3: column 1 is 'nan', not finite");
  EXPECT_EQ(message("1 1e999\n"), "line 1: column 2 is '1e999', not finite");
  EXPECT_EQ(message("1;2\n3;4,5\n"), "line 2: column 2 is '4,5', no number");
  EXPECT_EQ(message("1,2\n3,\n"), "line 2: column 2 is '', no number");
  EXPECT_EQ(message("1 2\n3 4 5\n"), "line 2: 3 fields instead of 2");
  EXPECT_EQ(message("a b c\n1 2\n"), "line 2: 2 fields below a line of names that has others");
  EXPECT_EQ(message("a b\nc d\n1 2\n"), "line 2: column 1 is 'c', no number");
  EXPECT_EQ(message("1 2\n3 \x01\x80\n"),
            "line 2: column 2 is '?"
            "?', no number");
  EXPECT_THAT(message(""), HasSubstr("no line of numbers"));
  EXPECT_THAT(message("# only\n"), HasSubstr("no line of numbers"));
  EXPECT_THAT(message(std::string(2000000, ' ') + "1\n"), HasSubstr("longer than"));
  EXPECT_THAT(message(std::string(9000, ',') + "\n1\n"), HasSubstr("columns"));
}

TEST(NumberTableParse, ReadsNumbersTooCloseToZeroAsZero) {
  EXPECT_THAT(parse_number_table("1e-999 0.000 -2e-500")->numbers, ElementsAre(0, 0, 0));
  EXPECT_THAT(parse_number_table("4.9e-324")->numbers, ElementsAre(4.9e-324));
}

TEST(NumberTableLookAt, TakesRowsOfFiveNumbersBelowAtMostOneLineOfNames) {
  using Look = NumberTableLook;
  const auto look = [](const std::string& text, bool whole = true) { return look_at_number_table(text, whole); };
  EXPECT_EQ(look("1 2 3 4 5"), Look::kTable);
  EXPECT_EQ(look("# c\n\na,b,c,d,e\n1,2,3,4,5\n"), Look::kTable);
  EXPECT_EQ(look("1 2 3 4"), Look::kNone);
  EXPECT_EQ(look("theta_i,phi_i\n1,2\n"), Look::kNone);
  EXPECT_EQ(look("Source Measured\n1 2 3 4 5\n"), Look::kNone);
  EXPECT_EQ(look("a b c d e\nf g h i j\n1 2 3 4 5\n"), Look::kNone);
  EXPECT_EQ(look("a 2 c d e\n1 2 3 4 5\n"), Look::kNone);
  EXPECT_EQ(look("# only a comment\n"), Look::kNone);
  EXPECT_EQ(look("# the beginning of a long comment", false), Look::kComments);
  EXPECT_EQ(look("theta_i,phi_i,theta_v,phi_v,400,410,4", false), Look::kComments);
  EXPECT_EQ(look("{\"theta_i\": [1, 2, 3, 4, 5], \"x", false), Look::kNone);
  EXPECT_EQ(look("the beginning of a long line of some text", false), Look::kNone);
  EXPECT_EQ(look("1 2 3 4 5 6e", false), Look::kTable);
  EXPECT_EQ(look("1 2 3 4 5", false), Look::kNone);  // the fifth may go on
}

}  // namespace
}  // namespace sbrdf::internal
