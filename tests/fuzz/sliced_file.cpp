#include "tests/fuzz/sliced_file.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal::fuzzing {
namespace {

// Of the file as it lies there: an index, and what follows.
struct Halves {
  std::uint8_t minor = 0;
  Bytes index;
  Bytes chunks;
};

std::optional<Halves> halves_of(const Bytes& file) {
  ByteReader in(file);
  in.bytes(kContainerMagic.size() + 1);
  Halves halves;
  halves.minor = in.u8();
  const std::uint64_t stated = in.count(28);
  if (!in.ok() || in.remaining() < kChecksumSize) return {};
  const auto index = in.bytes(std::min<std::uint64_t>(stated, in.remaining() - kChecksumSize));
  in.bytes(kChecksumSize);
  const auto chunks = in.bytes(in.remaining());
  halves.index.assign(index.begin(), index.end());
  halves.chunks.assign(chunks.begin(), chunks.end());
  return halves;
}

// Checksums of a file whose bytes changed anywhere.
void mend(Bytes& file) {
  std::optional<Halves> halves = halves_of(file);
  if (!halves) return;
  if (const Result<SlicedIndex> index = parse_index(halves->index, true)) {
    std::size_t offset = 0;
    for (const std::uint32_t size : index->chunk_sizes) {
      if (size > halves->chunks.size() - offset) break;
      if (size > kChecksumSize) {
        const std::size_t payload = size - kChecksumSize;
        const std::uint32_t sum = checksum(std::span(halves->chunks).subspan(offset, payload));
        std::memcpy(halves->chunks.data() + offset + payload, &sum, sizeof(sum));
      }
      offset += size;
    }
  }
  file = emit_container(halves->index, halves->chunks, kContainerMajor, halves->minor);
}

class Mutation {
 public:
  Mutation(std::size_t max_size, unsigned seed) : max_size_(max_size), random_(seed) {}

  Bytes apply(Bytes file) {
    const std::size_t kind = below(16);
    if (kind == 0) return mutated(std::move(file));
    const std::optional<Halves> halves = halves_of(file);
    if (kind == 1 || !halves) {
      file = mutated(std::move(file));
      mend(file);
      return file;
    }
    if (kind < 5) return with_other_index(*halves);
    std::optional<SlicedParts> parts = take_apart(file);
    if (!parts) return with_other_index(*halves);
    for (std::size_t times = 1 + below(3); times > 0; --times) {
      if (kind < 10) {
        change_payload(*parts);
      } else {
        change_field(*parts);
      }
    }
    return put_together(*parts);
  }

 private:
  [[nodiscard]] std::size_t below(std::size_t count) { return random_() % std::max<std::size_t>(1, count); }
  [[nodiscard]] double number() {
    static constexpr std::array kNumbers = {0.0,
                                            -1.0,
                                            1e-6,
                                            0.001,
                                            0.01,
                                            0.5,
                                            1.0,
                                            1.0001,
                                            1.5,
                                            2.0,
                                            20.0,
                                            45.0,
                                            80.0,
                                            90.0,
                                            180.0,
                                            300.0,
                                            1e30,
                                            1e-40,
                                            3e38,
                                            std::numeric_limits<double>::infinity(),
                                            std::numeric_limits<double>::quiet_NaN()};
    return kNumbers[below(kNumbers.size())];
  }
  [[nodiscard]] std::uint32_t count() {
    static constexpr std::array<std::uint32_t, 10> kCounts = {0, 1, 2, 3, 7, 100, 4096, 65536, 1U << 20U, 0xFFFFFFFF};
    return kCounts[below(kCounts.size())];
  }

  Bytes mutated(Bytes bytes) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(size, std::min(max_size_, 2 * size + 16)));
    bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
    return bytes;
  }

  Bytes with_other_index(const Halves& halves) {
    Bytes file = emit_container(mutated(halves.index), halves.chunks, kContainerMajor, halves.minor);
    mend(file);
    return file;
  }

  void change_payload(SlicedParts& parts) {
    if (parts.payloads.empty()) return;
    // The first ones, metadata, guide and crossings, are few among many.
    Bytes& payload =
        parts.payloads[below(below(3) == 0 ? std::min<std::size_t>(3, parts.payloads.size()) : parts.payloads.size())];
    switch (below(9)) {
      case 0:
        payload = parts.payloads[below(parts.payloads.size())];
        break;
      case 1:
        payload.clear();
        break;
      case 2:
        payload.resize(below(payload.size()));
        break;
      case 3:
        insert_extreme(payload);
        break;
      default:
        payload = mutated(std::move(payload));
        break;
    }
  }

  // In a script of the symbols fuzzer a residual as it is, beside the greatest steps and those of infinite values.
  void insert_extreme(Bytes& payload) {
    static constexpr std::array<std::uint32_t, 5> kSteps = {0x7F7FFFFF, 0x7F800000, 0x7FC00000, 0x7FFFFFFF, 0xFFFFFFFE};
    const std::uint32_t step = kSteps[below(kSteps.size())];
    std::array<std::byte, 5> bytes = {static_cast<std::byte>(252 + below(2))};
    for (unsigned k = 1; k < bytes.size(); ++k) bytes[k] = static_cast<std::byte>(step >> (32 - 8 * k));
    payload.insert(payload.begin() + static_cast<std::ptrdiff_t>(below(payload.size() + 1)), bytes.begin(),
                   bytes.end());
  }

  void change_field(SlicedParts& parts) {
    SlicedIndex& index = parts.index;
    switch (below(12)) {
      case 0:
        change_group(index.distributions.groups[below(index.distributions.groups.size())]);
        index.distributions.guide[below(2)] = static_cast<std::uint8_t>(below(113));
        break;
      case 1:
        // More than there may be can only stand in a file: changed bytes bring that about.
        index.distributions.flag_depths = static_cast<std::uint32_t>(below(CodingContext::kFlagDepths + 1));
        index.distributions.flags_by_depth = below(2) == 0;
        index.distributions.flags[below(index.distributions.flags.size())] = static_cast<std::uint8_t>(below(256));
        break;
      case 2:
        index.base_channel = static_cast<std::uint32_t>(below(index.channels.size() + 1));
        index.activity_shift = static_cast<std::uint32_t>(below(33));
        break;
      case 3:
        index.distributions.token_count = static_cast<std::uint32_t>(15 + below(61));
        break;
      case 4:
        index.adaptive_count =
            below(2) == 0 ? count() : index.adaptive_count + static_cast<std::uint32_t>(below(5)) - 2;
        break;
      case 5:
        change_guide(index);
        break;
      case 6:
        change_scale(index);
        break;
      case 7:
        change_channels(index);
        break;
      case 8:
        change_layout(index.layout);
        fit_chunks(parts);
        break;
      case 9:
      case 10:
        change_frame(index.frame);
        fit_chunks(parts);
        break;
      default:
        change_payload(parts);
        index.metadata_size = below(2) == 0 ? count() : static_cast<std::uint32_t>(below(2000));
        break;
    }
  }

  void change_group(GroupDistributions& group) {
    group.width = static_cast<std::uint8_t>(below(GroupDistributions::kMostWidth + 1));
    group.long_tails = below(2) == 0;
    group.stated = below(2) == 0;
    for (std::int8_t& off : group.off) {
      off = static_cast<std::int8_t>(group.stated ? static_cast<int>(below(16)) - GroupDistributions::kFarthest : 0);
    }
  }

  void change_guide(SlicedIndex& index) {
    index.guided = below(4) != 0;
    index.guide_ratio = below(2) == 0 ? 1 : number();
    index.guide_count = below(2) == 0 ? count() : static_cast<std::uint32_t>(below(20));
    // A guide needs the other frame and the log domain.
    index.frame.id = FrameId::kHalfDifference;
    use_log(index);
  }

  void use_log(SlicedIndex& index) {
    index.domain = DomainKind::kLog;
    index.reference_steps.resize(index.channels.size(), 1);
  }

  void change_scale(SlicedIndex& index) {
    if (below(4) == 0) {
      index.scale = Quantizer();
      return;
    }
    // The tables of fine bounds are slow to make and no harder to read.
    const std::uint32_t bound = below(8) == 0 ? 1 + static_cast<std::uint32_t>(below(500'000)) : 100'000;
    const auto lowest = static_cast<std::int32_t>(below(1U << 30U)) - (1 << 29);
    index.scale = Quantizer(bound_of(std::max(bound, 100U)), below(2) == 0 ? lowest : lowest % 2000);
  }

  void change_channels(SlicedIndex& index) {
    switch (below(4)) {
      case 0:
        index.channels.resize(1 + below(6), "channel");
        break;
      case 1:
        use_log(index);
        index.reference_steps.back() = static_cast<std::int32_t>(count() / 2);
        index.floor_halvings = static_cast<int>(below(256));
        break;
      case 2:
        index.domain = DomainKind::kLinear;
        index.reference_steps.clear();
        break;
      default:
        index.ranges[below(index.ranges.size())] = {-static_cast<std::int32_t>(count() / 4),
                                                    static_cast<std::int32_t>(count() / 2)};
        break;
    }
    index.ranges.resize(index.channels.size());
    if (index.domain == DomainKind::kLog) use_log(index);
  }

  void change_layout(ChunkLayout& layout) {
    layout.whole = below(4) == 0;
    if (layout.whole) {
      layout = {};
      return;
    }
    if (below(2) == 0) {
      auto& block = layout.block_nodes[below(layout.block_nodes.size())];
      block[below(block.size())] = static_cast<std::uint32_t>(below(8) == 0 ? count() : below(6));
      return;
    }
    layout.piece_depths = {1};
    while (below(3) != 0)
      layout.piece_depths.push_back(static_cast<std::uint8_t>(layout.piece_depths.back() + 1 + below(4)));
  }

  void change_frame(FrameSpec& frame) {
    if (below(4) == 0) {
      frame.id = static_cast<FrameId>(1 + below(2));
      frame.symmetries = {below(2) == 0, below(2) == 0, below(2) == 0};
      if (frame.symmetries.isotropic) frame.axes[0].nodes_deg = {0};
    }
    std::vector<double>& nodes = frame.axes[below(kAxisCount)].nodes_deg;
    const auto at = nodes.begin() + static_cast<std::ptrdiff_t>(below(nodes.size()));
    switch (below(4)) {
      case 0:
        nodes.erase(at);
        break;
      case 1:
        *at += below(2) == 0 ? number() : -number();
        break;
      case 2:
        nodes.insert(at, number());
        break;
      default:
        nodes = {0};
        for (std::size_t k = 1 + below(5); k > 0; --k)
          nodes.push_back(nodes.back() + static_cast<double>(1 + below(30)));
        break;
    }
    if (nodes.empty()) nodes = {0};
    if (frame.id == FrameId::kElevation && below(4) != 0) frame.axes[2].nodes_deg = frame.axes[3].nodes_deg;
    if (below(8) == 0) frame.theta_max_deg = below(2) == 0 ? number() : static_cast<double>(below(9001)) / 100;
    if (frame.id == FrameId::kElevation) frame.theta_max_deg = frame.axes[3].nodes_deg.back();
  }

  // As many chunks as the frame and the layout ask for.
  void fit_chunks(SlicedParts& parts) {
    double points = 1;
    for (const Axis& axis : parts.index.frame.axes) points *= static_cast<double>(axis.nodes_deg.size());
    if (points > 10'000 || !check_frame(parts.index.frame)) return;
    const Result<Lattice> lattice = build_lattice(parts.index.frame);
    if (!lattice) return;
    const ChunkOrder order(make_blocks(*lattice, parts.index.layout), parts.index.layout.piece_depths.size());
    parts.payloads.resize(std::min<std::size_t>(parts.index.chunk_count(order.count()), 10'000));
    const std::size_t crossings = parts.index.layout.whole ? 0 : ChunkOrder::crossings(0);
    if (parts.payloads[crossings].empty()) parts.payloads[crossings].resize(4);
  }

  std::size_t max_size_;
  std::minstd_rand random_;
};

}  // namespace

std::optional<SlicedParts> take_apart(const Bytes& file) {
  const std::optional<Halves> halves = halves_of(file);
  if (!halves) return {};
  Result<SlicedIndex> index = parse_index(halves->index, halves->minor > kContainerMinor);
  if (!index) return {};
  SlicedParts parts;
  parts.minor = halves->minor;
  ByteReader in(halves->chunks);
  for (const std::uint32_t size : index->chunk_sizes) {
    const auto chunk = in.bytes(size);
    if (!in.ok()) return {};
    const auto payload = chunk.first(size > kChecksumSize ? size - kChecksumSize : 0);
    parts.payloads.emplace_back(payload.begin(), payload.end());
  }
  parts.index = *std::move(index);
  return parts;
}

Bytes put_together(const SlicedParts& parts) {
  SlicedIndex index = parts.index;
  index.chunk_sizes.clear();
  Bytes chunks;
  for (const Bytes& payload : parts.payloads) {
    const std::size_t before = chunks.size();
    append_chunk(chunks, payload);
    index.chunk_sizes.push_back(static_cast<std::uint32_t>(chunks.size() - before));
  }
  return emit_container(emit_index(index), chunks, kContainerMajor, parts.minor);
}

std::size_t mutate_sliced(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  Mutation mutation(max_size, seed);
  const Bytes file = mutation.apply(copy_of(bytes, size));
  const std::size_t kept = std::min(file.size(), max_size);
  std::ranges::copy(std::as_bytes(std::span(file)).first(kept), reinterpret_cast<std::byte*>(bytes));
  return kept;
}

}  // namespace sbrdf::internal::fuzzing
