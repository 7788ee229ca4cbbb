#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// BSDFs of windows and blinds as matrices over patches of the hemisphere (J. H. Klems, 1994), in the XML of LBNL's
// WINDOW and of Radiance: specs/klems.md.

/// Patches with the same bounds of theta [degrees]: `lower` belongs to them, `upper` to the next ring. Patch k has its
/// centre at the azimuth k 360 / phi_count.
struct KlemsRing {
  double lower_deg = 0;
  double upper_deg = 90;
  std::uint32_t phi_count = 1;

  bool operator==(const KlemsRing&) const = default;
};

/// Patches of a hemisphere, ring by ring from the normal outwards. Rings begin at 0, end at 90 and leave no gap.
class KlemsBasis {
 public:
  KlemsBasis() = default;
  explicit KlemsBasis(std::vector<KlemsRing> rings);

  [[nodiscard]] const std::vector<KlemsRing>& rings() const { return rings_; }
  [[nodiscard]] std::size_t patch_count() const { return patch_count_; }
  /// The patch of a direction: theta in [0, 90], any finite phi [degrees both]. A theta within 1e-9 of a bound counts
  /// as on it, so that degrees that went through radians stay on their side.
  [[nodiscard]] std::size_t patch_of(double theta_deg, double phi_deg) const;
  /// A patch's ring, and its azimuth at the centre [degrees].
  struct Patch {
    KlemsRing ring;
    double phi_deg = 0;
  };
  [[nodiscard]] Patch patch(std::size_t index) const;
  /// Integral of cos(theta) over a patch: pi (sin^2 upper - sin^2 lower) / phi_count.
  [[nodiscard]] double projected_solid_angle(std::size_t index) const;

 private:
  std::vector<KlemsRing> rings_;
  std::size_t patch_count_ = 0;
};

/// The bases that files name without defining them. "LBNL/Klems Half" has 77 patches in WINDOW and in today's Radiance,
/// 73 in that of 2011; the count of numbers tells. Empty where `name` (letter case ignored) and count are of none.
[[nodiscard]] std::vector<KlemsRing> known_klems_rings(std::string_view name, std::size_t half_patches);

/// The side that the light comes from.
enum class KlemsSide : std::uint8_t { kFront, kBack };
inline constexpr std::array kKlemsSideNames = {Named{"front", KlemsSide::kFront}, Named{"back", KlemsSide::kBack}};
/// What the values are a mean over.
enum class KlemsBand : std::uint8_t { kVisible, kSolar };
inline constexpr std::array kKlemsBandNames = {Named{"visible", KlemsBand::kVisible},
                                               Named{"solar", KlemsBand::kSolar}};

/// One of the matrices in a file.
struct KlemsChoice {
  KlemsSide side = KlemsSide::kFront;
  KlemsBand band = KlemsBand::kVisible;
  bool transmission = false;
};

struct KlemsMatrix {
  std::string material;  ///< its name, of printable letters; may be empty
  KlemsBasis incident;
  KlemsBasis outgoing;
  /// [1/sr], finite, any sign: patches of `incident` x those of `outgoing`, outgoing fastest, whatever the order in the
  /// file.
  std::vector<double> values;

  [[nodiscard]] double value(std::size_t incident_patch, std::size_t outgoing_patch) const {
    return values[incident_patch * outgoing.patch_count() + outgoing_patch];
  }
};

/// Largest file that is read: ten times what WINDOW and Radiance write.
inline constexpr std::uint64_t kKlemsLargestFile = std::uint64_t{32} << 20U;

/// One matrix of a file. kUnsupported, listing what the file holds, where it is not there, and for tensor trees;
/// kInvalidFile, with the place of the element in the file, for what is no whole XML, a missing or repeated element, a
/// basis that is neither known nor defined soundly, a wrong count of numbers, and what is no finite number.
[[nodiscard]] Result<KlemsMatrix> parse_klems(std::span<const std::byte> bytes, const KlemsChoice& choice);

/// Whether a file is XML with the root element WindowElement. `head` are its first bytes, up to that element at least.
[[nodiscard]] bool recognises_klems(std::span<const std::byte> head);

}  // namespace sbrdf::internal
