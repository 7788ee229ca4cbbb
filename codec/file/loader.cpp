#include "codec/file/loader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "codec/coding/guide_steps.h"
#include "codec/coding/sample_coder.h"
#include "codec/entropy/event_stream.h"
#include "codec/evaluation/needs.h"
#include "codec/file/memory_need.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {
namespace {

/// Makes values of the steps that are read, and in the end a sliced BRDF.
class SampleCollector {
 public:
  SampleCollector(const SlicedIndex& index, const Lattice& lattice, int max_depth)
      : index_(index), lattice_(lattice), channels_(index.channels.size()), max_depth_(max_depth) {
    sliced_.frame = index.frame;
    sliced_.domain = index.value_domain();
    sliced_.grey_shares = index.grey_shares;
    sliced_.channels = index.channels;
    sliced_.sample_counts.assign(lattice.slices.size(), 0);
    first_.resize(lattice.slices.size());
    if (!index.scale.lossless()) tabulate_values();
    if (max_depth < kMaxDepth) return;
    sliced_.positions.reserve(index.adaptive_count);
    sliced_.sample_values.reserve(index.adaptive_count * channels_);
  }

  /// Before anything else: its values are added to those of all samples.
  void add_guide(Guide guide) {
    offsets_.emplace(guide, lattice_, channels_, index_.scale);
    sliced_.guide = std::move(guide);
  }

  /// The samples of a slice that were read, but for its crossings, by rising position.
  void add_slice(std::uint32_t k, SliceSteps& read) {
    const Slice& slice = lattice_.slices[k];
    first_[k] = sliced_.positions.size();
    std::uint32_t s = 0;
    do {
      const SliceSteps::Sample& sample = read.samples[s];
      const int depth = depth_of(sample.place.fraction);
      if (depth != 0 && depth <= max_depth_) {
        ++sliced_.sample_counts[k];
        sliced_.positions.push_back(sample.place);
        append_values([&] { return coordinates_on(slice, sample.position_deg); },
                      std::span(read.table.steps(s), channels_), sliced_.sample_values);
      }
      s = sample.after;
    } while (s != 0 && s != SliceSteps::kNone);
  }

  /// All crossings, those that were not read as 0.
  void add_crossings(StepTable& steps, const std::vector<bool>& read) {
    sliced_.crossing_values.reserve(lattice_.crossings.size() * channels_);
    for (std::size_t k = 0; k < lattice_.crossings.size(); ++k) {
      if (read[k]) {
        append_values([&] { return lattice_.crossings[k]; }, std::span(steps.steps(k), channels_),
                      sliced_.crossing_values);
      } else {
        sliced_.crossing_values.resize(sliced_.crossing_values.size() + channels_, 0.0F);
      }
    }
  }

  Result<SlicedBrdf> finish() {
    order_by_slice();
    const auto finite = [](float v) { return std::isfinite(v); };
    for (const auto* values : {&sliced_.crossing_values, &sliced_.sample_values}) {
      if (!std::all_of(values->begin(), values->end(), finite)) return refuse_sliced("SB-8-4", "a value is not finite");
    }
    sliced_.whole_ranges = index_.value_ranges();
    return std::move(sliced_);
  }

 private:
  template <class CoordinatesOf>
  void append_values(const CoordinatesOf& x, std::span<std::int32_t> steps, std::vector<float>& values) {
    if (offsets_) offsets_->put_back(x(), steps);
    for (const std::int32_t step : steps) values.push_back(value(step));
  }

  [[nodiscard]] float value(std::int32_t step) const {
    const std::uint32_t place = static_cast<std::uint32_t>(step) - static_cast<std::uint32_t>(first_step_);
    return place < known_values_.size() ? known_values_[place] : index_.scale.value(step);
  }

  // Those between the bounds that the index tells, where there are fewer of them than values.
  void tabulate_values() {
    std::int64_t least = 0;
    std::int64_t most = 0;
    for (const StepRange& range : index_.ranges) {
      least = std::min<std::int64_t>(least, range.least);
      most = std::max<std::int64_t>(most, range.most);
    }
    const auto count = static_cast<std::uint64_t>(most - least) + 1;
    if (count > (lattice_.crossings.size() + index_.adaptive_count) * channels_) return;
    first_step_ = static_cast<std::int32_t>(least);
    for (std::int64_t step = least; step <= most; ++step) {
      known_values_.push_back(index_.scale.value(static_cast<std::int32_t>(step)));
    }
  }

  // Blocks come in an order of their own.
  void order_by_slice() {
    std::size_t next = 0;
    bool ordered = true;
    for (std::size_t k = 0; k < first_.size(); ++k) {
      ordered = ordered && (sliced_.sample_counts[k] == 0 || first_[k] == next);
      next += sliced_.sample_counts[k];
    }
    if (ordered) return;
    std::vector<SamplePosition> positions;
    std::vector<float> values;
    positions.reserve(sliced_.positions.size());
    values.reserve(sliced_.sample_values.size());
    for (std::size_t k = 0; k < first_.size(); ++k) {
      const auto first = static_cast<std::ptrdiff_t>(first_[k]);
      const auto count = static_cast<std::ptrdiff_t>(sliced_.sample_counts[k]);
      const auto channels = static_cast<std::ptrdiff_t>(channels_);
      positions.insert(positions.end(), sliced_.positions.begin() + first, sliced_.positions.begin() + first + count);
      values.insert(values.end(), sliced_.sample_values.begin() + first * channels,
                    sliced_.sample_values.begin() + (first + count) * channels);
    }
    sliced_.positions = std::move(positions);
    sliced_.sample_values = std::move(values);
  }

  const SlicedIndex& index_;
  const Lattice& lattice_;
  std::size_t channels_;
  int max_depth_;
  std::optional<GuideSteps> offsets_;
  std::vector<std::size_t> first_;   ///< per slice, its first sample as read
  std::vector<float> known_values_;  ///< of the steps from first_step_ on
  std::int32_t first_step_ = 0;
  SlicedBrdf sliced_;
};

/// One load: which crossings and slices are wanted, and what has been read of them.
class Loader {
 public:
  Loader(const SlicedFile& file, LatticeParts wanted, int max_depth)
      : file_(file),
        index_(file.index),
        lattice_(*file.lattice),
        channels_(index_.channels.size()),
        coding_(index_.coding()),
        max_depth_(max_depth),
        tables_(index_.distributions),
        wanted_(std::move(wanted)),
        crossings_(channels_),
        state_(channels_) {}

  // The slices of a block share a stream, and each is predicted from its crossings: all of them are needed to decode
  // any one slice that has samples; a slice without samples needs only its own.
  void want_what_decoding_needs() {
    if (index_.layout.whole) wanted_.crossings.assign(wanted_.crossings.size(), true);
    for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
      const Blocks& blocks = file_.blocks.slices[kind];
      for (std::size_t block = 0; block < blocks.size(); ++block) {
        if (!is_wanted(blocks[block]) || !has_samples(kind, block)) continue;
        for (const std::uint32_t k : blocks[block]) {
          for (const SliceNode& node : lattice_.nodes_of(lattice_.slices[k])) wanted_.crossings[node.crossing] = true;
        }
      }
    }
  }

  Result<SlicedBrdf> run() {
    needed_ = memory_of_index(file_.offsets.front()) + memory_of_metadata(index_) + memory_of_samples(index_, lattice_);
    if (Status enough = check_memory(needed_, file_.memory_allowed); !enough) return enough.error();
    longest_ = static_cast<std::size_t>((static_cast<double>(file_.memory_allowed) - needed_) /
                                        memory_of_decoded_sample(channels_));
    collector_.emplace(index_, lattice_, max_depth_);
    if (Status status = read_guide(); !status) return status.error();
    if (Status status = read_crossings(); !status) return status.error();
    if (Status status = read_slices(); !status) return status.error();
    collector_->add_crossings(crossings_, read_crossing_);
    return collector_->finish();
  }

 private:
  [[nodiscard]] bool is_wanted(const std::vector<std::uint32_t>& block) const {
    return std::any_of(block.begin(), block.end(), [&](std::uint32_t k) { return wanted_.slices[k]; });
  }
  [[nodiscard]] bool has_samples(std::size_t kind, std::size_t block) const {
    for (std::size_t piece = 0; piece < index_.layout.piece_depths.size(); ++piece) {
      if (index_.layout.piece_depths[piece] > max_depth_) break;
      if (has_samples(file_.order.slices(piece, kind, block))) return true;
    }
    return false;
  }
  [[nodiscard]] bool has_samples(std::size_t stream_number) const {
    return index_.layout.whole ? index_.adaptive_count > 0 : index_.chunk_sizes[stream_number] != 0;
  }

  [[nodiscard]] Error damaged(std::size_t chunk, const char* clause, const char* what) const {
    Error error = refuse_sliced(clause, what);
    error.offset = file_.offsets[chunk];
    return error;
  }

  [[nodiscard]] Guide guide_of(const SliceSteps& read) const {
    Guide guide;
    guide.ratio = index_.guide_ratio;
    for (std::uint32_t k = 0; k != SliceSteps::kNone; k = read.samples[k].after) {
      guide.places.push_back(read.samples[k].place);
      for (std::size_t c = 0; c < channels_; ++c) {
        guide.values.push_back(guide_value(index_.scale, read.table.steps(k)[c]));
      }
    }
    return guide;
  }

  /// A chunk that is being read.
  struct ChunkStream {
    std::vector<std::byte> bytes;
    std::size_t number;
    StreamReader in;

    ChunkStream(std::vector<std::byte> payload, std::size_t chunk, DecodingTables& tables)
        : bytes(std::move(payload)), number(chunk), in(bytes, tables) {}
  };
  /// Of a whole file the one stream that goes on and on, else that of a chunk of its own.
  Result<std::shared_ptr<ChunkStream>> stream(std::size_t number) {
    if (whole_ != nullptr) return whole_;
    if (index_.layout.whole) number = 0;
    Result<std::vector<std::byte>> bytes = file_.chunk(number);
    if (!bytes) return bytes.error();
    auto opened = std::make_shared<ChunkStream>(*std::move(bytes), number, tables_);
    if (index_.layout.whole) whole_ = opened;
    return opened;
  }
  /// Whether all that a stream must hold was read well, when another takes its place.
  [[nodiscard]] bool ends_well(const ChunkStream& read) const {
    return index_.layout.whole ? read.in.ok() : read.in.at_end();
  }

  Status read_guide() {
    if (!index_.guided) return ok_status();
    const Result<std::shared_ptr<ChunkStream>> read = stream(ChunkOrder::kGuide);
    if (!read) return read.error();
    StreamReader& in = (*read)->in;
    StepTable nodes(channels_);
    const std::size_t node_count = lattice_.nodes[kVertical].size();
    nodes.hold(node_count);
    code_guide_nodes(in, coding_, node_count, nodes);
    SliceSteps state(channels_);
    begin_guide(lattice_, nodes, state);
    const SliceCoding guide_coding = {coding_, kGuideSampleContexts, [&](const SamplePosition& place) {
                                        return guide_position_deg(lattice_.nodes[kVertical], place);
                                      }};
    for (int depth = 1; depth <= kMaxDepth && in.ok(); ++depth) {
      code_depth(in, guide_coding, depth, state, SamplesToRead());
      if (state.samples.size() > index_.guide_count) break;
    }
    if (!ends_well(**read) || state.samples.size() != index_.guide_count) {
      return damaged(ChunkOrder::kGuide, "SB-8-2", "the guide does not decode");
    }
    Guide guide = guide_of(state);
    if (!std::all_of(guide.values.begin(), guide.values.end(), [](float v) { return std::isfinite(v); })) {
      return damaged(ChunkOrder::kGuide, "SB-8-4", "a value of the guide is not finite");
    }
    collector_->add_guide(std::move(guide));
    return ok_status();
  }

  Status read_crossings() {
    crossings_.hold(lattice_.crossings.size());
    read_crossing_.assign(lattice_.crossings.size(), false);
    for (std::uint32_t block = 0; block < file_.blocks.crossings.size(); ++block) {
      const std::vector<std::uint32_t>& members = file_.blocks.crossings[block];
      if (std::none_of(members.begin(), members.end(), [&](std::uint32_t k) { return wanted_.crossings[k]; })) continue;
      const Result<std::shared_ptr<ChunkStream>> read = stream(ChunkOrder::crossings(block));
      if (!read) return read.error();
      code_crossings((*read)->in, coding_, file_.plan->get(lattice_, file_.blocks), block, crossings_);
      if (!ends_well(**read)) return damaged((*read)->number, "SB-8-1", "the crossings do not decode");
      for (const std::uint32_t k : members) read_crossing_[k] = true;
    }
    return ok_status();
  }

  /// The samples of one piece of a block.
  struct PieceStream {
    std::shared_ptr<ChunkStream> read;
    int first_depth = 0;
    int end_depth = 0;
  };

  // Slice by slice through all pieces, so that nothing but one slice is worked on.
  Status read_slices() {
    if (max_depth_ == 0) return ok_status();
    for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
      for (std::size_t block = 0; block < file_.blocks.slices[kind].size(); ++block) {
        if (!index_.layout.whole && !is_wanted(file_.blocks.slices[kind][block])) continue;
        if (Status status = read_block(kind, block); !status) return status;
      }
    }
    if (whole_ != nullptr && !whole_->in.at_end()) return damaged(0, "SB-8-3", "the samples do not decode");
    return ok_status();
  }

  Status read_block(std::size_t kind, std::size_t block) {
    std::vector<PieceStream> pieces;
    for (std::size_t piece = 0; piece < index_.layout.piece_depths.size(); ++piece) {
      const auto [first_depth, end_depth] = depths_of_piece(index_.layout, piece);
      const std::size_t number = file_.order.slices(piece, kind, block);
      if (first_depth > max_depth_ || !has_samples(number)) continue;
      Result<std::shared_ptr<ChunkStream>> read = stream(number);
      if (!read) return read.error();
      pieces.push_back({*std::move(read), first_depth, end_depth});
    }
    for (const std::uint32_t k : file_.blocks.slices[kind][block]) {
      if (pieces.empty()) break;
      if (Status status = read_slice(k, pieces); !status) return status;
    }
    for (const PieceStream& piece : pieces) {
      if (!ends_well(*piece.read)) return damaged(piece.read->number, "SB-8-3", "the samples do not decode");
    }
    return ok_status();
  }

  Status read_slice(std::uint32_t k, std::vector<PieceStream>& pieces) {
    const Slice& slice = lattice_.slices[k];
    const SliceCoding slice_coding = {
        coding_, kSampleContexts, [&](const SamplePosition& place) { return position_deg(lattice_, slice, place); }};
    begin_slice(lattice_, slice, crossings_, state_);
    const std::size_t crossings = state_.samples.size();
    for (PieceStream& piece : pieces) {
      for (int depth = piece.first_depth; depth < piece.end_depth; ++depth) {
        if (state_.depth != depth - 1) break;
        if (Status enough = check_slice_fits(); !enough) return enough;
        code_depth(piece.read->in, slice_coding, depth, state_, SamplesToRead());
        if (!piece.read->in.ok() || decoded_ + state_.samples.size() - crossings > index_.adaptive_count) {
          return damaged(piece.read->number, "SB-8-3", "the samples do not decode");
        }
      }
    }
    decoded_ += state_.samples.size() - crossings;
    if (wanted_.slices[k]) collector_->add_slice(k, state_);
    return ok_status();
  }

  // Memory is checked before each depth: flags that are always yes cost nothing, and how long a single slice gets is
  // only seen while it is read.
  [[nodiscard]] Status check_slice_fits() const {
    const std::size_t halved = state_.samples.size() - state_.newest;
    const std::size_t most = state_.samples.size() + 2 * halved;
    if (most <= longest_) return ok_status();
    return check_memory(needed_ + static_cast<double>(most) * memory_of_decoded_sample(channels_),
                        file_.memory_allowed);
  }

  const SlicedFile& file_;
  const SlicedIndex& index_;
  const Lattice& lattice_;
  std::size_t channels_;
  CodingParameters coding_;
  int max_depth_;
  DecodingTables tables_;
  std::shared_ptr<ChunkStream> whole_;
  LatticeParts wanted_;
  std::vector<bool> read_crossing_;
  StepTable crossings_;
  SliceSteps state_;
  std::uint64_t decoded_ = 0;
  double needed_ = 0;                         ///< memory, but for the slice that is being read
  std::size_t longest_ = 0;                   ///< samples of a slice that certainly fit
  std::optional<SampleCollector> collector_;  ///< made once the memory is known to be enough
};

}  // namespace

Result<std::vector<std::byte>> SlicedFile::chunk(std::size_t number) const {
  return read_chunk(*source, offsets[number], index.chunk_sizes[number]);
}

Result<SlicedBrdf> load_samples(const SlicedFile& file, int max_depth) {
  const Lattice& lattice = *file.lattice;
  const LatticeParts all = {std::vector<bool>(lattice.crossings.size(), true),
                            std::vector<bool>(lattice.slices.size(), true)};
  return Loader(file, all, max_depth).run();
}

Result<SlicedBrdf> load_samples(const SlicedFile& file, const CellSet& cells, int max_depth) {
  Loader loader(file, needs_of(*file.lattice, cells), max_depth);
  loader.want_what_decoding_needs();
  return loader.run();
}

}  // namespace sbrdf::internal
