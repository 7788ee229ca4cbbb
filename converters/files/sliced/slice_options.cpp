#include "converters/files/sliced/slice_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "converters/slicing/names.h"
#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMostBytes = 1'000'000'000;
constexpr std::uint64_t kMostEvaluations = 100'000;
constexpr Range kTarget = {0, 1000, true};          // [%]
constexpr Range kPrecision = {0.0001, 50};          // [%]
constexpr Range kGap = {0.01, 90};                  // [degrees]
constexpr std::string_view kAuto = "auto";          // the choice is the program's
constexpr std::string_view kSearch = "search";      // placement: nodes by the error on held-back directions
constexpr std::string_view kPaper = "paper";        // placement: by Table 3
constexpr std::string_view kLossless = "lossless";  // precision; "auto", too, which is the default
constexpr std::string_view kFitted = "fitted";      // values

/// The names of a table after "auto".
template <class T, std::size_t N>
constexpr std::array<std::string_view, N + 1> auto_or(const std::array<Named<T>, N>& table) {
  std::array<std::string_view, N + 1> names = {kAuto};
  for (std::size_t k = 0; k < N; ++k) names[k + 1] = table[k].name;
  return names;
}

constexpr auto kFrameChoices = auto_or(kFrameNames);
constexpr auto kDomainChoices = auto_or(kDomainNames);
constexpr auto kRefinementChoices = names_of(kRefinementNames);
constexpr std::array<std::string_view, 2> kValueChoices = {kFitted, "measured"};
constexpr auto kChunkChoices = names_of(kChunkNames);
constexpr auto kMetadataChoices = names_of(kMetadataNames);

Status check_placement(std::string_view text) {
  if (text == kSearch || text == kPaper || parse_steps(text)) return ok_status();
  return usage_error(
      fmt::format("'{}' is neither search, paper, nor two positive numbers of degrees such as 14/36", text));
}

/// As a fraction.
std::optional<double> parse_precision(std::string_view text) {
  if (text == kLossless) return 0;
  const Result<double> percent = number_within(text.substr(0, text.size() - (text.ends_with('%') ? 1 : 0)), kPrecision);
  return percent ? std::optional(*percent / 100) : std::nullopt;
}

Status check_precision(std::string_view text) {
  if (text == kAuto || parse_precision(text)) return ok_status();
  return usage_error(fmt::format("'{}' is neither auto, lossless, nor 0.0001 to 50 percent, such as 0.1%", text));
}

constexpr std::array kRepresentationNames = {Named{"sliced", Representation::kSliced},
                                             Named{"dense", Representation::kDense},
                                             Named{"auto", Representation::kAuto}};
constexpr auto kRepresentations = names_of(kRepresentationNames);

constexpr std::array kOptions = {
    OptionSpec{.name = "representation",
               .kind = OptionKind::kChoice,
               .choices = kRepresentations,
               .fallback = "sliced",
               .meaning = "sliced: samples along slices, placed where they are needed; dense: a table, transformed and "
                          "coded, the smallest on disk and the fastest in memory, without parts or a bound; auto: "
                          "the smaller or the better one of both, by the target or --max-bytes"},
    OptionSpec{.name = "samples",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {1, kMaxSampleCount},
               .fallback = "4096",
               .meaning = "Directions sampled, crossings included"},
    OptionSpec{.name = "target-mre",
               .kind = OptionKind::kNumber,
               .unit = "PERCENT",
               .range = kTarget,
               .meaning = "Instead of --samples: as few as reach this mean relative error"},
    OptionSpec{.name = "target-rel-l1",
               .kind = OptionKind::kNumber,
               .unit = "PERCENT",
               .range = kTarget,
               .meaning = "Instead of --samples: as few as reach this relative L1 error"},
    OptionSpec{.name = "max-bytes",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {1, kMostBytes},
               .meaning = "Instead of --samples: as many as fit a file of this size"},
    OptionSpec{.name = "frame",
               .kind = OptionKind::kChoice,
               .choices = kFrameChoices,
               .fallback = kAuto,
               .meaning = "Coordinates of the slices"},
    OptionSpec{.name = "domain",
               .kind = OptionKind::kChoice,
               .choices = kDomainChoices,
               .fallback = kAuto,
               .meaning = "Interpolate the values or their logarithms"},
    OptionSpec{.name = "placement",
               .unit = "search|paper|E/A",
               .fallback = kSearch,
               .check = check_placement,
               .meaning =
                   "Nodes by the error on held-back directions; or, in the elevation frame, by the paper's Table 3 "
                   "from the number of samples, or so many degrees between elevations and between azimuths"},
    OptionSpec{.name = "theta-max",
               .kind = OptionKind::kNumber,
               .unit = "DEG",
               .range = {kLeastThetaMaxDeg, 90},
               .meaning =
                   "Slices go up to this theta, in degrees, rounded to hundredths; beyond, the value there is held; "
                   "as far as IN is measured, 80 for a model or a placement by steps"},
    OptionSpec{.name = "refine",
               .kind = OptionKind::kChoice,
               .choices = kRefinementChoices,
               .fallback = "true",
               .meaning = "Place samples by the true error against the source, or as a goniometer must, by what was "
                          "measured already"},
    OptionSpec{.name = "values",
               .kind = OptionKind::kChoice,
               .choices = kValueChoices,
               .fallback = "fitted, or measured with --refine measured",
               .meaning = "Samples hold what brings the whole nearest to the source, or what the source has there"},
    OptionSpec{.name = "minimum-gap",
               .kind = OptionKind::kNumber,
               .unit = "DEG",
               .range = kGap,
               .meaning = "Samples are not set closer than this, in degrees; 0.01, or 1 with --refine measured"},
    OptionSpec{.name = "search-evaluations",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {1, kMostEvaluations},
               .fallback = "200",
               .meaning = "Structures a search tries of each frame for N, N / 4, N / 16 ... samples each; the round of "
                          "some fifty in which it gets there is finished"},
    OptionSpec{.name = "no-mirrors",
               .kind = OptionKind::kFlag,
               .meaning = "Do not use mirror symmetries of the source; a placement by steps never does"},
    OptionSpec{.name = "precision",
               .unit = "auto|lossless|P%",
               .fallback = "auto, or as in a sliced IN",
               .check = check_precision,
               .meaning = "Largest relative error of every stored sample, in percent, or lossless; auto: as coarse as "
                          "adds a tenth to the error of the file, or as makes the file that --target-mre, "
                          "--target-rel-l1 or --max-bytes ask for smallest or best"},
    OptionSpec{
        .name = "chunks",
        .kind = OptionKind::kChoice,
        .choices = kChunkChoices,
        .fallback = kAuto,
        .meaning =
            "whole: one chunk, the smallest file; split: a region can be loaded by itself; auto: split from 65,536 "
            "samples on"},
    OptionSpec{.name = "metadata",
               .kind = OptionKind::kChoice,
               .choices = kMetadataChoices,
               .fallback = "lean, or as in a sliced IN",
               .meaning =
                   "What a file says of how it came to be; lean: source, errors and findings; full: the command, "
                   "conventions and counts, too"},
};

/// Each says by itself when to stop.
constexpr std::array<std::string_view, 4> kStopRules = {"samples", "target-mre", "target-rel-l1", "max-bytes"};
/// All that has a meaning for a dense table.
constexpr std::array<std::string_view, 7> kOfDense = {"representation", "target-mre", "target-rel-l1", "max-bytes",
                                                      "theta-max",      "no-mirrors", "metadata"};
/// How a file is coded, whatever its samples.
constexpr std::array<std::string_view, 3> kCoding = {"precision", "chunks", "metadata"};

std::string placement_of(const Options& options) { return options.text("placement").value_or(std::string(kSearch)); }

// Of the elevation frame: by steps, or by the paper's table.
bool has_placement(const Options& options) { return placement_of(options) != kSearch; }

std::optional<FrameId> frame_of(const Options& options) {
  return value_of(kFrameNames, options.text("frame").value_or(std::string(kAuto)));
}

StopRule stop_rule(const Options& options) {
  if (const auto percent = options.number("target-mre")) return TargetMre{*percent};
  if (const auto percent = options.number("target-rel-l1")) return TargetRelL1{*percent};
  if (const auto bytes = options.count("max-bytes")) return MaxBytes{*bytes};
  return SampleCount{options.count("samples").value_or(kDefaultSampleCount)};
}

StructureRule structure_rule(const Options& options) {
  const std::string placement = placement_of(options);
  if (placement == kPaper) {
    return table_3_placement(options.count("samples").value_or(kDefaultSampleCount));
  }
  if (const auto steps = parse_steps(placement)) return *steps;
  SearchedStructure search;
  search.frame = frame_of(options);
  search.use_mirrors = !options.has("no-mirrors");
  search.evaluations = options.count("search-evaluations").value_or(kDefaultSearchEvaluations);
  return search;
}

}  // namespace

std::optional<Placement> parse_steps(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto elevation = parse_number(text.substr(0, slash));
  const auto azimuth = parse_number(text.substr(slash + 1));
  if (!elevation || !azimuth || *elevation <= 0 || *azimuth <= 0) return std::nullopt;
  return Placement{*elevation, *azimuth};
}

std::span<const OptionSpec> sliced_options() { return kOptions; }

Status check_slice_options(const Options& options) {
  std::string_view stop_rule;
  for (const std::string_view name : kStopRules) {
    if (!options.has(name)) continue;
    if (!stop_rule.empty()) return usage_error(fmt::format("--{} excludes --{}", stop_rule, name));
    stop_rule = name;
  }
  if (representation_of(options) != Representation::kSliced) {
    for (const auto& [name, value] : options.all()) {
      if (std::find(kOfDense.begin(), kOfDense.end(), name) == kOfDense.end()) {
        return usage_error(fmt::format("--{} is of slices, and --representation {} may have none", name,
                                       *options.text("representation")));
      }
    }
  }
  const std::string placement = placement_of(options);
  if (has_placement(options) && frame_of(options) == FrameId::kHalfDifference) {
    return usage_error(
        fmt::format("--placement: '{}' is one of the elevation frame, not of --frame half-difference", placement));
  }
  if (options.text("values") == kFitted && options.text("refine") == "measured") {
    return usage_error("--values fitted: with --refine measured nothing is known of the source between its samples");
  }
  if (options.has("search-evaluations") && has_placement(options)) {
    return usage_error("--search-evaluations: nothing is searched for with --placement " + placement);
  }
  return ok_status();
}

Representation representation_of(const Options& options) {
  const auto text = options.text("representation");
  return text ? value_of(kRepresentationNames, *text).value_or(Representation::kSliced) : Representation::kSliced;
}

bool ask_for_sampling(const Options& options) {
  return std::any_of(options.all().begin(), options.all().end(), [](const auto& given) {
    return std::find(kCoding.begin(), kCoding.end(), given.first) == kCoding.end();
  });
}

SliceOptions slice_options(const Options& options) {
  SliceOptions slices;
  slices.stop = stop_rule(options);
  slices.structure = structure_rule(options);
  slices.domain = value_of(kDomainNames, options.text("domain").value_or(std::string(kAuto)));
  if (const auto refine = options.text("refine")) {
    slices.refinement = value_of(kRefinementNames, *refine).value_or(slices.refinement);
  }
  slices.fit_values = options.text("values").value_or(std::string(kFitted)) == kFitted;
  // In hundredths, as in files.
  if (const auto theta_max = options.number("theta-max")) slices.theta_max_deg = std::round(100 * *theta_max) / 100;
  slices.minimum_gap_deg = options.number("minimum-gap");
  if (const auto precision = options.text("precision")) {
    slices.precision = parse_precision(*precision);
  }
  if (const auto chunks = options.text("chunks")) {
    slices.chunks = value_of(kChunkNames, *chunks).value_or(slices.chunks);
  }
  if (const auto metadata = options.text("metadata")) {
    slices.metadata = value_of(kMetadataNames, *metadata).value_or(slices.metadata);
  }
  slices.source_sha256 = options.provenance.source_sha256;
  slices.command = options.provenance.command;
  return slices;
}

}  // namespace sbrdf::internal
