#include "tools/charts/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <sstream>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"
#include "tools/charts/label_places.h"
#include "tools/charts/svg.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kGolden = SBRDF_SOURCE_DIR "/tests/vectors/charts/example.svg";

Chart example_chart() {
  Chart chart;
  chart.title = "Leather & <silk>: time against error";
  chart.x_title = "error [%]";
  chart.y_title = "time [ns]";
  chart.x_least = 0.001;
  chart.pareto_front = true;
  chart.filled_name = "in a batch";
  chart.hollow_name = "one at a time";
  chart.series = {{"model", 0, false, {{0, 300, 320}}},
                  {"slices", 1, true, {{2, 110, 130, "1,000"}, {0.7, 120, 145, "3,000"}, {0.2, 150, 180, "8,911"}}},
                  {"table", 2, false, {{1.5, 190, 190, ""}}}};
  chart.levels = {{195, "yardstick"}};
  chart.footnote = "a machine, 2 cores";
  return chart;
}

/// The pixels of a picture, as another program draws it.
class Raster {
 public:
  explicit Raster(const std::string& svg) {
    const ScratchFolder folder;
    write_bytes(folder / "chart.svg", bytes_of(svg));
    const ProgramRun drawn = run_command({"rsvg-convert", folder / "chart.svg", "-o", folder / "chart.png"});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const ProgramRun read =
        run_command({"oiiotool", folder / "chart.png", "--ch", "0,1,2", "-d", "uint8", "-o", folder / "chart.ppm"});
    EXPECT_EQ(read.exit_code, 0) << read.err << read.out;
    const std::string ppm = read_text(folder / "chart.ppm");
    std::istringstream head(ppm);
    std::string kind;
    int most = 0;
    head >> kind >> width >> height >> most;
    EXPECT_EQ(kind, "P6");
    EXPECT_EQ(most, 255);
    pixels_ = ppm.substr(std::min(ppm.size(), static_cast<std::size_t>(head.tellg()) + 1));
    EXPECT_EQ(pixels_.size(), 3 * width * height);
  }
  /// 0xRRGGBB.
  [[nodiscard]] unsigned at(double x, double y) const {
    const std::size_t first = 3 * (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x));
    unsigned colour = 0;
    for (std::size_t c = 0; c < 3; ++c) colour = colour << 8U | static_cast<unsigned char>(pixels_.at(first + c));
    return colour;
  }
  [[nodiscard]] std::size_t count(unsigned colour) const {
    std::size_t found = 0;
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) found += at(static_cast<double>(x), static_cast<double>(y)) == colour;
    }
    return found;
  }

  std::size_t width = 0;
  std::size_t height = 0;

 private:
  std::string pixels_;
};

TEST(Chart, IsDrawnWithTheSameBytesAsEver) {
  const std::string svg = draw_chart(example_chart());
  EXPECT_EQ(svg, read_text(kGolden)) << "look at the new picture before it takes the place of the old one";
  EXPECT_EQ(svg, draw_chart(example_chart()));
}

TEST(Chart, IsAPictureThatAnotherProgramDrawsWithEveryMarkerInItsPlace) {
  const Raster raster(draw_chart(example_chart()));
  EXPECT_EQ(raster.width, kChartWidth);
  EXPECT_EQ(raster.height, kChartHeight);
  EXPECT_EQ(raster.at(2, 2), 0xFFFFFFU);
  EXPECT_GT(raster.count(0x000000), 500U) << "frame and text";
  EXPECT_GT(raster.count(0x0072B2), 100U) << "three filled squares";
  EXPECT_GT(raster.count(0xD55E00), 20U) << "a filled triangle";
  // The axes run from 0.0005 to 5 and from 100 to 500 over the plot, 92 to 690 and 476 to 48 pixels.
  const auto x_of = [](double x) { return 92 + (690 - 92) * std::log10(x / 0.0005) / 4; };
  const auto y_of = [](double y) { return 476 - (476 - 48) * std::log(y / 100) / std::log(5); };
  EXPECT_EQ(raster.at(x_of(0.7), y_of(120)), 0x0072B2U);
  EXPECT_EQ(raster.at(x_of(0.2), y_of(150)), 0x0072B2U);
  EXPECT_EQ(raster.at(x_of(0.2), y_of(180)), 0xFFFFFFU) << "hollow";
  EXPECT_EQ(raster.at(x_of(1.5), y_of(190)), 0xD55E00U);
  EXPECT_EQ(raster.at(x_of(0.001), y_of(300)), 0x000000U) << "an error of 0 stands at the least";
  EXPECT_EQ(raster.at(x_of(0.01), y_of(300)), 0xBBBBBBU) << "the front leads from the exact one to the right";
}

TEST(Chart, EscapesTextAndDropsWhatIsNone) {
  Chart chart = example_chart();
  chart.series[0].name = "<b>\"x\" & 'y'\x01\xFF\n</text>";
  const std::string svg = draw_chart(chart);
  EXPECT_THAT(svg, HasSubstr("&lt;b&gt;&quot;x&quot; &amp; &#39;y&#39;???&lt;/text&gt;"));
  EXPECT_THAT(svg, HasSubstr("<title>Leather &amp; &lt;silk&gt;: time against error</title>"));
  const Raster raster(svg);
  EXPECT_EQ(raster.width, kChartWidth);
}

TEST(Chart, LeavesOutWhatHasNoPlaceOnALogarithmicAxis) {
  Chart chart;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  chart.series = {
      {"odd", 1, true, {{1, 0}, {1, -2}, {nan, 3}, {infinite, 3}, {3, nan}, {3, infinite}, {0, 4}, {-1, 4}}}};
  const std::string svg = draw_chart(chart);
  for (const char* bad : {"nan", "inf"}) EXPECT_THAT(svg, Not(HasSubstr(bad)));
  chart.series[0].points.push_back({2, 5});
  EXPECT_GT(Raster(draw_chart(chart)).count(0x0072B2), 80U) << "one marker in the plot and one in the legend";
}

TEST(Chart, BreaksLongNamesIntoLinesThatStayInThePicture) {
  Chart chart = example_chart();
  chart.series[1].name = "a name of many words that would run out of the picture on one line";
  chart.series[2].name = std::string(70, 'x');
  const std::string svg = draw_chart(chart);
  EXPECT_THAT(svg, HasSubstr(">a name of many words that would<"));
  const Raster raster(svg);
  for (double y = 0; y < kChartHeight; ++y) EXPECT_EQ(raster.at(kChartWidth - 2, y), 0xFFFFFFU) << y;
}

TEST(ParetoFront, HoldsWhatNothingElseBeatsInBoth) {
  const std::vector<ChartPoint> front =
      pareto_front({{3, 3}, {1, 9}, {2, 5}, {2, 4}, {4, 3}, {5, 1}, {6, 2}, {1, 10}, {9, 1}});
  std::vector<std::pair<double, double>> found;
  for (const ChartPoint& point : front) found.emplace_back(point.x, point.y);
  EXPECT_THAT(found,
              testing::ElementsAre(std::pair(1.0, 9.0), std::pair(2.0, 4.0), std::pair(3.0, 3.0), std::pair(5.0, 1.0)));
}

TEST(LabelPlaces, PutLabelsWhereNothingElseIs) {
  LabelPlaces places({0, 0, 200, 200});
  const Spot first = places.place({100, 100}, 40, 10);
  EXPECT_GT(first.x, 100) << "to the right of its point while that is free";
  const Spot second = places.place({100, 100}, 40, 10);
  EXPECT_LT(second.x + 40, 100) << "then to its left";
  const Spot third = places.place({195, 195}, 40, 10);
  EXPECT_LE(third.x + 40, 200) << "inside";
  EXPECT_LE(third.y, 200);
}

}  // namespace
}  // namespace sbrdf::internal
