#include "codec/file/index.h"

#include <algorithm>
#include <cmath>

#include "formats/core/byte_reader.h"
#include "formats/core/counts.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kMaxPerOctave = 1U << 20U;

enum SymmetryBits : std::uint8_t {
  kIsotropicBit = 1,
  kMirrorXBit = 2,
  kMirrorYBit = 4,
  kThetaMaxBit = 16,
  kMaskBit = 32
};
constexpr unsigned kKnownBits = kIsotropicBit | kMirrorXBit | kMirrorYBit | kThetaMaxBit | kMaskBit;
enum class NodeForm : std::uint8_t { kRegular = 0, kHundredths = 1, kDoubles = 2 };

double regular_node(double step, std::size_t k) { return static_cast<double>(k) * step; }
double hundredths_node(std::uint16_t hundredths) { return static_cast<double>(hundredths) / 100.0; }

void put_nodes(ByteWriter& out, const std::vector<double>& nodes) {
  const double step = nodes.size() > 1 ? nodes[1] : 0;
  bool regular = true;
  bool hundredths = true;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    regular = regular && nodes[k] == regular_node(step, k);
    hundredths = hundredths && nodes[k] == hundredths_node(static_cast<std::uint16_t>(std::lround(nodes[k] * 100)));
  }
  const NodeForm form = regular ? NodeForm::kRegular : hundredths ? NodeForm::kHundredths : NodeForm::kDoubles;
  out.number(static_cast<std::uint8_t>(form));
  put_count(out, nodes.size());
  if (form == NodeForm::kRegular) {
    out.number(step);
    return;
  }
  for (const double node : nodes) {
    if (form == NodeForm::kHundredths) {
      out.number(static_cast<std::uint16_t>(std::lround(node * 100)));
    } else {
      out.number(node);
    }
  }
}

Result<std::vector<double>> take_nodes(ByteReader& in) {
  const std::uint8_t form = in.u8();
  const std::uint32_t count = take_count(in);
  if (form > static_cast<std::uint8_t>(NodeForm::kDoubles))
    return refuse_sliced("SB-2-4", "unknown form of a node list");
  if (count == 0 || count > 4096) return refuse_sliced("SB-2-4", std::to_string(count) + " nodes on an axis");
  std::vector<double> nodes;
  const double step = form == static_cast<std::uint8_t>(NodeForm::kRegular) ? in.f64() : 0;
  for (std::uint32_t k = 0; k < count && in.ok(); ++k) {
    switch (static_cast<NodeForm>(form)) {
      case NodeForm::kRegular:
        nodes.push_back(regular_node(step, k));
        break;
      case NodeForm::kHundredths:
        nodes.push_back(hundredths_node(in.u16()));
        break;
      case NodeForm::kDoubles:
        nodes.push_back(in.f64());
        break;
    }
  }
  return nodes;
}

// The elevation frame's follows from its nodes.
bool states_theta_max(const FrameSpec& frame) {
  return frame.id == FrameId::kHalfDifference && frame.theta_max_deg != kPaperThetaMaxDeg;
}

void put_frame(ByteWriter& out, const SlicedIndex& index) {
  const FrameSpec& frame = index.frame;
  const Symmetries& symmetries = frame.symmetries;
  out.number(static_cast<std::uint8_t>(frame.id));
  out.number(static_cast<std::uint8_t>((symmetries.isotropic ? kIsotropicBit : 0) |
                                       (symmetries.mirror_x ? kMirrorXBit : 0) |
                                       (symmetries.mirror_y ? kMirrorYBit : 0) |
                                       (states_theta_max(frame) ? kThetaMaxBit : 0) | (index.mask ? kMaskBit : 0)));
  for (const Axis& axis : frame.axes) put_nodes(out, axis.nodes_deg);
  if (states_theta_max(frame)) put_count(out, static_cast<std::uint64_t>(std::lround(frame.theta_max_deg * 100)));
  if (!index.mask) return;
  out.number(static_cast<std::uint8_t>(index.mask->frame));
  for (const std::uint32_t count : index.mask->counts) put_count(out, count);
  put_count(out, index.mask_size);
}

Status take_mask(ByteReader& in, SlicedIndex& index) {
  MaskGrid& grid = index.mask.emplace();
  grid.frame = static_cast<MaskFrame>(in.u8());
  for (std::uint32_t& count : grid.counts) count = take_count(in);
  index.mask_size = take_count(in);
  if (in.ok() && grid.frame != MaskFrame::kAngles && grid.frame != MaskFrame::kHalfDifference) {
    return unsupported("[SB-2-16] unknown frame of a mask");
  }
  if (in.ok() && (!grid.is_valid() || index.mask_size == 0 || index.mask_size > kMaxMaskSize)) {
    return refuse_sliced("SB-2-16", "the mask of unmeasured directions has no cells, or more than can be");
  }
  return ok_status();
}

Status take_frame(ByteReader& in, SlicedIndex& index) {
  FrameSpec& frame = index.frame;
  frame.id = static_cast<FrameId>(in.u8());
  const std::uint8_t bits = in.u8();
  const FrameGeometry* known = find_geometry(frame.id);
  if (in.ok() && known == nullptr) {
    return unsupported("[SB-2-2] unknown frame " + std::to_string(static_cast<int>(frame.id)));
  }
  if ((bits & ~kKnownBits) != 0 || ((bits & kThetaMaxBit) != 0 && frame.id != FrameId::kHalfDifference)) {
    return unsupported("[SB-2-3] unknown symmetry");
  }
  frame.symmetries = {(bits & kIsotropicBit) != 0, (bits & kMirrorXBit) != 0, (bits & kMirrorYBit) != 0};
  for (std::size_t axis = 0; axis < kAxisCount && in.ok(); ++axis) {
    Result<std::vector<double>> nodes = take_nodes(in);
    if (!nodes) return in.ok() ? Status(nodes.error()) : ok_status();
    frame.axes[axis] = {std::string(known->axis_names()[axis]), *std::move(nodes)};
  }
  if (frame.id == FrameId::kElevation && in.ok()) frame.theta_max_deg = frame.axes[kVertical].nodes_deg.back();
  if ((bits & kThetaMaxBit) != 0) frame.theta_max_deg = take_count(in) / 100.0;
  return (bits & kMaskBit) != 0 ? take_mask(in, index) : ok_status();
}

void put_values(ByteWriter& out, const SlicedIndex& index) {
  out.number(static_cast<std::uint8_t>(index.domain.kind));
  put_count(out, index.channels.size());
  for (const std::string& name : index.channels) {
    put_count(out, name.size());
    out.text(name);
  }
  for (const float v : index.domain.reference) out.number(v);
  for (const float v : index.domain.floor) out.number(v);
  for (const ValueRange& range : index.ranges) {
    out.number(range.least);
    out.number(range.most);
  }
}

Status take_values(ByteReader& in, SlicedIndex& index) {
  index.domain.kind = static_cast<DomainKind>(in.u8());
  const bool log = index.domain.kind == DomainKind::kLog;
  if (in.ok() && !log && index.domain.kind != DomainKind::kLinear) {
    return unsupported("[SB-2-5] unknown value domain");
  }
  const std::uint32_t channels = take_count(in);
  if (in.ok() && (channels == 0 || channels > kMaxChannels)) {
    return refuse_sliced("SB-2-6", std::to_string(channels) + " channels");
  }
  for (std::uint32_t c = 0; c < channels && in.ok(); ++c) index.channels.push_back(in.text(take_count(in)));
  const auto positive = [](float v) { return std::isfinite(v) && v > 0; };
  for (auto* list : {&index.domain.reference, &index.domain.floor}) {
    for (std::uint32_t c = 0; log && c < channels && in.ok(); ++c) {
      list->push_back(in.number<float>());
      if (in.ok() && !positive(list->back())) {
        return refuse_sliced("SB-2-7", "the log domain needs a positive reference and floor for every channel");
      }
    }
  }
  for (std::uint32_t c = 0; c < channels && in.ok(); ++c) {
    ValueRange range;
    range.least = in.number<float>();
    range.most = in.number<float>();
    if (!(range.least <= range.most) || !std::isfinite(range.least) || !std::isfinite(range.most)) {
      return refuse_sliced("SB-2-8", "the range of a channel's values is not a range");
    }
    index.ranges.push_back(range);
  }
  return ok_status();
}

void put_scale(ByteWriter& out, const Quantizer& scale) {
  out.number(static_cast<std::uint8_t>(scale.lossless() ? 0 : 1));
  if (scale.lossless()) return;
  out.number(scale.bound());
  put_count(out, scale.per_octave());
  out.number(scale.ratio());
  out.number(scale.lowest());
}

Status take_scale(ByteReader& in, Quantizer& scale) {
  const std::uint8_t kind = in.u8();
  if (kind > 1) return unsupported("[SB-2-10] unknown precision");
  if (kind == 0 || !in.ok()) return ok_status();
  const double bound = in.f64();
  const std::uint32_t per_octave = take_count(in);
  const double ratio = in.f64();
  const std::int32_t lowest = in.i32();
  if (!in.ok()) return ok_status();
  constexpr std::int32_t kFarthest = 1 << 29;
  if (!(bound > 0 && bound < 1) || per_octave == 0 || per_octave > kMaxPerOctave || !(ratio > 1 && ratio <= 2) ||
      lowest < -kFarthest || lowest > kFarthest) {
    return refuse_sliced("SB-2-11", "the scale of steps is out of its range");
  }
  scale = Quantizer(bound, per_octave, ratio, lowest);
  return ok_status();
}

template <std::size_t N>
void put_used(ByteWriter& out, const std::array<std::uint8_t, N>& values, std::uint8_t unused) {
  for (std::size_t from = 0; from < N; from += 8) {
    std::uint8_t bits = 0;
    for (std::size_t k = from; k < std::min(N, from + 8); ++k) {
      if (values[k] != unused) bits = static_cast<std::uint8_t>(bits | 1U << (k - from));
    }
    out.number(bits);
  }
  for (const std::uint8_t v : values) {
    if (v != unused) out.number(v);
  }
}

// False where a bit stands for nothing, or a used value is not below `end`.
template <std::size_t N>
bool take_used(ByteReader& in, std::array<std::uint8_t, N>& values, std::uint8_t unused, unsigned end) {
  std::array<bool, N> used{};
  bool valid = true;
  for (std::size_t from = 0; from < N; from += 8) {
    const std::uint8_t bits = in.u8();
    for (std::size_t k = from; k < from + 8; ++k) {
      const bool set = ((bits >> (k - from)) & 1U) != 0;
      if (k < N) {
        used[k] = set;
      } else {
        valid = valid && !set;
      }
    }
  }
  for (std::size_t k = 0; k < N; ++k) {
    values[k] = used[k] ? in.u8() : unused;
    valid = valid && (!used[k] || values[k] < end);
  }
  return valid;
}

void put_coding(ByteWriter& out, const SlicedIndex& index) {
  put_count(out, index.base_channel);
  out.number(static_cast<std::uint8_t>(index.activity_shift));
  out.number(static_cast<std::uint8_t>(index.distributions.token_count));
  put_used(out, index.distributions.residuals, Distributions::kUnused);
  put_used(out, index.distributions.flags, 0);
}

Status take_coding(ByteReader& in, SlicedIndex& index) {
  index.base_channel = take_count(in);
  index.activity_shift = in.u8();
  index.distributions.token_count = in.u8();
  constexpr unsigned kAnyByte = 256;
  const bool residuals_known =
      take_used(in, index.distributions.residuals, Distributions::kUnused, Distribution::kFamilySize);
  const bool flags_known = take_used(in, index.distributions.flags, 0, kAnyByte);
  if (!in.ok()) return ok_status();
  if (index.base_channel >= index.channels.size() || index.activity_shift > 31 ||
      index.distributions.token_count < Token::kDirect || index.distributions.token_count > Token::kCount ||
      !residuals_known || !flags_known) {
    return refuse_sliced("SB-2-12", "a parameter of the coding is out of its range");
  }
  return ok_status();
}

void put_layout(ByteWriter& out, const ChunkLayout& layout) {
  put_count(out, layout.piece_depths.size());
  for (const std::uint8_t depth : layout.piece_depths) out.number(depth);
  for (const auto& block : layout.block_nodes) {
    for (const std::uint32_t nodes : block) put_count(out, nodes);
  }
}

Status take_layout(ByteReader& in, ChunkLayout& layout) {
  const std::uint32_t pieces = take_count(in);
  if (in.ok() && (pieces == 0 || pieces > kMaxDepth)) {
    return refuse_sliced("SB-2-13", std::to_string(pieces) + " pieces of depths");
  }
  layout.piece_depths.clear();
  for (std::uint32_t k = 0; k < pieces && in.ok(); ++k) {
    const std::uint8_t depth = in.u8();
    const bool rises = k == 0 ? depth == 1 : depth > layout.piece_depths.back();
    if (in.ok() && (!rises || depth > kMaxDepth))
      return refuse_sliced("SB-2-13", "the pieces' depths do not rise from 1");
    layout.piece_depths.push_back(depth);
  }
  for (auto& block : layout.block_nodes) {
    for (std::uint32_t& nodes : block) nodes = take_count(in);
  }
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

ChunkOrder::ChunkOrder(const LatticeBlocks& blocks, std::size_t pieces, bool masked)
    : first_piece_(2 + blocks.crossings.size()) {
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    kind_offset_[kind] = per_piece_;
    per_piece_ += blocks.slices[kind].size();
  }
  count_ = first_piece_ + pieces * per_piece_ + (masked ? 1 : 0);
}

std::vector<std::byte> emit_index(const SlicedIndex& index) {
  ByteWriter out;
  put_frame(out, index);
  put_values(out, index);
  out.number(static_cast<std::uint8_t>(index.guided ? 1 : 0));
  if (index.guided) {
    out.number(index.guide_ratio);
    put_count(out, index.guide_count);
  }
  put_count(out, index.adaptive_count);
  put_scale(out, index.scale);
  put_coding(out, index);
  put_layout(out, index.layout);
  put_count(out, index.metadata_size);
  put_count(out, index.chunk_sizes.size());
  for (const std::uint32_t size : index.chunk_sizes) put_count(out, size);
  return std::move(out).take();
}

Result<SlicedIndex> parse_index(std::span<const std::byte> bytes, bool newer_minor) {
  ByteReader in(bytes);
  SlicedIndex index;
  if (Status status = take_frame(in, index); !status) return status.error();
  if (Status status = take_values(in, index); !status) return status.error();
  const std::uint8_t guided = in.u8();
  if (guided > 1) return unsupported("[SB-2-9] unknown kind of guide");
  index.guided = guided == 1;
  if (index.guided) {
    index.guide_ratio = in.f64();
    index.guide_count = take_count(in);
    if (in.ok() && (index.frame.id != FrameId::kHalfDifference || index.domain.kind != DomainKind::kLog ||
                    !(index.guide_ratio >= 1e-3 && index.guide_ratio <= 1e3) || index.guide_count > kMaxGuideCount)) {
      return refuse_sliced("SB-2-9",
                           "a guide needs the half/difference frame, the log domain and a ratio in [0.001, 1000]");
    }
  }
  index.adaptive_count = take_count(in);
  if (in.ok() && index.adaptive_count > kMaxAdaptiveCount) return refuse_sliced("SB-2-14", "more than 2^26 samples");
  if (Status status = take_scale(in, index.scale); !status) return status.error();
  if (Status status = take_coding(in, index); !status) return status.error();
  if (Status status = take_layout(in, index.layout); !status) return status.error();
  index.metadata_size = take_count(in);
  const std::uint32_t chunks = take_count(in);
  if (in.ok() && (index.metadata_size > kMaxMetadataSize || chunks > in.remaining())) {
    return refuse_sliced("SB-2-15", "more metadata or chunks than can be");
  }
  for (std::uint32_t k = 0; k < chunks && in.ok(); ++k) index.chunk_sizes.push_back(take_count(in));
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
