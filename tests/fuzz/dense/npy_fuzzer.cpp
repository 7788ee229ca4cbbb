#include <algorithm>

#include "converters/files/npy/npy_file.h"
#include "tests/fuzz/dense/dense_file.h"

// The NPY reader. An input is an array, or a head, a zero and an array. An array alone gets the nodes of a small grid.

namespace sbrdf::internal::fuzzing {
namespace {

void run(const Bytes& bytes) {
  const auto zero = std::find(bytes.begin(), bytes.end(), std::byte{0});
  const bool with_head = !bytes.empty() && bytes.front() == std::byte{'{'} && zero != bytes.end();
  Options options;
  auto file = std::make_shared<PairSource>(bytes, Bytes());
  if (with_head) {
    file = std::make_shared<PairSource>(Bytes(zero + 1, bytes.end()), Bytes(bytes.begin(), zero));
  } else {
    options.set("grid", "difference/0:45:45:90");
  }
  const auto source = open_npy(file, options);
  if (source) exercise_dense(**source, ".npy");
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
