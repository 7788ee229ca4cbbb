#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

/// Along each axis of an atlas the interval behind the node of that number; 0 where nothing moves.
using AtlasCell = std::array<std::size_t, kAxisCount>;

/// Cells of an atlas' axes: those that it holds. As it is made, empty, it stands for all of them.
class AtlasCells {
 public:
  using Counts = std::array<std::uint32_t, kAxisCount>;

  AtlasCells() = default;
  /// None yet, of so many along each axis.
  explicit AtlasCells(const Counts& counts) : counts_(counts), flags_(cell_count(counts)) {}

  [[nodiscard]] static std::uint64_t cell_count(const Counts& counts) {
    return std::uint64_t{counts[0]} * counts[1] * counts[2] * counts[3];
  }

  [[nodiscard]] bool is_everything() const { return flags_.empty(); }
  [[nodiscard]] const Counts& counts() const { return counts_; }
  /// One for each cell, the last axis fastest.
  [[nodiscard]] const std::vector<bool>& flags() const { return flags_; }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(std::count(flags_.begin(), flags_.end(), true));
  }

  [[nodiscard]] bool has(const AtlasCell& cell) const { return is_everything() || flags_[index(cell)]; }
  void add(const AtlasCell& cell) { flags_[index(cell)] = true; }
  void add_number(std::size_t number) { flags_[number] = true; }
  /// All that the other one has, of the same counts.
  void add_all(const AtlasCells& other) {
    for (std::size_t k = 0; k < flags_.size(); ++k) flags_[k] = flags_[k] || other.flags_[k];
  }

  /// Calls `visit(cell)` for each that is there.
  template <class Visit>
  void for_each(const Visit& visit) const {
    AtlasCell cell{};
    for (std::size_t k = 0; k < flags_.size(); ++k) {
      if (!flags_[k]) continue;
      std::size_t rest = k;
      for (std::size_t axis = kAxisCount; axis-- > 0; rest /= counts_[axis]) cell[axis] = rest % counts_[axis];
      visit(cell);
    }
  }

  bool operator==(const AtlasCells&) const = default;

 private:
  [[nodiscard]] std::size_t index(const AtlasCell& cell) const {
    return ((cell[0] * counts_[1] + cell[1]) * counts_[2] + cell[2]) * counts_[3] + cell[3];
  }

  Counts counts_{};
  std::vector<bool> flags_;
};

}  // namespace sbrdf::internal
