#include "converters/files/merl/merl_census.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {

namespace {

/// Cells that one task looks at: some MB.
constexpr std::uint64_t kBlock = std::uint64_t{1} << 16U;

/// Whether both directions of a cell lie above the horizon. Those of half and difference angles have, with h = (sin
/// theta_h, 0, cos theta_h) and d = (sin theta_d cos phi_d, sin theta_d sin phi_d), the heights
///     cos theta_d cos theta_h -+ sin theta_d cos phi_d sin theta_h,
/// of which sines and cosines are the same for whole rows.
class CellHorizon {
 public:
  CellHorizon(const MerlShape& shape, const MerlConvention& convention) : shape_(shape), convention_(convention) {
    for (std::uint64_t k = 0; k < shape[0]; ++k) {
      const double theta_h = merl_cell_angles(shape, convention, k * shape[1] * shape[2]).theta_h;
      h_.push_back({std::sin(theta_h), std::cos(theta_h)});
    }
    for (std::uint64_t k = 0; k < shape[1]; ++k) {
      const double theta_d = merl_cell_angles(shape, convention, k * shape[2]).theta_d;
      d_.push_back({std::sin(theta_d), std::cos(theta_d)});
    }
    for (std::uint64_t k = 0; k < shape[2]; ++k) {
      cos_phi_.push_back(std::cos(merl_cell_angles(shape, convention, k).phi_d));
    }
  }

  [[nodiscard]] bool is_above(std::uint64_t cell) const {
    constexpr double kRounding = 1e-9;
    const Angle& h = h_[cell / shape_[2] / shape_[1]];
    const Angle& d = d_[cell / shape_[2] % shape_[1]];
    const double lower = d.cos * h.cos - std::abs(d.sin * cos_phi_[cell % shape_[2]]) * h.sin;
    if (std::abs(lower) > kRounding) return lower > 0;
    return above_horizon(merl_cell_pair(shape_, convention_, cell));
  }

 private:
  struct Angle {
    double sin, cos;
  };
  MerlShape shape_;
  MerlConvention convention_;
  std::vector<Angle> h_, d_;
  std::vector<double> cos_phi_;
};

class CensusTaker {
 public:
  CensusTaker(const MerlCells& cells, const MerlConvention& convention, const ValuePolicy& policy)
      : cells_(cells), horizon_(cells.shape(), convention), policy_(policy) {}

  [[nodiscard]] MerlCensus take(std::uint64_t first, std::uint64_t end) const {
    return cells_.value_size() == sizeof(float) ? take_as<float>(first, end) : take_as<double>(first, end);
  }

 private:
  template <class T>
  [[nodiscard]] MerlCensus take_as(std::uint64_t first, std::uint64_t end) const {
    MerlCensus census;
    for (std::uint64_t cell = first; cell < end; ++cell) {
      const MerlColour colour = cells_.colour_as<T>(cell);
      // Nearly all cells; no branch for each channel.
      const double least = std::min(colour[0], std::min(colour[1], colour[2]));
      const double most = std::max(colour[0], std::max(colour[1], colour[2]));
      const double sum = colour[0] + colour[1] + colour[2];
      if (least >= 0 && most <= kPlain && sum == sum) continue;
      if (add_cell(cell, colour, census) && horizon_.is_above(cell)) ++census.marks_above;
    }
    return census;
  }

  // Whether it is a mark.
  bool add_cell(std::uint64_t cell, const MerlColour& colour, MerlCensus& census) const {
    bool finite = true;
    for (std::size_t c = 0; c < colour.size(); ++c) {
      if (is_finite_merl_value(colour[c], c)) continue;
      finite = false;
      ++census.bad;
      census.first_bad = std::min(census.first_bad, c * cells_.count() + cell);
    }
    const std::size_t negative = merl_negative_channels(colour);
    if (!finite) {
      ++census.bad_cells;
      return true;
    }
    if (negative == kMerlChannelCount) {
      ++census.marks;
      return true;
    }
    if (negative > 0) ++census.mixed;
    return negative > 0 && policy_.negatives == Negatives::kUnmeasured;
  }

  static constexpr double kPlain = 1e38;  ///< finite whatever the channel's scale, which is below 1

  const MerlCells& cells_;
  CellHorizon horizon_;
  ValuePolicy policy_;
};

void add(const MerlCensus& block, MerlCensus& census) {
  census.marks += block.marks;
  census.marks_above += block.marks_above;
  census.mixed += block.mixed;
  census.bad_cells += block.bad_cells;
  census.bad += block.bad;
  census.first_bad = std::min(census.first_bad, block.first_bad);
}

/// How two readings of the third dimension fit the cells of a table.
class TurnJudge {
 public:
  TurnJudge(const MerlCells& cells, MerlPosition position)
      : cells_(cells), shape_(cells.shape()), half_{position, MerlTurn::kHalf}, full_{position, MerlTurn::kFull} {}

  /// Nothing where the content does not tell.
  [[nodiscard]] std::optional<MerlTurn> judge() {
    constexpr std::uint64_t kMostCells = std::uint64_t{1} << 18U;
    const std::uint64_t count = cells_.count();
    // Odd, so that every column is met.
    const std::uint64_t stride = std::max<std::uint64_t>(1, count / kMostCells) | 1U;
    for (std::uint64_t cell = 0; cell < count; cell += stride) add(cell);
    const double told = blank_half_ + blank_full_;
    if (told >= kFewest) {
      // A blank cell above the horizon of one reading is below that of the other.
      if (blank_full_ > kShare * told && filled_full_ < (1 - kShare) * (blank_full_ + 1)) return MerlTurn::kFull;
      if (blank_half_ > kShare * told && filled_half_ < (1 - kShare) * (blank_half_ + 1)) return MerlTurn::kHalf;
      return std::nullopt;
    }
    if (across_ > 0.01 * sum_ && opposite_ < 0.25 * across_) return MerlTurn::kFull;
    if (across_ > 0.01 * sum_ && opposite_ > 0.8 * across_) return MerlTurn::kHalf;
    return std::nullopt;
  }

 private:
  static constexpr double kFewest = 16;
  static constexpr double kShare = 0.95;

  void add(std::uint64_t cell) {
    const double value = grey(cell);
    const bool blank = !(value > 0);
    const bool in_half = above_horizon(merl_cell_pair(shape_, half_, cell));
    const bool in_full = above_horizon(merl_cell_pair(shape_, full_, cell));
    if (in_half && !in_full) ++(blank ? blank_full_ : filled_full_);
    if (in_full && !in_half) ++(blank ? blank_half_ : filled_half_);
    if (blank) return;
    const std::uint64_t row = cell - cell % shape_[2];
    const auto along = [&](std::uint32_t step) { return grey(row + (cell - row + step) % shape_[2]); };
    const double opposite = along(shape_[2] / 2);
    const double across = along(shape_[2] / 4);
    if (!(opposite > 0) || !(across > 0)) return;
    sum_ += value;
    opposite_ += std::abs(opposite - value);
    across_ += std::abs(across - value);
  }
  [[nodiscard]] double grey(std::uint64_t cell) const {
    const MerlColour colour = cells_.colour(cell);
    return (colour[0] + colour[1] + colour[2]) / 3;
  }

  const MerlCells& cells_;
  MerlShape shape_;
  MerlConvention half_, full_;
  double blank_half_ = 0, blank_full_ = 0;    ///< no value, and below the horizon of this reading alone
  double filled_half_ = 0, filled_full_ = 0;  ///< a value, and below the horizon of this reading alone
  double sum_ = 0, opposite_ = 0, across_ = 0;
};

}  // namespace

MerlCensus take_merl_census(const MerlCells& cells, const MerlConvention& convention, const ValuePolicy& policy) {
  const CensusTaker taker(cells, convention, policy);
  std::vector<MerlCensus> blocks((cells.count() + kBlock - 1) / kBlock);
  parallel_for(blocks.size(),
               [&](std::uint64_t k) { blocks[k] = taker.take(k * kBlock, std::min(cells.count(), (k + 1) * kBlock)); });
  MerlCensus census;
  for (const MerlCensus& block : blocks) add(block, census);
  return census;
}

bool has_positive_value(const MerlCells& cells, const ValuePolicy& policy) {
  for (std::uint64_t cell = 0; cell < cells.count(); ++cell) {
    const MerlColour colour = cells.colour(cell);
    if (std::none_of(colour.begin(), colour.end(), [](double value) { return value > 0; })) continue;
    bool finite = true;
    for (std::size_t c = 0; c < colour.size(); ++c) finite = finite && is_finite_merl_value(colour[c], c);
    const bool mark = policy.negatives == Negatives::kUnmeasured && merl_negative_channels(colour) > 0;
    if (finite && !mark) return true;
  }
  return false;
}

std::optional<MerlTurn> judge_merl_turn(const MerlCells& cells, MerlPosition position) {
  return TurnJudge(cells, position).judge();
}

}  // namespace sbrdf::internal
