#include "formats/table/hdf5/samples.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "formats/table/hdf5/parts.h"
#include "formats/table/hdf5/table.h"

namespace sbrdf::internal {
namespace {

constexpr hsize_t kChunkRows = 4096;
constexpr std::uint64_t kMostNumbers = std::uint64_t{1} << 28U;  // 32 channels of the pairs of 4096 directions

std::array<hsize_t, 2> rows_and_channels(const Hdf5Samples& samples) {
  return {samples.values.size() / samples.channels.size(), samples.channels.size()};
}

Hdf5Handle write_values(hid_t file, const Hdf5Samples& samples, unsigned deflate) {
  const std::array<hsize_t, 2> sizes = rows_and_channels(samples);
  const std::array<hsize_t, 2> chunk = {std::min(sizes[0], kChunkRows), sizes[1]};
  const Hdf5Handle space(H5Screate_simple(2, sizes.data(), nullptr), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  H5Pset_chunk(properties.id(), 2, chunk.data());
  if (deflate > 0) {
    H5Pset_shuffle(properties.id());
    H5Pset_deflate(properties.id(), deflate);
  }
  Hdf5Handle set(
      H5Dcreate2(file, kHdf5Dataset, hdf5_float_type(4).id(), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
      H5Dclose);
  const bool written =
      set.ok() && H5Dwrite(set.id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, samples.values.data()) >= 0;
  const bool told = written && write_hdf5_text(set.id(), "quantity", "f_r, without cosine") &&
                    write_hdf5_text(set.id(), "unit", "1/sr") &&
                    write_hdf5_text(set.id(), "rows", "pairs of directions a >= b at a (a + 1) / 2 + b");
  return told ? std::move(set) : Hdf5Handle();
}

/// The number of entries of a dataset of one dimension, 1 to `most`.
Result<std::uint64_t> entries(hid_t dataset, std::string_view name, std::uint64_t most) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const hssize_t points = H5Sget_simple_extent_ndims(space.id()) == 1 ? H5Sget_simple_extent_npoints(space.id()) : 0;
  if (points >= 1 && static_cast<std::uint64_t>(points) <= most) return static_cast<std::uint64_t>(points);
  return unsupported("the dataset \"" + std::string(name) + "\" must have one dimension of 1 to " +
                     std::to_string(most) + " entries");
}

Result<Hdf5Handle> open_list(const Hdf5File& file, const std::string& name, std::uint64_t most, std::uint64_t& count) {
  Result<Hdf5Handle> dataset = open_hdf5_dataset(file, name);
  if (!dataset) return dataset;
  const Result<std::uint64_t> found = entries(dataset->id(), name, most);
  if (!found) return found.error();
  if (Status stored = check_hdf5_storage(dataset->id()); !stored) return stored.error();
  count = *found;
  return dataset;
}

Result<std::vector<double>> read_rings(const Hdf5File& file, const std::string& name) {
  std::uint64_t count = 0;
  const Result<Hdf5Handle> dataset = open_list(file, name, kHdf5MostRings, count);
  if (!dataset) return dataset.error();
  auto numbers = read_hdf5_numbers(dataset->id(), count);
  if (!numbers) return hdf5_refused("the dataset \"" + name + "\" is not of numbers");
  return *std::move(numbers);
}

Result<std::vector<std::string>> read_channels(const Hdf5File& file) {
  std::uint64_t count = 0;
  const Result<Hdf5Handle> dataset = open_list(file, "channel", kHdf5MostChannels, count);
  if (!dataset) return dataset.error();
  auto names = read_hdf5_names(dataset->id(), count);
  if (!names) return hdf5_refused("the dataset \"channel\" is not of text of a fixed width");
  return *std::move(names);
}

Result<std::vector<float>> read_values(const Hdf5File& file, std::uint64_t channels) {
  const Result<Hdf5Handle> dataset = open_hdf5_dataset(file, kHdf5Dataset);
  if (!dataset) return dataset.error();
  const Hdf5Handle space(H5Dget_space(dataset->id()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset->id()), H5Tclose);
  std::array<hsize_t, 2> sizes{};
  if (H5Sget_simple_extent_ndims(space.id()) != 2 ||
      H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr) != 2 || sizes[1] != channels) {
    return invalid_file("the dataset \"f_r\" is not of two dimensions, pairs and channels");
  }
  if (sizes[0] > kMostNumbers / sizes[1]) return unsupported("the dataset \"f_r\" has more than 2^28 numbers");
  if (!is_hdf5_float(type.id())) return unsupported("the numbers of the dataset \"f_r\" are no IEEE floats");
  if (Status stored = check_hdf5_storage(dataset->id()); !stored) return stored.error();
  std::vector<float> values(sizes[0] * sizes[1]);
  if (H5Dread(dataset->id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    return hdf5_refused("the dataset \"f_r\" cannot be read");
  }
  return values;
}

}  // namespace

Result<Hdf5Samples> read_hdf5_samples(const Hdf5File& file) {
  const Hdf5Lock lock;
  const hid_t id = file.state().file.id();
  if (read_hdf5_text(id, "version").value_or("") != "1") {
    return unsupported("uniform samples of another version than 1");
  }
  Hdf5Samples samples;
  samples.scheme = read_hdf5_text(id, "scheme").value_or("");
  samples.interpolation = read_hdf5_text(id, "interpolation").value_or("");
  samples.kernel = read_hdf5_text(id, "kernel").value_or("");
  samples.description = read_hdf5_text(id, "description").value_or("");
  samples.theta_max_deg = read_hdf5_number(id, "theta_max").value_or(90);
  if (!(samples.theta_max_deg > 0 && samples.theta_max_deg <= 90)) {
    return invalid_file("the attribute \"theta_max\" is not within 0 and 90 degrees");
  }
  for (auto [name, into] : {std::pair{"ring_theta", &samples.ring_theta_deg}, {"ring_count", &samples.ring_count}}) {
    Result<std::vector<double>> numbers = read_rings(file, name);
    if (!numbers) return numbers.error();
    *into = *std::move(numbers);
  }
  Result<std::vector<std::string>> channels = read_channels(file);
  if (!channels) return channels.error();
  samples.channels = *std::move(channels);
  Result<std::vector<float>> values = read_values(file, samples.channels.size());
  if (!values) return values.error();
  samples.values = *std::move(values);
  return samples;
}

Status write_hdf5_samples(ByteSink& sink, const Hdf5Samples& samples, const std::string& report, unsigned deflate) {
  if (samples.values.size() > kMostNumbers) return unsupported("more than 2^28 numbers");
  const Hdf5Lock lock;
  Result<Hdf5Output> file = Hdf5Output::create(sink);
  if (!file) return file.error();
  const hid_t id = file->id();
  const bool head = write_hdf5_text(id, "sbrdf", kHdf5UniformSamples) && write_hdf5_text(id, "version", "1") &&
                    write_hdf5_text(id, "scheme", samples.scheme) &&
                    write_hdf5_text(id, "interpolation", samples.interpolation) &&
                    (samples.kernel.empty() || write_hdf5_text(id, "kernel", samples.kernel)) &&
                    write_hdf5_text(id, "description", samples.description) &&
                    write_hdf5_number(id, "theta_max", samples.theta_max_deg) && write_hdf5_text(id, "report", report);
  const auto in_degrees = [](const Hdf5Handle& set) { return set.ok() && write_hdf5_text(set.id(), "unit", "degree"); };
  const bool rings = head && in_degrees(write_hdf5_numbers(id, "ring_theta", samples.ring_theta_deg)) &&
                     write_hdf5_numbers(id, "ring_count", samples.ring_count).ok() &&
                     write_hdf5_names(id, "channel", samples.channels).ok();
  if (!rings || !write_values(id, samples, deflate).ok()) return hdf5_not_written();
  return file->finish();
}

}  // namespace sbrdf::internal
