// SPDX-License-Identifier: Apache-2.0
// Thomas-Fermi atoms against known limits, and the wide-range aluminium against what is measured.
#include "eos/wide_range.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "core/error.hpp"
#include "eos/hugoniot.hpp"

namespace {

struct Aluminium {
  eos::WideRange model{eos::find_metal("Al")};
  eos::SesameMaterial source = model.table();
  eos::Sesame table;
  Aluminium() {
    const auto file = std::filesystem::temp_directory_path() / ("wide_range_test_" + std::to_string(::getpid()) + ".ses");
    std::ofstream(file) << eos::sesame_text(source);
    table.file = file.string(), table.number = source.number;
    eos::prepare(table);
    std::filesystem::remove(file);
  }
};

const Aluminium& aluminium() {
  static const Aluminium al;
  return al;
}

}  // namespace

TEST(ThomasFermi, FermiIntegrals) {
  // SciPy: quad of x^k/(1 + exp(x - eta))
  EXPECT_NEAR(eos::fermi_integrals(0).half, 0.6780938951531010, 1e-9);
  EXPECT_NEAR(eos::fermi_integrals(0).three_halves, 1.1528038370883613, 1e-9);
  for (const double eta : {-12.0, 60.0}) {  // seams to the expansions
    const auto a = eos::fermi_integrals(eta - 1e-9), b = eos::fermi_integrals(eta + 1e-9);
    EXPECT_NEAR(a.half, b.half, 3e-8 * a.half);
    EXPECT_NEAR(a.three_halves, b.three_halves, 3e-8 * a.three_halves);
  }
}

TEST(ThomasFermi, FreeAtom) {
  // E = -0.768745 Z^(7/3) hartree (Lieb, Rev. Mod. Phys. 53 (1981) 603)
  EXPECT_NEAR(eos::thomas_fermi(1, 60, 1e-5).e, -0.768745, 1e-5);
  EXPECT_NEAR(eos::thomas_fermi(13, 60 / std::cbrt(13.0), 1e-5).e, -0.768745 * std::pow(13, 7.0 / 3), 0.01);
}

TEST(ThomasFermi, HotMatterIsAnIdealGas) {
  const double R = 3, T = 1e4, V = 4 * 3.14159265358979 / 3 * R * R * R;
  EXPECT_NEAR(eos::thomas_fermi(13, R, T).p * V, 13 * T, 1e-3 * 13 * T);
}

TEST(ThomasFermi, PressureIsTheDerivativeOfTheFreeEnergy) {
  const double T = 0.3, R = 2.8, h = 1e-3, pi = 3.14159265358979;
  const double dF = eos::thomas_fermi(13, R + h, T).f - eos::thomas_fermi(13, R - h, T).f;
  const double p = eos::thomas_fermi(13, R, T).p;
  EXPECT_NEAR(-dF / (2 * h) / (4 * pi * R * R), p, 1e-4 * p);
}

TEST(WideRange, UnknownMetalNamesTheValidOnes) {
  try {
    eos::find_metal("Xx");
    FAIL();
  } catch (const core::CaseError& e) {
    EXPECT_NE(std::string(e.what()).find("Al, Cu, Fe, Ti"), std::string::npos);
  }
}

TEST(WideRange, PhasesOfAluminium) {
  const auto& e = aluminium().model.phase_energies();
  // 933 K: 1050 J/(kg K) mean specific heat from 294 K, heat of fusion 0.397 MJ/kg; vaporisation 10.9 MJ/kg at 2792 K (CRC)
  EXPECT_NEAR(e.melt, 0.671e6, 0.05 * 0.671e6);
  EXPECT_NEAR(e.melted - e.melt, 0.397e6, 0.01 * 0.397e6);
  EXPECT_NEAR(e.vaporised - e.vapour, 10.9e6, 0.15 * 10.9e6);
  const auto& v = *aluminium().source.vapour;
  std::size_t k = 0;
  while (v.T[k] < 2792) ++k;
  const double t = (2792 - v.T[k - 1]) / (v.T[k] - v.T[k - 1]);
  EXPECT_NEAR(std::exp((1 - t) * std::log(v.p[k - 1]) + t * std::log(v.p[k])), 1e5, 0.05e5);
  // liquid at the melting point: 2375 kg/m3 (Assael et al., J. Phys. Chem. Ref. Data 35 (2006) 285)
  EXPECT_NEAR(v.rho_liquid[0], 2375, 0.04 * 2375);
}

TEST(WideRange, HugoniotIsTheMeasuredLine) {
  for (double up = 250; up <= 6000; up += 250) {
    const double p = 2700 * (5350 + 1.34 * up) * up;
    EXPECT_NEAR(eos::hugoniot(aluminium().table, aluminium().table.rho_0, up).p, p, 0.015 * p) << up;  // melting costs most
  }
}

TEST(WideRange, ShockMeltingBetweenTheMeasuredBounds) {
  // melting begins on the Hugoniot near 125 GPa and is complete near 150 GPa (McQueen, Fritz & Morris 1984)
  const auto at = [](double p) {
    double lo = 1000, hi = 8000;
    for (int i = 0; i < 50; ++i) {
      const double up = 0.5 * (lo + hi);
      (eos::hugoniot(aluminium().table, aluminium().table.rho_0, up).p < p ? lo : hi) = up;
    }
    return eos::hugoniot(aluminium().table, aluminium().table.rho_0, lo);
  };
  const auto solid = at(105e9), liquid = at(215e9);
  EXPECT_LT(solid.temperature, aluminium().model.melting_temperature(solid.rho));
  EXPECT_GT(liquid.temperature, aluminium().model.melting_temperature(liquid.rho));
}

TEST(WideRange, FreeEnergyHasTheZeroOfEnergy) {
  const auto& g = aluminium().source.grids.at(301);
  const std::size_t n = g.rho.size(), i = std::lower_bound(g.rho.begin(), g.rho.end(), 2699.0) - g.rho.begin();
  const std::size_t k = std::lower_bound(g.T.begin(), g.T.end(), 298.0) - g.T.begin();
  // 28.30 J/(mol K) at 298.15 K (Chase, NIST-JANAF Thermochemical Tables, 1998)
  EXPECT_NEAR((g.e[k * n + i] - g.f[k * n + i]) / g.T[k], 28.30 / 0.02698154, 0.03 * 28.30 / 0.02698154);
  for (std::size_t j = k; j + 1 < g.T.size() && g.T[j + 1] < 900; ++j) {  // e is the derivative of F/T by 1/T
    const double e = (g.f[(j + 1) * n + i] / g.T[j + 1] - g.f[j * n + i] / g.T[j]) / (1 / g.T[j + 1] - 1 / g.T[j]);
    EXPECT_GT(e, g.e[j * n + i]) << g.T[j];
    EXPECT_LT(e, g.e[(j + 1) * n + i]) << g.T[j];
  }
  for (std::size_t j = 1; j < n; ++j) EXPECT_GT(g.rho[j], g.rho[j - 1] * (1 + 1e-6));
}

TEST(WideRange, TableIsFiniteAndItsEnergyRises) {
  const auto& g = aluminium().source.grids.at(301);
  const std::size_t n = g.rho.size();
  for (std::size_t k = 0; k < g.T.size(); ++k)
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_TRUE(std::isfinite(g.p[k * n + i]) && std::isfinite(g.e[k * n + i]));
      // below max_stretch and in metastable solids an isotherm may end; elsewhere heat raises e
      if (k > 0 && g.rho[i] > 2700) {
        EXPECT_GT(g.e[k * n + i], g.e[(k - 1) * n + i]) << g.rho[i] << " " << g.T[k];
      }
    }
}
