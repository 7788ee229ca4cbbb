#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/options.h"
#include "converters/slicing/options.h"
#include "converters/source/progress.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What is measured: a name for people, and how it is opened, every time from the start.
struct BenchMaterial {
  std::string name;
  std::function<Result<OpenedSource>()> open;
};

/// Bytes of a file in memory.
using FileBytes = std::shared_ptr<const std::vector<std::byte>>;

/// Makes the files of one material, each once, however many methods read it. References must outlive it.
class Workshop {
 public:
  /// `search_evaluations`: see SearchedStructure, for sliced().
  Workshop(const BenchMaterial& material, const BrdfSource& source, std::size_t search_evaluations)
      : material_(material), source_(source), search_evaluations_(search_evaluations) {}

  [[nodiscard]] const BenchMaterial& material() const { return material_; }
  [[nodiscard]] const BrdfSource& source() const { return source_; }

  /// A sliced file as `sbrdf convert --samples N` makes it.
  [[nodiscard]] Result<FileBytes> sliced(std::uint64_t samples, const Progress& progress);
  /// One for the tables of growth, up to hundreds of thousands of samples: hardly searched for, samples not fitted and
  /// within 0.1 %, as `sbrdf convert --search-evaluations 1 --values measured --precision 0.1%` makes it.
  [[nodiscard]] Result<FileBytes> sliced_for_growth(std::uint64_t samples, const Progress& progress);
  /// What `sbrdf convert` writes under this extension with these options.
  [[nodiscard]] Result<FileBytes> file(const std::string& extension, const Options& options, const Progress& progress);

 private:
  using Make = std::function<Result<std::vector<std::byte>>()>;

  [[nodiscard]] Result<FileBytes> once(const std::string& key, const Make& make);
  [[nodiscard]] Result<std::vector<std::byte>> saved(const std::string& extension, const Options& options,
                                                     const Progress& progress) const;
  [[nodiscard]] Result<std::vector<std::byte>> encoded(const SliceOptions& options, const Progress& progress) const;

  const BenchMaterial& material_;
  const BrdfSource& source_;
  std::size_t search_evaluations_;
  std::map<std::string, FileBytes> made_;
};

}  // namespace sbrdf::internal
