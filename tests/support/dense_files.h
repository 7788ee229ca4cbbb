#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/format_table.h"
#include "converters/tables/dense_source.h"

namespace sbrdf::internal::dense_files {

using Bytes = std::vector<std::byte>;

/// A file that stays in memory along with those that belong to it.
class FolderSink final : public ByteSink {
 public:
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    return own_.write(offset, bytes);
  }
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view suffix) override {
    return static_cast<ByteSink*>(&others_[std::string(suffix)]);
  }
  [[nodiscard]] std::map<std::string, Bytes> take() && {
    std::map<std::string, Bytes> files;
    files[""] = std::move(own_).take();
    for (auto& [suffix, sink] : others_) files[suffix] = std::move(sink).take();
    return files;
  }

 private:
  MemorySink own_;
  std::map<std::string, MemorySink> others_;
};

class FolderSource final : public OwnedMemorySource {
 public:
  explicit FolderSource(std::map<std::string, Bytes> files) : OwnedMemorySource(files[""]), files_(std::move(files)) {}
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> sibling(std::string_view suffix) const override {
    const auto found = files_.find(std::string(suffix));
    if (found == files_.end()) return std::shared_ptr<const ByteSource>();
    return std::shared_ptr<const ByteSource>(std::make_shared<OwnedMemorySource>(found->second));
  }

 private:
  std::map<std::string, Bytes> files_;
};

struct SavedFiles {
  std::map<std::string, Bytes> files;
  Report report;
};

inline Result<SavedFiles> save(std::string_view extension, const BrdfSource& source, const Options& options = {}) {
  FolderSink sink;
  SavedFiles saved;
  if (Status done = save_source(*find_writer(extension).value(), source, sink, options, saved.report); !done) {
    return done.error();
  }
  saved.files = std::move(sink).take();
  return saved;
}

inline Result<std::unique_ptr<BrdfSource>> open(std::map<std::string, Bytes> files, const Options& options = {}) {
  return open_source(std::make_shared<FolderSource>(std::move(files)), options);
}

inline const Remark* find_remark(const Report& report, std::string_view key) {
  for (const Remark& remark : report.remarks) {
    if (remark.key == key) return &remark;
  }
  return nullptr;
}

/// All values of a table in C order.
inline std::vector<double> values_of(const BrdfSource& source) {
  const DenseTable& table = *source.table();
  std::vector<GridNode> nodes(table.grid.node_count());
  for (std::uint64_t k = 0; k < nodes.size(); ++k) nodes[k] = table.grid.node(k);
  std::vector<double> values(nodes.size() * table.channel_count);
  table.values->gather(nodes, values);
  return values;
}

/// Whether they are the same numbers, signs of zeros included, or both NaN.
inline bool same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (std::isnan(a[k]) && std::isnan(b[k])) continue;
    if (a[k] != b[k] || std::signbit(a[k]) != std::signbit(b[k])) return false;
  }
  return true;
}

/// Axes of uneven nodes, one of them mirrored, in the frame of light and view less light.
inline Grid uneven_grid() {
  return {GridFrame::kDifference,
          {GridAxis({0, 100.00000000000001}, Ends::kFullTurn), GridAxis({0, 1.0 / 3, 60}), GridAxis({5, 80}),
           GridAxis({0, 0.1, 180}, Ends::kMirrored)}};
}

/// A table with holes, negative numbers and zeros, denormal and large ones, in all of which T has every bit.
template <class T>
std::unique_ptr<BrdfSource> awkward_table(std::vector<std::string> channels = {"R", "G", "B"}) {
  const Grid grid = uneven_grid();
  const std::size_t count = channels.size();
  std::vector<T> values(grid.node_count() * count);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<T>(std::exp(std::sin(1.0 + double(k)) * 20));
  const std::vector<T> special = {T(-0.25),  T(-0.0),     std::numeric_limits<T>::denorm_min(),
                                  T(1e12),   T(1) / T(3), std::numeric_limits<T>::min(),
                                  T(-1e-30), T(0)};
  std::copy(special.begin(), special.end(), values.begin() + 3);
  for (std::size_t c = 0; c < count; ++c) {
    values[7 * count + c] = values[20 * count + c] = std::numeric_limits<T>::quiet_NaN();
  }
  DenseDescription description;
  description.format = "test";
  description.channels = std::move(channels);
  return DenseSource::make(table_in_memory(grid, count, std::move(values)), std::move(description)).value();
}

}  // namespace sbrdf::internal::dense_files
