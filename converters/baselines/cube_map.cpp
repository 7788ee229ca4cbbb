#include "converters/baselines/cube_map.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "converters/baselines/scheme_samples.h"
#include "formats/core/half.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMostDirections = 256;
/// So near to the border of a texel [texels] a direction belongs to both sides: which one a driver reads is rounding.
constexpr double kBorder = 1e-3;
/// Nobody asks below the horizon, but texels across it have directions there.
constexpr double kLowest = -0.01;

/// The vectors along columns and rows of a face, and to its middle.
struct Face {
  glm::dvec3 columns, rows, middle;
};
const std::array<Face, BarycentricCube::kFaces> kCube = {{{{0, 0, -1}, {0, -1, 0}, {1, 0, 0}},
                                                          {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
                                                          {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                                          {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                                          {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                                                          {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}};

glm::dvec3 direction_of(std::size_t face, double column, double row, std::size_t side) {
  const double half = static_cast<double>(side) / 2;
  return glm::normalize(kCube[face].middle + (column / half - 1) * kCube[face].columns +
                        (row / half - 1) * kCube[face].rows);
}

std::size_t number_of(std::size_t face, std::size_t column, std::size_t row) {
  return (face * BarycentricCube::kFaceSide + row) * BarycentricCube::kFaceSide + column;
}

BarycentricCube::Texel texel_for(const Triangulation& triangulation, const glm::dvec3& w) {
  BarycentricCube::Texel texel;
  const Place place = triangulation.place_of(w);
  for (std::size_t k = 0; k < 3; ++k) {
    texel.vertices[k] = static_cast<std::uint8_t>(place.triangle[k]);
    texel.weights[k] = half_from_float(static_cast<float>(place.weights[k]));
  }
  return texel;
}

// The texels that hold a sampled direction have it whole, so that its value comes back.
void keep_directions(std::span<const glm::dvec3> directions, BarycentricCube& cube) {
  constexpr std::size_t kSide = BarycentricCube::kFaceSide;
  for (std::size_t number = 0; number < directions.size(); ++number) {
    const CubePlace place = cube_place(directions[number], kSide);
    for (const double x : {std::max(place.at.x - kBorder, 0.0), place.at.x + kBorder}) {
      for (const double y : {std::max(place.at.y - kBorder, 0.0), place.at.y + kBorder}) {
        const auto column = static_cast<std::size_t>(x);
        const auto row = static_cast<std::size_t>(y);
        if (column >= kSide || row >= kSide) continue;
        const auto same = static_cast<std::uint8_t>(number);
        cube.texels[number_of(place.face, column, row)] = {{same, same, same}, {half_from_float(1), 0, 0}};
      }
    }
  }
}

}  // namespace

CubePlace cube_place(const glm::dvec3& w, std::size_t side) {
  const glm::dvec3 size = glm::abs(w);
  std::size_t axis = 2;
  if (size.x >= size.y && size.x >= size.z) {
    axis = 0;
  } else if (size.y >= size.z) {
    axis = 1;
  }
  const auto number = static_cast<glm::length_t>(axis);
  const std::size_t face = 2 * axis + (w[number] < 0 ? 1 : 0);
  const double half = static_cast<double>(side) / 2;
  return {face,
          half * (glm::dvec2(glm::dot(w, kCube[face].columns), glm::dot(w, kCube[face].rows)) / size[number] + 1.0)};
}

Result<BarycentricCube> BarycentricCube::make(const UniformScheme& scheme) {
  const std::vector<glm::dvec3> directions = scheme_directions(scheme);
  if (directions.size() > kMostDirections) {
    return unsupported("a cube map numbers directions in 8 bits; this scheme has " + std::to_string(directions.size()));
  }
  const Result<Triangulation> triangulation = Triangulation::make(scheme);
  if (!triangulation) return triangulation.error();
  BarycentricCube cube;
  cube.texels.resize(kFaces * kFaceSide * kFaceSide);
  for (std::size_t face = 0; face < kFaces; ++face) {
    for (std::size_t row = 0; row < kFaceSide; ++row) {
      for (std::size_t column = 0; column < kFaceSide; ++column) {
        const glm::dvec3 w =
            direction_of(face, static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5, kFaceSide);
        if (w.z >= kLowest) cube.texels[number_of(face, column, row)] = texel_for(*triangulation, w);
      }
    }
  }
  keep_directions(directions, cube);
  return cube;
}

const BarycentricCube::Texel& BarycentricCube::at(const glm::dvec3& w) const {
  const CubePlace place = cube_place(w, kFaceSide);
  const auto within = [](double x) { return std::min(static_cast<std::size_t>(x), kFaceSide - 1); };
  return texels[number_of(place.face, within(place.at.x), within(place.at.y))];
}

}  // namespace sbrdf::internal
