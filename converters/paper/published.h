#pragma once

#include <array>
#include <cstdint>

namespace sbrdf::internal {

// What the paper's supplemental material prints, to compare with.

/// Numbers of samples of the accuracy tables.
inline constexpr std::array<std::uint64_t, 2> kPaperCounts = {8'911, 18'721};

/// One material.
struct PaperRow {
  const char* material;               ///< as kurt_material() takes it
  std::array<double, 2> mre_percent;  ///< "proposed" at kPaperCounts, Figures 5 to 14
  bool exchanged;                     ///< the document's figure carries another material's; put right here
  double increase;                    ///< Table 4
};
/// The ten materials in the paper's order.
inline constexpr std::array<PaperRow, 10> kPaper = {{{"Brushed alum", {24.5, 18.9}, false, 1.31},
                                                     {"Purple satin", {0.8, 0.5}, false, 1.19},
                                                     {"Red velvet", {0.1, 0.1}, true, 1.49},
                                                     {"Yellow satin", {10.4, 5.7}, true, 1.32},
                                                     {"fabric002", {0.5, 0.3}, false, 1.02},
                                                     {"fabric041", {0.2, 0.1}, false, 1.03},
                                                     {"fabric112", {1.3, 0.9}, false, 1.05},
                                                     {"fabric135", {3.9, 2.5}, false, 1.27},
                                                     {"fabric139", {0.5, 0.3}, false, 1.11},
                                                     {"wood01", {0.2, 0.1}, false, 1.17}}};

}  // namespace sbrdf::internal
