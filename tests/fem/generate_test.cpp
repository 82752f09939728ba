// SPDX-License-Identifier: Apache-2.0
// Generated meshes: topology, exact symmetry, exact volumes of the true bodies, quality; lines of nodes.
#include "fem/generate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "core/error.hpp"
#include "fem/hex8.hpp"

namespace {

using core::Symmetry;
using core::Vec3;
using fem::HexMesh;
using Point = std::array<double, 3>;

Point point(const Vec3& x) { return {x[0], x[1], x[2]}; }

std::set<Point> points(const HexMesh& mesh) {
  std::set<Point> s;
  for (const Vec3& x : mesh.x) s.insert(point(x));
  return s;
}

/// An element as the set of its corners, so that meshes can be compared whatever their order.
std::set<std::set<Point>> hexes(const HexMesh& mesh) {
  std::set<std::set<Point>> s;
  for (const auto& node : mesh.node) {
    std::set<Point> corners;
    for (const auto nd : node) corners.insert(point(mesh.x[static_cast<std::size_t>(nd)]));
    s.insert(corners);
  }
  return s;
}

HexMesh mirrored(HexMesh mesh, int axis) {
  for (Vec3& x : mesh.x) x[axis] = x[axis] == 0 ? 0.0 : -x[axis];
  return mesh;
}

fem::Corners<double> corners(const HexMesh& mesh, std::size_t el) {
  fem::Corners<double> x;
  for (std::size_t a = 0; a < 8; ++a)
    for (int d = 0; d < 3; ++d) x.c[a][d] = mesh.x[static_cast<std::size_t>(mesh.node[el][a])][d];
  return x;
}

double smallest_det_j(const HexMesh& mesh) {
  double low = 1e300;
  for (std::size_t el = 0; el < mesh.node.size(); ++el)
    low = std::min(low, fem::smallest_corner_jacobian(fem::edges(corners(mesh, el))));
  return low;
}

using Face = std::array<std::int32_t, 4>;

/// Faces of one element only, outward; expects every other one to be shared by exactly two elements.
std::vector<Face> boundary_faces(const HexMesh& mesh) {
  std::map<std::set<std::int32_t>, std::vector<Face>> faces;
  for (const auto& node : mesh.node)
    for (const auto& f : fem::face_corner) {
      Face face;
      for (std::size_t k = 0; k < 4; ++k) face[k] = node[static_cast<std::size_t>(f[k])];
      faces[std::set<std::int32_t>(face.begin(), face.end())].push_back(face);
    }
  std::vector<Face> boundary;
  for (const auto& [key, list] : faces) {
    EXPECT_EQ(key.size(), 4u);
    EXPECT_LE(list.size(), 2u);
    if (list.size() == 1) boundary.push_back(list[0]);
  }
  return boundary;
}

/// A closed oriented surface of one piece of genus 0: every edge is run through once in each direction, V - E + F = 2.
void expect_closed_sphere(const std::vector<Face>& faces) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed;
  std::set<std::int32_t> nodes;
  for (const Face& f : faces)
    for (std::size_t k = 0; k < 4; ++k) {
      ++directed[{f[k], f[(k + 1) % 4]}];
      nodes.insert(f[k]);
    }
  for (const auto& [edge, n] : directed) {
    EXPECT_EQ(n, 1);
    EXPECT_EQ(directed.count({edge.second, edge.first}), 1u);
  }
  const long v = static_cast<long>(nodes.size()), e = static_cast<long>(directed.size() / 2);
  EXPECT_EQ(v - e + static_cast<long>(faces.size()), 2);
}

void expect_sound(const HexMesh& mesh) {
  expect_closed_sphere(boundary_faces(mesh));
  EXPECT_EQ(points(mesh).size(), mesh.x.size()) << "two nodes at one place";
  std::set<std::int32_t> used;
  for (const auto& node : mesh.node) used.insert(node.begin(), node.end());
  EXPECT_EQ(used.size(), mesh.x.size()) << "nodes without an element";
  EXPECT_GT(smallest_det_j(mesh), 0);
}

bool same_bits(const HexMesh& a, const HexMesh& b) {
  return a.x.size() == b.x.size() && a.node == b.node &&
         std::equal(a.x.begin(), a.x.end(), b.x.begin(),
                    [](const Vec3& p, const Vec3& q) { return std::memcmp(p.data(), q.data(), sizeof p) == 0; });
}

const std::vector<Symmetry> all_symmetries = {{{false, false, false}}, {{true, false, false}}, {{false, true, false}},
                                              {{false, false, true}},  {{true, true, false}},  {{true, false, true}},
                                              {{false, true, true}},   {{true, true, true}}};

/// The kept part is the full mesh's elements on the positive side, bit for bit, and its copies make up the whole.
void expect_part_of(const HexMesh& part, const HexMesh& full, const Symmetry& keep) {
  EXPECT_EQ(part.node.size() * static_cast<std::size_t>(keep.copies()), full.node.size());
  HexMesh positive;
  positive.x = full.x;
  for (const auto& node : full.node) {
    const bool kept = std::all_of(node.begin(), node.end(), [&](std::int32_t nd) {
      for (std::size_t d = 0; d < 3; ++d)
        if (keep.plane[d] && full.x[static_cast<std::size_t>(nd)][static_cast<int>(d)] < 0) return false;
      return true;
    });
    if (kept) positive.node.push_back(node);
  }
  EXPECT_EQ(hexes(part), hexes(positive));
  const double volume = fem::quality(full).volume;
  EXPECT_NEAR(fem::quality(part).volume * keep.copies(), volume, 1e-13 * volume);  // sums of some 1e3 positive terms
}

/// Order of convergence of the volume to the true one between two meshes, the finer of twice the elements across.
double volume_order(double coarse, double fine, double exact) { return std::log2((exact - coarse) / (exact - fine)); }

TEST(Sphere, IsOneClosedBodyOfPositiveElements) {
  for (int n = 4; n <= 48; n += n < 20 ? 2 : 14) {
    SCOPED_TRACE(n);
    expect_sound(fem::sphere(1.0, n));
  }
}

TEST(Sphere, EveryCornerJacobianIsPositiveForAllSizes) {
  for (int n = 4; n <= 48; n += 2) EXPECT_GT(smallest_det_j(fem::sphere(0.004, n)), 0) << n;
}

TEST(Sphere, HasElementsAcrossTheDiameterRoundedUpToEven) {
  for (const int n : {4, 8, 9, 10, 19, 20}) {
    const HexMesh mesh = fem::sphere(2.0, n);
    const auto on_axis =
        std::count_if(mesh.x.begin(), mesh.x.end(), [](const Vec3& x) { return x[0] == 0 && x[1] == 0; });
    EXPECT_EQ(on_axis, n + n % 2 + 1) << n;
  }
}

TEST(Sphere, SurfaceNodesLieOnTheSphere) {
  for (const int n : {4, 10, 24}) {
    const HexMesh mesh = fem::sphere(2.0, n);
    for (const Face& f : boundary_faces(mesh))
      for (const auto nd : f)  // a few roundings of numbers near 1
        EXPECT_NEAR(mesh.x[static_cast<std::size_t>(nd)].norm(), 1.0, 5e-16);
  }
}

TEST(Sphere, VolumeConvergesToTheTrueOneAtSecondOrder) {
  const double exact = core::pi / 6;
  const double v8 = fem::quality(fem::sphere(1, 8)).volume, v16 = fem::quality(fem::sphere(1, 16)).volume,
               v32 = fem::quality(fem::sphere(1, 32)).volume;
  EXPECT_LT(v32, exact);
  EXPECT_NEAR(v32, exact, 0.005 * exact);
  EXPECT_NEAR(volume_order(v8, v16, exact), 2.0, 0.1);
  EXPECT_NEAR(volume_order(v16, v32, exact), 2.0, 0.03);
}

TEST(Sphere, IsItsOwnMirrorImageBitByBit) {
  for (const int n : {4, 6, 10, 16}) {
    const HexMesh mesh = fem::sphere(0.0043, n);
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(points(mirrored(mesh, d)), points(mesh)) << n << " axis " << d;
      EXPECT_EQ(hexes(mirrored(mesh, d)), hexes(mesh)) << n << " axis " << d;
    }
  }
}

TEST(Sphere, NodesOnTheSymmetryPlanesAreExactlyThere) {
  const HexMesh quarter = fem::sphere(0.0043, 12, {{true, true, false}});
  for (const Vec3& x : quarter.x)
    for (int d = 0; d < 2; ++d) EXPECT_TRUE((x[d] == 0 && !std::signbit(x[d])) || x[d] > 1e-5) << x.transpose();
}

TEST(Sphere, PartsAreTheFullMeshCutAtItsPlanes) {
  for (const int n : {6, 8}) {
    const HexMesh full = fem::sphere(1.3, n);
    for (const Symmetry& keep : all_symmetries) {
      const HexMesh part = fem::sphere(1.3, n, keep);
      expect_part_of(part, full, keep);
      expect_sound(part);
    }
  }
}

TEST(Sphere, FourQuartersHaveTheNodesOfTheFull) {
  const HexMesh full = fem::sphere(1.3, 10), quarter = fem::sphere(1.3, 10, {{true, true, false}});
  std::set<Point> all = points(quarter);
  all.merge(points(mirrored(quarter, 0)));
  all.merge(points(mirrored(quarter, 1)));
  all.merge(points(mirrored(mirrored(quarter, 0), 1)));
  EXPECT_EQ(all, points(full));
}

TEST(Sphere, QualityIsAsStated) {
  for (const int n : {8, 10, 16, 20, 24, 32, 48}) {
    const fem::MeshQuality q = fem::quality(fem::sphere(1.0, n, {{true, true, true}}));
    EXPECT_GT(q.shortest_edge * n, 0.68) << n;
    EXPECT_GT(q.smallest_angle, 1.0) << n;
    EXPECT_LT(q.jacobian_ratio, n < 10 ? 2.9 : n < 16 ? 2.2 : n < 20 ? 1.9 : n < 24 ? 1.7 : 1.6) << n;
  }
}

TEST(Sphere, SameArgumentsGiveTheSameBits) { EXPECT_TRUE(same_bits(fem::sphere(1, 14), fem::sphere(1, 14))); }

TEST(Sphere, NeighboursLieCloseInMemory) {
  const HexMesh mesh = fem::sphere(1, 24);
  double mean = 0;
  for (const auto& node : mesh.node) {
    const auto [low, high] = std::minmax_element(node.begin(), node.end());
    mean += (*high - *low) / static_cast<double>(mesh.node.size());
  }
  EXPECT_LT(mean, 0.15 * static_cast<double>(mesh.x.size()));
}

TEST(Cylinder, IsOneClosedBodyOfPositiveElements) {
  for (const int n : {4, 5, 6, 8, 10, 14, 20}) {
    SCOPED_TRACE(n);
    expect_sound(fem::cylinder(1.0, 0.7, n, 3));
  }
}

TEST(Cylinder, EveryCornerJacobianIsPositiveForAllSizes) {
  for (int n = 4; n <= 48; n += 2) EXPECT_GT(smallest_det_j(fem::cylinder(1.0, 1.0, n, 1)), 0) << n;
}

TEST(Cylinder, SurfaceNodesLieOnTheCylinder) {
  const HexMesh mesh = fem::cylinder(2.0, 3.0, 12, 5);
  for (const Face& f : boundary_faces(mesh)) {
    const bool end = std::all_of(
        f.begin(), f.end(), [&](std::int32_t nd) { return std::abs(mesh.x[static_cast<std::size_t>(nd)][2]) == 1.5; });
    if (end) continue;
    for (const auto nd : f) EXPECT_NEAR(mesh.x[static_cast<std::size_t>(nd)].head<2>().norm(), 1.0, 5e-16);
  }
}

TEST(Cylinder, VolumeConvergesToTheTrueOneAtSecondOrder) {
  const double exact = core::pi / 4 * 0.5;
  const auto volume = [](int n) { return fem::quality(fem::cylinder(1, 0.5, n, 2)).volume; };
  EXPECT_NEAR(volume(32), exact, 0.002 * exact);
  EXPECT_NEAR(volume_order(volume(8), volume(16), exact), 2.0, 0.1);
  EXPECT_NEAR(volume_order(volume(16), volume(32), exact), 2.0, 0.03);
}

TEST(Cylinder, IsItsOwnMirrorImageBitByBit) {
  for (const int n_along : {3, 4}) {
    const HexMesh mesh = fem::cylinder(0.0037, 0.0113, 10, n_along);
    for (int d = 0; d < 3; ++d) EXPECT_EQ(hexes(mirrored(mesh, d)), hexes(mesh)) << n_along << " axis " << d;
  }
}

TEST(Cylinder, PartsAreTheFullMeshCutAtItsPlanes) {
  const HexMesh full = fem::cylinder(1.3, 2.1, 10, 6);
  for (const Symmetry& keep : all_symmetries) expect_part_of(fem::cylinder(1.3, 2.1, 10, 6, keep), full, keep);
  EXPECT_EQ(fem::cylinder(1, 1, 8, 5, {{false, false, true}}).node.size() * 2, fem::cylinder(1, 1, 8, 6).node.size());
}

TEST(Cylinder, QualityIsAsStated) {
  for (const int n : {8, 10, 20, 32, 48}) {
    const fem::MeshQuality q = fem::quality(fem::cylinder(1.0, 1.0, n, n));
    EXPECT_GT(q.shortest_edge * n, 0.8) << n;
    EXPECT_GT(q.smallest_angle, 1.0) << n;
    EXPECT_LT(q.jacobian_ratio, 1.75) << n;
  }
}

TEST(Box, IsTheTensorProductOfItsLines) {
  const std::vector<double> x{-1, 0, 3}, y{0, 0.5, 1, 2}, z{-2, -1};
  const HexMesh mesh = fem::box(x, y, z);
  EXPECT_EQ(mesh.x.size(), 24u);
  EXPECT_EQ(mesh.node.size(), 6u);
  expect_sound(mesh);
  std::set<Point> expected;
  for (const double a : x)
    for (const double b : y)
      for (const double c : z) expected.insert({a, b, c});
  EXPECT_EQ(points(mesh), expected);
  const fem::MeshQuality q = fem::quality(mesh);
  EXPECT_DOUBLE_EQ(q.volume, 8.0);
  EXPECT_DOUBLE_EQ(q.shortest_edge, 0.5);
  EXPECT_NEAR(q.jacobian_ratio, 1.0, 1e-14);
  EXPECT_NEAR(q.smallest_angle, core::pi / 2, 1e-14);
}

TEST(Box, CornerOrderIsTheOneOfTheHeader) {
  const HexMesh mesh = fem::box({0, 1}, {0, 1}, {0, 1});
  const std::array<Vec3, 8> expected{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0),
                                     Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)};
  for (std::size_t a = 0; a < 8; ++a)
    EXPECT_EQ(mesh.x[static_cast<std::size_t>(mesh.node[0][a])], expected[a]) << "corner " << a;
}

TEST(Box, RejectsLinesThatDoNotAscend) {
  EXPECT_THROW(fem::box({0, 1}, {0, 0}, {0, 1}), core::CaseError);
  EXPECT_THROW(fem::box({0}, {0, 1}, {0, 1}), core::CaseError);
}

TEST(Quality, OfATaperedHexIsThatOfTheHandCalculation) {
  // A unit cube whose top is drawn in to a square of side 1/2 about the corner (0, 0): frustum, volume 7/12; det J is
  // the cross-section (1 - z/2)^2 at every height z: 1 at the bottom, 1/4 on top. Smallest angle: edge (-1/2, 0, 1) or
  // (-1/2, -1/2, 1) at the bottom against (-1, 0, 0) or (0, -1, 0); the least is acos(0.5 / sqrt(1.25)).
  HexMesh mesh = fem::box({0, 1}, {0, 1}, {0, 1});
  for (Vec3& x : mesh.x)
    if (x[2] == 1) x.head<2>() *= 0.5;
  const fem::MeshQuality q = fem::quality(mesh);
  EXPECT_NEAR(q.volume, 7.0 / 12.0, 1e-15);
  EXPECT_NEAR(q.jacobian_ratio, 4.0, 1e-14);
  EXPECT_NEAR(q.shortest_edge, 0.5, 1e-15);
  EXPECT_NEAR(q.smallest_angle, std::acos(0.5 / std::sqrt(1.25)), 1e-14);
}

TEST(Quality, OfAnInvertedHexHasNoRatio) {
  HexMesh mesh = fem::box({0, 1}, {0, 1}, {0, 1});
  std::swap(mesh.node[0][0], mesh.node[0][1]);
  EXPECT_EQ(fem::quality(mesh).jacobian_ratio, 1e300);
}

double largest_jump(const std::vector<double>& x) {
  double jump = 1;
  for (std::size_t i = 2; i < x.size(); ++i) {
    const double a = x[i - 1] - x[i - 2], b = x[i] - x[i - 1];
    jump = std::max({jump, a / b, b / a});
  }
  return jump;
}

double longest_edge(const std::vector<double>& x) {
  double e = 0;
  for (std::size_t i = 1; i < x.size(); ++i) e = std::max(e, x[i] - x[i - 1]);
  return e;
}

// Differences of coordinates near 1 carry the coordinates' rounding: 1e-16 over edges of 1e-3 at least.
constexpr double round_off = 1e-10;

TEST(GradedLine, KeepsEndsFineSizeAndGrowth) {
  for (const double growth : {1.0, 1.03, 1.15, 1.5})
    for (const double fine_half : {0.0, 0.03, 0.2, 0.7})
      for (const double focus : {0.0, 0.11, -0.9, 5.0})
        for (const double fine : {0.004, 0.013, 0.3, 9.0}) {
          const fem::Grading g{.fine = fine, .fine_half = fine_half, .focus = focus, .growth = growth};
          SCOPED_TRACE(testing::Message() << growth << " " << fine_half << " " << focus << " " << fine);
          const std::vector<double> x = fem::graded_line(-1.0, 0.8, g);
          EXPECT_EQ(x.front(), -1.0);
          EXPECT_EQ(x.back(), 0.8);
          EXPECT_TRUE(std::adjacent_find(x.begin(), x.end(), std::greater_equal<double>()) == x.end());
          EXPECT_LE(largest_jump(x), growth * (1 + round_off));
        }
}

TEST(GradedLine, FinePartIsUniformWithTheRoundedCount) {
  const fem::Grading g{.fine = 0.01, .fine_half = 0.0523, .focus = 0.1, .growth = 1.2};
  const std::vector<double> x = fem::graded_line(-1.0, 1.0, g);
  std::vector<double> fine;
  for (const double v : x)
    if (v > 0.1 - 0.0524 && v < 0.1 + 0.0524) fine.push_back(v);
  ASSERT_EQ(fine.size(), 11u);  // round(0.1046 / 0.01) = 10 elements
  EXPECT_NEAR(fine.front(), 0.1 - 0.0523, 1e-15);
  EXPECT_NEAR(fine.back(), 0.1 + 0.0523, 1e-15);
  for (std::size_t i = 1; i < fine.size(); ++i) EXPECT_NEAR(fine[i] - fine[i - 1], 0.01046, 1e-15);
}

TEST(GradedLine, IsItsOwnMirrorImageBitByBitWithANodeAtZero) {
  const fem::Grading g{.fine = 0.0113, .fine_half = 0.083, .growth = 1.12};
  const std::vector<double> x = fem::graded_line(-0.71, 0.71, g);
  const std::size_t n = x.size();
  EXPECT_EQ(n % 2, 1u);
  EXPECT_EQ(x[n / 2], 0.0);
  for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(x[i], -x[n - 1 - i]);
  EXPECT_EQ(std::vector<double>(x.begin() + static_cast<std::ptrdiff_t>(n / 2), x.end()), fem::graded_line(0, 0.71, g));
}

TEST(GradedLine, FinePartBeginsAtASymmetryPlane) {
  const std::vector<double> x = fem::graded_line(0, 1, {.fine = 0.01, .fine_half = 0.1, .growth = 1.3});
  for (std::size_t i = 0; i <= 10; ++i) EXPECT_NEAR(x[i], 0.01 * static_cast<double>(i), 1e-15);
  EXPECT_GT(x[11] - x[10], 0.0101);
}

TEST(GradedLine, CoarseLimitsTheEdges) {
  const std::vector<double> x =
      fem::graded_line(-1, 1, {.fine = 0.01, .fine_half = 0.1, .growth = 1.3, .coarse = 0.05});
  EXPECT_LE(longest_edge(x), 0.05 * (1 + round_off));
  EXPECT_GT(longest_edge(x), 0.045);
  EXPECT_LE(largest_jump(x), 1.3 * (1 + round_off));
}

TEST(GradedLine, RejectsWhatHasNoLine) {
  EXPECT_THROW(fem::graded_line(1, 1, {.fine = 0.1}), core::CaseError);
  EXPECT_THROW(fem::graded_line(0, 1, {.fine = 0}), core::CaseError);
  EXPECT_THROW(fem::graded_line(0, 1, {.fine = 0.1, .growth = 0.9}), core::CaseError);
}

}  // namespace
