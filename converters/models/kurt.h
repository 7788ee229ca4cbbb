#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// One specular lobe of the model of Kurt, Szirmay-Kalos and Křivánek, "An Anisotropic BRDF Model for Fitting and Monte
/// Carlo Rendering", 2010 (specs/kurt.md).
struct KurtLobe {
  std::array<double, 3> k_s = {0, 0, 0};  ///< weight of R, G, B; at least 0
  double f_0 = 1;                         ///< Schlick's reflectance at normal incidence; at least 0
  double m_x = 1;                         ///< Beckmann roughness along the tangent; above 0
  double m_y = 1;                         ///< the same across the tangent
  double alpha = 0;                       ///< exponent of the cosines' product; at least 0
};

/// f_r = k_d / pi + sum over lobes of k_s F D / (4 (v.h) ((l.n)(v.n))^alpha).
struct KurtModel {
  std::string name;
  std::array<double, 3> k_d = {0, 0, 0};
  std::vector<KurtLobe> lobes;
};

/// Largest k_d, k_s and f_0; m_x and m_y lie between its inverse and itself.
inline constexpr double kKurtLargest = 1e6;
inline constexpr double kKurtLargestAlpha = 10;
/// Directions closer to the horizon than this [radians] are evaluated at this distance: the model grows without bound
/// there where alpha > 0.
inline constexpr double kKurtGrazing = 1e-4;

/// The ten materials of Table 2 of Vávra and Filip, "Adaptive Measurement of Anisotropic Material Appearance",
/// supplemental material, 2017, in its order.
[[nodiscard]] std::vector<std::string> kurt_material_names();

/// A material of Table 2. Upper and lower case are the same, and so are ' ', '-' and '_'. kUsage where there is none of
/// that name; the message lists the names.
Result<KurtModel> kurt_material(std::string_view name);

/// One object {"name": string, "k_d": [r,g,b], "lobes": [{"k_s": [r,g,b], "f_0": x, "m_x": x, "m_y": x, "alpha": x}]}.
/// All keys are needed, each once, and no others; the name has no control characters. kInvalidFile otherwise, and where
/// a number is outside its range; the message names the key ("lobes[1].m_x"), or the offset where the text is no JSON.
Result<KurtModel> parse_kurt_json(std::string_view text);

/// The text that parse_kurt_json reads, with every number as it is.
[[nodiscard]] std::string emit_kurt_json(const KurtModel& model);

/// kUsage where a number of the model is outside its range; the message names it as parse_kurt_json does.
Status check_kurt_model(const KurtModel& model);

/// The model as a source: reciprocal, isotropic if every lobe has m_x = m_y. Values above the largest float become
/// that. `model` must pass check_kurt_model.
[[nodiscard]] std::unique_ptr<BrdfSource> make_kurt_source(const KurtModel& model);

}  // namespace sbrdf::internal
