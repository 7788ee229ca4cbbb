#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/slicing/slicing.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/merl/merl.h"

namespace sbrdf {

/// Something a conversion changed or lost, for people (`text`) and for scripts (`key`, `value`).
struct Remark {
  std::string key;  ///< such as "reciprocity_residual_percent"
  double value = 0;
  std::string text;  ///< such as "reciprocity residual 3.2 %: f(i,v) and f(v,i) were replaced by their mean"
};

/// What the writers may be told. Each uses the part that concerns it.
struct SaveOptions {
  std::optional<SliceOptions> slices;    ///< not given: a sliced source is copied as it is, others use the defaults
  std::optional<double> copy_precision;  ///< of such a copy; not given: that of the source
  ChunkSize copy_chunks = ChunkSize::kAuto;
  std::optional<MerlShape> merl_shape;  ///< not given: a MERL source is copied bit for bit, others get kMerlShape
};

struct SavedFile {
  std::vector<std::byte> bytes;
  std::vector<Remark> remarks;
};

/// One row per format. A new format is one row here, one file in converters/ and one folder in formats/.
struct Format {
  std::string_view name;
  std::string_view extension;  ///< decides what is written; what is read is recognised by content
  std::string_view description;
  bool (*recognises)(std::span<const std::byte> file) = nullptr;
  Result<std::unique_ptr<BrdfSource>> (*load)(std::span<const std::byte> file) = nullptr;  ///< nullptr: not readable
  Result<SavedFile> (*save)(const BrdfSource& source, const SaveOptions& options,
                            const Progress& progress) = nullptr;  ///< nullptr: not writable
};

[[nodiscard]] std::span<const Format> formats();

/// Recognised by content, never by extension. An error where no row, or only a damaged file of a row, matches: empty
/// files, text and foreign formats are told apart where that helps.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> load_source(std::span<const std::byte> file);

/// The writable format of an extension such as ".sbrdf", letter case ignored; kUsage listing the writable ones
/// otherwise.
[[nodiscard]] Result<const Format*> find_writer(std::string_view extension);

}  // namespace sbrdf
