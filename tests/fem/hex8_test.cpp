// SPDX-License-Identifier: Apache-2.0
// Identities of the one-point hexahedron, and shape measures against values worked out by hand.
#include "fem/hex8.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/types.hpp"
#include "tests/fem/shapes.hpp"

namespace {

using core::Mat3;
using core::Vec3;
using fem::Corners;
using fem::Gradient;

using shapes::sign;

template <class Map>
Corners<double> hex(Map&& map) {
  Corners<double> c;
  for (int i = 0; i < 8; ++i) {
    const Vec3 x = map(Vec3(sign[i][0], sign[i][1], sign[i][2]));
    for (int d = 0; d < 3; ++d) c.c[i][d] = x[d];
  }
  return c;
}

Vec3 corner(const Corners<double>& c, int i) { return {c.c[i][0], c.c[i][1], c.c[i][2]}; }

/// A hex with warped faces, every corner off its place by up to 0.3 half-edges, far from the origin.
Corners<double> distorted(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  return hex([&](const Vec3& x) { return Vec3(x + Vec3(jitter(random), jitter(random), jitter(random)) + Vec3(5, -3, 2)); });
}

double tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6;
}

// Numbers are of order 1 to 10 and sums have 8 to 48 terms: a few hundred units in the last place.
constexpr double round_off = 1e-13;

/// B_jI [corner][direction].
using AtCorners = std::array<std::array<double, 3>, 8>;
AtCorners at_corners(const Gradient<double>& g) {
  double b[8][3];
  for (int d = 0; d < 3; ++d) {
    double q[fem::n_modes] = {};
    for (int k = 0; k < fem::n_straining; ++k) q[k] = g.g[k][d];
    fem::spread(q, d, b);
  }
  AtCorners r;
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t d = 0; d < 3; ++d) r[i][d] = b[i][d];
  return r;
}

TEST(StableLength, OfCubeAndBrick) {
  const auto of = [](double a, double b, double c) {
    const auto x = hex([&](const Vec3& s) { return Vec3(0.5 * a * s[0], 0.5 * b * s[1], 0.5 * c * s[2]); });
    const auto m = fem::modes(x);
    const auto g = fem::gradient(m);
    const double v = fem::volume(m, g);
    return fem::stable_length(g, v, v / std::sqrt(fem::largest_face_area_squared(m)));
  };
  // 8 B:B = 4 (A_x^2 + A_y^2 + A_z^2) of a brick with face areas A: 2 V / sqrt is V / |A|
  EXPECT_NEAR(of(2, 2, 2), 4.0 / 3, 1e-14);                  // 8 / sqrt(48) = 1.155 is less than two thirds of an edge
  EXPECT_NEAR(of(1, 1, 0.2), 0.2 / std::sqrt(1.08), 1e-14);  // areas 1, 0.2, 0.2
  EXPECT_NEAR(of(0.1, 1, 1), 0.1 / std::sqrt(1.02), 1e-14);
}

TEST(Hex8, GradientOperatorSumsToZero) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto b = at_corners(fem::gradient(fem::modes(distorted(seed))));
    for (std::size_t d = 0; d < 3; ++d) {
      double sum = 0;
      for (const auto& at : b) sum += at[d];
      EXPECT_NEAR(sum, 0, round_off);
    }
  }
}

TEST(Hex8, VolumeOfPlanarFacedHexIsThatOfItsTetrahedra) {
  // A projective map keeps planes plane. Each outward face makes two tetrahedra with the mean of the corners.
  for (const Vec3& a : {Vec3(0.2, 0.1, -0.15), Vec3(-0.3, 0.25, 0.1), Vec3(0, 0, 0)}) {
    const auto p = hex([&](const Vec3& x) { return Vec3(x / (1 + a.dot(x))); });
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < 8; ++i) centre += corner(p, i) / 8;
    double exact = 0;
    for (const auto& f : fem::face_corner) {
      exact -= tetrahedron(corner(p, f[0]), corner(p, f[1]), corner(p, f[2]), centre);
      exact -= tetrahedron(corner(p, f[0]), corner(p, f[2]), corner(p, f[3]), centre);
    }
    const auto m = fem::modes(p);
    EXPECT_NEAR(fem::volume(m, fem::gradient(m)), exact, round_off * exact);
  }
}

TEST(Hex8, VolumeIsTheIntegralOfDetJ) {
  // det J is a polynomial of degree 2 in each parent coordinate: 2x2x2 Gauss points integrate it exactly.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto x = distorted(seed);
    double exact = 0;
    for (const auto& s : sign)
      exact += shapes::jacobian_at(x, s[0] / std::sqrt(3.0), s[1] / std::sqrt(3.0), s[2] / std::sqrt(3.0));
    const auto m = fem::modes(x);
    EXPECT_NEAR(fem::volume(m, fem::gradient(m)), exact, round_off * 100);
  }
}

TEST(Hex8, LinearVelocityFieldGivesExactGradient) {
  Mat3 l;
  l << 0.3, -1.2, 0.5, 0.8, -0.4, 2.0, -0.7, 0.1, 0.9;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto x = distorted(seed);
    Corners<double> v;
    for (int i = 0; i < 8; ++i) {
      const Vec3 u = l * corner(x, i) + Vec3(1, 2, 3);
      for (int d = 0; d < 3; ++d) v.c[i][d] = u[d];
    }
    const auto m = fem::modes(x);
    const auto g = fem::gradient(m);
    double sum[3][3];
    fem::contract(fem::modes(v), g, sum);
    const double volume = fem::volume(m, g);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(sum[i][j] / volume, l(i, j), round_off);
  }
}

/// The mode's base vectors, Flanagan & Belytschko 1981, table 2, in the signs used here.
constexpr double base[4][8] = {{1, 1, -1, -1, -1, -1, 1, 1}, {1, -1, -1, 1, -1, 1, 1, -1}, {1, -1, 1, -1, 1, -1, 1, -1}, {-1, 1, -1, 1, 1, -1, 1, -1}};

TEST(Hex8, HourglassRatesAreThoseOfTheShapeVectorsAndVanishInLinearFields) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto x = distorted(seed);
    const auto m = fem::modes(x);
    const auto g = fem::gradient(m);
    const auto b = at_corners(g);
    const double volume = fem::volume(m, g);
    // gamma_aI = h_aI - B_jI (x_jJ h_aJ) / V, written out
    double gamma[4][8];
    for (int a = 0; a < 4; ++a) {
      Vec3 h = Vec3::Zero();
      for (int i = 0; i < 8; ++i) h += base[a][i] * corner(x, i);
      for (int i = 0; i < 8; ++i) gamma[a][i] = base[a][i] - (b[i][0] * h[0] + b[i][1] * h[1] + b[i][2] * h[2]) / volume;
    }
    for (const bool linear : {true, false}) {
      auto v = distorted(seed + 100);
      if (linear)
        for (int i = 0; i < 8; ++i)
          for (int d = 0; d < 3; ++d) v.c[i][d] = 1 + d + 2 * x.c[i][(d + 1) % 3] - x.c[i][d];
      double l[3][3], rate[4][3];
      fem::contract(fem::modes(v), g, l);
      for (auto& row : l)
        for (double& a : row) a /= volume;
      fem::hourglass_rates(m, fem::modes(v), l, rate);
      for (int a = 0; a < 4; ++a)
        for (int d = 0; d < 3; ++d) {
          double sum = 0;
          for (int i = 0; i < 8; ++i) sum += gamma[a][i] * v.c[i][d];
          EXPECT_NEAR(rate[a][d], linear ? 0.0 : sum, 20 * round_off);
        }
    }
  }
}

TEST(Hex8, GradientIsTheDerivativeOfTheVolume) {
  // V is linear in each coordinate of each corner: a difference over any step is its derivative.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto x = distorted(seed);
    const auto volume = [](const Corners<double>& c) {
      const auto m = fem::modes(c);
      return fem::volume(m, fem::gradient(m));
    };
    const auto b = at_corners(fem::gradient(fem::modes(x)));
    for (int i = 0; i < 8; ++i)
      for (int d = 0; d < 3; ++d) {
        auto moved = x;
        moved.c[i][d] += 1;
        EXPECT_NEAR(b[std::size_t(i)][std::size_t(d)], volume(moved) - volume(x), 10 * round_off);
      }
  }
}

TEST(Hex8, LargestFaceAreaIsThatOfTheDiagonals) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto x = distorted(seed);
    double largest = 0;
    for (const auto& f : fem::face_corner)
      largest = std::max(largest, 0.5 * (corner(x, f[2]) - corner(x, f[0])).cross(corner(x, f[3]) - corner(x, f[1])).norm());
    EXPECT_NEAR(std::sqrt(fem::largest_face_area_squared(fem::modes(x))), largest, round_off * largest * 10);
  }
}

TEST(Hex8, ModesAreSpreadOverCornersByTheirBaseVectors) {
  const double q[7] = {-0.75, 4.0, 0.125, 1.5, -2.25, 3.0, 0.5};
  for (int d = 0; d < 3; ++d) {
    double f[8][3] = {};
    fem::spread(q, d, f);
    for (int i = 0; i < 8; ++i) {
      double sum = q[0] * sign[i][0] + q[1] * sign[i][1] + q[2] * sign[i][2];
      for (int a = 0; a < 4; ++a) sum += q[3 + a] * base[a][i];
      for (int k = 0; k < 3; ++k) EXPECT_EQ(f[i][k], k == d ? sum : 0.0);
    }
  }
}

TEST(Hex8, JacobianRatioOfTrapezoidByHand) {
  // x = xi (1 + eta/2), y = eta, z = zeta: det J = 1 + eta/2, at the Gauss points 1 +- 1/(2 sqrt 3):
  // ratio (2 sqrt 3 + 1)/(2 sqrt 3 - 1) = 1.8116; at the corners the smallest is 1/2.
  const auto x = hex([](const Vec3& p) { return Vec3(p[0] * (1 + 0.5 * p[1]), p[1], p[2]); });
  const double r = 2 * std::sqrt(3.0);
  EXPECT_NEAR(fem::jacobian_ratio(fem::edges(x)), (r + 1) / (r - 1), round_off);
  EXPECT_NEAR(fem::smallest_corner_jacobian(fem::edges(x)), 0.5, round_off);
  // the angle at the long base: tan = height / overhang = 2 / 1
  EXPECT_NEAR(fem::smallest_angle(x), std::atan(2.0), round_off);
}

TEST(Hex8, JacobianRatioOfInvertedElementIsBeyondAnyLimit) {
  const auto x = hex([](const Vec3& p) { return Vec3(p[0] * (1 + 2.5 * p[1]), p[1], p[2]); });
  EXPECT_EQ(fem::jacobian_ratio(fem::edges(x)), 1e300);
}

TEST(Hex8, SmallestAngleOfShearedCube) {
  for (const double shear : {0.0, 0.5, 1.0, 2.0}) {
    const auto x = hex([&](const Vec3& p) { return Vec3(p[0] + shear * p[1], p[1], p[2]); });
    EXPECT_NEAR(fem::smallest_angle(x), std::atan2(1.0, shear), 1e-12);  // acos loses digits near 90 degrees
  }
}

/// Every corner off its place by up to 1.2 half-edges: some turn inside out.
Corners<double> crumpled(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-1.2, 1.2);
  const double size = seed % 3 == 0 ? 0.2 : seed % 3 == 1 ? 0.6 : 1;
  return hex([&](const Vec3& x) { return Vec3(x + size * Vec3(jitter(random), jitter(random), jitter(random)) + Vec3(5, -3, 2)); });
}

TEST(Hex8, JacobiansFromEdgesAreThoseOfTheShapeFunctions) {
  int inverted = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const auto x = crumpled(seed);
    const auto edge = fem::edges(x);
    const double low = shapes::jacobians(x, 1).first, ratio = shapes::jacobian_ratio(x);
    EXPECT_EQ(fem::smallest_corner_jacobian(edge), low) << seed;  // bit for bit: halves are exact
    double inside, high;
    fem::extreme_jacobians(fem::gauss_lines(edge), inside, high);
    EXPECT_NEAR(inside, shapes::jacobians(x, 1 / std::sqrt(3.0)).first, 10 * round_off) << seed;
    EXPECT_NEAR(high, shapes::jacobians(x, 1 / std::sqrt(3.0)).second, 10 * round_off) << seed;
    if (std::abs(inside) > 0.01) {
      EXPECT_NEAR(fem::jacobian_ratio(edge) / ratio, 1, 1e-11) << seed;
    }
    inverted += low <= 0;
  }
  EXPECT_GT(inverted, 30);
  EXPECT_LT(inverted, 270);
}

TEST(Hex8, SharperThanAnAngleAgreesWithTheSmallestAngle) {
  const auto limit = [](double angle) { return std::cos(angle) * std::abs(std::cos(angle)); };
  for (unsigned seed = 0; seed < 300; ++seed) {
    const auto x = crumpled(seed);
    const double angle = fem::smallest_angle(x);
    EXPECT_TRUE(fem::sharper_than(fem::edges(x), limit(angle + 1e-9))) << seed;
    EXPECT_FALSE(fem::sharper_than(fem::edges(x), limit(angle - 1e-9))) << seed;
  }
  const auto flat = hex([](const Vec3& x) { return Vec3(x[0], x[1], 0); });  // edges of no length have no angle
  EXPECT_FALSE(fem::sharper_than(fem::edges(flat), limit(1.5)));
}

}  // namespace
