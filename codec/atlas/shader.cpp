#include "codec/atlas/shader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

// Nine digits bring a float back; a point makes it one for GLSL.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  std::string result = text;
  if (result.find_first_of(".e") == std::string::npos) result += ".0";
  return result;
}

std::string number(std::size_t value) { return std::to_string(value) + ".0"; }

std::string vec3(std::span<const float, 3> v) {
  return "vec3(" + number(double{v[0]}) + ", " + number(double{v[1]}) + ", " + number(double{v[2]}) + ")";
}

std::string list(const std::string& type, const std::vector<std::string>& entries) {
  std::string text = type + "[" + std::to_string(entries.size()) + "](";
  for (std::size_t k = 0; k < entries.size(); ++k) text += (k == 0 ? "" : ", ") + entries[k];
  return text + ")";
}

const char* const kAngles = R"(
// Azimuth and polar angle [degrees]; an azimuth at a pole is 0.
float sbrdf_azimuth(float y, float x) { return x == 0.0 && y == 0.0 ? 0.0 : degrees(atan(y, x)); }
float sbrdf_polar(vec3 w) { return degrees(atan(length(w.xy), w.z)); }
float sbrdf_wrap(float a, float period) { return a - period * floor(a / period); }
)";

const char* const kHalfDifference = R"(
// (phi_h, phi_d, theta_d, theta_h) [degrees].
vec4 sbrdf_coordinates(vec3 w_i, vec3 w_v) {
  vec3 h = w_i + w_v;
  vec3 e = w_i - w_v;
  float across = length(h.xy);
  float along = length(h);
  vec2 turn = across > 0.0 ? h.xy / across : vec2(1.0, 0.0);
  vec2 tilt = vec2(h.z, across) / along;
  vec2 d = vec2(dot(e.xy, turn) * tilt.x - e.z * tilt.y, e.y * turn.x - e.x * turn.y);
  return vec4(sbrdf_wrap(sbrdf_azimuth(h.y, h.x), 360.0), sbrdf_wrap(sbrdf_azimuth(d.y, d.x), 180.0),
              degrees(atan(length(e), along)), degrees(atan(across, h.z)));
}
)";

const char* const kElevation = R"(
// (s, u, theta_v, theta_i) [degrees], theta_i <= theta_v by reciprocity.
vec4 sbrdf_coordinates(vec3 w_i, vec3 w_v) {
  float phi_i = sbrdf_azimuth(w_i.y, w_i.x);
  float phi_v = sbrdf_azimuth(w_v.y, w_v.x);
  float theta_i = sbrdf_polar(w_i);
  float theta_v = sbrdf_polar(w_v);
  float s = phi_i + phi_v;
  float u = phi_i - phi_v;
  if (theta_i > theta_v) u = -u;
  if (theta_i == theta_v) u = abs(u);
  if (min(theta_i, theta_v) == 0.0) {
    s -= u;
    u = 0.0;
  }
  float turns = floor(u / 360.0);
  return vec4(sbrdf_wrap(s - 360.0 * turns, 720.0), u - 360.0 * turns, max(theta_i, theta_v), min(theta_i, theta_v));
}
)";

class Writer {
 public:
  explicit Writer(const Atlas& atlas) : atlas_(atlas), layout_(atlas.layout), poles_(poles(atlas.layout)) {}

  std::string write() {
    text_ = "#ifndef SBRDF_ATLAS\nuniform highp sampler2D sbrdf_atlas;\n#define SBRDF_ATLAS sbrdf_atlas\n#endif\n";
    text_ += kAngles;
    text_ += layout_.frame == FrameId::kHalfDifference ? kHalfDifference : kElevation;
    write_texel();
    write_fold();
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (layout_.axes[axis].moves()) write_place(axis);
    }
    for (std::size_t k = 0; k < layout_.tables.size(); ++k) write_table(k);
    write_inverse();
    if (!layout_.cells.is_everything()) write_cells();
    write_eval();
    return std::move(text_);
  }

 private:
  void write_texel() {
    text_ +=
        "\n// Bilinear between the centres of texels.\nvec3 sbrdf_texel(float x, float y) {\n"
        "  return textureLod(SBRDF_ATLAS, (vec2(x, y) + 0.5) / vec2(" +
        number(std::size_t{layout_.width}) + ", " + number(std::size_t{layout_.height}) + "), 0.0).rgb;\n}\n";
  }

  // See fold_coordinates.
  void write_fold() {
    const Symmetries& symmetries = layout_.symmetries;
    const bool half = layout_.frame == FrameId::kHalfDifference;
    text_ += "\n// Symmetries of the material.\nvec4 sbrdf_fold(vec4 x) {\n";
    if (symmetries.isotropic) {
      const std::string turn = half ? "180.0" : "360.0";
      text_ += "  x.x = 0.0;\n";
      if (symmetries.mirror_x || symmetries.mirror_y) text_ += "  x.y = min(x.y, " + turn + " - x.y);\n";
    } else if (half && symmetries.mirror_x) {
      if (symmetries.mirror_y) text_ += "  if (x.x >= 180.0) x.x -= 180.0;\n";
      const double plane = symmetries.mirror_y ? 90 : 180;
      text_ += "  if (x.x > " + number(plane) + ") {\n    x.x = " + number(2 * plane) +
               " - x.x;\n    x.y = x.y == 0.0 ? 0.0 : 180.0 - x.y;\n  }\n";
    }
    text_ += "  return x;\n}\n";
  }

  static bool is_even(const AtlasAxis& axis) {
    const std::size_t cells = axis.nodes_deg.size() - 1;
    for (std::size_t k = 0; k < cells; ++k) {
      if (axis.texels[k + 1] - axis.texels[k] != axis.texels[1]) return false;
      if (std::abs(axis.nodes_deg[k + 1] * static_cast<double>(cells) -
                   axis.nodes_deg.back() * static_cast<double>(k + 1)) > 1e-6) {
        return false;
      }
    }
    return !axis.root_spacing;
  }

  // A cell of an axis, the fraction of the way through it, and the texel of slices along the axis.
  void write_place(std::size_t axis_number) {
    const AtlasAxis& axis = layout_.axes[axis_number];
    const std::size_t cells = axis.nodes_deg.size() - 1;
    text_ += "\nvec3 sbrdf_place_" + std::to_string(axis_number) + "(float x) {\n";
    if (is_even(axis)) {
      text_ += "  float at = clamp(x * " + number(static_cast<double>(cells) / axis.nodes_deg.back()) + ", 0.0, " +
               number(cells) + ");\n  float cell = min(floor(at), " + number(cells - 1) +
               ");\n  return vec3(cell, at - cell, at * " + number(std::size_t{axis.texels[1]}) + ");\n}\n";
      return;
    }
    std::vector<std::string> rows;
    std::string cell = "0.0";
    for (std::size_t k = 0; k < cells; ++k) {
      rows.push_back(
          "vec4(" + number(axis.nodes_deg[k]) + ", " + number(1 / (axis.nodes_deg[k + 1] - axis.nodes_deg[k])) + ", " +
          number(std::size_t{axis.texels[k]}) + ", " + number(std::size_t{axis.texels[k + 1] - axis.texels[k]}) + ")");
      if (k > 0) cell += " + step(" + number(axis.nodes_deg[k]) + ", x)";
    }
    text_ += "  const vec4 cells[" + std::to_string(cells) + "] = " + list("vec4", rows) + ";\n  float cell = " + cell +
             ";\n  vec4 c = cells[int(cell)];\n  float t = clamp((x - c.x) * c.y, 0.0, 1.0);\n";
    text_ += axis.root_spacing ? "  return vec3(cell, t, c.z + c.w * (cell == 0.0 ? sqrt(t) : t));\n}\n"
                               : "  return vec3(cell, t, c.z + c.w * t);\n}\n";
  }

  // One bilinear look-up in the tile between two nodes of the explicit axes.
  void write_table(std::size_t k) {
    const AtlasTable& table = layout_.tables[k];
    text_ += "\nvec3 sbrdf_table_" + std::to_string(k) + "(float along, float across, float first, float second) {\n";
    if (table.triangular) {
      text_ += "  float tile = first * (first + 3.0) * 0.5 + second;\n";
    } else {
      const std::size_t row = table.between.size() > 1 ? step_count(layout_, table.between[1]) : 1;
      text_ += "  float tile = first * " + number(row) + " + second;\n";
    }
    text_ += (layout_.cells.is_everything() ? texel_by_row(table) : texel_by_place(table)) + scaled(atlas_.scales[k]) +
             "}\n";
  }

  static std::string texel_by_row(const AtlasTable& table) {
    const std::string per_row = number(std::size_t{table.tiles_per_row});
    return "  float row = floor((tile + 0.5) / " + per_row + ");\n  vec3 texel = sbrdf_texel(" +
           number(std::size_t{table.x}) + " + (tile - row * " + per_row + ") * " +
           number(std::size_t{table.tile_width}) + " + along, " + number(std::size_t{table.y}) + " + row * " +
           number(std::size_t{table.tile_height}) + " + across);\n";
  }

  // Of tiles that are left out in part, where their first texel would lie; of those that are not there, anywhere.
  static std::string texel_by_place(const AtlasTable& table) {
    std::vector<std::string> places;
    for (const AtlasTile& tile : table.tiles) {
      places.push_back("vec2(" + number(static_cast<double>(tile.x) - tile.first_column) + ", " +
                       number(static_cast<double>(tile.y) - tile.first_row) + ")");
    }
    return "  const vec2 places[" + std::to_string(places.size()) + "] = " + list("vec2", places) +
           ";\n  vec2 place = places[int(tile)];\n  vec3 texel = sbrdf_texel(place.x + along, place.y + across);\n";
  }

  // `texel` is that of the tile with the number `tile`.
  static std::string scaled(const std::vector<AtlasScale>& scales) {
    if (scales.size() == 1) {
      const AtlasScale& scale = scales.front();
      return "  return " + vec3(scale.offset) + " + " + vec3(scale.scale) + " * texel;\n";
    }
    std::vector<std::string> offsets;
    std::vector<std::string> factors;
    for (const AtlasScale& scale : scales) {
      offsets.push_back(vec3(scale.offset));
      factors.push_back(vec3(scale.scale));
    }
    const std::string type = "  const vec3 ";
    const std::string size = "[" + std::to_string(scales.size()) + "] = ";
    return type + "offsets" + size + list("vec3", offsets) + ";\n" + type + "factors" + size + list("vec3", factors) +
           ";\n  return offsets[int(tile)] + factors[int(tile)] * texel;\n";
  }

  void write_inverse() {
    const AtlasDomain& domain = atlas_.domain;
    text_ += "\n// f_r [1/sr] of v.\nvec3 sbrdf_inverse(vec3 v) {\n";
    if (domain.log) {
      text_ +=
          "  const vec3 at_zero = " + vec3(domain.at_zero) + ";\n  const vec3 floor_value = " + vec3(domain.floor) +
          ";\n  vec3 high = " + vec3(domain.reference) + " * exp(0.5 * min(v, 160.0)) * exp(0.5 * min(v, 160.0));\n" +
          "  vec3 middle = floor_value * (v - at_zero);\n" +
          "  vec3 down = 0.5 * min(at_zero - 1.0 - v, 160.0);\n  vec3 low = -floor_value * exp(down) * exp(down);\n" +
          "  vec3 f = mix(mix(low, middle, step(at_zero - 1.0, v)), high, step(" + vec3(domain.at_floor) + ", v));\n";
    } else {
      text_ += "  vec3 f = v;\n";
    }
    text_ += "  f = clamp(f, " + vec3(domain.least) + ", " + vec3(domain.most) + ");\n";
    if (domain.grey_divisor != 0) {
      text_ += "  f -= " + vec3(domain.grey_shares) + " * ((f.r + f.g + f.b) / " + number(double{domain.grey_divisor}) +
               ");\n";
    }
    text_ += "  return f;\n}\n";
  }

  void write_eval() {
    text_ +=
        "\nvec3 sbrdf_eval(vec3 w_i, vec3 w_v) {\n  if (w_i.z < 0.0 || w_v.z < 0.0) return vec3(0.0);\n"
        "  vec4 x = sbrdf_fold(sbrdf_coordinates(w_i, w_v));\n";
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (!layout_.axes[axis].moves()) continue;
      const std::string number_text = std::to_string(axis);
      text_ += "  vec3 p" + number_text + " = sbrdf_place_" + number_text + "(x." + "xyzw"[axis] + ");\n";
    }
    if (!layout_.cells.is_everything()) write_check();
    if (layout_.dense_along) write_texel_steps();
    text_ += "  vec3 v = vec3(0.0);\n  float w;\n";
    for (std::size_t k = 0; k < layout_.tables.size(); ++k) write_sum(k);
    if (layout_.ring && layout_.ring->tile_width > 0) {
      for (const AtlasPole& pole : poles_) write_ring(pole);
    }
    text_ += "  return sbrdf_inverse(v);\n}\n";
  }

  // One bit for each cell, the last axis fastest.
  void write_cells() {
    const std::vector<bool>& flags = layout_.cells.flags();
    std::vector<std::string> words;
    for (std::size_t first = 0; first < flags.size(); first += 32) {
      std::uint32_t word = 0;
      for (std::size_t k = first; k < std::min(first + 32, flags.size()); ++k) {
        word |= static_cast<std::uint32_t>(flags[k]) << (k - first);
      }
      words.push_back(std::to_string(word) + "u");
    }
    text_ += "\n#ifdef SBRDF_DEBUG\nbool sbrdf_holds(vec4 cell) {\n  const uint bits[" + std::to_string(words.size()) +
             "] = " + list("uint", words) + ";\n  int number = int(((cell.x * ";
    const CellSet::Counts& counts = layout_.cells.counts();
    text_ += number(std::size_t{counts[1]}) + " + cell.y) * " + number(std::size_t{counts[2]}) + " + cell.z) * " +
             number(std::size_t{counts[3]}) +
             " + cell.w + 0.5);\n  return ((bits[number >> 5] >> uint(number & 31)) & 1u) != 0u;\n}\n#endif\n";
  }

  // See place_between.
  void write_texel_steps() {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (!layout_.axes[axis].moves() || axis == *layout_.dense_along) continue;
      const std::string p = "p" + std::to_string(axis);
      text_ += "  " + p + ".x = min(floor(" + p + ".z), " + number(step_count(layout_, axis) - 2) + ");\n  " + p +
               ".y = " + p + ".z - " + p + ".x;\n";
    }
  }

  void write_check() {
    std::string cell;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      cell += axis == 0 ? "" : ", ";
      cell += layout_.axes[axis].moves() ? "p" + std::to_string(axis) + ".x" : std::string("0.0");
    }
    text_ += "#ifdef SBRDF_DEBUG\n  if (!sbrdf_holds(vec4(" + cell + "))) return " + vec3(kLeftOutColour) +
             ";  // left out\n#endif\n";
  }

  // Tiles at a pole are taken out as often as there are rings that stand for them.
  void write_sum(std::size_t k) {
    const AtlasTable& table = layout_.tables[k];
    for (unsigned bits = 0; bits < (1U << table.between.size()); ++bits) {
      std::string weight;
      std::string share;
      std::string nodes;
      for (std::size_t m = 0; m < 2; ++m) {
        if (m >= table.between.size()) {
          nodes += ", 0.0";
          continue;
        }
        const std::string p = "p" + std::to_string(table.between[m]);
        const bool far = ((bits >> m) & 1U) != 0;
        weight += (m == 0 ? "" : " * ") + (far ? p + ".y" : "(1.0 - " + p + ".y)");
        nodes += ", " + p + ".x" + (far ? " + 1.0" : "");
        for (const AtlasPole& pole : poles_) {
          if (pole.polar_axis == table.between[m] && !far) share += " - (" + p + ".x == 0.0 ? 1.0 : 0.0)";
        }
      }
      if (!share.empty()) weight += " * (1.0" + share + ")";
      const std::string across = table.across ? "p" + std::to_string(*table.across) : "";
      text_ += "  w = " + (weight.empty() ? "1.0" : weight) + ";\n  v += w * sbrdf_table_" + std::to_string(k) + "(p" +
               std::to_string(table.along) + ".z, " +
               (table.across ? across + ".x + " + across + ".y" : std::string("0.0")) + nodes + ");\n";
    }
  }

  void write_ring(const AtlasPole& pole) {
    const AtlasRing& ring = *layout_.ring;
    const std::string polar = "p" + std::to_string(pole.polar_axis);
    const std::string period = number(ring.period_deg);
    const std::string other = pole.ring_axis == kAxial ? "x.y" : "x.x";
    const AtlasScale& scale = atlas_.scales.back().front();
    text_ += "  if (" + polar + ".x == 0.0) {\n    float turn = sbrdf_wrap(x." + "xyzw"[pole.ring_axis] +
             (pole.sign > 0 ? " + " : " - ") + other + ", " + period + ") / " + period + ";\n    v += (1.0 - " + polar +
             ".y) * (" + vec3(scale.offset) + " + " + vec3(scale.scale) + " * sbrdf_texel(" +
             number(std::size_t{ring.x}) + " + turn * " + number(std::size_t{ring.ring_texels}) + ", " +
             number(std::size_t{ring.y}) + " + p" + std::to_string(pole.along) + ".z));\n  }\n";
  }

  const Atlas& atlas_;
  const AtlasLayout& layout_;
  std::vector<AtlasPole> poles_;
  std::string text_;
};

}  // namespace

std::string atlas_shader(const Atlas& atlas) { return Writer(atlas).write(); }

}  // namespace sbrdf::internal
