#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

TEST(SchemesCommand, ListsThoseOfThePaper) {
  const ProgramRun run = run_sbrdf({"schemes"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("18,721"));
  const auto json = run_sbrdf({"schemes", "--json"}).json();
  ASSERT_EQ(json.size(), 30U);
  EXPECT_EQ(json[13]["name"], "14");
  EXPECT_EQ(json[13]["directions"], 133);
  EXPECT_EQ(json[13]["pairs"], 17689);
  EXPECT_EQ(json[13]["reciprocal_pairs"], 8911);
  EXPECT_EQ(json[13]["rings"][7]["theta_deg"], 80);
  EXPECT_EQ(json[13]["rings"][7]["azimuth_step_deg"], 10);
  EXPECT_EQ(json[13]["rings"][7]["count"], 36);
}

TEST(SchemesCommand, ReadsAFileAndNamesWhatIsWrong) {
  const ScratchFolder folder;
  const std::string file = folder / "mine.json";
  write_bytes(file, bytes_of(R"({"name": "mine", "rings": [{"theta_deg": 0, "count": 1},
                                                               {"theta_deg": 40, "count": 9}]})"));
  const ProgramRun run = run_sbrdf({"schemes", file, "14"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("mine"));
  EXPECT_THAT(run.out, HasSubstr("40 deg"));
  write_bytes(file, bytes_of(R"({"name": "mine", "rings": []})"));
  expect_failure(run_sbrdf({"schemes", file}), 3, file, "'rings' has fewer than two");
  expect_failure(run_sbrdf({"schemes", folder / "none.json"}), 2, folder / "none.json", "");
  expect_failure(run_sbrdf({"schemes", "31"}), 1, "31", "there is no scheme");
}

}  // namespace
}  // namespace sbrdf::internal
