#include "tools/charts/strips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/charts/svg.h"

namespace sbrdf::internal {
namespace {

constexpr double kWidth = 960;
constexpr double kLeft = 210;
constexpr double kRight = 810;
constexpr double kTop = 84;
constexpr double kLine = 24;
constexpr double kBelow = 78;
constexpr double kMeanRadius = 6.5;
constexpr double kValueRadius = 3.5;
constexpr std::string_view kPlain = "#000000";
constexpr std::string_view kColour = "#D55E00";  // of Okabe and Ito

bool is_drawn(double value) { return std::isfinite(value) && value > 0; }

LogAxis axis_of(const StripChart& chart) {
  std::vector<double> values;
  for (const Strip& strip : chart.strips) {
    for (const double value : strip.values) values.push_back(value);
    if (strip.mean) values.push_back(*strip.mean);
  }
  std::erase_if(values, [](double value) { return !is_drawn(value); });
  if (values.empty()) return LogAxis::around(1, 10, chart.numerals);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return LogAxis::around(*least, *most, chart.numerals);
}

double bottom_of(const StripChart& chart) { return kTop + kLine * static_cast<double>(chart.strips.size()); }

void draw_legend(SvgPicture& picture, const StripChart& chart) {
  constexpr double kY = 52;
  picture.marker(Marker::kDiamond, {kLeft + 6, kY}, kMeanRadius, kPlain, true);
  picture.text({kLeft + 18, kY + 4}, chart.mean_name, {.size = 11});
  const double next = kLeft + 40 + text_width(chart.mean_name, 11);
  picture.marker(Marker::kCircle, {next, kY}, kValueRadius, kPlain, false);
  picture.text({next + 10, kY + 4}, chart.value_name, {.size = 11});
  picture.text({kRight + 12, kTop - 8}, chart.remark_name, {.size = 10, .colour = "#555555"});
}

void draw_strip(SvgPicture& picture, const Strip& strip, double y, const LogAxis& axis) {
  const auto x_of = [&](double value) { return kLeft + (kRight - kLeft) * axis.place(value); };
  const std::string_view colour = strip.stands_out ? kColour : kPlain;
  picture.line({kLeft, y}, {kRight, y}, {"#DDDDDD", 1});
  picture.text({kLeft - 8, y + 4}, strip.name,
               {.size = 11, .anchor = Anchor::kEnd, .colour = colour, .bold = strip.stands_out});
  for (const double value : strip.values) {
    if (is_drawn(value)) picture.marker(Marker::kCircle, {x_of(value), y}, kValueRadius, colour, false);
  }
  if (strip.mean && is_drawn(*strip.mean)) {
    picture.marker(Marker::kDiamond, {x_of(*strip.mean), y}, kMeanRadius, colour, true);
  }
  picture.text({kRight + 12, y + 4}, strip.remark, {.size = 10});
}

}  // namespace

std::string draw_strips(const StripChart& chart) {
  const double bottom = bottom_of(chart);
  SvgPicture picture(kWidth, bottom + kBelow, chart.title);
  const LogAxis axis = axis_of(chart);
  picture.text({kLeft, 28}, chart.title, {.size = 15, .bold = true});
  draw_legend(picture, chart);
  for (const Tick& tick : axis.ticks()) {
    const double x = kLeft + (kRight - kLeft) * axis.place(tick.value);
    picture.line({x, kTop}, {x, bottom}, {tick.label.empty() ? "#EEEEEE" : "#CCCCCC", 1});
    picture.text({x, bottom + 16}, tick.label, {.size = 11, .anchor = Anchor::kMiddle});
  }
  picture.rectangle({kLeft, kTop}, kRight - kLeft, bottom - kTop, "none", {"#000000", 1});
  double y = kTop + kLine / 2;
  for (const Strip& strip : chart.strips) {
    draw_strip(picture, strip, y, axis);
    y += kLine;
  }
  picture.text({(kLeft + kRight) / 2, bottom + 38}, chart.x_title, {.size = 12, .anchor = Anchor::kMiddle});
  picture.text({16, bottom + 62}, chart.footnote, {.size = 9, .colour = "#555555"});
  return std::move(picture).finish();
}

}  // namespace sbrdf::internal
