#include "converters/bench/methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "converters/baselines/schemes.h"
#include "converters/bench/yardstick.h"
#include "converters/files/format_table.h"
#include "converters/tables/grid.h"
#include "formats/merl/merl.h"

namespace sbrdf::internal {
namespace {

using Opened = Result<std::unique_ptr<Contender>>;

std::string grouped(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t k = digits.size(); k > 3; k -= 3) digits.insert(k - 3, ",");
  return digits;
}

std::shared_ptr<const ByteSource> copy_of(const FileBytes& file) { return std::make_shared<OwnedMemorySource>(*file); }

// Which materials.

std::string_view any(const BrdfSource& /*source*/) { return {}; }

std::string_view of_rgb(const BrdfSource& source) {
  return source.channel_count() == 3 ? "" : "it does not have 3 channels";
}

std::string_view of_isotropic_rgb(const BrdfSource& source) {
  return source.traits().isotropic ? of_rgb(source) : "the material is anisotropic, the table is not";
}

std::string_view of_isotropic(const BrdfSource& source) {
  return source.traits().isotropic ? "" : "tables over four axes are too large to be fast";
}

std::string_view of_anisotropic(const BrdfSource& source) {
  return source.traits().isotropic ? "the material is isotropic; a MERL table says the same with an axis less" : "";
}

// The source itself is such a file.
std::string_view of_isotropic_but_merl(const BrdfSource& source) {
  return source.stored("merl") != nullptr ? "it is the source itself" : of_isotropic_rgb(source);
}

std::string_view of_rgb_but_rgl(const BrdfSource& source) {
  return source.stored("rgl") != nullptr ? "it is the source itself" : of_rgb(source);
}

// How large.

std::vector<Variant> by_samples(const VariantChoice& choice) {
  std::vector<Variant> variants;
  for (const std::uint64_t samples : choice.samples) variants.push_back(samples_variant(samples));
  return variants;
}

std::vector<Variant> by_grid(const VariantChoice& choice) {
  std::vector<Variant> variants;
  for (const std::string& grid : choice.grids) {
    const Result<Grid> parsed = parse_grid(grid);
    variants.push_back({parsed ? parsed->size_text() : grid, 0, Options().set("grid", grid).set("type", "float32")});
  }
  return variants;
}

/// The scheme of the paper with the nearest number of samples for each.
std::vector<Variant> by_scheme(const VariantChoice& choice) {
  const std::vector<UniformScheme> schemes = paper_schemes();
  std::vector<Variant> variants;
  for (const std::uint64_t samples : choice.samples) {
    const auto off = [&](const UniformScheme& scheme) {
      return std::abs(std::log(static_cast<double>(scheme.reciprocal_pair_count()) / static_cast<double>(samples)));
    };
    const auto nearest =
        std::min_element(schemes.begin(), schemes.end(), [&](const auto& a, const auto& b) { return off(a) < off(b); });
    const std::string name = grouped(nearest->reciprocal_pair_count()) + " samples";
    if (!variants.empty() && variants.back().name == name) continue;
    variants.push_back({name, 0, Options().set("scheme", nearest->name)});
  }
  return variants;
}

/// Few where few numbers of samples are wanted, since larger files take a minute to find.
std::vector<Variant> by_bytes(const VariantChoice& choice) {
  const bool few = choice.samples.size() < 3;
  std::vector<Variant> variants;
  for (const char* bytes : few ? std::vector{"80"} : std::vector{"150", "800"}) {
    variants.push_back({std::string("at most ") + bytes + " bytes", 0,
                        Options().set("representation", "dense").set("max-bytes", bytes)});
  }
  return variants;
}

std::vector<Variant> merl_cells(const VariantChoice& /*choice*/) { return {{"90 x 90 x 180 cells"}}; }
std::vector<Variant> as_it_is(const VariantChoice& /*choice*/) { return {{""}}; }
std::vector<Variant> rgl_tables(const VariantChoice& choice) { return {{"", 0, choice.rgl}}; }

// The source itself.

Result<Prepared> prepare_source(Workshop& workshop, const Variant& /*variant*/, const Progress& /*progress*/) {
  const BenchMaterial& material = workshop.material();
  const Result<OpenedSource> opened = material.open();
  if (!opened) return opened.error();
  const auto open = [&material]() -> Opened {
    Result<OpenedSource> again = material.open();
    if (!again) return again.error();
    return std::unique_ptr<Contender>(std::make_unique<SourceContender>(std::move(again->source)));
  };
  return Prepared{open, opened->bytes};
}

// Slices, in the forms that are evaluated.

/// Of a slice, in the value domain: small beside what slices are off by themselves.
constexpr double kPresampledTolerance = 5e-4;

VectorEvaluator exact(const DecodedSliced& decoded) { return {decoded.sliced, decoded.lattice}; }
VectorEvaluator presampled(const DecodedSliced& decoded) { return exact(decoded).presampled(kPresampledTolerance); }
VectorEvaluator dense(const DecodedSliced& decoded) { return exact(decoded).dense(decoded.sliced, decoded.lattice); }

template <SlicedContender::Make make>
Opened open_slices(std::span<const std::byte> bytes) {
  Result<DecodedSliced> decoded = decode_sliced(bytes);
  if (!decoded) return decoded.error();
  if constexpr (make == exact) {
    return std::unique_ptr<Contender>(std::make_unique<LazyContender>(*std::move(decoded)));
  } else {
    return std::unique_ptr<Contender>(std::make_unique<SlicedContender>(*decoded, make));
  }
}

template <SlicedContender::Make make>
Result<Prepared> prepare_slices(Workshop& workshop, const Variant& variant, const Progress& progress) {
  const Result<FileBytes> file = workshop.sliced(variant.samples, progress);
  if (!file) return file.error();
  const auto open = [bytes = *file]() -> Opened { return open_slices<make>(*copy_of(bytes)->view()); };
  return Prepared{open, (*file)->size()};
}

// Files of other formats, as this library reads them.

Result<Prepared> prepare_format(const Result<FileBytes>& file, const Options& options) {
  if (!file) return file.error();
  const auto open = [bytes = *file, options]() -> Opened {
    Result<std::unique_ptr<BrdfSource>> source = open_source(copy_of(bytes), options);
    if (!source) return source.error();
    return std::unique_ptr<Contender>(std::make_unique<SourceContender>(*std::move(source)));
  };
  return Prepared{open, (*file)->size()};
}

/// 90 x 90 x 180 cells whose values belong there: at the centre, or at the lower edge.
Result<FileBytes> merl_file(Workshop& workshop, const std::string& position, const Progress& progress) {
  return workshop.file(".binary", Options().set("merl-shape", "90,90,180").set("merl-position", position), progress);
}

Result<Prepared> prepare_merl_linear(Workshop& workshop, const Variant& /*variant*/, const Progress& progress) {
  return prepare_format(merl_file(workshop, "centre", progress), Options().set("merl-turn", "half"));
}

Result<Prepared> prepare_merl_nearest(Workshop& workshop, const Variant& /*variant*/, const Progress& progress) {
  return prepare_format(merl_file(workshop, "centre", progress),
                        Options().set("merl-turn", "half").set("merl-lookup", "nearest"));
}

Result<Prepared> prepare_dense(Workshop& workshop, const Variant& variant, const Progress& progress) {
  const std::string grid = variant.options.text("grid").value_or("");
  return prepare_format(workshop.file(".npy", variant.options, progress), Options().set("grid", grid));
}

Result<Prepared> prepare_series(Workshop& workshop, const Variant& variant, const Progress& progress) {
  return prepare_format(workshop.file(".sbrdf", variant.options, progress), {});
}

Result<Prepared> prepare_barycentric(Workshop& workshop, const Variant& variant, const Progress& progress) {
  return prepare_format(workshop.file(".h5", variant.options, progress), Options().set("interpolation", "barycentric"));
}

Result<Prepared> prepare_rbf(Workshop& workshop, const Variant& variant, const Progress& progress) {
  return prepare_format(workshop.file(".h5", variant.options, progress), Options().set("interpolation", "rbf"));
}

Result<Prepared> prepare_rgl(Workshop& workshop, const Variant& variant, const Progress& progress) {
  return prepare_format(workshop.file(".bsdf", variant.options, progress), {});
}

// The plain look-up.

template <class Number>
class LookUpContender final : public Contender {
 public:
  explicit LookUpContender(std::vector<Number> numbers) : table_(std::move(numbers)) {}

  [[nodiscard]] std::size_t channel_count() const override { return 3; }
  [[nodiscard]] bool is_reciprocal() const override { return true; }
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                std::span<float> values) const override {
    for (std::size_t k = 0; k < w_i.size(); ++k) {
      const glm::vec3 value = table_.look_up(w_i[k], w_v[k]);
      for (int c = 0; c < 3; ++c) values[3 * k + static_cast<std::size_t>(c)] = value[c];
    }
  }

 private:
  TrilinearTable<Number> table_;
};

/// f_r of every cell; marks are 0.
Result<std::vector<double>> numbers_of_merl(std::span<const std::byte> bytes) {
  constexpr std::size_t kCells = TrilinearTable<double>::kCells;
  std::vector<double> numbers(kMerlChannelCount * kCells);
  if (bytes.size() != kMerlHeaderSize + numbers.size() * sizeof(double)) {
    return invalid_file("not a table of 90 x 90 x 180 cells");
  }
  std::memcpy(numbers.data(), bytes.data() + kMerlHeaderSize, numbers.size() * sizeof(double));
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = std::max(numbers[k], 0.0) * kMerlScale[k / kCells];
  return numbers;
}

Result<Prepared> prepare_plain(Workshop& workshop, const Variant& /*variant*/, const Progress& progress) {
  const Result<FileBytes> file = merl_file(workshop, "edge", progress);
  if (!file) return file.error();
  const auto open = [bytes = *file]() -> Opened {
    Result<std::vector<double>> numbers = numbers_of_merl(*bytes);
    if (!numbers) return numbers.error();
    return std::unique_ptr<Contender>(std::make_unique<LookUpContender<double>>(*std::move(numbers)));
  };
  return Prepared{open, (*file)->size()};
}

Result<Prepared> prepare_plain_half(Workshop& workshop, const Variant& /*variant*/, const Progress& progress) {
  const Result<FileBytes> file = merl_file(workshop, "edge", progress);
  if (!file) return file.error();
  const Result<std::vector<double>> numbers = numbers_of_merl(**file);
  if (!numbers) return numbers.error();
  const auto halves = std::make_shared<std::vector<HalfNumber>>();
  for (const double number : *numbers) {
    halves->push_back({half_from_float(static_cast<float>(std::min(number, kHalfLargest)))});
  }
  const auto open = [halves]() -> Opened {
    return std::unique_ptr<Contender>(std::make_unique<LookUpContender<HalfNumber>>(*halves));
  };
  return Prepared{open, halves->size() * sizeof(HalfNumber)};
}

/// [%]; nodes 15 degrees apart make highlights ten times as wide.
constexpr double kWildOfCoarseTables = 1000;

/// Radial basis functions swing by any factor between highlights narrower than their samples are apart.
constexpr double kWildOfSwinging = 1e9;

constexpr std::array kMethods = {
    Method{"source", any, as_it_is, prepare_source},
    Method{"sliced, exact", any, by_samples, prepare_slices<exact>, open_slices<exact>},
    Method{"sliced, pre-sampled", any, by_samples, prepare_slices<presampled>, open_slices<presampled>},
    Method{"sliced, dense", of_isotropic, by_samples, prepare_slices<dense>, open_slices<dense>},
    Method{"dense representation", any, by_bytes, prepare_series},
    Method{"MERL, linear", of_isotropic_but_merl, merl_cells, prepare_merl_linear},
    Method{"MERL, nearest", of_isotropic_rgb, merl_cells, prepare_merl_nearest},
    Method{"plain table", of_isotropic_rgb, merl_cells, prepare_plain},
    Method{"plain table, half floats", of_isotropic_rgb, merl_cells, prepare_plain_half},
    Method{"dense 4-D table", of_anisotropic, by_grid, prepare_dense, nullptr, kWildOfCoarseTables},
    Method{"uniform, barycentric", any, by_scheme, prepare_barycentric, nullptr, kWildOfCoarseTables},
    Method{"uniform, RBF", any, by_scheme, prepare_rbf, nullptr, kWildOfSwinging},
    Method{"RGL", of_rgb_but_rgl, rgl_tables, prepare_rgl},
};

}  // namespace

std::span<const Method> bench_methods() { return kMethods; }

Variant samples_variant(std::uint64_t samples) { return {grouped(samples) + " samples", samples}; }

}  // namespace sbrdf::internal
