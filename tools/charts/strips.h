#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/charts/log_axis.h"

namespace sbrdf::internal {

/// One thing that was measured on several others.
struct Strip {
  std::string name;
  std::vector<double> values;       ///< what is not above 0 or not finite is not drawn
  std::optional<double> mean = {};  ///< a larger marker
  std::string remark = {};          ///< at the right end; few characters
  bool stands_out = false;          ///< in colour, its name bold
};

/// A chart of a line for each strip, with its values along one logarithmic axis.
struct StripChart {
  std::string title;
  std::string x_title;
  Numerals numerals = Numerals::kPlain;
  std::string value_name;   ///< what a small marker is
  std::string mean_name;    ///< what a large one is
  std::string remark_name;  ///< above the remarks
  std::vector<Strip> strips;
  std::string footnote;
};

/// As an SVG picture, 960 pixels wide and as high as it takes. It can be told apart without colours. The same chart
/// gives the same bytes.
[[nodiscard]] std::string draw_strips(const StripChart& chart);

}  // namespace sbrdf::internal
