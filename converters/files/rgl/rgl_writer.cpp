#include "converters/files/rgl/rgl_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/rgl/rgl.h"
#include "converters/files/rgl/rgl_fit.h"
#include "converters/files/rgl/rgl_microfacets.h"
#include "converters/files/rgl/rgl_spectral.h"
#include "converters/files/table_options.h"
#include "converters/files/value_options.h"
#include "converters/source/filled_source.h"
#include "formats/core/directions.h"
#include "formats/rgl/rgl_material.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kWarpSize = 128;
constexpr std::uint64_t kColourSize = 64;
constexpr std::uint64_t kThetaCount = 32;
// Of anisotropic sources, which have as many slices for each azimuth.
constexpr std::uint64_t kAnisotropicWarpSize = 64;
constexpr std::uint64_t kAnisotropicColourSize = 32;
constexpr std::uint64_t kAnisotropicThetaCount = 16;
constexpr std::uint64_t kPhiCount = 33;
constexpr std::size_t kLongestDescription = 200;

enum class RglValues : std::uint8_t { kRgb, kSpectra };
constexpr std::array kRglValuesNames = {Named{"rgb", RglValues::kRgb}, Named{"spectra", RglValues::kSpectra}};
constexpr auto kSpectralChoices = names_of(kRglSpectralNames);
constexpr auto kValuesChoices = names_of(kRglValuesNames);

constexpr std::array kOptions = {
    negatives_option(OptionUse::kBoth),
    OptionSpec{.name = "spectral",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kSpectralChoices,
               .fallback = "channels",
               .meaning = "A spectral RGL IN: a channel for each wavelength, or its colour under D65 as linear sRGB"},
    OptionSpec{.name = "rgl-size",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {4, 256},
               .fallback = "those of an RGL IN, else 64, anisotropic 32",
               .meaning = "Nodes along each side of the colours of an RGL OUT"},
    OptionSpec{.name = "rgl-warp-size",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {4, 1024},
               .fallback = "those of an RGL IN, else 128, anisotropic 64",
               .meaning = "Nodes along each side of the density that an RGL OUT warps directions by"},
    OptionSpec{.name = "rgl-theta",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {2, 128},
               .fallback = "those of an RGL IN, else 32, anisotropic 16",
               .meaning = "Elevations of the light of an RGL OUT, from 0 to 90 degrees"},
    OptionSpec{.name = "rgl-phi",
               .kind = OptionKind::kCount,
               .unit = "N",
               .counts = {5, 361},
               .fallback = "33",
               .meaning = "Azimuths of the light of an anisotropic RGL OUT, both ends of the full turn among them"},
    OptionSpec{.name = "rgl-values",
               .kind = OptionKind::kChoice,
               .choices = kValuesChoices,
               .fallback = "spectra where channels are wavelengths, else rgb",
               .meaning = "Values of an RGL OUT. pbrt reads spectra alone"},
};

Status check_sizes(std::uint64_t slices, std::uint64_t colours, std::uint64_t warp) {
  if (slices * colours * colours <= kRglMostColourNodes && slices * warp * warp <= kRglMostWarpNodes) {
    return ok_status();
  }
  return usage_error(fmt::format("--rgl-size {}, --rgl-warp-size {}: {} slices of these make more than {} or {} nodes",
                                 colours, warp, slices, kRglMostColourNodes, kRglMostWarpNodes));
}

/// One channel, or three.
class ReducedSource final : public BrdfSource {
 public:
  /// `weights` [3, channel] of the source's own channels.
  ReducedSource(const BrdfSource& source, std::vector<double> weights)
      : source_(source), weights_(std::move(weights)), traits_(source.traits()) {
    traits_.channels = {"R", "G", "B"};
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    const std::size_t channels = source_.channel_count();
    std::vector<float> all(pairs.size() * channels);
    source_.evaluate(pairs, all);
    for (std::size_t n = 0; n < values.size(); ++n) {
      double sum = 0;
      for (std::size_t c = 0; c < channels; ++c) {
        sum += weights_[n % kRglRgbCount * channels + c] * all[n / kRglRgbCount * channels + c];
      }
      values[n] = static_cast<float>(sum);
    }
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    source_.measured(pairs, flags);
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return source_.mask_grid(); }

 private:
  const BrdfSource& source_;
  std::vector<double> weights_;
  SourceTraits traits_;
};

/// What is encoded in place of the source, and its wavelengths where the file is spectral.
struct Prepared {
  std::unique_ptr<BrdfSource> reduced;
  std::unique_ptr<BrdfSource> filled;
  std::vector<float> wavelengths;
};

Result<Prepared> prepare(const BrdfSource& source, const Options& options, Report& report) {
  const std::vector<std::string>& channels = source.traits().channels;
  const std::optional<std::vector<float>> wavelengths = wavelengths_of_channels(channels);
  const auto values = value_of(kRglValuesNames, options.text("rgl-values").value_or(wavelengths ? "spectra" : "rgb"));
  Prepared prepared;
  if (values == RglValues::kSpectra) {
    if (!wavelengths) return unsupported("--rgl-values spectra: the channels of the source are no wavelengths");
    if (wavelengths->size() > kRglMaxWavelengthCount) {
      return unsupported(fmt::format("{} wavelengths, the limit is {}", wavelengths->size(), kRglMaxWavelengthCount));
    }
    prepared.wavelengths = *wavelengths;
  } else if (wavelengths) {
    if (wavelengths->front() > kRglColoursFromNm || wavelengths->back() < kRglColoursToNm) {
      return unsupported(fmt::format("--rgl-values rgb: colours need all wavelengths from {:g} to {:g} nm",
                                     kRglColoursFromNm, kRglColoursToNm));
    }
    prepared.reduced = std::make_unique<ReducedSource>(source, rgl_rgb_weights(*wavelengths));
    report.remarks.push_back({"wavelengths_reduced", static_cast<double>(wavelengths->size()),
                              fmt::format("{} wavelengths became linear sRGB under D65", wavelengths->size())});
  } else if (channels.size() == 1) {
    prepared.reduced = std::make_unique<ReducedSource>(source, std::vector<double>(kRglRgbCount, 1.0));
    report.remarks.push_back({"channel_repeated", 1, "the only channel stands in R, G and B"});
  } else if (channels.size() != kRglRgbCount) {
    return unsupported(fmt::format("an RGL file holds 3 channels or wavelengths, the source has {} channels without",
                                   channels.size()));
  }
  const BrdfSource& given = prepared.reduced ? *prepared.reduced : source;
  if (given.mask_grid()) prepared.filled = std::make_unique<FilledSource>(given);
  return prepared;
}

/// Halfway between evenly spaced and evenly in the cosine: steps of 17 degrees at the normal are too wide for a cosine
/// of theta_v that falls to 0 elsewhere.
std::vector<float> elevations(std::uint64_t count) {
  std::vector<float> nodes;
  for (std::uint64_t k = 0; k < count; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(count - 1);
    nodes.push_back(static_cast<float>((std::acos(1 - part) + part * kPi / 2) / 2));
  }
  return nodes;
}

std::vector<float> azimuths_for(const BrdfSource& source, const Options& options) {
  if (source.traits().isotropic) return {0};
  const std::uint64_t count = options.count("rgl-phi").value_or(kPhiCount);
  std::vector<float> nodes;
  for (std::uint64_t k = 0; k < count; ++k) {
    nodes.push_back(static_cast<float>((2 * static_cast<double>(k) / static_cast<double>(count - 1) - 1) * kPi));
  }
  return nodes;
}

/// A material of the source's nodes that has everything but a density and colours.
RglMaterial make_material(const BrdfSource& source, const Options& options) {
  const bool isotropic = source.traits().isotropic;
  RglMaterial material;
  material.phi_i = azimuths_for(source, options);
  material.theta_i = elevations(options.count("rgl-theta").value_or(isotropic ? kThetaCount : kAnisotropicThetaCount));
  const std::size_t size = options.count("rgl-size").value_or(isotropic ? kColourSize : kAnisotropicColourSize);
  material.colour_grid = {size, size};
  const std::size_t warp_size = options.count("rgl-warp-size").value_or(isotropic ? kWarpSize : kAnisotropicWarpSize);
  material.vndf_grid = {warp_size, warp_size};
  return material;
}

/// The tables of the RGL file that the source is, so that only colours are fitted again, and come out as they were
/// where they have the same nodes. Nothing where options ask for other nodes, or there is no such file.
std::optional<RglMaterial> own_material(const BrdfSource& source, const Options& options) {
  const auto stored = source.stored(kRglTables);
  if (stored == nullptr || !stored->view()) return std::nullopt;
  if (options.has("rgl-theta") || options.has("rgl-phi") || options.has("rgl-warp-size")) return std::nullopt;
  const Result<TensorFile> tensors = parse_tensor_file(*stored->view());
  Result<RglMaterial> own = tensors ? parse_rgl_material(*tensors) : tensors.error();
  const bool fits =
      own && own->phi_i.size() == 1 && own->theta_i.size() >= 2 && own->jacobian && own->negative_ndf_count == 0;
  if (!fits) return std::nullopt;
  if (const auto size = options.count("rgl-size")) own->colour_grid = {*size, *size};
  own->colour_grid.y_count = own->colour_grid.x_count;
  return *std::move(own);
}

/// A material that was made, as bytes, and how near it comes.
struct Encoded {
  std::vector<std::byte> bytes;
  RglMaterial material;
  RglFitLosses losses;
  ResamplingError error;
};

/// `material` has everything but colours.
Result<Encoded> encode(const BrdfSource& source, const BrdfSource& encoded, RglMaterial material,
                       const RglFitRequest& request, const Progress& progress) {
  const Result<RglFitLosses> losses = fit_colours(encoded, request, material, progress);
  if (!losses) return losses.error();
  Encoded result;
  result.losses = *losses;
  result.bytes = emit_rgl_material(material, sampling_of(encoded, material));
  const Result<std::unique_ptr<BrdfSource>> read = load_rgl(result.bytes);
  if (!read) return read.error();
  const std::size_t own = source.channel_count();
  const std::size_t written = (*read)->channel_count();
  // The only channel of a source stands in three.
  result.error = resampling_error(source, [&](auto pairs, auto values) {
    std::vector<float> all(pairs.size() * written);
    (*read)->evaluate(pairs, all);
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = all[n / own * written + n % own];
  });
  result.material = std::move(material);
  return result;
}

void remark_shape(Report& report, const RglMaterial& material) {
  report.remarks.push_back(
      {"slices", static_cast<double>(material.slice_count()),
       fmt::format("{} azimuths and {} elevations of the light, colours at {} x {} nodes each, warped by {} x {}",
                   material.phi_i.size(), material.theta_i.size(), material.colour_grid.x_count,
                   material.colour_grid.y_count, material.vndf_grid.x_count, material.vndf_grid.y_count)});
}

void remark_losses(Report& report, const BrdfSource& source, const RglFitLosses& losses, Negatives negatives) {
  const auto of = [&](std::uint64_t count) {
    return fmt::format(
        "of {} pairs of directions ({:.3g} %) that the colours were fitted to ", losses.pairs,
        100 * static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(losses.pairs, 1)));
  };
  remark_count(
      report, "unmeasured_pairs", losses.unmeasured,
      of(losses.unmeasured) +
          "were not measured by the source: values from around them, which the file cannot tell from measured");
  remark_count(report, "pairs_beyond_theta_max", losses.beyond_theta_max,
               of(losses.beyond_theta_max) +
                   fmt::format("have a direction beyond theta_max = {:g} degrees, how far the source is measured: {}",
                               source.traits().theta_max_deg, source.traits().beyond_theta_max));
  const std::string done = negatives == Negatives::kKeep    ? "kept"
                           : negatives == Negatives::kClamp ? "0 in their place"
                                                            : "left out, as if not measured";
  remark_count(report, "negative_pairs", losses.negative, of(losses.negative) + "have a channel below 0: " + done);
}

}  // namespace

std::span<const OptionSpec> rgl_options() { return kOptions; }

Status check_rgl_options(const Options& options) {
  return check_sizes(options.count("rgl-theta").value_or(2), options.count("rgl-size").value_or(4),
                     options.count("rgl-warp-size").value_or(4));
}

namespace {

/// With the file's own tables where it has some.
Result<Encoded> encode_all(const BrdfSource& source, const BrdfSource& encoded, const Prepared& prepared,
                           const Options& options, const Progress& progress) {
  const std::optional<RglMaterial> own = own_material(source, options);
  RglMaterial material = own ? *own : make_material(source, options);
  material.description = printable_text(source.traits().description, kLongestDescription);
  if (material.description.empty()) material.description = "BRDF";
  material.wavelengths = prepared.wavelengths;
  if (Status sane = check_sizes(material.slice_count(), material.colour_grid.x_count, material.vndf_grid.x_count);
      !sane) {
    return sane.error();
  }
  RglFitRequest request;
  request.negatives = policy_of(options, NonFinite::kRefuse).negatives;
  RglMaterial guessed = material;
  const double size = fill_microfacets(encoded, guessed);
  if (size > 0 && std::isfinite(size)) request.size = size;
  // What came out is measured against what was asked for; one channel stands for the three that it became.
  const BrdfSource& reference = prepared.reduced && source.channel_count() != 1 ? *prepared.reduced : source;
  if (own) return encode(reference, encoded, std::move(material), request, progress);
  fill_visible_normals(guessed.vndf_grid.x_count, guessed);
  return encode(reference, encoded, std::move(guessed), request, progress);
}

}  // namespace

Status save_rgl(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                const Progress& progress) {
  const bool as_it_is = options.select(kOptions, OptionUse::kWrite).all().empty();
  if (const auto stored = source.stored("rgl"); stored != nullptr && as_it_is) {
    report.remarks.push_back({"copied", 1, "copied bit for bit"});
    return copy_bytes(*stored, sink, progress);
  }
  const Result<Prepared> prepared = prepare(source, options, report);
  if (!prepared) return prepared.error();
  const BrdfSource& given = prepared->reduced ? *prepared->reduced : source;
  const BrdfSource& encoded = prepared->filled ? *prepared->filled : given;
  const Result<Encoded> made = encode_all(source, encoded, *prepared, options, progress);
  if (!made) return made.error();
  remark_shape(report, made->material);
  remark_losses(report, source, made->losses, policy_of(options, NonFinite::kRefuse).negatives);
  remark_resampling(report, given, made->error);
  return sink.write(0, made->bytes);
}

}  // namespace sbrdf::internal
