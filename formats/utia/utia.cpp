#include "formats/utia/utia.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kSureNumbers = 8;

bool is_likely(double number) {
  const double size = std::abs(number);
  return number == 0 || std::isnan(number) || (size >= 1e-46 && size <= 1e42);
}

}  // namespace

std::optional<UtiaShape> utia_shape_of_size(std::uint64_t file_size) {
  for (const UtiaShape& shape : {kUtiaStandard, kUtiaDense}) {
    if (file_size == utia_file_size(shape)) return shape;
  }
  return std::nullopt;
}

bool are_utia_numbers(std::span<const double> numbers) {
  if (numbers.size() < kSureNumbers) return false;
  const auto likely = static_cast<std::size_t>(std::count_if(numbers.begin(), numbers.end(), is_likely));
  return std::all_of(numbers.begin(), numbers.begin() + kSureNumbers, is_likely) && 4 * likely >= 3 * numbers.size();
}

bool recognises_utia(std::span<const std::byte> head, std::uint64_t file_size) {
  std::array<double, kUtiaHeadNumbers> numbers{};
  if (!utia_shape_of_size(file_size) || head.size() < sizeof numbers) return false;
  std::memcpy(numbers.data(), head.data(), sizeof numbers);
  return are_utia_numbers(numbers);
}

}  // namespace sbrdf::internal
