#include "converters/files/merl/merl_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {

namespace {

constexpr std::array<char, kMerlChannelCount> kChannelNames = {'R', 'G', 'B'};
/// Sums of weights below this are rounding, and their quotients noise.
constexpr float kFaintest = 1e-20f;
/// Cells that one task looks at: some MB.
constexpr std::uint64_t kBlock = std::uint64_t{1} << 16U;

/// Pairs whose cells are on their way from memory while angles are worked out.
constexpr std::size_t kAhead = 16;

using Colour = std::array<double, kMerlChannelCount>;
using Planes = std::array<const std::byte*, kMerlChannelCount>;

double value_at(const std::byte* plane, std::uint64_t index) {
  double value;
  std::memcpy(&value, plane + sizeof(double) * index, sizeof value);
  return value;
}

Colour colour_at(const Planes& planes, std::uint64_t cell) {
  return {value_at(planes[0], cell), value_at(planes[1], cell), value_at(planes[2], cell)};
}

bool is_finite(double value, std::size_t channel) { return std::fabs(value * kMerlScale[channel]) <= kMerlLargest; }

/// Two neighbouring cells along an axis and the weight of the second.
struct Bracket {
  std::uint64_t low, high;
  float weight;
};

/// `centred` is the position minus 0.5, so that whole numbers are cell centres.
Bracket bracket_clamped(double centred, std::uint32_t count) {
  const double inside = std::clamp(centred, 0.0, count - 1.0);
  const auto low = static_cast<std::uint64_t>(inside);
  return {low, std::min<std::uint64_t>(low + 1, count - 1), static_cast<float>(inside - static_cast<double>(low))};
}

/// `phi_d` in [0, 2 pi): by reciprocity its second half repeats the first.
Bracket bracket_phi_d(double phi_d, std::uint32_t count) {
  const double centred = (phi_d < kPi ? phi_d : phi_d - kPi) / kPi * count - 0.5;
  const double below = std::floor(centred);
  const std::uint64_t low = below < 0 ? count - 1 : static_cast<std::uint64_t>(below);
  return {low, low + 1 < count ? low + 1 : 0, static_cast<float>(centred - below)};
}

}  // namespace

/// What a block of cells, or all of them, hold.
struct MerlCensus {
  std::uint64_t marks = 0;        ///< all channels negative
  std::uint64_t marks_above = 0;  ///< of these, and of the two below where they are marks, above the horizon
  std::uint64_t mixed = 0;        ///< some channels negative, none of them infinite
  std::uint64_t bad_cells = 0;    ///< with a value that is not finite
  std::uint64_t bad = 0;          ///< such values
  std::uint64_t first_bad = std::numeric_limits<std::uint64_t>::max();  ///< position among all values of the file
  bool positive = false;                                                ///< in a cell that is no mark

  void add(const MerlCensus& other) {
    marks += other.marks;
    marks_above += other.marks_above;
    mixed += other.mixed;
    bad_cells += other.bad_cells;
    bad += other.bad;
    first_bad = std::min(first_bad, other.first_bad);
    positive = positive || other.positive;
  }
};

namespace {

/// Looks at the cells of a table.
class CensusTaker {
 public:
  CensusTaker(const Planes& planes, const MerlShape& shape, const ValuePolicy& policy)
      : planes_(planes), shape_(shape), cell_count_(merl_cell_count(shape)), policy_(policy) {}

  [[nodiscard]] MerlCensus take(std::uint64_t first, std::uint64_t end) const {
    MerlCensus census;
    for (std::uint64_t cell = first; cell < end; ++cell) {
      const bool mark = add_cell(cell, colour_at(planes_, cell), census);
      if (mark && above_horizon(merl_cell_centre(shape_, cell))) ++census.marks_above;
    }
    return census;
  }

 private:
  // Whether it is a mark.
  bool add_cell(std::uint64_t cell, const Colour& colour, MerlCensus& census) const {
    bool finite = true;
    bool positive = false;
    for (std::size_t c = 0; c < colour.size(); ++c) {
      positive = positive || colour[c] > 0;
      if (is_finite(colour[c], c)) continue;
      finite = false;
      ++census.bad;
      census.first_bad = std::min(census.first_bad, c * cell_count_ + cell);
    }
    const std::size_t negative = merl_negative_channels(colour);
    bool mark = false;
    if (!finite) {
      ++census.bad_cells;
      mark = true;
    } else if (negative == kMerlChannelCount) {
      ++census.marks;
      mark = true;
    } else if (negative > 0) {
      ++census.mixed;
      mark = policy_.negatives == Negatives::kUnmeasured;
    }
    census.positive = census.positive || (positive && !mark);
    return mark;
  }

  const Planes& planes_;
  const MerlShape& shape_;
  std::uint64_t cell_count_;
  const ValuePolicy& policy_;
};

}  // namespace

DirectionPair merl_cell_centre(const MerlShape& shape, std::uint64_t cell) {
  const auto centre = [](std::uint64_t index) { return static_cast<double>(index) + 0.5; };
  return pair_from_half_difference({merl_theta_h(centre(cell / shape[2] / shape[1]), shape[0]), 0,
                                    merl_theta_d(centre(cell / shape[2] % shape[1]), shape[1]),
                                    merl_phi_d(centre(cell % shape[2]), shape[2])});
}

std::string merl_cell_name(const MerlShape& shape, std::uint64_t cell, std::size_t channel) {
  return fmt::format("theta_h {}, theta_d {}, phi_d {}, channel {}", cell / shape[2] / shape[1],
                     cell / shape[2] % shape[1], cell % shape[2], kChannelNames[channel]);
}

std::size_t merl_negative_channels(const std::array<double, kMerlChannelCount>& values) {
  return static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double value) { return value < 0; }));
}

Result<std::unique_ptr<MerlSource>> MerlSource::make(std::shared_ptr<const ByteSource> file,
                                                     const ValuePolicy& policy) {
  const Result<std::vector<std::byte>> head = read_start(*file, kMerlHeaderSize);
  if (!head) return head.error();
  const Result<MerlShape> shape = parse_merl_shape(*head, file->size());
  if (!shape) return shape.error();
  Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(file));
  if (!viewed) return viewed.error();
  std::unique_ptr<MerlSource> source(new MerlSource(*std::move(viewed), *shape, policy));
  if (Status usable = source->examine(); !usable) return usable.error();
  return source;
}

MerlSource::MerlSource(std::shared_ptr<const ByteSource> file, const MerlShape& shape, const ValuePolicy& policy)
    : file_(std::move(file)), shape_(shape), cell_count_(merl_cell_count(shape)), policy_(policy) {
  const std::byte* values = file_->view()->data() + kMerlHeaderSize;
  for (std::size_t c = 0; c < planes_.size(); ++c) planes_[c] = values + sizeof(double) * cell_count_ * c;
  traits_.format = "merl";
  traits_.description = fmt::format("MERL table, {} x {} x {} cells", shape_[0], shape_[1], shape_[2]);
  traits_.channels = {"R", "G", "B"};
  traits_.isotropic = traits_.reciprocal = true;
  traits_.shape.assign(shape_.begin(), shape_.end());
}

Status MerlSource::examine() {
  std::vector<MerlCensus> blocks((cell_count_ + kBlock - 1) / kBlock);
  const CensusTaker taker(planes_, shape_, policy_);
  parallel_for(blocks.size(),
               [&](std::uint64_t k) { blocks[k] = taker.take(k * kBlock, std::min(cell_count_, (k + 1) * kBlock)); });
  MerlCensus census;
  for (const MerlCensus& block : blocks) census.add(block);
  if (census.bad > 0 && policy_.non_finite == NonFinite::kRefuse) {
    const std::uint64_t first = census.first_bad;
    return invalid_file(fmt::format("{} of {} MERL values are NaN, infinite or above {:g} as f_r, the first at {}",
                                    census.bad, kMerlChannelCount * cell_count_, kMerlLargest,
                                    merl_cell_name(shape_, first % cell_count_, first / cell_count_)),
                        kMerlHeaderSize + sizeof(double) * first);
  }
  if (!census.positive) return invalid_file("no value of the MERL table is positive");
  has_non_finite_ = census.bad > 0;
  changes_values_ = has_non_finite_ || (census.mixed > 0 && policy_.negatives != Negatives::kKeep);
  marks_above_ = census.marks_above;
  add_findings(census);
  return ok_status();
}

void MerlSource::add_findings(const MerlCensus& census) {
  const auto add = [&](std::string what, std::uint64_t count) {
    if (count > 0) traits_.findings.push_back({std::move(what), count, cell_count_});
  };
  if (census.bad > 0) {
    add(fmt::format(
            "cells with a value that is NaN, infinite or above {:g} as f_r, taken as unmeasured; the first at {}",
            kMerlLargest, merl_cell_name(shape_, census.first_bad % cell_count_, census.first_bad / cell_count_)),
        census.bad_cells);
  }
  add("cells unmeasured or below the horizon", census.marks);
  add("cells unmeasured above the horizon", census.marks_above);
  const std::string what = "cells with some negative channel";
  if (policy_.negatives == Negatives::kClamp) {
    add(what + ", 0 in its place", census.mixed);
  } else {
    add(policy_.negatives == Negatives::kKeep ? what : what + ", taken as unmeasured", census.mixed);
  }
}

bool MerlSource::is_mark(const Colour& colour) const {
  const std::size_t negative = merl_negative_channels(colour);
  if (negative == kMerlChannelCount || (negative > 0 && policy_.negatives == Negatives::kUnmeasured)) return true;
  if (!has_non_finite_) return false;
  for (std::size_t c = 0; c < colour.size(); ++c) {
    if (!is_finite(colour[c], c)) return true;
  }
  return false;
}

// A cell and a half of theta_d: there, no pair lies among cells below the horizon alone.
DirectionPair MerlSource::away_from_horizon(DirectionPair pair) const {
  const double limit = kPi / 2 * std::max(0.0, 1 - 1.5 / shape_[1]);
  pair.i.theta = std::min(pair.i.theta, limit);
  pair.v.theta = std::min(pair.v.theta, limit);
  return pair;
}

MerlSource::Cell MerlSource::cell(std::uint64_t index) const {
  Colour colour = colour_at(planes_, index);
  if (is_mark(colour)) return {0, 0, 0, 0};
  if (policy_.negatives == Negatives::kClamp) {
    for (double& value : colour) value = std::max(value, 0.0);
  }
  return {static_cast<float>(colour[0] * kMerlScale[0]), static_cast<float>(colour[1] * kMerlScale[1]),
          static_cast<float>(colour[2] * kMerlScale[2]), 1};
}

MerlSource::Place MerlSource::place_of(const HalfDifference& angles) const {
  // In the root of theta_h rather than in theta_h: less error on sharp lobes, see specs/merl.md.
  const Bracket h = bracket_clamped(merl_theta_h_position(angles.theta_h, shape_[0]) - 0.5, shape_[0]);
  const Bracket d = bracket_clamped(angles.theta_d / (kPi / 2) * shape_[1] - 0.5, shape_[1]);
  // Under the normal phi_d is the azimuth of the light, which an isotropic material does not know.
  const Bracket p = bracket_phi_d(angles.theta_h > 0 ? angles.phi_d : 0, shape_[2]);
  const auto row = [&](std::uint64_t theta_h_index, std::uint64_t theta_d_index) {
    return merl_cell_index(shape_, theta_h_index, theta_d_index, 0);
  };
  return {{row(h.low, d.low), row(h.low, d.high), row(h.high, d.low), row(h.high, d.high)},
          {(1 - h.weight) * (1 - d.weight), (1 - h.weight) * d.weight, h.weight * (1 - d.weight), h.weight * d.weight},
          p.low,
          p.high,
          p.weight};
}

void MerlSource::fetch(const Place& place) const {
  for (const std::uint64_t row : place.rows) {
    for (const std::byte* plane : planes_) __builtin_prefetch(plane + sizeof(double) * (row + place.low));
  }
}

MerlSource::Cell MerlSource::interpolate(const Place& place) const {
  Cell sum = {0, 0, 0, 0};
  for (std::size_t k = 0; k < place.rows.size(); ++k) {
    const Cell low = cell(place.rows[k] + place.low);
    const Cell high = cell(place.rows[k] + place.high);
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c] += place.row_weights[k] * ((1 - place.high_weight) * low[c] + place.high_weight * high[c]);
    }
  }
  return sum;
}

void MerlSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  assert(values.size() == pairs.size() * kMerlChannelCount);
  std::array<Place, kAhead> places;  // of those above the horizon
  for (std::size_t first = 0; first < pairs.size(); first += kAhead) {
    const std::size_t count = std::min(kAhead, pairs.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      if (!above_horizon(pairs[first + k])) continue;
      places[k] = place_of(half_difference_from_pair(pairs[first + k]));
      fetch(places[k]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      Cell sum{};
      if (above_horizon(pairs[first + k])) {
        sum = interpolate(places[k]);
        if (sum[3] <= kFaintest)
          sum = interpolate(place_of(half_difference_from_pair(away_from_horizon(pairs[first + k]))));
      }
      for (std::size_t c = 0; c < kMerlChannelCount; ++c) {
        values[(first + k) * kMerlChannelCount + c] = sum[3] > kFaintest ? sum[c] / sum[3] : 0.0f;
      }
    }
  }
}

bool MerlSource::is_measured(const Place& place) const {
  double measured = 0;
  double marked = 0;
  for (std::size_t k = 0; k < place.rows.size(); ++k) {
    const std::array<std::pair<std::uint64_t, double>, 2> sides = {
        {{place.low, 1.0 - place.high_weight}, {place.high, place.high_weight}}};
    for (const auto& [column, share] : sides) {
      const double weight = place.row_weights[k] * share;
      const std::uint64_t index = place.rows[k] + column;
      if (weight == 0) continue;
      if (!is_mark(colour_at(planes_, index))) {
        measured += weight;
      } else if (above_horizon(merl_cell_centre(shape_, index))) {
        marked += weight;
      }
    }
  }
  return measured >= marked;
}

void MerlSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const bool ask = marks_above_ > 0 && above_horizon(pairs[k]);
    flags[k] = !ask || is_measured(place_of(half_difference_from_pair(pairs[k]))) ? 1 : 0;
  }
}

std::optional<MaskGrid> MerlSource::mask_grid() const {
  if (marks_above_ == 0) return std::nullopt;
  MaskGrid grid = {MaskFrame::kHalfDifference, {1, shape_[0], shape_[1], shape_[2]}};
  while (!grid.is_valid()) {  // a table with more cells than a mask can have
    for (std::uint32_t& count : grid.counts) count = (count + 1) / 2;
  }
  return grid;
}

Result<std::unique_ptr<BrdfSource>> open_merl(std::shared_ptr<const ByteSource> file, const Options& options) {
  const ValuePolicy policy = policy_of(options, NonFinite::kUnmeasured);
  Result<std::unique_ptr<MerlSource>> source = MerlSource::make(std::move(file), policy);
  if (!source) return source.error();
  return std::unique_ptr<BrdfSource>(*std::move(source));
}

}  // namespace sbrdf::internal
