#include "converters/files/format_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/analytic/analytic_file.h"
#include "converters/files/atlas/atlas_file.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/csv/csv_file.h"
#include "converters/files/dense/table_head.h"
#include "converters/files/exr/exr_file.h"
#include "converters/files/foreign.h"
#include "converters/files/hdf5/hdf5_file.h"
#include "converters/files/klems/klems_source.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/merl/merl_writer.h"
#include "converters/files/ngan/ngan.h"
#include "converters/files/npy/npy_file.h"
#include "converters/files/rgl/rgl.h"
#include "converters/files/rgl/rgl_writer.h"
#include "converters/files/scattered/scattered_file.h"
#include "converters/files/sliced/bundle_file.h"
#include "converters/files/sliced/slice_options.h"
#include "converters/files/sliced/sliced.h"
#include "converters/files/utia/utia.h"
#include "converters/files/zemax/zemax_source.h"
#include "formats/klems/klems.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"
#include "formats/table/exr_image.h"
#include "formats/table/hdf5/table.h"
#include "formats/table/npy.h"
#include "formats/zemax/zemax.h"

namespace sbrdf::internal {
namespace {

using Head = std::span<const std::byte>;
using Bytes = std::shared_ptr<const ByteSource>;

Match whole_if(bool recognised) { return recognised ? Match::kWhole : Match::kNone; }

Match recognise_ngan(Head head, std::uint64_t size) {
  if (recognises_ngan(head, size)) return Match::kWhole;
  return resembles_ngan(head) ? Match::kDamaged : Match::kNone;
}

// MERL files have no magic: what begins with three small counts is one, but where another row is surer. The header of
// an anisotropic table, whole or cut off where a MERL table would end, is no beginning of one: it would be denormal
// values.
Match recognise_merl(Head head, std::uint64_t size) {
  if (resembles_ngan(head) || recognises_ngan(head, size)) return Match::kNone;
  if (recognises_merl(head, size)) return Match::kWhole;
  return resembles_merl(head, size) ? Match::kPossible : Match::kNone;
}

// Likewise: the size, which no MERL table has, and numbers that make sense.
Match recognise_utia(Head head, std::uint64_t size) {
  if (!utia_shape_of_size(size)) return Match::kNone;
  return begins_like_utia(head, size) ? Match::kWhole : Match::kPossible;
}

template <LobeKind kind>
constexpr Format analytic_row(std::string_view description, std::string_view page) {
  return {.name = name_of(kLobeKindNames, kind),
          .extension = ".json",
          .description = description,
          .page = page,
          .capabilities = {Capability::kRead},
          .holds = {.negatives = false, .values = "formula"},
          .options = {},
          .recognise = [](Head head, std::uint64_t) { return recognise_analytic_file(head, kind); },
          .open = [](Bytes bytes, const Options&) { return open_analytic_file(*bytes); }};
}

const std::array kFormats = {
    Format{.name = "sbrdf",
           .extension = ".sbrdf",
           .description = "sliced BRDF",
           .page = "sbrdf.md",
           .capabilities = {Capability::kRead, Capability::kWrite, Capability::kParts, Capability::kLevels,
                            Capability::kBundled, Capability::kMetadata},
           .holds = {.non_reciprocal = false,
                     .unmeasured = true,
                     .channels = "any",
                     .values = "lossless or within a stored bound"},
           .options = sliced_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(is_container(head)); },
           .open = open_sliced,
           .save = save_sliced,
           .check = check_slice_options},
    Format{.name = "merl",
           .extension = ".binary",
           .description = "MERL table, isotropic, half/difference angles",
           .page = "merl.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.anisotropic = false, .non_reciprocal = false, .unmeasured = true, .values = "float64"},
           .options = merl_options(),
           .recognise = recognise_merl,
           .open = [](Bytes bytes, const Options& options) { return open_merl(std::move(bytes), options); },
           .save = save_merl},
    Format{.name = "ngan",
           .extension = ".dat",
           .description = "anisotropic MERL-style table over bins of the angles (Ngan 2005)",
           .page = "ngan.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .negatives = false, .channels = "any, without names", .values = "float32"},
           .options = ngan_options(),
           .recognise = recognise_ngan,
           .open = open_ngan,
           .save = save_ngan},
    Format{.name = "utia",
           .extension = ".bin",
           .description = "UTIA table, anisotropic, theta to 75 or 86 degrees",
           .page = "utia.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .values = "float64"},
           .options = utia_options(),
           .recognise = recognise_utia,
           .open = open_utia,
           .save = save_utia},
    Format{.name = "rgl",
           .extension = ".bsdf",
           .description = "RGL tensor file, RGB or spectral",
           .page = "rgl.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.channels = "RGB or wavelengths", .values = "float32"},
           .options = rgl_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_rgl(head)); },
           .open = open_rgl,
           .save = save_rgl,
           .check = check_rgl_options},
    Format{.name = "sbrdfz",
           .extension = ".sbrdfz",
           .description = "bundle of sliced BRDFs; FILE.sbrdfz:NAME is one of them",
           .page = "sbrdfz.md",
           .capabilities = {Capability::kRead, Capability::kManyMaterials},
           .holds = {.non_reciprocal = false, .unmeasured = true, .channels = "any", .values = "as .sbrdf"},
           .options = bundle_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(is_bundle(head)); },
           .open = open_bundle,
           .material = material_of_bundle},
    Format{.name = "hdf5",
           .extension = ".h5",
           .description = "dense table on any grid, or uniform samples, in HDF5",
           .page = "hdf5.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .channels = "any", .values = "float16, float32, float64"},
           .options = hdf5_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(is_hdf5(head)); },
           .open = open_hdf5,
           .save = save_hdf5,
           .fragile = true,
           .check = check_hdf5_options},
    analytic_row<LobeKind::kKurt>("JSON file of the parameters of a Kurt model", "kurt.md"),
    analytic_row<LobeKind::kWard>("JSON file of the parameters of a Ward model", "models.md"),
    analytic_row<LobeKind::kGgx>("JSON file of the parameters of a GGX model", "models.md"),
    Format{.name = "zemax",
           .extension = ".bsdf",
           .description = "Zemax (Ansys) tabular BSDF, text",
           .page = "zemax.md",
           .capabilities = {Capability::kRead},
           .holds = {.unmeasured = true, .channels = "1 or 3", .values = "decimal numbers"},
           .options = zemax_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_zemax(head)); },
           .open = open_zemax},
    Format{.name = "klems",
           .extension = ".xml",
           .description = "Klems matrix of WINDOW and Radiance",
           .page = "klems.md",
           .capabilities = {Capability::kRead},
           .holds = {.channels = "1", .values = "decimal numbers"},
           .options = klems_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_klems(head)); },
           .open = open_klems},
    Format{.name = "npy",
           .extension = ".npy",
           .description = "dense table as a NumPy array, with FILE.npy.json beside it",
           .page = "npy.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .channels = "any", .values = "float16, float32, float64"},
           .options = npy_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_npy(head)); },
           .open = open_npy,
           .save = save_npy,
           .beside = kNpyHeadSuffix,
           .is_beside = is_table_head},
    Format{.name = "atlas",
           .extension = ".json",
           .description = "texture atlas for engines: the manifest, with its texture beside it",
           .page = "atlas.md",
           .capabilities = {Capability::kRead},
           .holds = {.non_reciprocal = false, .values = "texels"},
           .options = {},
           .recognise =
               [](Head head, std::uint64_t) {
                 return whole_if(recognises_manifest({reinterpret_cast<const char*>(head.data()), head.size()}));
               },
           .open = open_atlas,
           .consists_of = files_of_atlas},
    Format{.name = "exr",
           .extension = ".exr",
           .description = "dense table as an OpenEXR image, rows of light and columns of view",
           .page = "exr.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .channels = "any", .values = "float16, float32"},
           .options = exr_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_exr(head)); },
           .open = open_exr,
           .save = save_exr,
           .check = check_exr_options},
    Format{.name = "csv",
           .extension = ".csv",
           .description = "dense table as text",
           .page = "csv.md",
           .capabilities = {Capability::kRead, Capability::kWrite},
           .holds = {.unmeasured = true, .channels = "any", .values = "float16, float32, float64"},
           .options = csv_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(recognises_csv(head)); },
           .open = open_csv,
           .save = save_csv},
    Format{.name = "scattered",
           .extension = ".txt",
           .description = "samples at any directions, as text, fitted to a dense table",
           .page = "scattered.md",
           .capabilities = {Capability::kRead},
           .holds = {.unmeasured = true, .channels = "any", .values = "text"},
           .options = scattered_options(),
           .recognise = recognise_scattered,
           .open = open_scattered},
};

// Of rows that are read only, some share an extension: ".bsdf files (zemax)".
std::string files_of(const Format& format) {
  const auto same = std::count_if(kFormats.begin(), kFormats.end(),
                                  [&](const Format& other) { return other.extension == format.extension; });
  const std::string files = std::string(format.extension) + " files";
  return same == 1 ? files : files + " (" + std::string(format.name) + ")";
}

Error not_recognised(Head head, std::uint64_t size) {
  if (const auto foreign = name_foreign(head)) return invalid_file("this is " + std::string(*foreign));
  if (is_text(head)) return invalid_file("a text file of no format that is known here");
  // A damaged MERL header looks like no format at all, so say what is wrong with it as one.
  const Result<MerlShape> shape = parse_merl_shape(head, size);
  std::string message = "not recognised: the content is of none of the formats listed by 'sbrdf formats'";
  if (shape) return invalid_file(message);
  return invalid_file(message + "; as a MERL table: " + shape.error().message, shape.error().offset);
}

/// The row that is surest of a file, and how sure.
struct Found {
  const Format* format = nullptr;
  Match match = Match::kNone;
};

Found find_format(Head head, std::uint64_t size) {
  Found surest;
  for (const Format& format : kFormats) {
    const Match match = format.recognise(head, size);
    if (match > surest.match) surest = {&format, match};
  }
  return surest;
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

Result<const Format*> recognise(const ByteSource& bytes) {
  if (bytes.size() == 0) return invalid_file("the file is empty");
  Result<std::vector<std::byte>> head = read_start(bytes, kHeadSize);
  if (!head) return head.error();
  Found found = find_format(*head, bytes.size());
  if (found.match != Match::kWhole && bytes.size() > kHeadSize && is_text(*head)) {
    head = read_start(bytes, kTextHeadSize);
    if (!head) return head.error();
    found = find_format(*head, bytes.size());
  }
  if (found.match == Match::kWhole) return found.format;
  if (found.format == nullptr || name_foreign(*head)) return not_recognised(*head, bytes.size());
  return found.format;
}

Result<std::unique_ptr<BrdfSource>> open_source(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<const Format*> format = recognise(*bytes);
  if (!format) return format.error();
  const std::string whose = files_of(**format) + " that are read";
  if (Status known = check_options(options, (*format)->options, OptionUse::kRead, whose); !known) return known.error();
  return (*format)->open(std::move(bytes), options);
}

Result<const Format*> find_writer(std::string_view extension) {
  std::string known;
  for (const Format& format : kFormats) {
    if (!format.capabilities.has(Capability::kWrite)) continue;
    const bool same = std::equal(extension.begin(), extension.end(), format.extension.begin(), format.extension.end(),
                                 [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
    if (same) return &format;
    known += (known.empty() ? "" : ", ") + std::string(format.extension);
  }
  return usage_error("no format is written with the extension '" + std::string(extension) + "'; use one of " + known);
}

bool reads_with(const Format& format, std::string_view option) {
  return format.capabilities.has(Capability::kRead) && find_option(format.options, option, OptionUse::kRead) != nullptr;
}

const Format* find_format_with(std::string_view option) {
  const auto found = std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& format) {
    return find_option(format.options, option, OptionUse::kBoth) != nullptr;
  });
  return found == kFormats.end() ? nullptr : &*found;
}

Status check_save(const Format& format, const Options& options) {
  const std::string whose = files_of(format) + " that are written";
  if (Status known = check_options(options, format.options, OptionUse::kWrite, whose); !known) return known;
  return format.check == nullptr ? ok_status() : format.check(options);
}

namespace {

/// Tells how large a file became.
class CountingSink final : public ByteSink {
 public:
  explicit CountingSink(ByteSink& sink) : sink_(sink) {}

  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    std::uint64_t seen = size_;
    const std::uint64_t end = offset + bytes.size();
    while (seen < end && !size_.compare_exchange_weak(seen, end)) {
    }
    return sink_.write(offset, bytes);
  }
  [[nodiscard]] std::string path() const override { return sink_.path(); }
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view suffix) override { return sink_.sibling(suffix); }
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  ByteSink& sink_;
  std::atomic<std::uint64_t> size_ = 0;
};

}  // namespace

Status save_source(const Format& format, const BrdfSource& source, ByteSink& sink, const Options& options,
                   Report& report, const Progress& progress) {
  if (!format.capabilities.has(Capability::kWrite)) return unsupported(files_of(format) + " cannot be written");
  if (Status allowed = check_save(format, options); !allowed) return allowed;
  report.findings = source.findings();
  CountingSink counting(sink);
  Status saved = format.save(source, counting, options, report, progress);
  report.bytes = counting.size();
  return saved;
}

}  // namespace sbrdf::internal
