#include <fuzzer/FuzzedDataProvider.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/hdf5/hdf5_file.h"
#include "formats/table/hdf5/samples.h"
#include "formats/table/hdf5/table.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/require.h"

// What an HDF5 file says about its table or its uniform samples, not how the library packs it: heads of any content are
// written, and whatever the reader takes must evaluate to finite values.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr std::array kFrames = {"angles", "difference", "half-difference", "mirror", "sideways"};
constexpr std::array kEnds = {"held", "360", "180", "mirrored", "extrapolated", ""};
constexpr std::array kSpacings = {"angle", "root", "cube"};

Hdf5Head head_from(FuzzedDataProvider& input) {
  Hdf5Head head;
  head.frame = input.PickValueInArray(kFrames);
  for (Hdf5Axis& axis : head.axes) {
    axis.name = std::string("axis") + static_cast<char>('a' + (&axis - head.axes.data()));
    axis.ends = input.PickValueInArray(kEnds);
    axis.spacing = input.PickValueInArray(kSpacings);
    const auto count = input.ConsumeIntegralInRange<int>(1, 4);
    double at = input.ConsumeBool() ? 0 : input.ConsumeFloatingPoint<double>();
    for (int k = 0; k < count; ++k) {
      axis.nodes_deg.push_back(at);
      at += input.ConsumeBool() ? 20 : input.ConsumeFloatingPoint<double>();
    }
  }
  head.channels.assign(static_cast<std::size_t>(input.ConsumeIntegralInRange<int>(1, 3)), "c");
  head.value_size = input.PickValueInArray<std::size_t>({2, 4, 8});
  head.theta_max_deg = input.ConsumeBool() ? 90 : input.ConsumeFloatingPoint<double>();
  return head;
}

void open_and_evaluate(std::vector<std::byte> bytes) {
  const auto source = open_hdf5(std::make_shared<OwnedMemorySource>(std::move(bytes)), {});
  if (source) evaluate_everywhere(**source);
}

void run_samples(FuzzedDataProvider& input) {
  Hdf5Samples samples;
  const auto rings = input.ConsumeIntegralInRange<int>(1, 4);
  double theta = 0;
  for (int k = 0; k < rings; ++k) {
    samples.ring_theta_deg.push_back(theta);
    samples.ring_count.push_back(k == 0 ? 1 : input.ConsumeBool() ? 4 : input.ConsumeFloatingPoint<double>());
    theta += input.ConsumeBool() ? 20 : input.ConsumeFloatingPoint<double>();
  }
  const std::size_t directions = 1 + 4 * static_cast<std::size_t>(rings - 1);
  samples.channels.assign(static_cast<std::size_t>(input.ConsumeIntegralInRange<int>(1, 3)), "c");
  samples.values.resize(directions * (directions + 1) / 2 * samples.channels.size(), 1);
  for (float& value : samples.values) {
    if (input.ConsumeBool()) value = input.ConsumeFloatingPoint<float>();
  }
  samples.interpolation = input.PickValueInArray({"barycentric", "rbf", "nearest"});
  samples.kernel = input.PickValueInArray({"linear", "cubic", "thin-plate", "inverse-multiquadric", ""});
  MemorySink sink;
  if (write_hdf5_samples(sink, samples, "", 0)) open_and_evaluate(std::move(sink).take());
}

void run(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider input(bytes, size);
  if (input.ConsumeBool()) return run_samples(input);
  const Hdf5Head head = head_from(input);
  Hdf5Extent shape{};
  for (std::size_t k = 0; k < head.axes.size(); ++k) shape[k] = head.axes[k].nodes_deg.size();
  shape.back() = head.channels.size();
  std::vector<double> values(shape[0] * shape[1] * shape[2] * shape[3] * shape[4]);
  for (double& value : values) value = input.ConsumeBool() ? 1 : input.ConsumeFloatingPoint<double>();
  MemorySink sink;
  auto writer = Hdf5TableWriter::create(sink, head, shape, 0);
  if (!writer || !(*writer)->write({}, shape, values) || !(*writer)->finish("")) return;
  open_and_evaluate(std::move(sink).take());
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(bytes, size);
  return 0;
}
