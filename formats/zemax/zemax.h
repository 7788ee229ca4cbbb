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

// Zemax (Ansys) tabular BSDF text, specs/zemax.md: a header of keywords, then blocks of numbers.

/// Which azimuths around the mirror direction a file lists.
enum class ZemaxSymmetry : std::uint8_t {
  kPlaneSymmetrical,  ///< 0 to 180 degrees; the other half is the same mirrored at the plane of incidence
  kAsymmetrical,      ///< the whole turn
  kAsymmetrical4d,    ///< the whole turn, for several rotations of the sample
};
inline constexpr std::array kZemaxSymmetryNames = {Named{"PlaneSymmetrical", ZemaxSymmetry::kPlaneSymmetrical},
                                                   Named{"Asymmetrical", ZemaxSymmetry::kAsymmetrical},
                                                   Named{"Asymmetrical4D", ZemaxSymmetry::kAsymmetrical4d}};
/// Reflection or transmission.
enum class ZemaxScatter : std::uint8_t { kBrdf, kBtdf };
inline constexpr std::array kZemaxScatterNames = {Named{"BRDF", ZemaxScatter::kBrdf},
                                                  Named{"BTDF", ZemaxScatter::kBtdf}};
/// One channel, or the tristimulus values X, Y, Z.
enum class ZemaxSpectrum : std::uint8_t { kMonochrome, kXyz };
inline constexpr std::array kZemaxSpectrumNames = {Named{"Monochrome", ZemaxSpectrum::kMonochrome},
                                                   Named{"XYZ", ZemaxSpectrum::kXyz}};

/// Largest count of angles in one list.
inline constexpr std::size_t kZemaxMostAngles = 65536;

/// Largest |value|: sums of a few still fit a float.
inline constexpr double kZemaxLargest = 1e37;

/// What a file says.
struct ZemaxTable {
  ZemaxSymmetry symmetry = ZemaxSymmetry::kPlaneSymmetrical;
  ZemaxSpectrum spectrum = ZemaxSpectrum::kMonochrome;
  ZemaxScatter scatter = ZemaxScatter::kBrdf;
  // Angles [degrees], each list rising, with at least one.
  std::vector<double> rotations;   ///< of the sample, within [-360, 360] and one turn
  std::vector<double> incidences;  ///< of the light, and so of the mirror direction, from the normal, in [0, 90]
  std::vector<double> azimuths;    ///< around the mirror direction, within [-360, 360] and one turn
  std::vector<double> radials;     ///< from the mirror direction, in [0, 180]
  /// "TIS" of each block: the total integrated scatter as whoever wrote the file saw it; rotations x incidences of a
  /// channel, incidence fastest, channel slowest.
  std::vector<double> tis;
  /// f_r [1/sr], any sign; rotations x incidences x azimuths x radials of a channel, radial fastest, channel
  /// slowest.
  std::vector<double> values;

  [[nodiscard]] std::size_t channel_count() const { return spectrum == ZemaxSpectrum::kXyz ? 3 : 1; }
  /// Of one channel.
  [[nodiscard]] std::size_t block_count() const { return rotations.size() * incidences.size(); }
  /// Values of one block.
  [[nodiscard]] std::size_t block_size() const { return azimuths.size() * radials.size(); }
};

/// A whole file. Lines end with LF or CR LF; words are parted by blanks and tabs; letter case means nothing; a line
/// that begins with '#' is a comment. The header is eight keywords in any order, each once; the four lists may go on
/// over several lines, a row of a block is one line.
///
/// kInvalidFile, with the line and its place in the file, for an unknown, missing or repeated keyword, an angle out of
/// its range or not above the one before, what is no finite number (NaN among them) or
/// beyond kZemaxLargest, a wrong count of numbers in a list, a row, a block or the file, and anything behind the last
/// block. Counts are held against the bytes that are left before anything is allocated.
[[nodiscard]] Result<ZemaxTable> parse_zemax(std::string_view text);

/// Whether a file begins as such a file does: the first line that is no comment begins with a keyword of the header,
/// and another one does, too. `head` are its first bytes, enough to see both lines.
[[nodiscard]] bool recognises_zemax(std::span<const std::byte> head);

}  // namespace sbrdf::internal
