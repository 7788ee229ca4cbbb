#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/charts/log_axis.h"

namespace sbrdf::internal {

/// A point of a chart. What is not above 0 or not finite is not drawn, but for an x of 0: see Chart::x_least.
struct ChartPoint {
  double x = 0;
  double y = 0;
  std::optional<double> other_y = {};  ///< of the same thing otherwise: a hollow marker, joined by a thin line
  std::string label = {};              ///< beside the marker; few characters
};

/// Points that belong together: one colour, one marker.
struct ChartSeries {
  std::string name;
  std::size_t style = 0;  ///< any number; the same number looks the same in every chart
  bool joined = false;    ///< by lines, in the order of the points
  std::vector<ChartPoint> points = {};
};

/// A line across the chart at one y, such as a yardstick.
struct ChartLevel {
  double y = 0;
  std::string name;
};

/// A chart with logarithmic axes, of which smaller is better along both where the front is drawn.
struct Chart {
  std::string title;
  std::string x_title;
  std::string y_title;
  Numerals x_numerals = Numerals::kPlain;
  Numerals y_numerals = Numerals::kPlain;
  bool x_ticks_at_points = false;  ///< lines and numbers at the x of points alone, for what is counted
  double x_least = 0;              ///< smaller x stand at this, which the axis says: errors that are only rounding
  std::string filled_name;         ///< what filled markers are, where there are hollow ones
  std::string hollow_name;         ///< what these are
  bool pareto_front = false;       ///< along the points that no other one beats in both x and y
  std::vector<ChartSeries> series;
  std::vector<ChartLevel> levels;
  std::string footnote;  ///< small, below: the machine
};

/// The size of every chart [pixels].
inline constexpr double kChartWidth = 960;
inline constexpr double kChartHeight = 560;

/// The chart as an SVG picture: the legend to the right of the plot, labels beside their points where nothing else is.
/// Colours are those of Okabe and Ito, which colour-blind people can tell apart ("Color Universal Design", 2008),
/// without the yellow that white paper swallows; each has a marker of its own. The same chart gives the same bytes.
[[nodiscard]] std::string draw_chart(const Chart& chart);

/// The points that no other one beats in both (smaller or equal x and y, one of them smaller), by rising x.
[[nodiscard]] std::vector<ChartPoint> pareto_front(std::vector<ChartPoint> points);

}  // namespace sbrdf::internal
