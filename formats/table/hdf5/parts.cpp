#include "formats/table/hdf5/parts.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
constexpr std::uint64_t kInPlaceFrom = std::uint64_t{1} << 26U;
constexpr std::size_t kGrowth = std::size_t{1} << 20U;  // of a file in memory [bytes]
constexpr std::size_t kLongestText = std::size_t{1} << 20U;
constexpr std::size_t kLongestName = 256;
constexpr std::uint64_t kMostChunkNumbers = std::uint64_t{1} << 24U;

// The library's reason for a failure lasts until its next call, and closing a list of properties is one.
Result<Hdf5Handle> open_at(const std::string& name, hid_t access) {
  Hdf5Handle file(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (!file.ok()) return hdf5_refused("not a readable HDF5 file");
  return file;
}

Result<Hdf5Handle> open_image(std::span<const std::byte> bytes) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.id(), std::size_t{1} << 16U, false);
  std::vector<std::byte> copy(bytes.begin(), bytes.end());
  if (H5Pset_file_image(access.id(), copy.data(), copy.size()) < 0) return hdf5_refused("not a readable HDF5 file");
  return open_at("/dev/null/table.h5", access.id());  // where no file can be: the library refuses one that is there
}

herr_t refuse_external(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) { return -1; }

Hdf5Handle write_list(hid_t file, const std::string& name, hid_t type, std::size_t count, const void* values) {
  const hsize_t size = count;
  const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  Hdf5Handle set(H5Dcreate2(file, name.c_str(), type, space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Dclose);
  if (!set.ok() || H5Dwrite(set.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) return {};
  return set;
}

/// Of a dataset, which the library makes room for as soon as one number of it is read; 0 where there are no chunks.
std::uint64_t chunk_numbers(hid_t properties) {
  if (H5Pget_layout(properties) != H5D_CHUNKED) return 0;
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  const int rank = H5Pget_chunk(properties, H5S_MAX_RANK, sizes.data());
  std::uint64_t numbers = 1;
  for (int k = 0; k < rank; ++k) {
    numbers *= std::min<std::uint64_t>(sizes[static_cast<std::size_t>(k)], kMostChunkNumbers + 1);
    if (numbers > kMostChunkNumbers) break;
  }
  return numbers;
}

bool has_entries(hid_t dataset, std::uint64_t count) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const hssize_t points = H5Sget_simple_extent_npoints(space.id());
  return points >= 0 && static_cast<std::uint64_t>(points) == count;
}

}  // namespace

bool is_hdf5(std::span<const std::byte> head) {
  return head.size() >= kSignature.size() && std::memcmp(head.data(), kSignature.data(), kSignature.size()) == 0;
}

Hdf5File::Hdf5File(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5File::~Hdf5File() {
  const Hdf5Lock lock;
  state_.reset();
}
const std::string& Hdf5File::content() const { return state_->content; }

Result<std::shared_ptr<const Hdf5File>> Hdf5File::open(std::shared_ptr<const ByteSource> bytes) {
  const bool in_place = bytes->size() > kInPlaceFrom && !bytes->path().empty();
  if (!in_place) {
    Result<std::shared_ptr<const ByteSource>> viewed = with_view(bytes);
    if (!viewed) return viewed.error();
    bytes = *std::move(viewed);
  }
  const Hdf5Lock lock;
  Result<Hdf5Handle> opened = in_place ? open_at(bytes->path(), H5P_DEFAULT) : open_image(*bytes->view());
  if (!opened) return opened.error();
  auto state = std::make_unique<State>();
  state->file = *std::move(opened);
  state->bytes = std::move(bytes);
  state->content = read_hdf5_text(state->file.id(), "sbrdf").value_or("");
  return std::shared_ptr<const Hdf5File>(new Hdf5File(std::move(state)));
}

Result<Hdf5Output> Hdf5Output::create(ByteSink& sink) {
  const std::string path = sink.path();
  Hdf5Output output(sink, path.empty());
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (output.in_memory_) {
    H5Pset_fapl_core(access.id(), kGrowth, false);
  } else {
    H5Pset_fapl_stdio(access.id());  // the other one wants the real path of a link, which a nameless file has not
  }
  const std::string name = output.in_memory_ ? "in memory" : path;
  output.file_ = {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose};
  if (!output.file_.ok()) return hdf5_not_written();
  return output;
}

Status Hdf5Output::finish() {
  if (H5Fflush(file_.id(), H5F_SCOPE_LOCAL) < 0) return hdf5_not_written();
  if (!in_memory_) {
    hsize_t size = 0;
    if (H5Fget_filesize(file_.id(), &size) < 0 || !file_.close()) return hdf5_not_written();
    return sink_->write(size, {});
  }
  // Memory is asked for in steps, of which the file takes the first part.
  const ssize_t size = H5Fget_file_image(file_.id(), nullptr, 0);
  if (size < 0) return hdf5_not_written();
  std::vector<std::byte> image(static_cast<std::size_t>(size));
  if (H5Fget_file_image(file_.id(), image.data(), image.size()) < 0) return hdf5_not_written();
  return sink_->write(0, image);
}

Hdf5Handle hdf5_float_type(std::size_t size) {
  if (size == 8) return {H5Tcopy(H5T_IEEE_F64LE), H5Tclose};
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  if (size == 4) return type;
  // IEEE binary16: sign at bit 15, 5 bits of exponent from bit 10 with bias 15, 10 bits of mantissa.
  H5Tset_fields(type.id(), 15, 10, 5, 0, 10);
  H5Tset_size(type.id(), 2);
  H5Tset_ebias(type.id(), 15);
  return type;
}

Hdf5Handle hdf5_text_type(std::size_t size) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), std::max<std::size_t>(1, size));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

bool is_hdf5_float(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  std::size_t sign = 0, exponent = 0, exponent_size = 0, mantissa = 0, mantissa_size = 0;
  if (H5Tget_class(type) != H5T_FLOAT ||
      H5Tget_fields(type, &sign, &exponent, &exponent_size, &mantissa, &mantissa_size) < 0)
    return false;
  return (size == 2 && exponent_size == 5 && mantissa_size == 10) ||
         (size == 4 && exponent_size == 8 && mantissa_size == 23) ||
         (size == 8 && exponent_size == 11 && mantissa_size == 52);
}

bool write_hdf5_text(hid_t object, const char* name, const std::string& text) {
  const Hdf5Handle type = hdf5_text_type(text.size());
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name, type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string padded = text.empty() ? std::string(1, '\0') : text;
  return attribute.ok() && H5Awrite(attribute.id(), type.id(), padded.data()) >= 0;
}

bool write_hdf5_number(hid_t object, const char* name, double value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.ok() && H5Awrite(attribute.id(), H5T_NATIVE_DOUBLE, &value) >= 0;
}

std::optional<std::string> read_hdf5_text(hid_t object, const char* name) {
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

std::optional<double> read_hdf5_number(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Hdf5Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
  double value = 0;
  const bool one = H5Tget_class(type.id()) == H5T_FLOAT && H5Sget_simple_extent_npoints(space.id()) == 1;
  if (!one || H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &value) < 0) return std::nullopt;
  return value;
}

Hdf5Handle write_hdf5_numbers(hid_t file, const std::string& name, const std::vector<double>& numbers) {
  return write_list(file, name, hdf5_float_type(8).id(), numbers.size(), numbers.data());
}

Hdf5Handle write_hdf5_names(hid_t file, const std::string& name, const std::vector<std::string>& names) {
  std::size_t width = 1;
  for (const std::string& each : names) width = std::max(width, each.size());
  std::string padded;
  for (std::string each : names) {
    each.resize(width, '\0');
    padded += each;
  }
  return write_list(file, name, hdf5_text_type(width).id(), names.size(), padded.data());
}

std::optional<std::vector<double>> read_hdf5_numbers(hid_t dataset, std::uint64_t count) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  if (!has_entries(dataset, count) || (kind != H5T_FLOAT && kind != H5T_INTEGER)) return std::nullopt;
  std::vector<double> numbers(count);
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) return std::nullopt;
  return numbers;
}

std::optional<std::vector<std::string>> read_hdf5_names(hid_t dataset, std::uint64_t count) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const std::size_t width = H5Tget_size(type.id());
  const bool plain = H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
  if (!plain || !has_entries(dataset, count) || width > kLongestName) return std::nullopt;
  std::string padded(width * count, '\0');
  if (H5Dread(dataset, type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()) < 0) return std::nullopt;
  std::vector<std::string> names;
  for (std::uint64_t k = 0; k < count; ++k) {
    const char* name = padded.data() + k * width;
    names.emplace_back(name, strnlen(name, width));
  }
  return names;
}

Result<Hdf5Handle> open_hdf5_dataset(const Hdf5File& file, const std::string& name) {
  // What is read in boxes is kept by somebody else.
  const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.id(), 1, 0, 0);
  H5Pset_elink_cb(access.id(), refuse_external, nullptr);
  Hdf5Handle dataset(H5Dopen2(file.state().file.id(), name.c_str(), access.id()), H5Dclose);
  if (!dataset.ok()) return hdf5_refused("no dataset \"" + name + "\"");
  return dataset;
}

// What lies in other files is none of this one: a table could name any file of the machine. And what is not stored
// reads as zeros: a file of a hundred bytes could claim to hold any number of them.
Status check_hdf5_storage(hid_t dataset) {
  const Hdf5Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_external_count(properties.id()) > 0 || H5Pget_layout(properties.id()) == H5D_VIRTUAL) {
    return unsupported("the numbers of the dataset lie in other files");
  }
  if (chunk_numbers(properties.id()) > kMostChunkNumbers) return unsupported("chunks of more than 2^24 numbers");
  constexpr double kMostCompression = 1100;  // deflate makes a byte of 1032 at most
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const auto numbers = static_cast<double>(H5Sget_simple_extent_npoints(space.id()));
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  if (numbers * static_cast<double>(H5Tget_size(type.id())) <= kMostCompression * stored) return ok_status();
  return invalid_file("most of the dataset was never written");
}

Error hdf5_not_written() { return io_error(hdf5_message("cannot be written")); }
Error hdf5_refused(const std::string& what) { return invalid_file(hdf5_message(what)); }

}  // namespace sbrdf::internal
