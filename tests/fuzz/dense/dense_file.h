#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/format_table.h"
#include "converters/tables/dense_source.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/require.h"

namespace sbrdf::internal::fuzzing {

/// A file and the one beside it, which may be empty: none.
class PairSource final : public OwnedMemorySource {
 public:
  PairSource(Bytes file, Bytes beside) : OwnedMemorySource(std::move(file)), beside_(std::move(beside)) {}
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> sibling(std::string_view /*suffix*/) const override {
    if (beside_.empty()) return std::shared_ptr<const ByteSource>();
    return std::shared_ptr<const ByteSource>(std::make_shared<OwnedMemorySource>(beside_));
  }

 private:
  Bytes beside_;
};

class PairSink final : public ByteSink {
 public:
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    return file_.write(offset, bytes);
  }
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view /*suffix*/) override {
    return static_cast<ByteSink*>(&beside_);
  }
  [[nodiscard]] std::shared_ptr<PairSource> take() && {
    Bytes file = std::move(file_).take();
    return std::make_shared<PairSource>(std::move(file), std::move(beside_).take());
  }

 private:
  MemorySink file_;
  MemorySink beside_;
};

inline std::vector<double> numbers_of(const DenseTable& table) {
  std::vector<GridNode> nodes(table.grid.node_count());
  for (std::uint64_t k = 0; k < nodes.size(); ++k) nodes[k] = table.grid.node(k);
  std::vector<double> values(nodes.size() * table.channel_count);
  table.values->gather(nodes, values);
  return values;
}

/// Of a file that was read: it can be evaluated, and what is written of it, number by number, is read as the same.
inline void exercise_dense(const BrdfSource& source, std::string_view extension) {
  evaluate_everywhere(source);
  const DenseTable& table = *source.table();
  if (table.grid.node_count() * table.channel_count > 100000) return;
  PairSink sink;
  Report report;
  const Options clamped = Options().set("negatives", "clamp");  // so that it is not copied as a file
  if (!save_source(*find_writer(extension).value(), source, sink, clamped, report)) return;
  const auto back = open_source(std::move(sink).take());
  require(back.ok(), "what is written is read");
  require((*back)->table()->grid == table.grid, "nodes come back");
  const std::vector<double> before = numbers_of(table);
  const std::vector<double> after = numbers_of(*(*back)->table());
  require(before.size() == after.size(), "channels come back");
  for (std::size_t k = 0; k < before.size(); ++k) {
    const bool hole = std::isnan(before[k]) && std::isnan(after[k]);
    const bool clamps = before[k] < 0 && after[k] == 0;  // nodes above the horizon
    require(hole || clamps || after[k] == before[k], "numbers come back");
  }
}

}  // namespace sbrdf::internal::fuzzing
