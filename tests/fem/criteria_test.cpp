// SPDX-License-Identifier: Apache-2.0
// Each criterion alone flags what it should and nothing else; the total deformation against closed forms.
#include "fem/criteria.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "fem/elements.hpp"
#include "tests/fem/fluid.hpp"

namespace {

using core::Vec3;
using Flags = std::vector<std::uint32_t>;

/// 2 x 2 x 2 elements of unit edge, rho 1000.
struct Block {
  Block() {
    fem::add_body(mesh, fem::box({0, 1, 2}, {0, 1, 2}, {0, 1, 2}), 0, 1000);
    fem::finish(mesh);
    mesh.elements.dt.assign(8, 1e-4);
    mesh.elements.dt_0 = mesh.elements.dt;
    fem::store_initial_shape(mesh);
  }
  Flags flags() { return fem::flag_elements(mesh, criteria, {1000.0}); }
  fem::Mesh mesh;
  fem::Criteria criteria;
};

TEST(Criteria, NothingFlagsAnUndeformedMesh) {
  Block b;
  b.criteria.use_deformation = b.criteria.use_jacobian = b.criteria.use_plastic_strain = b.criteria.use_timestep =
      b.criteria.use_damage = true;
  EXPECT_TRUE(b.flags().empty());
}

TEST(Criteria, Deformation) {
  Block b;
  b.mesh.elements.deformation[3] = 2.1;
  EXPECT_TRUE(b.flags().empty());
  b.criteria.use_deformation = true;
  EXPECT_EQ(b.flags(), Flags{3});
}

/// While matter is compressed above 1 % of its modulus, criteria wait; what turns inside out does not.
TEST(Criteria, AShockPassesBeforeAnythingIsFlagged) {
  Block b;
  b.criteria.use_deformation = true;
  auto& e = b.mesh.elements;
  e.deformation[3] = 2.1;
  e.pt.c[3] = 5000;               // rho c^2 = 25 GPa
  e.pt.q[3] = 1;                  // being compressed
  e.pt.p[3] = 0.26e9;
  EXPECT_TRUE(b.flags().empty());
  e.pt.p[3] = 0.24e9;
  EXPECT_EQ(b.flags(), Flags{3});
  e.pt.p[3] = 0.26e9, e.pt.q[3] = 0;
  EXPECT_EQ(b.flags(), Flags{3});
  e.pt.q[3] = 1;
  for (const auto nd : e.node[3]) b.mesh.nodes.x[static_cast<std::size_t>(nd)][0] *= -1;
  EXPECT_EQ(b.flags(), Flags{3});
}

TEST(Criteria, PlasticStrain) {
  Block b;
  b.mesh.elements.pt.eps_p[5] = 2.6;
  EXPECT_TRUE(b.flags().empty());
  b.criteria.use_plastic_strain = true;
  EXPECT_EQ(b.flags(), Flags{5});
}

TEST(Criteria, Timestep) {
  Block b;
  b.mesh.elements.dt[2] = 0.09e-4;
  EXPECT_TRUE(b.flags().empty());
  b.criteria.use_timestep = true;
  EXPECT_EQ(b.flags(), Flags{2});
}

TEST(Criteria, CollapseIsAlwaysLookedFor) {
  Block b;
  b.mesh.elements.dt[2] = 0.03e-4;
  EXPECT_EQ(b.flags(), Flags{2});
}

/// Left-overs are looked for below 0.7 of the first step, and rho c^2 is 25 GPa.
struct BlockWithLeftOvers : Block {
  BlockWithLeftOvers() {
    criteria.left_over = 0.7;
    mesh.elements.pt.c.assign(mesh.elements.pt.c.size(), 5000);
  }
  /// Is the first element one, at this stable step over the first and this pressure [Pa]?
  bool first(double step, double p) {
    mesh.elements.dt[0] = step * mesh.elements.dt_0[0];
    mesh.elements.pt.p[0] = p;
    return flags() == Flags{0};
  }
};

TEST(Criteria, LeftOverHangsOnToLittleIsNotPressedAndHoldsTheStep) {
  BlockWithLeftOvers b;
  EXPECT_FALSE(b.first(0.6, 0));  // the corner of a whole block: 8 + 3 x 4 + 3 x 2 + 1 = 27 corners at its nodes
  for (const std::uint32_t el : {2, 3, 4, 5, 6, 7}) b.mesh.elements.alive[el] = 0;
  EXPECT_TRUE(b.first(0.6, 0));  // 8 of its own and 4 of element 1
  EXPECT_TRUE(b.first(0.6, 0.049e9));
  EXPECT_FALSE(b.first(0.6, 0.051e9));
  EXPECT_FALSE(b.first(0.8, 0));
}

TEST(Criteria, LeftOverStandsBesideWhatHasGoneAndHasLostHalfItsStep) {
  BlockWithLeftOvers b;
  EXPECT_FALSE(b.first(0.4, 0));     // nothing has gone: flattened inside a body that is whole
  b.mesh.elements.alive[7] = 0;      // the element opposite, at one node: 26 of 27 corners are left
  EXPECT_TRUE(b.first(0.4, 0));
  EXPECT_TRUE(b.first(0.4, 0.24e9));
  EXPECT_FALSE(b.first(0.4, 0.26e9));
  EXPECT_FALSE(b.first(0.6, 0));
}

TEST(Criteria, Damage) {
  Block b;
  b.mesh.elements.pt.damage[0] = 1.0;
  b.mesh.elements.pt.damage[1] = 0.999;
  EXPECT_TRUE(b.flags().empty());
  b.criteria.use_damage = true;
  EXPECT_EQ(b.flags(), Flags{0});
}

/// Nodes at z = 2 pulled together along x: the upper four elements become trapezoids.
void taper(Block& b, double factor) {
  for (auto& x : b.mesh.nodes.x)
    if (x[2] == 2) x[0] *= factor;
  b.mesh.elements.deformation.assign(8, 1.0);
}

TEST(Criteria, JacobianRatioAgainstTheShapeAsBuilt) {
  // Upper edges shrink to f of the lower: det J = (1 + f)/2 - (1 - f)/2 zeta; the ratio of the Gauss values passes 2.5 at
  // (1 - f)/(1 + f) = (1.5/3.5) sqrt 3, f = 0.148. (Corner elements' skew is the same on both sides of x = 1: f about 0.)
  for (const double f : {0.16, 0.14}) {
    Block b;
    b.criteria.use_jacobian = true;
    b.criteria.min_angle = 0;
    taper(b, f);
    EXPECT_EQ(b.flags().size(), f > 0.148 ? 0u : 4u) << f;
  }
}

TEST(Criteria, SmallestAngle) {
  // x += 2 z: the angle is atan(1/2) = 0.4636 everywhere, and det J stays uniform.
  Block b;
  for (auto& x : b.mesh.nodes.x) x[0] += 2 * x[2];
  b.mesh.elements.deformation.assign(8, 1.0);
  b.criteria.use_jacobian = true;
  b.criteria.min_angle = 0.46;
  EXPECT_TRUE(b.flags().empty());
  b.criteria.min_angle = 0.47;
  EXPECT_EQ(b.flags().size(), 8u);
}

TEST(Criteria, InvertedCornerIsAlwaysLookedFor) {
  Block b;
  taper(b, -0.1);
  EXPECT_EQ(b.flags().size(), 4u);
}

/// Moves the block with x = f(t) X over n steps to t = 1 and returns the total deformation of its first element.
double deform(int n, const std::function<Vec3(const Vec3&, double)>& f) {
  Block b;
  const auto x_0 = b.mesh.nodes.x;
  const double dt = 1.0 / n;
  for (int k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < x_0.size(); ++i) {
      const Vec3 next = f(x_0[i], (k + 1) * dt);
      b.mesh.nodes.v[i] = (next - b.mesh.nodes.x[i]) / dt;
      b.mesh.nodes.x[i] = next;
    }
    fem::update_awake_elements(b.mesh, {fluid()}, {}, {dt, dt});
  }
  return b.mesh.elements.deformation[0];
}

TEST(Criteria, DeformationOfSimpleShearIsExact) {
  // D_xy = rate/2: sqrt(2/3 D:D) = rate/sqrt 3 in every step.
  const double measured = deform(10, [](const Vec3& x, double t) { return Vec3(x[0] + 0.5 * t * x[2], x[1], x[2]); });
  EXPECT_NEAR(measured, 0.5 / std::sqrt(3.0), 1e-14);
}

TEST(Criteria, DeformationOfUniaxialStretchConvergesAtSecondOrder) {
  // The integral of dl/l to l = 2: sqrt(2/3) ln 2; mid-point rule.
  const auto stretch = [](const Vec3& x, double t) { return Vec3(x[0], x[1], x[2] * (1 + t)); };
  const double exact = std::sqrt(2.0 / 3.0) * std::log(2.0);
  const double coarse = std::abs(deform(20, stretch) - exact), fine = std::abs(deform(40, stretch) - exact);
  EXPECT_LT(fine, 1e-4);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.05);
}

}  // namespace
