#include "codec/frame/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"

namespace sbrdf::internal {
namespace {

Lattice lattice_of(double elevation_step, double azimuth_step, const Symmetries& symmetries = {}) {
  return build_lattice(elevation_frame(elevation_step, azimuth_step, symmetries).value()).value();
}

/// Every kind of symmetry on an even placement, and lists of their own with different counts of the two slices.
std::vector<std::pair<std::string, FrameSpec>> various_frames() {
  std::vector<std::pair<std::string, FrameSpec>> frames;
  for (int bits = 0; bits < 8; ++bits) {
    const Symmetries symmetries = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    frames.emplace_back("symmetries " + std::to_string(bits), elevation_frame(40, 60, symmetries).value());
  }
  frames.emplace_back("odd", elevation_frame(40, 72, {}).value());
  frames.emplace_back("own lists", elevation_frame_from_nodes({0, 11, 35, 80}, {0, 50, 200}, {0, 30, 180, 330}, {}));
  frames.emplace_back("own lists without the pole's opposite",
                      elevation_frame_from_nodes({0, 11, 80}, {0, 50, 200}, {0, 30, 100, 260, 330}, {}));
  // Within reach of the horizon, where every coordinate is a direction pair of its own.
  for (int bits = 0; bits < 8; ++bits) {
    const Symmetries symmetries = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    const std::vector<double> phi_h = symmetries.isotropic ? std::vector{0.0} : std::vector{0.0, 90.0, 180.0, 270.0};
    frames.emplace_back("half/difference, symmetries " + std::to_string(bits),
                        half_difference_frame({0, 12, 40}, {0, 25, 40}, phi_h, {0, 60, 90, 120}, symmetries));
  }
  frames.emplace_back("half/difference, own lists",
                      half_difference_frame({0, 3, 30}, {0, 25, 50}, {0, 20, 190}, {0, 70, 100}, {}));
  frames.emplace_back("own lists, isotropic",
                      elevation_frame_from_nodes({0, 11, 80}, {0}, {0, 5, 180, 355}, {.isotropic = true}));
  return frames;
}

void for_each_padded_point(const Lattice& lattice, std::size_t left_out,
                           const std::function<void(const std::array<std::size_t, kAxisCount>&)>& visit) {
  std::array<std::size_t, kAxisCount> count{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) count[axis] = axis == left_out ? 1 : lattice.nodes[axis].size();
  std::array<std::size_t, kAxisCount> k{};
  for (k[3] = 0; k[3] < count[3]; ++k[3])
    for (k[2] = 0; k[2] < count[2]; ++k[2])
      for (k[1] = 0; k[1] < count[1]; ++k[1])
        for (k[0] = 0; k[0] < count[0]; ++k[0]) visit(k);
}

std::size_t index_of(const Strides& strides, const std::array<std::size_t, kAxisCount>& k) {
  std::size_t index = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) index += k[axis] * strides[axis];
  return index;
}

Coordinates coordinates_at(const Lattice& lattice, const std::array<std::size_t, kAxisCount>& k) {
  Coordinates x{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = lattice.nodes[axis][k[axis]];
  return x;
}

double value_at(const Lattice& lattice, const Coordinates& x) {
  return analytic_brdf(directions_at(lattice.spec, x), lattice.spec.symmetries);
}

std::uint64_t crossing_formula(std::uint64_t a, std::uint64_t e) {
  const bool opposite = a % 2 == 0;
  const std::uint64_t pairs = (a - 1 - (opposite ? 1 : 0)) / 2;
  const std::uint64_t q = 2 * a + (opposite ? a : 0) + 2 * a * pairs;
  return 1 + 2 * a * e + a * a * e * (e - 1) + e * q;
}

TEST(Crossings, AreAsManyAsKnownForEveryPlacementOfThePaper) {
  struct Row {
    double elevation_step, azimuth_step;
    std::size_t count;
  };
  constexpr std::array rows = {
      Row{28, 180, 55},  Row{20, 180, 89},   Row{16, 180, 131},  Row{28, 60, 379},   Row{20, 60, 649},
      Row{16, 60, 991},  Row{14, 60, 1405},  Row{16, 36, 2651},  Row{14, 36, 3781},  Row{12, 36, 5111},
      Row{10, 36, 6641}, Row{8, 36, 10301},  Row{12, 20, 16255}, Row{10, 20, 21169}, Row{8, 20, 32941},
      Row{6, 20, 64261}, Row{6, 12, 177661},
  };
  for (const auto& [elevation_step, azimuth_step, count] : rows) {
    EXPECT_EQ(lattice_of(elevation_step, azimuth_step).crossings.size(), count)
        << elevation_step << "/" << azimuth_step;
  }
}

TEST(Crossings, AreAsManyAsTheClosedFormulaSaysForOtherSteps) {
  for (const double azimuth_step : {30.0, 40.0, 45.0, 72.0, 90.0, 120.0, 360.0 / 7}) {
    for (const double elevation_step : {25.0, 40.0, 80.0}) {
      const Lattice lattice = lattice_of(elevation_step, azimuth_step);
      const auto a = static_cast<std::uint64_t>(std::lround(360 / azimuth_step));
      const auto e = static_cast<std::uint64_t>(std::ceil(80 / elevation_step));
      EXPECT_EQ(lattice.crossings.size(), crossing_formula(a, e)) << elevation_step << "/" << azimuth_step;
    }
  }
}

/// The direction pairs of all lattice points that differ in more than a symmetry, counted by their vectors.
std::size_t count_by_vectors(const Lattice& lattice) {
  using Rounded = std::array<std::int64_t, 6>;
  std::set<Rounded> seen;
  const Symmetries& symmetries = lattice.spec.symmetries;
  for_each_padded_point(lattice, kAxisCount, [&](const auto& k) {
    const DirectionPair pair = directions_at(lattice.spec, coordinates_at(lattice, k));
    Rounded least{};
    bool first = true;
    for (int bits = 0; bits < 8; ++bits) {
      DirectionPair image = (bits & 1) != 0 ? DirectionPair{pair.v, pair.i} : pair;
      if (((bits & 2) != 0 && !symmetries.mirror_x) || ((bits & 4) != 0 && !symmetries.mirror_y)) continue;
      for (Direction* direction : {&image.i, &image.v}) {
        if ((bits & 2) != 0) direction->phi = -direction->phi;
        if ((bits & 4) != 0) direction->phi = kPi - direction->phi;
      }
      if (symmetries.isotropic) {
        const double turn = image.i.theta > kPole ? image.i.phi : image.v.phi;
        image.i.phi -= turn;
        image.v.phi -= turn;
      }
      const auto [ix, iy, iz, vx, vy, vz] = vectors_of(image);
      Rounded rounded{};
      const std::array components = {ix, iy, iz, vx, vy, vz};
      for (std::size_t c = 0; c < 6; ++c) rounded[c] = std::llround(components[c] * 1e7);
      least = first ? rounded : std::min(least, rounded);
      first = false;
    }
    seen.insert(least);
  });
  return seen.size();
}

TEST(Crossings, AreAsManyAsDistinctDirectionPairsForEverySymmetry) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    EXPECT_EQ(lattice.crossings.size(), count_by_vectors(lattice));
  }
}

TEST(Crossings, StandForTheSameMeasurementAsEachOfTheirCorners) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    for_each_padded_point(lattice, kAxisCount, [&](const auto& k) {
      const Coordinates x = coordinates_at(lattice, k);
      const Coordinates& stored = lattice.crossings[lattice.corners[index_of(lattice.corner_strides, k)]];
      EXPECT_NEAR(value_at(lattice, stored) / value_at(lattice, x), 1, 1e-12)
          << testing::PrintToString(x) << " from " << testing::PrintToString(stored);
    });
  }
}

TEST(Crossings, AreNumberedAsTheyAreFirstMetWithAxis0Fastest) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    std::uint32_t next = 0;
    for_each_padded_point(lattice, kAxisCount, [&](const auto& k) {
      const std::uint32_t crossing = lattice.corners[index_of(lattice.corner_strides, k)];
      ASSERT_LE(crossing, next);
      next = std::max(next, crossing + 1);
    });
    EXPECT_EQ(next, lattice.crossings.size());
  }
}

TEST(Slices, GiveEveryLineOfTheLatticeItsValues) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const double extent = lattice.nodes[axis].back();
      if (lattice.nodes[axis].size() == 1) continue;
      for_each_padded_point(lattice, axis, [&](const auto& k) {
        const LineReference& reference = lattice.lines[axis][index_of(lattice.line_strides[axis], k)];
        Coordinates x = coordinates_at(lattice, k);
        for (int step = 0; step <= 11; ++step) {
          x[axis] = extent * step / 11;
          Coordinates stored{};
          if (reference.is_constant()) {
            stored = lattice.crossings[reference.crossing()];
          } else {
            const Slice& slice = lattice.slices[reference.target];
            const double position = fold(slice, reference.sign * x[axis] + reference.offset_deg);
            ASSERT_GE(position, slice.start_deg);
            ASSERT_LE(position, slice.start_deg + slice.length_deg);
            stored = coordinates_on(slice, position);
          }
          ASSERT_NEAR(value_at(lattice, stored) / value_at(lattice, x), 1, 1e-12)
              << "axis " << axis << ", " << testing::PrintToString(x) << " from " << testing::PrintToString(stored);
        }
      });
    }
  }
}

TEST(Slices, AreAsManyOfEachKindAsThePaperSays) {
  for (const double azimuth_step : {36.0, 60.0, 72.0, 120.0, 180.0}) {
    const Lattice lattice = lattice_of(28, azimuth_step);
    const auto a = static_cast<std::int64_t>(std::lround(360 / azimuth_step));
    constexpr std::int64_t e = 3;
    const bool opposite = a % 2 == 0;
    // In a subspace of equal elevations the axial slices of u and -u are the same.
    const std::int64_t axial_of_equal = 1 + (opposite ? 1 : 0) + (a - 1 - (opposite ? 1 : 0)) / 2;
    const auto count = [&](SliceKind kind) {
      return std::count_if(lattice.slices.begin(), lattice.slices.end(),
                           [&](const Slice& slice) { return slice.kind == kind; });
    };
    EXPECT_EQ(count(kAxial), e + a * e * (e - 1) / 2 + e * axial_of_equal);
    EXPECT_EQ(count(kDiagonal), a * e * (e - 1) / 2 + e * a);
    EXPECT_EQ(count(kHorizontal), 2 * a + e * 2 * a * a);
    EXPECT_EQ(count(kVertical), 0);
  }
}

TEST(Slices, ArePassedByTheirNodesInOrderFromTheStart) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    std::uint32_t begin = 0;
    for (const Slice& slice : lattice.slices) {
      ASSERT_EQ(slice.node_begin, begin);
      begin += slice.node_count;
      const auto nodes = lattice.nodes_of(slice);
      EXPECT_NEAR(nodes.front().position_deg, slice.start_deg, 1e-9);
      if (slice.boundary != Boundary::kPeriodic) {
        EXPECT_NEAR(nodes.back().position_deg, slice.start_deg + slice.length_deg, 1e-9);
      }
      EXPECT_EQ(slice.interval_count(), nodes.size() - (slice.boundary == Boundary::kPeriodic ? 0 : 1));
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        EXPECT_TRUE(k == 0 || nodes[k].position_deg > nodes[k - 1].position_deg);
        EXPECT_LE(nodes[k].position_deg, slice.start_deg + slice.length_deg);
        const Coordinates x = coordinates_on(slice, nodes[k].position_deg);
        EXPECT_NEAR(value_at(lattice, lattice.crossings[nodes[k].crossing]) / value_at(lattice, x), 1, 1e-12);
      }
    }
    EXPECT_EQ(begin, lattice.slice_nodes.size());
  }
}

TEST(Slices, AreNumberedAsTheyAreFirstMetLinesOfAxis0First) {
  for (const auto& [name, spec] : various_frames()) {
    const Lattice lattice = build_lattice(spec).value();
    std::uint32_t next = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      for (const LineReference& reference : lattice.lines[axis]) {
        if (reference.is_constant()) continue;
        ASSERT_LE(reference.target, next) << name;
        next = std::max(next, reference.target + 1);
      }
    }
    EXPECT_EQ(next, lattice.slices.size());
  }
}

/// Kind, boundary, start, length, and (position, crossing) of each node.
struct ExpectedSlice {
  SliceKind kind;
  Boundary boundary;
  double start_deg, length_deg;
  std::vector<std::pair<double, std::uint32_t>> nodes;
};

void expect_lattice(const Lattice& lattice, const std::vector<Coordinates>& crossings,
                    const std::vector<ExpectedSlice>& slices) {
  EXPECT_EQ(lattice.crossings, crossings);
  ASSERT_EQ(lattice.slices.size(), slices.size());
  for (std::size_t k = 0; k < slices.size(); ++k) {
    SCOPED_TRACE("slice " + std::to_string(k));
    const Slice& slice = lattice.slices[k];
    EXPECT_EQ(slice.kind, slices[k].kind);
    EXPECT_EQ(slice.boundary, slices[k].boundary);
    EXPECT_EQ(slice.start_deg, slices[k].start_deg);
    EXPECT_EQ(slice.length_deg, slices[k].length_deg);
    std::vector<std::pair<double, std::uint32_t>> nodes;
    for (const SliceNode& node : lattice.nodes_of(slice)) nodes.emplace_back(node.position_deg, node.crossing);
    EXPECT_EQ(nodes, slices[k].nodes);
  }
}

// Both lists come from another implementation of specs/sbrdf.md; files depend on them.
TEST(Numbering, IsThatOfTheFormatForAnAnisotropicMaterial) {
  expect_lattice(lattice_of(80, 180),
                 {{0, 0, 0, 0},
                  {0, 0, 80, 0},
                  {180, 0, 80, 0},
                  {360, 0, 80, 0},
                  {540, 0, 80, 0},
                  {0, 0, 80, 80},
                  {180, 0, 80, 80},
                  {360, 0, 80, 80},
                  {540, 0, 80, 80},
                  {0, 180, 80, 80},
                  {180, 180, 80, 80}},
                 {{kAxial, Boundary::kPeriodic, 0, 720, {{0, 1}, {180, 2}, {360, 3}, {540, 4}}},
                  {kAxial, Boundary::kPeriodic, 0, 720, {{0, 5}, {180, 6}, {360, 7}, {540, 8}}},
                  {kAxial, Boundary::kPeriodic, 0, 360, {{0, 9}, {180, 10}}},
                  {kDiagonal, Boundary::kMirrored, 0, 360, {{0, 5}, {180, 9}, {360, 7}}},
                  {kDiagonal, Boundary::kMirrored, 0, 360, {{0, 6}, {180, 10}, {360, 8}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 0}, {80, 1}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 0}, {80, 2}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 0}, {80, 3}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 0}, {80, 4}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 1}, {80, 5}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 2}, {80, 6}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 3}, {80, 7}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 4}, {80, 8}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 2}, {80, 9}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 3}, {80, 10}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 4}, {80, 9}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 1}, {80, 10}}}});
}

TEST(Numbering, IsThatOfTheFormatForAnIsotropicMaterial) {
  expect_lattice(lattice_of(40, 180, {.isotropic = true}),
                 {{0, 0, 0, 0},
                  {0, 0, 40, 0},
                  {0, 0, 80, 0},
                  {0, 0, 40, 40},
                  {0, 180, 40, 40},
                  {0, 0, 80, 40},
                  {0, 180, 80, 40},
                  {0, 0, 80, 80},
                  {0, 180, 80, 80}},
                 {{kDiagonal, Boundary::kMirrored, 0, 180, {{0, 3}, {180, 4}}},
                  {kDiagonal, Boundary::kPeriodic, 0, 360, {{0, 5}, {180, 6}}},
                  {kDiagonal, Boundary::kMirrored, 0, 180, {{0, 7}, {180, 8}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 0}, {40, 1}, {80, 2}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 1}, {40, 3}, {80, 5}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 1}, {40, 4}, {80, 6}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 2}, {40, 5}, {80, 7}}},
                  {kHorizontal, Boundary::kBounded, 0, 80, {{0, 2}, {40, 6}, {80, 8}}}});
}

TEST(Slices, RepeatAfterTheirPeriodAndMirrorAtTheirEnds) {
  for (const auto& [name, spec] : various_frames()) {
    SCOPED_TRACE(name);
    const Lattice lattice = build_lattice(spec).value();
    for (const Slice& slice : lattice.slices) {
      for (double inside = 1.5; inside < slice.length_deg; inside += 47) {
        const auto value = [&](double from_start) {
          return value_at(lattice, coordinates_on(slice, slice.start_deg + from_start));
        };
        if (slice.boundary == Boundary::kPeriodic) {
          EXPECT_NEAR(value(inside + slice.length_deg) / value(inside), 1, 1e-12);
        } else if (slice.boundary == Boundary::kMirrored) {
          EXPECT_NEAR(value(-inside) / value(inside), 1, 1e-12);
          EXPECT_NEAR(value(2 * slice.length_deg - inside) / value(inside), 1, 1e-12);
        }
      }
    }
  }
}

TEST(Slices, AreMeasuredInDegreesOfThePapersParameter) {
  for (const Slice& slice : lattice_of(40, 60).slices) EXPECT_EQ(slice.gap_scale, slice.kind <= kDiagonal ? 0.5 : 1.0);
}

TEST(PaddedNodes, CloseTheTurnOfEachAzimuth) {
  const Lattice lattice = build_lattice(elevation_frame_from_nodes({0, 80}, {0, 50, 200}, {0, 30, 330}, {})).value();
  EXPECT_EQ(lattice.nodes[kAxial], (std::vector<double>{0, 50, 200, 360, 410, 560, 720}));
  EXPECT_EQ(lattice.nodes[kDiagonal], (std::vector<double>{0, 30, 330, 360}));
  EXPECT_EQ(lattice.nodes[kHorizontal], (std::vector<double>{0, 80}));
}

TEST(BuildLattice, StoresNoSliceAlongTheSumForAnIsotropicMaterial) {
  const Lattice lattice = lattice_of(14, 36, {.isotropic = true});
  for (const Slice& slice : lattice.slices) EXPECT_NE(slice.kind, kAxial);
  EXPECT_TRUE(lattice.lines[kAxial].empty());
}

TEST(BuildLattice, RefusesSymmetriesWhoseMirrorPlanesHoldNoNode) {
  for (const double azimuth_step : {40.0, 72.0, 120.0}) {
    const auto lattice = build_lattice(elevation_frame(40, azimuth_step, {.isotropic = true}).value());
    ASSERT_FALSE(lattice);
    EXPECT_EQ(lattice.error().code, ErrorCode::kUnsupported);
  }
  EXPECT_FALSE(build_lattice(elevation_frame(40, 72, {.mirror_y = true}).value()));
}

TEST(BuildLattice, RefusesMoreThanFourMillionPoints) {
  const auto lattice = build_lattice(elevation_frame(1, 2, {}).value());
  ASSERT_FALSE(lattice);
  EXPECT_EQ(lattice.error().code, ErrorCode::kUnsupported);
}

TEST(BuildLattice, RefusesWhatCheckFrameRefuses) {
  EXPECT_FALSE(build_lattice(elevation_frame_from_nodes({0, 80}, {0, 90}, {5, 90}, {})));
}

TEST(Fold, IsTheTriangleWaveOfAMirroredSliceTheSawtoothOfAPeriodicOneAndTheClampOfABoundedOne) {
  Slice slice;
  slice.start_deg = 180;
  slice.length_deg = 90;
  for (int k = -1000; k <= 1000; ++k) {
    const double position = k * 0.75;
    slice.boundary = Boundary::kMirrored;
    EXPECT_NEAR(fold(slice, position), 180 + std::abs(std::remainder(position - 180, 180.0)), 1e-9);
    slice.boundary = Boundary::kPeriodic;
    const double sawtooth = std::fmod(std::fmod(position, 90) + 90, 90);
    EXPECT_NEAR(fold(slice, position), 180 + sawtooth, 1e-9);
    slice.boundary = Boundary::kBounded;
    EXPECT_EQ(fold(slice, position), std::max(180.0, std::min(270.0, position)));
  }
}

}  // namespace
}  // namespace sbrdf::internal
