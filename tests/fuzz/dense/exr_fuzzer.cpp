#include "converters/files/exr/exr_file.h"
#include "tests/fuzz/dense/dense_file.h"

// The EXR reader, in front of the OpenEXR library.

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sbrdf::internal;
  const auto file = std::make_shared<OwnedMemorySource>(fuzzing::copy_of(bytes, size));
  const auto source = open_exr(file, {});
  if (source) fuzzing::exercise_dense(**source, ".exr");
  static_cast<void>(open_exr(file, Options().set("grid", "difference/0:45:45:90")));
  return 0;
}
