#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <utility>

#include "formats/table/hdf5/parts.h"
#include "formats/table/hdf5/table.h"

namespace sbrdf::internal {

struct Hdf5TableWriter::State {
  Hdf5Output file;
  Hdf5Handle dataset;
};

namespace {

std::array<hsize_t, kHdf5Rank> sizes_of(const Hdf5Extent& extent) {
  std::array<hsize_t, kHdf5Rank> sizes{};
  std::copy(extent.begin(), extent.end(), sizes.begin());
  return sizes;
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

bool write_axis(hid_t file, const Hdf5Handle& table, unsigned at, const Hdf5Axis& axis) {
  const Hdf5Handle scale = write_hdf5_numbers(file, name_of_scale(axis.name), axis.nodes_deg);
  return attach(table, scale, at, axis.name) && write_hdf5_text(scale.id(), "unit", "degree") &&
         write_hdf5_text(scale.id(), "ends", axis.ends) && write_hdf5_text(scale.id(), "spacing", axis.spacing);
}

bool write_head(hid_t file, const Hdf5Handle& table, const Hdf5Head& head) {
  bool good = write_hdf5_text(table.id(), "quantity", "f_r, without cosine") &&
              write_hdf5_text(table.id(), "unit", "1/sr") && write_hdf5_text(table.id(), "unmeasured", "NaN") &&
              write_hdf5_text(file, "sbrdf", kHdf5DenseTable) && write_hdf5_text(file, "version", "1") &&
              write_hdf5_text(file, "frame", head.frame) && write_hdf5_text(file, "description", head.description) &&
              write_hdf5_number(table.id(), "theta_max", head.theta_max_deg) &&
              write_hdf5_text(table.id(), "beyond_theta_max", head.beyond) &&
              write_hdf5_number(table.id(), "slice_theta_max", head.slice_theta_max_deg);
  for (unsigned axis = 0; axis < head.axes.size(); ++axis) {
    good = good && write_axis(file, table, axis, head.axes[axis]);
  }
  return good && attach(table, write_hdf5_names(file, "channel", head.channels), kHdf5Rank - 1, "channel");
}

Hdf5Handle make_table(hid_t file, const Hdf5Head& head, const Hdf5Extent& chunk, unsigned deflate) {
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
  const Hdf5Handle type = hdf5_float_type(head.value_size);
  return {H5Dcreate2(file, kHdf5Dataset, type.id(), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Dclose};
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
  Result<Hdf5Output> file = Hdf5Output::create(sink);
  if (!file) return file.error();
  auto state = std::make_unique<State>(State{*std::move(file), {}});
  const hid_t id = state->file.id();
  state->dataset = make_table(id, head, chunk, deflate);
  if (!state->dataset.ok() || !write_head(id, state->dataset, head)) return hdf5_not_written();
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
    return hdf5_not_written();
  }
  return ok_status();
}

Status Hdf5TableWriter::finish(const std::string& report) {
  const Hdf5Lock lock;
  const bool told = report.empty() || write_hdf5_text(state_->file.id(), "report", report);
  if (!told || !state_->dataset.close()) return hdf5_not_written();
  return state_->file.finish();
}

}  // namespace sbrdf::internal
