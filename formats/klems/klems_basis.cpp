#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "formats/core/directions.h"
#include "formats/klems/klems.h"

namespace sbrdf::internal {
namespace {

constexpr double kSnapDeg = 1e-9;

struct KnownBasis {
  std::string_view name;
  std::vector<KlemsRing> rings;
};

std::size_t count_patches(const std::vector<KlemsRing>& rings) {
  std::size_t count = 0;
  for (const KlemsRing& ring : rings) count += ring.phi_count;
  return count;
}

/// J. H. Klems' bases as Radiance 3.46 (2022) and the engine of WINDOW have them, and the older half one.
const std::vector<KnownBasis>& known_bases() {
  static const std::vector<KnownBasis> bases = {
      {"LBNL/Klems Full",
       {{0, 5, 1},
        {5, 15, 8},
        {15, 25, 16},
        {25, 35, 20},
        {35, 45, 24},
        {45, 55, 24},
        {55, 65, 24},
        {65, 75, 16},
        {75, 90, 12}}},
      {"LBNL/Klems Half",
       {{0, 6.5, 1},
        {6.5, 19.5, 8},
        {19.5, 32.5, 12},
        {32.5, 45.5, 16},
        {45.5, 58.5, 20},
        {58.5, 71.5, 12},
        {71.5, 90, 8}}},
      {"LBNL/Klems Half",
       {{0, 6.5, 1},
        {6.5, 19.5, 8},
        {19.5, 32.5, 12},
        {32.5, 46.5, 16},
        {46.5, 61.5, 20},
        {61.5, 76.5, 12},
        {76.5, 90, 4}}},
      {"LBNL/Klems Quarter", {{0, 9, 1}, {9, 27, 8}, {27, 45, 12}, {45, 63, 12}, {63, 90, 8}}},
  };
  return bases;
}

}  // namespace

KlemsBasis::KlemsBasis(std::vector<KlemsRing> rings) : rings_(std::move(rings)), patch_count_(count_patches(rings_)) {}

std::size_t KlemsBasis::patch_of(double theta_deg, double phi_deg) const {
  std::size_t first = 0;
  std::size_t ring = 0;
  while (ring + 1 < rings_.size() && theta_deg >= rings_[ring].upper_deg - kSnapDeg) first += rings_[ring++].phi_count;
  const double count = rings_[ring].phi_count;
  const double place = std::floor(wrap(phi_deg, 360) / 360 * count + 0.5 + kSnapDeg);
  return first + static_cast<std::size_t>(place) % rings_[ring].phi_count;
}

KlemsBasis::Patch KlemsBasis::patch(std::size_t index) const {
  assert(index < patch_count_);
  std::size_t ring = 0;
  while (index >= rings_[ring].phi_count) index -= rings_[ring++].phi_count;
  return {rings_[ring], 360.0 * static_cast<double>(index) / rings_[ring].phi_count};
}

double KlemsBasis::projected_solid_angle(std::size_t index) const {
  const KlemsRing ring = patch(index).ring;
  const double lower = std::sin(radians_from_degrees(ring.lower_deg));
  const double upper = std::sin(radians_from_degrees(ring.upper_deg));
  return kPi * (upper * upper - lower * lower) / ring.phi_count;
}

std::vector<KlemsRing> known_klems_rings(std::string_view name, std::size_t half_patches) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  const auto same = [&](std::string_view other) {
    return std::equal(name.begin(), name.end(), other.begin(), other.end(),
                      [&](char a, char b) { return lower(a) == lower(b); });
  };
  for (const KnownBasis& basis : known_bases()) {
    const bool counts = basis.name != "LBNL/Klems Half" || count_patches(basis.rings) == half_patches;
    if (counts && same(basis.name)) return basis.rings;
  }
  return {};
}

}  // namespace sbrdf::internal
