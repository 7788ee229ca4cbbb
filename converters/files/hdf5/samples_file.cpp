#include "converters/files/hdf5/samples_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "converters/baselines/scheme_samples.h"
#include "converters/files/value_options.h"
#include "converters/source/reciprocity.h"
#include "formats/table/hdf5/samples.h"

namespace sbrdf::internal {
namespace {

/// `chosen`, but for what the options say.
Interpolation changed(Interpolation chosen, const Options& options) {
  chosen.kind = value_of(kInterpolationNames, options.text("interpolation").value_or("")).value_or(chosen.kind);
  if (const auto kernel = options.text("rbf-kernel")) {
    chosen = {Interpolation::Kind::kRbf, value_of(kRbfKernelNames, *kernel).value_or(chosen.kernel)};
  }
  return chosen;
}
bool says_how(const Options& options) { return options.has("interpolation") || options.has("rbf-kernel"); }

/// Of samples, values below 0 can become 0; none can be left out.
Status apply_policy(const Options& options, std::vector<float>& values) {
  const Negatives negatives = policy_of(options, NonFinite::kRefuse).negatives;
  const bool some = std::any_of(values.begin(), values.end(), [](float v) { return v < 0; });
  if (!some || negatives == Negatives::kKeep) return ok_status();
  if (negatives == Negatives::kUnmeasured) {
    return unsupported("--negatives unmeasured: every pair of uniform samples must have a value");
  }
  for (float& value : values) value = std::max(value, 0.0F);
  return ok_status();
}

Result<Interpolation> stored_interpolation(const Hdf5Samples& stored) {
  const auto kind = value_of(kInterpolationNames, stored.interpolation);
  if (stored.interpolation.empty()) return invalid_file("the attribute \"interpolation\" is missing, or is no text");
  if (!kind) return unsupported(fmt::format("\"{}\" is no interpolation that is known here", stored.interpolation));
  if (*kind == Interpolation::Kind::kBarycentric) return Interpolation{*kind};
  const auto kernel = value_of(kRbfKernelNames, stored.kernel);
  if (stored.kernel.empty()) return invalid_file("the attribute \"kernel\" is missing, or is no text");
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
  if (!usable_names(stored.channels)) return invalid_file("two channels have one name, or one has none");
  samples.description = std::move(stored.description);
  samples.theta_max_deg = stored.theta_max_deg;
  samples.channels = std::move(stored.channels);
  samples.values = std::move(stored.values);
  return samples;
}

Hdf5Samples stored_of(const SchemeSamples& samples, const Interpolation& how) {
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
  stored.description = samples.description;
  stored.theta_max_deg = samples.theta_max_deg;
  return stored;
}

Result<SchemeSamples> take_samples(const BrdfSource& source, const Options& options, Report& report,
                                   const Progress& progress) {
  const auto name = options.text("scheme");
  if (!name) return source.uniform_samples()->samples();
  const Result<UniformScheme> scheme = scheme_by_name(*name);
  if (!scheme) return scheme.error();
  const SourceTraits& traits = source.traits();
  if (scheme->rings.back().theta_deg > traits.theta_max_deg) {
    report.remarks.push_back(
        {"beyond_theta_max", scheme->rings.back().theta_deg,
         fmt::format("the scheme goes on to {} degrees, beyond theta_max = {}: {} is sampled there",
                     scheme->rings.back().theta_deg, traits.theta_max_deg, traits.beyond_theta_max)});
  }
  if (!traits.reciprocal) remark_reciprocity(report, reciprocity_difference_percent(source));
  return sample_scheme(source, *scheme, progress);
}

}  // namespace

bool usable_names(const std::vector<std::string>& names) {
  const std::set<std::string> different(names.begin(), names.end());
  return !names.empty() && different.size() == names.size() && !different.contains("");
}

Status check_samples_options(const Options& options) {
  if (options.text("interpolation") == "barycentric" && options.has("rbf-kernel")) {
    return usage_error("--rbf-kernel: is of --interpolation rbf");
  }
  if (!options.has("scheme")) return ok_status();
  for (const char* dense : {"grid", "type"}) {
    if (options.has(dense)) {
      return usage_error(fmt::format("--scheme: --{} is for dense tables, and uniform samples are none", dense));
    }
  }
  return ok_status();
}

Status check_scheme_name(std::string_view text) {
  const std::string name(text);
  const Result<UniformScheme> scheme = scheme_by_name(name);
  return scheme ? ok_status() : Status(usage_error(name + ": " + scheme.error().message));
}

Result<std::unique_ptr<BrdfSource>> open_samples(const Hdf5File& file, std::shared_ptr<const ByteSource> bytes,
                                                 const Options& options) {
  Result<Hdf5Samples> stored = read_hdf5_samples(file);
  if (!stored) return stored.error();
  const Result<Interpolation> how = stored_interpolation(*stored);
  if (!how) return how.error();
  Result<SchemeSamples> samples = samples_of(*std::move(stored));
  if (!samples) return samples.error();
  if (Status taken = apply_policy(options, samples->values); !taken) return taken.error();
  Result<std::unique_ptr<SchemeSource>> source = SchemeSource::make(*std::move(samples), changed(*how, options));
  if (!source) return source.error();
  if (!says_how(options) && !options.has("negatives"))
    (*source)->keep_file(std::move(bytes));  // a copy would not say what was asked for
  return std::unique_ptr<BrdfSource>(*std::move(source));
}

bool wants_samples(const BrdfSource& source, const Options& options) {
  return options.has("scheme") || (source.uniform_samples() != nullptr && !options.has("grid"));
}

Status save_samples(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                    const Progress& progress) {
  if (options.has("type")) return usage_error("--type: is for dense tables; --grid makes one of uniform samples");
  const bool as_it_is = !options.has("scheme") && !options.has("deflate") && !options.has("negatives");
  if (as_it_is && !says_how(options)) {
    if (const auto stored = source.stored("hdf5")) {
      report.remarks.push_back({"copied", 1, "copied bit for bit"});
      return copy_bytes(*stored, sink, progress);
    }
  }
  const SchemeSource* given = source.uniform_samples();
  const Interpolation how = changed(given == nullptr ? Interpolation{} : given->interpolation(), options);
  Result<SchemeSamples> samples = take_samples(source, options, report, progress);
  if (!samples) return samples.error();
  if (Status taken = apply_policy(options, samples->values); !taken) return taken.error();
  const UniformScheme& scheme = samples->scheme;
  report.remarks.push_back({"uniform_samples", static_cast<double>(scheme.reciprocal_pair_count()),
                            fmt::format("{} samples at the {} directions of scheme {}", scheme.reciprocal_pair_count(),
                                        scheme.direction_count(), scheme.name)});
  const auto deflate = static_cast<unsigned>(options.count("deflate").value_or(kHdf5Deflate));
  return write_hdf5_samples(sink, stored_of(*samples, how), report_json(report), deflate);
}

}  // namespace sbrdf::internal
