// SPDX-License-Identifier: Apache-2.0
// Flow laws against figures evaluated outside from the papers' equations; tolerance round-off.
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/material/materials.hpp"

using material::flow;
using State = material::FlowState<double>;

TEST(JohnsonCook, StaticYieldAtRoomTemperature) {
  EXPECT_EQ(flow(jc_2024(), State{1, 0, 294, 0.5})(0.0).Y, 265e6);
}

TEST(JohnsonCook, HardensWithStrainAndRate) {  // (265 + 426 0.1^0.34)(1 + 0.015 ln 1e4) MPa
  EXPECT_NEAR(flow(jc_2024(), State{1, 0, 294, 1e4})(0.1).Y, 523232174.33720416, 1e-5);
}

TEST(JohnsonCook, SoftensHalfWayToMelting) {  // (265 + 426 0.5^0.34)(1 + 0.015 ln 1e5)(1 - 0.5)
  EXPECT_NEAR(flow(jc_2024(), State{1, 0, 534.5, 1e5})(0.5).Y, 352721457.9155761, 1e-5);
}

TEST(JohnsonCook, SoftensWithAnExponent) {  // (90 + 292 0.3^0.31)(1 + 0.025 ln 1e4)(1 - 0.5^1.09)
  EXPECT_NEAR(flow(jc_copper(), State{1, 0, 825, 1e4})(0.3).Y, 189856697.42279163, 1e-5);
}

TEST(JohnsonCook, ColdIsNotHarderThanRoomTemperature) {
  EXPECT_EQ(flow(jc_2024(), State{1, 0, 100, 1})(0.0).Y, 265e6);
}

TEST(JohnsonCook, MeltedHasNeitherStrengthNorStiffness) {
  const auto f = flow(jc_2024(), State{1, 0, 775, 1e4});
  EXPECT_EQ(f.G, 0.0);
  EXPECT_EQ(f(0.3).Y, 0.0);
}

TEST(SteinbergGuinan, PressureHardensAndHeatSoftens) {  // eta 1.2, 20 GPa, 600 K, eps 0.05
  const auto f = flow(sg_2024(), State{1.2, 20e9, 600, 1e6});
  EXPECT_NEAR(f.G, 58410094075.500626, 1e-3);
  EXPECT_NEAR(f(0.05).Y, 891927902.3169729, 1e-4);
}

TEST(SteinbergGuinan, HardeningSaturates) {  // 0.854 GPa uncapped at eps 2: Y_max (0.76 GPa) times the factor
  const auto f = flow(sg_2024(), State{1.2, 20e9, 600, 1e6});
  EXPECT_NEAR(f(2.0).Y, 1552156346.0622544, 1e-4);
  EXPECT_EQ(f(2.0).slope, 0.0);
}

TEST(SteinbergGuinan, StrainBeforeTheStartHardensToo) {  // 0.26 [1 + 310 (0.02 + 0.01)]^0.185 GPa times f at eta 1.1, 10 GPa, 450 K
  auto s = sg_2024();
  s.eps_i = 0.01;
  EXPECT_NEAR(flow(s, State{1.1, 10e9, 450, 1e6})(0.02).Y, 616093371.3376888, 1e-4);
}

TEST(SteinbergGuinan, ColdIsHarderThanTheReference) {  // f = 1 + 0.616e-3 (300 - 100): unlike Johnson & Cook's law it is not held
  const auto f = flow(sg_2024(), State{1, 0, 100, 1e6});
  EXPECT_NEAR(f.G, 32123520000.0, 1e-3);
  EXPECT_NEAR(f(0.02).Y, 420762430.0003383, 1e-4);
}

/// The slopes of a flow law against central differences over h.
template <class Flow>
void expect_slopes(const Flow& f, double eps) {
  const double h = 1e-5;
  const auto at = f(eps), above = f(eps + h), below = f(eps - h);
  EXPECT_NEAR(at.slope, (above.Y - below.Y) / (2 * h), 1e-6 * std::abs(at.slope));
  EXPECT_NEAR(at.bend, (above.slope - below.slope) / (2 * h), 1e-6 * std::abs(at.bend));
  EXPECT_LT(at.bend, 0);
}

TEST(FlowLaws, SlopesAreDerivatives) {
  expect_slopes(flow(jc_2024(), State{1, 0, 400, 1e4}), 0.1);
  expect_slopes(flow(sg_2024(), State{1.2, 20e9, 600, 1e6}), 0.05);
  expect_slopes(flow(za_iron(), State{1, 0, 400, 1e3}), 0.1);
  expect_slopes(flow(za_copper(), State{1, 0, 400, 1e3}), 0.1);
}

TEST(SteinbergGuinan, MeltsOnItsCurve) {  // 1220 exp(3 (1 - 1/1.2)) 1.2^(2 (2 - 1.5 - 1/3))
  const double T_melt = material::melting_temperature(sg_2024(), 1.2);
  EXPECT_NEAR(T_melt, 2137.4738995338244, 1e-9);
  EXPECT_GT(flow(sg_2024(), State{1.2, 90e9, T_melt - 0.01, 1})(0.1).Y, 0.0);
  const auto melted = flow(sg_2024(), State{1.2, 90e9, T_melt + 0.01, 1});
  EXPECT_EQ(melted.G, 0.0);
  EXPECT_EQ(melted(0.1).Y, 0.0);
}

TEST(SteinbergGuinan, FarTensionDoesNotTurnNegative) {
  EXPECT_EQ(flow(sg_2024(), State{0.7, -1e12, 300, 1}).G, 0.0);
}

TEST(ZerilliArmstrong, HardeningOfCopperSoftensWithHeat) {  // 65 + 890 sqrt(0.3) exp(400 (-0.0028 + 0.000115 ln 1e4)) MPa
  EXPECT_NEAR(flow(za_copper(), State{1, 0, 400, 1e4})(0.3).Y, 307963376.42318416, 1e-5);
  EXPECT_EQ(flow(za_copper(), State{1, 0, 400, 1e4})(0.0).Y, 65e6);
}

TEST(ZerilliArmstrong, YieldOfIronSoftensWithHeat) {  // 65 + 1033 exp(350 (-0.00698 + 0.000415 ln 1e3)) + 266 0.2^0.289 MPa
  EXPECT_NEAR(flow(za_iron(), State{1, 0, 350, 1e3})(0.2).Y, 476895033.6599567, 1e-5);
}

TEST(ZerilliArmstrong, RateIsPerSecond) {  // ln 1 = 0: 65 + 890 sqrt(0.04) exp(-0.0028 294) MPa
  EXPECT_NEAR(flow(za_copper(), State{1, 0, 294, 1})(0.04).Y, 143146365.59564495, 1e-5);
}

TEST(ZerilliArmstrong, FastestRatesAreNotHelpedByHeat) {  // above exp(0.0028/0.000115)/s: 65 + 890 sqrt(0.3) MPa
  EXPECT_NEAR(flow(za_copper(), State{1, 0, 400, 1e11})(0.3).Y, 552473076.1795979, 1e-5);
}

TEST(ZerilliArmstrong, AtRestOnlyTheAthermalPartIsLeft) {
  EXPECT_NEAR(flow(za_copper(), State{1, 0, 294, 0})(0.3).Y, 65e6, 0.1);  // ln of the smallest rate is -691
}

TEST(ZerilliArmstrong, MeltedHasNeitherStrengthNorStiffness) {
  const auto f = flow(za_iron(), State{1, 0, 1811, 1e4});
  EXPECT_EQ(f.G, 0.0);
  EXPECT_EQ(f(0.3).Y, 0.0);
}

TEST(FlowLaws, SlopeIsTheDerivative) {
  const auto check = [](const auto& f) {
    for (double eps : {1e-4, 0.01, 0.5}) {
      const double h = 1e-5 * eps;  // central difference, error h^2
      EXPECT_NEAR(f(eps).slope, (f(eps + h).Y - f(eps - h).Y) / (2 * h), 1e-5 * f(eps).slope);
    }
  };
  check(flow(jc_2024(), State{1, 0, 400, 1e5}));
  check(flow(sg_2024(), State{1.1, 10e9, 400, 1e5}));
  check(flow(za_copper(), State{1, 0, 400, 1e5}));
  check(flow(za_iron(), State{1, 0, 400, 1e5}));
}

TEST(Strength, ShearModulusOfEveryLaw) {
  EXPECT_EQ(material::shear_modulus(material::NoStrength{}), 0.0);
  EXPECT_EQ(material::shear_modulus(material::PerfectlyPlastic{5e9, 1e8}), 5e9);
  EXPECT_EQ(material::shear_modulus(jc_2024()), 28.6e9);
  EXPECT_EQ(material::shear_modulus(sg_2024()), 28.6e9);
  EXPECT_EQ(material::shear_modulus(za_copper()), 47.7e9);
}

TEST(Strength, MeaninglessConstantsAreRefused) {
  EXPECT_THROW(aluminium(material::PerfectlyPlastic{0, 1e8}), core::CaseError);
  auto cold = jc_2024();
  cold.T_melt = 200;
  EXPECT_THROW(aluminium(cold), core::CaseError);
  auto convex = za_iron();
  convex.n = 1.5;
  EXPECT_THROW(aluminium(convex), core::CaseError);
}
