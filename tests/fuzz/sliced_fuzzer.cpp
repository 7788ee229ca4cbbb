#include "tests/fuzz/sliced_file.h"

// Sliced files, from the index to the last sample.

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  return sbrdf::internal::fuzzing::mutate_sliced(bytes, size, max_size, seed);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::exercise_sliced(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
