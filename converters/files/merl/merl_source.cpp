#include "converters/files/merl/merl_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
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

template <class T>
double number_at(const std::byte* plane, std::uint64_t index) {
  T value;
  std::memcpy(&value, plane + sizeof(T) * index, sizeof value);
  return value;
}

Colour colour_in(const Planes& planes, std::size_t value_size, std::uint64_t cell) {
  if (value_size == sizeof(float)) {
    return {number_at<float>(planes[0], cell), number_at<float>(planes[1], cell), number_at<float>(planes[2], cell)};
  }
  return {number_at<double>(planes[0], cell), number_at<double>(planes[1], cell), number_at<double>(planes[2], cell)};
}

bool is_finite(double value, std::size_t channel) { return std::fabs(value * kMerlScale[channel]) <= kMerlLargest; }

/// Two neighbouring cells along an axis and the weight of the second.
struct CellBracket {
  std::uint64_t low, high;
  float weight;
};

/// `centred` is the position minus 0.5, so that whole numbers are cell centres.
CellBracket bracket_clamped(double centred, std::uint32_t count) {
  const double inside = std::clamp(centred, 0.0, count - 1.0);
  const auto low = static_cast<std::uint64_t>(inside);
  return {low, std::min<std::uint64_t>(low + 1, count - 1), static_cast<float>(inside - static_cast<double>(low))};
}

/// `centred` is likewise, of an axis that closes.
CellBracket bracket_closed(double centred, std::uint32_t count) {
  const double below = std::floor(centred);
  const std::uint64_t low =
      below < 0 ? count - 1 : std::min<std::uint64_t>(static_cast<std::uint64_t>(below), count - 1);
  return {low, low + 1 < count ? low + 1 : 0, static_cast<float>(centred - below)};
}

/// The cell that a position lies in.
CellBracket bracket_nearest(double position, std::uint32_t count) {
  const auto cell = static_cast<std::uint64_t>(std::clamp(position, 0.0, count - 1.0));
  return {cell, cell, 0};
}

/// What phi_d covers.
double turn_of(const MerlConvention& convention) { return convention.turn == MerlTurn::kFull ? 2 * kPi : kPi; }
/// From a cell's lower edge to its value, in cells.
double offset_of(const MerlConvention& convention) { return convention.position == MerlPosition::kEdge ? 0 : 0.5; }

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
  CensusTaker(const Planes& planes, const MerlHead& head, const MerlConvention& convention, const ValuePolicy& policy)
      : planes_(planes),
        head_(head),
        convention_(convention),
        cell_count_(merl_cell_count(head.shape)),
        policy_(policy) {}

  [[nodiscard]] MerlCensus take(std::uint64_t first, std::uint64_t end) const {
    MerlCensus census;
    for (std::uint64_t cell = first; cell < end; ++cell) {
      const bool mark = add_cell(cell, colour_in(planes_, head_.value_size, cell), census);
      if (mark && above_horizon(merl_cell_pair(head_.shape, convention_, cell))) ++census.marks_above;
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
  MerlHead head_;
  const MerlConvention& convention_;
  std::uint64_t cell_count_;
  const ValuePolicy& policy_;
};

}  // namespace

DirectionPair merl_cell_pair(const MerlShape& shape, const MerlConvention& convention, std::uint64_t cell) {
  const auto at = [&](std::uint64_t index) { return static_cast<double>(index) + offset_of(convention); };
  return pair_from_half_difference({merl_theta_h(at(cell / shape[2] / shape[1]), shape[0]), 0,
                                    merl_theta_d(at(cell / shape[2] % shape[1]), shape[1]),
                                    at(cell % shape[2]) / shape[2] * turn_of(convention)});
}

Grid merl_cell_grid(const MerlShape& shape, const MerlConvention& convention) {
  const bool full = convention.turn == MerlTurn::kFull;
  const double at = offset_of(convention);
  std::vector<double> theta_h(shape[0]);
  for (std::uint32_t k = 0; k < shape[0]; ++k) theta_h[k] = 90 * std::pow((k + at) / shape[0], 2);
  const double d = 90.0 / shape[1];
  const double p = (full ? 360.0 : 180.0) / shape[2];
  return {
      GridFrame::kHalfDifference,
      {GridAxis(), GridAxis(std::move(theta_h), Ends::kHeld, Spacing::kRoot), GridAxis(even_nodes(at * d, d, shape[1])),
       GridAxis(even_nodes(at * p, p, shape[2]), full ? Ends::kFullTurn : Ends::kHalfTurn)}};
}

std::string merl_cell_name(const MerlShape& shape, std::uint64_t cell, std::size_t channel) {
  return fmt::format("theta_h {}, theta_d {}, phi_d {}, channel {}", cell / shape[2] / shape[1],
                     cell / shape[2] % shape[1], cell % shape[2], kChannelNames[channel]);
}

std::size_t merl_negative_channels(const std::array<double, kMerlChannelCount>& values) {
  return static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double value) { return value < 0; }));
}

namespace {

/// How two readings of the third dimension fit the cells of a table.
class TurnJudge {
 public:
  TurnJudge(const Planes& planes, const MerlHead& head, MerlPosition position)
      : planes_(planes), head_(head), half_{position, MerlTurn::kHalf}, full_{position, MerlTurn::kFull} {}

  /// Nothing where the content does not tell.
  [[nodiscard]] std::optional<MerlTurn> judge() {
    constexpr std::uint64_t kMostCells = std::uint64_t{1} << 18U;
    const std::uint64_t count = merl_cell_count(head_.shape);
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
    const bool in_half = above_horizon(merl_cell_pair(head_.shape, half_, cell));
    const bool in_full = above_horizon(merl_cell_pair(head_.shape, full_, cell));
    if (in_half && !in_full) ++(blank ? blank_full_ : filled_full_);
    if (in_full && !in_half) ++(blank ? blank_half_ : filled_half_);
    if (blank) return;
    const std::uint64_t row = cell - cell % head_.shape[2];
    const auto along = [&](std::uint32_t step) { return grey(row + (cell - row + step) % head_.shape[2]); };
    const double opposite = along(head_.shape[2] / 2);
    const double across = along(head_.shape[2] / 4);
    if (!(opposite > 0) || !(across > 0)) return;
    sum_ += value;
    opposite_ += std::abs(opposite - value);
    across_ += std::abs(across - value);
  }
  [[nodiscard]] double grey(std::uint64_t cell) const {
    const Colour colour = colour_in(planes_, head_.value_size, cell);
    return (colour[0] + colour[1] + colour[2]) / 3;
  }

  const Planes& planes_;
  MerlHead head_;
  MerlConvention half_, full_;
  double blank_half_ = 0, blank_full_ = 0;    ///< no value, and below the horizon of this reading alone
  double filled_half_ = 0, filled_full_ = 0;  ///< a value, and below the horizon of this reading alone
  double sum_ = 0, opposite_ = 0, across_ = 0;
};

}  // namespace

Result<std::unique_ptr<MerlSource>> MerlSource::make(std::shared_ptr<const ByteSource> file, const ValuePolicy& policy,
                                                     const MerlConvention& convention) {
  const Result<std::vector<std::byte>> start = read_start(*file, kMerlHeaderSize);
  if (!start) return start.error();
  const Result<MerlHead> head = parse_merl_head(*start, file->size());
  if (!head) return head.error();
  if (head->value_size != convention.value_size) {
    return unsupported(head->value_size == sizeof(double)
                           ? "the numbers of this MERL table are 64-bit floats, not --merl-float32"
                           : "a MERL table that has exactly the size of float32 values, or half of one of float64; "
                             "--merl-float32 reads the former",
                       kMerlHeaderSize);
  }
  Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(file));
  if (!viewed) return viewed.error();
  std::unique_ptr<MerlSource> source(new MerlSource(*std::move(viewed), *head, policy, convention));
  source->settle_turn();
  if (Status usable = source->examine(); !usable) return usable.error();
  if (convention.lookup == MerlLookup::kLinear) source->table_ = source->make_table();
  return source;
}

MerlSource::MerlSource(std::shared_ptr<const ByteSource> file, const MerlHead& head, const ValuePolicy& policy,
                       const MerlConvention& convention)
    : file_(std::move(file)),
      shape_(head.shape),
      value_size_(head.value_size),
      convention_(convention),
      cell_count_(merl_cell_count(head.shape)),
      policy_(policy) {
  const std::byte* values = file_->view()->data() + kMerlHeaderSize;
  for (std::size_t c = 0; c < planes_.size(); ++c) planes_[c] = values + value_size_ * cell_count_ * c;
  traits_.format = "merl";
  traits_.description = fmt::format("MERL table, {} x {} x {} cells{}", shape_[0], shape_[1], shape_[2],
                                    value_size_ == sizeof(float) ? ", float32" : "");
  traits_.channels = {"R", "G", "B"};
  traits_.isotropic = true;
  traits_.shape.assign(shape_.begin(), shape_.end());
}

MerlSource::~MerlSource() = default;

void MerlSource::settle_turn() {
  if (convention_.turn == MerlTurn::kAuto) {
    const bool asks = shape_[2] != kMerlShape[2] && shape_[2] % 2 == 0;
    const MerlHead head = {shape_, value_size_};
    const auto turn = asks ? TurnJudge(planes_, head, convention_.position).judge() : MerlTurn::kHalf;
    convention_.turn = turn.value_or(MerlTurn::kHalf);
    if (!turn && shape_[2] >= 3 * shape_[1]) {  // more columns than half a turn is usually given
      traits_.findings.push_back(
          {"cells along phi_d, taken for half a turn; they could cover a full one: --merl-turn full", shape_[2],
           shape_[2]});
    } else if (turn == MerlTurn::kFull) {
      traits_.findings.push_back({"cells along phi_d cover a full turn, as the content tells", shape_[2], shape_[2]});
    }
  }
  traits_.reciprocal = convention_.turn == MerlTurn::kHalf;
  if (!traits_.reciprocal) traits_.description += ", full turn of phi_d";
}

Colour MerlSource::colour_at(std::uint64_t cell) const { return colour_in(planes_, value_size_, cell); }

/// Cells as nodes of a grid.
class MerlSource::CellValues final : public NodeValues {
 public:
  explicit CellValues(const MerlSource& source) : source_(source) {}
  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      Colour colour = source_.colour_at(merl_cell_index(source_.shape_, nodes[n][1], nodes[n][2], nodes[n][3]));
      const bool mark = source_.is_mark(colour);
      for (std::size_t c = 0; c < colour.size(); ++c) {
        double value = mark ? std::numeric_limits<double>::quiet_NaN() : colour[c] * kMerlScale[c];
        if (source_.policy_.negatives == Negatives::kClamp && value < 0) value = 0;
        values[n * colour.size() + c] = value;
      }
    }
  }

 private:
  const MerlSource& source_;  ///< whose table this is
};

std::unique_ptr<DenseTable> MerlSource::make_table() const {
  const ValueType type = value_size_ == sizeof(float) ? ValueType::kFloat32 : ValueType::kFloat64;
  return std::make_unique<DenseTable>(
      DenseTable{merl_cell_grid(shape_, convention_), kMerlChannelCount, std::make_shared<CellValues>(*this), type});
}

Status MerlSource::examine() {
  std::vector<MerlCensus> blocks((cell_count_ + kBlock - 1) / kBlock);
  const CensusTaker taker(planes_, {shape_, value_size_}, convention_, policy_);
  parallel_for(blocks.size(),
               [&](std::uint64_t k) { blocks[k] = taker.take(k * kBlock, std::min(cell_count_, (k + 1) * kBlock)); });
  MerlCensus census;
  for (const MerlCensus& block : blocks) census.add(block);
  if (census.bad > 0 && policy_.non_finite == NonFinite::kRefuse) {
    const std::uint64_t first = census.first_bad;
    return invalid_file(fmt::format("{} of {} MERL values are NaN, infinite or above {:g} as f_r, the first at {}",
                                    census.bad, kMerlChannelCount * cell_count_, kMerlLargest,
                                    merl_cell_name(shape_, first % cell_count_, first / cell_count_)),
                        kMerlHeaderSize + value_size_ * first);
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
  Colour colour = colour_at(index);
  if (is_mark(colour)) return {0, 0, 0, 0};
  if (policy_.negatives == Negatives::kClamp) {
    for (double& value : colour) value = std::max(value, 0.0);
  }
  return {static_cast<float>(colour[0] * kMerlScale[0]), static_cast<float>(colour[1] * kMerlScale[1]),
          static_cast<float>(colour[2] * kMerlScale[2]), 1};
}

MerlSource::Place MerlSource::place_of(const HalfDifference& angles) const {
  // In the root of theta_h rather than in theta_h: less error on sharp lobes, see specs/merl.md.
  const double at_h = merl_theta_h_position(angles.theta_h, shape_[0]);
  const double at_d = angles.theta_d / (kPi / 2) * shape_[1];
  // Under the normal phi_d is the azimuth of the light, which an isotropic material does not know.
  const double turn = turn_of(convention_);
  const double phi_d = angles.theta_h > 0 ? angles.phi_d : 0;
  const double at_p = (phi_d < turn ? phi_d : phi_d - turn) / turn * shape_[2];
  const bool nearest = convention_.lookup == MerlLookup::kNearest;
  const double offset = offset_of(convention_);
  const CellBracket h = nearest ? bracket_nearest(at_h, shape_[0]) : bracket_clamped(at_h - offset, shape_[0]);
  const CellBracket d = nearest ? bracket_nearest(at_d, shape_[1]) : bracket_clamped(at_d - offset, shape_[1]);
  const CellBracket p = nearest ? bracket_nearest(at_p, shape_[2]) : bracket_closed(at_p - offset, shape_[2]);
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
    for (const std::byte* plane : planes_) __builtin_prefetch(plane + value_size_ * (row + place.low));
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
      if (!is_mark(colour_at(index))) {
        measured += weight;
      } else if (above_horizon(merl_cell_pair(shape_, convention_, index))) {
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
  // The mask knows half a turn.
  const std::uint32_t columns = convention_.turn == MerlTurn::kFull ? (shape_[2] + 1) / 2 : shape_[2];
  MaskGrid grid = {MaskFrame::kHalfDifference, {1, shape_[0], shape_[1], columns}};
  while (!grid.is_valid()) {  // a table with more cells than a mask can have
    for (std::uint32_t& count : grid.counts) count = (count + 1) / 2;
  }
  return grid;
}

MerlConvention merl_convention_of(const Options& options, MerlTurn turn) {
  return {value_of(kMerlPositionNames, options.text("merl-position").value_or("")).value_or(MerlPosition::kCentre),
          value_of(kMerlTurnNames, options.text("merl-turn").value_or("")).value_or(turn),
          value_of(kMerlLookupNames, options.text("merl-lookup").value_or("")).value_or(MerlLookup::kLinear),
          options.has("merl-float32") ? sizeof(float) : sizeof(double)};
}

Result<std::unique_ptr<BrdfSource>> open_merl(std::shared_ptr<const ByteSource> file, const Options& options) {
  const ValuePolicy policy = policy_of(options, NonFinite::kUnmeasured);
  Result<std::unique_ptr<MerlSource>> source =
      MerlSource::make(std::move(file), policy, merl_convention_of(options, MerlTurn::kAuto));
  if (!source) return source.error();
  return std::unique_ptr<BrdfSource>(*std::move(source));
}

}  // namespace sbrdf::internal
