#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// What the header of an NPY file says (specs/npy.md): one array of floats, little-endian, right behind the header.
struct NpyHeader {
  std::size_t number_size = 4;       ///< bytes of one number: 2, 4 or 8, a float each time
  bool fortran_order = false;        ///< the first axis is the fastest; else the last
  std::vector<std::uint64_t> shape;  ///< may be empty: a single number
  std::uint64_t data_offset = 0;     ///< of the first number [bytes]

  /// Product of the shape; cannot wrap in a header that was parsed.
  [[nodiscard]] std::uint64_t number_count() const;
};

/// Longest header that is read [bytes]; arrays of floats need some 100.
inline constexpr std::size_t kNpyLongestHeader = 65536;

/// The file begins as an NPY file does.
[[nodiscard]] bool recognises_npy(std::span<const std::byte> head);

/// `start` are the first kNpyLongestHeader bytes of the file, or all where there are fewer. Versions 1.0, 2.0 and 3.0.
///
/// kInvalidFile where this is no NPY file, where the header is cut off or is not the dictionary that it has to be
/// (with the place in it), and where the size of the file is not just that of the array. kUnsupported for other
/// versions, longer headers, big-endian numbers, objects of Python (pickled), records, and numbers that are no floats
/// of 16, 32 or 64 bits; the message names them.
[[nodiscard]] Result<NpyHeader> parse_npy_header(std::span<const std::byte> start, std::uint64_t file_size);

/// The header of a little-endian array in C order, as NumPy writes it: version 1.0, padded so that the numbers begin at
/// a multiple of 64 bytes.
[[nodiscard]] std::vector<std::byte> emit_npy_header(std::size_t number_size, std::span<const std::uint64_t> shape);

}  // namespace sbrdf::internal
