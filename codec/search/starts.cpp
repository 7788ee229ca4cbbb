#include "codec/search/starts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {
namespace {

constexpr double kMaxCrossingShare = 0.9;  // of the budget
constexpr std::size_t kFewestKept = 8;     // of each frame

// Where steps come in lists, the sparsest first.
constexpr std::array kElevationSteps = {28.0, 20.0, 14.0, 10.0, 7.0, 5.0};
constexpr std::array kAzimuthSteps = {180.0, 60.0, 36.0, 20.0, 12.0};
constexpr std::array kPhiHSteps = {90.0, 45.0, 22.5, 15.0};
constexpr std::array kPhiDSteps = {45.0, 30.0, 18.0};

std::vector<double> steps(double end, double step) {
  std::vector<double> list;
  for (int k = 0; k * step < end - 1e-9; ++k) list.push_back(k * step);
  list.push_back(end);
  return list;
}

// Lists that were made for 80 degrees, spread up to another theta_max in quarters of a degree.
std::vector<double> spread(std::vector<double> list, double theta_max_deg) {
  for (double& node : list) node = std::round(4 * node * theta_max_deg / kPaperThetaMaxDeg) / 4;
  list.back() = theta_max_deg;
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

void add_elevation_starts(const SearchOptions& options, std::vector<Structure>& starts) {
  const Symmetries& symmetries = options.symmetries;
  for (const double elevation : kElevationSteps) {
    for (const double azimuth : kAzimuthSteps) {
      FrameOutline& outline = starts.emplace_back().outline;
      outline = {FrameId::kElevation, symmetries, {}, options.theta_max_deg};
      outline.lists[kAxial] = symmetries.isotropic ? std::vector<double>{0} : steps(180, azimuth);
      outline.lists[kDiagonal] = steps(180, azimuth);
      outline.lists[kHorizontal] = steps(options.theta_max_deg, elevation);
    }
  }
}

void add_half_difference_starts(const SearchOptions& options, std::vector<Structure>& starts) {
  const Symmetries& symmetries = options.symmetries;
  const std::vector<std::vector<double>> theta_h_lists = {
      {0, 20, 50, 80}, {0, 6, 16, 32, 55, 80}, {0, 3, 8, 16, 32, 55, 80}, {0, 2, 5, 10, 20, 35, 55, 80}};
  const std::vector<std::vector<double>> theta_d_lists = {
      {0, 40, 80}, {0, 20, 40, 60, 72, 80}, {0, 12, 24, 36, 48, 60, 70, 80}};
  std::vector<std::vector<double>> phi_h = {{0}};
  if (!symmetries.isotropic) {
    phi_h.clear();
    for (const double step : kPhiHSteps) phi_h.push_back(steps(90, step));
  }
  for (const auto& h : theta_h_lists) {
    for (const auto& d : theta_d_lists) {
      for (const auto& axial : phi_h) {
        for (const double phi_d_step : kPhiDSteps) {
          const std::vector<double> theta_d = spread(d, options.theta_max_deg);
          const std::vector<double> theta_h = spread(h, options.theta_max_deg);
          starts.emplace_back().outline = {FrameId::kHalfDifference,
                                           symmetries,
                                           {axial, steps(90, phi_d_step), theta_d, theta_h},
                                           options.theta_max_deg};
        }
      }
    }
  }
}

std::vector<Structure> densest_third(const std::vector<Structure>& all, std::uint64_t sample_count) {
  std::vector<std::pair<std::size_t, std::size_t>> counts;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Result<Lattice> lattice = build_lattice(expand_outline(all[k].outline));
    if (!lattice || !fits_budget(lattice->crossings.size(), sample_count)) continue;
    counts.emplace_back(lattice->crossings.size(), k);
  }
  std::sort(counts.rbegin(), counts.rend());
  const std::size_t keep = std::max(std::min(kFewestKept, counts.size()), counts.size() / 3);
  std::vector<Structure> kept;
  for (std::size_t k = 0; k < keep; ++k) kept.push_back(all[counts[k].second]);
  return kept;
}

// What the options say of all structures alike.
void settle(const SearchOptions& options, std::vector<Structure>& starts) {
  for (Structure& start : starts) {
    start.domain = options.domain.value_or(DomainKind::kLog);
    if (options.objective == Objective::kMre) start.value_exponent = 0;
    if (options.objective == Objective::kRelL1) start.value_exponent = 1;
  }
}

}  // namespace

bool fits_budget(std::size_t crossing_count, std::uint64_t sample_count) {
  return static_cast<double>(crossing_count) <= kMaxCrossingShare * static_cast<double>(sample_count);
}

std::vector<Structure> regular_starts(const SearchOptions& options, std::size_t most) {
  std::array<std::vector<Structure>, 2> kept;
  for (const FrameId id : {FrameId::kElevation, FrameId::kHalfDifference}) {
    if (options.frame.value_or(id) != id) continue;
    std::vector<Structure> all;
    if (id == FrameId::kElevation) add_elevation_starts(options, all);
    if (id == FrameId::kHalfDifference) add_half_difference_starts(options, all);
    settle(options, all);
    kept[id == FrameId::kElevation ? 0 : 1] = densest_third(all, options.sampling.sample_count);
  }
  while (kept[0].size() + kept[1].size() > most) kept[kept[0].size() < kept[1].size() ? 1 : 0].pop_back();
  kept[0].insert(kept[0].end(), kept[1].begin(), kept[1].end());
  return std::move(kept[0]);
}

}  // namespace sbrdf::internal
