#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <utility>

#include "formats/table/hdf5_handle.h"
#include "formats/table/hdf5_table.h"

namespace sbrdf::internal {

struct Hdf5TableWriter::State {
  ByteSink* sink = nullptr;
  bool in_memory = false;
  Hdf5Handle file;
  Hdf5Handle dataset;
};

namespace {

constexpr std::size_t kGrowth = std::size_t{1} << 20U;  // of a file in memory [bytes]

Error failed(const std::string& what) { return io_error(hdf5_message(what)); }

std::array<hsize_t, kHdf5Rank> sizes_of(const Hdf5Extent& extent) {
  std::array<hsize_t, kHdf5Rank> sizes{};
  std::copy(extent.begin(), extent.end(), sizes.begin());
  return sizes;
}

Hdf5Handle number_type(std::size_t size) {
  if (size == 8) return {H5Tcopy(H5T_IEEE_F64LE), H5Tclose};
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  if (size == 4) return type;
  // IEEE binary16: sign at bit 15, 5 bits of exponent from bit 10 with bias 15, 10 bits of mantissa.
  H5Tset_fields(type.id(), 15, 10, 5, 0, 10);
  H5Tset_size(type.id(), 2);
  H5Tset_ebias(type.id(), 15);
  return type;
}

Hdf5Handle string_type(std::size_t size) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), std::max<std::size_t>(1, size));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

bool write_text(hid_t object, const char* name, const std::string& text) {
  const Hdf5Handle type = string_type(text.size());
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name, type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string padded = text.empty() ? std::string(1, '\0') : text;
  return attribute.ok() && H5Awrite(attribute.id(), type.id(), padded.data()) >= 0;
}

bool write_number(hid_t object, const char* name, double value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.ok() && H5Awrite(attribute.id(), H5T_NATIVE_DOUBLE, &value) >= 0;
}

/// A dataset of one dimension, without the time at which it was made.
Hdf5Handle make_scale(hid_t file, const std::string& name, hid_t type, std::size_t count, const void* values) {
  const hsize_t size = count;
  const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  Hdf5Handle set(H5Dcreate2(file, name.c_str(), type, space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Dclose);
  if (!set.ok() || H5Dwrite(set.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) return {};
  return set;
}

/// Names of datasets hold no blanks: "phi_v - phi_i" becomes "phi_v-phi_i".
std::string name_of_scale(std::string name) {
  std::erase(name, ' ');
  return name;
}

bool attach(const Hdf5Handle& table, const Hdf5Handle& scale, unsigned axis, const std::string& name) {
  return scale.ok() && H5DSset_scale(scale.id(), name.c_str()) >= 0 &&
         H5DSattach_scale(table.id(), scale.id(), axis) >= 0 && H5DSset_label(table.id(), axis, name.c_str()) >= 0;
}

bool write_axis(const Hdf5Handle& file, const Hdf5Handle& table, unsigned at, const Hdf5Axis& axis) {
  const Hdf5Handle type(H5Tcopy(H5T_IEEE_F64LE), H5Tclose);
  const Hdf5Handle scale =
      make_scale(file.id(), name_of_scale(axis.name), type.id(), axis.nodes_deg.size(), axis.nodes_deg.data());
  return attach(table, scale, at, axis.name) && write_text(scale.id(), "unit", "degree") &&
         write_text(scale.id(), "ends", axis.ends) && write_text(scale.id(), "spacing", axis.spacing);
}

bool write_channels(const Hdf5Handle& file, const Hdf5Handle& table, const std::vector<std::string>& channels) {
  std::size_t width = 1;
  for (const std::string& name : channels) width = std::max(width, name.size());
  std::string padded;
  for (std::string name : channels) {
    name.resize(width, '\0');
    padded += name;
  }
  const Hdf5Handle type = string_type(width);
  const Hdf5Handle scale = make_scale(file.id(), "channel", type.id(), channels.size(), padded.data());
  return attach(table, scale, kHdf5Rank - 1, "channel");
}

bool write_head(const Hdf5Handle& file, const Hdf5Handle& table, const Hdf5Head& head) {
  bool good = write_text(table.id(), "quantity", "f_r, without cosine") && write_text(table.id(), "unit", "1/sr") &&
              write_text(table.id(), "unmeasured", "NaN") && write_text(file.id(), "sbrdf", "dense table") &&
              write_text(file.id(), "version", "1") && write_text(file.id(), "frame", head.frame) &&
              write_text(file.id(), "description", head.description) &&
              write_number(table.id(), "theta_max", head.theta_max_deg) &&
              write_text(table.id(), "beyond_theta_max", head.beyond) &&
              write_number(table.id(), "slice_theta_max", head.slice_theta_max_deg);
  for (unsigned axis = 0; axis < head.axes.size(); ++axis) {
    good = good && write_axis(file, table, axis, head.axes[axis]);
  }
  return good && write_channels(file, table, head.channels);
}

Hdf5Handle make_table(const Hdf5Handle& file, const Hdf5Head& head, const Hdf5Extent& chunk, unsigned deflate) {
  Hdf5Extent shape{};
  for (std::size_t axis = 0; axis < head.axes.size(); ++axis) shape[axis] = head.axes[axis].nodes_deg.size();
  shape.back() = head.channels.size();
  const auto sizes = sizes_of(shape);
  const auto chunk_sizes = sizes_of(chunk);
  const Hdf5Handle space(H5Screate_simple(kHdf5Rank, sizes.data(), nullptr), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  H5Pset_chunk(properties.id(), kHdf5Rank, chunk_sizes.data());
  if (deflate > 0) {
    H5Pset_shuffle(properties.id());
    H5Pset_deflate(properties.id(), deflate);
  }
  const Hdf5Handle type = number_type(head.value_size);
  return {H5Dcreate2(file.id(), kHdf5Dataset, type.id(), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
          H5Dclose};
}

}  // namespace

Hdf5TableWriter::Hdf5TableWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5TableWriter::~Hdf5TableWriter() {
  const Hdf5Lock lock;
  state_.reset();
}

Result<std::unique_ptr<Hdf5TableWriter>> Hdf5TableWriter::create(ByteSink& sink, const Hdf5Head& head,
                                                                 const Hdf5Extent& chunk, unsigned deflate) {
  const Hdf5Lock lock;
  auto state = std::make_unique<State>();
  state->sink = &sink;
  const std::string path = sink.path();
  state->in_memory = path.empty();
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (state->in_memory) {
    H5Pset_fapl_core(access.id(), kGrowth, false);
  } else {
    H5Pset_fapl_stdio(access.id());  // the other one wants the real path of a link, which a nameless file has not
  }
  const std::string name = state->in_memory ? "in memory" : path;
  state->file = {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose};
  if (!state->file.ok()) return failed("cannot be written");
  state->dataset = make_table(state->file, head, chunk, deflate);
  if (!state->dataset.ok() || !write_head(state->file, state->dataset, head)) return failed("cannot be written");
  return std::unique_ptr<Hdf5TableWriter>(new Hdf5TableWriter(std::move(state)));
}

Status Hdf5TableWriter::write(const Hdf5Extent& first, const Hdf5Extent& count, std::span<const double> values) {
  const Hdf5Lock lock;
  const auto starts = sizes_of(first);
  const auto counts = sizes_of(count);
  const Hdf5Handle memory(H5Screate_simple(kHdf5Rank, counts.data(), nullptr), H5Sclose);
  const Hdf5Handle box(H5Dget_space(state_->dataset.id()), H5Sclose);
  if (H5Sselect_hyperslab(box.id(), H5S_SELECT_SET, starts.data(), nullptr, counts.data(), nullptr) < 0 ||
      H5Dwrite(state_->dataset.id(), H5T_NATIVE_DOUBLE, memory.id(), box.id(), H5P_DEFAULT, values.data()) < 0) {
    return failed("cannot be written");
  }
  return ok_status();
}

Status Hdf5TableWriter::finish(const std::string& report) {
  const Hdf5Lock lock;
  const bool told = report.empty() || write_text(state_->file.id(), "report", report);
  if (!told || !state_->dataset.close() || H5Fflush(state_->file.id(), H5F_SCOPE_LOCAL) < 0) {
    return failed("cannot be written");
  }
  if (!state_->in_memory) {
    hsize_t size = 0;
    if (H5Fget_filesize(state_->file.id(), &size) < 0 || !state_->file.close()) return failed("cannot be written");
    return state_->sink->write(size, {});
  }
  // Memory is asked for in steps, of which the file takes the first part.
  const ssize_t size = H5Fget_file_image(state_->file.id(), nullptr, 0);
  if (size < 0) return failed("cannot be written");
  std::vector<std::byte> image(static_cast<std::size_t>(size));
  if (H5Fget_file_image(state_->file.id(), image.data(), image.size()) < 0) return failed("cannot be written");
  return state_->sink->write(0, image);
}

}  // namespace sbrdf::internal
