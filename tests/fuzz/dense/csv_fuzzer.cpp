#include "converters/files/csv/csv_file.h"
#include "tests/fuzz/dense/dense_file.h"

// The reader of dense tables as text.

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sbrdf::internal;
  const auto source = open_csv(std::make_shared<OwnedMemorySource>(fuzzing::copy_of(bytes, size)), {});
  if (source) fuzzing::exercise_dense(**source, ".csv");
  return 0;
}
