#include "codec/file/index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/channel_names.h"

namespace sbrdf::internal {
namespace {

enum FrameBits : std::uint8_t { kFrameMask = 0x0F, kIsotropicBit = 0x10, kMirrorXBit = 0x20, kMirrorYBit = 0x40 };
enum PartBits : std::uint8_t {
  kGuideBit = 1,
  kSplitBit = 2,
  kMetadataBit = 4,
  kThetaMaxBit = 8,
  kMaskBit = 16,
  kKnownParts = 31
};

/// How the nodes of an axis are written: the first that gives them back to the last bit.
enum NodeForm : std::uint8_t {
  kFinest = 20,      ///< 0 to 20: differences in 2^-form degrees
  kEqualBit = 0x20,  ///< beside one of these: all differences are equal
  kTurn = 0x40,      ///< the turn, divided evenly
  kHundredths,       ///< differences in hundredths of a degree
  kDoubles,
};

static_assert(kMostNamedChannels == kMaxChannels);

std::uint32_t take_count(ByteReader& in) { return static_cast<std::uint32_t>(in.count(32)); }

double node_in(std::uint64_t units, std::uint8_t form) {
  const auto whole = static_cast<double>(units);
  return form == kHundredths ? whole / 100 : std::ldexp(whole, -static_cast<int>(form));
}

double turn_of(const FrameGeometry& frame, std::size_t axis) { return frame.node_period(axis); }
double even_node(double turn, std::size_t k, std::size_t count) {
  return static_cast<double>(k) * (turn / static_cast<double>(count));
}

/// Differences of nodes in units of a form; nothing where these do not give the nodes back.
std::optional<std::vector<std::uint64_t>> differences_in(const std::vector<double>& nodes, std::uint8_t form) {
  std::vector<std::uint64_t> differences;
  std::uint64_t before = 0;
  for (const double node : nodes) {
    const double units = form == kHundredths ? node * 100 : std::ldexp(node, form);
    if (!(units >= 0 && units < std::ldexp(1.0, 30))) return {};
    const auto whole = static_cast<std::uint64_t>(std::llround(units));
    if (node_in(whole, form) != node || whole < before) return {};
    differences.push_back(whole - std::exchange(before, whole));
  }
  differences.erase(differences.begin());
  return differences;
}

void put_nodes(ByteWriter& out, const std::vector<double>& nodes, double turn) {
  bool even = turn > 0;
  for (std::size_t k = 0; k < nodes.size() && even; ++k) even = nodes[k] == even_node(turn, k, nodes.size());
  out.count(nodes.size());
  if (even) return out.number(static_cast<std::uint8_t>(kTurn));
  for (std::uint8_t form = 0; form <= kFinest + 1; ++form) {
    const std::uint8_t units = form > kFinest ? static_cast<std::uint8_t>(kHundredths) : form;
    const auto differences = differences_in(nodes, units);
    if (!differences || nodes.front() != 0) continue;
    const bool equal = units <= kFinest && differences->size() > 1 &&
                       std::all_of(differences->begin(), differences->end(),
                                   [&](std::uint64_t d) { return d == differences->front(); });
    out.number(static_cast<std::uint8_t>(units | (equal ? kEqualBit : 0)));
    for (std::size_t k = 0; k < (equal ? 1 : differences->size()); ++k) out.count((*differences)[k]);
    return;
  }
  out.number(static_cast<std::uint8_t>(kDoubles));
  for (const double node : nodes) out.number(node);
}

Result<std::vector<double>> take_nodes(ByteReader& in, double turn) {
  const std::uint32_t count = take_count(in);
  const std::uint8_t form = in.u8();
  if (!in.ok()) return std::vector<double>();
  if (count == 0 || count > 4096) return refuse_sliced("SB-2-4", std::to_string(count) + " nodes on an axis");
  const bool equal = (form & kEqualBit) != 0 && form < kTurn;
  const std::uint8_t units = equal ? form - kEqualBit : form;
  if ((units > kFinest && units < kTurn) || units > kDoubles || (units == kTurn && !(turn > 0))) {
    return refuse_sliced("SB-2-4", "unknown form of a node list");
  }
  std::vector<double> nodes;
  std::uint64_t sum = 0;
  std::uint64_t difference = 0;
  for (std::uint32_t k = 0; k < count && in.ok(); ++k) {
    if (units == kTurn) {
      nodes.push_back(even_node(turn, k, count));
    } else if (units == kDoubles) {
      nodes.push_back(in.f64());
    } else {
      if (k == 1 || (k > 1 && !equal)) difference = take_count(in);
      sum += difference;
      nodes.push_back(node_in(sum, units));
    }
  }
  return nodes;
}

// Axis 0 of isotropic materials is one node, and the elevation frame has axis 2 twice.
bool is_stored(const FrameSpec& frame, std::size_t axis) {
  if (axis == kAxial) return !frame.symmetries.isotropic;
  return axis != kVertical || frame.id != FrameId::kElevation;
}

void put_frame(ByteWriter& out, const FrameSpec& frame) {
  const Symmetries& symmetries = frame.symmetries;
  out.number(
      static_cast<std::uint8_t>(static_cast<std::uint8_t>(frame.id) | (symmetries.isotropic ? kIsotropicBit : 0) |
                                (symmetries.mirror_x ? kMirrorXBit : 0) | (symmetries.mirror_y ? kMirrorYBit : 0)));
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (is_stored(frame, axis)) put_nodes(out, frame.axes[axis].nodes_deg, turn_of(geometry(frame.id), axis));
  }
}

Status take_frame(ByteReader& in, FrameSpec& frame) {
  const std::uint8_t bits = in.u8();
  frame.id = static_cast<FrameId>(bits & kFrameMask);
  const FrameGeometry* known = find_geometry(frame.id);
  if (!in.ok()) return ok_status();
  if ((bits & kFrameMask) == kDenseFrame) {
    return unsupported("[SB-2-2] a dense file: it has no slices, and no parts of them");
  }
  if (known == nullptr) return unsupported("[SB-2-2] unknown frame " + std::to_string(bits & kFrameMask));
  if (bits > (kFrameMask | kIsotropicBit | kMirrorXBit | kMirrorYBit)) return unsupported("[SB-2-3] unknown symmetry");
  frame.symmetries = {(bits & kIsotropicBit) != 0, (bits & kMirrorXBit) != 0, (bits & kMirrorYBit) != 0};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    frame.axes[axis].name = known->axis_names()[axis];
    std::vector<double>& nodes = frame.axes[axis].nodes_deg;
    nodes = axis == kAxial ? std::vector<double>{0} : frame.axes[axis - 1].nodes_deg;
    if (!is_stored(frame, axis)) continue;
    Result<std::vector<double>> taken = take_nodes(in, turn_of(*known, axis));
    if (!taken) return taken.error();
    nodes = *std::move(taken);
  }
  // The elevation frame's follows from its nodes.
  if (frame.id == FrameId::kElevation && in.ok()) frame.theta_max_deg = frame.axes[kVertical].nodes_deg.back();
  return ok_status();
}

bool states_theta_max(const FrameSpec& frame) {
  return frame.id == FrameId::kHalfDifference && frame.theta_max_deg != kPaperThetaMaxDeg;
}

void put_parts(ByteWriter& out, const SlicedIndex& index) {
  out.number(static_cast<std::uint8_t>((index.guided ? kGuideBit : 0) | (index.layout.whole ? 0 : kSplitBit) |
                                       (index.metadata_size > 0 ? kMetadataBit : 0) |
                                       (states_theta_max(index.frame) ? kThetaMaxBit : 0) |
                                       (index.mask ? kMaskBit : 0)));
  if (states_theta_max(index.frame)) {
    out.count(static_cast<std::uint64_t>(std::lround(index.frame.theta_max_deg * 100)));
  }
  if (!index.mask) return;
  out.number(static_cast<std::uint8_t>(index.mask->frame));
  for (const std::uint32_t count : index.mask->counts) out.count(count);
  out.count(index.mask_size);
}

Status take_mask(ByteReader& in, SlicedIndex& index) {
  MaskGrid& grid = index.mask.emplace();
  grid.frame = static_cast<MaskFrame>(in.u8());
  for (std::uint32_t& count : grid.counts) count = take_count(in);
  index.mask_size = take_count(in);
  if (in.ok() && grid.frame != MaskFrame::kAngles && grid.frame != MaskFrame::kHalfDifference) {
    return unsupported("[SB-2-17] unknown frame of a mask");
  }
  if (in.ok() && (!grid.is_valid() || index.mask_size == 0 || index.mask_size > kMaxMaskSize)) {
    return refuse_sliced("SB-2-17", "the mask of unmeasured directions has no cells, or more than can be");
  }
  return ok_status();
}

/// Sets `parts` to the bits, too.
Status take_parts(ByteReader& in, SlicedIndex& index, std::uint8_t& parts) {
  parts = in.u8();
  if (parts > kKnownParts || ((parts & kThetaMaxBit) != 0 && index.frame.id != FrameId::kHalfDifference)) {
    return unsupported("[SB-2-16] unknown parts");
  }
  index.guided = (parts & kGuideBit) != 0;
  index.layout.whole = (parts & kSplitBit) == 0;
  if ((parts & kThetaMaxBit) != 0) index.frame.theta_max_deg = take_count(in) / 100.0;
  return (parts & kMaskBit) != 0 ? take_mask(in, index) : ok_status();
}

void put_scale(ByteWriter& out, const Quantizer& scale) {
  out.count(scale.lossless() ? 0 : millionths_of(scale.bound()));
  if (!scale.lossless()) out.signed_count(scale.lowest());
}

Status take_scale(ByteReader& in, Quantizer& scale) {
  const std::uint32_t bound = take_count(in);
  if (bound == 0 || !in.ok()) return ok_status();
  const std::int64_t lowest = in.signed_count(33);
  if (!in.ok()) return ok_status();
  constexpr std::int64_t kFarthest = 1 << 29;
  if (bound > millionths_of(kCoarsestBound) || lowest < -kFarthest || lowest > kFarthest) {
    return refuse_sliced("SB-2-11", "the scale of steps is out of its range");
  }
  scale = Quantizer(bound_of(bound), static_cast<std::int32_t>(lowest));
  return ok_status();
}

constexpr std::uint8_t kGreyBit = 0x10;  // beside the domain

void put_values(ByteWriter& out, const SlicedIndex& index) {
  const bool grey = index.grey_shares.active();
  out.number(static_cast<std::uint8_t>(static_cast<std::uint8_t>(index.domain) | (grey ? kGreyBit : 0)));
  put_channel_names(out, index.channels);
  for (const float share : index.grey_shares.shares()) {
    if (grey) out.count(static_cast<std::uint64_t>(std::lround(share * GreyShares::kSteps)));
  }
  for (const StepRange& range : index.ranges) {
    out.signed_count(range.least);
    out.count(static_cast<std::uint64_t>(std::int64_t{range.most} - range.least));
  }
  if (index.domain != DomainKind::kLog) return;
  for (const std::int32_t step : index.reference_steps) out.count(static_cast<std::uint64_t>(step));
  out.number(static_cast<std::uint8_t>(index.floor_halvings));
}

/// Nothing where no value has that step.
std::optional<std::int32_t> step_of_value(const Quantizer& scale, std::int64_t step) {
  if (std::abs(step) > std::numeric_limits<std::int32_t>::max()) return {};
  const auto narrow = static_cast<std::int32_t>(step);
  return std::isfinite(scale.value(narrow)) ? std::optional(narrow) : std::nullopt;
}

Status take_grey(ByteReader& in, bool stated, SlicedIndex& index) {
  if (!stated) return ok_status();
  std::vector<float> shares;
  for (std::size_t c = 0; c < index.channels.size() && in.ok(); ++c) {
    const std::uint32_t steps = take_count(in);
    if (steps > GreyShares::kMostSteps) return refuse_sliced("SB-2-18", "the share of grey of a channel is too large");
    shares.push_back(static_cast<float>(steps) / GreyShares::kSteps);
  }
  index.grey_shares = GreyShares(std::move(shares));
  if (in.ok() && !index.grey_shares.active()) return refuse_sliced("SB-2-18", "all shares of grey are 0");
  return ok_status();
}

Status take_values(ByteReader& in, SlicedIndex& index) {
  const std::uint8_t bits = in.u8();
  index.domain = static_cast<DomainKind>(bits & ~kGreyBit);
  if (in.ok() && index.domain != DomainKind::kLog && index.domain != DomainKind::kLinear) {
    return unsupported("[SB-2-5] unknown value domain");
  }
  if (Status status = take_channel_names(in, index.channels); !status) return status;
  if (Status status = take_grey(in, (bits & kGreyBit) != 0, index); !status) return status;
  for (std::size_t c = 0; c < index.channels.size() && in.ok(); ++c) {
    const std::int64_t least = in.signed_count(33);
    const auto from = step_of_value(index.scale, least);
    const auto to = step_of_value(index.scale, least + std::int64_t{take_count(in)});
    if (!from || !to) return refuse_sliced("SB-2-8", "the range of a channel ends where no value is");
    index.ranges.push_back({*from, *to});
  }
  if (index.domain != DomainKind::kLog) return ok_status();
  for (std::size_t c = 0; c < index.channels.size() && in.ok(); ++c) {
    const auto step = step_of_value(index.scale, take_count(in));
    if (in.ok() && !(step && index.scale.value(*step) > 0)) {
      return refuse_sliced("SB-2-7", "the log domain needs a positive reference for every channel");
    }
    index.reference_steps.push_back(step.value_or(0));
  }
  index.floor_halvings = in.u8();
  return ok_status();
}

Status take_guide(ByteReader& in, SlicedIndex& index) {
  if (!index.guided) return ok_status();
  if (!index.frame.symmetries.isotropic) index.guide_ratio = in.f64();
  index.guide_count = take_count(in);
  if (in.ok() && (index.frame.id != FrameId::kHalfDifference || index.domain != DomainKind::kLog ||
                  !(index.guide_ratio >= 1e-3 && index.guide_ratio <= 1e3) || index.guide_count > kMaxGuideCount)) {
    return refuse_sliced("SB-2-9",
                         "a guide needs the half/difference frame, the log domain and a ratio in [0.001, 1000]");
  }
  return ok_status();
}

/// Whether some context of a group can occur: the first two are of crossings, every other one of the channels beside
/// the base channel.
bool is_used(const SlicedIndex& index, std::size_t group) {
  return (group < 2 || index.adaptive_count > 0) && (group % 2 == 0 || index.channels.size() > 1);
}

constexpr std::uint8_t kLongTailsBit = 0x40;
constexpr std::uint8_t kStatedBit = 0x80;

void put_group(ByteWriter& out, const GroupDistributions& group) {
  out.number(static_cast<std::uint8_t>(group.width | (group.long_tails ? kLongTailsBit : 0) |
                                       (group.stated ? kStatedBit : 0)));
  for (std::size_t k = 0; group.stated && k < group.off.size(); k += 2) {
    const int low = group.off[k] + GroupDistributions::kFarthest;
    const int high = group.off[k + 1] + GroupDistributions::kFarthest;
    out.number(static_cast<std::uint8_t>(low | high << 4U));
  }
}

void take_group(ByteReader& in, GroupDistributions& group) {
  const std::uint8_t bits = in.u8();
  group.width = bits & GroupDistributions::kMostWidth;
  group.long_tails = (bits & kLongTailsBit) != 0;
  group.stated = (bits & kStatedBit) != 0;
  for (std::size_t k = 0; group.stated && k < group.off.size(); k += 2) {
    const std::uint8_t both = in.u8();
    group.off[k] = static_cast<std::int8_t>((both & 15U) - GroupDistributions::kFarthest);
    group.off[k + 1] = static_cast<std::int8_t>((both >> 4U) - GroupDistributions::kFarthest);
  }
}

constexpr std::uint32_t kEachFlagBit = 8;  // beside the number of depths

void put_flags(ByteWriter& out, const Distributions& distributions) {
  out.number(static_cast<std::uint8_t>(distributions.flag_depths | (distributions.flags_by_depth ? 0 : kEachFlagBit)));
  const std::size_t step = distributions.flags_by_depth ? CodingContext::kFlagsPerDepth : 1;
  for (std::size_t k = 0; k < distributions.flag_depths * CodingContext::kFlagsPerDepth; k += step) {
    out.number(distributions.flags[k]);
  }
}

bool take_flags(ByteReader& in, Distributions& distributions) {
  const std::uint8_t bits = in.u8();
  distributions.flags_by_depth = (bits & kEachFlagBit) == 0;
  distributions.flag_depths = bits & ~kEachFlagBit;
  if (distributions.flag_depths > CodingContext::kFlagDepths) return false;
  for (std::size_t k = 0; k < distributions.flag_depths * CodingContext::kFlagsPerDepth; ++k) {
    const bool first = k % CodingContext::kFlagsPerDepth == 0;
    distributions.flags[k] = distributions.flags_by_depth && !first ? distributions.flags[k - 1] : in.u8();
  }
  return true;
}

void put_coding(ByteWriter& out, const SlicedIndex& index) {
  const Distributions& distributions = index.distributions;
  out.count(index.base_channel);
  out.number(static_cast<std::uint8_t>(index.activity_shift));
  out.number(static_cast<std::uint8_t>(distributions.token_count));
  for (std::size_t group = 0; group < distributions.groups.size(); ++group) {
    if (is_used(index, group)) put_group(out, distributions.groups[group]);
  }
  for (const std::uint8_t number : distributions.guide) {
    if (index.guided) out.number(number);
  }
  if (index.guided || index.adaptive_count > 0) put_flags(out, distributions);
}

Status take_coding(ByteReader& in, SlicedIndex& index) {
  Distributions& distributions = index.distributions;
  index.base_channel = take_count(in);
  index.activity_shift = in.u8();
  distributions.token_count = in.u8();
  for (std::size_t group = 0; group < distributions.groups.size(); ++group) {
    if (is_used(index, group)) take_group(in, distributions.groups[group]);
  }
  bool known = true;
  for (std::uint8_t& number : distributions.guide) {
    if (index.guided) number = in.u8();
    known = known && number < Distribution::kFamilySize;
  }
  if (index.guided || index.adaptive_count > 0) known = take_flags(in, distributions) && known;
  if (!in.ok()) return ok_status();
  if (index.base_channel >= index.channels.size() || index.activity_shift > 31 ||
      distributions.token_count < Token::kDirect || distributions.token_count > Token::kCount || !known) {
    return refuse_sliced("SB-2-12", "a parameter of the coding is out of its range");
  }
  return ok_status();
}

Status take_metadata(ByteReader& in, SlicedIndex& index) {
  index.metadata_size = take_count(in);
  const std::uint32_t packed = take_count(in);
  if (in.ok() && index.metadata_size > kMaxMetadataSize) return refuse_sliced("SB-2-15", "more metadata than can be");
  const std::span<const std::byte> bytes = in.bytes(packed);
  index.metadata.assign(bytes.begin(), bytes.end());
  return ok_status();
}

void put_layout(ByteWriter& out, const ChunkLayout& layout) {
  out.count(layout.piece_depths.size());
  for (const std::uint8_t depth : layout.piece_depths) out.number(depth);
  for (const auto& block : layout.block_nodes) {
    for (const std::uint32_t nodes : block) out.count(nodes);
  }
}

Status take_layout(ByteReader& in, ChunkLayout& layout) {
  const std::uint32_t pieces = take_count(in);
  if (in.ok() && (pieces == 0 || pieces > kMaxDepth)) {
    return refuse_sliced("SB-2-13", std::to_string(pieces) + " pieces");
  }
  layout.piece_depths.clear();
  for (std::uint32_t k = 0; k < pieces && in.ok(); ++k) layout.piece_depths.push_back(in.u8());
  const auto rises = [&] {
    return std::adjacent_find(layout.piece_depths.begin(), layout.piece_depths.end(), std::greater_equal<>()) ==
           layout.piece_depths.end();
  };
  if (in.ok() && (layout.piece_depths.front() != 1 || layout.piece_depths.back() > kMaxDepth || !rises())) {
    return refuse_sliced("SB-2-13", "the depths of pieces begin with 1, rise, and are at most 16");
  }
  for (auto& block : layout.block_nodes) {
    for (std::uint32_t& nodes : block) nodes = take_count(in);
  }
  return ok_status();
}

Status take_chunks(ByteReader& in, SlicedIndex& index) {
  auto chunks = static_cast<std::uint32_t>(index.chunk_count(1));
  if (!index.layout.whole) {
    if (Status status = take_layout(in, index.layout); !status) return status;
    chunks = take_count(in);
    if (in.ok() && chunks > in.remaining()) return refuse_sliced("SB-2-15", "more chunks than can be");
  }
  for (std::uint32_t k = 0; k < chunks && in.ok(); ++k) index.chunk_sizes.push_back(take_count(in));
  return ok_status();
}

}  // namespace

Error refuse_sliced(const char* clause, const std::string& what) {
  return invalid_file(std::string("[") + clause + "] " + what);
}

CodingParameters SlicedIndex::coding() const {
  CodingParameters coding;
  coding.channel_count = static_cast<std::uint32_t>(channels.size());
  coding.base_channel = base_channel;
  coding.activity_shift = activity_shift;
  const double twelfth = scale.steps_per_octave() / 12;
  coding.slope_prior = twelfth * twelfth;
  return coding;
}

ValueDomain SlicedIndex::value_domain() const {
  ValueDomain values = {domain, {}, floor_halvings};
  for (const std::int32_t step : reference_steps) values.reference.push_back(scale.value(step));
  return values;
}

std::vector<ValueRange> SlicedIndex::value_ranges() const {
  std::vector<ValueRange> values;
  for (const StepRange& range : ranges) values.push_back({scale.value(range.least), scale.value(range.most)});
  return values;
}

ChunkOrder::ChunkOrder(const LatticeBlocks& blocks, std::size_t pieces) : first_piece_(1 + blocks.crossings.size()) {
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    kind_offset_[kind] = per_piece_;
    per_piece_ += blocks.slices[kind].size();
  }
  count_ = first_piece_ + pieces * per_piece_;
}

std::vector<std::byte> emit_index(const SlicedIndex& index) {
  ByteWriter out;
  put_frame(out, index.frame);
  put_parts(out, index);
  put_scale(out, index.scale);
  put_values(out, index);
  if (index.guided) {
    if (!index.frame.symmetries.isotropic) out.number(index.guide_ratio);
    out.count(index.guide_count);
  }
  out.count(index.adaptive_count);
  put_coding(out, index);
  if (index.metadata_size > 0) {
    out.count(index.metadata_size);
    out.count(index.metadata.size());
    out.bytes(index.metadata);
  }
  if (!index.layout.whole) {
    put_layout(out, index.layout);
    out.count(index.chunk_sizes.size());
  }
  for (const std::uint32_t size : index.chunk_sizes) out.count(size);
  return std::move(out).take();
}

Result<SlicedIndex> parse_index(std::span<const std::byte> bytes, bool newer_minor) {
  ByteReader in(bytes);
  SlicedIndex index;
  if (Status status = take_frame(in, index.frame); !status) return status.error();
  std::uint8_t parts = 0;
  if (Status status = take_parts(in, index, parts); !status) return status.error();
  if (Status status = take_scale(in, index.scale); !status) return status.error();
  if (Status status = take_values(in, index); !status) return status.error();
  if (Status status = take_guide(in, index); !status) return status.error();
  index.adaptive_count = take_count(in);
  if (in.ok() && index.adaptive_count > kMaxAdaptiveCount) return refuse_sliced("SB-2-14", "more than 2^26 samples");
  if (Status status = take_coding(in, index); !status) return status.error();
  if ((parts & kMetadataBit) != 0) {
    if (Status status = take_metadata(in, index); !status) return status.error();
  }
  if (Status status = take_chunks(in, index); !status) return status.error();
  if (!in.ok()) return refuse_sliced("SB-2-1", "the index ends early");
  if (in.remaining() != 0 && !newer_minor) return refuse_sliced("SB-2-1", "the index goes on behind its end");
  if (Status status = check_frame(index.frame); !status) {
    Error error = status.error();
    error.message = "[SB-2-4] " + error.message;
    return error;
  }
  return index;
}

}  // namespace sbrdf::internal
