// SPDX-License-Identifier: Apache-2.0
#include "material/radial_return.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/material/materials.hpp"

namespace {

double determinant(const double* s) {
  return s[0] * (s[1] * s[2] - s[4] * s[4]) - s[3] * (s[3] * s[2] - s[4] * s[5]) + s[5] * (s[3] * s[4] - s[1] * s[5]);
}

}  // namespace

TEST(Rotation, KeepsTheInvariants) {
  for (double angle : {1e-3, 0.3, 3.0, 50.0}) {
    double s[6] = {3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8};
    const double before = material::effective_stress(s), det = determinant(s);
    const double w[3] = {0.6 * angle, -0.64 * angle, 0.48 * angle};
    material::rotate(s, w);
    EXPECT_NEAR(material::effective_stress(s), before, 1e-14 * before);
    EXPECT_NEAR(determinant(s), det, 1e-12 * std::abs(det));
    EXPECT_NEAR(s[0] + s[1] + s[2], 0.0, 1e-14 * before);
  }
}

TEST(Rotation, TurnsTheRightWayByTwoArctanHalf) {
  // uniaxial s along x turned about z by an angle a: s_xx = c^2, s_xy = c s, with a = 2 atan(w/2) (Hughes & Winget)
  for (double w_z : {0.01, 0.2, 1.0}) {
    double s[6] = {1, 0, 0, 0, 0, 0};
    const double w[3] = {0, 0, w_z}, a = 2 * std::atan(w_z / 2);
    material::rotate(s, w);
    EXPECT_NEAR(s[0], std::cos(a) * std::cos(a), 1e-15);
    EXPECT_NEAR(s[1], std::sin(a) * std::sin(a), 1e-15);
    EXPECT_NEAR(s[3], std::cos(a) * std::sin(a), 1e-15);
    EXPECT_NEAR(a, w_z, w_z * w_z * w_z / 12);  // second order: the angle is exact up to the cube
  }
}

TEST(Rotation, AboutEveryAxis) {  // a quarter turn, w = 2 tan(45 deg)
  double s[6] = {1, 2, -3, 0, 0, 0};
  const double about_x[3] = {2, 0, 0}, about_y[3] = {0, 2, 0};
  material::rotate(s, about_x);  // y -> z
  EXPECT_NEAR(s[1], -3, 1e-15);
  EXPECT_NEAR(s[2], 2, 1e-15);
  double t[6] = {0, 0, 0, 1, 0, 0};
  material::rotate(t, about_y);  // z -> x, x -> -z: xy -> -yz
  EXPECT_NEAR(t[4], -1, 1e-15);
  EXPECT_NEAR(t[3], 0, 1e-15);
}

TEST(RadialReturn, LandsOnTheYieldSurface) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 1);
  const auto check = [](const auto& f, double trial, double eps) {
    if (f.G == 0) return;  // melted: VanishingStiffnessGivesTheBoundNotInfinity
    const auto r = material::plastic_increment(f, trial, eps, 1e9);
    if (trial <= f(eps).Y) {
      EXPECT_EQ(r.increment, 0.0);
      return;
    }
    // relative to the trial stress, as the iteration promises
    EXPECT_NEAR(trial - 3 * f.G * r.increment, f(eps + r.increment).Y, 1.01e-11 * trial);
    EXPECT_EQ(r.Y, f(eps + r.increment).Y);
    EXPECT_GE(r.increment, 0.0);
  };
  for (int i = 0; i < 20000; ++i) {
    const double eps = i % 3 == 0 ? 0.0 : std::pow(10, -10 * u(random));
    const double trial = std::pow(10, 7 + 5 * u(random));
    const material::FlowState<double> at{0.8 + u(random), 1e11 * (u(random) - 0.1), 200 + 800 * u(random),
                                         std::pow(10, 8 * u(random))};
    check(material::flow(jc_2024(), at), trial, eps);
    check(material::flow(jc_copper(), at), trial, eps);
    check(material::flow(sg_2024(), at), trial, eps);
    check(material::flow(za_copper(), at), trial, eps);
    check(material::flow(za_iron(), at), trial, eps);
    check(material::flow(material::PerfectlyPlastic{28.6e9, 0.26e9}, at), trial, eps);
  }
}

TEST(RadialReturn, BarelyPlasticFromZeroStrain) {
  // A + B d^n + 3 G d = A + 1 kPa from an infinite slope: d ~ (1e3/426e6)^(1/0.34), some 2.8e-17
  const auto f = material::flow(jc_2024(), material::FlowState<double>{1, 0, 294, 1});
  const double d = material::plastic_increment(f, 265e6 + 1e3, 0.0, 1.0).increment;
  EXPECT_NEAR(f(d).Y + 3 * f.G * d, 265e6 + 1e3, 1.01e-11 * 265e6);
}

TEST(RadialReturn, PerfectlyPlasticInOneStep) {
  const auto f = material::flow(material::PerfectlyPlastic{25e9, 0.3e9}, material::FlowState<double>{1, 0, 294, 1});
  EXPECT_NEAR(material::plastic_increment(f, 0.6e9, 0.1, 1.0).increment, 0.3e9 / 75e9, 1e-17);
}

TEST(RadialReturn, VanishingStiffnessGivesTheBoundNotInfinity) {
  material::ConstantFlow<double> f{0, 0};
  for (double G : {0.0, 1e-10, 1e-3, 1.0}) {
    f.G = G;
    const auto r = material::plastic_increment(f, 1e9, 0.2, 0.015);
    EXPECT_EQ(r.increment, 0.015);
    EXPECT_EQ(r.Y, 0.0);
  }
}
