#include "converters/files/hdf5/samples_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "converters/baselines/scheme_samples.h"
#include "converters/source/reciprocity.h"
#include "formats/table/hdf5/samples.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kDeflate = 4;

/// `chosen`, but for what the options say.
Interpolation changed(Interpolation chosen, const Options& options) {
  chosen.kind = value_of(kInterpolationNames, options.text("interpolation").value_or("")).value_or(chosen.kind);
  chosen.kernel = value_of(kRbfKernelNames, options.text("rbf-kernel").value_or("")).value_or(chosen.kernel);
  return chosen;
}
bool says_how(const Options& options) { return options.has("interpolation") || options.has("rbf-kernel"); }

Result<Interpolation> stored_interpolation(const Hdf5Samples& stored) {
  const auto kind = value_of(kInterpolationNames, stored.interpolation);
  if (!kind) return unsupported(fmt::format("\"{}\" is no interpolation that is known here", stored.interpolation));
  if (*kind == Interpolation::Kind::kBarycentric) return Interpolation{*kind};
  const auto kernel = value_of(kRbfKernelNames, stored.kernel);
  if (!kernel) return unsupported(fmt::format("\"{}\" is no kernel that is known here", stored.kernel));
  return Interpolation{*kind, *kernel};
}

Result<SchemeSamples> samples_of(Hdf5Samples stored) {
  if (stored.ring_theta_deg.size() != stored.ring_count.size()) {
    return invalid_file("the datasets \"ring_theta\" and \"ring_count\" are not of one length");
  }
  SchemeSamples samples;
  samples.scheme.name = std::move(stored.scheme);
  for (std::size_t k = 0; k < stored.ring_count.size(); ++k) {
    const double count = stored.ring_count[k];
    const bool whole = count >= 1 && count <= static_cast<double>(kMostSchemeDirections) && count == std::floor(count);
    if (!whole)
      return invalid_file(fmt::format("\"ring_count\" has {} at {}, which is no number of directions", count, k));
    samples.scheme.rings.push_back({stored.ring_theta_deg[k], static_cast<std::size_t>(count)});
  }
  if (Status fine = check_scheme(samples.scheme); !fine) return fine.error();
  const std::uint64_t pairs = samples.scheme.reciprocal_pair_count();
  const std::uint64_t rows = stored.values.size() / stored.channels.size();
  if (rows != pairs) {
    return invalid_file(fmt::format("\"f_r\" has {} rows, and the scheme {} pairs of directions", rows, pairs));
  }
  const auto wrong =
      std::find_if_not(stored.values.begin(), stored.values.end(), [](float v) { return std::isfinite(v); });
  if (wrong != stored.values.end()) {
    const auto at = static_cast<std::size_t>(wrong - stored.values.begin());
    return invalid_file(fmt::format("\"f_r\" has a value that is not finite, in row {}", at / stored.channels.size()));
  }
  samples.channels = std::move(stored.channels);
  samples.values = std::move(stored.values);
  return samples;
}

Hdf5Samples stored_of(const SchemeSamples& samples, const Interpolation& how, const std::string& description) {
  Hdf5Samples stored;
  stored.scheme = samples.scheme.name;
  for (const Ring& ring : samples.scheme.rings) {
    stored.ring_theta_deg.push_back(ring.theta_deg);
    stored.ring_count.push_back(static_cast<double>(ring.count));
  }
  stored.channels = samples.channels;
  stored.values = samples.values;
  stored.interpolation = name_of(kInterpolationNames, how.kind);
  if (how.kind == Interpolation::Kind::kRbf) stored.kernel = name_of(kRbfKernelNames, how.kernel);
  stored.description = description;
  return stored;
}

Result<SchemeSamples> take_samples(const BrdfSource& source, const Options& options, Report& report,
                                   const Progress& progress) {
  const auto name = options.text("scheme");
  if (!name) return source.uniform_samples()->samples();
  const Result<UniformScheme> scheme = scheme_by_name(*name);
  if (!scheme) return scheme.error();
  if (!source.traits().reciprocal) remark_reciprocity(report, reciprocity_difference_percent(source));
  return sample_scheme(source, *scheme, progress);
}

}  // namespace

Result<std::unique_ptr<BrdfSource>> open_samples(const Hdf5File& file, std::shared_ptr<const ByteSource> bytes,
                                                 const Options& options) {
  Result<Hdf5Samples> stored = read_hdf5_samples(file);
  if (!stored) return stored.error();
  const Result<Interpolation> how = stored_interpolation(*stored);
  if (!how) return how.error();
  Result<SchemeSamples> samples = samples_of(*std::move(stored));
  if (!samples) return samples.error();
  Result<std::unique_ptr<SchemeSource>> source = SchemeSource::make(*std::move(samples), changed(*how, options));
  if (!source) return source.error();
  if (!says_how(options)) (*source)->keep_file(std::move(bytes));  // a copy would not say what was asked for
  return std::unique_ptr<BrdfSource>(*std::move(source));
}

bool wants_samples(const BrdfSource& source, const Options& options) {
  return options.has("scheme") || (source.uniform_samples() != nullptr && !options.has("grid"));
}

Status save_samples(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                    const Progress& progress) {
  if (!options.has("scheme") && !options.has("deflate")) {
    if (const auto stored = source.stored("hdf5")) {
      report.remarks.push_back({"copied", 1, "copied bit for bit"});
      return copy_bytes(*stored, sink, progress);
    }
  }
  const SchemeSource* given = source.uniform_samples();
  const Interpolation how = changed(given == nullptr ? Interpolation{} : given->interpolation(), options);
  const Result<SchemeSamples> samples = take_samples(source, options, report, progress);
  if (!samples) return samples.error();
  const UniformScheme& scheme = samples->scheme;
  report.remarks.push_back({"uniform_samples", static_cast<double>(scheme.reciprocal_pair_count()),
                            fmt::format("{} samples at the {} directions of scheme {}", scheme.reciprocal_pair_count(),
                                        scheme.direction_count(), scheme.name)});
  const auto deflate = static_cast<unsigned>(options.count("deflate").value_or(kDeflate));
  return write_hdf5_samples(sink, stored_of(*samples, how, source.traits().description), report_json(report), deflate);
}

}  // namespace sbrdf::internal
