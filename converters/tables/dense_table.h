#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "converters/tables/grid.h"
#include "formats/core/named.h"

namespace sbrdf::internal {

/// Of numbers in a file.
enum class ValueType : std::uint8_t { kFloat16, kFloat32, kFloat64 };
inline constexpr std::array kValueTypeNames = {Named{"float16", ValueType::kFloat16},
                                               Named{"float32", ValueType::kFloat32},
                                               Named{"float64", ValueType::kFloat64}};
/// Bytes of one number.
[[nodiscard]] constexpr std::size_t size_of(ValueType type) {
  return type == ValueType::kFloat16 ? 2 : type == ValueType::kFloat32 ? 4 : 8;
}

/// Values at the nodes of a grid, wherever they are kept. Immutable; several threads may ask at once.
class NodeValues {
 public:
  NodeValues() = default;
  NodeValues(const NodeValues&) = delete;
  NodeValues& operator=(const NodeValues&) = delete;
  virtual ~NodeValues() = default;

  /// f_r [1/sr] at each node, channel fastest: `values` has nodes.size() x channels entries. A node that was not
  /// measured has NaN in every channel.
  virtual void gather(std::span<const GridNode> nodes, std::span<double> values) const = 0;
};

/// A dense table: a grid, and a value for each node and channel, exactly as it was read (in f_r).
struct DenseTable {
  Grid grid;
  std::size_t channel_count = 3;
  std::shared_ptr<const NodeValues> values;
  ValueType type = ValueType::kFloat32;  ///< the least that holds every value
};

/// Values that lie in memory, or in a mapped file, as numbers in a row of some order. f_r = number x scale.
class StridedValues final : public NodeValues {
 public:
  struct Layout {
    ValueType type = ValueType::kFloat32;
    std::array<std::uint64_t, 4> strides = {0, 0, 0, 0};  ///< numbers from one node to the next along each axis
    std::uint64_t channel_stride = 0;                     ///< numbers from one channel to the next
    std::vector<double> scales;                           ///< of each channel
    bool negative_is_mark = false;                        ///< a node with some channel below 0 was not measured
  };
  /// `first` is the number of node {0, 0, 0, 0} and channel 0, at any alignment; `owner` keeps it where it is.
  StridedValues(std::shared_ptr<const void> owner, const std::byte* first, Layout layout);

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override;

 private:
  [[nodiscard]] double number(std::uint64_t position) const;

  std::shared_ptr<const void> owner_;
  const std::byte* first_;
  Layout layout_;
};

/// The numbers of a row in C order, channel fastest: strides for `grid`.
[[nodiscard]] StridedValues::Layout interleaved_layout(const Grid& grid, std::size_t channel_count, ValueType type);

/// A table of numbers in C order with the channel fastest. NaN in some channel makes a node unmeasured.
[[nodiscard]] DenseTable table_in_memory(Grid grid, std::size_t channel_count, std::vector<float> values);
[[nodiscard]] DenseTable table_in_memory(Grid grid, std::size_t channel_count, std::vector<double> values);

}  // namespace sbrdf::internal
