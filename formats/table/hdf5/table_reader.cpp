#include <hdf5_hl.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/core/piece_hook.h"
#include "formats/table/hdf5/parts.h"
#include "formats/table/hdf5/table.h"

namespace sbrdf::internal {

struct Hdf5TableReader::State {
  std::shared_ptr<const Hdf5File> file;
  Hdf5Handle dataset;
  Hdf5Head head;
  std::size_t rank = kHdf5Rank;
  Hdf5Extent shape{};
  Hdf5Extent chunk{};
};

namespace {

/// Numbers of a box that is read at once, where a file is not chunked.
constexpr std::uint64_t kBoxNumbers = 16384;

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

Result<std::string> find_dataset(hid_t file) {
  if (H5Lexists(file, kHdf5Dataset, H5P_DEFAULT) > 0) return std::string(kHdf5Dataset);
  Found found;
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, look, &found);
  if (found.names.size() == 1) return found.names.front();
  if (found.names.empty()) return invalid_file("no dataset of floats with four or five dimensions");
  std::string list;
  for (std::size_t k = 0; k < std::min<std::size_t>(found.names.size(), 10); ++k)
    list += (k == 0 ? "" : ", ") + found.names[k];
  return usage_error("several datasets could be a table; --hdf5-dataset chooses one of " + list);
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
  if (H5Pget_chunk(properties.id(), static_cast<int>(rank), sizes.data()) < 0) return hdf5_refused("no size of chunks");
  Hdf5Extent chunk{};
  for (std::size_t k = 0; k < kHdf5Rank; ++k) chunk[k] = std::clamp<std::uint64_t>(sizes[k], 1, shape[k]);
  return chunk;
}

Status read_head(hid_t file, hid_t dataset, const Hdf5Extent& shape, std::size_t rank, Hdf5Head& head) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  if (!is_hdf5_float(type.id()))
    return unsupported("the numbers of the dataset are no IEEE floats of 16, 32 or 64 bits");
  head.value_size = H5Tget_size(type.id());
  if (rank == kHdf5Rank) {
    const Hdf5Handle names = open_scale(dataset, kHdf5Rank - 1);
    if (names.ok()) head.channels = read_hdf5_names(names.id(), shape.back()).value_or(std::vector<std::string>());
  }
  if (read_hdf5_text(file, "sbrdf").value_or("") != kHdf5DenseTable) return ok_status();
  if (read_hdf5_text(file, "version").value_or("") != "1")
    return unsupported("a dense table of another version than 1");
  head.frame = read_hdf5_text(file, "frame").value_or("");
  head.theta_max_deg = read_hdf5_number(dataset, "theta_max").value_or(90);
  head.beyond = read_hdf5_text(dataset, "beyond_theta_max").value_or("");
  head.slice_theta_max_deg = std::min(head.theta_max_deg, read_hdf5_number(dataset, "slice_theta_max").value_or(90));
  if (!(head.theta_max_deg > 0 && head.theta_max_deg <= 90 && head.slice_theta_max_deg > 0))
    return invalid_file("theta_max is not within 0 and 90 degrees");
  if (head.frame.empty()) return invalid_file("the attribute \"frame\" is missing");
  for (unsigned axis = 0; axis < head.axes.size(); ++axis) {
    const Hdf5Handle scale = open_scale(dataset, axis);
    auto nodes = scale.ok() ? read_hdf5_numbers(scale.id(), shape[axis]) : std::nullopt;
    if (!nodes)
      return invalid_file("dimension " + std::to_string(axis) + " has no scale with its " +
                          std::to_string(shape[axis]) + " nodes");
    head.axes[axis] = {"", *std::move(nodes), read_hdf5_text(scale.id(), "ends").value_or("held"),
                       read_hdf5_text(scale.id(), "spacing").value_or("angle")};
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

Result<std::unique_ptr<Hdf5TableReader>> Hdf5TableReader::open(std::shared_ptr<const Hdf5File> file,
                                                               const std::string& dataset) {
  const Hdf5Lock lock;
  auto state = std::make_unique<State>();
  state->file = std::move(file);
  const hid_t id = state->file->state().file.id();
  const Result<std::string> name = dataset.empty() ? find_dataset(id) : dataset;
  if (!name) return name.error();
  Result<Hdf5Handle> opened = open_hdf5_dataset(*state->file, *name);
  if (!opened) return opened.error();
  state->dataset = *std::move(opened);
  if (Status shaped = read_shape(state->dataset.id(), state->rank, state->shape); !shaped) return shaped.error();
  if (Status stored = check_hdf5_storage(state->dataset.id()); !stored) return stored.error();
  const Result<Hdf5Extent> chunk = read_chunk(state->dataset.id(), state->rank, state->shape);
  if (!chunk) return chunk.error();
  state->chunk = *chunk;
  if (Status read = read_head(id, state->dataset.id(), state->shape, state->rank, state->head); !read) {
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
    return hdf5_refused("a part of the table cannot be read");
  }
  piece_done();
  return ok_status();
}

}  // namespace sbrdf::internal
