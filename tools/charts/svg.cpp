#include "tools/charts/svg.h"

#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

constexpr double kPiHere = 3.14159265358979323846;
constexpr double kOutline = 1.5;            // width of the outline of markers [pixels]
constexpr double kWidthOfCharacter = 0.56;  // of the size, on the average of the fonts below

/// At most two decimals, no more than it takes, and no "-0".
std::string number(double value) {
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string points_of(std::span<const Spot> spots) {
  std::string points;
  for (const Spot& spot : spots)
    points += fmt::format("{}{},{}", points.empty() ? "" : " ", number(spot.x), number(spot.y));
  return points;
}

std::string stroke_of(const Stroke& stroke) {
  const std::string dash = stroke.dash.empty() ? "" : fmt::format(" stroke-dasharray=\"{}\"", stroke.dash);
  return fmt::format("stroke=\"{}\" stroke-width=\"{}\"{}", stroke.colour, number(stroke.width), dash);
}

/// Corners on a circle, the first at an angle from the top [turns]; every second one at `inner` times the radius.
std::vector<Spot> corners(Spot centre, double radius, std::size_t count, double first, double inner = 1) {
  std::vector<Spot> spots;
  for (std::size_t k = 0; k < count; ++k) {
    const double angle = 2 * kPiHere * (first + static_cast<double>(k) / static_cast<double>(count));
    const double r = k % 2 == 1 ? inner * radius : radius;
    spots.push_back({centre.x + r * std::sin(angle), centre.y - r * std::cos(angle)});
  }
  return spots;
}

std::vector<Spot> corners_of(Marker marker, Spot centre, double radius) {
  // Enlarged so that all seem alike.
  switch (marker) {
    case Marker::kSquare:
      return corners(centre, 1.25 * radius, 4, 0.125);
    case Marker::kUp:
      return corners(centre, 1.4 * radius, 3, 0);
    case Marker::kDiamond:
      return corners(centre, 1.4 * radius, 4, 0);
    case Marker::kDown:
      return corners(centre, 1.4 * radius, 3, 0.5);
    case Marker::kHexagon:
      return corners(centre, 1.15 * radius, 6, 0.25);
    case Marker::kStar:
      return corners(centre, 1.6 * radius, 10, 0, 0.45);
    case Marker::kPentagon:
      return corners(centre, 1.2 * radius, 5, 0.5);
    case Marker::kCircle:
      break;
  }
  return {};
}

}  // namespace

SvgPicture::SvgPicture(double width, double height, std::string_view title) {
  svg_ = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\">\n"
      "<title>{2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#FFFFFF\"/>\n",
      number(width), number(height), xml_text(title));
}

void SvgPicture::line(Spot from, Spot to, const Stroke& stroke) {
  svg_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", number(from.x), number(from.y),
                      number(to.x), number(to.y), stroke_of(stroke));
}

void SvgPicture::path(std::span<const Spot> spots, const Stroke& stroke) {
  svg_ += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke-linejoin=\"round\" {}/>\n", points_of(spots),
                      stroke_of(stroke));
}

void SvgPicture::rectangle(Spot corner, double width, double height, std::string_view fill, const Stroke& stroke) {
  svg_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" {}/>\n", number(corner.x),
                      number(corner.y), number(width), number(height), fill, stroke_of(stroke));
}

void SvgPicture::polygon(std::span<const Spot> spots, std::string_view colour, bool filled) {
  svg_ += fmt::format("<polygon points=\"{}\" fill=\"{}\" stroke-linejoin=\"round\" {}/>\n", points_of(spots),
                      filled ? colour : "#FFFFFF", stroke_of({colour, kOutline}));
}

void SvgPicture::marker(Marker marker, Spot centre, double radius, std::string_view colour, bool filled) {
  if (marker != Marker::kCircle) {
    polygon(corners_of(marker, centre, radius), colour, filled);
    return;
  }
  svg_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\" {}/>\n", number(centre.x), number(centre.y),
                      number(radius), filled ? colour : "#FFFFFF", stroke_of({colour, kOutline}));
}

void SvgPicture::text(Spot at, std::string_view text, const Lettering& lettering) {
  constexpr std::array<std::string_view, 3> kAnchors = {"start", "middle", "end"};
  const std::string turn =
      lettering.upwards ? fmt::format(" transform=\"rotate(-90 {} {})\"", number(at.x), number(at.y)) : "";
  const auto write = [&](std::string_view paint) {
    svg_ += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{}\" {}{}{}>{}</text>\n", number(at.x),
                        number(at.y), number(lettering.size), kAnchors.at(static_cast<std::size_t>(lettering.anchor)),
                        paint, lettering.bold ? " font-weight=\"bold\"" : "", turn, xml_text(text));
  };
  if (lettering.halo) write("fill=\"none\" stroke=\"#FFFFFF\" stroke-width=\"3\"");
  write(fmt::format("fill=\"{}\"", lettering.colour));
}

std::string SvgPicture::finish() && {
  svg_ += "</svg>\n";
  return std::move(svg_);
}

double text_width(std::string_view text, double size) {
  return kWidthOfCharacter * size * static_cast<double>(character_count(text));
}

std::string xml_text(std::string_view text) {
  std::string escaped;
  for (const char c : one_line(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace sbrdf::internal
