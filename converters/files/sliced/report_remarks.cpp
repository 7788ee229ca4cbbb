#include "converters/files/sliced/report_remarks.h"

namespace sbrdf::internal {

void remark_errors(const SliceReport& report, const std::vector<std::string>& channels, Report& told) {
  std::vector<Remark>& remarks = told.remarks;
  remarks.push_back({"held_back_mre_percent", report.error.mre_percent,
                     "off the grid: MRE " + percent_text(report.error.mre_percent) + " on " +
                         std::to_string(report.error_directions) +
                         " random directions that took no part in any choice"});
  remarks.push_back({"held_back_rel_l1_percent", report.error.rel_l1_percent,
                     "off the grid: relative L1 error " + percent_text(report.error.rel_l1_percent) + " on the same"});
  if (report.error_values_all_zero) return;
  const ErrorFigures& figures = report.figures;
  remarks.push_back(
      {"held_back_p999_percent", figures.relative_p999_percent,
       "off the grid: 99.9 % of the relative errors are at most " + percent_text(figures.relative_p999_percent)});
  if (figures.max_relative_percent > 0) {
    remarks.push_back({"held_back_largest_percent", figures.max_relative_percent,
                       "off the grid: the largest is " + percent_text(figures.max_relative_percent) + ", of " +
                           place_text(figures.max_relative_at, channels)});
  }
  const FalseValues& found = report.false_values;
  if (found.count > 0) {
    remarks.push_back({"false_values", static_cast<double>(found.count),
                       "warning: " + std::to_string(found.count) +
                           " of the values on these directions are false, above 3 times all that the source has within "
                           "3 degrees; the worst, of " +
                           place_text(found.worst, channels)});
  }
}

}  // namespace sbrdf::internal
