#include "converters/files/sliced/sliced.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

#include "codec/file/reader.h"
#include "codec/series/series_file.h"
#include "converters/files/sliced/report_remarks.h"
#include "converters/files/sliced/series_source.h"
#include "converters/files/sliced/slice_options.h"
#include "converters/slicing/metadata.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {
namespace {

std::string theta_max_text(double theta_max_deg) {
  const std::string text = fmt::format("slices go up to theta_max = {:g} degrees", theta_max_deg);
  if (theta_max_deg >= 90) return text;
  const double beyond = 100 * std::cos(radians_from_degrees(theta_max_deg));
  return text + fmt::format("; in the {:.3g} % of the hemisphere beyond, the value is held at theta_max", beyond);
}

void remark_slicing(const Slicing& slicing, bool reciprocal, Report& told) {
  const SliceReport& report = slicing.report;
  const std::uint64_t samples = slicing.sliced.sample_count();
  std::vector<Remark>& remarks = told.remarks;
  remarks.push_back({"samples", static_cast<double>(samples),
                     std::to_string(samples) + " samples, " + std::to_string(slicing.sliced.crossing_count()) +
                         " of them at crossings"});
  if (samples < report.wanted_samples) {
    remark_count(told, "samples_not_placed", report.wanted_samples - samples,
                 "samples not placed: every interval is at the smallest gap");
  }
  remarks.push_back({"theta_max_deg", report.theta_max_deg, theta_max_text(report.theta_max_deg)});
  remarks.push_back({"values_fitted", report.fitted ? 1.0 : 0.0,
                     report.fitted ? "samples are fitted: they hold what brings the whole nearest to the source"
                                   : "samples hold what the source has there"});
  remarks.push_back({"precision_percent", 100 * slicing.precision.value_or(0),
                     slicing.precision.value_or(0) == 0
                         ? "samples are not rounded"
                         : "samples are rounded to within " + percent_text(100 * *slicing.precision)});
  for (const std::string& reason : report.reasons) remarks.push_back({"choice", 0, reason});
  remark_errors(report, slicing.sliced.channels, told);
  if (report.error_values_all_zero) {
    remarks.push_back({"held_back_values_all_zero", 1,
                       "the source is zero on all of these directions: neither error says how good the file is"});
  }
  if (!reciprocal) remark_reciprocity(told, report.reciprocity_difference_percent);
  remark_count(told, "filled_samples", report.filled_samples,
               "samples at directions that were not measured: the value of the nearest that was");
  remark_count(told, "zero_values", report.zero_values, "sampled values are exactly zero");
  remark_count(told, "negative_values", report.negative_values, "sampled values are negative, kept");
}

// What a copy cannot give back, or loses once more.
void remark_copy(const DecodedSliced& content, double precision, const Options& options, Report& told) {
  if (precision > content.precision) {
    told.remarks.push_back({"precision_percent", 100 * precision,
                            "samples are rounded again, to within " + percent_text(100 * precision) +
                                "; how large errors become is not measured, the source is needed for that"});
  } else if (precision < content.precision && options.has("precision")) {
    told.remarks.push_back({"precision_before_percent", 100 * content.precision,
                            "samples of IN were rounded to within " + percent_text(100 * content.precision) +
                                " already, which a finer precision does not undo"});
  }
  if (options.text("metadata") == "full") {
    told.remarks.push_back({"metadata_kept", 1, "metadata are those of IN: what it left out is not known any more"});
  }
}

Result<MadeFile> make_sliced_file(const BrdfSource& source, const Options& options, const Progress& progress) {
  const SliceOptions slices = slice_options(options);
  const Result<Slicing> slicing = slice_source(source, slices, progress);
  if (!slicing) return slicing.error();
  MadeFile made;
  remark_slicing(*slicing, source.traits().reciprocal, made.report);
  made.bytes = encode_sliced(slicing->sliced, slicing->lattice, encoding_of(*slicing, slices));
  made.error = slicing->report.error;
  return made;
}

/// Of both representations the one that serves better, with the reason.
Result<MadeFile> make_either(const BrdfSource& source, const Options& options, const Progress& progress) {
  const SliceOptions wanted = slice_options(options);
  const bool sized = std::holds_alternative<MaxBytes>(wanted.stop);
  StepwiseProgress steps(progress);
  Result<MadeFile> slices = make_sliced_file(source, options, steps.step(0.5));
  if (!sized && !target_percent(wanted.stop)) {
    if (slices) slices->report.remarks.push_back({"choice", 0, "slices: nothing asks for an error or a size"});
    return slices;
  }
  if (!slices && slices.error().code != ErrorCode::kDifference) return slices;
  Result<MadeFile> dense = make_series_file(source, options, steps.step(1));
  if (!dense && dense.error().code == ErrorCode::kDifference) return slices ? std::move(slices) : std::move(dense);
  if (!dense) return dense;
  if (!slices) {
    dense->report.remarks.push_back({"choice", 0, "dense: " + slices.error().message});
    return dense;
  }
  const auto error = [&](const MadeFile& made) { return objective_value(made.error, objective_of(wanted.stop)); };
  const bool take_dense = sized ? error(*dense) < error(*slices) : dense->bytes.size() < slices->bytes.size();
  MadeFile& chosen = take_dense ? *dense : *slices;
  chosen.report.remarks.push_back(
      {"choice", 0,
       sized ? fmt::format("{}: the error is {:.3g} % for {:.3g} %", take_dense ? "dense" : "slices", error(chosen),
                           error(take_dense ? *slices : *dense))
             : fmt::format("{}: {} bytes for {}", take_dense ? "dense" : "slices", chosen.bytes.size(),
                           (take_dense ? *slices : *dense).bytes.size())});
  return std::move(chosen);
}

Status write_made(const Result<MadeFile>& made, ByteSink& sink, Report& report) {
  if (!made) return made.error();
  report.remarks.insert(report.remarks.end(), made->report.remarks.begin(), made->report.remarks.end());
  return sink.write(0, made->bytes);
}

Status copy_sliced(const DecodedSliced& content, ByteSink& sink, const Options& options, Report& report) {
  const SliceOptions asked = slice_options(options);
  // Without the source there is no error that could choose a precision.
  const EncodeOptions encoding = {asked.precision.value_or(content.precision), asked.chunks};
  report.remarks.push_back({"copied", 1, "copied without sampling again"});
  remark_copy(content, encoding.precision, options, report);
  SlicedBrdf copy = content.sliced;
  if (encoding.precision != content.precision) copy.metadata = metadata_of_copy(copy.metadata, content.precision);
  if (options.has("metadata") && asked.metadata == MetadataDetail::kNone) copy.metadata.clear();
  if (options.has("metadata") && asked.metadata == MetadataDetail::kLean) copy.metadata = lean_metadata(copy.metadata);
  return sink.write(0, encode_sliced(copy, content.lattice, encoding));
}

}  // namespace

SourceTraits sliced_traits(const FrameSpec& frame, const std::vector<std::string>& channels) {
  SourceTraits traits;
  traits.format = "sbrdf";
  traits.description = "sliced BRDF, " + std::string(geometry(frame.id).name()) + " frame";
  traits.channels = channels;
  traits.isotropic = frame.symmetries.isotropic;
  traits.reciprocal = true;
  traits.theta_max_deg = traits.slice_theta_max_deg = frame.theta_max_deg;
  traits.beyond_theta_max = "the value held at theta_max";
  return traits;
}

SlicedSource::SlicedSource(DecodedSliced decoded)
    : decoded_(std::move(decoded)),
      traits_(sliced_traits(decoded_.sliced.frame, decoded_.sliced.channels)),
      for_vectors_(decoded_.sliced, decoded_.lattice) {}

void SlicedSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  std::call_once(angles_asked_, [&] { for_angles_.emplace(decoded_.sliced, decoded_.lattice); });
  const std::size_t channels = channel_count();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for_angles_->evaluate(pairs[k], values.subspan(k * channels, channels));
  }
}

void SlicedSource::evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                    std::span<float> values) const {
  for_vectors_.evaluate(w_i, w_v, values);
}

void SlicedSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  const auto& mask = decoded_.sliced.mask;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    flags[k] = !mask || !above_horizon(pairs[k]) || mask->is_measured(pairs[k]) ? 1 : 0;
  }
}

std::optional<MaskGrid> SlicedSource::mask_grid() const {
  if (!decoded_.sliced.mask) return std::nullopt;
  return decoded_.sliced.mask->grid;
}

Result<std::unique_ptr<BrdfSource>> open_sliced(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  if (is_series_file(*bytes)) return open_series(std::move(bytes), options.memory);
  Result<SlicedReader> reader = SlicedReader::open(*bytes, options.memory);
  if (!reader) return reader.error();
  Result<SlicedBrdf> sliced = reader->load_all();
  if (!sliced) return sliced.error();
  const std::string version = reader->version();
  const double precision = reader->index().scale.bound();
  return std::unique_ptr<BrdfSource>(std::make_unique<SlicedSource>(
      DecodedSliced{*std::move(sliced), std::move(*reader).take_lattice(), version, precision}));
}

Status save_sliced(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                   const Progress& progress) {
  if (const auto stored = source.stored("sbrdf"); stored && options.all().empty()) {
    report.remarks.push_back({"copied", 1, "copied as it is"});
    return copy_bytes(*stored, sink, progress);
  }
  switch (representation_of(options)) {
    case Representation::kDense:
      return write_made(make_series_file(source, options, progress), sink, report);
    case Representation::kAuto:
      return write_made(make_either(source, options, progress), sink, report);
    case Representation::kSliced:
      break;
  }
  if (const DecodedSliced* content = source.sliced(); content != nullptr && !ask_for_sampling(options)) {
    return copy_sliced(*content, sink, options, report);
  }
  return write_made(make_sliced_file(source, options, progress), sink, report);
}

}  // namespace sbrdf::internal
