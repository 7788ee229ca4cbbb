#include "converters/files/rgl/rgl.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/rgl/rgl_angles.h"
#include "converters/files/rgl/rgl_spectral.h"
#include "converters/files/rgl/rgl_tables.h"
#include "converters/source/atan2_each.h"
#include "formats/core/directions.h"
#include "formats/rgl/rgl_material.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal {
namespace {

constexpr std::string_view kFourierMagic = "SCATFUN\x01";
/// How far the first azimuth of a quarter turn may be from -pi [radians].
constexpr double kQuarterSlack = 1e-3;

bool is_fourier_bsdf(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with(kFourierMagic);
}

/// An azimuth of incidence brought into the part of the turn that was measured. Azimuths relative to it keep their sign
/// or, where the pair was mirrored, change it.
struct FoldedAzimuth {
  double phi_i = 0;
  double sign = 1;
};

/// How much of the turn of phi_i a file covers; the rest follows from the symmetry of the material.
enum class Coverage : std::uint8_t { kIsotropic, kFullTurn, kHalfTurn, kQuarterTurn };

Result<Coverage> coverage_of(const RglMaterial& material, const TensorFile& tensors) {
  if (material.isotropic()) return Coverage::kIsotropic;
  const double first = material.phi_i.front();
  const double span = material.phi_i.back() - first;
  const double parts = std::rint(2 * kPi / span);
  if (parts == 1) return Coverage::kFullTurn;
  if (parts == 2) return Coverage::kHalfTurn;
  if (parts == 4 && std::abs(first + kPi) < kQuarterSlack) return Coverage::kQuarterTurn;
  return Error{ErrorCode::kUnsupported,
               "field \"phi_i\": from " + std::to_string(first) + " to " + std::to_string(first + span) +
                   " radians; only a full turn, a half turn, or the quarter from -pi can be read",
               tensors.find("phi_i")->offset};
}

FoldedAzimuth fold(Coverage coverage, double first, double phi_i) {
  switch (coverage) {
    case Coverage::kIsotropic:
      return {};
    case Coverage::kFullTurn:
      return {first + wrap(phi_i - first, 2 * kPi), 1};
    case Coverage::kHalfTurn:
      return {first + wrap(phi_i - first, kPi), 1};
    case Coverage::kQuarterTurn:
      break;
  }
  // Mirrored at the tangent and at the bitangent, which makes the material symmetric under half a turn as well.
  const double within_half = wrap(phi_i, kPi);
  if (within_half < kPi / 2) return {within_half - kPi, 1};
  return {-within_half, -1};
}

/// What the tables are asked about.
struct RglAngles {
  double theta_i = 0;
  double phi_i = 0;       ///< of the light; does not count for an isotropic material
  double half_theta = 0;  ///< elevation of the half vector
  double half_phi = 0;    ///< its azimuth from that of the light
  double cos_theta_v = 0;
};

/// `pair` lies above the horizon. A light along the normal has no azimuth. The tables do depend on one there; atan2(0,
/// 0) is the database's.
RglAngles angles_of(const DirectionPair& pair) {
  const double phi_i = pair.i.theta == 0 ? 0 : pair.i.phi;
  const double difference = pair.v.phi - phi_i;
  const double sin_v = std::sin(pair.v.theta);
  const double cos_v = std::cos(pair.v.theta);
  const double x = std::sin(pair.i.theta) + sin_v * std::cos(difference);
  const double y = sin_v * std::sin(difference);
  const double z = std::cos(pair.i.theta) + cos_v;
  return {pair.i.theta, phi_i, std::atan2(std::sqrt(x * x + y * y), z), std::atan2(y, x), cos_v};
}

constexpr std::size_t kBlock = 16;  // pairs whose angles are worked out side by side

/// The same of up to kBlock pairs of vectors of any length.
class VectorAngles {
 public:
  explicit VectorAngles(bool isotropic) : per_pair_(isotropic ? 3 : 4) {}

  void add(const glm::dvec3& w_i, const glm::dvec3& w_v) {
    const double length_i = std::sqrt(w_i.x * w_i.x + w_i.y * w_i.y + w_i.z * w_i.z);
    const double length_v = std::sqrt(w_v.x * w_v.x + w_v.y * w_v.y + w_v.z * w_v.z);
    const glm::dvec3 h = length_v * w_i + length_i * w_v;
    const double radius_i = std::sqrt(w_i.x * w_i.x + w_i.y * w_i.y);
    // Turned by the azimuth of the light, which is 0 where it has none.
    const double along = radius_i > 0 ? w_i.x : 1;
    const double across = radius_i > 0 ? w_i.y : 0;
    add(radius_i, w_i.z);
    add(std::sqrt(h.x * h.x + h.y * h.y), h.z);
    add(along * h.y - across * h.x, along * h.x + across * h.y);
    if (per_pair_ == 4) add(across, along);
    cos_theta_v_[pairs_++] = w_v.z / length_v;
  }
  void finish() { atan2_each(std::span(y_).first(size_), std::span(x_).first(size_), std::span(y_).first(size_)); }

  [[nodiscard]] RglAngles operator[](std::size_t pair) const {
    const double* own = y_.data() + per_pair_ * pair;
    return {own[0], per_pair_ == 4 ? own[3] : 0, own[1], own[2], cos_theta_v_[pair]};
  }

 private:
  void add(double y, double x) {
    y_[size_] = y;
    x_[size_++] = x;
  }

  std::size_t per_pair_;
  std::size_t pairs_ = 0;
  std::size_t size_ = 0;
  std::array<double, 4 * kBlock> y_;
  std::array<double, 4 * kBlock> x_;
  std::array<double, kBlock> cos_theta_v_;
};

std::vector<std::string> names_of_wavelengths(std::span<const float> wavelengths) {
  std::vector<std::string> names;
  for (const float wavelength : wavelengths) names.push_back(rgl_channel_name(wavelength));
  return names;
}

class RglSource final : public BrdfSource {
 public:
  /// `file` may be nullptr. `as_stored`: values are what it says.
  RglSource(RglMaterial material, Coverage coverage, Negatives negatives, std::shared_ptr<const ByteSource> file,
            bool as_stored)
      : file_(std::move(file)),
        as_stored_(as_stored),
        coverage_(coverage),
        negatives_(negatives),
        jacobian_(material.jacobian),
        phi_i_(std::move(material.phi_i)),
        theta_i_(std::move(material.theta_i)),
        sigma_(material.sigma_grid, std::move(material.sigma)),
        ndf_(material.ndf_grid, std::move(material.ndf)),
        vndf_(material.vndf_grid, material.vndf),
        colours_(material.colour_grid, material.channel_count(), material.colours) {
    traits_.format = "rgl";
    traits_.description = material.description.empty() ? "RGL material" : material.description;
    traits_.channels = {"R", "G", "B"};
    if (material.spectral()) traits_.channels = names_of_wavelengths(material.wavelengths);
    traits_.isotropic = coverage == Coverage::kIsotropic;
    traits_.theta_max_deg = traits_.slice_theta_max_deg = kRglThetaMaxDeg;
    traits_.beyond_theta_max = "extrapolated towards a pole at the horizon";
    add_finding(material.spectral() ? "negative stored spectral values" : "negative stored rgb values",
                material.negative_colour_count, material.colours.size());
    add_finding("negative stored ndf values", material.negative_ndf_count, material.ndf_grid.cell_count());
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    const std::size_t channels = channel_count();
    assert(values.size() == pairs.size() * channels);
    for (std::size_t k = 0; k < pairs.size(); ++k) evaluate_pair(pairs[k], values.subspan(k * channels, channels));
  }

  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override {
    const std::size_t channels = channel_count();
    assert(w_i.size() == w_v.size() && values.size() == w_i.size() * channels);
    const glm::dvec3 normal = {0, 0, 1};  // stands in for what is no direction
    std::array<bool, kBlock> above;
    for (std::size_t first = 0; first < w_i.size(); first += kBlock) {
      const std::size_t count = std::min(kBlock, w_i.size() - first);
      VectorAngles angles(traits_.isotropic);
      for (std::size_t k = 0; k < count; ++k) {
        above[k] = above_horizon(w_i[first + k]) && above_horizon(w_v[first + k]);
        angles.add(above[k] ? glm::dvec3(w_i[first + k]) : normal, above[k] ? glm::dvec3(w_v[first + k]) : normal);
      }
      angles.finish();
      for (std::size_t k = 0; k < count; ++k) {
        const std::span<float> own = values.subspan((first + k) * channels, channels);
        if (above[k]) {
          evaluate_at(angles[k], own);
        } else {
          std::ranges::fill(own, 0.0f);
        }
      }
    }
  }

  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    std::ranges::fill(flags, std::uint8_t{1});
    if (negatives_ != Negatives::kUnmeasured) return;
    std::vector<float> values(channel_count());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      evaluate_pair(pairs[k], values);
      if (*std::ranges::min_element(values) < 0) flags[k] = 0;
    }
  }
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const override {
    return format == kRglTables || (format == traits_.format && as_stored_) ? file_ : nullptr;
  }
  // There is no table of directions; these cells are about as fine as the measurement.
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override {
    if (negatives_ != Negatives::kUnmeasured) return std::nullopt;
    return traits_.isotropic ? MaskGrid{MaskFrame::kAngles, {90, 1, 90, 180}}
                             : MaskGrid{MaskFrame::kAngles, {45, 36, 45, 36}};
  }

 private:
  void add_finding(std::string what, std::uint64_t count, std::uint64_t total) {
    if (count > 0) traits_.findings.push_back({std::move(what), count, total});
  }

  void evaluate_pair(const DirectionPair& pair, std::span<float> values) const {
    if (above_horizon(pair)) {
      evaluate_at(angles_of(pair), values);
    } else {
      std::ranges::fill(values, 0.0f);
    }
  }

  void evaluate_at(const RglAngles& angles, std::span<float> values) const {
    const FoldedAzimuth light = fold(coverage_, phi_i_.front(), angles.phi_i);
    const RglPoint u_m = {unit_from_theta(angles.half_theta),
                          unit_from_phi(light.phi_i + light.sign * angles.half_phi)};
    const RglSlices slices = rgl_slices(phi_i_, theta_i_, light.phi_i, angles.theta_i);
    double scale = 1 / std::max(angles.cos_theta_v, kRglMinCosine);
    if (jacobian_) {
      // Dupuy & Jakob 2018: stored is the weight of a sample, f_r cos(theta_v) over the density ndf(m) / (4 sigma(i)).
      const RglPoint u_i = {unit_from_theta(angles.theta_i), unit_from_phi(light.phi_i)};
      scale *= ndf_.at(u_m) / (4 * sigma_.at(u_i));
    }
    colours_.at(vndf_.invert(u_m, slices), slices, scale, values);
    if (negatives_ == Negatives::kClamp) {
      for (float& value : values) value = std::max(value, 0.0F);
    }
  }

  std::shared_ptr<const ByteSource> file_;
  bool as_stored_;
  Coverage coverage_;
  Negatives negatives_;
  bool jacobian_;
  std::vector<float> phi_i_;
  std::vector<float> theta_i_;
  RglTable sigma_;
  RglTable ndf_;
  RglWarp vndf_;
  RglColours colours_;
  SourceTraits traits_;
};

Result<std::unique_ptr<BrdfSource>> make_source(std::span<const std::byte> bytes, Negatives negatives,
                                                RglSpectral spectral, std::shared_ptr<const ByteSource> file) {
  if (is_fourier_bsdf(bytes)) {
    return unsupported("a Fourier BSDF (magic SCATFUN), not an RGL tensor file", 0);
  }
  const Result<TensorFile> tensors = parse_tensor_file(bytes);
  if (!tensors) return tensors.error();
  Result<RglMaterial> material = parse_rgl_material(*tensors);
  if (!material) return material.error();
  const Result<Coverage> coverage = coverage_of(*material, *tensors);
  if (!coverage) return coverage.error();
  const bool reduce = spectral == RglSpectral::kRgb && material->spectral();
  if (reduce) {
    if (Status reduced = reduce_to_rgb(*material); !reduced) return reduced.error();
  }
  const bool as_stored = !reduce && negatives == Negatives::kKeep;
  return std::unique_ptr<BrdfSource>(
      std::make_unique<RglSource>(*std::move(material), *coverage, negatives, std::move(file), as_stored));
}

}  // namespace

bool recognises_rgl(std::span<const std::byte> bytes) { return is_tensor_file(bytes) || is_fourier_bsdf(bytes); }

Result<std::unique_ptr<BrdfSource>> load_rgl(std::span<const std::byte> bytes, Negatives negatives,
                                             RglSpectral spectral) {
  return make_source(bytes, negatives, spectral, nullptr);
}

Result<std::unique_ptr<BrdfSource>> open_rgl(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<std::shared_ptr<const ByteSource>> viewed = with_view(std::move(bytes));
  if (!viewed) return viewed.error();
  const Negatives negatives = policy_of(options, NonFinite::kRefuse).negatives;
  const auto spectral = value_of(kRglSpectralNames, options.text("spectral").value_or("channels"));
  return make_source(*(*viewed)->view(), negatives, spectral.value_or(RglSpectral::kChannels), *viewed);
}

}  // namespace sbrdf::internal
