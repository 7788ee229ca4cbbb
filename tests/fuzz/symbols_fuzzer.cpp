#include <algorithm>
#include <optional>
#include <utility>

#include "codec/coding/guide_steps.h"
#include "codec/coding/sample_coder.h"
#include "codec/entropy/event_stream.h"
#include "codec/entropy/rans.h"
#include "codec/file/reader.h"
#include "codec/frame/cells.h"
#include "formats/core/byte_source.h"
#include "tests/fuzz/sliced_file.h"

// Chunks whose streams are intact but say anything at all. A changed stream hardly ever ends as it must; so the
// payloads of the input are taken as scripts of residuals and flags, which are coded into streams that do.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr std::uint8_t kSomeFlag = 128;
constexpr std::size_t kMostSamples = 20'000;

/// What a script says, one number or flag after another. Behind its end all are 0 and no.
class Script {
 public:
  explicit Script(Bytes bytes) : bytes_(std::move(bytes)) {}

  bool flag() {
    if (bit_ == 0) flags_ = next();
    const bool value = ((flags_ >> bit_) & 1U) != 0;
    bit_ = (bit_ + 1) % 8;
    return value;
  }
  // Bytes below 240 are small numbers. Others say how many bits a number has, or that it follows as it is.
  std::int64_t residual() {
    const std::uint8_t first = next();
    if (first == 0) return 0;
    if (first < 240) return std::int64_t{first} - 120;
    if (first >= 252) {
      std::uint32_t bits = 0;
      for (int k = 0; k < 4; ++k) bits = bits << 8U | next();
      return first == 252 ? std::int64_t{bits} : -std::int64_t{bits};
    }
    const unsigned bits = 8 + 2 * (first - 240U);
    const std::int64_t value = (std::int64_t{1} << bits) | (std::int64_t{next()} << (bits - 8));
    return (next() & 1U) != 0 ? -value : value;
  }

 private:
  std::uint8_t next() { return at_ < bytes_.size() ? static_cast<std::uint8_t>(bytes_[at_++]) : std::uint8_t{0}; }

  Bytes bytes_;
  std::size_t at_ = 0;
  unsigned bit_ = 0;
  std::uint8_t flags_ = 0;
};

/// The Io of code_sample that reads a script and writes down what a stream must hold to say the same.
class ScriptIo {
 public:
  static constexpr bool kDecodes = true;

  ScriptIo(const Bytes& script, const SlicedIndex& index) : script_(script), index_(index) {}

  void residual(unsigned context, std::int64_t& value) {
    value = script_.residual();
    if (token_of(value).index >= index_.distributions.token_count) value = 0;
    events_.push_back({value, static_cast<std::uint8_t>(context), false});
  }
  void flag(unsigned context, bool& value) {
    value = script_.flag();
    events_.push_back({value ? 1 : 0, static_cast<std::uint8_t>(context), true});
  }
  [[nodiscard]] std::int32_t step(std::int64_t step) {
    constexpr std::int64_t kMost = 0x7FFFFFFF;
    if (step < -kMost || step > kMost) failed_ = true;
    return static_cast<std::int32_t>(std::clamp(step, -kMost, kMost));
  }
  [[nodiscard]] bool ok() const { return !failed_ && events_.size() < kMostSamples * 8; }

  [[nodiscard]] Bytes stream() const {
    return events_.empty() ? RansEncoder().finish() : StreamWriter(index_.distributions).write(events_);
  }

 private:
  Script script_;
  const SlicedIndex& index_;
  std::vector<Event> events_;
  bool failed_ = false;
};

/// Makes a file of what scripts say, in the order in which a reader decodes it.
class ScriptedFile {
 public:
  ScriptedFile(SlicedParts parts, const Lattice& lattice)
      : parts_(in_chunks(std::move(parts), lattice)),
        index_(parts_.index),
        lattice_(lattice),
        channels_(index_.channels.size()),
        blocks_(make_blocks(lattice, index_.layout)),
        order_(blocks_, index_.layout.piece_depths.size()),
        crossings_(channels_),
        state_(channels_) {
    // What the file says no to may be yes here.
    index_.distributions.flag_depths = CodingContext::kFlagDepths;
    std::ranges::replace(index_.distributions.flags, std::uint8_t{0}, kSomeFlag);
  }

  Bytes run() {
    if (index_.guided) write_guide();
    write_crossings();
    for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
      for (std::size_t block = 0; block < blocks_.slices[kind].size(); ++block) write_block(kind, block);
    }
    index_.adaptive_count = static_cast<std::uint32_t>(sample_count_);
    find_ranges();
    return put_together(parts_);
  }

 private:
  void write_guide() {
    Bytes& payload = parts_.payloads[ChunkOrder::kGuide];
    ScriptIo io(payload, index_);
    const std::size_t node_count = lattice_.nodes[kVertical].size();
    StepTable nodes(channels_);
    nodes.hold(node_count);
    code_guide_nodes(io, index_.coding(), node_count, nodes);
    SliceSteps state(channels_);
    begin_guide(lattice_, nodes, state);
    const CodingParameters coding = index_.coding();
    const SliceCoding guide_coding = {coding, kGuideSampleContexts, [&](const SamplePosition& place) {
                                        return guide_position_deg(lattice_.nodes[kVertical], place);
                                      }};
    for (int depth = 1; depth <= kMaxDepth && io.ok(); ++depth) {
      code_depth(io, guide_coding, depth, state, SamplesToRead());
    }
    index_.guide_count = static_cast<std::uint32_t>(state.samples.size());
    payload = io.stream();
  }

  void write_crossings() {
    const CrossingPlan plan = plan_crossings(lattice_, blocks_);
    crossings_.hold(lattice_.crossings.size());
    for (std::uint32_t block = 0; block < blocks_.crossings.size(); ++block) {
      Bytes& payload = parts_.payloads[order_.crossings(block)];
      ScriptIo io(payload, index_);
      code_crossings(io, index_.coding(), plan, block, crossings_);
      payload = io.stream();
    }
  }

  struct Piece {
    ScriptIo io;
    std::size_t number = 0;
    std::pair<int, int> depths;
  };

  void write_block(std::size_t kind, std::size_t block) {
    std::vector<Piece> pieces;
    for (std::size_t piece = 0; piece < index_.layout.piece_depths.size(); ++piece) {
      const std::size_t number = order_.slices(piece, kind, block);
      if (parts_.payloads[number].empty()) continue;
      pieces.push_back({ScriptIo(parts_.payloads[number], index_), number, depths_of_piece(index_.layout, piece)});
    }
    for (const std::uint32_t k : blocks_.slices[kind][block]) {
      if (!write_slice(k, pieces)) break;
    }
    for (const Piece& piece : pieces) parts_.payloads[piece.number] = piece.io.stream();
  }

  // False when it is enough, or too much for a reader.
  bool write_slice(std::uint32_t k, std::vector<Piece>& pieces) {
    const Slice& slice = lattice_.slices[k];
    const CodingParameters coding = index_.coding();
    const SliceCoding slice_coding = {
        coding, kSampleContexts, [&](const SamplePosition& place) { return position_deg(lattice_, slice, place); }};
    begin_slice(lattice_, slice, crossings_, state_);
    const std::size_t known = state_.samples.size();
    for (Piece& piece : pieces) {
      for (int depth = piece.depths.first; depth < piece.depths.second; ++depth) {
        code_depth(piece.io, slice_coding, depth, state_, SamplesToRead());
        if (!piece.io.ok() || sample_count_ + state_.samples.size() - known > kMostSamples) return false;
      }
    }
    sample_count_ += state_.samples.size() - known;
    return true;
  }

  // A file of one chunk says in each of many what it says in the one.
  static SlicedParts in_chunks(SlicedParts parts, const Lattice& lattice) {
    if (!parts.index.layout.whole) return parts;
    parts.index.layout.whole = false;
    const ChunkOrder order(make_blocks(lattice, parts.index.layout), parts.index.layout.piece_depths.size());
    parts.index.mask.reset();
    parts.payloads.resize(order.count(), parts.payloads.front());
    if (!parts.index.guided) parts.payloads[ChunkOrder::kGuide].clear();
    return parts;
  }

  // Those of the values that a reader finds, so that it accepts the file.
  void find_ranges() {
    const Bytes file = put_together(parts_);
    const MemorySource source(file);
    const Result<SlicedReader> reader = SlicedReader::open(source);
    if (!reader) return;
    CellSet all(reader->lattice());
    all.add_all();
    const Result<PartialSliced> loaded = reader->load(all);
    if (!loaded) return;
    SlicedBrdf sliced = loaded->sliced();
    sliced.whole_ranges.clear();
    index_.ranges.clear();
    for (const ValueRange& range : value_ranges(sliced)) {
      index_.ranges.push_back({index_.scale.step(range.least), index_.scale.step(range.most)});
    }
  }

  SlicedParts parts_;
  SlicedIndex& index_;
  const Lattice& lattice_;
  std::size_t channels_;
  LatticeBlocks blocks_;
  ChunkOrder order_;
  StepTable crossings_;
  SliceSteps state_;
  std::size_t sample_count_ = 0;
};

void run(const Bytes& bytes) {
  const MemorySource source(bytes);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  std::optional<SlicedParts> parts = take_apart(bytes);
  if (!reader || !parts) return;
  exercise_sliced(ScriptedFile(*std::move(parts), reader->lattice()).run());
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  return sbrdf::internal::fuzzing::mutate_sliced(bytes, size, max_size, seed);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
