#include "converters/files/zemax/zemax_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "converters/files/rgb_of_xyz.h"
#include "converters/files/value_options.h"
#include "converters/files/zemax/zemax_integral.h"
#include "converters/tables/dense_source.h"
#include "formats/core/named.h"
#include "formats/zemax/zemax.h"

namespace sbrdf::internal {
namespace {

/// What an exact 0 above the horizon is.
enum class Zeros : std::uint8_t {
  kAuto,        ///< unmeasured in a file whose other values never come near 0, else black
  kUnmeasured,  ///< a direction without a value
  kBlack,       ///< the value 0
};
constexpr std::array kZerosNames = {Named{"auto", Zeros::kAuto}, Named{"unmeasured", Zeros::kUnmeasured},
                                    Named{"black", Zeros::kBlack}};
constexpr auto kZerosChoices = names_of(kZerosNames);

/// What a SampleRotation is.
enum class Rotation : std::uint8_t {
  kLight,   ///< phi_i: the light goes round the sample
  kSample,  ///< -phi_i: the sample turns under the light
};
constexpr std::array kRotationNames = {Named{"light", Rotation::kLight}, Named{"sample", Rotation::kSample}};
constexpr auto kRotationChoices = names_of(kRotationNames);

constexpr std::array kOptions = {
    negatives_option(OptionUse::kRead),
    OptionSpec{.name = "zemax-zeros",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kZerosChoices,
               .fallback = "auto",
               .meaning = "Values of exactly 0 above the horizon: black, not measured, or (auto) not measured if no "
                          "other value of the file is below a thousandth of their median"},
    OptionSpec{.name = "zemax-rotation",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kRotationChoices,
               .fallback = "light",
               .meaning = "SampleRotation is phi_i, the azimuth of the light on the sample (light), or how far the "
                          "sample was turned counter-clockwise under a fixed light, -phi_i (sample)"},
};

/// `auto`: the least value of a file that has no blacks, over the median of all that are not 0.
constexpr double kDarkest = 1e-3;
/// From where on an integral is said to differ from the TIS stated.
constexpr double kTisTolerance = 0.05;
constexpr double kTurnTolerance = 1e-6;     // degrees
constexpr double kHorizonTolerance = 1e-9;  // radians

/// Angles of an axis, and the positions of these in the list of the file.
struct Nodes {
  std::vector<double> angles;
  std::vector<std::size_t> positions;
  bool repeats = false;      ///< the last angle of the list is the first plus a turn, and left out
  double uncovered_deg = 0;  ///< a gap between the last and the first much wider than those listed
};

/// A list of azimuths that closes after a turn; `sign` of -1 turns it round.
Nodes turn_of(const std::vector<double>& list, double sign) {
  Nodes nodes;
  const std::size_t count = list.size();
  nodes.repeats = count > 1 && list.back() - list.front() > 360 - kTurnTolerance;
  std::vector<std::pair<double, std::size_t>> sorted;
  for (std::size_t k = 0; k < count - (nodes.repeats ? 1 : 0); ++k) sorted.emplace_back(wrap(sign * list[k], 360), k);
  std::sort(sorted.begin(), sorted.end());
  for (const auto& [angle, position] : sorted) {
    nodes.angles.push_back(angle);
    nodes.positions.push_back(position);
  }
  double widest = 0;
  for (std::size_t k = 1; k < count; ++k) widest = std::max(widest, list[k] - list[k - 1]);
  const double closing = 360 - (list.back() - list.front());
  if (count > 1 && closing > 1.5 * widest) nodes.uncovered_deg = closing;
  return nodes;
}

Nodes listed(const std::vector<double>& list) {
  Nodes nodes;
  nodes.angles = list;
  nodes.positions.resize(list.size());
  std::iota(nodes.positions.begin(), nodes.positions.end(), std::size_t{0});
  return nodes;
}

/// Above the horizon or on it, whatever rounding says of the latter.
bool reaches_horizon(const DirectionPair& pair) {
  return pair.i.theta <= kPi / 2 + kHorizonTolerance && pair.v.theta <= kPi / 2 + kHorizonTolerance;
}

/// Makes a dense table of what a file says.
class Reading {
 public:
  Reading(const ZemaxTable& table, Zeros zeros, Rotation rotation) : table_(table), zeros_(zeros) {
    phi_i_ = turn_of(table.rotations, rotation == Rotation::kLight ? 1 : -1);
    azimuth_ = is_mirrored() ? listed(table.azimuths) : turn_of(table.azimuths, 1);
    if (is_mirrored()) azimuth_.angles.back() = std::min(azimuth_.angles.back(), 180.0);
    add_outer_radials();
  }

  Result<std::unique_ptr<BrdfSource>> source(const Negatives negatives) {
    if (Status made = make_grid(); !made) return made.error();
    if (zeros_ == Zeros::kAuto) zeros_ = never_dark() ? Zeros::kUnmeasured : Zeros::kBlack;
    std::vector<double> values = node_values();
    add_zero_findings();
    add_seam_finding("SampleRotation", phi_i_, 0);
    add_seam_finding("ScatterAzimuth", azimuth_, 2);
    add_centre_finding();
    add_gap_findings();

    DenseDescription description;
    description.format = "zemax";
    description.description =
        fmt::format("Zemax table, {}, {}, {}; {}", grid_.size_text(), name_of(kZemaxSymmetryNames, table_.symmetry),
                    name_of(kZemaxSpectrumNames, table_.spectrum), compare_tis());
    description.channels =
        channel_count() == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
    description.policy = {negatives, NonFinite::kUnmeasured};
    description.findings = std::move(findings_);
    description.unmeasured = "nodes above the horizon not measured";
    return DenseSource::make(table_in_memory(grid_, channel_count(), std::move(values)), std::move(description));
  }

 private:
  [[nodiscard]] bool is_mirrored() const { return table_.symmetry == ZemaxSymmetry::kPlaneSymmetrical; }
  [[nodiscard]] std::size_t channel_count() const { return table_.channel_count(); }

  // A list of radials may end before the horizon does. What lies beyond was not measured.
  void add_outer_radials() {
    radials_ = table_.radials;
    const double last = radials_.back();
    if (last >= 90 + table_.incidences.back() - kTurnTolerance) return;
    const double step = radials_.size() > 1 ? last - radials_[radials_.size() - 2] : 10;
    radials_.push_back(std::min(last + step, 180.0));
    if (radials_.back() < 180) radials_.push_back(180);
  }

  Status make_grid() {
    grid_.frame = GridFrame::kMirror;
    const std::array<std::pair<const std::vector<double>*, Ends>, 4> axes = {
        {{&phi_i_.angles, Ends::kFullTurn},
         {&table_.incidences, Ends::kHeld},
         {&azimuth_.angles, is_mirrored() ? Ends::kMirrored : Ends::kFullTurn},
         {&radials_, Ends::kHeld}}};
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const auto& [nodes, ends] = axes.at(k);
      if (!GridAxis::is_valid(*nodes, ends, Spacing::kAngle)) {
        return invalid_file(fmt::format("two angles of {} are the same but for rounding", grid_.axis_name(k)));
      }
      grid_.axes.at(k) = GridAxis(*nodes, ends);
    }
    return ok_status();
  }

  // Position of a number of the file, of channel 0; `node` has its radial within the list.
  [[nodiscard]] std::size_t position(const GridNode& node) const {
    const std::size_t block = phi_i_.positions[node[0]] * table_.incidences.size() + node[1];
    return (block * table_.azimuths.size() + azimuth_.positions[node[2]]) * table_.radials.size() + node[3];
  }
  [[nodiscard]] double number(std::size_t position, std::size_t channel) const {
    return table_.values[channel * table_.block_count() * table_.block_size() + position];
  }
  [[nodiscard]] bool is_zero(std::size_t position) const {
    for (std::size_t c = 0; c < channel_count(); ++c) {
      if (number(position, c) != 0) return false;
    }
    return true;
  }

  // Measurements that reach black pass by it; zeros in others are gaps.
  [[nodiscard]] bool never_dark() const {
    std::vector<double> sizes;
    sizes.reserve(table_.values.size());
    for (const double value : table_.values) {
      if (value != 0) sizes.push_back(std::abs(value));
    }
    if (sizes.empty()) return false;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    return *std::min_element(sizes.begin(), middle + 1) >= kDarkest * *middle;
  }

  std::vector<double> node_values() {
    const std::size_t channels = channel_count();
    const std::uint64_t count = grid_.node_count();
    std::vector<double> values(count * channels, std::numeric_limits<double>::quiet_NaN());
    for (std::uint64_t k = 0; k < count; ++k) {
      const GridNode node = grid_.node(k);
      if (node[3] >= table_.radials.size()) continue;
      const std::size_t at = position(node);
      const bool zero = is_zero(at);
      const bool above = reaches_horizon(grid_.pair_of(node));
      if (above && zero) ++zeros_above_;
      if (!above && !zero) ++values_below_;
      if (zero && (!above || zeros_ == Zeros::kUnmeasured)) continue;
      for (std::size_t c = 0; c < channels; ++c)
        values[k * channels + c] = channels == 1 ? number(at, 0) : colour(at, c);
    }
    return values;
  }
  [[nodiscard]] double colour(std::size_t at, std::size_t channel) const {
    const std::array<double, 3>& row = kRgbOfXyz.at(channel);
    return row[0] * number(at, 0) + row[1] * number(at, 1) + row[2] * number(at, 2);
  }

  void add(std::string what, std::uint64_t count, std::uint64_t total) {
    if (count > 0) findings_.push_back({std::move(what), count, total});
  }

  void add_zero_findings() {
    const bool black = zeros_ == Zeros::kBlack;
    add(fmt::format("nodes above the horizon, or on it, with a value of exactly 0, taken as {}",
                    black ? "black" : "unmeasured"),
        zeros_above_, grid_.node_count());
    add("nodes below the horizon with a value", values_below_, grid_.node_count());
  }

  // `axis` of the grid, of which the file lists 0 and 360 degrees.
  void add_seam_finding(std::string_view name, const Nodes& nodes, std::size_t axis) {
    if (!nodes.repeats) return;
    const std::array<std::size_t, 4> shape = {table_.rotations.size(), table_.incidences.size(), table_.azimuths.size(),
                                              table_.radials.size()};
    const std::size_t inner = std::accumulate(shape.begin() + static_cast<std::ptrdiff_t>(axis) + 1, shape.end(),
                                              std::size_t{1}, std::multiplies<>());
    const std::size_t outer = table_.block_count() * table_.block_size() / inner / shape.at(axis);
    const std::size_t apart = (shape.at(axis) - 1) * inner;
    std::uint64_t different = 0;
    double largest = 0;
    for (std::size_t k = 0; k < outer * inner; ++k) {
      const std::size_t first = k / inner * shape.at(axis) * inner + k % inner;
      bool same = true;
      for (std::size_t c = 0; c < channel_count(); ++c) {
        const double difference = std::abs(number(first, c) - number(first + apart, c));
        largest = std::max(largest, difference);
        same = same && difference == 0;
      }
      if (!same) ++different;
    }
    const std::vector<double>& list = axis == 0 ? table_.rotations : table_.azimuths;
    add(fmt::format("values at {} {:g} that differ from those at {:g}, by up to {:.4g} 1/sr; the latter are used", name,
                    list.back(), list.front(), largest),
        different, outer * inner);
  }

  // All azimuths are one direction at radial 0.
  void add_centre_finding() {
    if (table_.radials.front() > 0) return;
    std::uint64_t uneven = 0;
    for (std::size_t block = 0; block < table_.block_count(); ++block) {
      const std::size_t first = block * table_.block_size();
      bool even = true;
      for (std::size_t k = 0; k < table_.block_size(); k += table_.radials.size()) {
        for (std::size_t c = 0; c < channel_count(); ++c) even = even && number(first + k, c) == number(first, c);
      }
      if (!even) ++uneven;
    }
    add("mirror directions at which the value depends on the azimuth", uneven, table_.block_count());
  }

  void add_gap_findings() {
    const auto degrees = [](double angle) { return static_cast<std::uint64_t>(std::ceil(angle - 1e-9)); };
    add("degrees of phi_i without a SampleRotation, between the last and the first; interpolated there",
        degrees(phi_i_.uncovered_deg), 360);
    add("degrees of azimuth without a ScatterAzimuth, between the last and the first; interpolated there",
        degrees(azimuth_.uncovered_deg), 360);
    if (is_mirrored()) {
      add("degrees of azimuth before the first ScatterAzimuth or after the last, where their values are held",
          degrees(azimuth_.angles.front() + 180 - azimuth_.angles.back()), 180);
    }
    add("degrees of theta_i below the first AngleOfIncidence, where its values are held",
        degrees(table_.incidences.front()), 90);
    add("degrees of radial before the first ScatterRadial, where its values are held", degrees(radials_.front()), 180);
    if (radials_.size() > table_.radials.size()) {
      add("degrees of radial beyond the last ScatterRadial, taken as unmeasured", degrees(180 - table_.radials.back()),
          180);
    }
  }

  /// Integrals over what the file states.
  struct Ratios {
    double least = std::numeric_limits<double>::infinity();
    double most = 0;
    std::uint64_t count = 0;
    std::uint64_t different = 0;

    [[nodiscard]] std::string text() const { return fmt::format("{:.3g} to {:.3g} times", least, most); }
  };
  [[nodiscard]] Ratios ratios(ZemaxIntegrand integrand) const {
    const std::vector<double> integrals = zemax_integrals(table_, integrand);
    Ratios ratios;
    for (std::size_t k = 0; k < integrals.size(); ++k) {
      if (table_.tis[k] <= 0) continue;
      const double ratio = integrals[k] / table_.tis[k];
      ++ratios.count;
      if (!(std::abs(ratio - 1) <= kTisTolerance)) ++ratios.different;
      ratios.least = std::min(ratios.least, ratio);
      ratios.most = std::max(ratios.most, ratio);
    }
    return ratios;
  }

  // The table is f_r whatever TIS says: what it was made of is not told, and often not this integral.
  [[nodiscard]] std::string compare_tis() {
    const Ratios cosine = ratios(ZemaxIntegrand::kCosine);
    if (cosine.count == 0) return "no TIS stated";
    if (cosine.different > 0) {
      const Ratios plain = ratios(ZemaxIntegrand::kPlain);
      add(fmt::format(
              "blocks with an integral of f_r cos more than {:g} % from the TIS stated ({} it; that of f_r is {} "
              "it), which is not used",
              100 * kTisTolerance, cosine.text(), plain.text()),
          cosine.different, cosine.count);
    }
    return fmt::format("its blocks integrate to {} the TIS stated", cosine.text());
  }

  const ZemaxTable& table_;
  Zeros zeros_;
  Nodes phi_i_;
  Nodes azimuth_;
  std::vector<double> radials_;  ///< and those added beyond the last
  Grid grid_;
  std::uint64_t zeros_above_ = 0;
  std::uint64_t values_below_ = 0;
  std::vector<Finding> findings_;
};

}  // namespace

Result<std::unique_ptr<BrdfSource>> open_zemax(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(bytes));
  if (!viewed) return viewed.error();
  const auto view = (*viewed)->view().value();
  const Result<ZemaxTable> table = parse_zemax({reinterpret_cast<const char*>(view.data()), view.size()});
  if (!table) return table.error();
  if (table->scatter == ZemaxScatter::kBtdf) {
    return unsupported("ScatterType is BTDF: the file is about light that passes through, only BRDFs are read");
  }
  const Zeros zeros = value_of(kZerosNames, options.text("zemax-zeros").value_or("")).value_or(Zeros::kAuto);
  const Rotation rotation =
      value_of(kRotationNames, options.text("zemax-rotation").value_or("")).value_or(Rotation::kLight);
  return Reading(*table, zeros, rotation).source(policy_of(options, NonFinite::kUnmeasured).negatives);
}

std::span<const OptionSpec> zemax_options() { return kOptions; }

}  // namespace sbrdf::internal
