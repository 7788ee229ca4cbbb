#include <hdf5_hl.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "formats/core/piece_hook.h"
#include "formats/table/hdf5_handle.h"
#include "formats/table/hdf5_table.h"

namespace sbrdf::internal {

struct Hdf5TableReader::State {
  std::shared_ptr<const ByteSource> bytes;
  Hdf5Handle file;
  Hdf5Handle dataset;
  Hdf5Head head;
  std::size_t rank = kHdf5Rank;
  Hdf5Extent shape{};
  Hdf5Extent chunk{};
};

namespace {

constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
constexpr std::uint64_t kInPlaceFrom = std::uint64_t{1} << 26U;
constexpr std::size_t kLongestText = std::size_t{1} << 20U;
/// Numbers of a box that is read at once, where a file is not chunked.
constexpr std::uint64_t kBoxNumbers = 16384;
constexpr std::uint64_t kMostChunkNumbers = std::uint64_t{1} << 24U;

Error refused(const std::string& what) { return invalid_file(hdf5_message(what)); }

/// A text attribute; nothing where there is none of that name, or it is something else.
std::optional<std::string> read_text(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Hdf5Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
  if (!attribute.ok() || H5Tget_class(type.id()) != H5T_STRING || H5Sget_simple_extent_npoints(space.id()) != 1) {
    return std::nullopt;
  }
  if (H5Tis_variable_str(type.id()) > 0) {
    char* text = nullptr;
    const Hdf5Handle memory(H5Tcopy(type.id()), H5Tclose);
    if (H5Aread(attribute.id(), memory.id(), &text) < 0 || text == nullptr) return std::nullopt;
    std::string copy(text, strnlen(text, kLongestText));
    H5free_memory(text);
    return copy;
  }
  const std::size_t size = H5Tget_size(type.id());
  if (size > kLongestText) return std::nullopt;
  std::string text(size, '\0');
  if (H5Aread(attribute.id(), type.id(), text.data()) < 0) return std::nullopt;
  text.resize(strnlen(text.data(), size));
  return text;
}

std::optional<double> read_number(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Hdf5Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
  double value = 0;
  const bool one = H5Tget_class(type.id()) == H5T_FLOAT && H5Sget_simple_extent_npoints(space.id()) == 1;
  if (!one || H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &value) < 0) return std::nullopt;
  return value;
}

// The library's reason for a failure lasts until its next call, and closing a list of properties is one.
Result<Hdf5Handle> open_at(const std::string& name, hid_t access) {
  Hdf5Handle file(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (!file.ok()) return refused("not a readable HDF5 file");
  return file;
}

Result<Hdf5Handle> open_image(std::span<const std::byte> bytes) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.id(), std::size_t{1} << 16U, false);
  std::vector<std::byte> copy(bytes.begin(), bytes.end());
  if (H5Pset_file_image(access.id(), copy.data(), copy.size()) < 0) return refused("not a readable HDF5 file");
  return open_at("table.h5", access.id());
}

struct Found {
  std::vector<std::string> names;
};

// Takes note of each dataset of floats that could be a table.
herr_t look(hid_t file, const char* name, const H5O_info_t* object, void* found) {
  if (object->type != H5O_TYPE_DATASET) return 0;
  const Hdf5Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  if (!set.ok()) return 0;
  const Hdf5Handle type(H5Dget_type(set.id()), H5Tclose);
  const Hdf5Handle space(H5Dget_space(set.id()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.id());
  if (H5Tget_class(type.id()) == H5T_FLOAT && (rank == 4 || rank == 5))
    static_cast<Found*>(found)->names.emplace_back(name);
  return 0;
}

Result<std::string> find_dataset(const Hdf5Handle& file) {
  if (H5Lexists(file.id(), kHdf5Dataset, H5P_DEFAULT) > 0) return std::string(kHdf5Dataset);
  Found found;
  H5Ovisit(file.id(), H5_INDEX_NAME, H5_ITER_INC, look, &found);
  if (found.names.size() == 1) return found.names.front();
  if (found.names.empty()) return invalid_file("no dataset of floats with four or five dimensions");
  std::string list;
  for (std::size_t k = 0; k < std::min<std::size_t>(found.names.size(), 10); ++k)
    list += (k == 0 ? "" : ", ") + found.names[k];
  return usage_error("several datasets could be a table; --hdf5-dataset chooses one of " + list);
}

bool is_ieee_float(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  std::size_t sign = 0, exponent = 0, exponent_size = 0, mantissa = 0, mantissa_size = 0;
  if (H5Tget_class(type) != H5T_FLOAT ||
      H5Tget_fields(type, &sign, &exponent, &exponent_size, &mantissa, &mantissa_size) < 0)
    return false;
  return (size == 2 && exponent_size == 5 && mantissa_size == 10) ||
         (size == 4 && exponent_size == 8 && mantissa_size == 23) ||
         (size == 8 && exponent_size == 11 && mantissa_size == 52);
}

std::optional<std::vector<double>> read_nodes(hid_t scale, std::uint64_t count) {
  const Hdf5Handle space(H5Dget_space(scale), H5Sclose);
  const Hdf5Handle type(H5Dget_type(scale), H5Tclose);
  const hssize_t points = H5Sget_simple_extent_npoints(space.id());
  if (points < 0 || static_cast<std::uint64_t>(points) != count || H5Tget_class(type.id()) != H5T_FLOAT)
    return std::nullopt;
  std::vector<double> nodes(count);
  if (H5Dread(scale, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, nodes.data()) < 0) return std::nullopt;
  return nodes;
}

/// The first scale of a dimension.
Hdf5Handle open_scale(hid_t dataset, unsigned dimension) {
  Hdf5Handle scale;
  if (H5DSget_num_scales(dataset, dimension) < 1) return scale;
  const auto take = [](hid_t, unsigned, hid_t found, void* target) -> herr_t {
    H5Iinc_ref(found);
    *static_cast<Hdf5Handle*>(target) = {found, H5Dclose};
    return 1;
  };
  H5DSiterate_scales(dataset, dimension, nullptr, take, &scale);
  return scale;
}

std::vector<std::string> read_channels(hid_t dataset, unsigned dimension, std::uint64_t count) {
  const Hdf5Handle scale = open_scale(dataset, dimension);
  std::vector<std::string> names;
  if (!scale.ok()) return names;
  const Hdf5Handle type(H5Dget_type(scale.id()), H5Tclose);
  const Hdf5Handle space(H5Dget_space(scale.id()), H5Sclose);
  const hssize_t points = H5Sget_simple_extent_npoints(space.id());
  const std::size_t width = H5Tget_size(type.id());
  const bool plain = H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
  if (!plain || points < 0 || static_cast<std::uint64_t>(points) != count || width > 256) return names;
  std::string padded(width * count, '\0');
  if (H5Dread(scale.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()) < 0) return names;
  for (std::uint64_t k = 0; k < count; ++k) {
    const char* name = padded.data() + k * width;
    names.emplace_back(name, strnlen(name, width));
  }
  return names;
}

Status read_shape(hid_t dataset, std::size_t& rank, Hdf5Extent& shape) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const int dimensions = H5Sget_simple_extent_ndims(space.id());
  if (dimensions != 4 && dimensions != 5) return invalid_file("the dataset has other than four or five dimensions");
  rank = static_cast<std::size_t>(dimensions);
  std::array<hsize_t, kHdf5Rank> sizes = {1, 1, 1, 1, 1};
  H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr);
  for (std::size_t k = 0; k < kHdf5Rank; ++k) {
    const std::uint64_t most = k + 1 == kHdf5Rank ? kHdf5MostChannels : kHdf5MostAlongAxis;
    if (sizes[k] < 1 || sizes[k] > most) {
      return unsupported("dimension " + std::to_string(k) + " of the dataset has " + std::to_string(sizes[k]) +
                         " entries, must be 1 to " + std::to_string(most));
    }
    shape[k] = sizes[k];
  }
  return ok_status();
}

// What lies in other files is none of this one: a table could name any file of the machine.
Status check_place(hid_t dataset) {
  const Hdf5Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_external_count(properties.id()) > 0 || H5Pget_layout(properties.id()) == H5D_VIRTUAL) {
    return unsupported("the numbers of the dataset lie in other files");
  }
  return ok_status();
}

herr_t refuse_external(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) { return -1; }

// What is not stored reads as zeros: a file of a hundred bytes could claim to hold any number of them.
Status check_storage(hid_t dataset, const Hdf5Extent& shape) {
  constexpr double kMostCompression = 1100;  // deflate makes a byte of 1032 at most
  double numbers = 1;
  for (const std::uint64_t size : shape) numbers *= static_cast<double>(size);
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  if (numbers * static_cast<double>(H5Tget_size(type.id())) <= kMostCompression * stored) return ok_status();
  return invalid_file("most of the dataset was never written");
}

/// A box of about kBoxNumbers, all channels, even along the angles.
Hdf5Extent box_for(const Hdf5Extent& shape) {
  Hdf5Extent box = {1, 1, 1, 1, shape.back()};
  std::uint64_t numbers = shape.back();
  bool grown = true;
  while (grown && numbers < kBoxNumbers) {
    grown = false;
    for (std::size_t axis = 4; axis-- > 0 && numbers < kBoxNumbers;) {
      if (box[axis] >= shape[axis]) continue;
      numbers = numbers / box[axis] * std::min(2 * box[axis], shape[axis]);
      box[axis] = std::min(2 * box[axis], shape[axis]);
      grown = true;
    }
  }
  return box;
}

Result<Hdf5Extent> read_chunk(hid_t dataset, std::size_t rank, const Hdf5Extent& shape) {
  const Hdf5Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(properties.id()) != H5D_CHUNKED) return box_for(shape);
  std::array<hsize_t, kHdf5Rank> sizes = {1, 1, 1, 1, 1};
  if (H5Pget_chunk(properties.id(), static_cast<int>(rank), sizes.data()) < 0) return refused("no size of chunks");
  Hdf5Extent chunk{};
  std::uint64_t numbers = 1;
  for (std::size_t k = 0; k < kHdf5Rank; ++k) {
    chunk[k] = std::clamp<std::uint64_t>(sizes[k], 1, shape[k]);
    numbers *= std::max<std::uint64_t>(1, std::min<std::uint64_t>(sizes[k], kMostChunkNumbers + 1));
    if (numbers > kMostChunkNumbers) return unsupported("chunks of more than 2^24 numbers");
  }
  return chunk;
}

}  // namespace

bool is_hdf5(std::span<const std::byte> head) {
  return head.size() >= kSignature.size() && std::memcmp(head.data(), kSignature.data(), kSignature.size()) == 0;
}

namespace {

Status read_head(hid_t file, hid_t dataset, const Hdf5Extent& shape, std::size_t rank, Hdf5Head& head) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  if (!is_ieee_float(type.id()))
    return unsupported("the numbers of the dataset are no IEEE floats of 16, 32 or 64 bits");
  head.value_size = H5Tget_size(type.id());
  head.channels = rank == kHdf5Rank ? read_channels(dataset, kHdf5Rank - 1, shape.back()) : std::vector<std::string>();
  if (read_text(file, "sbrdf").value_or("") != "dense table") return ok_status();
  if (read_text(file, "version").value_or("") != "1") return unsupported("a dense table of another version than 1");
  head.frame = read_text(file, "frame").value_or("");
  head.theta_max_deg = read_number(dataset, "theta_max").value_or(90);
  head.beyond = read_text(dataset, "beyond_theta_max").value_or("");
  head.slice_theta_max_deg = std::min(head.theta_max_deg, read_number(dataset, "slice_theta_max").value_or(90));
  if (!(head.theta_max_deg > 0 && head.theta_max_deg <= 90 && head.slice_theta_max_deg > 0))
    return invalid_file("theta_max is not within 0 and 90 degrees");
  if (head.frame.empty()) return invalid_file("the attribute \"frame\" is missing");
  for (unsigned axis = 0; axis < head.axes.size(); ++axis) {
    const Hdf5Handle scale = open_scale(dataset, axis);
    auto nodes = scale.ok() ? read_nodes(scale.id(), shape[axis]) : std::nullopt;
    if (!nodes)
      return invalid_file("dimension " + std::to_string(axis) + " has no scale with its " +
                          std::to_string(shape[axis]) + " nodes");
    head.axes[axis] = {"", *std::move(nodes), read_text(scale.id(), "ends").value_or("held"),
                       read_text(scale.id(), "spacing").value_or("angle")};
  }
  return ok_status();
}

}  // namespace

Hdf5TableReader::Hdf5TableReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5TableReader::~Hdf5TableReader() {
  const Hdf5Lock lock;
  state_.reset();
}
const Hdf5Head& Hdf5TableReader::head() const { return state_->head; }
const Hdf5Extent& Hdf5TableReader::shape() const { return state_->shape; }
const Hdf5Extent& Hdf5TableReader::chunk() const { return state_->chunk; }

Result<std::unique_ptr<Hdf5TableReader>> Hdf5TableReader::open(std::shared_ptr<const ByteSource> file,
                                                               const std::string& dataset) {
  auto state = std::make_unique<State>();
  const bool in_place = file->size() > kInPlaceFrom && !file->path().empty();
  if (!in_place) {
    Result<std::shared_ptr<const ByteSource>> viewed = with_view(file);
    if (!viewed) return viewed.error();
    file = *std::move(viewed);
  }
  const Hdf5Lock lock;
  Result<Hdf5Handle> opened = in_place ? open_at(file->path(), H5P_DEFAULT) : open_image(*file->view());
  if (!opened) return opened.error();
  state->file = *std::move(opened);
  state->bytes = std::move(file);
  const Result<std::string> name = dataset.empty() ? find_dataset(state->file) : dataset;
  if (!name) return name.error();
  // The boxes that are read are chunks, which somebody else keeps.
  const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.id(), 1, 0, 0);
  H5Pset_elink_cb(access.id(), refuse_external, nullptr);
  state->dataset = {H5Dopen2(state->file.id(), name->c_str(), access.id()), H5Dclose};
  if (!state->dataset.ok()) return refused("no dataset \"" + *name + "\"");
  if (Status own = check_place(state->dataset.id()); !own) return own.error();
  if (Status shaped = read_shape(state->dataset.id(), state->rank, state->shape); !shaped) return shaped.error();
  if (Status written = check_storage(state->dataset.id(), state->shape); !written) return written.error();
  const Result<Hdf5Extent> chunk = read_chunk(state->dataset.id(), state->rank, state->shape);
  if (!chunk) return chunk.error();
  state->chunk = *chunk;
  if (Status read = read_head(state->file.id(), state->dataset.id(), state->shape, state->rank, state->head); !read) {
    return read.error();
  }
  return std::unique_ptr<Hdf5TableReader>(new Hdf5TableReader(std::move(state)));
}

Status Hdf5TableReader::read(const Hdf5Extent& first, const Hdf5Extent& count, std::span<double> values) const {
  const Hdf5Lock lock;
  std::array<hsize_t, kHdf5Rank> starts{};
  std::array<hsize_t, kHdf5Rank> counts{};
  std::copy(first.begin(), first.end(), starts.begin());
  std::copy(count.begin(), count.end(), counts.begin());
  const auto rank = static_cast<int>(state_->rank);
  const Hdf5Handle memory(H5Screate_simple(rank, counts.data(), nullptr), H5Sclose);
  const Hdf5Handle box(H5Dget_space(state_->dataset.id()), H5Sclose);
  if (H5Sselect_hyperslab(box.id(), H5S_SELECT_SET, starts.data(), nullptr, counts.data(), nullptr) < 0 ||
      H5Dread(state_->dataset.id(), H5T_NATIVE_DOUBLE, memory.id(), box.id(), H5P_DEFAULT, values.data()) < 0) {
    return refused("a part of the table cannot be read");
  }
  piece_done();
  return ok_status();
}

}  // namespace sbrdf::internal
