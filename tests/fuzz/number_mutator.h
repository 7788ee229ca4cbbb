#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <span>

namespace sbrdf::internal::fuzzing {

/// Writes a number that is hard on a reader, or a harmless one, over a number of `bytes`, which lie from `first` on.
template <class T>
void overwrite_number(std::span<std::uint8_t> bytes, std::size_t first, std::minstd_rand& random) {
  using Limits = std::numeric_limits<T>;
  static constexpr std::array kNumbers = {T(0),
                                          T(-0.0),
                                          T(1),
                                          T(-1),
                                          T(0.5),
                                          T(3.14159265),
                                          T(-3.14159265),
                                          T(1.57079633),
                                          T(1e30),
                                          T(-1e30),
                                          T(1e-30),
                                          T(1e37),
                                          Limits::max(),
                                          Limits::min(),
                                          Limits::denorm_min(),
                                          Limits::lowest(),
                                          Limits::infinity(),
                                          Limits::quiet_NaN()};
  if (bytes.size() < first + sizeof(T)) return;
  const std::size_t count = (bytes.size() - first) / sizeof(T);
  const T value = kNumbers[random() % kNumbers.size()];
  std::memcpy(bytes.data() + first + random() % count * sizeof(T), &value, sizeof(T));
}

}  // namespace sbrdf::internal::fuzzing
