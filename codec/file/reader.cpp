#include "codec/file/reader.h"

#include <algorithm>

#include "codec/file/memory_need.h"
#include "codec/mask/mask_runs.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/metadata.h"
#include "formats/sbrdf/zstd_frame.h"

namespace sbrdf::internal {
namespace {

// What a small file can make a reader allocate: no distribution takes less than 1/190 of a bit for a value.
constexpr double kMostValuesPerByte = 1536;
constexpr double kValuesAlwaysAllowed = 65536;

// Away from the poles at most eight lattice points are one crossing. Keeps a small file from asking for a huge lattice.
double least_crossing_count(const FrameSpec& frame) {
  double count = 1.0 / 8;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::size_t nodes = frame.axes[axis].nodes_deg.size();
    count *= static_cast<double>(axis <= kDiagonal || nodes == 1 ? nodes : nodes - 1);
  }
  return count;
}

}  // namespace

PartialSliced::PartialSliced(SlicedBrdf sliced, std::shared_ptr<const Lattice> lattice, CellSet cells)
    : sliced_(std::move(sliced)),
      cells_(std::move(cells)),
      evaluator_(sliced_, *lattice),
      lattice_(std::move(lattice)) {}

bool PartialSliced::covers(const DirectionPair& pair) const { return cells_.contains(cell_of(*lattice_, pair)); }

Status PartialSliced::evaluate(const DirectionPair& pair, std::span<float> values) const {
  // Below the horizon the value is known without the file.
  if (above_horizon(pair) && !covers(pair)) return usage_error("this pair of directions was not loaded");
  evaluator_.evaluate(pair, values);
  return ok_status();
}

Result<SlicedReader> SlicedReader::open(const ByteSource& source, const MemoryLimit& limit) {
  Result<ContainerHead> head = read_head(source);
  if (!head) return head.error();
  const bool newer_minor = head->minor > kContainerMinor;
  const std::uint64_t allowed = limit.of(source.stored_size());
  double needed = memory_of_index(head->index.size());
  if (Status enough = check_memory(needed, allowed); !enough) return enough.error();
  Result<SlicedIndex> index = parse_index(head->index, newer_minor);
  if (!index) return index.error();
  const double values = (least_crossing_count(index->frame) + index->adaptive_count + index->guide_count) *
                        static_cast<double>(index->channels.size());
  if (values > kValuesAlwaysAllowed + kMostValuesPerByte * static_cast<double>(source.size())) {
    return refuse_sliced("SB-2-14", "more values than a file of this size can hold");
  }
  needed += memory_of_metadata(*index) + memory_of_mask(*index) + memory_of_lattice(index->frame);
  if (Status enough = check_memory(needed, allowed); !enough) return enough.error();
  Result<Lattice> lattice = build_lattice(index->frame);
  if (!lattice) {
    Error error = lattice.error();
    error.message = "[SB-2-4] " + error.message;
    return error;
  }
  LatticeBlocks blocks = make_blocks(*lattice, index->layout);
  const ChunkOrder order(blocks, index->layout.piece_depths.size());
  if (const std::size_t expected = index->chunk_count(order.count()); index->chunk_sizes.size() != expected) {
    return refuse_sliced("SB-3-1", "the index lists " + std::to_string(index->chunk_sizes.size()) +
                                       " chunks, its frame and layout have " + std::to_string(expected));
  }
  if (!index->layout.whole && !index->guided && index->chunk_sizes[ChunkOrder::kGuide] != 0) {
    return refuse_sliced("SB-8-2", "a guide's chunk, but no guide");
  }
  std::vector<std::uint64_t> offsets = {head->chunks_offset()};
  for (const std::uint32_t size : index->chunk_sizes) offsets.push_back(offsets.back() + size);
  if (offsets.back() != source.size() && !(newer_minor && offsets.back() < source.size())) {
    return refuse_sliced(
        "SB-3-2", "the chunks end at byte " + std::to_string(offsets.back()) + " of " + std::to_string(source.size()));
  }
  return SlicedReader({&source, std::move(index).value(), std::make_shared<Lattice>(std::move(lattice).value()),
                       std::move(blocks), std::make_shared<LazyCrossingPlan>(), order, std::move(offsets), allowed},
                      head->version());
}

Lattice SlicedReader::take_lattice() && {
  // It was made by open, and not as a constant.
  if (file_.lattice.use_count() == 1) return std::move(*std::const_pointer_cast<Lattice>(file_.lattice));
  return *file_.lattice;
}

Result<std::string> SlicedReader::metadata() const {
  if (file_.index.metadata_size == 0) return std::string();
  std::optional<std::string> text = unpack_metadata(file_.index.metadata, file_.index.metadata_size);
  if (!text) return refuse_sliced("SB-8-5", "the metadata do not decompress to the size in the index");
  return *std::move(text);
}

Result<std::shared_ptr<const DirectionMask>> SlicedReader::mask() const {
  if (!file_.index.mask) return std::shared_ptr<const DirectionMask>();
  const Result<std::vector<std::byte>> packed = file_.chunk(file_.index.mask_chunk());
  if (!packed) return packed.error();
  const std::optional<std::vector<std::byte>> runs = unpack_bytes(*packed, file_.index.mask_size);
  std::optional<DirectionMask> mask = runs ? parse_runs(*runs, *file_.index.mask) : std::nullopt;
  if (!mask) return refuse_sliced("SB-8-7", "the mask does not decompress to runs that fill its cells");
  return std::shared_ptr<const DirectionMask>(std::make_shared<const DirectionMask>(*std::move(mask)));
}

Result<SlicedBrdf> SlicedReader::load_all(int max_depth) const {
  Result<SlicedBrdf> sliced = load_samples(file_, max_depth);
  if (!sliced) return sliced;
  if (max_depth >= kMaxDepth) {
    if (sliced->adaptive_count() != file_.index.adaptive_count) {
      return refuse_sliced("SB-8-3", "there are " + std::to_string(sliced->adaptive_count()) +
                                         " samples, the index says " + std::to_string(file_.index.adaptive_count));
    }
    sliced->whole_ranges.clear();
    if (value_ranges(*sliced) != file_.index.value_ranges()) {
      return refuse_sliced("SB-8-6", "the values do not span the ranges in the index");
    }
  }
  Result<std::string> text = metadata();
  if (!text) return text.error();
  sliced->metadata = *std::move(text);
  Result<std::shared_ptr<const DirectionMask>> unmeasured = mask();
  if (!unmeasured) return unmeasured.error();
  sliced->mask = *std::move(unmeasured);
  return sliced;
}

Result<PartialSliced> SlicedReader::load(const CellSet& cells, int max_depth) const {
  Result<SlicedBrdf> sliced = load_samples(file_, cells, max_depth);
  if (!sliced) return sliced.error();
  return PartialSliced(std::move(sliced).value(), file_.lattice, cells);
}

std::uint64_t SlicedReader::bytes_up_to(int max_depth) const {
  if (file_.index.layout.whole) return file_.offsets.back();
  std::size_t end = ChunkOrder::crossings(file_.blocks.crossings.size());
  for (std::size_t piece = 0; piece < file_.index.layout.piece_depths.size(); ++piece) {
    if (file_.index.layout.piece_depths[piece] > max_depth) break;
    end = file_.order.slices(piece, 0, 0) + file_.order.per_piece();
  }
  const std::uint64_t mask = file_.index.mask ? file_.index.chunk_sizes[file_.index.mask_chunk()] : 0;
  return std::min(file_.offsets[end] + mask, file_.offsets.back());
}

}  // namespace sbrdf::internal
