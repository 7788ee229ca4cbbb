#include "codec/file/recorder.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "codec/coding/guide_steps.h"
#include "codec/coding/sample_coder.h"

namespace sbrdf::internal {

SampleRecorder::SampleRecorder(const SlicedBrdf& sliced, const Lattice& lattice, const Scaled& scaled,
                               const ChunkLayout& layout)
    : sliced_(sliced),
      lattice_(lattice),
      scaled_(scaled),
      layout_(layout),
      channels_(sliced.channel_count()),
      blocks_(make_blocks(lattice, layout)),
      plan_(plan_crossings(lattice, blocks_)),
      crossings_(channels_),
      slice_(channels_) {
  for (const std::uint32_t count : sliced.sample_counts) first_sample_.push_back(first_sample_.back() + count);
  crossings_.hold(lattice.crossings.size());
  for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
    std::copy_n(scaled.crossing_steps.data() + k * channels_, channels_, crossings_.steps(k));
  }
}

std::vector<ChunkEvents> SampleRecorder::record_all(const CodingParameters& coding) {
  std::vector<ChunkEvents> events = {record_guide(coding)};
  std::vector<ChunkEvents> crossings = record_crossings(coding);
  std::move(crossings.begin(), crossings.end(), std::back_inserter(events));
  const std::size_t pieces = layout_.piece_depths.size();
  const ChunkOrder order(blocks_, pieces);
  events.resize(order.count());
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    for (std::size_t block = 0; block < blocks_.slices[kind].size(); ++block) {
      std::vector<ChunkEvents> recorded = record_slices(blocks_.slices[kind][block], coding);
      for (std::size_t piece = 0; piece < pieces; ++piece) {
        events[order.slices(piece, kind, block)] = std::move(recorded[piece]);
      }
    }
  }
  if (!layout_.whole) return events;
  std::size_t count = 0;
  for (const ChunkEvents& of_stream : events) count += of_stream.size();
  events.front().reserve(count);
  for (std::size_t k = 1; k < events.size(); ++k) {
    events.front().insert(events.front().end(), events[k].begin(), events[k].end());
  }
  events.resize(1);
  return events;
}

std::vector<ChunkEvents> SampleRecorder::record_crossings(const CodingParameters& coding) {
  std::vector<ChunkEvents> events(blocks_.crossings.size());
  for (std::uint32_t block = 0; block < events.size(); ++block) {
    events[block].reserve(blocks_.crossings[block].size() * channels_);
    EventRecorder recorder(events[block]);
    code_crossings(recorder, coding, plan_, block, crossings_);
  }
  return events;
}

std::vector<ChunkEvents> SampleRecorder::record_some_slices(const CodingParameters& coding) {
  constexpr std::size_t kEnough = 1000;
  std::vector<std::uint32_t> some;
  std::size_t samples = 0;
  const std::size_t step = std::max<std::size_t>(1, sliced_.adaptive_count() / kEnough);
  for (std::size_t k = 0; k < lattice_.slices.size() && samples < kEnough; k += step) {
    samples += sliced_.sample_counts[k];
    some.push_back(static_cast<std::uint32_t>(k));
  }
  return record_slices(some, coding);
}

std::vector<bool> SampleRecorder::pieces_with_samples(std::span<const std::uint32_t> block) const {
  std::vector<bool> used(layout_.piece_depths.size(), layout_.whole && sliced_.adaptive_count() > 0);
  for (const std::uint32_t k : block) {
    for (std::size_t s = first_sample_[k]; s < first_sample_[k + 1]; ++s) {
      const auto after = std::upper_bound(layout_.piece_depths.begin(), layout_.piece_depths.end(),
                                          depth_of(sliced_.positions[s].fraction));
      used[static_cast<std::size_t>(after - layout_.piece_depths.begin()) - 1] = true;
    }
  }
  return used;
}

std::vector<ChunkEvents> SampleRecorder::record_slices(std::span<const std::uint32_t> block,
                                                       const CodingParameters& coding) {
  const std::vector<bool> used = pieces_with_samples(block);
  std::vector<ChunkEvents> pieces(used.size());
  // A flag for each gap between crossings and for both halves of what is halved: no more than these.
  if (pieces.size() == 1) {
    std::size_t count = 0;
    for (const std::uint32_t k : block) {
      count += lattice_.slices[k].interval_count() + sliced_.sample_counts[k] * (channels_ + 2);
    }
    pieces.front().reserve(count);
  }
  for (const std::uint32_t k : block) record_slice(k, used, coding, pieces);
  return pieces;
}

void SampleRecorder::record_slice(std::uint32_t k, const std::vector<bool>& used, const CodingParameters& coding,
                                  std::vector<ChunkEvents>& pieces) {
  const Slice& slice = lattice_.slices[k];
  const std::size_t first = first_sample_[k];
  const std::size_t count = sliced_.sample_counts[k];
  const SamplesToWrite samples(std::span(sliced_.positions).subspan(first, count),
                               std::span(scaled_.sample_steps).subspan(first * channels_, count * channels_));
  const SliceCoding slice_coding = {coding, kSampleContexts,
                                    [&](const SamplePosition& place) { return position_deg(lattice_, slice, place); }};
  begin_slice(lattice_, slice, crossings_, slice_);
  for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
    if (!used[piece]) continue;
    EventRecorder recorder(pieces[piece]);
    const auto [first_depth, end_depth] = depths_of_piece(layout_, piece);
    for (int depth = first_depth; depth < end_depth; ++depth) {
      code_depth(recorder, slice_coding, depth, slice_, samples);
    }
  }
}

ChunkEvents SampleRecorder::record_guide(const CodingParameters& coding) const {
  ChunkEvents events;
  if (!sliced_.guide) return events;
  const Guide& guide = *sliced_.guide;
  StepTable nodes(channels_);
  nodes.hold(lattice_.nodes[kVertical].size());
  std::size_t node = 0;
  std::vector<SamplePosition> places;
  std::vector<std::int32_t> steps;
  for (std::size_t k = 0; k < guide.places.size(); ++k) {
    const bool at_node = guide.places[k].fraction == 0;
    if (!at_node) places.push_back(guide.places[k]);
    for (std::size_t c = 0; c < channels_; ++c) {
      const std::int32_t step = guide_step(scaled_.scale, guide.values[k * channels_ + c]);
      at_node ? void(nodes.steps(node)[c] = step) : steps.push_back(step);
    }
    node += at_node ? 1 : 0;
  }
  EventRecorder recorder(events);
  code_guide_nodes(recorder, coding, node, nodes);
  SliceSteps state(channels_);
  begin_guide(lattice_, nodes, state);
  const SliceCoding guide_coding = {coding, kGuideSampleContexts, [&](const SamplePosition& place) {
                                      return guide_position_deg(lattice_.nodes[kVertical], place);
                                    }};
  for (int depth = 1; depth <= kMaxDepth; ++depth) {
    code_depth(recorder, guide_coding, depth, state, SamplesToWrite(places, steps));
  }
  return events;
}

}  // namespace sbrdf::internal
