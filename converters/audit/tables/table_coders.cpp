#include "converters/audit/tables/table_coders.h"

#include <blosc.h>
#include <fmt/format.h>
#include <fpzip.h>
#include <zfp.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kStepCount = 37;
constexpr int kZstdLevel = 19;
constexpr int kBloscLevel = 9;

template <class T>
void append(Bytes& bytes, const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof(T));
}

/// Takes what append() wrote; false where nothing is left.
template <class T>
bool take(std::span<const std::byte>& bytes, T& value) {
  if (bytes.size() < sizeof(T)) return false;
  std::memcpy(&value, bytes.data(), sizeof(T));
  bytes = bytes.subspan(sizeof(T));
  return true;
}

Error refused(std::string_view who) { return invalid_file(std::string(who) + " refuses its own bytes"); }

// Logarithms in whole steps, for compressors that lose nothing.

/// From 1/2 to 1/1024, four to a halving.
double step_of(std::size_t setting) { return std::exp2(-1 - 0.25 * static_cast<double>(setting)); }

std::string step_text(std::size_t setting) { return fmt::format("steps of {:.3g} %", 100 * step_of(setting)); }

std::vector<std::int32_t> in_steps(const std::vector<float>& plane, double step) {
  std::vector<std::int32_t> steps;
  steps.reserve(plane.size());
  for (const float value : plane) steps.push_back(static_cast<std::int32_t>(std::lround(value / step)));
  return steps;
}

Planes in_whole_steps(const LogTable& table, std::size_t setting) {
  Planes planes;
  const double step = step_of(setting);
  for (const std::vector<float>& plane : table.planes) {
    std::vector<float>& rounded = planes.emplace_back();
    for (const std::int32_t s : in_steps(plane, step)) rounded.push_back(static_cast<float>(s * step));
  }
  return planes;
}

/// How whole numbers lie in bytes: differences from one to the next or not, two bytes each or four.
struct Packing {
  std::uint8_t differences = 0;
  std::uint8_t width = 2;
};

std::uint32_t folded(std::int32_t value) {
  return static_cast<std::uint32_t>(value) << 1U ^ (value < 0 ? 0xFFFFFFFFU : 0U);
}
std::int32_t unfolded(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1U) ^ -static_cast<std::int32_t>(value & 1U);
}

/// Little-endian numbers one after the other.
Bytes packed(const std::vector<std::int32_t>& steps, Packing& packing) {
  std::vector<std::uint32_t> numbers;
  std::int32_t last = 0;
  for (const std::int32_t s : steps) {
    numbers.push_back(folded(packing.differences != 0 ? s - last : s));
    last = s;
  }
  packing.width = std::all_of(numbers.begin(), numbers.end(), [](std::uint32_t n) { return n < 65'536; }) ? 2 : 4;
  Bytes bytes;
  for (const std::uint32_t n : numbers) {
    for (unsigned k = 0; k < packing.width; ++k) bytes.push_back(static_cast<std::byte>(n >> 8 * k));
  }
  return bytes;
}

std::vector<std::int32_t> unpacked(std::span<const std::byte> bytes, const Packing& packing) {
  std::vector<std::int32_t> steps;
  std::int32_t last = 0;
  for (std::size_t at = 0; at + packing.width <= bytes.size(); at += packing.width) {
    std::uint32_t n = 0;
    for (unsigned k = 0; k < packing.width; ++k) n |= static_cast<std::uint32_t>(bytes[at + k]) << 8 * k;
    last = packing.differences != 0 ? last + unfolded(n) : unfolded(n);
    steps.push_back(last);
  }
  return steps;
}

/// Bytes of equal weight together, and back.
Bytes shuffled(std::span<const std::byte> bytes, std::size_t width) {
  Bytes result(bytes.size());
  const std::size_t count = bytes.size() / width;
  for (std::size_t k = 0; k < bytes.size(); ++k) result[k % width * count + k / width] = bytes[k];
  return result;
}
Bytes unshuffled(std::span<const std::byte> bytes, std::size_t width) {
  Bytes result(bytes.size());
  const std::size_t count = bytes.size() / width;
  for (std::size_t k = 0; k < bytes.size(); ++k) result[k] = bytes[k % width * count + k / width];
  return result;
}

/// Each plane packed both ways; the smaller one is kept: packing, size, stream.
template <class Compress>
Bytes encode_steps(const LogTable& table, std::size_t setting, const Compress& compress) {
  Bytes bytes;
  append(bytes, static_cast<float>(step_of(setting)));
  for (const std::vector<float>& plane : table.planes) {
    const std::vector<std::int32_t> steps = in_steps(plane, step_of(setting));
    Bytes best;
    Packing how;
    for (const std::uint8_t differences : {std::uint8_t{0}, std::uint8_t{1}}) {
      Packing packing = {differences, 2};
      const Bytes plain = packed(steps, packing);
      Bytes stream = compress(plain, packing.width);
      if (best.empty() || stream.size() < best.size()) {
        best = std::move(stream);
        how = packing;
      }
    }
    append(bytes, how);
    append(bytes, static_cast<std::uint32_t>(best.size()));
    bytes.insert(bytes.end(), best.begin(), best.end());
  }
  return bytes;
}

/// `decompress` fills as many bytes as it is given room for, or says no.
template <class Decompress>
Result<Planes> decode_steps(std::span<const std::byte> bytes, const LogTable& like, std::string_view who,
                            const Decompress& decompress) {
  float stored_step = 0;
  if (!take(bytes, stored_step)) return refused(who);
  // The same number as the encoder's: steps are powers of two to a quarter, of which a float keeps 24 bits.
  const double step = std::exp2(std::round(4 * std::log2(static_cast<double>(stored_step))) / 4);
  Planes planes;
  for (std::size_t c = 0; c < like.planes.size(); ++c) {
    Packing how;
    std::uint32_t size = 0;
    if (!take(bytes, how) || !take(bytes, size) || size > bytes.size()) return refused(who);
    if (how.width != 2 && how.width != 4) return refused(who);
    Bytes plain(like.node_count() * how.width);
    if (!decompress(bytes.first(size), plain, how.width)) return refused(who);
    bytes = bytes.subspan(size);
    std::vector<float>& plane = planes.emplace_back();
    for (const std::int32_t s : unpacked(plain, how)) plane.push_back(static_cast<float>(s * step));
  }
  return planes;
}

Bytes encode_zstd(const LogTable& table, std::size_t setting) {
  return encode_steps(table, setting, [](const Bytes& plain, std::size_t width) {
    const Bytes turned = shuffled(plain, width);
    Bytes stream(ZSTD_compressBound(turned.size()));
    stream.resize(ZSTD_compress(stream.data(), stream.size(), turned.data(), turned.size(), kZstdLevel));
    return stream;
  });
}

Result<Planes> decode_zstd(std::span<const std::byte> bytes, const LogTable& like) {
  return decode_steps(bytes, like, "zstd", [](std::span<const std::byte> stream, Bytes& plain, std::size_t width) {
    Bytes turned(plain.size());
    if (ZSTD_decompress(turned.data(), turned.size(), stream.data(), stream.size()) != turned.size()) return false;
    plain = unshuffled(turned, width);
    return true;
  });
}

Bytes encode_blosc(const LogTable& table, std::size_t setting) {
  return encode_steps(table, setting, [](const Bytes& plain, std::size_t width) {
    Bytes best;
    for (const int shuffle : {BLOSC_SHUFFLE, BLOSC_BITSHUFFLE}) {
      Bytes stream(plain.size() + BLOSC_MAX_OVERHEAD);
      const int size = blosc_compress_ctx(kBloscLevel, shuffle, width, plain.size(), plain.data(), stream.data(),
                                          stream.size(), "zstd", 0, 1);
      stream.resize(static_cast<std::size_t>(std::max(size, 0)));
      if (best.empty() || stream.size() < best.size()) best = std::move(stream);
    }
    return best;
  });
}

Result<Planes> decode_blosc(std::span<const std::byte> bytes, const LogTable& like) {
  return decode_steps(bytes, like, "Blosc", [](std::span<const std::byte> stream, Bytes& plain, std::size_t) {
    return blosc_decompress_ctx(stream.data(), plain.data(), plain.size(), 1) == static_cast<int>(plain.size());
  });
}

// zfp: a bound on the logarithms, which it keeps to by far.

constexpr std::size_t kZfpSettings = 18;
double zfp_tolerance(std::size_t setting) { return std::exp2(5 - static_cast<double>(setting)); }
std::string zfp_text(std::size_t setting) { return fmt::format("logarithms within {:.3g}", zfp_tolerance(setting)); }

using ZfpField = std::unique_ptr<zfp_field, void (*)(zfp_field*)>;
using ZfpStream = std::unique_ptr<zfp_stream, void (*)(zfp_stream*)>;
using BitStream = std::unique_ptr<bitstream, void (*)(bitstream*)>;

/// Axes of one node are left out.
ZfpField zfp_field_of(float* numbers, const std::array<std::uint32_t, 4>& n) {
  if (n[0] == 1) return {zfp_field_3d(numbers, zfp_type_float, n[3], n[2], n[1]), zfp_field_free};
  return {zfp_field_4d(numbers, zfp_type_float, n[3], n[2], n[1], n[0]), zfp_field_free};
}

Bytes encode_zfp(const LogTable& table, std::size_t setting) {
  Bytes bytes;
  append(bytes, static_cast<float>(zfp_tolerance(setting)));
  for (std::vector<float> plane : table.planes) {
    const ZfpField field = zfp_field_of(plane.data(), table.counts);
    const ZfpStream stream(zfp_stream_open(nullptr), zfp_stream_close);
    zfp_stream_set_accuracy(stream.get(), zfp_tolerance(setting));
    Bytes buffer(zfp_stream_maximum_size(stream.get(), field.get()));
    const BitStream bits(stream_open(buffer.data(), buffer.size()), stream_close);
    zfp_stream_set_bit_stream(stream.get(), bits.get());
    zfp_stream_rewind(stream.get());
    buffer.resize(zfp_compress(stream.get(), field.get()));
    append(bytes, static_cast<std::uint32_t>(buffer.size()));
    bytes.insert(bytes.end(), buffer.begin(), buffer.end());
  }
  return bytes;
}

Result<Planes> decode_zfp(std::span<const std::byte> bytes, const LogTable& like) {
  float tolerance = 0;
  if (!take(bytes, tolerance)) return refused("zfp");
  Planes planes;
  for (std::size_t c = 0; c < like.planes.size(); ++c) {
    std::uint32_t size = 0;
    if (!take(bytes, size) || size > bytes.size()) return refused("zfp");
    std::vector<float>& plane = planes.emplace_back(like.node_count());
    Bytes buffer(bytes.begin(), bytes.begin() + size);
    buffer.resize(buffer.size() + 64);  // it reads in words
    bytes = bytes.subspan(size);
    const ZfpField field = zfp_field_of(plane.data(), like.counts);
    const ZfpStream stream(zfp_stream_open(nullptr), zfp_stream_close);
    zfp_stream_set_accuracy(stream.get(), static_cast<double>(tolerance));
    const BitStream bits(stream_open(buffer.data(), buffer.size()), stream_close);
    zfp_stream_set_bit_stream(stream.get(), bits.get());
    zfp_stream_rewind(stream.get());
    if (zfp_decompress(stream.get(), field.get()) == 0) return refused("zfp");
  }
  return planes;
}

// fpzip: so many bits of each number. Numbers are moved to 16 and beyond, so that a bit means the same for most.

constexpr std::size_t kFpzipSettings = 17;
constexpr float kFpzipLeast = 16;
int fpzip_bits(std::size_t setting) { return static_cast<int>(setting) + 8; }
std::string fpzip_text(std::size_t setting) { return fmt::format("{} bits", fpzip_bits(setting)); }

void shape_fpzip(FPZ& fpz, const std::array<std::uint32_t, 4>& counts, int bits) {
  fpz.type = FPZIP_TYPE_FLOAT;
  fpz.prec = bits;
  fpz.nx = static_cast<int>(counts[3]);
  fpz.ny = static_cast<int>(counts[2]);
  fpz.nz = static_cast<int>(counts[1]);
  fpz.nf = static_cast<int>(counts[0]);
}

Bytes encode_fpzip(const LogTable& table, std::size_t setting) {
  Bytes bytes;
  append(bytes, static_cast<std::uint8_t>(fpzip_bits(setting)));
  for (std::vector<float> plane : table.planes) {
    const float moved = kFpzipLeast - *std::min_element(plane.begin(), plane.end());
    for (float& value : plane) value += moved;
    Bytes buffer(1024 + 8 * plane.size());
    FPZ* fpz = fpzip_write_to_buffer(buffer.data(), buffer.size());
    shape_fpzip(*fpz, table.counts, fpzip_bits(setting));
    buffer.resize(fpzip_write(fpz, plane.data()));
    fpzip_write_close(fpz);
    append(bytes, moved);
    append(bytes, static_cast<std::uint32_t>(buffer.size()));
    bytes.insert(bytes.end(), buffer.begin(), buffer.end());
  }
  return bytes;
}

Result<Planes> decode_fpzip(std::span<const std::byte> bytes, const LogTable& like) {
  std::uint8_t bits = 0;
  if (!take(bytes, bits)) return refused("fpzip");
  Planes planes;
  for (std::size_t c = 0; c < like.planes.size(); ++c) {
    float moved = 0;
    std::uint32_t size = 0;
    if (!take(bytes, moved) || !take(bytes, size) || size > bytes.size()) return refused("fpzip");
    std::vector<float>& plane = planes.emplace_back(like.node_count());
    FPZ* fpz = fpzip_read_from_buffer(bytes.data());
    shape_fpzip(*fpz, like.counts, bits);
    const bool whole = fpzip_read(fpz, plane.data()) != 0;
    fpzip_read_close(fpz);
    if (!whole) return refused("fpzip");
    bytes = bytes.subspan(size);
    for (float& value : plane) value -= moved;
  }
  return planes;
}

constexpr std::array kCoders = {
    TableCoder{"table, zstd", "value", kStepCount, step_text, in_whole_steps, encode_zstd, decode_zstd},
    TableCoder{"table, Blosc", "value", kStepCount, step_text, in_whole_steps, encode_blosc, decode_blosc},
    TableCoder{"table, zfp", "value", kZfpSettings, zfp_text, nullptr, encode_zfp, decode_zfp},
    TableCoder{"table, fpzip", "value", kFpzipSettings, fpzip_text, nullptr, encode_fpzip, decode_fpzip},
};

}  // namespace

std::span<const TableCoder> table_coders() { return kCoders; }

}  // namespace sbrdf::internal
