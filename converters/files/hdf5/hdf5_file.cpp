#include "converters/files/hdf5/hdf5_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/dense/dense_file.h"
#include "converters/files/hdf5/samples_file.h"
#include "converters/files/table_options.h"
#include "converters/files/value_options.h"
#include "converters/tables/dense_source.h"
#include "converters/tables/tile_cache.h"
#include "formats/table/hdf5/samples.h"
#include "formats/table/hdf5/table.h"

namespace sbrdf::internal {
namespace {

/// Decoded boxes that stay in memory [bytes].
constexpr std::uint64_t kCacheBytes = std::uint64_t{256} << 20U;
/// Numbers of a chunk that is written.
constexpr std::uint64_t kChunkNumbers = 16384;

constexpr std::array kOptions = {
    grid_option(),
    type_option(),
    OptionSpec{.name = "hdf5-dataset",
               .use = OptionUse::kRead,
               .unit = "PATH",
               .fallback = "f_r, or the only table",
               .meaning = "Dataset of an HDF5 IN that holds the table: four angles, and the channel as the fifth "
                          "dimension if there are several"},
    OptionSpec{.name = "deflate",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {0, 9},
               .fallback = "4",
               .meaning = "How hard an HDF5 OUT is compressed: 0 not at all, 9 most and slowest"},
    kSchemeOption,
    kInterpolationOption,
    kRbfKernelOption,
    negatives_option(OptionUse::kBoth),
    non_finite_option(OptionUse::kBoth),
};

Result<GridAxis> axis_of(const Hdf5Axis& axis, GridFrame frame, std::size_t index) {
  const std::string_view name = Grid::axis_name(frame, index);
  const auto ends = value_of(kEndsNames, axis.ends);
  const auto spacing = value_of(kSpacingNames, axis.spacing);
  if (!ends || !spacing) {
    return unsupported(
        fmt::format("{}: \"{}\" is no end, or \"{}\" no spacing, that is known here", name, axis.ends, axis.spacing));
  }
  if (!Grid::can_have(frame, index, axis.nodes_deg, *ends, *spacing)) {
    return invalid_file(fmt::format("the nodes of {} do not rise within its range", name));
  }
  return GridAxis(axis.nodes_deg, *ends, *spacing);
}

Result<Grid> own_grid(const Hdf5Head& head) {
  const auto frame = value_of(kGridFrameNames, head.frame);
  if (!frame) return unsupported(fmt::format("\"{}\" is no frame that is known here", head.frame));
  Grid grid;
  grid.frame = *frame;
  std::uint64_t count = 1;
  for (std::size_t k = 0; k < grid.axes.size(); ++k) {
    Result<GridAxis> axis = axis_of(head.axes[k], *frame, k);
    if (!axis) return axis.error();
    grid.axes[k] = *std::move(axis);
    count *= grid.axes[k].size();  // 2^36 x 2^16 at most
    if (count > kGridMostNodes) return unsupported("more than 2^36 nodes");
  }
  return grid;
}

Result<Grid> grid_of(const Hdf5TableReader& file, const Options& options) {
  // Where the file tells, --grid is about what is written.
  if (!file.head().frame.empty()) return own_grid(file.head());
  Result<Grid> parsed = grid_of_option(options, "the file does not tell where its nodes are");
  if (!parsed) return parsed;
  const Grid& grid = *parsed;
  for (std::size_t k = 0; k < grid.axes.size(); ++k) {
    if (grid.axes[k].size() == file.shape()[k]) continue;
    return usage_error(fmt::format("--grid: {}, but the dataset has {} entries along dimension {}", grid.size_text(),
                                   file.shape()[k], k));
  }
  return parsed;
}

TiledValues::Box box_of(const Hdf5Extent& extent) {
  TiledValues::Box box{};
  for (std::size_t k = 0; k < box.size(); ++k) box[k] = static_cast<std::uint32_t>(extent[k]);
  return box;
}

Hdf5Extent extent_of(const std::array<std::uint32_t, 4>& box, std::uint64_t last) {
  return {box[0], box[1], box[2], box[3], last};
}

/// The first error of reading a box. What cannot be read is NaN; the source is looked at once as a whole, so that an
/// error is known before it is used.
class FirstError {
 public:
  void take(const Error& error) {
    const std::scoped_lock lock(mutex_);
    if (!error_) error_ = error;
  }
  [[nodiscard]] std::optional<Error> get() const {
    const std::scoped_lock lock(mutex_);
    return error_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<Error> error_;
};

/// Numbers of a box at most, whatever chunks a file has.
constexpr std::uint64_t kMostBoxNumbers = std::uint64_t{1} << 20U;

// Of all channels, as chunks are in the angles, but no larger than there is room for.
TiledValues::Box tile_of(const Hdf5TableReader& file) {
  TiledValues::Box box = box_of(file.chunk());
  const auto numbers = [&] { return std::uint64_t{box[0]} * box[1] * box[2] * box[3] * file.shape().back(); };
  while (numbers() > kMostBoxNumbers) {
    std::uint32_t& longest = *std::max_element(box.begin(), box.end());
    if (longest == 1) break;
    longest = (longest + 1) / 2;
  }
  return box;
}

DenseTable table_of(std::shared_ptr<const Hdf5TableReader> file, Grid grid, std::shared_ptr<FirstError> failure) {
  const std::uint64_t channels = file->shape().back();
  const auto read = [file, channels, failure](const GridNode& first, const TiledValues::Box& count,
                                              std::span<double> values) {
    const Status done = file->read(extent_of(first, 0), extent_of(count, channels), values);
    if (done) return;
    failure->take(done.error());
    std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
  };
  const ValueType type = file->head().value_size == 8   ? ValueType::kFloat64
                         : file->head().value_size == 4 ? ValueType::kFloat32
                                                        : ValueType::kFloat16;
  auto values = std::make_shared<TiledValues>(box_of(file->shape()), channels, tile_of(*file), kCacheBytes, read);
  return {std::move(grid), channels, std::move(values), type};
}

}  // namespace

Result<std::unique_ptr<BrdfSource>> open_hdf5(std::shared_ptr<const ByteSource> file, const Options& options) {
  const Result<std::shared_ptr<const Hdf5File>> opened = Hdf5File::open(file);
  if (!opened) return opened.error();
  if ((*opened)->content() == kHdf5UniformSamples) return open_samples(**opened, std::move(file), options);
  Result<std::unique_ptr<Hdf5TableReader>> reader =
      Hdf5TableReader::open(*opened, options.text("hdf5-dataset").value_or(""));
  if (!reader) return reader.error();
  const std::shared_ptr<const Hdf5TableReader> shared = *std::move(reader);
  Result<Grid> grid = grid_of(*shared, options);
  if (!grid) return grid.error();
  const Hdf5Head& stored = shared->head();
  TableHead head;
  head.channels = usable_names(stored.channels) ? stored.channels : default_channels(shared->shape().back());
  head.reach = {stored.theta_max_deg, stored.slice_theta_max_deg, stored.beyond};
  // A copy is of use where the file has this layout, and its table is the one that is found without asking.
  if (stored.frame.empty() || options.has("hdf5-dataset")) file = nullptr;
  const auto failure = std::make_shared<FirstError>();
  Result<std::unique_ptr<BrdfSource>> source =
      open_dense(table_of(shared, *std::move(grid), failure), "hdf5", std::move(head), std::move(file), options);
  if (const auto error = failure->get()) return *error;
  return source;
}

namespace {

// Doubled along one axis after the other, the fastest first.
std::array<std::uint32_t, 4> chunk_for(const Grid& grid, std::size_t channels) {
  std::array<std::uint32_t, 4> box = {1, 1, 1, 1};
  std::uint64_t numbers = channels;
  bool grown = true;
  while (grown) {
    grown = false;
    for (std::size_t axis = 4; axis-- > 0;) {
      const std::uint32_t wider = std::min(2 * box[axis], grid.axes[axis].size());
      const std::uint64_t more = numbers / box[axis] * wider;
      if (wider == box[axis] || more > kChunkNumbers) continue;
      box[axis] = wider;
      numbers = more;
      grown = true;
    }
  }
  return box;
}

Hdf5Head head_of(const TableHead& table, const SourceTraits& traits) {
  Hdf5Head head;
  head.frame = name_of(kGridFrameNames, table.grid.frame);
  for (std::size_t k = 0; k < head.axes.size(); ++k) {
    const GridAxis& axis = table.grid.axes[k];
    head.axes[k] = {std::string(table.grid.axis_name(k)), axis.nodes_deg(),
                    std::string(name_of(kEndsNames, axis.ends())), std::string(name_of(kSpacingNames, axis.spacing()))};
  }
  head.channels = table.channels;
  head.value_size = size_of(table.type);
  head.description = traits.description;
  head.theta_max_deg = table.reach.theta_max_deg;
  head.slice_theta_max_deg = table.reach.slice_theta_max_deg;
  head.beyond = table.reach.beyond_theta_max;
  return head;
}

}  // namespace

Status save_hdf5(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                 const Progress& progress) {
  if (wants_samples(source, options)) return save_samples(source, sink, options, report, progress);
  for (const char* option : {"interpolation", "rbf-kernel"}) {
    if (options.has(option) && source.uniform_samples() == nullptr) {
      return usage_error(fmt::format("--{}: is of uniform samples, which take --scheme", option));
    }
  }
  DenseWriting writing(source, options, ValueType::kFloat64, report);
  if (!options.has("deflate")) {
    if (const auto stored = writing.stored("hdf5")) return copy_bytes(*stored, sink, progress);
  }
  const std::uint64_t channels = writing.channel_count();
  const std::array<std::uint32_t, 4> box = chunk_for(writing.grid(), channels);
  const auto deflate = static_cast<unsigned>(options.count("deflate").value_or(kHdf5Deflate));
  Result<std::unique_ptr<Hdf5TableWriter>> writer =
      Hdf5TableWriter::create(sink, head_of(writing.head(), source.traits()), extent_of(box, channels), deflate);
  if (!writer) return writer.error();
  const auto take = [&](const TableBlock& block, std::span<const double> values) {
    return (*writer)->write(extent_of(block.first, 0), extent_of(block.count, channels), values);
  };
  if (Status sampled = writing.sample(box, take, progress); !sampled) return sampled;
  return (*writer)->finish(report_json(report));
}

Status check_hdf5_options(const Options& options) { return check_samples_options(options); }

std::span<const OptionSpec> hdf5_options() { return kOptions; }

}  // namespace sbrdf::internal
