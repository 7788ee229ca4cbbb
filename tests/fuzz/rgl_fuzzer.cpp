#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "converters/files/rgl/rgl.h"
#include "formats/rgl/rgl_material.h"
#include "formats/rgl/tensor_file.h"
#include "tests/fuzz/number_mutator.h"
#include "tests/fuzz/require.h"

// The RGL reader: every field lies within the file, and what loads must evaluate to finite values.

namespace sbrdf::internal::fuzzing {
namespace {

void check_fields(const TensorFile& tensors, const Bytes& file) {
  for (const TensorField& field : tensors.fields) {
    std::uint64_t count = 1;
    for (const std::uint64_t extent : field.shape) count *= extent;
    require(field.bytes.size() == count * tensor_type_size(field.type), "a field has as many bytes as its shape asks");
    require(field.bytes.empty() || field.bytes.data() == file.data() + field.offset, "a field lies at its offset");
    require(field.offset + field.bytes.size() <= file.size(), "a field lies within the file");
    require(tensors.find(field.name) == &field, "a field can be found by its name");
  }
}

void evaluate_everywhere(const BrdfSource& source) {
  constexpr std::array kTheta = {0.0, 1e-9, 0.3, 1.2, 1.57079, kPi / 2, 1.6};
  constexpr std::array kPhi = {0.0, 1e-9, -1.0, kPi / 2, kPi, -kPi, 5.0, 1e6};
  for (const double theta_i : kTheta) {
    for (const double theta_v : kTheta) {
      for (std::size_t k = 0; k < kPhi.size(); ++k) {
        const DirectionPair pair = {{theta_i, kPhi[k]}, {theta_v, kPhi[(k * k + 1) % kPhi.size()]}};
        std::vector<float> values(source.channel_count());
        source.evaluate(std::span(&pair, 1), values);
        for (const float v : values) require(std::isfinite(v), "an RGL source evaluates to finite values");
      }
    }
  }
}

void run(const Bytes& bytes) {
  const Result<TensorFile> tensors = parse_tensor_file(bytes);
  if (tensors) check_fields(*tensors, bytes);
  const auto source = load_rgl(bytes);
  require(!source.ok() || tensors.ok(), "only tensor files load");
  if (source) evaluate_everywhere(**source);
  const auto colours = load_rgl(bytes, Negatives::kKeep, RglSpectral::kRgb);
  require(source.ok() || !colours.ok(), "what has colours has channels");
  if (colours) evaluate_everywhere(**colours);
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  const auto kind = random() % 4;
  if (kind < 2) return LLVMFuzzerMutate(bytes, size, max_size);
  // Elements may lie at any offset.
  for (std::size_t times = 1 + random() % kind; times > 0; --times) {
    sbrdf::internal::fuzzing::overwrite_number<float>({bytes, size}, random() % 4, random);
  }
  return size;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
