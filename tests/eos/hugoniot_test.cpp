// SPDX-License-Identifier: Apache-2.0
// The Hugoniot solver against states that follow by hand from a linear shock-speed law, whatever gamma is:
// Us = c_0 + s up, p = rho_0 Us up, rho = rho_0 Us/(Us - up), e = up^2/2.
#include "eos/hugoniot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "tests/eos/models.hpp"

namespace {

struct Row {
  double up, Us, p_GPa, rho;
};

// Symmetric impact of 2024 aluminium, rho_0 2785, c_0 5328, s 1.338 (constants: Marsh, LASL Shock Hugoniot Data, 1980).
// Figures rounded to the digits shown.
constexpr Row aluminium_rows[] = {{250, 5662.5, 3.9425, 2913.6},    {500, 5997.0, 8.3508, 3038.3},
                                  {1000, 6666.0, 18.5648, 3276.5},  {2000, 8004.0, 44.5823, 3712.7},
                                  {3500, 10011.0, 97.5822, 4282.1}, {4000, 10680.0, 118.9752, 4452.7},
                                  {5000, 12018.0, 167.3507, 4769.2}};
// OFHC copper, rho_0 8930, c_0 3940, s 1.489 (Steinberg, UCRL-MA-106439, 1996).
constexpr Row copper_rows[] = {{500, 4684.5, 20.9163, 9997.0},
                               {2000, 6918.0, 123.5555, 12561.6},
                               {5000, 11385.0, 508.3403, 15923.0}};

void compare(const eos::Eos& model, double rho_0, double c_0, double s, const Row& row) {
  const auto h = eos::hugoniot(model, rho_0, row.up);
  EXPECT_NEAR(h.Us, row.Us, 0.051);             // printed to 0.1 m/s
  EXPECT_NEAR(h.p * 1e-9, row.p_GPa, 0.51e-4);  // printed to 1e-4 GPa
  EXPECT_NEAR(h.rho, row.rho, 0.051);           // printed to 0.1 kg/m3
  const double Us = c_0 + s * row.up;
  EXPECT_NEAR(h.Us, Us, 1e-9 * Us);  // closed form; the solver goes to the last bit of x
  EXPECT_NEAR(h.p, rho_0 * Us * row.up, 1e-9 * h.p);
  EXPECT_NEAR(h.rho, rho_0 * Us / (Us - row.up), 1e-9 * h.rho);
  EXPECT_NEAR(h.e, 0.5 * row.up * row.up, 1e-9 * h.e);
}

}  // namespace

TEST(Hugoniot, LinearShockSpeedAluminium) {
  for (const Row& row : aluminium_rows) compare(aluminium_2024(), 2785, 5328, 1.338, row);
}

TEST(Hugoniot, LinearShockSpeedCopper) {
  for (const Row& row : copper_rows) compare(copper(), 8930, 3940, 1.489, row);
}

TEST(Hugoniot, CubicShockSpeedSatisfiesItsOwnLaw) {
  for (double up : {100.0, 600.0, 1500.0}) {
    const auto h = eos::hugoniot(hafnium(), 13300, up);
    const double x = up / h.Us;
    EXPECT_NEAR(h.Us, 2980 + 1.448 * up - 3.852 * x * up + 7.0 * x * x * up, 1e-8 * h.Us);
  }
}

TEST(Hugoniot, IdealGasStrongShock) {
  // Rankine-Hugoniot for gamma = 1.4, p_0 = 1e5 Pa, rho_0 = 1.2: Us from Us^2 - (gamma+1)/2 up Us - c_0^2 = 0
  const eos::IdealGas air{1.4, 718};
  const double rho_0 = 1.2, e_0 = 1e5 / (0.4 * rho_0), c2 = 1.4 * 1e5 / rho_0;
  for (double up : {50.0, 500.0, 5000.0}) {
    const auto h = eos::hugoniot(air, rho_0, up, e_0);
    const double Us = 0.6 * up + std::sqrt(0.36 * up * up + c2);
    EXPECT_NEAR(h.Us, Us, 1e-9 * Us);
    EXPECT_NEAR(h.p, 1e5 + rho_0 * Us * up, 1e-9 * h.p);
    EXPECT_NEAR(h.rho, rho_0 * Us / (Us - up), 1e-8 * h.rho);
  }
}

TEST(Hugoniot, TillotsonSatisfiesTheJumpConditions) {
  const auto m = aluminium_tillotson();
  for (double up : {200.0, 2000.0, 8000.0}) {
    const auto h = eos::hugoniot(m, 2700, up);
    EXPECT_NEAR(h.p, 2700 * h.Us * up, 1e-9 * h.p);
    EXPECT_NEAR(h.rho * (h.Us - up), 2700 * h.Us, 1e-9 * 2700 * h.Us);
    EXPECT_NEAR(eos::state(m, h.rho, h.e).p, h.p, 1e-8 * h.p);
  }
}

TEST(Hugoniot, SymmetricImpactSplitsTheVelocity) {
  EXPECT_NEAR(eos::impact_pressure(aluminium_2024(), 2785, aluminium_2024(), 2785, 8000) * 1e-9, 118.9752, 0.51e-4);
}

TEST(Hugoniot, ImpactOfAluminiumOnCopper) {
  // intersection of rho (c + s u) u for copper and the reflected curve for aluminium at 5 km/s, solved outside
  const double p = 92444397219.74805;
  EXPECT_NEAR(eos::impact_pressure(aluminium_2024(), 2785, copper(), 8930, 5000), p, 1e-8 * p);
  EXPECT_NEAR(eos::impact_pressure(copper(), 8930, aluminium_2024(), 2785, 5000), p, 1e-8 * p);
}

TEST(Hugoniot, ObliqueImpactBeforeJetting) {
  // aluminium on itself at 8 km/s: attached shocks of Us = c_0 + s up, solved outside:
  // 30.087 degrees, 185.9 GPa there, where a flat impact has 119.0
  const auto own = eos::onset_of_jetting(aluminium_2024(), 2785, aluminium_2024(), 2785, 8000);
  EXPECT_NEAR(own.angle * 180 / std::numbers::pi, 30.087, 0.01);
  EXPECT_NEAR(own.p * 1e-9, 185.9, 1);
  // harder to jet the slower
  EXPECT_GT(eos::onset_of_jetting(aluminium_2024(), 2785, aluminium_2024(), 2785, 12000).angle, own.angle);
  const auto copper_on_aluminium = eos::onset_of_jetting(copper(), 8930, aluminium_2024(), 2785, 8000);
  EXPECT_GT(copper_on_aluminium.p, eos::impact_pressure(copper(), 8930, aluminium_2024(), 2785, 8000));
}

TEST(Hugoniot, ObliqueImpactOfSlowSoftAndHardBodies) {
  // attached shocks of Us = c_0 + s up, solved outside; matter is sped up by more than the closing speed before it jets
  eos::MieGrueneisen foam{.rho_0 = 100, .c_0 = 500, .s_1 = 1.2, .gamma_0 = 0.5, .a = 0, .cv = 1500};
  eos::prepare(foam);
  const auto expect = [](const eos::Eos& a, double rho_0_a, const eos::Eos& b, double rho_0_b, double v, double degrees, double GPa) {
    const auto jet = eos::onset_of_jetting(a, rho_0_a, b, rho_0_b, v);
    EXPECT_NEAR(jet.angle * 180 / std::numbers::pi, degrees, 1e-3 * degrees) << v;
    EXPECT_NEAR(jet.p * 1e-9, GPa, 0.02 * GPa) << v;  // steps of 1 % in up
  };
  expect(aluminium_2024(), 2785, aluminium_2024(), 2785, 50, 0.5115, 2.110);
  expect(aluminium_2024(), 2785, aluminium_2024(), 2785, 200, 1.9036, 5.714);
  expect(aluminium_2024(), 2785, copper(), 8930, 3000, 16.839, 82.36);
  expect(copper(), 8930, aluminium_2024(), 2785, 3000, 16.263, 80.46);
  expect(foam, 100, copper(), 8930, 200, 2.9055, 0.01499);
  expect(foam, 100, copper(), 8930, 3000, 36.249, 1.5547);
}

TEST(Hugoniot, ObliqueImpactNearTheEndOfTheRange) {
  // 25 km/s is beyond the shocks that the model covers, a flat impact at that speed is not
  EXPECT_THROW(eos::hugoniot(aluminium_2024(), 2785, 25000), core::CaseError);
  const double flat = eos::impact_pressure(aluminium_2024(), 2785, aluminium_2024(), 2785, 25000);
  EXPECT_GT(eos::onset_of_jetting(aluminium_2024(), 2785, aluminium_2024(), 2785, 25000).p, flat);
  EXPECT_EQ(eos::onset_of_jetting(aluminium_2024(), 2785, aluminium_2024(), 2785, 200000).p, 0) << "no jetting within the range";
}

TEST(Hugoniot, ImpactBeyondTheRangeHasNoPressure) {
  EXPECT_EQ(eos::impact_pressure(aluminium_2024(), 2785, aluminium_2024(), 2785, 200000), 0);
  // copper covers less than v, the answer lies below
  const double p = eos::impact_pressure(aluminium_2024(), 2785, copper(), 8930, 25000);
  EXPECT_THROW(eos::hugoniot(copper(), 8930, 25000), core::CaseError);
  EXPECT_GT(p, eos::impact_pressure(aluminium_2024(), 2785, copper(), 8930, 24000));
}

TEST(Hugoniot, BeyondTheRangeIsRefused) {
  EXPECT_THROW(eos::hugoniot(aluminium_2024(), 2785, 1e6), core::CaseError);
}

TEST(Hugoniot, PoleOfTheShockSpeed) {
  // D = 1 - s x = 0 at x = 1/s: rho_max = rho_0 s/(s - 1)
  EXPECT_NEAR(eos::max_density(eos::Eos(aluminium_2024())), 2785 * 1.338 / 0.338, 1e-6);
  EXPECT_EQ(eos::max_density(eos::Eos(aluminium_tillotson())), 1e300);
}
