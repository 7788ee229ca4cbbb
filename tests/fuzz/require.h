#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

// What libFuzzer calls, and what it offers to a mutator of ours.
extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed);
std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t max_size);
}

namespace sbrdf::internal::fuzzing {

using Bytes = std::vector<std::byte>;

/// Ends the program, which libFuzzer takes for a finding, unless `holds`.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

/// An own copy of exactly the input's size, so that the sanitizer sees every read past its end.
inline Bytes copy_of(const std::uint8_t* bytes, std::size_t size) {
  const auto view = std::as_bytes(std::span(bytes, size));
  return {view.begin(), view.end()};
}

}  // namespace sbrdf::internal::fuzzing
