#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/foreign.h"
#include "converters/files/utia/utia.h"
#include "converters/files/value_options.h"
#include "converters/tables/dense_source.h"

namespace sbrdf::internal {
namespace {

/// Numbers of a file as values; NaN stays.
class UtiaValues final : public NodeValues {
 public:
  UtiaValues(std::shared_ptr<const NodeValues> numbers, const UtiaConventions& conventions)
      : numbers_(std::move(numbers)), conventions_(conventions) {}

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    numbers_->gather(nodes, values);
    for (double& value : values) value = utia_value(value, conventions_);
  }

 private:
  std::shared_ptr<const NodeValues> numbers_;
  UtiaConventions conventions_;
};

/// A table whose encoded numbers are interpolated, and then decoded.
class DecodedSource final : public BrdfSource {
 public:
  /// `decoded` is the table with its values decoded, `encoded` the same as its numbers are.
  DecodedSource(std::unique_ptr<BrdfSource> decoded, DenseTable encoded, const UtiaConventions& conventions)
      : decoded_(std::move(decoded)), encoded_(std::move(encoded)), conventions_(conventions) {}

  [[nodiscard]] const SourceTraits& traits() const override { return decoded_->traits(); }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    interpolate_table(encoded_, pairs, values);
    for (float& value : values) {
      value = static_cast<float>(std::clamp(utia_value(value, conventions_), -kTableLargest, kTableLargest));
    }
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    decoded_->measured(pairs, flags);
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return decoded_->mask_grid(); }
  [[nodiscard]] const DenseTable* table() const override { return decoded_->table(); }

 private:
  std::unique_ptr<BrdfSource> decoded_;
  DenseTable encoded_;
  UtiaConventions conventions_;
};

/// The values of a source's table as the numbers that stand for them: what the policy made of them is kept.
class EncodedValues final : public NodeValues {
 public:
  EncodedValues(std::shared_ptr<const NodeValues> values, const UtiaConventions& conventions)
      : values_(std::move(values)), conventions_(conventions) {}

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    values_->gather(nodes, values);
    for (double& value : values) value = utia_number(value, conventions_);
  }

 private:
  std::shared_ptr<const NodeValues> values_;
  UtiaConventions conventions_;
};

StridedValues::Layout layout_of(const UtiaShape& shape, double scale) {
  StridedValues::Layout layout;
  layout.type = ValueType::kFloat64;
  const std::uint64_t directions = utia_direction_count(shape);
  layout.strides = {directions * shape.phi_count, directions, shape.phi_count, 1};
  layout.channel_stride = utia_value_count(shape);
  layout.scales.assign(kUtiaChannelCount, scale);
  return layout;
}

}  // namespace

Grid utia_grid(const UtiaShape& shape, bool extrapolated) {
  Grid grid = angles_grid(shape.theta_step_deg, shape.theta_step_deg * (shape.theta_count - 1), shape.phi_step_deg);
  if (!extrapolated) return grid;
  for (const std::size_t axis : {0, 2}) grid.axes[axis] = GridAxis(grid.axes[axis].nodes_deg(), Ends::kExtrapolated);
  return grid;
}

Result<std::unique_ptr<BrdfSource>> make_utia_source(std::shared_ptr<const ByteSource> file, const UtiaShape& shape,
                                                     const UtiaConventions& conventions, const ValuePolicy& policy) {
  if (file->size() != utia_file_size(shape)) {
    return invalid_file(
        fmt::format("a UTIA table of {} x {} directions needs {} bytes, the file has {}", utia_direction_count(shape),
                    utia_direction_count(shape), utia_file_size(shape), file->size()),
        std::min(file->size(), utia_file_size(shape)));
  }
  Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(file));
  if (!viewed) return viewed.error();
  const bool encoded = conventions.gamma != UtiaGamma::kNone;
  const std::shared_ptr<const NodeValues> stored = std::make_shared<StridedValues>(
      *viewed, (*viewed)->view()->data(), layout_of(shape, encoded ? 1 : conventions.scale / conventions.white));
  std::shared_ptr<const NodeValues> values = stored;
  if (encoded) values = std::make_shared<UtiaValues>(stored, conventions);
  DenseDescription description;
  description.format = "utia";
  description.description =
      fmt::format("UTIA table, {} x {} directions of light and of viewer", shape.theta_count, shape.phi_count);
  description.channels = {"R", "G", "B"};
  description.policy = policy;
  description.unmeasured = "nodes that hold NaN, taken as unmeasured";
  if (conventions.plain()) description.file = *viewed;
  Result<std::unique_ptr<BrdfSource>> source =
      DenseSource::make({utia_grid(shape, conventions.extrapolated), kUtiaChannelCount, values, ValueType::kFloat64},
                        std::move(description));
  if (!source || conventions.gamma != UtiaGamma::kSrgbAfter) return source;
  DenseTable numbers = *(*source)->table();
  const bool as_stored = numbers.values == values;  // else the policy made other values of some
  numbers.values = as_stored ? stored : std::make_shared<EncodedValues>(std::move(numbers.values), conventions);
  return std::unique_ptr<BrdfSource>(
      std::make_unique<DecodedSource>(*std::move(source), std::move(numbers), conventions));
}

bool begins_like_utia(std::span<const std::byte> head, std::uint64_t file_size) {
  return recognises_utia(head, file_size) && !is_text(head);
}

Result<std::unique_ptr<BrdfSource>> open_utia(std::shared_ptr<const ByteSource> file, const Options& options) {
  const Result<std::vector<std::byte>> head = read_start(*file, kUtiaHeadNumbers * sizeof(double));
  if (!head) return head.error();
  const std::optional<UtiaShape> shape = utia_shape_of_size(file->size());
  if (!shape || !begins_like_utia(*head, file->size())) {
    return invalid_file("the file has the size of a UTIA table, but its first numbers are none of a BRDF", 0);
  }
  return make_utia_source(std::move(file), *shape, utia_conventions(options),
                          policy_of(options, NonFinite::kUnmeasured));
}

}  // namespace sbrdf::internal
