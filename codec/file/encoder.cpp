#include "codec/file/encoder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "codec/coding/distribution_choice.h"
#include "codec/coding/guide_steps.h"
#include "codec/coding/sample_coder.h"
#include "codec/file/index.h"
#include "codec/file/metadata.h"
#include "codec/file/reader.h"
#include "codec/file/value_scaling.h"
#include "formats/sbrdf/container.h"

namespace sbrdf::internal {
namespace {

/// The Io of code_sample for writing.
class Recorder {
 public:
  static constexpr bool kDecodes = false;

  explicit Recorder(std::vector<Event>& events) : events_(events) {}
  void residual(unsigned context, std::int64_t& value) {
    events_.push_back({value, static_cast<std::uint8_t>(context), false});
  }
  void flag(unsigned context, bool& value) {
    events_.push_back({value ? 1 : 0, static_cast<std::uint8_t>(context), true});
  }
  [[nodiscard]] static std::int32_t step(std::int64_t step) { return static_cast<std::int32_t>(step); }
  [[nodiscard]] static bool ok() { return true; }

 private:
  std::vector<Event>& events_;
};

class Encoder {
 public:
  Encoder(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options)
      : sliced_(sliced),
        lattice_(lattice),
        channels_(sliced.channel_count()),
        crossings_(channels_),
        state_(channels_) {
    crossings_.hold(lattice.crossings.size());
    index_.frame = sliced.frame;
    index_.domain = sliced.domain;
    index_.channels = sliced.channels;
    index_.adaptive_count = static_cast<std::uint32_t>(sliced.adaptive_count());
    index_.metadata_size = static_cast<std::uint32_t>(sliced.metadata.size());
    const bool split = options.chunks == ChunkSize::kSplit ||
                       (options.chunks == ChunkSize::kAuto && sliced.sample_count() >= kSplitFrom);
    index_.layout = split ? split_layout(lattice_, sliced.sample_count()) : whole_layout();
    blocks_ = make_blocks(lattice_, index_.layout);
    plan_ = plan_crossings(lattice_, blocks_);
    for (const std::uint32_t count : sliced.sample_counts) first_sample_.push_back(first_sample_.back() + count);
    make_steps(options.precision);
  }

  std::vector<std::byte> run() {
    choose_parameters();
    std::vector<std::vector<Event>> events = record_all();
    index_.distributions = choose_distributions(events).distributions;
    std::vector<std::byte> chunks;
    const auto append = [&](std::span<const std::byte> payload) {
      const std::size_t before = chunks.size();
      append_chunk(chunks, payload);
      index_.chunk_sizes.push_back(static_cast<std::uint32_t>(chunks.size() - before));
    };
    append(packed_metadata());
    for (const std::vector<Event>& chunk : events) append(encode(chunk));
    return emit_container(emit_index(index_), chunks);
  }

  CodingCost cost() {
    choose_parameters();
    const std::vector<std::vector<Event>> events = record_all();
    index_.distributions = choose_distributions(events).distributions;
    std::map<std::pair<bool, unsigned>, std::map<std::int64_t, double>> counts;
    CodingCost cost;
    double bits = 0;
    for (const std::vector<Event>& chunk : events) {
      cost.stream_bytes += encode(chunk).size();
      for (const Event& event : chunk) {
        const Token token = token_of(event.value);
        ++counts[{event.flag, event.context}][event.flag ? event.value : token.index];
        bits += event.flag ? 0 : token.bit_count;
      }
    }
    for (const auto& [context, symbols] : counts) {
      double total = 0;
      for (const auto& [symbol, count] : symbols) total += count;
      for (const auto& [symbol, count] : symbols) bits += count * std::log2(total / count);
    }
    cost.entropy_bytes = bits / 8;
    return cost;
  }

 private:
  void make_steps(double precision) {
    Scaled scaled = scale_values(sliced_, precision);
    index_.scale = scaled.scale;
    crossing_steps_ = std::move(scaled.crossing_steps);
    sample_steps_ = std::move(scaled.sample_steps);
    SlicedBrdf kept;  // as it will come back
    kept.channels = sliced_.channels;
    kept.crossing_values = std::move(scaled.crossing_values);
    kept.sample_values = std::move(scaled.sample_values);
    index_.ranges = value_ranges(kept);
    if (sliced_.guide) {
      index_.guided = true;
      index_.guide_ratio = sliced_.guide->ratio;
      index_.guide_count = static_cast<std::uint32_t>(sliced_.guide->places.size());
    }
    take_off_guide();
  }

  void take_off_guide() {
    if (!sliced_.guide) return;
    Guide guide = *sliced_.guide;
    for (float& v : guide.values) v = guide_value(index_.scale, guide_step(index_.scale, v));
    const GuideSteps offsets(guide, lattice_, channels_, index_.scale);
    for (std::size_t k = 0; k < lattice_.crossings.size(); ++k) {
      offsets.take_off(lattice_.crossings[k], std::span(crossing_steps_).subspan(k * channels_, channels_));
    }
    std::size_t next = 0;
    for (std::size_t k = 0; k < lattice_.slices.size(); ++k) {
      const Slice& slice = lattice_.slices[k];
      for (std::uint32_t s = 0; s < sliced_.sample_counts[k]; ++s, ++next) {
        offsets.take_off(coordinates_on(slice, position_deg(lattice_, slice, sliced_.positions[next])),
                         std::span(sample_steps_).subspan(next * channels_, channels_));
      }
    }
  }

  // Which channel is predicted first, and how activities are scaled: tried on a part of the samples.
  void choose_parameters() {
    const std::uint32_t candidates = std::min<std::uint32_t>(static_cast<std::uint32_t>(channels_), 3);
    const std::vector<std::uint32_t> shifts =
        index_.scale.lossless() ? std::vector<std::uint32_t>{8, 10, 12, 14} : std::vector<std::uint32_t>{0, 2};
    constexpr std::size_t kFewSamples = 500;
    const bool on_slices = sliced_.adaptive_count() >= kFewSamples;
    index_.activity_shift = shifts.front();
    std::vector<std::vector<Event>> crossings(blocks_.crossings.size());
    record_crossings(crossings);  // slices are predicted from them
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t best_base = 0;
    std::uint32_t best_shift = shifts.front();
    const auto try_out = [&](std::uint32_t base, std::uint32_t shift) {
      index_.base_channel = base;
      index_.activity_shift = shift;
      std::vector<std::vector<Event>> events(blocks_.crossings.size());
      on_slices ? record_some_slices(events.front()) : record_crossings(events);
      const std::uint64_t cost = choose_distributions(events).cost_256;
      if (cost >= least) return;
      least = cost;
      best_base = base;
      best_shift = shift;
    };
    for (std::uint32_t base = 0; base < candidates; ++base) try_out(base, shifts.front());
    for (std::size_t k = 1; k < shifts.size(); ++k) try_out(best_base, shifts[k]);
    index_.base_channel = best_base;
    index_.activity_shift = best_shift;
  }

  // In the order of ChunkOrder, from the guide on.
  std::vector<std::vector<Event>> record_all() {
    std::vector<std::vector<Event>> events(1 + blocks_.crossings.size());
    record_guide(events[0]);
    std::vector<std::vector<Event>> crossings(blocks_.crossings.size());
    record_crossings(crossings);
    std::move(crossings.begin(), crossings.end(), events.begin() + 1);
    const std::size_t pieces = index_.layout.piece_depths.size();
    const ChunkOrder order(blocks_, pieces);
    events.resize(order.count() - 1);  // metadata are no events
    for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
      for (std::size_t block = 0; block < blocks_.slices[kind].size(); ++block) {
        record_slices(blocks_.slices[kind][block], [&](std::size_t piece) -> std::vector<Event>& {
          return events[order.slices(piece, kind, block) - 1];
        });
      }
    }
    return events;
  }

  void record_crossings(std::vector<std::vector<Event>>& events) {
    for (std::size_t k = 0; k < lattice_.crossings.size(); ++k) {
      std::copy_n(crossing_steps_.data() + k * channels_, channels_, crossings_.steps(k));
    }
    for (std::uint32_t block = 0; block < blocks_.crossings.size(); ++block) {
      Recorder recorder(events[block]);
      code_crossings(recorder, index_.coding(), plan_, block, crossings_);
    }
  }

  void record_some_slices(std::vector<Event>& events) {
    constexpr std::size_t kEnough = 1000;
    std::vector<std::uint32_t> some;
    std::size_t samples = 0;
    const std::size_t step = std::max<std::size_t>(1, sliced_.adaptive_count() / kEnough);
    for (std::size_t k = 0; k < lattice_.slices.size() && samples < kEnough; k += step) {
      samples += sliced_.sample_counts[k];
      some.push_back(static_cast<std::uint32_t>(k));
    }
    record_slices(some, [&](std::size_t) -> std::vector<Event>& { return events; });
  }

  // Pieces without a sample stay without an event.
  template <class EventsOf>
  void record_slices(const std::vector<std::uint32_t>& block, const EventsOf& events_of) {
    const std::size_t pieces = index_.layout.piece_depths.size();
    std::vector<bool> used(pieces, false);
    for (const std::uint32_t k : block) {
      for (std::size_t s = first_sample_[k]; s < first_sample_[k + 1]; ++s) {
        const auto after = std::upper_bound(index_.layout.piece_depths.begin(), index_.layout.piece_depths.end(),
                                            depth_of(sliced_.positions[s].fraction));
        used[static_cast<std::size_t>(after - index_.layout.piece_depths.begin()) - 1] = true;
      }
    }
    const CodingParameters coding = index_.coding();
    for (const std::uint32_t k : block) {
      const Slice& slice = lattice_.slices[k];
      const std::size_t first = first_sample_[k];
      const std::size_t count = sliced_.sample_counts[k];
      const SamplesToEncode samples = {std::span(sliced_.positions).subspan(first, count),
                                       std::span(sample_steps_).subspan(first * channels_, count * channels_)};
      begin_slice(lattice_, slice, crossings_, state_);
      for (std::size_t piece = 0; piece < pieces; ++piece) {
        if (!used[piece]) continue;
        Recorder recorder(events_of(piece));
        const auto [first_depth, end_depth] = depths_of_piece(index_.layout, piece);
        for (int depth = first_depth; depth < end_depth; ++depth) {
          code_depth(
              recorder, coding, depth, state_,
              [&](const SamplePosition& place) { return position_deg(lattice_, slice, place); }, &samples,
              CodingContext::kSampleBase, CodingContext::kSampleOther);
        }
      }
    }
  }

  void record_guide(std::vector<Event>& events) {
    if (!sliced_.guide) return;
    const Guide& guide = *sliced_.guide;
    StepTable nodes(channels_);
    nodes.hold(lattice_.nodes[kVertical].size());
    std::size_t node = 0;
    std::vector<SamplePosition> places;
    std::vector<std::int32_t> samples;
    std::vector<std::int32_t> steps(channels_);
    for (std::size_t k = 0; k < guide.places.size(); ++k) {
      for (std::size_t c = 0; c < channels_; ++c) {
        steps[c] = guide_step(index_.scale, guide.values[k * channels_ + c]);
      }
      if (guide.places[k].fraction == 0) {
        std::copy(steps.begin(), steps.end(), nodes.steps(node++));
      } else {
        places.push_back(guide.places[k]);
        samples.insert(samples.end(), steps.begin(), steps.end());
      }
    }
    Recorder recorder(events);
    code_guide_nodes(recorder, index_.coding(), node, nodes);
    SliceSteps state(channels_);
    begin_guide(lattice_, nodes, state);
    const SamplesToEncode wanted = {places, samples};
    for (int depth = 1; depth <= kMaxDepth; ++depth) {
      code_depth(
          recorder, index_.coding(), depth, state,
          [&](const SamplePosition& place) { return guide_position_deg(lattice_.nodes[kVertical], place); }, &wanted,
          CodingContext::kGuideSample, CodingContext::kGuideSample, false);
    }
  }

  std::vector<std::byte> encode(const std::vector<Event>& events) {
    if (events.empty()) return {};
    if (distributions_.empty()) {
      for (const std::uint8_t number : index_.distributions.residuals) {
        distributions_.push_back(number == Distributions::kUnused
                                     ? Distribution()
                                     : make_distribution(number, index_.distributions.token_count));
      }
    }
    RansEncoder out;
    for (auto event = events.rbegin(); event != events.rend(); ++event) {
      if (event->flag) {
        const std::uint32_t yes = 16U * index_.distributions.flags[event->context];
        event->value != 0 ? out.put(0, yes) : out.put(yes, kProbabilityOne - yes);
        continue;
      }
      const Token token = token_of(event->value);
      const Distribution& distribution = distributions_[event->context];
      out.put_bits(token.bits, token.bit_count);
      out.put(distribution.start[token.index], distribution.frequency[token.index]);
    }
    return out.finish();
  }

  [[nodiscard]] std::vector<std::byte> packed_metadata() const {
    if (sliced_.metadata.empty()) return {};
    return pack_metadata(sliced_.metadata);
  }

  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  std::size_t channels_;
  SlicedIndex index_;
  LatticeBlocks blocks_;
  CrossingPlan plan_;
  std::vector<std::int32_t> crossing_steps_;
  std::vector<std::int32_t> sample_steps_;
  std::vector<std::size_t> first_sample_ = {0};  ///< of each slice, one entry more
  StepTable crossings_;
  SliceSteps state_;
  std::vector<Distribution> distributions_;
};

}  // namespace

std::vector<std::byte> encode_sliced(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options) {
  return Encoder(sliced, lattice, options).run();
}

CodingCost coding_cost(const SlicedBrdf& sliced, const Lattice& lattice, const EncodeOptions& options) {
  return Encoder(sliced, lattice, options).cost();
}

Result<DecodedSliced> decode_sliced(std::span<const std::byte> bytes) {
  const MemorySource source(bytes);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  if (!reader) return reader.error();
  Result<SlicedBrdf> sliced = reader->load_all();
  if (!sliced) return sliced.error();
  return DecodedSliced{std::move(sliced).value(), reader->lattice(), reader->version(), reader->index().scale.bound()};
}

}  // namespace sbrdf::internal
