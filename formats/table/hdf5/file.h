#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The bytes begin as every HDF5 file does.
[[nodiscard]] bool is_hdf5(std::span<const std::byte> head);

/// An HDF5 file that is read: where it is, if it has more than 64 MiB and a path, else from memory.
class Hdf5File {
 public:
  /// kInvalidFile for a file that the library does not take.
  [[nodiscard]] static Result<std::shared_ptr<const Hdf5File>> open(std::shared_ptr<const ByteSource> bytes);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// What its attribute `sbrdf` says that it holds: "dense table", "uniform samples". Empty where there is none.
  [[nodiscard]] const std::string& content() const;

  struct State;
  [[nodiscard]] const State& state() const { return *state_; }

 private:
  explicit Hdf5File(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sbrdf::internal
