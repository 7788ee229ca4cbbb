#include "converters/baselines/schemes.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

struct Row {
  std::uint64_t sum, pairs, reciprocal;
};
/// The lines "sum", "illum. x view" and "reciprocal" of Table 1.
const std::array kStated = {
    Row{29, 841, 435},        Row{37, 1369, 703},      Row{41, 1681, 861},      Row{47, 2209, 1128},
    Row{57, 3249, 1653},      Row{79, 6241, 3160},     Row{67, 4489, 2278},     Row{87, 7569, 3828},
    Row{87, 7569, 3828},      Row{97, 9409, 4753},     Row{101, 10201, 5151},   Row{109, 11881, 5995},
    Row{117, 13689, 6903},    Row{133, 17689, 8911},   Row{131, 17161, 8646},   Row{137, 18769, 9453},
    Row{163, 26569, 13366},   Row{169, 28561, 14365},  Row{193, 37249, 18721},  Row{187, 34969, 17578},
    Row{227, 51529, 25878},   Row{259, 67081, 33670},  Row{313, 97969, 49141},  Row{233, 54289, 27261},
    Row{299, 89401, 44850},   Row{315, 99225, 49770},  Row{369, 136161, 68265}, Row{497, 247009, 123753},
    Row{553, 305809, 153181}, Row{841, 707281, 354061}};

TEST(Schemes, OfThePaperHaveTheCountsOfItsTable1) {
  const std::vector<UniformScheme> schemes = paper_schemes();
  ASSERT_EQ(schemes.size(), kStated.size());
  for (std::size_t k = 0; k < schemes.size(); ++k) {
    const UniformScheme& scheme = schemes[k];
    EXPECT_EQ(scheme.name, std::to_string(k + 1));
    EXPECT_EQ(scheme.direction_count(), kStated[k].sum) << scheme.name;
    EXPECT_EQ(scheme.pair_count(), kStated[k].pairs) << scheme.name;
    EXPECT_EQ(scheme.reciprocal_pair_count(), kStated[k].reciprocal) << scheme.name;
    EXPECT_EQ(scheme.rings.back().theta_deg, 80);
    for (const Ring& ring : scheme.rings) EXPECT_EQ(360 % ring.count, 0U) << "the step is a whole number of degrees";
  }
  EXPECT_EQ(paper_scheme("19").value().reciprocal_pair_count(), 18721U) << "18,712 in the text is a misprint";
  for (const std::string name : {"0", "31", "", "14 ", "x"}) EXPECT_FALSE(paper_scheme(name)) << name;
}

TEST(Schemes, HaveTheirDirectionsRingByRing) {
  const UniformScheme scheme = paper_scheme("3").value();
  const std::vector<glm::dvec3> directions = scheme_directions(scheme);
  ASSERT_EQ(directions.size(), 41U);
  EXPECT_LT(glm::length(directions[0] - glm::dvec3(0, 0, 1)), 1e-12);
  const double theta = 28 * std::acos(-1.0) / 180;
  const double phi = 36 * std::acos(-1.0) / 180;
  EXPECT_LT(glm::length(directions[1] - glm::dvec3(std::sin(theta), 0, std::cos(theta))), 1e-12);
  EXPECT_LT(glm::length(directions[2] -
                        glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))),
            1e-12);
}

TEST(Schemes, OfAFileAreRead) {
  const Result<UniformScheme> scheme =
      parse_scheme(R"({"name": "mine", "rings": [{"theta_deg": 0, "count": 1}, {"theta_deg": 40.5, "count": 7}]})");
  ASSERT_TRUE(scheme) << scheme.error().message;
  EXPECT_EQ(scheme->name, "mine");
  EXPECT_EQ(scheme->direction_count(), 8U);
  EXPECT_EQ(scheme->rings[1].theta_deg, 40.5);
}

TEST(Schemes, OfAFileAreRefusedWithWhatIsWrong) {
  const auto refusal = [](const std::string& rings) {
    const Result<UniformScheme> scheme = parse_scheme(R"({"name": "x", "rings": [)" + rings + "]}");
    return scheme ? "" : scheme.error().message;
  };
  const std::string normal = R"({"theta_deg": 0, "count": 1})";
  for (const auto& [rings, what] : std::vector<std::pair<std::string, std::string>>{
           {normal, "'rings' has fewer than two"},
           {R"({"theta_deg": 1, "count": 1})", "rings[0]: 'theta_deg' is not 0"},
           {R"({"theta_deg": 0, "count": 2})", "rings[0]: 'count' is not 1"},
           {normal + R"(, {"theta_deg": 0, "count": 6})", "rings[1]: 'theta_deg' is not above"},
           {normal + R"(, {"theta_deg": 90, "count": 6})", "rings[1]: 'theta_deg' is not below 90"},
           {normal + R"(, {"theta_deg": -5, "count": 6})", "rings[1]: 'theta_deg'"},
           {normal + R"(, {"theta_deg": 30, "count": 2})", "rings[1]: 'count' is below 3"},
           {normal + R"(, {"theta_deg": 30, "count": 6.5})", "rings[1]: 'count' is no whole number"},
           {normal + R"(, {"theta_deg": 30, "count": 5000})", "rings[1]: 'count'"},
           {normal + R"(, {"theta_deg": 30, "count": 4096})", "4097 directions"},
           {normal + R"(, {"theta_deg": 30, "step": 6})", "'step' is not known"},
           {"1, 2", "rings[0]: 'theta_deg' is missing"}}) {
    EXPECT_THAT(refusal(rings), HasSubstr(what)) << rings;
  }
  for (const std::string text : {"", "[]", "{", R"({"rings": []})", R"({"name": 1, "rings": []})"}) {
    EXPECT_FALSE(parse_scheme(text)) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
