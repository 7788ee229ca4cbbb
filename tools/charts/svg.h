#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sbrdf::internal {

/// A place in a picture [pixels]: x to the right, y downwards.
struct Spot {
  double x = 0;
  double y = 0;
};

/// How a line is drawn.
struct Stroke {
  std::string_view colour = "#000000";
  double width = 1;            ///< [pixels]
  std::string_view dash = {};  ///< as in stroke-dasharray; empty: an unbroken line
};

enum class Anchor : std::uint8_t { kStart, kMiddle, kEnd };

/// How text is written.
struct Lettering {
  double size = 12;  ///< [pixels]
  Anchor anchor = Anchor::kStart;
  std::string_view colour = "#000000";
  bool bold = false;
  bool halo = false;     ///< white around it, over what it stands on
  bool upwards = false;  ///< turned by a quarter, to be read from below
};

/// What stands at a point of a chart. All are closed, so that each can be filled or hollow.
enum class Marker : std::uint8_t { kCircle, kSquare, kUp, kDiamond, kDown, kHexagon, kStar, kPentagon };
inline constexpr std::size_t kMarkerCount = 8;

/// A picture in SVG 1.1, element after element. The same calls give the same bytes everywhere: numbers have at most two
/// decimals, text is escaped, and what is no text (control characters, bytes that are not UTF-8) becomes '?'.
class SvgPicture {
 public:
  /// [pixels]; on white. `title` is what programs read out or show for the picture.
  SvgPicture(double width, double height, std::string_view title);

  void line(Spot from, Spot to, const Stroke& stroke);
  void path(std::span<const Spot> spots, const Stroke& stroke);
  void rectangle(Spot corner, double width, double height, std::string_view fill, const Stroke& stroke);
  /// As large as a circle of this radius; hollow ones are white inside.
  void marker(Marker marker, Spot centre, double radius, std::string_view colour, bool filled);
  void text(Spot at, std::string_view text, const Lettering& lettering);

  [[nodiscard]] std::string finish() &&;

 private:
  void polygon(std::span<const Spot> spots, std::string_view colour, bool filled);

  std::string svg_;
};

/// How wide text is, roughly [pixels]: fonts differ.
[[nodiscard]] double text_width(std::string_view text, double size);

/// For XML: escaped, and one line.
[[nodiscard]] std::string xml_text(std::string_view text);

}  // namespace sbrdf::internal
