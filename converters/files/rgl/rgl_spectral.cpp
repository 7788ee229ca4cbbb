#include "converters/files/rgl/rgl_spectral.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>

#include "converters/files/rgb_of_xyz.h"
#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

constexpr std::string_view kUnit = " nm";
constexpr double kFirstNm = 380;
constexpr double kStepNm = 10;

/// Daylight and the observer at one wavelength.
struct Observer {
  double d65, x, y, z;
};
// CIE standard illuminant D65 (ISO 11664-2) and colour matching functions of 1931 (ISO 11664-1), every 10 nm from 380.
constexpr std::array<Observer, 41> kObserver = {
    {{49.9755, 0.001368, 0.000039, 0.006450}, {54.6482, 0.004243, 0.000120, 0.020050},
     {82.7549, 0.014310, 0.000396, 0.067850}, {91.4860, 0.043510, 0.001210, 0.207400},
     {93.4318, 0.134380, 0.004000, 0.645600}, {86.6823, 0.283900, 0.011600, 1.385600},
     {104.865, 0.348280, 0.023000, 1.747060}, {117.008, 0.336200, 0.038000, 1.772110},
     {117.812, 0.290800, 0.060000, 1.669200}, {114.861, 0.195360, 0.090980, 1.287640},
     {115.923, 0.095640, 0.139020, 0.812950}, {108.811, 0.032010, 0.208020, 0.465180},
     {109.354, 0.004900, 0.323000, 0.272000}, {107.802, 0.009300, 0.503000, 0.158200},
     {104.790, 0.063270, 0.710000, 0.078250}, {107.689, 0.165500, 0.862000, 0.042160},
     {104.405, 0.290400, 0.954000, 0.020300}, {104.046, 0.433450, 0.994950, 0.008750},
     {100.000, 0.594500, 0.995000, 0.003900}, {96.3342, 0.762100, 0.952000, 0.002100},
     {95.7880, 0.916300, 0.870000, 0.001650}, {88.6856, 1.026300, 0.757000, 0.001100},
     {90.0062, 1.062200, 0.631000, 0.000800}, {89.5991, 1.002600, 0.503000, 0.000340},
     {87.6987, 0.854450, 0.381000, 0.000190}, {83.2886, 0.642400, 0.265000, 0.000050},
     {83.6992, 0.447900, 0.175000, 0.000020}, {80.0268, 0.283500, 0.107000, 0.000000},
     {80.2146, 0.164900, 0.061000, 0.000000}, {82.2778, 0.087400, 0.032000, 0.000000},
     {78.2842, 0.046770, 0.017000, 0.000000}, {69.7213, 0.022700, 0.008210, 0.000000},
     {71.6091, 0.011359, 0.004102, 0.000000}, {74.3490, 0.005790, 0.002091, 0.000000},
     {61.6040, 0.002899, 0.001047, 0.000000}, {69.8856, 0.001440, 0.000520, 0.000000},
     {75.0870, 0.000690, 0.000249, 0.000000}, {63.5927, 0.000332, 0.000120, 0.000000},
     {46.4182, 0.000166, 0.000060, 0.000000}, {66.8054, 0.000083, 0.000030, 0.000000},
     {63.3828, 0.000042, 0.000015, 0.000000}}};

/// Calls `add(index, weight)` for the wavelengths between which `at` lies.
template <class Add>
void spread(std::span<const float> wavelengths, double at, const Add& add) {
  const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), at);
  if (above == wavelengths.begin()) return add(0, 1);
  const auto high = static_cast<std::size_t>(above - wavelengths.begin());
  if (high == wavelengths.size()) return add(high - 1, 1);
  const double weight = (at - wavelengths[high - 1]) / (wavelengths[high] - wavelengths[high - 1]);
  add(high - 1, 1 - weight);
  add(high, weight);
}

}  // namespace

std::string rgl_channel_name(float wavelength_nm) { return fmt::format("{}{}", wavelength_nm, kUnit); }

std::optional<std::vector<float>> wavelengths_of_channels(std::span<const std::string> names) {
  std::vector<float> wavelengths;
  for (const std::string_view name : names) {
    if (!name.ends_with(kUnit)) return std::nullopt;
    const std::optional<double> wavelength = parse_number(name.substr(0, name.size() - kUnit.size()));
    if (!wavelength || *wavelength <= 0 || *wavelength > 1e9) return std::nullopt;
    const auto nm = static_cast<float>(*wavelength);
    if (!wavelengths.empty() && nm <= wavelengths.back()) return std::nullopt;
    wavelengths.push_back(nm);
  }
  return wavelengths;
}

std::vector<double> rgl_rgb_weights(std::span<const float> wavelengths_nm) {
  constexpr int kParts = 10;  // steps of 1 nm: the products of the curves and a spectrum that is linear between nodes
  const std::size_t count = wavelengths_nm.size();
  std::vector<double> weights(kRglRgbCount * count);
  for (std::size_t step = 0; step + 1 < kObserver.size(); ++step) {
    const Observer& a = kObserver[step];
    const Observer& b = kObserver[step + 1];
    for (int part = 0; part < kParts; ++part) {
      const double t = (part + 0.5) / kParts;
      const double light = a.d65 + t * (b.d65 - a.d65);
      const std::array<double, 3> xyz = {light * (a.x + t * (b.x - a.x)), light * (a.y + t * (b.y - a.y)),
                                         light * (a.z + t * (b.z - a.z))};
      spread(wavelengths_nm, kFirstNm + kStepNm * (static_cast<double>(step) + t), [&](std::size_t k, double weight) {
        for (std::size_t c = 0; c < kRglRgbCount; ++c) {
          for (std::size_t axis = 0; axis < 3; ++axis)
            weights[c * count + k] += kRgbOfXyz[c][axis] * xyz[axis] * weight;
        }
      });
    }
  }
  // The white of the tables is that of the matrix to 0.1 %; this makes it exact.
  for (std::size_t c = 0; c < kRglRgbCount; ++c) {
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k) sum += weights[c * count + k];
    for (std::size_t k = 0; k < count; ++k) weights[c * count + k] /= sum;
  }
  return weights;
}

Status reduce_to_rgb(RglMaterial& material) {
  const std::vector<float>& nm = material.wavelengths;
  if (nm.front() > kRglColoursFromNm || nm.back() < kRglColoursToNm) {
    return unsupported(
        fmt::format("wavelengths from {:g} to {:g} nm: colours need all from {:g} to {:g} nm; "
                    "--spectral channels reads what there is",
                    nm.front(), nm.back(), kRglColoursFromNm, kRglColoursToNm));
  }
  const std::vector<double> weights = rgl_rgb_weights(nm);
  const std::size_t cells = material.colour_grid.cell_count();
  std::vector<float> rgb(material.slice_count() * kRglRgbCount * cells);
  for (std::size_t n = 0; n < rgb.size(); ++n) {
    const std::size_t c = n / cells % kRglRgbCount;
    const float* spectrum = material.colours.data() + n / cells / kRglRgbCount * nm.size() * cells + n % cells;
    double sum = 0;
    for (std::size_t k = 0; k < nm.size(); ++k) sum += weights[c * nm.size() + k] * spectrum[k * cells];
    if (std::abs(sum) > std::numeric_limits<float>::max()) return invalid_file("a colour is beyond the range of float");
    rgb[n] = static_cast<float>(sum);
  }
  if (*std::ranges::max_element(rgb) <= 0) return invalid_file("no colour of the spectra is positive");
  material.colours = std::move(rgb);
  material.wavelengths.clear();
  material.negative_colour_count =
      static_cast<std::uint64_t>(std::ranges::count_if(material.colours, [](float value) { return value < 0; }));
  return ok_status();
}

}  // namespace sbrdf::internal
