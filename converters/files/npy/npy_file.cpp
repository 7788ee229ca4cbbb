#include "converters/files/npy/npy_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/dense/dense_file.h"
#include "formats/table/npy.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kAxes = 4;

ValueType type_of(const NpyHeader& header) {
  return header.number_size == 2   ? ValueType::kFloat16
         : header.number_size == 4 ? ValueType::kFloat32
                                   : ValueType::kFloat64;
}

/// What stands in the file beside the array; nothing where there is none.
Result<std::optional<TableHead>> read_head(const ByteSource& bytes) {
  const Result<std::shared_ptr<const ByteSource>> beside = bytes.sibling(kNpyHeadSuffix);
  if (!beside) return beside.error();
  if (*beside == nullptr) return std::optional<TableHead>();
  if ((*beside)->size() > kLongestTableHead) {
    return unsupported(fmt::format("the .json file beside it has {} bytes; at most {} are read", (*beside)->size(),
                                   kLongestTableHead));
  }
  const Result<std::vector<std::byte>> text = read_range(**beside, 0, (*beside)->size());
  if (!text) return text.error();
  Result<TableHead> head = parse_table_head({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!head) {
    Error error = head.error();
    error.message = "the .json file beside it: " + error.message;
    error.offset.reset();
    return error;
  }
  return std::optional<TableHead>(*std::move(head));
}

std::string shape_text(const std::vector<std::uint64_t>& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

/// Channels of an array whose first four axes have the sizes of a grid; nothing where it has others.
std::optional<std::size_t> channels_of(const NpyHeader& header, const Grid& grid) {
  const std::vector<std::uint64_t>& shape = header.shape;
  if (shape.size() != kAxes && shape.size() != kAxes + 1) return std::nullopt;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    if (shape[axis] != grid.axes[axis].size()) return std::nullopt;
  }
  const std::uint64_t channels = shape.size() == kAxes ? 1 : shape[kAxes];
  if (channels == 0 || channels > kMostTableChannels) return std::nullopt;
  return static_cast<std::size_t>(channels);
}

StridedValues::Layout layout_of(const NpyHeader& header, std::size_t channels) {
  StridedValues::Layout layout;
  layout.type = type_of(header);
  layout.scales.assign(channels, 1.0);
  std::array<std::uint64_t, kAxes + 1> strides{};
  std::uint64_t stride = 1;
  for (std::size_t k = 0; k < header.shape.size(); ++k) {
    const std::size_t axis = header.fortran_order ? k : header.shape.size() - 1 - k;
    strides[axis] = stride;
    stride *= header.shape[axis];
  }
  std::copy_n(strides.begin(), kAxes, layout.strides.begin());
  layout.channel_stride = strides[kAxes];
  return layout;
}

/// Grid and names of channels, from beside the array or from the options.
Result<TableHead> head_for(const ByteSource& bytes, const NpyHeader& header, const Options& options) {
  Result<std::optional<TableHead>> beside = read_head(bytes);
  if (!beside) return beside.error();
  if (*beside) {
    const auto channels = channels_of(header, (*beside)->grid);
    if (channels && *channels == (*beside)->channels.size()) return **std::move(beside);
    return invalid_file(fmt::format("the array of shape {} is not that of the .json file beside it: {}, {} channels",
                                    shape_text(header.shape), (*beside)->grid.size_text(), (*beside)->channels.size()));
  }
  Result<Grid> grid = grid_of_option(options, "no file of the same name and .json beside it");
  if (!grid) return grid.error();
  const auto channels = channels_of(header, *grid);
  if (!channels) {
    return usage_error(
        fmt::format("--grid: {} do not fit the array of shape {}; axes and channels are to be (theta_i, "
                    "phi_i, theta_v, phi_v, channels) or those of the grid's frame, without the last of one channel",
                    grid->size_text(), shape_text(header.shape)));
  }
  TableHead head;
  head.grid = *std::move(grid);
  head.channels = default_channels(*channels);
  return head;
}

Status write_head(const DenseWriting& writing, ByteSink& sink, Report& report) {
  const Result<ByteSink*> beside = sink.sibling(kNpyHeadSuffix);
  if (!beside) return beside.error();
  if (*beside == nullptr) {
    report.remarks.push_back(
        {"axes_lost", 1, "no place for a second file: nothing says where the nodes of the array are"});
    return ok_status();
  }
  const std::string text = emit_table_head(writing.head()) + "\n";
  return (*beside)->write(0, std::as_bytes(std::span(text.data(), text.size())));
}

Status write_array(DenseWriting& writing, ByteSink& sink, const Progress& progress) {
  std::vector<std::uint64_t> shape;
  for (const GridAxis& axis : writing.grid().axes) shape.push_back(axis.size());
  shape.push_back(writing.channel_count());
  const std::vector<std::byte> header = emit_npy_header(size_of(writing.type()), shape);
  if (Status written = sink.write(0, header); !written) return written;
  std::uint64_t offset = header.size();
  std::vector<std::byte> numbers;
  const auto take = [&](const TableBlock&, std::span<const double> values) {
    numbers.clear();
    append_numbers(writing.type(), values, numbers);
    Status written = sink.write(offset, numbers);
    offset += numbers.size();
    return written;
  };
  return writing.sample(rows_of(writing.grid()), take, progress);
}

}  // namespace

std::span<const OptionSpec> npy_options() { return kDenseOptions; }

Result<std::unique_ptr<BrdfSource>> open_npy(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<std::vector<std::byte>> start = read_start(*bytes, kNpyLongestHeader);
  if (!start) return start.error();
  const Result<NpyHeader> header = parse_npy_header(*start, bytes->size());
  if (!header) return header.error();
  Result<TableHead> head = head_for(*bytes, *header, options);
  if (!head) return head.error();
  Result<std::shared_ptr<const ByteSource>> viewed = with_view(bytes);
  if (!viewed) return viewed.error();
  const std::size_t channels = head->channels.size();
  const std::byte* first = (*viewed)->view()->data() + header->data_offset;
  DenseTable table;
  table.values = std::make_shared<StridedValues>(*viewed, first, layout_of(*header, channels));
  table.grid = std::move(head->grid);
  table.channel_count = channels;
  table.type = type_of(*header);
  return open_dense(std::move(table), "npy", *std::move(head), std::move(bytes), options);
}

Status save_npy(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                const Progress& progress) {
  DenseWriting writing(source, options, ValueType::kFloat64, report);
  if (const auto stored = writing.stored("npy")) {
    if (Status copied = copy_bytes(*stored, sink, progress); !copied) return copied;
  } else if (Status written = write_array(writing, sink, progress); !written) {
    return written;
  }
  return write_head(writing, sink, report);
}

}  // namespace sbrdf::internal
