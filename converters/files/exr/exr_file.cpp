#include "converters/files/exr/exr_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/dense/dense_file.h"
#include "formats/table/exr_image.h"

namespace sbrdf::internal {
namespace {

constexpr std::string_view kAttribute = "sbrdf";
/// What the library takes beside the pixels, in blocks of rows.
constexpr std::uint64_t kBlocks = 4;

std::uint64_t row_count(const Grid& grid) { return std::uint64_t{grid.axes[0].size()} * grid.axes[1].size(); }
std::uint64_t column_count(const Grid& grid) { return std::uint64_t{grid.axes[2].size()} * grid.axes[3].size(); }

bool fits(const ExrHeader& header, const Grid& grid) {
  return header.height == row_count(grid) && header.width == column_count(grid);
}

const ExrChannel* find(const ExrHeader& header, std::string_view name) {
  const auto found = std::find_if(header.channels.begin(), header.channels.end(),
                                  [&](const ExrChannel& channel) { return channel.name == name; });
  return found == header.channels.end() ? nullptr : &*found;
}

/// The number that a name begins with, such as a wavelength.
std::optional<double> leading_number(std::string_view name) {
  double value = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), value);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

/// Channels of an image that does not tell their order, and how many are left out.
std::vector<std::string> channels_without_head(const ExrHeader& header, std::vector<Finding>& findings) {
  if (find(header, "R") != nullptr && find(header, "G") != nullptr && find(header, "B") != nullptr) {
    if (header.channels.size() > 3) {
      findings.push_back(
          {"channels other than R, G and B, left out", header.channels.size() - 3, header.channels.size()});
    }
    return {"R", "G", "B"};
  }
  std::vector<std::string> names;
  for (const ExrChannel& channel : header.channels) names.push_back(channel.name);
  const bool numbered =
      std::all_of(names.begin(), names.end(), [](const std::string& name) { return leading_number(name).has_value(); });
  if (numbered) {
    std::stable_sort(names.begin(), names.end(),
                     [](const auto& a, const auto& b) { return *leading_number(a) < *leading_number(b); });
  }
  return names;
}

std::string size_text(const ExrHeader& header) { return fmt::format("{} x {} pixels", header.width, header.height); }

Result<TableHead> head_in_image(const ExrHeader& header) {
  Result<TableHead> head = parse_table_head(header.text);
  if (!head) {
    Error error = head.error();
    error.message = fmt::format("attribute \"{}\": {}", kAttribute, error.message);
    return error;
  }
  if (!fits(header, head->grid)) {
    return invalid_file(fmt::format("the image of {} is not that of its attribute \"{}\": {}", size_text(header),
                                    kAttribute, head->grid.size_text()));
  }
  for (const std::string& name : head->channels) {
    if (find(header, name) == nullptr) return invalid_file("a channel of the description is not in the image");
  }
  return head;
}

Result<TableHead> head_for(const ExrHeader& header, const Options& options, std::vector<Finding>& findings) {
  if (!header.text.empty()) return head_in_image(header);
  TableHead head;
  const Grid utia = parse_grid("utia").value();
  if (!options.has("grid") && fits(header, utia)) {
    head.grid = utia;
    findings.push_back(
        {"nodes taken to be those of UTIA's images, as nothing in the file tells: light and view at theta "
         "0, 15, ... 75 and phi 0, 7.5, ... 352.5 degrees, values f_r",
         utia.node_count(), utia.node_count()});
  } else {
    Result<Grid> grid = grid_of_option(
        options, fmt::format("an image of {} without the attribute \"{}\"", size_text(header), kAttribute));
    if (!grid) return grid.error();
    if (!fits(header, *grid)) {
      return usage_error(fmt::format("--grid: {} need an image of {} x {} pixels, this one has {}", grid->size_text(),
                                     column_count(*grid), row_count(*grid), size_text(header)));
    }
    head.grid = *std::move(grid);
  }
  head.channels = channels_without_head(header, findings);
  return head;
}

bool all_halves(const ExrHeader& header, const std::vector<std::string>& channels) {
  return std::all_of(channels.begin(), channels.end(),
                     [&](const std::string& name) { return find(header, name)->half; });
}

/// Gathers the parts of rows that sample_table gives into whole rows.
Status write_rows(DenseWriting& writing, ExrWriter& writer, const Progress& progress) {
  const std::size_t row_size = column_count(writing.grid()) * writing.channel_count() * size_of(writing.type());
  std::vector<std::byte> row;
  const auto take = [&](const TableBlock&, std::span<const double> values) {
    append_numbers(writing.type(), values, row);
    if (row.size() < row_size) return ok_status();
    Status written = writer.write_row(row);
    row.clear();
    return written;
  };
  return writing.sample(rows_of(writing.grid()), take, progress);
}

}  // namespace

std::span<const OptionSpec> exr_options() { return kDenseOptions; }

Status check_exr_options(const Options& options) {
  if (options.text("type") != "float64") return ok_status();
  return unsupported("--type: OpenEXR images have no 64-bit floats; use float32 or float16");
}

Result<std::unique_ptr<BrdfSource>> open_exr(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  Result<std::unique_ptr<ExrReader>> reader = ExrReader::open(bytes, kAttribute);
  if (!reader) return reader.error();
  const ExrHeader& header = (*reader)->header();
  std::vector<Finding> findings;
  Result<TableHead> head = head_for(header, options, findings);
  if (!head) return head.error();
  const bool half = all_halves(header, head->channels);
  const ValueType type = half ? ValueType::kFloat16 : ValueType::kFloat32;
  const std::uint64_t numbers = head->grid.node_count() * head->channels.size();
  const double needed = static_cast<double>(numbers) * static_cast<double>(size_of(type)) +
                        static_cast<double>(kBlocks * header.block_size);
  if (Status allowed = check_memory(needed, options.memory.of(bytes->stored_size())); !allowed) return allowed.error();
  const auto pixels = std::make_shared<std::vector<std::byte>>(numbers * size_of(type));
  if (Status read = (*reader)->read(head->channels, half, *pixels); !read) return read.error();
  // An image without a head is none that is written here, and a copy would lose where its nodes are.
  std::shared_ptr<const ByteSource> told = header.text.empty() ? nullptr : std::move(bytes);
  DenseTable table;
  table.values = std::make_shared<StridedValues>(pixels, pixels->data(),
                                                 interleaved_layout(head->grid, head->channels.size(), type));
  table.grid = std::move(head->grid);
  table.channel_count = head->channels.size();
  table.type = type;
  return open_dense(std::move(table), "exr", *std::move(head), std::move(told), options, std::move(findings));
}

Status save_exr(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                const Progress& progress) {
  DenseWriting writing(source, options, ValueType::kFloat32, report);
  if (const auto stored = writing.stored("exr")) return copy_bytes(*stored, sink, progress);
  ExrWriter::Image image;
  image.width = column_count(writing.grid());
  image.height = row_count(writing.grid());
  image.channels = source.traits().channels;
  image.half = writing.type() == ValueType::kFloat16;
  image.attribute = kAttribute;
  if (Status possible = ExrWriter::check(image); !possible) return possible;
  const std::size_t head_size = writing.head_size();
  image.text = writing.padded_head(head_size);
  Result<std::unique_ptr<ExrWriter>> writer = ExrWriter::create(sink, image);
  if (!writer) return writer.error();
  if (Status written = write_rows(writing, **writer, progress); !written) return written;
  return (*writer)->finish(writing.padded_head(head_size));
}

}  // namespace sbrdf::internal
