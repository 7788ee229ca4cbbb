// Writes what the decoder makes of a file, for comparison with the reference decoder (specs/reference/).
//
// usage: dump_sliced FILE VALUES_OUT POSITIONS_OUT
//   VALUES_OUT     float32: crossings by number, then samples slice by slice, then the guide's; channel fastest
//   POSITIONS_OUT  u32: number of samples of each slice, then interval and fraction of every sample, then of the
//   guide's; with a mask its frame, the cells along its axes, and the lengths of its runs, measured cells first
// Exit codes: 0 ok, 2 a file cannot be read or written, 3 refused, 4 unsupported, with the message on stderr.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "codec/file/encoder.h"

namespace sbrdf::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void append(std::string& out, std::span<const T> numbers) {
  out.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
}

std::string values_of(const SlicedBrdf& sliced) {
  std::string out;
  append<float>(out, sliced.crossing_values);
  append<float>(out, sliced.sample_values);
  if (sliced.guide) append<float>(out, sliced.guide->values);
  return out;
}

void append_places(std::vector<std::uint32_t>& out, std::span<const SamplePosition> places) {
  for (const SamplePosition& place : places) {
    out.push_back(place.interval);
    out.push_back(place.fraction);
  }
}

void append_mask(std::vector<std::uint32_t>& out, const DirectionMask& mask) {
  out.push_back(static_cast<std::uint32_t>(mask.grid.frame));
  out.insert(out.end(), mask.grid.counts.begin(), mask.grid.counts.end());
  out.push_back(0);
  bool unmeasured = false;
  for (const bool bit : mask.unmeasured) {
    if (bit != unmeasured) out.push_back(0);
    unmeasured = bit;
    ++out.back();
  }
}

std::string positions_of(const SlicedBrdf& sliced) {
  std::vector<std::uint32_t> numbers = sliced.sample_counts;
  append_places(numbers, sliced.positions);
  if (sliced.guide) append_places(numbers, sliced.guide->places);
  if (sliced.mask) append_mask(numbers, *sliced.mask);
  std::string out;
  append<std::uint32_t>(out, numbers);
  return out;
}

bool save(const char* path, const std::string& content) {
  std::ofstream file(path, std::ios::binary);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  return static_cast<bool>(file.flush());
}

int dump(const char* path, const char* values_path, const char* positions_path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::cerr << path << " cannot be read\n";
    return static_cast<int>(ErrorCode::kIo);
  }
  const std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Result<DecodedSliced> decoded = decode_sliced(std::as_bytes(std::span(content)));
  if (!decoded.ok()) {
    std::cerr << decoded.error().message << '\n';
    return static_cast<int>(decoded.error().code);
  }
  const SlicedBrdf& sliced = decoded.value().sliced;
  if (!save(values_path, values_of(sliced)) || !save(positions_path, positions_of(sliced))) {
    std::cerr << "an output cannot be written\n";
    return static_cast<int>(ErrorCode::kIo);
  }
  return 0;
}

}  // namespace
}  // namespace sbrdf::internal

int main(int count, char** arguments) {
  if (count != 4) {
    std::cerr << "usage: dump_sliced FILE VALUES_OUT POSITIONS_OUT\n";
    return static_cast<int>(sbrdf::internal::ErrorCode::kUsage);
  }
  try {
    return sbrdf::internal::dump(arguments[1], arguments[2], arguments[3]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(sbrdf::internal::ErrorCode::kIo);
  }
}
