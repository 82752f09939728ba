// SPDX-License-Identifier: Apache-2.0
#include "eos/mie_grueneisen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eos/hugoniot.hpp"
#include "tests/eos/models.hpp"

TEST(MieGrueneisen, ReferenceStateIsExact) {
  const auto s = eos::state(aluminium_2024(), 2785.0, 0.0);
  EXPECT_EQ(s.p, 0.0);
  EXPECT_NEAR(s.temperature, 294.0, 1e-12);
  EXPECT_NEAR(s.c2, 5328.0 * 5328.0, 1e-6);
}

TEST(MieGrueneisen, PressureInCompression) {
  // the form in mu of the LS-DYNA manual, evaluated outside: mu = 0.2, e = 2 MJ/kg; tolerance round-off
  EXPECT_NEAR(eos::state(aluminium_2024(), 1.2 * 2785, 2e6).p, 29687872653.061226, 1.0);
}

TEST(MieGrueneisen, PressureWithAllThreeSlopes) {
  EXPECT_NEAR(eos::state(hafnium(), 1.25 * 13300, 3e5).p, 36563013762.86684, 1.0);
}

TEST(MieGrueneisen, PressureInExpansion) {
  // rho_0 c_0^2 mu eta^2 + rho gamma (e - c_0^2 mu^2/2) at mu = -0.1, e = 1 MJ/kg, evaluated outside
  EXPECT_NEAR(eos::state(aluminium_2024(), 0.9 * 2785, 1e6).p, -1836804144.1520643, 1.0);
}

TEST(MieGrueneisen, PressureBeyondTheGuardIsTheTangentOfTheHugoniot) {
  // (gamma_0 + a mu) x = 1.8 where 1.52 x^2 - 3.8 x + 1.8 = 0: x_g = 0.63495, before 0.9 of the pole at 1/1.338. There half of the
  // Grueneisen term takes 0.9 of p_H = rho_0 c_0^2 x/(1 - s x)^2, and from there p rises by rho_0 c_0^2 (1 + s x_g)/(1 - s x_g)^3.
  const double x_g = (3.8 - std::sqrt(3.8 * 3.8 - 4 * 1.52 * 1.8)) / (2 * 1.52), D = 1 - 1.338 * x_g, K = 2785 * 5328.0 * 5328.0;
  const double e = 3e7, at_guard = 0.1 * K * x_g / (D * D) + 1.8 / x_g * 2785 * e, slope = K * (1 + 1.338 * x_g) / (D * D * D);
  for (const double x : {0.65, 0.8}) {
    const double p = at_guard + slope * (x - x_g);
    EXPECT_NEAR(eos::state(aluminium_2024(), 2785 / (1 - x), e).p, p, 1e-9 * p);
  }
}

TEST(MieGrueneisen, TemperatureInExpansion) {
  // T_0 exp(integral of gamma/eta from 1 to 1 - u) + (e - c_0^2 u^2/2)/cv, integrated outside by Simpson's rule. u is the expansion where
  // heat has driven it (0.05), what heat alone drives, 2 e/c_0^2 = 0.0705, where it is more, or 0.02136 of 3e5 J/kg
  EXPECT_NEAR(eos::state(aluminium_2024(), 0.95 * 2785, 1e6).temperature, 1367.150081610671, 1e-6);
  EXPECT_NEAR(eos::state(aluminium_2024(), 0.9 * 2785, 1e6).temperature, 1315.4568375273652, 1e-6);
  EXPECT_NEAR(eos::state(aluminium_2024(), 0.5 * 2785, 3e5).temperature, 617.2194587348993, 1e-6);
}

TEST(MieGrueneisen, SmallTensionIsLinear) {
  const double mu = -1e-4, p = eos::state(aluminium_2024(), 2785 * (1 + mu), 0.0).p;
  EXPECT_NEAR(p, 2785 * 5328.0 * 5328.0 * mu, 2e-4 * std::abs(p));  // the next term is of order mu
}

TEST(MieGrueneisen, PressureAndSoundSpeedAreContinuousAtReferenceDensity) {
  const auto m = aluminium_2024();
  for (double e : {0.0, 1e6, 1e7}) {
    const auto below = eos::state(m, 2785 * (1 - 1e-9), e), above = eos::state(m, 2785 * (1 + 1e-9), e);
    EXPECT_NEAR(below.p, above.p, 1e-8 * (8e10 + above.p));
    EXPECT_NEAR(below.c2, above.c2, 1e-7 * above.c2);
    EXPECT_NEAR(below.temperature, above.temperature, 1e-6 * above.temperature);
  }
}

TEST(MieGrueneisen, HotThinMatterIsAnIdealGas) {
  const auto m = aluminium_2024();
  const double e = 5e7, cohesion = 5328.0 * 5328.0 / 2;
  double last = 1e300;
  for (double eta : {1.0, 0.5, 0.1, 1e-2, 1e-4, 1e-8}) {
    const double p = eos::state(m, eta * 2785, e).p;
    EXPECT_GT(p, 0.0);
    EXPECT_LT(p, last);
    last = p;
  }
  // p -> 2/3 rho (e - cohesion), error of order eta
  EXPECT_NEAR(last, 2.0 / 3.0 * 2785e-8 * (e - cohesion), 1e-6 * last);
}

TEST(MieGrueneisen, TemperatureOnTheHugoniot) {
  // Walsh & Christian, Phys. Rev. 97 (1955) 1544, eq. 11: dT = -T gamma/v dv + [(v_0 - v) dp + p dv]/(2 cv) along the
  // Hugoniot, integrated outside with 20000 Runge-Kutta steps. Tolerance: the polynomial for e_s.
  const double rows[][2] = {{500, 359.3520698716337},   {1000, 485.8829931215751},  {2000, 1119.646469706012},
                            {4000, 4791.536795101496},  {5000, 8128.701808051409},  {8000, 24968.81216105673}};
  for (const auto& r : rows) EXPECT_NEAR(eos::hugoniot(aluminium_2024(), 2785, r[0]).temperature, r[1], 1e-6 * r[1]);
}

TEST(MieGrueneisen, ColdEnergyIsAbsoluteZero) {
  const auto m = aluminium_2024();
  for (double eta : {0.3, 0.985, 1.0, 1.3, 2.0, 2.5}) {
    const double e = eos::cold_energy(m, eta * 2785);
    EXPECT_NEAR(eos::state(m, eta * 2785, e).temperature, 0.0, 1e-6 * (294 + std::abs(e) / 875));
    EXPECT_GT(eos::state(m, eta * 2785, e + 875).temperature, 0.99);
  }
  EXPECT_NEAR(eos::cold_energy(m, 2785), -875 * 294, 1e-6);
}

TEST(MieGrueneisen, SeparatedDebrisKeepsItsTemperature) {
  // 0.5 MJ/kg at any density below the hot solid's: a solid at zero pressure with voids between its pieces
  const auto m = aluminium_2024();
  const double T = eos::state(m, 0.5 * 2785, 5e5).temperature;
  EXPECT_EQ(eos::state(m, 0.01 * 2785, 5e5).temperature, T);
  EXPECT_NEAR(T, 294 + 5e5 / 875.0, 60);  // less the work of thermal expansion, some 5 %
}

TEST(MieGrueneisen, TemperatureOfDebrisRisesWithEnergy) {
  double last = 0;
  for (double e = 0; e < 4e7; e += 1e5) {
    const double T = eos::state(aluminium_2024(), 30.0, e).temperature;
    EXPECT_GT(T, last);
    last = T;
  }
}

TEST(MieGrueneisen, FiniteAndRisingThroughThePole) {
  for (const auto& m : {aluminium_2024(), copper(), iron(), hafnium()}) {
    double last = -1;
    for (double eta = 1; eta < 20; eta *= 1.01) {
      // along a path with at least the energy of the Hugoniot, as any compressed state has
      const double x = std::min(1 - 1 / eta, m.x_guard), D = 1 - x * (m.s_1 + x * (m.s_2 + x * m.s_3));
      const auto s = eos::state(m, eta * m.rho_0, m.c_0 * m.c_0 * x * x / (2 * D * D));
      EXPECT_TRUE(std::isfinite(s.p) && std::isfinite(s.temperature));
      EXPECT_GT(s.p, last);
      EXPECT_GT(s.c2, 0);
      last = s.p;
    }
  }
}

TEST(MieGrueneisen, MeaninglessConstantsAreRefused) {
  eos::MieGrueneisen m{.rho_0 = 2785, .c_0 = 0, .s_1 = 1.3, .gamma_0 = 2, .cv = 875};
  EXPECT_THROW(eos::prepare(m), core::CaseError);
}
