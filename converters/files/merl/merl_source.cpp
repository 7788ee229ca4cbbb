#include "converters/files/merl/merl_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/source/atan2_each.h"

namespace sbrdf::internal {

namespace {

constexpr std::array<char, kMerlChannelCount> kChannelNames = {'R', 'G', 'B'};
/// Sums of weights below this are rounding, and their quotients noise.
constexpr float kFaintest = 1e-20f;
/// Pairs whose cells are on their way from memory while angles are worked out.
constexpr std::size_t kAhead = 16;

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

/// Half and difference angles of vectors of any length, those that a MERL table knows: what the arc tangents are of.
/// With h = i + v and d = i - v of equal lengths, theta_d is between the lengths of h and d, which are perpendicular; d
/// turned by -phi_h about z and by -theta_h about y points to phi_d.
class VectorAngles {
 public:
  void add(const glm::dvec3& w_i, const glm::dvec3& w_v) {
    const double length_i = std::sqrt(w_i.x * w_i.x + w_i.y * w_i.y + w_i.z * w_i.z);
    const double length_v = std::sqrt(w_v.x * w_v.x + w_v.y * w_v.y + w_v.z * w_v.z);
    const glm::dvec3 i = length_v * w_i;
    const glm::dvec3 v = length_i * w_v;
    const glm::dvec3 h = i + v;
    const glm::dvec3 d = i - v;
    const double square = h.x * h.x + h.y * h.y;
    const double length = std::sqrt(square + h.z * h.z);
    add(std::sqrt(square), h.z);
    add(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), length);
    // Both times the radius of h.
    add(length * (d.y * h.x - d.x * h.y), h.z * (d.x * h.x + d.y * h.y) - square * d.z);
  }
  void finish() { atan2_each(std::span(y_).first(size_), std::span(x_).first(size_), std::span(y_).first(size_)); }

  [[nodiscard]] HalfDifference operator[](std::size_t pair) const {
    const double* own = y_.data() + 3 * pair;
    return {own[0], 0, own[1], own[2] < 0 ? wrap(own[2], 2 * kPi) : own[2]};
  }

 private:
  void add(double y, double x) {
    y_[size_] = y;
    x_[size_++] = x;
  }

  std::array<double, 3 * kAhead> y_;
  std::array<double, 3 * kAhead> x_;
  std::size_t size_ = 0;
};

/// Tells from the bits of numbers, which rise as they do, whether a cell could be a mark or is out of range.
class PlainCells {
 public:
  /// `some_negative`: a cell with a single negative channel is no plain one.
  explicit PlainCells(bool some_negative) : some_negative_(some_negative ? kSign : 0) {}

  void take(const MerlColour& colour) {
    std::uint64_t all = kSign;
    std::uint64_t any = 0;
    for (const double value : colour) {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      all &= bits;
      any |= bits;
      // Has the sign where the size is beyond the largest, infinite or NaN.
      seen_ |= std::bit_cast<std::uint64_t>(kMerlLargest) - (bits & ~kSign);
    }
    seen_ |= all | (any & some_negative_);
  }
  [[nodiscard]] bool all() const { return (seen_ & kSign) == 0; }

 private:
  static constexpr std::uint64_t kSign = std::uint64_t{1} << 63U;
  std::uint64_t some_negative_;
  std::uint64_t seen_ = 0;
};

}  // namespace

Grid merl_cell_grid(const MerlShape& shape, const MerlConvention& convention) {
  const bool full = convention.turn == MerlTurn::kFull;
  const double at = merl_offset(convention);
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
    : file_(std::move(file)), cells_(head, file_->view()->data()), convention_(convention), policy_(policy) {
  const MerlShape& shape = cells_.shape();
  traits_.format = "merl";
  traits_.description = fmt::format("MERL table, {} x {} x {} cells{}", shape[0], shape[1], shape[2],
                                    head.value_size == sizeof(float) ? ", float32" : "");
  traits_.channels = {"R", "G", "B"};
  traits_.isotropic = true;
  traits_.shape.assign(shape.begin(), shape.end());
}

MerlSource::~MerlSource() = default;

void MerlSource::settle_turn() {
  if (convention_.turn == MerlTurn::kAuto) {
    const MerlShape& shape = cells_.shape();
    const bool asks = shape[2] != kMerlShape[2] && shape[2] % 2 == 0;
    const auto turn = asks ? judge_merl_turn(cells_, convention_.position) : MerlTurn::kHalf;
    convention_.turn = turn.value_or(MerlTurn::kHalf);
    if (!turn && shape[2] >= 3 * shape[1]) {  // more columns than half a turn is usually given
      traits_.findings.push_back(
          {"cells along phi_d, taken for half a turn; they could cover a full one: --merl-turn full", shape[2],
           shape[2]});
    } else if (turn == MerlTurn::kFull) {
      traits_.findings.push_back({"cells along phi_d cover a full turn, as the content tells", shape[2], shape[2]});
    }
  }
  traits_.reciprocal = convention_.turn == MerlTurn::kHalf;
  if (!traits_.reciprocal) traits_.description += ", full turn of phi_d";
}

/// Cells as nodes of a grid.
class MerlSource::CellValues final : public NodeValues {
 public:
  explicit CellValues(const MerlSource& source) : source_(source) {}
  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const MerlCells& cells = source_.cells_;
      const MerlColour colour = cells.colour(merl_cell_index(cells.shape(), nodes[n][1], nodes[n][2], nodes[n][3]));
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
  const ValueType type = cells_.value_size() == sizeof(float) ? ValueType::kFloat32 : ValueType::kFloat64;
  return std::make_unique<DenseTable>(DenseTable{merl_cell_grid(cells_.shape(), convention_), kMerlChannelCount,
                                                 std::make_shared<CellValues>(*this), type});
}

const MerlCensus& MerlSource::census() const {
  std::call_once(census_asked_, [&] {
    census_ = take_merl_census(cells_, convention_, policy_);
    findings_ = traits_.findings;
    add_findings();
  });
  return census_;
}

Status MerlSource::examine() const {
  if (policy_.non_finite == NonFinite::kRefuse && census().bad > 0) {
    const std::uint64_t first = census().first_bad;
    const std::uint64_t count = cells_.count();
    return invalid_file(fmt::format("{} of {} MERL values are NaN, infinite or above {:g} as f_r, the first at {}",
                                    census().bad, kMerlChannelCount * count, kMerlLargest,
                                    merl_cell_name(cells_.shape(), first % count, first / count)),
                        kMerlHeaderSize + cells_.value_size() * first);
  }
  if (!has_positive_value(cells_, policy_)) return invalid_file("no value of the MERL table is positive");
  return ok_status();
}

void MerlSource::add_findings() const {
  const auto add = [&](std::string what, std::uint64_t count) {
    if (count > 0) findings_.push_back({std::move(what), count, cells_.count()});
  };
  if (census_.bad > 0) {
    add(fmt::format(
            "cells with a value that is NaN, infinite or above {:g} as f_r, taken as unmeasured; the first at {}",
            kMerlLargest,
            merl_cell_name(cells_.shape(), census_.first_bad % cells_.count(), census_.first_bad / cells_.count())),
        census_.bad_cells);
  }
  add("cells unmeasured or below the horizon", census_.marks);
  add("cells unmeasured above the horizon", census_.marks_above);
  const std::string what = "cells with some negative channel";
  if (policy_.negatives == Negatives::kClamp) {
    add(what + ", 0 in its place", census_.mixed);
  } else {
    add(policy_.negatives == Negatives::kKeep ? what : what + ", taken as unmeasured", census_.mixed);
  }
}

bool MerlSource::changes_values() const {
  return census().bad > 0 || (census().mixed > 0 && policy_.negatives != Negatives::kKeep);
}

bool MerlSource::is_mark(const MerlColour& colour) const {
  const std::size_t negative = merl_negative_channels(colour);
  if (negative == kMerlChannelCount || (negative > 0 && policy_.negatives == Negatives::kUnmeasured)) return true;
  bool finite = true;
  for (std::size_t c = 0; c < colour.size(); ++c) finite = finite && is_finite_merl_value(colour[c], c);
  return !finite;
}

// A cell and a half of theta_d: there, no pair lies among cells below the horizon alone.
DirectionPair MerlSource::away_from_horizon(DirectionPair pair) const {
  const double limit = kPi / 2 * std::max(0.0, 1 - 1.5 / cells_.shape()[1]);
  pair.i.theta = std::min(pair.i.theta, limit);
  pair.v.theta = std::min(pair.v.theta, limit);
  return pair;
}

MerlSource::Place MerlSource::place_of(const HalfDifference& angles) const {
  const MerlShape& shape = cells_.shape();
  // In the root of theta_h rather than in theta_h: less error on sharp lobes, see specs/merl.md.
  const double at_h = merl_theta_h_position(angles.theta_h, shape[0]);
  const double at_d = angles.theta_d / (kPi / 2) * shape[1];
  // Under the normal phi_d is the azimuth of the light, which an isotropic material does not know.
  const double turn = merl_turn(convention_);
  const double phi_d = angles.theta_h > 0 ? angles.phi_d : 0;
  const double at_p = (phi_d < turn ? phi_d : phi_d - turn) / turn * shape[2];
  const bool nearest = convention_.lookup == MerlLookup::kNearest;
  const double offset = merl_offset(convention_);
  const CellBracket h = nearest ? bracket_nearest(at_h, shape[0]) : bracket_clamped(at_h - offset, shape[0]);
  const CellBracket d = nearest ? bracket_nearest(at_d, shape[1]) : bracket_clamped(at_d - offset, shape[1]);
  const CellBracket p = nearest ? bracket_nearest(at_p, shape[2]) : bracket_closed(at_p - offset, shape[2]);
  const auto row = [&](std::uint64_t theta_h_index, std::uint64_t theta_d_index) {
    return merl_cell_index(shape, theta_h_index, theta_d_index, 0);
  };
  return {{row(h.low, d.low), row(h.low, d.high), row(h.high, d.low), row(h.high, d.high)},
          {(1 - h.weight) * (1 - d.weight), (1 - h.weight) * d.weight, h.weight * (1 - d.weight), h.weight * d.weight},
          p.low,
          p.high,
          p.weight};
}

void MerlSource::fetch(const Place& place) const {
  for (const std::uint64_t row : place.rows) cells_.fetch(row + place.low);
}

template <class T>
MerlSource::Cell MerlSource::cell(std::uint64_t index) const {
  MerlColour colour = cells_.colour_as<T>(index);
  if (is_mark(colour)) return {0, 0, 0, 0};
  if (policy_.negatives == Negatives::kClamp) {
    for (double& value : colour) value = std::max(value, 0.0);
  }
  return {static_cast<float>(colour[0] * kMerlScale[0]), static_cast<float>(colour[1] * kMerlScale[1]),
          static_cast<float>(colour[2] * kMerlScale[2]), 1};
}

// All eight cells are read before any is looked at, so that no load waits for another. Where all of them are plain, as
// nearly everywhere, the sum is that of the other way, bit for bit.
template <class T>
MerlSource::Cell MerlSource::interpolate(const Place& place) const {
  PlainCells plain(policy_.negatives != Negatives::kKeep);
  std::array<std::array<MerlColour, 2>, 4> colours;
  for (std::size_t k = 0; k < place.rows.size(); ++k) {
    colours[k] = {cells_.colour_as<T>(place.rows[k] + place.low), cells_.colour_as<T>(place.rows[k] + place.high)};
    plain.take(colours[k][0]);
    plain.take(colours[k][1]);
  }
  if (!plain.all()) return interpolate_marked<T>(place);
  Cell sum = {0, 0, 0, 0};
  for (std::size_t k = 0; k < place.rows.size(); ++k) {
    const auto add = [&](std::size_t c, float low, float high) {
      sum[c] += place.row_weights[k] * ((1 - place.high_weight) * low + place.high_weight * high);
    };
    const auto& [low, high] = colours[k];
    for (std::size_t c = 0; c < kMerlChannelCount; ++c) {
      add(c, static_cast<float>(low[c] * kMerlScale[c]), static_cast<float>(high[c] * kMerlScale[c]));
    }
    add(3, 1, 1);
  }
  return sum;
}

template <class T>
MerlSource::Cell MerlSource::interpolate_marked(const Place& place) const {
  Cell sum = {0, 0, 0, 0};
  for (std::size_t k = 0; k < place.rows.size(); ++k) {
    const Cell low = cell<T>(place.rows[k] + place.low);
    const Cell high = cell<T>(place.rows[k] + place.high);
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c] += place.row_weights[k] * ((1 - place.high_weight) * low[c] + place.high_weight * high[c]);
    }
  }
  return sum;
}

template <class T, class PairOf>
void MerlSource::evaluate_numbers(std::span<const Place> places, std::span<const bool> above, const PairOf& pair_of,
                                  float* values) const {
  for (std::size_t k = 0; k < places.size(); ++k) {
    Cell sum{};
    if (above[k]) {
      sum = interpolate<T>(places[k]);
      if (sum[3] <= kFaintest) {
        sum = interpolate<T>(place_of(half_difference_from_pair(away_from_horizon(pair_of(k)))));
      }
    }
    for (std::size_t c = 0; c < kMerlChannelCount; ++c) {
      values[k * kMerlChannelCount + c] = sum[3] > kFaintest ? sum[c] / sum[3] : 0.0f;
    }
  }
}

template <class PairOf>
void MerlSource::evaluate_places(std::span<const Place> places, std::span<const bool> above, const PairOf& pair_of,
                                 float* values) const {
  if (places.size() > 1) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (above[k]) fetch(places[k]);
    }
  }
  if (cells_.value_size() == sizeof(float)) return evaluate_numbers<float>(places, above, pair_of, values);
  evaluate_numbers<double>(places, above, pair_of, values);
}

void MerlSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  assert(values.size() == pairs.size() * kMerlChannelCount);
  std::array<Place, kAhead> places;  // of those above the horizon
  std::array<bool, kAhead> above;
  for (std::size_t first = 0; first < pairs.size(); first += kAhead) {
    const std::size_t count = std::min(kAhead, pairs.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      above[k] = above_horizon(pairs[first + k]);
      if (above[k]) places[k] = place_of(half_difference_from_pair(pairs[first + k]));
    }
    evaluate_places(
        std::span(places).first(count), std::span(above).first(count), [&](std::size_t k) { return pairs[first + k]; },
        values.data() + first * kMerlChannelCount);
  }
}

void MerlSource::evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                  std::span<float> values) const {
  assert(w_i.size() == w_v.size() && values.size() == w_i.size() * kMerlChannelCount);
  std::array<Place, kAhead> places;
  std::array<bool, kAhead> above;
  for (std::size_t first = 0; first < w_i.size(); first += kAhead) {
    const std::size_t count = std::min(kAhead, w_i.size() - first);
    VectorAngles angles;
    for (std::size_t k = 0; k < count; ++k) {
      above[k] = above_horizon(w_i[first + k]) && above_horizon(w_v[first + k]);
      const glm::dvec3 normal = {0, 0, 1};  // stands in for what is no direction
      angles.add(above[k] ? glm::dvec3(w_i[first + k]) : normal, above[k] ? glm::dvec3(w_v[first + k]) : normal);
    }
    angles.finish();
    for (std::size_t k = 0; k < count; ++k) places[k] = place_of(angles[k]);
    const auto pair_of = [&](std::size_t k) {
      return DirectionPair{direction_from_vector(glm::dvec3(w_i[first + k])),
                           direction_from_vector(glm::dvec3(w_v[first + k]))};
    };
    evaluate_places(std::span(places).first(count), std::span(above).first(count), pair_of,
                    values.data() + first * kMerlChannelCount);
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
      if (!is_mark(cells_.colour(index))) {
        measured += weight;
      } else if (above_horizon(merl_cell_pair(cells_.shape(), convention_, index))) {
        marked += weight;
      }
    }
  }
  return measured >= marked;
}

void MerlSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  const bool holes = census().marks_above > 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const bool ask = holes && above_horizon(pairs[k]);
    flags[k] = !ask || is_measured(place_of(half_difference_from_pair(pairs[k]))) ? 1 : 0;
  }
}

std::optional<MaskGrid> MerlSource::mask_grid() const {
  if (census().marks_above == 0) return std::nullopt;
  const MerlShape& shape = cells_.shape();
  // The mask knows half a turn.
  const std::uint32_t columns = convention_.turn == MerlTurn::kFull ? (shape[2] + 1) / 2 : shape[2];
  MaskGrid grid = {MaskFrame::kHalfDifference, {1, shape[0], shape[1], columns}};
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
