#include "tools/charts/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "tools/charts/label_places.h"
#include "tools/charts/svg.h"
#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

constexpr Box kPlot = {92, 48, 690, 476};  // left, top, right, bottom
constexpr double kLegendLeft = 712;
constexpr double kLegendLine = 18;
constexpr std::size_t kLegendCharacters = 33;
constexpr std::size_t kFootnoteCharacters = 165;
constexpr double kRadius = 4.5;
constexpr double kLabelSize = 10;
constexpr Stroke kFrontStroke = {"#BBBBBB", 3.5, ""};
constexpr double kNearLine = 2;  // labels keep so far from lines [pixels]
constexpr Stroke kLevelStroke = {"#333333", 1.2, "2 3"};

// Okabe and Ito, "Color Universal Design", 2008, without yellow.
constexpr std::array<std::string_view, 7> kColours = {"#000000", "#0072B2", "#D55E00", "#009E73",
                                                      "#E69F00", "#CC79A7", "#56B4E9"};
constexpr std::array<std::string_view, 4> kDashes = {"", "7 3", "2 2", "9 3 2 3"};

std::string_view colour_of(const ChartSeries& series) { return kColours.at(series.style % kColours.size()); }
Marker marker_of(const ChartSeries& series) { return static_cast<Marker>(series.style % kMarkerCount); }
Stroke line_of(const ChartSeries& series) {
  return {colour_of(series), 1.5, kDashes.at(series.style % kDashes.size())};
}

bool is_shown(double y) { return std::isfinite(y) && y > 0; }

/// Words on lines of at most so many characters; what is longer is cut where it must be.
std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
  std::vector<std::string> lines = {""};
  std::string rest = one_line(text);
  while (rest.size() > most) {
    std::size_t end = rest.rfind(' ', most);
    if (end == std::string::npos || end == 0) {
      end = most;
      while (end > 1 && (static_cast<unsigned char>(rest[end]) & 0xC0U) == 0x80U) --end;  // not within a character
    }
    lines.back() = rest.substr(0, end);
    rest.erase(0, rest[end] == ' ' ? end + 1 : end);
    lines.emplace_back();
  }
  lines.back() = rest;
  return lines;
}

class ChartDrawing {
 public:
  explicit ChartDrawing(const Chart& chart)
      : chart_(chart),
        picture_(kChartWidth, kChartHeight, chart.title),
        x_axis_(x_axis_of(chart)),
        y_axis_(y_axis_of(chart)) {}

  std::string draw() && {
    picture_.text({kPlot.left, 28}, chart_.title, {.size = 15, .bold = true});
    draw_axes();
    draw_front();
    for (const ChartLevel& level : chart_.levels) {
      draw_path({{kPlot.left, y_of(level.y)}, {kPlot.right, y_of(level.y)}}, kLevelStroke);
    }
    for (const ChartSeries& series : chart_.series) draw_lines(series);
    for (const ChartSeries& series : chart_.series) draw_markers(series);
    draw_labels();
    draw_legend();
    double y = kChartHeight - 22;
    for (const std::string& line : wrapped(chart_.footnote, kFootnoteCharacters)) {
      picture_.text({kPlot.left - 76, y}, line, {.size = 9, .colour = "#555555"});
      y += 12;
    }
    return std::move(picture_).finish();
  }

 private:
  static LogAxis axis_of(const std::vector<double>& values, Numerals numerals) {
    if (values.empty()) return LogAxis::around(1, 10, numerals);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return LogAxis::around(*least, *most, numerals);
  }
  static double held(const Chart& chart, double x) { return std::max(x, chart.x_least); }
  static LogAxis x_axis_of(const Chart& chart) {
    std::vector<double> values;
    for (const ChartSeries& series : chart.series) {
      for (const ChartPoint& point : series.points) {
        if (is_shown(held(chart, point.x))) values.push_back(held(chart, point.x));
      }
    }
    return axis_of(values, chart.x_numerals);
  }
  static LogAxis y_axis_of(const Chart& chart) {
    std::vector<double> values;
    for (const ChartLevel& level : chart.levels) values.push_back(level.y);
    for (const ChartSeries& series : chart.series) {
      for (const ChartPoint& point : series.points) {
        values.push_back(point.y);
        if (point.other_y) values.push_back(*point.other_y);
      }
    }
    std::erase_if(values, [](double value) { return !is_shown(value); });
    return axis_of(values, chart.y_numerals);
  }

  [[nodiscard]] double x_of(double x) const {
    return kPlot.left + (kPlot.right - kPlot.left) * x_axis_.place(held(chart_, x));
  }
  [[nodiscard]] double y_of(double y) const { return kPlot.bottom - (kPlot.bottom - kPlot.top) * y_axis_.place(y); }
  [[nodiscard]] bool is_drawn(const ChartPoint& point) const {
    return is_shown(held(chart_, point.x)) && is_shown(point.y);
  }

  void draw_axes() {
    const bool holds = std::any_of(chart_.series.begin(), chart_.series.end(), [&](const ChartSeries& series) {
      return std::any_of(series.points.begin(), series.points.end(),
                         [&](const ChartPoint& point) { return point.x < chart_.x_least; });
    });
    for (const Tick& tick : x_ticks()) {
      const double x = x_of(tick.value);
      const bool major = !tick.label.empty();
      picture_.line({x, kPlot.top}, {x, kPlot.bottom}, {major ? "#CCCCCC" : "#EEEEEE", 1});
      const bool stands_for_less = holds && tick.value <= chart_.x_least * (1 + 1e-9);
      picture_.text({x, kPlot.bottom + 16}, (stands_for_less && major ? "\u2264 " : "") + tick.label,
                    {.size = 11, .anchor = Anchor::kMiddle});
    }
    for (const Tick& tick : y_axis_.ticks()) {
      const double y = y_of(tick.value);
      picture_.line({kPlot.left, y}, {kPlot.right, y}, {tick.label.empty() ? "#EEEEEE" : "#CCCCCC", 1});
      picture_.text({kPlot.left - 7, y + 4}, tick.label, {.size = 11, .anchor = Anchor::kEnd});
    }
    picture_.rectangle({kPlot.left, kPlot.top}, kPlot.right - kPlot.left, kPlot.bottom - kPlot.top, "none",
                       {"#000000", 1});
    const double middle = (kPlot.left + kPlot.right) / 2;
    picture_.text({middle, kPlot.bottom + 38}, chart_.x_title, {.size = 12, .anchor = Anchor::kMiddle});
    picture_.text({24, (kPlot.top + kPlot.bottom) / 2}, chart_.y_title,
                  {.size = 12, .anchor = Anchor::kMiddle, .upwards = true});
  }

  [[nodiscard]] std::vector<Tick> x_ticks() const {
    if (!chart_.x_ticks_at_points) return x_axis_.ticks();
    std::set<double> values;
    for (const ChartSeries& series : chart_.series) {
      for (const ChartPoint& point : series.points) values.insert(point.x);
    }
    std::vector<Tick> ticks;
    for (const double value : values) ticks.push_back({value, numeral(value, chart_.x_numerals)});
    return ticks;
  }

  /// Drawn, and kept free of labels as far as can be.
  void draw_path(const std::vector<Spot>& spots, const Stroke& stroke) {
    picture_.path(spots, stroke);
    for (std::size_t k = 1; k < spots.size(); ++k) {
      const Spot& from = spots[k - 1];
      const Spot& to = spots[k];
      const double length = std::hypot(to.x - from.x, to.y - from.y);
      const int parts = static_cast<int>(length / (2 * kNearLine)) + 1;
      for (int part = 0; part <= parts; ++part) {
        const double t = static_cast<double>(part) / parts;
        labels_.keep_free(around({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)}, kNearLine));
      }
    }
  }

  void draw_front() {
    if (!chart_.pareto_front) return;
    std::vector<ChartPoint> points;
    for (const ChartSeries& series : chart_.series) {
      for (const ChartPoint& point : series.points) {
        if (is_drawn(point)) points.push_back({held(chart_, point.x), point.y});
      }
    }
    const std::vector<ChartPoint> front = pareto_front(std::move(points));
    if (front.empty()) return;
    std::vector<Spot> steps = {{x_of(front.front().x), kPlot.top}};
    for (const ChartPoint& point : front) {
      steps.push_back({x_of(point.x), steps.back().y});
      steps.push_back({x_of(point.x), y_of(point.y)});
    }
    steps.push_back({kPlot.right, steps.back().y});
    draw_path(steps, kFrontStroke);
  }

  void draw_lines(const ChartSeries& series) {
    std::vector<Spot> spots;
    for (const ChartPoint& point : series.points) {
      if (!is_drawn(point)) continue;
      spots.push_back({x_of(point.x), y_of(point.y)});
      if (point.other_y && is_shown(*point.other_y)) {
        draw_path({spots.back(), {x_of(point.x), y_of(*point.other_y)}}, {colour_of(series), 0.8});
      }
    }
    if (series.joined && spots.size() > 1) draw_path(spots, line_of(series));
  }

  void draw_markers(const ChartSeries& series) {
    for (const ChartPoint& point : series.points) {
      if (!is_drawn(point)) continue;
      const double x = x_of(point.x);
      if (point.other_y && is_shown(*point.other_y)) {
        picture_.marker(marker_of(series), {x, y_of(*point.other_y)}, kRadius, colour_of(series), false);
        labels_.keep_free(around({x, y_of(*point.other_y)}, kRadius + 2));
      }
      picture_.marker(marker_of(series), {x, y_of(point.y)}, kRadius, colour_of(series), true);
      labels_.keep_free(around({x, y_of(point.y)}, kRadius + 2));
    }
  }

  void draw_labels() {
    for (const ChartSeries& series : chart_.series) {
      for (const ChartPoint& point : series.points) {
        if (!is_drawn(point) || point.label.empty()) continue;
        const Spot at = labels_.place({x_of(point.x), y_of(point.y)}, text_width(point.label, kLabelSize), kLabelSize);
        picture_.text(at, point.label, {.size = kLabelSize, .colour = colour_of(series), .halo = true});
      }
    }
  }

  void draw_legend() {
    double y = kPlot.top + 10;
    const auto write = [&](const std::string& text) {
      for (const std::string& line : wrapped(text, kLegendCharacters)) {
        picture_.text({kLegendLeft + 26, y + 4}, line, {.size = 11});
        y += kLegendLine - 4;
      }
      y += 4;
    };
    for (const ChartSeries& series : chart_.series) {
      if (series.joined) picture_.line({kLegendLeft - 3, y}, {kLegendLeft + 21, y}, line_of(series));
      picture_.marker(marker_of(series), {kLegendLeft + 9, y}, kRadius, colour_of(series), true);
      write(series.name);
    }
    for (const bool filled : {true, false}) {
      if (chart_.hollow_name.empty()) continue;
      picture_.marker(Marker::kCircle, {kLegendLeft + 9, y}, kRadius, "#777777", filled);
      write(filled ? chart_.filled_name : chart_.hollow_name);
    }
    const auto line = [&](const Stroke& stroke, const std::string& name) {
      picture_.line({kLegendLeft - 3, y}, {kLegendLeft + 21, y}, stroke);
      write(name);
    };
    const char* front = chart_.hollow_name.empty() ? "Pareto front" : "Pareto front of the filled ones";
    if (chart_.pareto_front) line(kFrontStroke, front);
    for (const ChartLevel& level : chart_.levels) line(kLevelStroke, level.name);
  }

  const Chart& chart_;
  SvgPicture picture_;
  LogAxis x_axis_;
  LogAxis y_axis_;
  LabelPlaces labels_{kPlot};
};

}  // namespace

std::vector<ChartPoint> pareto_front(std::vector<ChartPoint> points) {
  std::sort(points.begin(), points.end(),
            [](const ChartPoint& a, const ChartPoint& b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
  std::vector<ChartPoint> front;
  for (ChartPoint& point : points) {
    if (front.empty() || point.y < front.back().y) front.push_back(std::move(point));
  }
  return front;
}

std::string draw_chart(const Chart& chart) { return ChartDrawing(chart).draw(); }

}  // namespace sbrdf::internal
