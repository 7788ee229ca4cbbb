#include "converters/files/format_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/foreign.h"
#include "converters/files/kurt/kurt_file.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/merl/merl_writer.h"
#include "converters/files/rgl/rgl.h"
#include "converters/files/rgl/rgl_writer.h"
#include "converters/files/sliced/bundle_file.h"
#include "converters/files/sliced/slice_options.h"
#include "converters/files/sliced/sliced.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"

namespace sbrdf::internal {
namespace {

using Head = std::span<const std::byte>;
using Bytes = std::shared_ptr<const ByteSource>;

Match whole_if(bool recognised) { return recognised ? Match::kWhole : Match::kNone; }

// MERL files have no magic: what begins with three small counts is one, but where another row is sure.
Match recognise_merl(Head head, std::uint64_t size) {
  if (recognises_merl(head, size)) return Match::kWhole;
  return resembles_merl(head, size) ? Match::kDamaged : Match::kNone;
}

const std::array kFormats = {
    Format{.name = "sbrdf",
           .extension = ".sbrdf",
           .description = "sliced BRDF",
           .page = "sbrdf.md",
           .capabilities = {Capability::kRead, Capability::kWrite, Capability::kParts, Capability::kLevels,
                            Capability::kBundled, Capability::kMetadata},
           .holds = {.unmeasured = true, .channels = "any", .values = "lossless or within a stored bound"},
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
           .holds = {.unmeasured = true, .channels = "any", .values = "as .sbrdf"},
           .options = bundle_options(),
           .recognise = [](Head head, std::uint64_t) { return whole_if(is_bundle(head)); },
           .open = open_bundle,
           .material = material_of_bundle},
    Format{.name = "kurt",
           .extension = ".json",
           .description = "parameters of a Kurt model",
           .page = "kurt.md",
           .capabilities = {Capability::kRead},
           .holds = {.negatives = false, .values = "formula"},
           .options = {},
           .recognise = [](Head head, std::uint64_t) { return recognise_kurt_file(head); },
           .open = [](Bytes bytes, const Options&) { return open_kurt_file(*bytes); }},
};

std::string files_of(const Format& format) { return std::string(format.extension) + " files"; }

Error not_recognised(Head head, std::uint64_t size) {
  if (const auto foreign = name_foreign(head)) return invalid_file("this is " + std::string(*foreign));
  if (is_text(head)) return invalid_file("a text file of no format that is known here");
  // A damaged MERL header looks like no format at all, so say what is wrong with it as one.
  const Result<MerlShape> shape = parse_merl_shape(head, size);
  std::string message = "not recognised: the content is of none of the formats listed by 'sbrdf formats'";
  if (shape) return invalid_file(message);
  return invalid_file(message + "; as a MERL table: " + shape.error().message, shape.error().offset);
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

Result<const Format*> recognise(const ByteSource& bytes) {
  if (bytes.size() == 0) return invalid_file("the file is empty");
  const Result<std::vector<std::byte>> head = read_start(bytes, kHeadSize);
  if (!head) return head.error();
  const Format* damaged = nullptr;
  for (const Format& format : kFormats) {
    const Match match = format.recognise(*head, bytes.size());
    if (match == Match::kWhole) return &format;
    if (match == Match::kDamaged) damaged = &format;
  }
  if (damaged == nullptr || name_foreign(*head)) return not_recognised(*head, bytes.size());
  return damaged;
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
  report.findings = source.traits().findings;
  CountingSink counting(sink);
  Status saved = format.save(source, counting, options, report, progress);
  report.bytes = counting.size();
  return saved;
}

}  // namespace sbrdf::internal
