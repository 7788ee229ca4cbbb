#include <array>

#include "converters/files/scattered/scattered_file.h"
#include "tests/fuzz/dense/dense_file.h"

// The reader of scattered samples. The first byte of an input says with which options the rest is read.

namespace sbrdf::internal::fuzzing {
namespace {

Options options_of(unsigned choice) {
  constexpr std::array kGrids = {"difference/0:45:45:90", "45:180:45:180", "half-difference/0:45:45:90",
                                 "mirror/0:45:120:90"};
  Options options;
  options.set("grid", kGrids.at(choice % 4));
  if ((choice & 4U) != 0) options.set("scattered-angles", "radians");
  if ((choice & 8U) != 0) options.set("scattered-quantity", "f_r-cos");
  if ((choice & 16U) != 0) options.set("scattered-columns", "theta_v,phi_v,theta_i,skip,Y");
  if ((choice & 32U) != 0) options.set("scattered-radius", "180");
  return options;
}

void run(const Bytes& bytes) {
  if (bytes.empty()) return;
  const auto text = std::make_shared<OwnedMemorySource>(Bytes(bytes.begin() + 1, bytes.end()));
  const auto head = text->view()->first(std::min<std::size_t>(text->size(), kHeadSize));
  if (!head.empty()) static_cast<void>(recognise_scattered(head, text->size()));
  const auto source = open_scattered(text, options_of(std::to_integer<unsigned>(bytes.front())));
  if (source) exercise_dense(**source, ".npy");
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
