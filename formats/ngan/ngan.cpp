#include "formats/ngan/ngan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <string>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

constexpr std::array<const char*, 4> kAxisNames = {"theta_in", "theta_out", "phi_diff", "phi_in"};
// Places of the numbers in the header.
constexpr std::size_t kParameterisation = 6;
constexpr std::size_t kBinning = 7;
constexpr std::size_t kHalf = 9;
constexpr std::size_t kChannels = 10;

using Numbers = std::array<std::int32_t, kNganHeaderSize / sizeof(std::int32_t)>;

Error wrong(std::size_t place, const std::string& what, std::int32_t value, const std::string& must) {
  return invalid_file(fmt::format("{} of the anisotropic table is {}, must be {}", what, value, must),
                      place * sizeof(std::int32_t));
}

Result<Numbers> read_numbers(std::span<const std::byte> head) {
  ByteReader in(head);
  Numbers numbers{};
  for (std::int32_t& number : numbers) number = in.i32();
  if (in.ok()) return numbers;
  Error error = in.error();
  error.message = "header of the anisotropic table " + error.message;
  return error;
}

Result<NganHeader> check_numbers(const Numbers& numbers) {
  NganHeader header;
  // Compared one by one: a product of four hostile counts can wrap to the right number.
  for (std::size_t axis = 0; axis < header.counts.size(); ++axis) {
    if (numbers[axis] < 1 || numbers[axis] > std::int32_t{kNganMaxCount}) {
      return wrong(axis, std::string("count of ") + kAxisNames[axis], numbers[axis],
                   fmt::format("1 to {}", kNganMaxCount));
    }
    header.counts[axis] = static_cast<std::uint32_t>(numbers[axis]);
  }
  if (numbers[kHalf] != 0 && numbers[kHalf] != 1) return wrong(kHalf, "mark of half data", numbers[kHalf], "0 or 1");
  if (numbers[kChannels] < 1 || numbers[kChannels] > std::int32_t{kNganMaxChannels}) {
    return wrong(kChannels, "number of channels", numbers[kChannels], fmt::format("1 to {}", kNganMaxChannels));
  }
  header.half = numbers[kHalf] == 1;
  header.channels = static_cast<std::uint32_t>(numbers[kChannels]);
  return header;
}

bool is_standard(const Numbers& numbers) { return numbers[kParameterisation] == 1 && numbers[kBinning] == 0; }

bool is_bit(std::int32_t number) { return number == 0 || number == 1; }

}  // namespace

Result<NganHeader> parse_ngan_header(std::span<const std::byte> head, std::uint64_t file_size) {
  const Result<Numbers> numbers = read_numbers(head);
  if (!numbers) return numbers.error();
  Result<NganHeader> header = check_numbers(*numbers);
  if (!header) return header.error();
  if (!is_standard(*numbers)) {
    return unsupported(
        fmt::format("an anisotropic table of parameterisation {} and binning {}; only 1 and 0 can be read",
                    (*numbers)[kParameterisation], (*numbers)[kBinning]),
        kParameterisation * sizeof(std::int32_t));
  }
  const std::uint64_t expected = ngan_file_size(*header);
  if (file_size == expected) return header;
  return invalid_file(
      fmt::format("{} anisotropic table: {} bins of {} channel{} need {} bytes, the file has {}",
                  file_size < expected ? "truncated" : "bytes after the end of the", fmt::join(header->counts, " x "),
                  header->channels, header->channels == 1 ? "" : "s", expected, file_size),
      std::min(file_size, expected));
}

bool recognises_ngan(std::span<const std::byte> head, std::uint64_t file_size) {
  const Result<Numbers> numbers = read_numbers(head);
  if (!numbers || !is_bit((*numbers)[kParameterisation]) || !is_bit((*numbers)[kBinning])) return false;
  const Result<NganHeader> header = check_numbers(*numbers);
  return header.ok() && file_size == ngan_file_size(*header);
}

bool resembles_ngan(std::span<const std::byte> head) {
  const Result<Numbers> numbers = read_numbers(head);
  return numbers.ok() && is_standard(*numbers) && check_numbers(*numbers).ok();
}

std::array<std::byte, kNganHeaderSize> emit_ngan_header(const NganHeader& header) {
  Numbers numbers{};
  std::copy(header.counts.begin(), header.counts.end(), numbers.begin());
  numbers[kParameterisation] = 1;
  numbers[kHalf] = header.half ? 1 : 0;
  numbers[kChannels] = static_cast<std::int32_t>(header.channels);
  assert(check_numbers(numbers).ok());
  std::array<std::byte, kNganHeaderSize> bytes{};
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

}  // namespace sbrdf::internal
