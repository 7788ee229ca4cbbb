#include "codec/file/encoder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "codec/coding/value_scaling.h"
#include "codec/entropy/event_stream.h"
#include "codec/file/index.h"
#include "codec/file/parameter_choice.h"
#include "codec/file/reader.h"
#include "codec/file/recorder.h"
#include "codec/mask/mask_runs.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/metadata.h"
#include "formats/sbrdf/zstd_frame.h"

namespace sbrdf::internal {
namespace {

/// A file on its way: values have become steps, steps events, and all parameters of the index are chosen.
struct Recorded {
  SlicedIndex index;  ///< all but the sizes of chunks
  std::vector<ChunkEvents> events;
};

ChunkLayout layout_for(const SlicedBrdf& sliced, const Lattice& lattice, ChunkSize chunks) {
  const bool split = chunks == ChunkSize::kSplit || (chunks == ChunkSize::kAuto && sliced.sample_count() >= kSplitFrom);
  return split ? split_layout(lattice, sliced.sample_count()) : ChunkLayout();
}

std::vector<StepRange> ranges_of(const Scaled& scaled, std::size_t channels) {
  std::vector<StepRange> ranges;
  for (std::size_t c = 0; c < channels; ++c) {
    StepRange range = {scaled.crossing_steps[c], scaled.crossing_steps[c]};
    for (const auto* steps : {&scaled.crossing_steps, &scaled.sample_steps}) {
      for (std::size_t k = c; k < steps->size(); k += channels) {
        range.least = std::min(range.least, (*steps)[k]);
        range.most = std::max(range.most, (*steps)[k]);
      }
    }
    ranges.push_back(range);
  }
  return ranges;
}

SlicedIndex index_of(const SlicedBrdf& sliced, const Lattice& lattice, ChunkSize chunks, const Scaled& scaled) {
  SlicedIndex index;
  index.frame = sliced.frame;
  index.domain = sliced.domain.kind;
  index.channels = sliced.channels;
  index.ranges = ranges_of(scaled, sliced.channel_count());
  index.reference_steps = scaled.reference_steps;
  index.grey_shares = sliced.grey_shares;
  index.floor_halvings = sliced.domain.floor_halvings;
  if (sliced.guide) {
    index.guided = true;
    index.guide_ratio = sliced.guide->ratio;
    index.guide_count = static_cast<std::uint32_t>(sliced.guide->places.size());
  }
  index.adaptive_count = static_cast<std::uint32_t>(sliced.adaptive_count());
  index.scale = scaled.scale;
  index.layout = layout_for(sliced, lattice, chunks);
  if (sliced.mask) index.mask = sliced.mask->grid;
  index.metadata_size = static_cast<std::uint32_t>(sliced.metadata.size());
  if (index.metadata_size > 0) index.metadata = pack_metadata(sliced.metadata);
  return index;
}

Recorded record(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options) {
  Scaled scaled = scale_values(sliced, options.precision);
  Recorded made;
  made.index = index_of(sliced, lattice, options.chunks, scaled);
  take_off_guide(sliced, lattice, scaled);
  SampleRecorder recorder(sliced, lattice, scaled, made.index.layout);
  choose_parameters(recorder, made.index);
  made.events = recorder.record_all(made.index.coding());
  made.index.distributions = choose_distributions(made.events).distributions;
  return made;
}

/// Bits that symbols take if each is coded as often as it occurs: counts by symbol.
double empirical_bits(const std::map<std::int64_t, double>& counts) {
  double total = 0;
  for (const auto& [symbol, count] : counts) total += count;
  double bits = 0;
  for (const auto& [symbol, count] : counts) bits += count * std::log2(total / count);
  return bits;
}

}  // namespace

std::vector<std::byte> encode_sliced(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options) {
  Recorded recorded = record(sliced, lattice, options);
  SlicedIndex& index = recorded.index;
  std::vector<std::byte> chunks;
  const auto append = [&](std::span<const std::byte> payload) {
    const std::size_t before = chunks.size();
    append_chunk(chunks, payload);
    index.chunk_sizes.push_back(static_cast<std::uint32_t>(chunks.size() - before));
  };
  const StreamWriter writer(index.distributions);
  for (const ChunkEvents& events : recorded.events) append(writer.write(events));
  if (sliced.mask) {
    const std::vector<std::byte> runs = emit_runs(*sliced.mask);
    index.mask_size = static_cast<std::uint32_t>(runs.size());
    append(pack_bytes(runs));
  }
  return emit_container(emit_index(index), chunks);
}

CodingCost coding_cost(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options) {
  const Recorded recorded = record(sliced, lattice, options);
  const StreamWriter writer(recorded.index.distributions);
  std::array<std::map<std::int64_t, double>, CodingContext::kResidualCount> tokens;
  std::array<std::map<std::int64_t, double>, CodingContext::kFlagCount> flags;
  CodingCost cost;
  double bits = 0;
  for (const ChunkEvents& events : recorded.events) {
    cost.stream_bytes += writer.write(events).size();
    for (const Event& event : events) {
      const Token token = token_of(event.value);
      ++(event.flag ? flags[event.context][event.value] : tokens[event.context][token.index]);
      bits += event.flag ? 0 : token.bit_count;
    }
  }
  for (const auto& counts : tokens) bits += empirical_bits(counts);
  for (const auto& counts : flags) bits += empirical_bits(counts);
  cost.entropy_bytes = bits / 8;
  return cost;
}

Result<DecodedSliced> decode_sliced(std::span<const std::byte> bytes, const MemoryLimit& limit) {
  const MemorySource source(bytes);
  const Result<SlicedReader> reader = SlicedReader::open(source, limit);
  if (!reader) return reader.error();
  Result<SlicedBrdf> sliced = reader->load_all();
  if (!sliced) return sliced.error();
  return DecodedSliced{std::move(sliced).value(), reader->lattice(), reader->version(), reader->index().scale.bound()};
}

}  // namespace sbrdf::internal
