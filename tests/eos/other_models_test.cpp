// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/eos/models.hpp"

// Formulas of Melosh (1989), appendix II, evaluated outside; tolerance round-off.
TEST(Tillotson, Compressed) { EXPECT_NEAR(eos::state(aluminium_tillotson(), 3600.0, 5e6).p, 60066488888.88888, 1.0); }
TEST(Tillotson, ExpandedCold) { EXPECT_NEAR(eos::state(aluminium_tillotson(), 2600.0, 1e6).p, 2090091461.7149034, 1.0); }
TEST(Tillotson, ExpandedHot) { EXPECT_NEAR(eos::state(aluminium_tillotson(), 1500.0, 2e7).p, 15117831954.27483, 1.0); }
TEST(Tillotson, Intermediate) { EXPECT_NEAR(eos::state(aluminium_tillotson(), 2250.0, 8e6).p, 9603336800.960981, 1.0); }

// Between 0.8 and 0.5 of rho_0 the condensed branch is times t^2 (3 - 2t), t = (eta - 0.5)/0.3, evaluated outside: t = 0.5 and 0.8.
TEST(Tillotson, ExpandedColdFading) {
  EXPECT_NEAR(eos::state(aluminium_tillotson(), 0.65 * 2700, 1e6).p, -7769217168.6747, 1.0);
  EXPECT_NEAR(eos::state(aluminium_tillotson(), 0.74 * 2700, 2e6).p, -8418801582.304771, 1.0);
}

TEST(Tillotson, NegativeEnergyCountsWithAllOfB) {  // (0.5 + 1.63) 2800 (-1e5) + A mu + B mu^2, mu = 1/27
  EXPECT_NEAR(eos::state(aluminium_tillotson(), 2800.0, -1e5).p, 2277948422.496566, 1.0);
}

TEST(Tillotson, ContinuousAcrossEveryBorder) {
  const auto m = aluminium_tillotson();
  const auto jump = [&](double rho, double e, double drho, double de) {
    return std::abs(eos::state(m, rho + drho, e + de).p - eos::state(m, rho - drho, e - de).p);
  };
  // steps of 1e-9 relative change p by about 1e-9 times 1e11 Pa; a jump would be of order 1e8 and more
  for (double e : {1e6, 5e6, 2e7}) EXPECT_LT(jump(2700, e, 2.7e-6, 0), 2e3);
  for (double rho : {300.0, 1500.0, 2600.0})
    for (double e : {m.E_iv, m.E_cv}) EXPECT_LT(jump(rho, e, 0, 1e-9 * e), 2e3);
  for (double eta : {0.5, 0.8}) EXPECT_LT(jump(eta * 2700, 1e6, 2.7e-6, 0), 2e3);
}

TEST(Tillotson, ColdThinMatterDoesNotPull) {
  const auto s = eos::state(aluminium_tillotson(), 270.0, 0.0);
  EXPECT_EQ(s.p, 0.0);
  EXPECT_GT(s.c2, 0.0);
}

TEST(Tillotson, ThinLiquidDoesNotPush) {
  for (double eta : {0.05, 0.3, 0.5})
    for (double e : {0.5e6, 1.5e6, 3e6}) EXPECT_EQ(eos::state(aluminium_tillotson(), eta * 2700, e).p, 0.0);
}

TEST(Tillotson, ALiquidThatPartsIntoDropsKeepsItsHeat) {
  // Released from a shock of some 75 GPa along de = p drho/rho^2; a liquid bears no tension. What is left at p = 0 is what stays.
  const auto m = aluminium_tillotson();
  double rho = 1.45 * 2700, e = 4.5e6, at_rest = 0;
  while (rho > 0.05 * 2700) {
    const double p = eos::state(m, rho, e).p, drho = 1e-4 * rho;
    if (p <= 0 && at_rest == 0) at_rest = e;
    e -= std::max(p, 0.0) * drho / (rho * rho);
    rho -= drho;
  }
  EXPECT_GT(at_rest, 0.0);
  EXPECT_LT(at_rest, m.E_iv);
  EXPECT_EQ(e, at_rest);
}

TEST(Tillotson, ColdEnergyIsAbsoluteZero) {
  const auto m = aluminium_tillotson();
  for (double eta : {0.3, 1.0, 1.5, 2.5})
    EXPECT_NEAR(eos::state(m, eta * 2700, eos::cold_energy(m, eta * 2700)).temperature, 0.0, 1e-2);
}

TEST(Polynomial, ReferenceIsentropeOfAPureGrueneisenSolid) {
  // p = C1 mu + g rho_0 e with g = 2: ln(T_s/T_0) = g x, and e_s solves de/dx = (C1/rho_0) x/(1-x) + g e
  eos::Polynomial m{.rho_0 = 2700, .C1 = 75e9, .C4 = 2, .cv = 900};
  eos::prepare(m);
  for (double x : {0.1, 0.3, 0.6}) EXPECT_NEAR(m.isentrope.heating(x), 2 * x, 1e-12);
  // e_s = exp(2x) (C1/rho_0) int_0^x y/(1-y) exp(-2y) dy by Simpson's rule
  const double x = 0.5;
  const auto f = [](double y) { return y / (1 - y) * std::exp(-2 * y); };
  const int n = 2000;
  double sum = f(0) + f(x);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(x * i / n);
  const double e_s = std::exp(2 * x) * 75e9 / 2700 * sum * x / n / 3;
  EXPECT_NEAR(m.isentrope.energy(x), e_s, 1e-6 * e_s);  // the polynomial over 0 <= x <= 0.8
}

TEST(Polynomial, Pressure) {
  // mu = 0.5, e = 1 MJ/kg: 37.5 + 15 + 11.25 GPa + (2 + 0.25 + 0.075) 2700 1e6
  EXPECT_NEAR(eos::state(cubic(), 1.5 * 2700, 1e6).p, 63.75e9 + 2.325 * 2.7e9, 1.0);
  // mu = -0.2: the even terms are off: -15 - 0.72 GPa + 1.9 2.7e9
  EXPECT_NEAR(eos::state(cubic(), 0.8 * 2700, 1e6).p, -15.72e9 + 1.9 * 2.7e9, 1.0);
}

TEST(Polynomial, IsTheIdealGasWithTwoCoefficients) {
  eos::Polynomial m{.rho_0 = 1.2, .C4 = 0.4, .C5 = 0.4, .cv = 718};
  eos::prepare(m);
  for (double rho : {0.3, 1.2, 5.0}) {
    const auto a = eos::state(m, rho, 2e5), b = eos::state(eos::IdealGas{1.4, 718}, rho, 2e5);
    EXPECT_NEAR(a.p, b.p, 1e-12 * b.p);
    EXPECT_NEAR(a.c2, b.c2, 1e-12 * b.c2);
  }
}

TEST(IdealGas, Values) {
  const auto s = eos::state(eos::IdealGas{5.0 / 3.0, 300}, 2.0, 3e5);
  EXPECT_NEAR(s.p, 4e5, 1e-9);
  EXPECT_NEAR(s.c2, 5.0 / 3.0 * 2.0 / 3.0 * 3e5, 1e-9);
  EXPECT_NEAR(s.temperature, 1000, 1e-12);
  EXPECT_EQ(eos::state(eos::IdealGas{}, 2.0, -1.0).p, 0.0);
}

TEST(IdealGas, GammaOfOneIsRefused) {
  eos::Eos gas = eos::IdealGas{1.0, 718};
  EXPECT_THROW(eos::prepare(gas), core::CaseError);
}
