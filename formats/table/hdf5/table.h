#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/core/byte_sink.h"
#include "formats/core/result.h"
#include "formats/table/hdf5/file.h"

namespace sbrdf::internal {

// Dense tables in HDF5 (specs/hdf5.md): one dataset of five dimensions, four angles and the channel, with dimension
// scales that say where the nodes are. What the words in it mean is known to converters/tables.

/// Four angles and the channel, the slowest first.
inline constexpr std::size_t kHdf5Rank = 5;
using Hdf5Extent = std::array<std::uint64_t, kHdf5Rank>;

struct Hdf5Axis {
  std::string name;               ///< "theta_i", "phi_v - phi_i"
  std::vector<double> nodes_deg;  ///< [degrees]
  std::string ends;               ///< "held", "360"
  std::string spacing;            ///< "angle", "root"
};

/// What a file says about its table.
struct Hdf5Head {
  std::string frame;  ///< "angles"; empty where the file does not say: a dataset that somebody else wrote
  std::array<Hdf5Axis, 4> axes;
  std::vector<std::string> channels;
  std::size_t value_size = 4;       ///< 2, 4 or 8 bytes of a number
  std::string description;          ///< one line; only written
  double theta_max_deg = 90;        ///< how far the values are good for anything
  std::string beyond;               ///< what they are beyond
  double slice_theta_max_deg = 90;  ///< how far slices of it should go unless somebody says otherwise
};

/// What files that are written here say that they hold, and the name of the dataset in them.
inline constexpr const char* kHdf5DenseTable = "dense table";
inline constexpr const char* kHdf5Dataset = "f_r";
/// Nodes along one axis, and channels: larger ones are refused.
inline constexpr std::uint64_t kHdf5MostAlongAxis = 65536;
inline constexpr std::uint64_t kHdf5MostChannels = 4096;

/// A dense table in a file, read a box at a time.
class Hdf5TableReader {
 public:
  /// `dataset` is the path of the dataset in the file; empty: "f_r", or else the only one of numbers with four or five
  /// dimensions. kInvalidFile for a file without such a dataset, or whose attributes contradict it; kUnsupported for
  /// numbers other than IEEE floats, and sizes beyond the limits above; kUsage where several datasets could be meant.
  [[nodiscard]] static Result<std::unique_ptr<Hdf5TableReader>> open(std::shared_ptr<const Hdf5File> file,
                                                                     const std::string& dataset = {});
  ~Hdf5TableReader();
  Hdf5TableReader(const Hdf5TableReader&) = delete;
  Hdf5TableReader& operator=(const Hdf5TableReader&) = delete;

  [[nodiscard]] const Hdf5Head& head() const;
  /// A dataset of four dimensions has one channel.
  [[nodiscard]] const Hdf5Extent& shape() const;
  /// The box that is stored, or best read, as one.
  [[nodiscard]] const Hdf5Extent& chunk() const;

  /// A box within the shape: `values` has as many entries as it has, in C order. From any thread. kInvalidFile where
  /// the stored bytes are damaged or missing, kIo where the file cannot be read.
  [[nodiscard]] Status read(const Hdf5Extent& first, const Hdf5Extent& count, std::span<double> values) const;

 private:
  struct State;
  explicit Hdf5TableReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A dense table that is being written: boxes in any order, then finish().
class Hdf5TableWriter {
 public:
  /// A sink with a path gets the file as it is written, another one in finish(), whole. Chunks are shuffled and
  /// deflated
  /// (`deflate` 0 to 9; 0: neither). The same bytes each time: no time of writing is kept.
  [[nodiscard]] static Result<std::unique_ptr<Hdf5TableWriter>> create(ByteSink& sink, const Hdf5Head& head,
                                                                       const Hdf5Extent& chunk, unsigned deflate);
  ~Hdf5TableWriter();
  Hdf5TableWriter(const Hdf5TableWriter&) = delete;
  Hdf5TableWriter& operator=(const Hdf5TableWriter&) = delete;

  /// `values` has the box in C order.
  [[nodiscard]] Status write(const Hdf5Extent& first, const Hdf5Extent& count, std::span<const double> values);
  /// Once, at the end. kIo where something could not be written, now or before.
  [[nodiscard]] Status finish(const std::string& report);

 private:
  struct State;
  explicit Hdf5TableWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sbrdf::internal
