#include "codec/atlas/shader.h"

#include <algorithm>
#include <array>
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
  explicit Writer(const Atlas& atlas) : atlas_(atlas), layout_(atlas.layout) {
    // A ring that is left out is asked for nowhere.
    if (layout_.ring && layout_.ring->tile_width > 0) poles_ = poles(layout_);
  }

  std::string write() {
    text_ = "#ifndef SBRDF_ATLAS\nuniform highp sampler2D sbrdf_atlas;\n#define SBRDF_ATLAS sbrdf_atlas\n#endif\n";
    text_ += kAngles;
    text_ += layout_.frame == FrameId::kHalfDifference ? kHalfDifference : kElevation;
    write_texel();
    write_fold();
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (layout_.axes[axis].moves()) write_place(axis);
    }
    for (std::size_t k = 0; k < layout_.tables.size(); ++k) {
      write_tile(k);
      write_scales(k);
    }
    write_inverse();
    if (!layout_.cells.is_everything()) write_cells();
    write_eval();
    return std::move(text_);
  }

 private:
  // Multiplied rather than divided by the sides, as everywhere: a division takes as long as a dozen products.
  void write_texel() {
    text_ +=
        "\n// Bilinear between the centres of texels.\nvec3 sbrdf_texel(vec2 at) {\n  return textureLod(SBRDF_ATLAS, "
        "at * vec2(" +
        number(1.0 / layout_.width) + ", " + number(1.0 / layout_.height) + "), 0.0).rgb;\n}\n";
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

  static bool has_even_nodes(const AtlasAxis& axis) {
    const std::size_t cells = axis.nodes_deg.size() - 1;
    for (std::size_t k = 0; k < cells; ++k) {
      if (std::abs(axis.nodes_deg[k + 1] * static_cast<double>(cells) -
                   axis.nodes_deg.back() * static_cast<double>(k + 1)) > 1e-6) {
        return false;
      }
    }
    return true;
  }

  static bool has_even_texels(const AtlasAxis& axis) {
    for (std::size_t k = 1; k < axis.texels.size(); ++k) {
      if (axis.texels[k] != k * axis.texels[1]) return false;
    }
    return true;
  }

  // A cell of an axis, the fraction of the way through it, and the texel of slices along the axis.
  void write_place(std::size_t axis_number) {
    const AtlasAxis& axis = layout_.axes[axis_number];
    const std::size_t cells = axis.nodes_deg.size() - 1;
    const bool even_nodes = has_even_nodes(axis);
    text_ += "\nvec3 sbrdf_place_" + std::to_string(axis_number) + "(float x) {\n";
    if (even_nodes) {
      text_ += "  float at = clamp(x * " + number(static_cast<double>(cells) / axis.nodes_deg.back()) + ", 0.0, " +
               number(cells) + ");\n  float cell = min(floor(at), " + number(cells - 1) +
               ");\n  float t = at - cell;\n";
    } else {
      std::vector<std::string> rows;
      std::string cell = "0.0";
      for (std::size_t k = 0; k < cells; ++k) {
        rows.push_back("vec2(" + number(axis.nodes_deg[k]) + ", " +
                       number(1 / (axis.nodes_deg[k + 1] - axis.nodes_deg[k])) + ")");
        if (k > 0) cell += " + step(" + number(axis.nodes_deg[k]) + ", x)";
      }
      text_ += "  const vec2 nodes[" + std::to_string(cells) + "] = " + list("vec2", rows) +
               ";\n  float cell = " + cell +
               ";\n  vec2 node = nodes[int(cell)];\n  float t = clamp((x - node.x) * node.y, 0.0, 1.0);\n";
    }
    const std::string way = axis.root_spacing ? "(cell == 0.0 ? sqrt(t) : t)" : "t";
    if (has_even_texels(axis)) {
      text_ += "  return vec3(cell, t, (cell + " + way + ") * " + number(std::size_t{axis.texels[1]}) + ");\n}\n";
      return;
    }
    std::vector<std::string> rows;
    for (std::size_t k = 0; k < cells; ++k) {
      rows.push_back("vec2(" + number(std::size_t{axis.texels[k]}) + ", " +
                     number(std::size_t{axis.texels[k + 1] - axis.texels[k]}) + ")");
    }
    text_ += "  const vec2 texels[" + std::to_string(cells) + "] = " + list("vec2", rows) +
             ";\n  vec2 texel = texels[int(cell)];\n  return vec3(cell, t, texel.x + texel.y * " + way + ");\n}\n";
  }

  // To the centre of the first texel, which is where slices and nodes begin.
  void write_tile(std::size_t k) {
    const AtlasTable& table = layout_.tables[k];
    if (!layout_.cells.is_everything()) return write_kept_tile(k);
    const std::string x = number(table.x + 0.5);
    const std::string y = number(table.y + 0.5);
    const std::string width = number(std::size_t{table.tile_width});
    const std::string height = number(std::size_t{table.tile_height});
    text_ += "\n// Where a tile of the slices along axis " + std::to_string(table.along) +
             " begins [texels].\nvec2 sbrdf_tile_" + std::to_string(k) + "(float tile) {\n";
    if (table.tiles_per_row == 1) {
      text_ += "  return vec2(" + x + ", tile * " + height + " + " + y + ");\n}\n";
    } else if (table.tiles_per_row >= table.tile_count) {
      text_ += "  return vec2(tile * " + width + " + " + x + ", " + y + ");\n}\n";
    } else {
      text_ += "  float row = floor((tile + 0.5) * " + number(1.0 / table.tiles_per_row) +
               ");\n  return vec2((tile - row * " + number(std::size_t{table.tiles_per_row}) + ") * " + width + " + " +
               x + ", row * " + height + " + " + y + ");\n}\n";
    }
  }

  // Of tiles that are left out in part, where their first texel would lie; of those that are not there, anywhere.
  void write_kept_tile(std::size_t k) {
    std::vector<std::string> places;
    for (const AtlasTile& tile : layout_.tables[k].tiles) {
      places.push_back("vec2(" + number(tile.x + 0.5 - tile.first_column) + ", " +
                       number(tile.y + 0.5 - tile.first_row) + ")");
    }
    text_ += "\n// Where a tile of the slices along axis " + std::to_string(layout_.tables[k].along) +
             " begins [texels].\nvec2 sbrdf_tile_" + std::to_string(k) + "(float tile) {\n  const vec2 places[" +
             std::to_string(places.size()) + "] = " + list("vec2", places) + ";\n  return places[int(tile)];\n}\n";
  }

  // Of tables whose tiles have scales of their own.
  void write_scales(std::size_t k) {
    const std::vector<AtlasScale>& scales = atlas_.scales[k];
    if (scales.size() == 1) return;
    std::vector<std::string> offsets;
    std::vector<std::string> factors;
    for (const AtlasScale& scale : scales) {
      offsets.push_back(vec3(scale.offset));
      factors.push_back(vec3(scale.scale));
    }
    const std::string size = "[" + std::to_string(scales.size()) + "] = ";
    text_ += "\nvec3 sbrdf_scaled_" + std::to_string(k) + "(vec3 texel, float tile) {\n  const vec3 offsets" + size +
             list("vec3", offsets) + ";\n  const vec3 factors" + size + list("vec3", factors) +
             ";\n  return offsets[int(tile)] + factors[int(tile)] * texel;\n}\n";
  }

  void write_inverse() {
    const AtlasDomain& domain = atlas_.domain;
    text_ += "\n// f_r [1/sr] of v.\nvec3 sbrdf_inverse(vec3 v) {\n";
    if (domain.log) {
      text_ +=
          "  const vec3 at_zero = " + vec3(domain.at_zero) + ";\n  const vec3 at_floor = " + vec3(domain.at_floor) +
          ";\n  const vec3 floor_value = " + vec3(domain.floor) +
          ";\n  vec3 root = exp(0.5 * min(v, 160.0));\n  vec3 f = " + vec3(domain.reference) + " * root * root;\n" +
          "  if (any(lessThan(v, at_floor))) {\n    vec3 down = exp(0.5 * min(at_zero - 1.0 - v, 160.0));\n" +
          "    vec3 low = mix(-floor_value * down * down, floor_value * (v - at_zero), step(at_zero - 1.0, v));\n" +
          "    f = mix(low, f, step(at_floor, v));\n  }\n";
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
    if (!poles_.empty()) write_ring();
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
    for (const AtlasPole& pole : poles_) write_pole(pole);
    text_ += "  vec3 v = vec3(0.0);\n  vec4 sum;\n  vec3 texel;\n  vec2 at;\n  float tile;\n  float w;\n";
    for (std::size_t k = 0; k < layout_.tables.size(); ++k) write_sum(k);
    text_ += "  return sbrdf_inverse(v);\n}\n";
  }

  void write_ring() {
    const AtlasScale& scale = atlas_.scales.back().front();
    text_ +=
        "\nvec3 sbrdf_ring(vec3 texel) { return " + vec3(scale.offset) + " + " + vec3(scale.scale) + " * texel; }\n";
  }

  // Whether a pair lies in the cells at a pole, and where on the ring.
  void write_pole(const AtlasPole& pole) {
    const AtlasRing& ring = *layout_.ring;
    const std::string polar = std::to_string(pole.polar_axis);
    const std::string other = pole.ring_axis == kAxial ? "x.y" : "x.x";
    text_ += "  bool pole_" + polar + " = p" + polar + ".x == 0.0;\n  vec2 ring_" + polar + " = vec2(sbrdf_wrap(x." +
             "xyzw"[pole.ring_axis] + (pole.sign > 0 ? " + " : " - ") + other + ", " + number(ring.period_deg) +
             ") * " + number(ring.ring_texels / ring.period_deg) + " + " + number(ring.x + 0.5) + ", p" +
             std::to_string(pole.along) + ".z + " + number(ring.y + 0.5) + ");\n";
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
    const AtlasCells::Counts& counts = layout_.cells.counts();
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

  struct Corner {
    std::string tile, weight;
    const AtlasPole* ring = nullptr;  ///< read in place of the tile at this pole
  };

  // A ring stands for all tiles of its node, which count for nothing there: one of the primary's leaves its place to
  // it. Where two rings stand for one tile it is taken out twice.
  Corner corner_of(std::size_t k, unsigned bits) const {
    const AtlasTable& table = layout_.tables[k];
    const std::size_t count = table.between.size();
    Corner corner;
    std::string share;
    std::array<std::string, 2> nodes = {"0.0", "0.0"};
    for (std::size_t m = 0; m < count; ++m) {
      const std::string axis = std::to_string(table.between[m]);
      const bool far = ((bits >> m) & 1U) != 0;
      corner.weight += (m == 0 ? "" : " * ") + (far ? "p" + axis + ".y" : "(1.0 - p" + axis + ".y)");
      nodes[m] = far ? "(p" + axis + ".x + 1.0)" : "p" + axis + ".x";
      for (const AtlasPole& pole : poles_) {
        if (far || pole.polar_axis != table.between[m]) continue;
        share += " - float(pole_" + axis + ")";
        const bool others_far = (bits | (1U << m)) == (1U << count) - 1;
        if (k == 0 && others_far) corner.ring = &pole;
      }
    }
    if (corner.weight.empty()) corner.weight = "1.0";
    if (corner.ring == nullptr && !share.empty()) corner.weight += " * (1.0" + share + ")";
    if (table.triangular) {
      corner.tile = nodes[0] + " * (" + nodes[0] + " + 3.0) * 0.5 + " + nodes[1];
    } else if (count < 2) {
      corner.tile = nodes[0];
    } else {
      corner.tile = nodes[0] + " * " + number(step_count(layout_, table.between[1])) + " + " + nodes[1];
    }
    return corner;
  }

  void write_sum(std::size_t k) {
    const AtlasTable& table = layout_.tables[k];
    const std::string number_text = std::to_string(k);
    const std::string across = table.across ? "p" + std::to_string(*table.across) : "";
    const bool one_scale = atlas_.scales[k].size() == 1;
    const std::string add =
        one_scale ? "sum += w * vec4(texel, 1.0);\n" : "v += w * sbrdf_scaled_" + number_text + "(texel, tile);\n";
    text_ += "  // Slices along axis " + std::to_string(table.along) + ".\n  at = vec2(p" +
             std::to_string(table.along) + ".z, " +
             (table.across ? across + ".x + " + across + ".y" : std::string("0.0")) + ");\n";
    if (one_scale) text_ += "  sum = vec4(0.0);\n";
    for (unsigned bits = 0; bits < (1U << table.between.size()); ++bits) {
      const Corner corner = corner_of(k, bits);
      const std::string place = "at + sbrdf_tile_" + number_text + "(tile)";
      text_ += "  tile = " + corner.tile + ";\n  w = " + corner.weight + ";\n";
      if (corner.ring == nullptr) {
        text_ += "  texel = sbrdf_texel(" + place + ");\n  " + add;
        continue;
      }
      const std::string polar = std::to_string(corner.ring->polar_axis);
      text_ += "  texel = sbrdf_texel(pole_" + polar + " ? ring_" + polar + " : " + place + ");\n  if (pole_" + polar +
               ") {\n    v += (1.0 - p" + polar + ".y) * sbrdf_ring(texel);\n  } else {\n    " + add + "  }\n";
    }
    if (!one_scale) return;
    const AtlasScale& scale = atlas_.scales[k].front();
    text_ += "  v += " + vec3(scale.offset) + " * sum.w + " + vec3(scale.scale) + " * sum.rgb;\n";
  }

  const Atlas& atlas_;
  const AtlasLayout& layout_;
  std::vector<AtlasPole> poles_;
  std::string text_;
};

}  // namespace

std::string atlas_shader(const Atlas& atlas) { return Writer(atlas).write(); }

}  // namespace sbrdf::internal
