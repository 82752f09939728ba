// SPDX-License-Identifier: Apache-2.0
// The point update as a whole, against closed forms.
#include "material/update.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/material/materials.hpp"

using Inc = material::Increment<double>;

TEST(Update, EnergyIsNotTouchedAndTheEstimateIsHalfTheWork) {
  const auto m = aluminium(material::NoStrength{});
  auto pt = virgin(m);
  pt.rho = 2800;
  pt.p = 3e9;
  pt.e = 1e5;
  const double q = 1e9, tr = -0.03, rho_new = 2886;
  material::update(m, 1e-8, rho_new, Inc{{tr / 2, tr / 2, 0, 0, 0, 0}, {0, 0, 0}}, q, pt);
  EXPECT_EQ(pt.e, 1e5);
  const double e_est = 1e5 + 0.5 * -(3e9 + 1e9) * tr / ((2800 + 2886) / 2.0);
  const auto expected = eos::state(m.eos, rho_new, e_est);
  EXPECT_NEAR(pt.p, expected.p, 1e-12 * expected.p);
  EXPECT_NEAR(pt.temperature, expected.temperature, 1e-10);
  EXPECT_NEAR(pt.c, std::sqrt(expected.c2), 1e-9);
  EXPECT_EQ(pt.rho, rho_new);
}

TEST(Update, StressWorkEntersTheEstimate) {
  const auto m = aluminium(material::PerfectlyPlastic{28.6e9, 1e12});
  auto pt = virgin(m);
  pt.s[core::xy] = 2e8;
  pt.s[core::xx] = 1e8;
  pt.s[core::yy] = -1e8;
  material::update(m, 1e-8, 2785.0, Inc{{0.01, -0.01, 0, 0.02, 0, 0}, {0, 0, 0}}, 0.0, pt);
  const double work = (1e8 * 0.01 + 1e8 * 0.01 + 2 * 2e8 * 0.02) / 2785;
  EXPECT_NEAR(pt.p, 2.0 * 2785 * work / 2, 1e-9 * pt.p);  // gamma_0 rho_0 e at rho_0
}

TEST(Update, NoStrengthCarriesNoShear) {
  const auto m = aluminium(material::NoStrength{});
  auto pt = virgin(m);
  pt.s[core::xy] = 1e8;
  step(m, Inc{{0, 0, 0, 0.1, 0, 0}, {0, 0, 0}}, 1e-8, pt);
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
}

TEST(Update, UniaxialStrainElasticThenPlastic) {
  // s_xx = 4/3 G ln(l/l_0) up to yield at |s_xx| = 2/3 Y; eps_p = 2/3 (|strain| - Y/(2G)) beyond; s_yy = s_zz = -s_xx/2
  const double G = 28.6e9, Y = 0.26e9;
  const auto m = aluminium(material::PerfectlyPlastic{G, Y});
  auto pt = virgin(m);
  const double d = -1e-4, strain_at_yield = Y / (2 * G);
  for (int n = 1; n <= 200; ++n) {
    step(m, Inc{{d, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
    const double strain = -n * d;
    const double s = strain < strain_at_yield ? -4.0 / 3.0 * G * strain : -2.0 / 3.0 * Y;
    EXPECT_NEAR(pt.s[core::xx], s, 1e-11 * Y);
    EXPECT_NEAR(pt.s[core::yy], -s / 2, 1e-11 * Y);
    EXPECT_NEAR(pt.s[core::zz], -s / 2, 1e-11 * Y);
    EXPECT_NEAR(pt.eps_p, strain < strain_at_yield ? 0 : 2.0 / 3.0 * (strain - strain_at_yield), 1e-13);
  }
}

TEST(Update, LongitudinalSoundSpeed) {
  const auto m = aluminium(material::PerfectlyPlastic{28.6e9, 0.26e9});
  auto pt = virgin(m);
  step(m, Inc{}, 1e-9, pt);
  EXPECT_NEAR(pt.c, std::sqrt(5328.0 * 5328.0 + 4.0 / 3.0 * 28.6e9 / 2785), 1e-9);
}

TEST(Update, HardeningFollowsTheLawExactly) {
  // simple tension of Johnson-Cook at a steady rate: after every step sigma_eff = Y(eps_p, rate, T) of that step
  const auto m = aluminium(jc_2024());
  auto pt = virgin(m);
  const double dt = 1e-8, d = 1e-3, rate = d / dt;
  double e = 0;
  for (int n = 0; n < 500; ++n) {
    pt.e = e;  // no heating: the temperature stays near T_0
    step(m, Inc{{d, -d / 2, -d / 2, 0, 0, 0}, {0, 0, 0}}, dt, pt);
    const double t = std::max((pt.temperature - 294) / (775 - 294), 0.0);
    const double Y = (265e6 + 426e6 * std::pow(pt.eps_p, 0.34)) * (1 + 0.015 * std::log(rate)) * (1 - t);
    if (n > 6) {
      EXPECT_NEAR(material::effective_stress(pt.s), Y, 1e-10 * Y);
    }
  }
  // total strain = plastic + sigma/(3G)
  EXPECT_NEAR(500 * d, pt.eps_p + material::effective_stress(pt.s) / (3 * 28.6e9), 1e-9);
}

TEST(Update, RigidRotationTurnsTheStressAndNothingElse) {
  const auto m = aluminium(jc_2024());
  auto pt = virgin(m);
  pt.s[core::xx] = 1e8;
  pt.s[core::yy] = -1e8;
  const double w = 2 * std::tan(core::pi / 200);  // 1/100 of a half turn each step
  for (int n = 0; n < 100; ++n) step(m, Inc{{}, {0, 0, w}}, 1e-8, pt);
  EXPECT_NEAR(pt.s[core::xx], 1e8, 1e-4);
  EXPECT_NEAR(pt.s[core::xy], 0, 1e-4);
  EXPECT_EQ(pt.eps_p, 0.0);
  EXPECT_NEAR(pt.p, 0.0, 1e-3);
}

TEST(Update, MeltingDoesNotExplodeThePlasticStrain) {
  // a Steinberg-Guinan point under load is heated past melting within one step
  const auto m = aluminium(sg_2024());
  auto pt = virgin(m);
  for (int n = 0; n < 100; ++n) step(m, Inc{{-1e-3, 5e-4, 5e-4, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  const double before = pt.eps_p, sigma = material::effective_stress(pt.s);
  EXPECT_GT(sigma, 0.2e9);
  pt.e = 1.5e6;
  step(m, Inc{{-1e-3, 5e-4, 5e-4, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
  EXPECT_NEAR(pt.eps_p - before, 1e-3 + sigma / (3 * 28.6e9), 1e-15);  // strain brought plus elastic strain released
  const double melted = pt.eps_p;
  step(m, Inc{{-1e-3, 5e-4, 5e-4, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_LE(pt.eps_p - melted, 1.0000001e-3);
  // no shear part: the bulk speed of the same state (the estimated energy differs from e by the pressure's work, here 0)
  EXPECT_NEAR(pt.c, std::sqrt(eos::state(m.eos, pt.rho, pt.e).c2), 1e-9 * pt.c);
}

TEST(Update, SpallFailsThePointForGood) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  auto pt = virgin(m);
  int n = 0;
  double last = 0;
  while (pt.damage < 1 && n++ < 1000) {
    last = pt.p;
    step(m, Inc{{1e-4, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  }
  EXPECT_LT(last, -1.18e9);
  EXPECT_GE(last, -1.2e9);
  EXPECT_EQ(pt.damage, 1.0);
  EXPECT_EQ(pt.p, 0.0);
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
  // pulled on: still nothing; pushed together: pressure again, no shear
  step(m, Inc{{0.1, 0, 0, 0.05, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_EQ(pt.p, 0.0);
  step(m, Inc{{-0.3, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_GT(pt.p, 1e9);
  for (double s : pt.s) EXPECT_EQ(s, 0.0);
  EXPECT_EQ(pt.damage, 1.0);
  EXPECT_NEAR(pt.c * pt.c, eos::state(m.eos, pt.rho, 0.0).c2, 0.1 * pt.c * pt.c);  // no shear modulus
}

TEST(Update, MatterBelowItsColdCurveBearsNoTension) {
  // at rho_0 the cold curve lies cv T_0 = 875 * 294 = 257,250 J/kg below the reference state, and p = gamma_0 rho_0 e
  const auto m = aluminium(material::PerfectlyPlastic{28.6e9, 0.26e9});
  auto pt = virgin(m);
  for (const double e : {-257e3, -258e3, -2e6, -257e3}) {
    pt.e = e;
    pt.p = 0;
    material::update(m, 1e-9, 2785.0, Inc{{0, 0, 0, 0, 0, 0}, {0, 0, 0}}, 0.0, pt);
    EXPECT_NEAR(pt.p, e < -257250 ? 0.0 : 2.0 * 2785 * e, 1e-9 * 1.4e9) << e;
    EXPECT_EQ(pt.damage, 0.0);
  }
  pt.e = -258e3;  // pressed, it resists
  material::update(m, 1e-9, 2900.0, Inc{{-0.04, 0, 0, 0, 0, 0}, {0, 0, 0}}, 0.0, pt);
  EXPECT_GT(pt.p, 1e9);
}

TEST(Update, FluidSpallsToo) {
  auto m = aluminium(material::NoStrength{});
  m.spall = 1e8;
  auto pt = virgin(m);
  step(m, Inc{{0.01, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_EQ(pt.damage, 1.0);
  EXPECT_EQ(pt.p, 0.0);
}

// A crack that opens through a point of edge 0.1 mm: 8.2 kJ/m2 at 1.2 GPa is an opening of 2 x 8200 / 1.2e9 = 13.67 um, 0.1367 of
// the edge, at half of which half of the tension is left.
TEST(Update, TensionFallsLinearlyAsACrackOpens) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  auto pt = virgin(m);
  pt.m = m.rho_0 * 1e-12;
  const Inc pull{{1e-5, 0, 0, 0, 0, 0}, {0, 0, 0}};
  while (pt.damage == 0) step(m, pull, 1e-9, pt);
  EXPECT_NEAR(pt.p, -1.2e9, 1e6);
  for (int n = 0; n < 6833; ++n) step(m, pull, 1e-9, pt);
  EXPECT_NEAR(pt.damage, 0.5, 1e-3);
  EXPECT_NEAR(pt.p, -0.6e9, 1e6);
  // closed a little: unloads along the equation of state as soon as that bears less, and does not heal
  const double damage = pt.damage;
  for (int n = 0; n < 7000; ++n) step(m, Inc{{-1e-5, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_GT(pt.p, -0.6e9);
  EXPECT_EQ(pt.damage, damage);
}

TEST(Update, PartingTakesTheFractureEnergyAtEverySize) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  for (const double edge : {0.02e-3, 0.1e-3, 0.4e-3}) {
    auto pt = virgin(m);
    pt.m = m.rho_0 * edge * edge * edge;
    const double d = 1e-6;
    double work = 0;  // of the tension, a unit of volume, from where it begins to tear
    while (pt.damage < 1) {
      const double before = pt.p;
      const bool tears = pt.damage > 0;
      step(m, Inc{{d, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
      if (tears) work -= 0.5 * (before + pt.p) * d;
    }
    EXPECT_NEAR(work * edge, 8200, 0.01 * 8200) << edge;
  }
}

TEST(Update, WeakenedMatterTearsEarlier) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  auto pt = virgin(m);
  pt.damage = 0.75;
  while (pt.damage == 0.75) step(m, Inc{{1e-5, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
  EXPECT_NEAR(pt.p, -0.3e9, 2e6);
}

// Half molten, half of the work: the tension is half gone after 13.67/4 um, 0.0342 of an edge of 0.1 mm. Liquid: at once.
TEST(Update, WhatIsMoltenTakesNoFractureEnergy) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  m.e_melt = 0.5e6;
  m.e_melted = 1.0e6;
  const Inc pull{{1e-5, 0, 0, 0, 0, 0}, {0, 0, 0}};
  auto mush = virgin(m), liquid = virgin(m);
  mush.m = liquid.m = m.rho_0 * 1e-12;
  mush.e = 0.75e6;
  liquid.e = 1.2e6;
  while (mush.damage == 0) step(m, pull, 1e-9, mush);
  for (int n = 0; n < 3417; ++n) step(m, pull, 1e-9, mush);
  EXPECT_NEAR(mush.damage, 0.5, 1e-3);
  EXPECT_NEAR(mush.p, -0.6e9, 1e6);
  int steps = 0;
  while (liquid.damage < 1) {
    step(m, pull, 1e-9, liquid);
    if (liquid.damage > 0) ++steps;
  }
  EXPECT_LE(steps, 2);
  EXPECT_EQ(liquid.p, 0.0);
}

// Copper melts at one temperature: begin and end stand here for one energy, below which all is solid and above which all is liquid. A step
// opens 1e-5 of the edge of 0.1 mm, and the solid parts at 2 x 8200 / 1.2e9 m, 13.667 um, the liquid at a ten-thousandth of it.
TEST(Update, WhatMeltsAtOnceIsSolidUpToThere) {
  auto m = aluminium(jc_2024());
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  m.e_melt = m.e_melted = 0.5e6;
  for (const auto& [e, opening] : {std::pair{0.4999e6, 13.667e-6}, {0.5001e6, 1.3667e-9}}) {
    auto pt = virgin(m);
    pt.m = m.rho_0 * 1e-12;
    pt.e = e;
    while (pt.damage == 0) step(m, Inc{{1e-5, 0, 0, 0, 0, 0}, {0, 0, 0}}, 1e-9, pt);
    EXPECT_NEAR(pt.damage, 1e-9 / opening, 1e-4 / opening * 1e-9) << e;
  }
}
