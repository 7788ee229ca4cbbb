#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "converters/files/zemax/zemax_source.h"
#include "formats/core/directions.h"
#include "formats/zemax/zemax.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/require.h"

// The reader of Zemax text: a table has as many numbers as its lists ask for, and what opens evaluates to finite
// values.

namespace sbrdf::internal::fuzzing {
namespace {

void check_table(const ZemaxTable& table) {
  for (const auto* angles : {&table.rotations, &table.incidences, &table.azimuths, &table.radials}) {
    require(!angles->empty(), "a list has an angle");
    for (std::size_t k = 1; k < angles->size(); ++k) require((*angles)[k - 1] < (*angles)[k], "angles rise");
  }
  require(table.tis.size() == table.channel_count() * table.block_count(), "each block has its TIS");
  require(table.values.size() == table.tis.size() * table.block_size(), "each block is whole");
  for (const double v : table.values) require(std::abs(v) <= kZemaxLargest, "values are finite");
}

void run(const Bytes& bytes) {
  const Result<ZemaxTable> table = parse_zemax({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (table) check_table(*table);
  static_cast<void>(recognises_zemax(bytes));
  for (const char* zeros : {"auto", "black"}) {
    const auto source = open_zemax(std::make_shared<MemorySource>(bytes), Options().set("zemax-zeros", zeros));
    require(!source.ok() || table.ok(), "only what is parsed opens");
    if (source) evaluate_everywhere(**source);
  }
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
