#include "converters/audit/codings.h"

#include <zstd.h>

#include <cmath>
#include <span>

#include "codec/coding/quantizer.h"
#include "codec/file/encoder.h"

namespace sbrdf::internal {
namespace {

constexpr int kZstdLevel = 3;

std::uint64_t packed_size(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> packed(ZSTD_compressBound(bytes.size()));
  return ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel);
}

/// Bytes of equal weight together.
template <class T>
std::vector<std::uint8_t> shuffled(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes;
  for (unsigned weight = 0; weight < sizeof(T); ++weight) {
    for (const T v : values) bytes.push_back(static_cast<std::uint8_t>(v >> (8 * weight)));
  }
  return bytes;
}

}  // namespace

std::uint64_t baseline_size(const SlicedBrdf& sliced, double bound) {
  std::vector<float> values = sliced.crossing_values;
  values.insert(values.end(), sliced.sample_values.begin(), sliced.sample_values.end());
  Quantizer scale(bound);
  scale.begin_at_smallest({values});
  const std::size_t channels = sliced.channel_count();
  std::vector<std::uint32_t> differences;
  for (std::size_t c = 0; c < channels; ++c) {
    std::int32_t last = 0;
    for (std::size_t k = c; k < values.size(); k += channels) {
      const std::int32_t step = scale.step(values[k]);
      const std::int32_t difference = step - last;
      differences.push_back(static_cast<std::uint32_t>(difference) << 1U ^ (difference < 0 ? 0xFFFFFFFFU : 0U));
      last = step;
    }
  }
  std::vector<std::uint16_t> places;
  for (const SamplePosition& place : sliced.positions) places.push_back(static_cast<std::uint16_t>(place.interval));
  for (const SamplePosition& place : sliced.positions) places.push_back(static_cast<std::uint16_t>(place.fraction));
  for (const std::uint32_t count : sliced.sample_counts) places.push_back(static_cast<std::uint16_t>(count));
  return packed_size(shuffled(differences)) + packed_size(shuffled(places));
}

CodingSizes coding_sizes(const std::string& material, const SlicedBrdf& sliced, const Lattice& lattice) {
  constexpr double kTenthPercent = 0.001;
  CodingSizes row;
  row.material = material;
  row.samples = sliced.sample_count();
  row.values = row.samples * sliced.channel_count();
  row.raw = 4 * row.values + 4 * sliced.adaptive_count();
  row.lossless = encode_sliced(sliced, lattice).size();
  row.tenth_percent = encode_sliced(sliced, lattice, {kTenthPercent}).size();
  row.one_percent = encode_sliced(sliced, lattice, {0.01}).size();
  row.baseline = baseline_size(sliced, kTenthPercent);
  const CodingCost cost = coding_cost(sliced, lattice, {kTenthPercent});
  row.stream = cost.stream_bytes;
  row.entropy = cost.entropy_bytes;
  return row;
}

}  // namespace sbrdf::internal
