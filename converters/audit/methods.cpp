#include "converters/audit/methods.h"

#include <fmt/format.h>

#include <array>
#include <memory>
#include <utility>

#include "converters/audit/tables/table_coders.h"

namespace sbrdf::internal {
namespace {

// Which materials.

std::string_view any(const AuditSubject& /*subject*/) { return {}; }

std::string_view of_rgb(const AuditSubject& subject) {
  return subject.channel_count() == 3 ? "" : "it does not have 3 channels";
}

std::string_view of_isotropic_rgb(const AuditSubject& subject) {
  return subject.symmetries().isotropic ? of_rgb(subject) : "the material is anisotropic, the table is not";
}

std::string_view of_one_or_three(const AuditSubject& subject) {
  return subject.channel_count() == 1 ? "" : of_rgb(subject);
}

std::string_view of_up_to_four(const AuditSubject& subject) {
  return subject.channel_count() <= 4 ? "" : "textures hold 1, 3 or 4 channels";
}

// Formulae.

/// Models have three channels, which are one for a material with one.
class FirstChannel final : public BrdfSource {
 public:
  explicit FirstChannel(std::unique_ptr<BrdfSource> source) : source_(std::move(source)), traits_(source_->traits()) {
    traits_.channels = {"Y"};
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    std::vector<float> three(3 * pairs.size());
    source_->evaluate(pairs, three);
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = three[3 * k];
  }

 private:
  std::unique_ptr<BrdfSource> source_;
  SourceTraits traits_;
};

template <LobeKind kind>
Result<Found> find_fit(Workbench& bench, double percent, const Progress& progress) {
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  for (const std::uint64_t lobes : {1U, 2U, 3U}) {
    const Result<AnalyticModel> model = bench.fit(kind, lobes, steps.step(0.4));
    if (!model) {
      if (!smallest.complain(model.error())) return model.error();
      break;
    }
    const std::string text = emit_analytic_json(*model);
    Kept kept;
    kept.setting = fmt::format("{} lobe{}", lobes, lobes == 1 ? "" : "s");
    kept.bytes = text.size();
    // What the numbers would take as floats.
    kept.overhead = text.size() - sizeof(float) * (3 + (3 + shape_count(kind)) * lobes);
    const std::size_t channels = bench.subject().channel_count();
    kept.open = [model = *model, channels]() -> Result<std::unique_ptr<BrdfSource>> {
      std::unique_ptr<BrdfSource> source = make_analytic_source(model);
      if (channels == 3) return source;
      return std::unique_ptr<BrdfSource>(std::make_unique<FirstChannel>(std::move(source)));
    };
    if (Status judged = bench.judge(kept); !judged) return judged.error();
    if (smallest.take(std::move(kept))) break;
  }
  return std::move(smallest).found();
}

template <std::size_t number>
Result<Found> find_with(Workbench& bench, double percent, const Progress& progress) {
  return find_coded(bench, table_coders()[number], percent, progress);
}

constexpr bool kYes = true;
constexpr bool kNo = false;

constexpr std::array kMethods = {
    // name, in place, in part, bound
    AuditMethod{"sliced", kYes, kYes, "both", any, find_sliced},
    AuditMethod{"sliced, samples within 0.1 %", kYes, kYes, "both", any, find_sliced_tenth},
    AuditMethod{"dense representation", kNo, kNo, "measured", any, find_dense},
    AuditMethod{"engine atlas", kYes, kYes, "measured", of_up_to_four, find_engine_atlas},
    AuditMethod{"paper's textures", kYes, kNo, "measured", of_up_to_four, find_paper_atlas},
    AuditMethod{"table, floats", kYes, kYes, "value", any, find_float},
    AuditMethod{"table, half floats", kYes, kYes, "value", any, find_half},
    AuditMethod{"HDF5", kNo, kYes, "value", any, find_hdf5},
    AuditMethod{"OpenEXR", kNo, kYes, "value", any, find_exr},
    AuditMethod{"MERL", kYes, kYes, "value", of_isotropic_rgb, find_merl},
    AuditMethod{"UTIA", kYes, kYes, "value", of_rgb, find_utia},
    AuditMethod{"RGL", kYes, kYes, "none", of_rgb, find_rgl},
    AuditMethod{"table, zstd", kNo, kNo, "value", any, find_with<0>},
    AuditMethod{"table, Blosc", kNo, kNo, "value", any, find_with<1>},
    AuditMethod{"table, zfp", kNo, kNo, "value", any, find_with<2>},
    AuditMethod{"table, fpzip", kNo, kNo, "value", any, find_with<3>},
    AuditMethod{"Tucker", kYes, kNo, "none", any, find_tucker},
    AuditMethod{"uniform, barycentric", kYes, kYes, "value", any, find_barycentric},
    AuditMethod{"fit, Kurt", kYes, kNo, "none", of_one_or_three, find_fit<LobeKind::kKurt>},
    AuditMethod{"fit, Ward", kYes, kNo, "none", of_one_or_three, find_fit<LobeKind::kWard>},
    AuditMethod{"fit, GGX", kYes, kNo, "none", of_one_or_three, find_fit<LobeKind::kGgx>},
};

}  // namespace

std::span<const AuditMethod> audit_methods() { return kMethods; }

}  // namespace sbrdf::internal
