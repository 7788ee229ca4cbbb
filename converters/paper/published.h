#pragma once

#include <array>
#include <cstdint>

#include "formats/core/named.h"

namespace sbrdf::internal {

// What the paper's supplemental material prints, to compare with.

/// Numbers of samples of the accuracy tables.
inline constexpr std::array<std::uint64_t, 2> kPaperCounts = {8'911, 18'721};

/// The three methods that the paper compares, in its order of merit.
enum class PaperMethod : std::uint8_t { kProposed, kBarycentric, kRbf };
inline constexpr std::array kPaperMethodNames = {Named{"proposed", PaperMethod::kProposed},
                                                 Named{"barycentric", PaperMethod::kBarycentric},
                                                 Named{"rbf", PaperMethod::kRbf}};
/// The uniform schemes of the last two at kPaperCounts (Table 1).
inline constexpr std::array<const char*, 2> kPaperSchemes = {"14", "19"};

/// Table 5: bytes on a graphics card, in units of 2^20, at kPaperCounts.
inline constexpr std::array<double, 2> kPaperProposedMegabytes = {3.3, 5.1};
inline constexpr std::array<double, 2> kPaperBarycentricMegabytes = {3.5, 3.6};

/// One material. MRE [%] at kPaperCounts, Figures 5 to 14.
struct PaperRow {
  const char* material;  ///< as kurt_material() takes it
  std::array<double, 2> proposed;
  std::array<double, 2> barycentric;
  std::array<double, 2> rbf;
  bool exchanged;   ///< the document's figure carries another material's; put right here
  double increase;  ///< Table 4

  [[nodiscard]] constexpr const std::array<double, 2>& mre_percent(PaperMethod method) const {
    if (method == PaperMethod::kProposed) return proposed;
    return method == PaperMethod::kBarycentric ? barycentric : rbf;
  }
};
/// The ten materials in the paper's order.
inline constexpr std::array<PaperRow, 10> kPaper = {
    {{"Brushed alum", {24.5, 18.9}, {110.7, 72.4}, {152.1, 102.1}, false, 1.31},
     {"Purple satin", {0.8, 0.5}, {3.0, 2.0}, {1.0, 0.7}, false, 1.19},
     {"Red velvet", {0.1, 0.1}, {2.2, 1.7}, {0.7, 0.5}, true, 1.49},
     {"Yellow satin", {10.4, 5.7}, {16.3, 11.0}, {13.2, 7.8}, true, 1.32},
     {"fabric002", {0.5, 0.3}, {2.0, 1.6}, {0.6, 0.5}, false, 1.02},
     {"fabric041", {0.2, 0.1}, {1.1, 0.9}, {0.5, 0.4}, false, 1.03},
     {"fabric112", {1.3, 0.9}, {4.4, 3.3}, {1.2, 0.8}, false, 1.05},
     {"fabric135", {3.9, 2.5}, {5.4, 4.0}, {3.1, 2.3}, false, 1.27},
     {"fabric139", {0.5, 0.3}, {1.3, 1.0}, {0.5, 0.4}, false, 1.11},
     {"wood01", {0.2, 0.1}, {1.1, 0.9}, {0.4, 0.3}, false, 1.17}}};

}  // namespace sbrdf::internal
