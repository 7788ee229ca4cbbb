#include "converters/tables/dense_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "formats/core/half.h"

namespace sbrdf::internal {

StridedValues::StridedValues(std::shared_ptr<const void> owner, const std::byte* first, Layout layout)
    : owner_(std::move(owner)), first_(first), layout_(std::move(layout)) {}

double StridedValues::number(std::uint64_t position) const {
  if (layout_.type == ValueType::kFloat64) {
    double value;
    std::memcpy(&value, first_ + sizeof value * position, sizeof value);
    return value;
  }
  if (layout_.type == ValueType::kFloat16) {
    std::uint16_t bits;
    std::memcpy(&bits, first_ + sizeof bits * position, sizeof bits);
    return float_from_half(bits);
  }
  float value;
  std::memcpy(&value, first_ + sizeof value * position, sizeof value);
  return value;
}

void StridedValues::gather(std::span<const GridNode> nodes, std::span<double> values) const {
  const std::size_t channels = layout_.scales.size();
  assert(values.size() == nodes.size() * channels);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    std::uint64_t position = 0;
    for (std::size_t axis = 0; axis < nodes[n].size(); ++axis) position += layout_.strides[axis] * nodes[n][axis];
    const std::span<double> colour = values.subspan(n * channels, channels);
    bool mark = false;
    for (std::size_t c = 0; c < channels; ++c) {
      colour[c] = number(position + c * layout_.channel_stride) * layout_.scales[c];
      mark = mark || std::isnan(colour[c]) || (layout_.negative_is_mark && colour[c] < 0);
    }
    if (mark) std::fill(colour.begin(), colour.end(), std::numeric_limits<double>::quiet_NaN());
  }
}

StridedValues::Layout interleaved_layout(const Grid& grid, std::size_t channel_count, ValueType type) {
  StridedValues::Layout layout;
  layout.type = type;
  layout.channel_stride = 1;
  layout.scales.assign(channel_count, 1.0);
  std::uint64_t stride = channel_count;
  for (std::size_t axis = grid.axes.size(); axis-- > 0;) {
    layout.strides[axis] = stride;
    stride *= grid.axes[axis].size();
  }
  return layout;
}

namespace {

template <class T>
DenseTable in_memory(Grid grid, std::size_t channel_count, std::vector<T> values) {
  assert(values.size() == grid.node_count() * channel_count);
  const ValueType type = sizeof(T) == sizeof(double) ? ValueType::kFloat64 : ValueType::kFloat32;
  const auto kept = std::make_shared<const std::vector<T>>(std::move(values));
  const auto* first = std::as_bytes(std::span(*kept)).data();
  auto numbers = std::make_shared<StridedValues>(kept, first, interleaved_layout(grid, channel_count, type));
  return {std::move(grid), channel_count, std::move(numbers), type};
}

}  // namespace

DenseTable table_in_memory(Grid grid, std::size_t channel_count, std::vector<float> values) {
  return in_memory(std::move(grid), channel_count, std::move(values));
}
DenseTable table_in_memory(Grid grid, std::size_t channel_count, std::vector<double> values) {
  return in_memory(std::move(grid), channel_count, std::move(values));
}

}  // namespace sbrdf::internal
