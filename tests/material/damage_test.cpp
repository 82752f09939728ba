// SPDX-License-Identifier: Apache-2.0
// Johnson & Cook (1985) eqs 3-5, figures evaluated outside.
#include <gtest/gtest.h>

#include "tests/material/materials.hpp"

using material::fracture_strain;

TEST(JohnsonCookDamage, UniaxialTension) {  // sigma* = 1/3: 0.05 + 3.44 exp(-2.12/3)
  EXPECT_NEAR(fracture_strain(damage_4340(), -1e8, 3e8, 1.0, 294.0), 1.7469029657120483, 1e-14);
}

TEST(JohnsonCookDamage, UniaxialCompressionFastAndHot) {  // sigma* = -1/3, rate 1e4, T* = 1/2
  EXPECT_NEAR(fracture_strain(damage_4340(), 1e8, 3e8, 1e4, 0.5 * (294 + 1793)), 9.334698920856855, 1e-13);
}

TEST(JohnsonCookDamage, TriaxialityIsHeldAtThreeHalves) {
  EXPECT_NEAR(fracture_strain(damage_4340(), -9e8, 3e8, 1.0, 294.0), 0.19305465361683566, 1e-15);
}

TEST(JohnsonCookDamage, TriaxialityIsHeldAtMinusThirty) {  // 0.05 + 3.44 exp(2.12 30) under any higher pressure
  for (const double p : {9e9, 1e12}) EXPECT_NEAR(fracture_strain(damage_4340(), p, 3e8, 1.0, 294.0), 1.4377636240977207e+28, 1e15);
}

TEST(JohnsonCookDamage, FitThatBearsStrongTension) {  // Armco iron at sigma* = 1.5: -2.2 + 5.43 exp(-0.705)
  const material::JohnsonCookDamage d{.D1 = -2.2, .D2 = 5.43, .D3 = -0.47, .D4 = 0.016, .D5 = 0.63, .T_melt = 1811};
  EXPECT_NEAR(fracture_strain(d, -9e8, 3e8, 1.0, 294.0), 0.4830095582108491, 1e-14);
}

TEST(JohnsonCookDamage, FitThatVanishesIsHeldAtItsEnd) {
  // Lesuer's 6061-T6: -0.77 + 1.45 exp(-0.47 sigma*) is 0.3288 at 0.59, 0.15 at 0.968 and below zero from 1.347 on
  material::JohnsonCookDamage d{.D1 = -0.77, .D2 = 1.45, .D3 = -0.47, .D5 = 1.6, .T_melt = 925};
  EXPECT_NEAR(fracture_strain(d, -1.77e8, 3e8, 1.0, 294.0), 0.3288493165621, 1e-12);
  EXPECT_NEAR(fracture_strain(d, -2.9e8, 3e8, 1.0, 294.0), 0.1505630577060, 1e-12);
  for (const double p : {-3e8, -4.5e8, -2e9}) EXPECT_EQ(fracture_strain(d, p, 3e8, 1.0, 294.0), 0.15);
  EXPECT_NEAR(fracture_strain(d, -9e8, 3e8, 1.0, 0.5 * (294 + 925)), 0.15 * 1.8, 1e-15);
  d.D4 = -1;  // a rate that would make it negative
  EXPECT_EQ(fracture_strain(d, -9e8, 3e8, 1e4, 294.0), material::smallest_fracture_strain);
}

TEST(JohnsonCookDamage, AccumulatesToFailure) {
  // simple shear of a perfectly plastic solid with eps_f = 0.5 + 0.5 = 1 whatever the pressure, rate and heat
  auto m = aluminium(material::PerfectlyPlastic{28.6e9, 0.3e9});
  m.damage = material::JohnsonCookDamage{.D1 = 0.5, .D2 = 0.5, .D3 = 0};
  auto pt = virgin(m);
  const double shear = 2e-3;  // d_xy; equivalent strain 2/sqrt(3) of it
  int n = 0;
  while (pt.damage < 1 && n < 10000) {
    step(m, {{0, 0, 0, shear, 0, 0}, {0, 0, 0}}, 1e-8, pt);
    ++n;
    if (pt.damage < 1) {
      EXPECT_NEAR(pt.damage, pt.eps_p, 1e-12);
    }
  }
  EXPECT_EQ(pt.damage, 1.0);
  // equivalent strain to failure: 1 plus the elastic part 0.3e9/(3 G), to within one step
  EXPECT_NEAR(n * shear * 2 / std::sqrt(3.0), 1 + 0.3e9 / (3 * 28.6e9), 2 * shear * 2 / std::sqrt(3.0));
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
  const double eps_p = pt.eps_p;
  step(m, {{0, 0, 0, shear, 0, 0}, {0, 0, 0}}, 1e-8, pt);
  EXPECT_EQ(pt.damage, 1.0);
  EXPECT_EQ(pt.eps_p, eps_p);
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
}
