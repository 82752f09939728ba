// SPDX-License-Identifier: Apache-2.0
#include "io/shock_points.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "eos/hugoniot.hpp"
#include "eos/wide_range.hpp"
#include "io/material_file.hpp"

TEST(ShockPoints, ComeFromTheJumps) {
  const auto s = io::shock_series({"no such material", "Al2024-T351"});
  ASSERT_EQ(s.size(), 1u);
  EXPECT_EQ(s[0].points.size(), 28u);
  EXPECT_EQ(s[0].rho_0, 2785);
  // V/V0 = 0.91326, p = 8.0691 GPa: up = sqrt(8.0691e9 x 0.08674 / 2785) = 501.3 m/s, Us = 8.0691e9 / (2785 x 501.3) = 5779.5 m/s
  const auto& first = s[0].points.front();
  EXPECT_NEAR(first.up, 501.31, 0.05);
  EXPECT_NEAR(first.Us, 5779.5, 0.5);
  EXPECT_NEAR(first.rho, 3049.5, 0.1);
  for (std::size_t k = 1; k < s[0].points.size(); ++k) EXPECT_GE(s[0].points[k].up, s[0].points[k - 1].up);
  EXPECT_TRUE(io::shock_series({"Be"}).empty());
}

TEST(ShockPoints, EveryMaterialNamedIsInTheLibrary) {
  std::size_t found = 0;
  for (const auto& name : io::material_names()) found += io::shock_series({name}).size();
  EXPECT_EQ(found, 6u);
}

// Mie-Grueneisen, Tillotson's published constants, and the wide-range table from 20 to 197 GPa; points scatter by 2 %.
TEST(ShockPoints, ThreeModelsOfAluminium) {
  const auto mie = io::find_material("Al1100-O"), tillotson = io::find_material("Al-Tillotson");
  eos::Eos table = eos::Sesame{};
  auto& sesame = std::get<eos::Sesame>(table);
  const auto& metal = eos::find_metal("Al");
  sesame.rho_0 = metal.rho_0;
  sesame.table = std::make_shared<const eos::SesameTable>(eos::invert(eos::WideRange(metal).table().grids.at(301), metal.rho_0, "Al"));
  const auto series = io::shock_series({"Al1100-O"});
  ASSERT_EQ(series.size(), 1u);
  int compared = 0;
  for (const auto& at : series[0].points) {
    if (at.p < 20e9) continue;
    ++compared;
    const auto error = [&](const eos::Eos& m, double rho_0) { return eos::hugoniot(m, rho_0, at.up).p / at.p - 1; };
    EXPECT_LT(std::abs(error(mie.eos, mie.rho_0)), 0.03) << at.up;
    EXPECT_LT(std::abs(error(table, metal.rho_0)), 0.03) << at.up;
    EXPECT_LT(std::abs(error(tillotson.eos, tillotson.rho_0)), 0.08) << at.up;
  }
  EXPECT_EQ(compared, 23);
}
