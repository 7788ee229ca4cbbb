#include <array>
#include <cmath>
#include <memory>

#include "converters/files/klems/klems_source.h"
#include "formats/core/directions.h"
#include "formats/klems/klems.h"
#include "tests/fuzz/require.h"

// The reader of Klems XML: a matrix is whole, and what opens evaluates to finite values.

namespace sbrdf::internal::fuzzing {
namespace {

void evaluate_everywhere(const BrdfSource& source) {
  constexpr std::array kTheta = {0.0, 1e-9, 0.3, 1.2, kPi / 2, 1.6};
  constexpr std::array kPhi = {0.0, -1.0, kPi, 7.0, 1e6};
  for (const double theta_i : kTheta) {
    for (const double theta_v : kTheta) {
      for (const double phi : kPhi) {
        const DirectionPair pair = {{theta_i, phi}, {theta_v, 1 - phi}};
        float value = 0;
        source.evaluate(std::span(&pair, 1), std::span(&value, 1));
        require(std::isfinite(value), "a Klems source evaluates to finite values");
      }
    }
  }
}

void run(const Bytes& bytes) {
  static_cast<void>(recognises_klems(bytes));
  for (const bool transmission : {false, true}) {
    const Result<KlemsMatrix> matrix = parse_klems(bytes, {.transmission = transmission});
    if (matrix) {
      const std::size_t patches = matrix->incident.patch_count() * matrix->outgoing.patch_count();
      require(matrix->values.size() == patches, "a matrix is whole");
    }
    Options options;
    if (transmission) options.set("klems-transmission");
    const auto source = open_klems(std::make_shared<MemorySource>(bytes), options);
    require(!source.ok() || matrix.ok(), "only what is parsed opens");
    if (source) evaluate_everywhere(**source);
  }
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
