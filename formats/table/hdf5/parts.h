#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/table/hdf5/file.h"
#include "formats/table/hdf5/handle.h"

namespace sbrdf::internal {

// What files of every content are made of. All functions are called while an Hdf5Lock lives.

struct Hdf5File::State {
  std::shared_ptr<const ByteSource> bytes;
  Hdf5Handle file;
  std::string content;
};

/// A file that is being written: as it grows where the sink has a path, else in memory.
class Hdf5Output {
 public:
  [[nodiscard]] static Result<Hdf5Output> create(ByteSink& sink);
  [[nodiscard]] hid_t id() const { return file_.id(); }
  /// Once, at the end, when everything in it is closed.
  [[nodiscard]] Status finish();

 private:
  Hdf5Output(ByteSink& sink, bool in_memory) : sink_(&sink), in_memory_(in_memory) {}

  ByteSink* sink_;
  bool in_memory_;
  Hdf5Handle file_;
};

// Types: little-endian IEEE floats of 2, 4 or 8 bytes; text of a fixed width, padded with zeros, UTF-8.
[[nodiscard]] Hdf5Handle hdf5_float_type(std::size_t size);
[[nodiscard]] Hdf5Handle hdf5_text_type(std::size_t size);
[[nodiscard]] bool is_hdf5_float(hid_t type);

// Attributes. Reading gives nothing where there is none of that name, or it is something else.
[[nodiscard]] bool write_hdf5_text(hid_t object, const char* name, const std::string& text);
[[nodiscard]] bool write_hdf5_number(hid_t object, const char* name, double value);
[[nodiscard]] std::optional<std::string> read_hdf5_text(hid_t object, const char* name);
[[nodiscard]] std::optional<double> read_hdf5_number(hid_t object, const char* name);

// Datasets of one dimension. Writing gives an invalid handle where the library failed. Datasets tell no time, so that
// the same content has the same bytes. Reading gives nothing where the dataset is of another kind, or does not have
// `count` entries.
[[nodiscard]] Hdf5Handle write_hdf5_numbers(hid_t file, const std::string& name, const std::vector<double>& numbers);
[[nodiscard]] Hdf5Handle write_hdf5_names(hid_t file, const std::string& name, const std::vector<std::string>& names);
[[nodiscard]] std::optional<std::vector<double>> read_hdf5_numbers(hid_t dataset, std::uint64_t count);
[[nodiscard]] std::optional<std::vector<std::string>> read_hdf5_names(hid_t dataset, std::uint64_t count);

/// A dataset of this file, which no link to another one leads to. kInvalidFile where there is none.
[[nodiscard]] Result<Hdf5Handle> open_hdf5_dataset(const Hdf5File& file, const std::string& name);

/// Whether the numbers of a dataset are in its own file, in chunks of 2^24 at most, and are there at all. kUnsupported
/// or kInvalidFile where not.
[[nodiscard]] Status check_hdf5_storage(hid_t dataset);

/// kIo or kInvalidFile, with what the library last complained about.
[[nodiscard]] Error hdf5_not_written();
[[nodiscard]] Error hdf5_refused(const std::string& what);

}  // namespace sbrdf::internal
