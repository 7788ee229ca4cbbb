#include "converters/files/sliced/series_source.h"

#include <fmt/format.h>

#include <utility>

#include "codec/series/series_file.h"
#include "codec/series/series_table.h"
#include "converters/files/sliced/slice_options.h"
#include "converters/series/series_fit.h"

namespace sbrdf::internal {

SourceTraits series_traits(const SeriesBrdf& brdf) {
  SourceTraits traits;
  traits.format = "sbrdf";
  traits.description = "dense table from a series, half/difference angles";
  traits.channels = brdf.channels;
  traits.isotropic = brdf.symmetries.isotropic;
  traits.reciprocal = true;
  traits.theta_max_deg = traits.slice_theta_max_deg = brdf.warp.theta_max_deg;
  traits.beyond_theta_max = "the value held at the end of the table";
  return traits;
}

SeriesSource::SeriesSource(const SeriesBrdf& brdf, VectorEvaluator table, std::shared_ptr<const ByteSource> bytes)
    : table_(std::move(table)), traits_(series_traits(brdf)), metadata_(brdf.metadata), bytes_(std::move(bytes)) {}

void SeriesSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  evaluate_pairs(table_, pairs, values);
}

void SeriesSource::evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                    std::span<float> values) const {
  table_.evaluate(w_i, w_v, values);
}

std::shared_ptr<const ByteSource> SeriesSource::stored(std::string_view format) const {
  return format == "sbrdf" ? bytes_ : nullptr;
}

Result<std::unique_ptr<BrdfSource>> open_series(std::shared_ptr<const ByteSource> bytes, const MemoryLimit& memory,
                                                std::uint32_t most_level) {
  const Result<SeriesBrdf> brdf = decode_series(*bytes, most_level);
  if (!brdf) return brdf.error();
  Result<VectorEvaluator> table = make_table(*brdf, memory.of(bytes->size()));
  if (!table) return table.error();
  return std::unique_ptr<BrdfSource>(std::make_unique<SeriesSource>(*brdf, *std::move(table), std::move(bytes)));
}

Result<MadeFile> make_series_file(const BrdfSource& source, const Options& options, const Progress& progress) {
  const Result<SeriesFit> fit = fit_series(source, slice_options(options), progress);
  if (!fit) return fit.error();
  const SeriesBrdf& brdf = fit->brdf;
  MadeFile made{encode_series(brdf), {}, fit->report.error};
  Report& report = made.report;
  const std::size_t coefficients = brdf.coefficient_count();
  report.remarks.push_back({"coefficients", static_cast<double>(coefficients),
                            fmt::format("dense: {} coefficients of {} fields, up to {} x {} x {} x {} functions along "
                                        "theta_h, theta_d, phi_d, phi_h",
                                        coefficients, brdf.field_count(), brdf.shape.theta_h, brdf.shape.theta_d,
                                        brdf.shape.phi_d, brdf.shape.phi_h)});
  report.remarks.push_back(
      {"table_bytes", static_cast<double>(fit->table_bytes),
       fmt::format("expanded for evaluation it takes {:.2f} MB", 1e-6 * static_cast<double>(fit->table_bytes))});
  report.remarks.push_back({"theta_max_deg", fit->report.theta_max_deg,
                            fmt::format("the table goes up to theta_max = {:g} degrees; beyond, its end is held",
                                        fit->report.theta_max_deg)});
  remark_errors(fit->report, brdf.channels, report);
  if (!source.traits().reciprocal) remark_reciprocity(report, fit->report.reciprocity_difference_percent);
  if (source.mask_grid()) {
    report.remarks.push_back({"mask_lost", 1,
                              "warning: which directions were not measured is not said in a dense file; they are "
                              "filled in"});
  }
  return made;
}

}  // namespace sbrdf::internal
