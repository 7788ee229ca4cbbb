#include "converters/files/merl.h"
#include "formats/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sbrdf {

namespace {

constexpr std::array<char, kMerlChannelCount> kChannelNames = {'R', 'G', 'B'};
/// Largest f_r that is taken: weighted sums of such values still fit a float.
constexpr double kLargest = 1e38;
/// Sums of weights below this are rounding, and their quotients noise.
constexpr float kFaintest = 1e-20f;
/// On disk, in every channel of a cell that has no value.
constexpr double kMark = -1;

using Colour = std::array<double, kMerlChannelCount>;

Colour colour_at(const MerlTable& table, std::uint64_t cell) {
  const std::uint64_t count = merl_cell_count(table.shape);
  return {table.values[cell], table.values[count + cell], table.values[2 * count + cell]};
}

std::ptrdiff_t negative_channels(const Colour& colour) {
  return std::count_if(colour.begin(), colour.end(), [](double value) { return value < 0; });
}

std::string cell_name(const MerlShape& shape, std::uint64_t cell, std::size_t channel) {
  return fmt::format("theta_h {}, theta_d {}, phi_d {}, channel {}", cell / shape[2] / shape[1],
                     cell / shape[2] % shape[1], cell % shape[2], kChannelNames[channel]);
}

std::optional<Error> find_unusable(const MerlTable& table) {
  const std::uint64_t cells = merl_cell_count(table.shape);
  std::uint64_t bad = 0, first = 0;
  bool positive = false;
  for (std::uint64_t n = 0; n < table.values.size(); ++n) {
    const double value = table.values[n];
    positive = positive || value > 0;
    if (std::fabs(value * kMerlScale[n / cells]) <= kLargest) continue;
    if (bad++ == 0) first = n;
  }
  if (bad > 0) {
    return invalid_file(
        fmt::format("{} of {} MERL values are NaN, infinite or above {:g} as f_r, the first at {}", bad,
                    table.values.size(), kLargest, cell_name(table.shape, first % cells, first / cells)),
        kMerlHeaderSize + sizeof(double) * first);
  }
  if (!positive) return invalid_file("no value of the MERL table is positive");
  return {};
}

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

Result<std::unique_ptr<MerlSource>> MerlSource::make(MerlTable table) {
  assert(is_sane_merl_shape(table.shape));
  assert(table.values.size() == kMerlChannelCount * merl_cell_count(table.shape));
  if (auto error = find_unusable(table)) return *error;
  return std::unique_ptr<MerlSource>(new MerlSource(std::move(table)));
}

MerlSource::MerlSource(MerlTable table) : table_(std::move(table)), cells_(merl_cell_count(table_.shape)) {
  std::uint64_t marks = 0, mixed = 0;
  for (std::uint64_t n = 0; n < cells_.size(); ++n) {
    const Colour colour = colour_at(table_, n);
    const auto negative = negative_channels(colour);
    if (negative == kMerlChannelCount) {
      cells_[n] = {0, 0, 0, 0};
      ++marks;
      continue;
    }
    if (negative > 0) ++mixed;
    for (std::size_t c = 0; c < colour.size(); ++c) cells_[n][c] = static_cast<float>(colour[c] * kMerlScale[c]);
    cells_[n][3] = 1;
  }
  traits_.format = "merl";
  traits_.description =
      fmt::format("MERL table, {} x {} x {} cells", table_.shape[0], table_.shape[1], table_.shape[2]);
  traits_.channels = {"R", "G", "B"};
  traits_.isotropic = traits_.reciprocal = true;
  if (marks > 0) traits_.findings.push_back({"cells unmeasured or below the horizon", marks, cells_.size()});
  if (mixed > 0) traits_.findings.push_back({"cells with some negative channel", mixed, cells_.size()});
}

MerlSource::Cell MerlSource::interpolate(const HalfDifference& angles) const {
  const MerlShape& shape = table_.shape;
  // In the root of theta_h rather than in theta_h: less error on sharp lobes, see specs/merl.md.
  const Bracket h = bracket_clamped(merl_theta_h_position(angles.theta_h, shape[0]) - 0.5, shape[0]);
  const Bracket d = bracket_clamped(angles.theta_d / (kPi / 2) * shape[1] - 0.5, shape[1]);
  // Under the normal phi_d is the azimuth of the light, which an isotropic material does not know.
  const Bracket p = bracket_phi_d(angles.theta_h > 0 ? angles.phi_d : 0, shape[2]);

  Cell sum = {0, 0, 0, 0};
  const auto add_row = [&](std::uint64_t theta_h_index, std::uint64_t theta_d_index, float weight) {
    const Cell* row = cells_.data() + merl_cell_index(shape, theta_h_index, theta_d_index, 0);
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c] += weight * ((1 - p.weight) * row[p.low][c] + p.weight * row[p.high][c]);
    }
  };
  add_row(h.low, d.low, (1 - h.weight) * (1 - d.weight));
  add_row(h.low, d.high, (1 - h.weight) * d.weight);
  add_row(h.high, d.low, h.weight * (1 - d.weight));
  add_row(h.high, d.high, h.weight * d.weight);
  return sum;
}

void MerlSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  assert(values.size() == pairs.size() * kMerlChannelCount);
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const bool above = pairs[n].i.theta <= kPi / 2 && pairs[n].v.theta <= kPi / 2;
    const Cell sum = above ? interpolate(half_difference_from_pair(pairs[n])) : Cell{};
    for (std::size_t c = 0; c < kMerlChannelCount; ++c) {
      values[n * kMerlChannelCount + c] = sum[3] > kFaintest ? sum[c] / sum[3] : 0.0f;
    }
  }
}

namespace {

struct RowReport {
  std::uint64_t below_horizon = 0, some_negative = 0, all_negative = 0;
};

/// The work of resample_merl, one row of phi_d at a time.
class Resampler {
 public:
  Resampler(const BrdfSource& source, const MerlShape& shape)
      : source_(source), shape_(shape), rows_(std::uint64_t{shape[0]} * shape[1]) {
    table_.shape = shape;
    table_.values.resize(kMerlChannelCount * merl_cell_count(shape));
  }

  [[nodiscard]] std::uint64_t row_count() const { return rows_.size(); }

  void sample_row(std::uint64_t row) {
    std::vector<DirectionPair> pairs;
    std::vector<std::uint64_t> cells;
    for (std::uint32_t p = 0; p < shape_[2]; ++p) {
      const DirectionPair pair = centre(row, p);
      const std::uint64_t cell = row * shape_[2] + p;
      if (pair.i.theta > kPi / 2 || pair.v.theta > kPi / 2) {
        store(cell, {kMark, kMark, kMark});
      } else {
        pairs.push_back(pair);
        cells.push_back(cell);
      }
    }
    rows_[row].below_horizon = shape_[2] - cells.size();
    std::vector<float> values(pairs.size() * source_.channel_count());
    source_.evaluate(pairs, values);
    for (std::size_t n = 0; n < cells.size(); ++n) store_sample(row, cells[n], values, n);
  }

  Result<MerlResampling> take() && {
    if (first_bad_ < table_.values.size()) {
      const std::uint64_t count = merl_cell_count(shape_);
      return invalid_file("the source gives a NaN or an infinity for the MERL cell at " +
                          cell_name(shape_, first_bad_ % count, first_bad_ / count));
    }
    MerlReport report;
    report.cells = merl_cell_count(shape_);
    for (const RowReport& row : rows_) {
      report.below_horizon += row.below_horizon;
      report.some_negative += row.some_negative;
      report.all_negative += row.all_negative;
    }
    report.anisotropic_source_cut = !source_.traits().isotropic;
    report.source_not_reciprocal = !source_.traits().reciprocal;
    report.channel_repeated = source_.channel_count() == 1;
    return MerlResampling{std::move(table_), report};
  }

 private:
  [[nodiscard]] DirectionPair centre(std::uint64_t row, std::uint32_t phi_d_index) const {
    const std::uint64_t h = row / shape_[1];
    const std::uint64_t d = row % shape_[1];
    return pair_from_half_difference({merl_theta_h(static_cast<double>(h) + 0.5, shape_[0]), 0,
                                      merl_theta_d(static_cast<double>(d) + 0.5, shape_[1]),
                                      merl_phi_d(phi_d_index + 0.5, shape_[2])});
  }

  void store(std::uint64_t cell, const Colour& colour) {
    for (std::size_t c = 0; c < colour.size(); ++c) table_.values[c * merl_cell_count(shape_) + cell] = colour[c];
  }

  void store_sample(std::uint64_t row, std::uint64_t cell, std::span<const float> values, std::size_t n) {
    const std::size_t channels = source_.channel_count();
    Colour colour{};
    for (std::size_t c = 0; c < colour.size(); ++c) {
      const float value = values[n * channels + (channels == 1 ? 0 : c)];
      if (!std::isfinite(value)) note_bad(c * merl_cell_count(shape_) + cell);
      colour[c] = value / kMerlScale[c];
    }
    store(cell, colour);
    const auto negative = negative_channels(colour);
    if (negative == kMerlChannelCount) {
      ++rows_[row].all_negative;
    } else if (negative > 0) {
      ++rows_[row].some_negative;
    }
  }

  // The least position, so that the message does not depend on which thread came first.
  void note_bad(std::uint64_t position) {
    std::uint64_t seen = first_bad_;
    while (position < seen && !first_bad_.compare_exchange_weak(seen, position)) {
    }
  }

  const BrdfSource& source_;
  MerlShape shape_;
  MerlTable table_;
  std::vector<RowReport> rows_;
  std::atomic<std::uint64_t> first_bad_ = std::numeric_limits<std::uint64_t>::max();
};

}  // namespace

Result<MerlResampling> resample_merl(const BrdfSource& source, const MerlShape& shape, const Progress& progress) {
  if (!is_sane_merl_shape(shape) || merl_cell_count(shape) > kMerlMaxResampledCells) {
    return usage_error(
        fmt::format("a MERL table has 1 to {} cells along each axis and here at most {} in all, not {} x {} x {}",
                    kMerlMaxCount, kMerlMaxResampledCells, shape[0], shape[1], shape[2]));
  }
  if (source.channel_count() != kMerlChannelCount && source.channel_count() != 1) {
    return unsupported(fmt::format("a MERL table holds 3 channels, the source has {}", source.channel_count()));
  }
  Resampler resampler(source, shape);
  ProgressCounter counter(progress, resampler.row_count());
  parallel_for(resampler.row_count(), [&](std::uint64_t row) {
    if (counter.stopped()) return;
    resampler.sample_row(row);
    counter.advance();
  });
  if (counter.stopped()) return interrupted_error();
  return std::move(resampler).take();
}

}  // namespace sbrdf
