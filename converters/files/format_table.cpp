#include "converters/files/format_table.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "converters/files/merl.h"
#include "converters/files/rgl.h"
#include "converters/slicing/metadata_json.h"
#include "converters/source/reciprocity.h"
#include "formats/sbrdf/container.h"

namespace sbrdf {
namespace {

Result<std::unique_ptr<BrdfSource>> load_merl(std::span<const std::byte> file) {
  Result<MerlTable> table = parse_merl(file);
  if (!table) return table.error();
  Result<std::unique_ptr<MerlSource>> source = MerlSource::make(*std::move(table));
  if (!source) return source.error();
  return std::unique_ptr<BrdfSource>(*std::move(source));
}

std::string percent(double value) {
  if (std::isinf(value)) return "infinite";
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), "%.3g %%", value);
  return {text.data(), static_cast<std::size_t>(size)};
}

void remark_count(std::vector<Remark>& remarks, const char* key, std::uint64_t count, const std::string& what) {
  if (count > 0) remarks.push_back({key, static_cast<double>(count), std::to_string(count) + " " + what});
}

Remark reciprocity_remark(double residual) {
  return {"reciprocity_residual_percent", residual,
          "reciprocity residual " + percent(residual) + ": f(i,v) and f(v,i) were replaced by their mean"};
}

Result<SavedFile> save_merl(const BrdfSource& source, const SaveOptions& options, const Progress& progress) {
  SavedFile saved;
  const auto* merl = dynamic_cast<const MerlSource*>(&source);
  if (merl != nullptr && merl->table().shape == options.merl_shape.value_or(merl->table().shape)) {
    saved.bytes = emit_merl(merl->table());
    saved.remarks.push_back({"copied", 1, "copied bit for bit"});
    return saved;
  }
  const SymmetrisedSource symmetrised(source);
  const bool reciprocal = source.traits().reciprocal;
  const MerlShape shape = options.merl_shape.value_or(kMerlShape);
  Result<MerlResampling> resampling = resample_merl(reciprocal ? source : symmetrised, shape, progress);
  if (!resampling) return resampling.error();
  saved.bytes = emit_merl(resampling->table);
  const MerlReport& report = resampling->report;
  if (!reciprocal) saved.remarks.push_back(reciprocity_remark(reciprocity_difference_percent(source)));
  remark_count(saved.remarks, "below_horizon_cells", report.below_horizon, "cells below the horizon, marked -1");
  remark_count(saved.remarks, "some_negative_cells", report.some_negative,
               "cells with one or two negative channels, kept");
  remark_count(saved.remarks, "all_negative_cells", report.all_negative,
               "cells negative in every channel, kept; readers take them for unmeasured");
  if (report.anisotropic_source_cut) {
    saved.remarks.push_back({"anisotropic_source_cut", 1, "the source is anisotropic; the table holds phi_h = 0 only"});
  }
  if (report.channel_repeated)
    saved.remarks.push_back({"channel_repeated", 1, "the only channel stands in R, G and B"});
  return saved;
}

void remark_slicing(const Slicing& slicing, bool reciprocal, std::vector<Remark>& remarks) {
  const SliceReport& report = slicing.report;
  const std::uint64_t samples = slicing.sliced.sample_count();
  remarks.push_back({"samples", static_cast<double>(samples),
                     std::to_string(samples) + " samples, " + std::to_string(slicing.sliced.crossing_count()) +
                         " of them at crossings"});
  if (samples < report.wanted_samples) {
    remark_count(remarks, "samples_not_placed", report.wanted_samples - samples,
                 "samples not placed: every interval is at the smallest gap");
  }
  for (const std::string& reason : report.reasons) remarks.push_back({"choice", 0, reason});
  remarks.push_back({"held_back_mre_percent", report.error.mre_percent,
                     "MRE " + percent(report.error.mre_percent) + " on " + std::to_string(report.error_directions) +
                         " directions that took no part in any choice"});
  remarks.push_back({"held_back_rel_l1_percent", report.error.rel_l1_percent,
                     "relative L1 error " + percent(report.error.rel_l1_percent) + " on the same"});
  if (report.error_values_all_zero) {
    remarks.push_back({"held_back_values_all_zero", 1,
                       "the source is zero on all of these directions: neither error says how good the file is"});
  }
  if (!reciprocal) remarks.push_back(reciprocity_remark(report.reciprocity_difference_percent));
  remark_count(remarks, "zero_values", report.zero_values, "sampled values are exactly zero");
  remark_count(remarks, "negative_values", report.negative_values, "sampled values are negative, kept");
}

// The errors that the metadata state were measured before the copy was rounded.
std::string metadata_of_copy(const std::string& text, double precision) {
  nlohmann::ordered_json json = parse_metadata(text);
  if (!json.is_object()) return text;
  if (json.contains("error") && !json.contains("error_before_rounding")) {
    json["error_before_rounding"] = json["error"];
    json.erase("error");
  }
  if (const auto before = json.find("precision_percent"); before != json.end() && *before != 0.0) {
    json["coded_before_percent"].push_back(*before);
  }
  json["precision_percent"] = 100 * precision;
  return emit_metadata(json);
}

Result<SavedFile> save_sliced(const BrdfSource& source, const SaveOptions& options, const Progress& progress) {
  SavedFile saved;
  if (const auto* sliced = dynamic_cast<const SlicedSource*>(&source); sliced && !options.slices) {
    SlicedBrdf copy = sliced->sliced();
    const double precision = options.copy_precision.value_or(sliced->precision());
    if (precision != sliced->precision()) copy.metadata = metadata_of_copy(copy.metadata, precision);
    saved.bytes = encode_sliced(copy, sliced->lattice(), {precision, options.copy_chunks});
    saved.remarks.push_back({"copied", 1, "copied without sampling again"});
    return saved;
  }
  const SliceOptions slices = options.slices.value_or(SliceOptions{});
  Result<Slicing> slicing = slice_source(source, slices, progress);
  if (!slicing) return slicing.error();
  saved.bytes = encode_sliced(slicing->sliced, slicing->lattice, slices.encoding);
  remark_slicing(*slicing, source.traits().reciprocal, saved.remarks);
  return saved;
}

constexpr std::array kFormats = {
    Format{"sbrdf", ".sbrdf", "sliced BRDF", is_container, load_sliced, save_sliced},
    Format{"merl", ".binary", "MERL table, isotropic, half/difference angles",
           [](std::span<const std::byte> file) { return recognises_merl(file, file.size()); }, load_merl, save_merl},
    Format{"rgl", ".bsdf", "RGL tensor file, RGB", recognises_rgl, load_rgl, nullptr},
};

bool is_text(std::span<const std::byte> file) {
  const auto head = file.first(std::min<std::size_t>(file.size(), 512));
  return std::all_of(head.begin(), head.end(), [](std::byte b) {
    const int c = std::to_integer<int>(b);
    return (c >= 32 && c != 127) || c == '\n' || c == '\r' || c == '\t';
  });
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

Result<std::unique_ptr<BrdfSource>> load_source(std::span<const std::byte> file) {
  if (file.empty()) return invalid_file("the file is empty");
  for (const Format& format : kFormats) {
    if (format.load != nullptr && format.recognises(file)) return format.load(file);
  }
  if (is_text(file)) return invalid_file("a text file; no text format is known here");
  // A table that was cut off has no exact size to be recognised by; its reader says what is missing.
  if (resembles_merl(file)) return load_merl(file);
  // MERL files have no magic: a damaged header looks like no format at all, so say what is wrong with it as one.
  Error error = load_merl(file).error();
  error.message = "not recognised: the content is of none of the formats listed by 'sbrdf formats'; as a MERL table: " +
                  error.message;
  return error;
}

Result<const Format*> find_writer(std::string_view extension) {
  std::string known;
  for (const Format& format : kFormats) {
    if (format.save == nullptr) continue;
    const bool same = std::equal(extension.begin(), extension.end(), format.extension.begin(), format.extension.end(),
                                 [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
    if (same) return &format;
    known += (known.empty() ? "" : ", ") + std::string(format.extension);
  }
  return usage_error("no format is written with the extension '" + std::string(extension) + "'; use one of " + known);
}

}  // namespace sbrdf
