#include "converters/files/scattered/scattered_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/csv/csv_file.h"
#include "converters/files/dense/dense_file.h"
#include "converters/files/foreign.h"
#include "converters/files/scattered/chosen_grid.h"
#include "converters/files/scattered/local_fit.h"
#include "converters/files/scattered/sample_columns.h"
#include "formats/core/parallel.h"
#include "formats/table/number_table.h"

namespace sbrdf::internal {
namespace {

/// Without --scattered-radius: so many times the spacing of the samples, within bounds [degrees].
constexpr double kSpacings = 3, kLeastRadius = 5, kLargestRadius = 30;
constexpr std::uint64_t kBlock = 256;

constexpr std::array kOptions = {
    OptionSpec{.name = "scattered-angles",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kSampleAnglesChoices,
               .fallback = "what the names of the columns say, else degrees",
               .meaning = "What the angles of scattered samples are given in"},
    OptionSpec{.name = "scattered-quantity",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kSampleQuantityChoices,
               .fallback = "f_r",
               .meaning = "What scattered samples are: f_r, or f_r times the cosine of theta_v"},
    OptionSpec{.name = "scattered-columns",
               .use = OptionUse::kRead,
               .unit = "LIST",
               .fallback = "by their names in the file, else theta_i,phi_i,theta_v,phi_v and channels",
               .check = check_sample_columns,
               .meaning =
                   "What the columns of scattered samples are, in order: theta_i, phi_i (0 without it), theta_v, "
                   "phi_v, skip, or the name of a channel"},
    OptionSpec{.name = "scattered-radius",
               .kind = OptionKind::kNumber,
               .use = OptionUse::kRead,
               .unit = "DEG",
               .range = {0.01, 180},
               .fallback = "3 times the spacing of the samples, from 5 to 30",
               .meaning = "Nodes of the table without a scattered sample so near are unmeasured"},
    grid_option()};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct NodeCounts {
  std::uint64_t above = 0, measured = 0;
};

/// The values of all nodes; NaN where there is no sample near, or below the horizon.
std::vector<float> fit_nodes(const LocalFit& fit, const Grid& grid, std::size_t channels, double radius_deg,
                             NodeCounts& counts) {
  const std::uint64_t total = grid.node_count();
  std::vector<float> values(total * channels, std::numeric_limits<float>::quiet_NaN());
  std::vector<NodeCounts> parts((total + kBlock - 1) / kBlock);
  parallel_for(parts.size(), [&](std::uint64_t block) {
    std::vector<double> colour(channels);
    for (std::uint64_t k = block * kBlock; k < std::min(total, (block + 1) * kBlock); ++k) {
      const DirectionPair pair = grid.pair_of(grid.node(k));
      if (!above_horizon(pair)) continue;
      ++parts[block].above;
      if (fit.distance_deg(pair) > radius_deg) continue;
      ++parts[block].measured;
      fit.value_at(pair, colour);
      std::copy(colour.begin(), colour.end(), values.begin() + static_cast<std::ptrdiff_t>(k * channels));
    }
  });
  for (const NodeCounts& part : parts) {
    counts.above += part.above;
    counts.measured += part.measured;
  }
  return values;
}

/// How the table differs from the samples.
std::string residual_text(const Samples& samples, const DenseTable& table) {
  const std::size_t channels = samples.channels.size();
  std::vector<float> values(samples.values.size());
  parallel_blocks(samples.pairs.size(), kBlock, [&](std::size_t first, std::size_t count) {
    interpolate_table(table, std::span(samples.pairs).subspan(first, count),
                      std::span(values).subspan(first * channels, count * channels));
  });
  double difference = 0;
  double reference = 0;
  double largest = -1;
  std::size_t worst = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double own = std::abs(samples.values[k] - static_cast<double>(values[k]));
    difference += own;
    reference += std::abs(samples.values[k]);
    if (own <= largest) continue;
    largest = own;
    worst = k;
  }
  const DirectionPair& pair = samples.pairs[worst / channels];
  return fmt::format(
      "relative L1 {:.3g} %, largest difference {:.4g} 1/sr, {} of line {} (theta_i {:g}, phi_i {:g}, theta_v {:g}, "
      "phi_v "
      "{:g} degrees)",
      reference > 0 ? 100 * difference / reference : 0.0, largest, field_text(samples.channels[worst % channels]),
      samples.lines[worst / channels], degrees_from_radians(pair.i.theta), degrees_from_radians(pair.i.phi),
      degrees_from_radians(pair.v.theta), degrees_from_radians(pair.v.phi));
}

class Findings {
 public:
  void add(std::string what, std::uint64_t count, std::uint64_t total) {
    if (count > 0) list_.push_back({std::move(what), count, total});
  }
  [[nodiscard]] std::vector<Finding> take() && { return std::move(list_); }

 private:
  std::vector<Finding> list_;
};

void add_samples(Findings& findings, const Samples& samples, const LocalFit& fit, bool cosine) {
  findings.add(fmt::format("samples, angles in {}, {}", name_of(kSampleAnglesNames, samples.angles),
                           cosine ? "f_r cos(theta_v) divided by the cosine" : "f_r"),
               samples.pairs.size(), samples.rows);
  findings.add("samples below the horizon, left out", samples.below_horizon, samples.rows);
  findings.add("samples at theta_v = 90 degrees, where f_r cos(theta_v) does not tell f_r, left out",
               samples.at_horizon, samples.rows);
  findings.add("samples with a theta below 0, taken as one at phi + 180 degrees", samples.negative_theta, samples.rows);
  findings.add(
      fmt::format("samples that repeat the directions of others{}, their mean taken, from which they differ by a "
                  "relative L1 of {:.3g} %",
                  fit.is_isotropic() ? " in an isotropic material" : "", fit.repeated_percent()),
      fit.repeated(), samples.pairs.size());
}

void add_held_back(Findings& findings, const LocalFit& fit) {
  const LocalFit::HeldBack& held = fit.held_back();
  if (fit.point_count() < LocalFit::kFewest) {
    findings.add(
        fmt::format("samples at different directions, fewer than the {} that a fit goes by: the table is little "
                    "more than a guess",
                    LocalFit::kFewest),
        fit.point_count(), fit.point_count());
  }
  findings.add(
      fmt::format("samples predicted from others{}: relative L1 {:.3g} %; by local regression {}over {} samples, "
                  "distances along the difference direction times {:g}",
                  held.by_light ? " with another light direction" : "", held.rel_l1_percent,
                  fit.settings().curved ? "of the second degree " : "", fit.settings().neighbours,
                  fit.settings().difference_scale),
      held.samples, fit.point_count());
}

}  // namespace

std::span<const OptionSpec> scattered_options() { return kOptions; }

Match recognise_scattered(std::span<const std::byte> head, std::uint64_t size) {
  if (!is_text(head) || recognises_csv(head)) return Match::kNone;
  switch (look_at_number_table(text_of(head), head.size() == size)) {
    case NumberTableLook::kTable:
      return Match::kWhole;
    case NumberTableLook::kComments:
      return Match::kDamaged;
    case NumberTableLook::kNone:
      break;
  }
  return Match::kNone;
}

Result<std::unique_ptr<BrdfSource>> open_scattered(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(bytes));
  if (!viewed) return viewed.error();
  const Result<NumberTable> rows = parse_number_table(text_of(*(*viewed)->view()));
  if (!rows) return rows.error();
  const Result<Samples> samples = samples_of(*rows, options);
  if (!samples) return samples.error();
  ChosenGrid chosen;
  if (options.has("grid")) {
    chosen = {grid_of_option(options, "").value(), "as --grid says"};
  } else {
    chosen = choose_grid(*samples);
  }
  const double needed =
      static_cast<double>(chosen.grid.node_count()) * static_cast<double>(samples->channels.size() * sizeof(float));
  if (Status allowed = check_memory(needed, options.memory.of((*viewed)->stored_size())); !allowed)
    return allowed.error();
  const LocalFit fit(*samples, chosen.grid.is_isotropic());
  const double spacing = fit.held_back().spacing_deg;
  const double radius =
      options.number("scattered-radius").value_or(std::clamp(kSpacings * spacing, kLeastRadius, kLargestRadius));
  NodeCounts counts;
  std::vector<float> values = fit_nodes(fit, chosen.grid, samples->channels.size(), radius, counts);
  DenseTable table = table_in_memory(chosen.grid, samples->channels.size(), std::move(values));
  Findings findings;
  add_samples(findings, *samples, fit, options.text("scattered-quantity") == "f_r-cos");
  add_held_back(findings, fit);
  findings.add(fmt::format("nodes of {} in {} frame ({}) with a sample within {:.3g} degrees", chosen.grid.size_text(),
                           name_of(kGridFrameNames, chosen.grid.frame), chosen.reason, radius),
               counts.measured, counts.above);
  findings.add("samples compared with the table: " + residual_text(*samples, table), samples->pairs.size(),
               samples->pairs.size());
  TableHead head;
  head.channels = samples->channels;
  return open_dense(std::move(table), "scattered", std::move(head), nullptr, options, std::move(findings).take());
}

}  // namespace sbrdf::internal
