#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/coding/value_scaling.h"
#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/lazy_evaluator.h"
#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "codec/frame/cells.h"
#include "formats/core/byte_source.h"
#include "tests/fuzz/sliced_file.h"

namespace sbrdf::internal::fuzzing {
namespace {

// The scale of a finer bound takes long to make.
constexpr double kFinestBound = 1e-3;

// One that the file's bytes choose.
DirectionPair some_pair(const Bytes& file) {
  const std::uint32_t bits = checksum(file);
  const auto angle = [&](unsigned shift, double most) { return ((bits >> shift) & 0xFFU) / 255.0 * most; };
  return {direction_from_degrees(angle(0, 90), angle(8, 360)), direction_from_degrees(angle(16, 90), angle(24, 360))};
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v); };
  return std::ranges::equal(a, b, {}, bits, bits);
}

bool same_samples(const SlicedBrdf& a, const SlicedBrdf& b) {
  return a.frame == b.frame && a.domain == b.domain && a.channels == b.channels && a.metadata == b.metadata &&
         a.sample_counts == b.sample_counts && a.positions == b.positions &&
         same_bits(a.crossing_values, b.crossing_values) && same_bits(a.sample_values, b.sample_values) &&
         a.guide == b.guide;
}

void write_again(const DecodedSliced& decoded, const EncodeOptions& options) {
  SlicedBrdf expected = decoded.sliced;
  round_to_precision(expected, options.precision);
  const Result<DecodedSliced> again = decode_sliced(encode_sliced(decoded.sliced, decoded.lattice, options));
  require(again.ok(), "what was decoded can be written and decoded again");
  require(same_samples(again->sliced, expected), "what was decoded comes back as round_to_precision says");
}

void check_depths(const SlicedReader& reader, const DecodedSliced& decoded) {
  const Result<SlicedBrdf> coarse = reader.load_all(2);
  require(coarse.ok(), "what decodes does so down to a depth");
  require(same_bits(coarse->crossing_values, decoded.sliced.crossing_values), "crossings are the same at every depth");
  std::size_t expected = 0;
  for (const SamplePosition& place : decoded.sliced.positions) expected += depth_of(place.fraction) <= 2 ? 1 : 0;
  require(coarse->adaptive_count() == expected, "all samples down to the depth are there");
}

void check_cell(const PartialSliced& part, const DecodedSliced& decoded, const DirectionPair& pair) {
  std::vector<float> values(decoded.sliced.channel_count());
  std::vector<float> expected(values.size());
  require(part.evaluate(pair, values).ok(), "a pair in a loaded cell can be evaluated");
  Evaluator(decoded.sliced, decoded.lattice).evaluate(pair, expected);
  require(same_bits(values, expected), "a loaded cell has the values of the whole file");
}

// A pair alone has tables of its own; they give what the whole gives.
void check_vectors(const DecodedSliced& decoded, const DirectionPair& pair) {
  const glm::vec3 i(vector_from_direction(pair.i));
  const glm::vec3 v(vector_from_direction(pair.v));
  std::vector<float> values(decoded.sliced.channel_count());
  std::vector<float> expected(values.size());
  const LazyEvaluator lazy(decoded.sliced, decoded.lattice);
  lazy.evaluate(std::span(&i, 1), std::span(&v, 1), values);
  lazy.whole().evaluate(std::span(&v, 1), std::span(&i, 1), expected);
  require(same_bits(values, expected), "tables of a pair have the values of those of the whole");
}

}  // namespace

void exercise_sliced(const Bytes& file) {
  const MemorySource source(file);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  const Result<DecodedSliced> decoded = decode_sliced(file);
  if (!reader) {
    require(!decoded.ok(), "what cannot be opened does not decode");
    return;
  }
  const DirectionPair pair = some_pair(file);
  const Result<PartialSliced> part = reader->load(cells_of(reader->lattice(), std::span(&pair, 1)));
  if (part) {
    std::vector<float> values(reader->index().channels.size());
    require(part->evaluate(pair, values).ok(), "a pair in a loaded cell can be evaluated");
  }
  if (!decoded) {
    // A damaged part may lie beyond what these need: they only must not fail badly.
    (void)reader->load_all(2).ok();
    (void)reader->metadata().ok();
    return;
  }
  require(check_sliced(decoded->sliced, decoded->lattice).ok(), "what decodes holds what sliced BRDFs must");
  check_depths(*reader, *decoded);
  require(part.ok(), "a cell of what decodes can be loaded");
  check_cell(*part, *decoded, pair);
  check_vectors(*decoded, pair);
  // Writing is slow: in one way, which the file's bytes choose.
  const std::uint32_t bits = checksum(file);
  const bool bounded = (bits & 2U) != 0 && decoded->precision >= kFinestBound && decoded->precision <= 0.5;
  write_again(*decoded, {bounded ? decoded->precision : 0, (bits & 1U) != 0 ? ChunkSize::kSplit : ChunkSize::kWhole});
}

}  // namespace sbrdf::internal::fuzzing
