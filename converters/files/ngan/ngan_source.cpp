#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/ngan/ngan.h"
#include "converters/files/value_options.h"
#include "converters/tables/dense_source.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kBlock = std::uint64_t{1} << 18U;
constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

GridAxis theta_axis(std::uint32_t count, double offset) {
  const double step = 90.0 / count;
  return GridAxis(even_nodes(offset * step, step, count));
}

GridAxis phi_in_axis(std::uint32_t count, double offset) {
  if (count == 1) return {};
  const double step = 360.0 / count;
  return GridAxis(even_nodes(offset * step, step, count), Ends::kFullTurn);
}

// Both halves of half data. The image of a node at 0 is itself, so values at edges leave out 180 degrees.
GridAxis whole_axis(std::uint32_t count, bool half, bool at_edges) {
  const double step = (half ? 180.0 : 360.0) / count;
  std::vector<double> nodes = even_nodes(at_edges ? 0 : step / 2, step, std::size_t{count} * (half ? 2 : 1));
  if (half && at_edges) nodes.erase(nodes.begin() + count);
  return GridAxis(std::move(nodes), Ends::kFullTurn);
}

class OtherHalfValues final : public NodeValues {
 public:
  OtherHalfValues(std::shared_ptr<const NodeValues> first_half, const NganHeader& header, bool at_edges,
                  NganOtherHalf other_half)
      : first_half_(std::move(first_half)),
        stored_(header.counts[2]),
        whole_(at_edges ? 2 * stored_ - 1 : 2 * stored_),
        phi_in_count_(header.counts[3]),
        at_edges_(at_edges),
        other_half_(other_half) {}

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    if (nodes.empty()) return;
    const std::size_t channels = values.size() / nodes.size();
    std::array<GridNode, 64> images;
    for (std::size_t first = 0; first < nodes.size(); first += images.size()) {
      const std::size_t count = std::min(images.size(), nodes.size() - first);
      for (std::size_t n = 0; n < count; ++n) images[n] = image(nodes[first + n]);
      first_half_->gather(std::span(images).first(count), values.subspan(first * channels, count * channels));
    }
    if (other_half_ != NganOtherHalf::kUnmeasured) return;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (nodes[n][3] < stored_) continue;
      std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(n * channels), channels,
                  std::numeric_limits<double>::quiet_NaN());
    }
  }

 private:
  [[nodiscard]] GridNode image(GridNode node) const {
    if (node[3] < stored_) return node;
    node[3] = at_edges_ ? whole_ - node[3] : whole_ - 1 - node[3];
    if (other_half_ == NganOtherHalf::kTangent) {
      node[0] = at_edges_ ? (phi_in_count_ - node[0]) % phi_in_count_ : phi_in_count_ - 1 - node[0];
    }
    return node;
  }

  std::shared_ptr<const NodeValues> first_half_;
  std::uint32_t stored_;  ///< nodes along phi_diff
  std::uint32_t whole_;
  std::uint32_t phi_in_count_;
  bool at_edges_;
  NganOtherHalf other_half_;
};

StridedValues::Layout layout_of(const NganHeader& header, const NganConventions& conventions) {
  const auto& n = header.counts;
  const std::uint64_t unit = conventions.interleaved ? header.channels : 1;
  StridedValues::Layout layout;
  layout.type = ValueType::kFloat32;
  layout.strides = {unit, unit * n[3] * n[2] * n[1], unit * n[3] * n[2], unit * n[3]};
  layout.channel_stride = conventions.interleaved ? 1 : ngan_bin_count(header);
  layout.scales.assign(header.channels, conventions.scale);
  layout.negative_is_mark = true;
  return layout;
}

/// Numbers that are NaN, and the first that is no number of a table.
struct Strays {
  std::uint64_t nan = 0;
  std::uint64_t first = kNone;
};

Strays find_strays(const std::byte* numbers, std::uint64_t count, double scale) {
  std::vector<Strays> blocks((count + kBlock - 1) / kBlock);
  parallel_for(blocks.size(), [&](std::uint64_t k) {
    for (std::uint64_t n = k * kBlock; n < std::min(count, (k + 1) * kBlock); ++n) {
      float number;
      std::memcpy(&number, numbers + sizeof number * n, sizeof number);
      if (number * scale <= kTableLargest && !std::isinf(number)) continue;
      if (std::isnan(number)) ++blocks[k].nan;
      blocks[k].first = std::min(blocks[k].first, n);
    }
  });
  Strays all;
  for (const Strays& block : blocks) {
    all.nan += block.nan;
    all.first = std::min(all.first, block.first);
  }
  return all;
}

std::vector<std::string> channel_names(std::uint32_t count) {
  if (count == 3) return {"R", "G", "B"};
  std::vector<std::string> names;
  for (std::uint32_t c = 1; c <= count; ++c) names.push_back("C" + std::to_string(c));
  return names;
}

DenseDescription describe(const NganHeader& header, const NganConventions& conventions, const Strays& strays) {
  DenseDescription description;
  description.format = "ngan";
  description.description = fmt::format("anisotropic table, {} bins of theta_in, theta_out, phi_diff, phi_in{}",
                                        fmt::join(header.counts, " x "), header.half ? ", half data" : "");
  description.channels = channel_names(header.channels);
  description.unmeasured = "bins without a measurement (some channel negative)";
  const std::uint64_t bins = ngan_bin_count(header);
  if (strays.nan > 0) {
    description.findings.push_back(
        {"numbers that are NaN, their bins taken as unmeasured", strays.nan, bins * header.channels});
  }
  if (header.half) {
    const std::string what = conventions.other_half == NganOtherHalf::kTangent ? "mirror images about the tangent"
                             : conventions.other_half == NganOtherHalf::kPlane
                                 ? "mirror images about the plane of incidence"
                                 : "unmeasured";
    description.findings.push_back({"bins with phi_v - phi_i above 180 degrees, not stored: " + what, bins, 2 * bins});
  }
  return description;
}

}  // namespace

Grid ngan_grid(const NganHeader& header, bool at_edges) {
  const double offset = at_edges ? 0 : 0.5;
  const auto& n = header.counts;
  return {GridFrame::kDifference,
          {phi_in_axis(n[3], offset), theta_axis(n[0], offset), theta_axis(n[1], offset),
           whole_axis(n[2], header.half, at_edges)}};
}

Grid ngan_stored_grid(const NganHeader& header, bool at_edges) {
  Grid grid = ngan_grid(header, at_edges);
  if (!header.half) return grid;
  std::vector<double> nodes = grid.axes[3].nodes_deg();
  nodes.resize(header.counts[2]);
  grid.axes[3] = GridAxis(std::move(nodes), Ends::kMirrored);
  return grid;
}

std::shared_ptr<const NodeValues> with_other_half(std::shared_ptr<const NodeValues> first_half,
                                                  const NganHeader& header, bool at_edges, NganOtherHalf other_half) {
  return std::make_shared<OtherHalfValues>(std::move(first_half), header, at_edges, other_half);
}

Result<std::unique_ptr<BrdfSource>> open_ngan(std::shared_ptr<const ByteSource> file, const Options& options) {
  const NganConventions conventions = ngan_conventions(options);
  const ValuePolicy policy = policy_of(options, NonFinite::kUnmeasured);
  const Result<std::vector<std::byte>> head = read_start(*file, kNganHeaderSize);
  if (!head) return head.error();
  const Result<NganHeader> header = parse_ngan_header(*head, file->size());
  if (!header) return header.error();
  Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(file));
  if (!viewed) return viewed.error();
  const std::byte* numbers = (*viewed)->view()->data() + kNganHeaderSize;
  const Strays strays = find_strays(numbers, ngan_bin_count(*header) * header->channels, conventions.scale);
  // Asked here, as a table knows unmeasured nodes only, which are no errors.
  if (strays.first != kNone && policy.non_finite == NonFinite::kRefuse) {
    return invalid_file(fmt::format("a value is NaN, infinite or above {:g} as f_r", kTableLargest),
                        kNganHeaderSize + sizeof(float) * strays.first);
  }
  DenseDescription description = describe(*header, conventions, strays);
  if (!conventions.interleaved && !conventions.at_edges && conventions.scale == 1 &&
      conventions.other_half == NganOtherHalf::kTangent) {
    description.file = *viewed;
  }
  std::shared_ptr<const NodeValues> values =
      std::make_shared<StridedValues>(*viewed, numbers, layout_of(*header, conventions));
  if (header->half) values = with_other_half(std::move(values), *header, conventions.at_edges, conventions.other_half);
  return DenseSource::make({ngan_grid(*header, conventions.at_edges), header->channels, std::move(values)},
                           std::move(description));
}

}  // namespace sbrdf::internal
