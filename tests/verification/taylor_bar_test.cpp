// SPDX-License-Identifier: Apache-2.0
// Taylor bar of OFHC copper, 25.4 x 7.62 mm at 190 m/s, quarter model in hexes against the experiment of Johnson & Cook
// (1983) as given by Zerilli & Armstrong, J. Appl. Phys. 61 (1987) 1816: length 16.2 mm, foot 13.56 mm. Another code's hexes
// with the same law leave 0.685 of the length, 17.40 mm (reference, section 5).
#include "io/material_file.hpp"
#include "tests/verification/rig.hpp"

namespace {

using namespace rig;

void bar(bool spall, double length_tolerance, double foot_tolerance) {
  const double D = 7.62e-3, L = 25.4e-3;
  Rig r;
  auto& s = *r.s;
  core::Symmetry quarter;
  quarter.plane = {true, true, false};
  s.spec.symmetry = quarter;
  auto mesh = fem::cylinder(D, L, 8, 27, quarter);
  for (auto& x : mesh.x) x[2] += L / 2;
  auto copper = io::find_material("OFHC-Cu");
  if (!spall) copper.spall = 1e300;
  r.add(mesh, copper, [](const Vec3&) { return Vec3(0, 0, -190); });
  r.fix(1, [](const Vec3& x) { return x[0] == 0; });
  r.fix(2, [](const Vec3& x) { return x[1] == 0; });
  s.walls.push_back({Vec3(0, 0, 0), Vec3(0, 0, 1)});
  r.begin();
  const double initial = s.ledger.initial.kinetic;
  r.run(90e-6);
  double top = 0, bottom = 1e9, foot = 0, at_fifth = 0;
  for (const Vec3& x : s.mesh.nodes.x) {
    top = std::max(top, x[2]);
    bottom = std::min(bottom, x[2]);
    foot = std::max(foot, std::hypot(x[0], x[1]));
    if (std::abs(x[2] - 0.2 * L) < 0.5e-3) at_fifth = std::max(at_fifth, std::hypot(x[0], x[1]));
  }
  note("steps", static_cast<double>(s.steps));
  note("kinetic energy left / initial", s.ledger.now.kinetic / initial);
  note("diameter at 0.2 L0, mm (measured 10.1)", 2000 * at_fifth);
  note("hourglass energy / initial", s.ledger.hourglass / initial);
  int failed = 0;
  for (std::size_t el = 0; el < s.mesh.elements.size(); ++el) failed += s.mesh.elements.alive[el] && s.mesh.elements.pt.damage[el] >= 1;
  note("elements failed (measured: the bar stays whole)", failed);
  report("length, mm, against another code's hexes", 1000 * (top - bottom), 0.685 * 25.4);
  EXPECT_LT(std::abs(report("length, mm", 1000 * (top - bottom), 16.2)), length_tolerance);
  EXPECT_LT(std::abs(report("foot diameter, mm", 2000 * foot, 13.56)), foot_tolerance);
  EXPECT_GT(bottom, -1e-9);  // nothing passes the wall
  EXPECT_LT(std::abs(s.ledger.energy_error), 1e-9);
}

TEST(TaylorBarInHexes, CopperAt190) {
  // 8 %: the law itself leaves the bar 7 % too long, in this code and in the other one, on this mesh and on finer ones; the
  // foot is within the 10 % that a frictionless wall and constants from one laboratory deserve.
  bar(false, 0.08, 0.10);
}

// The library's tension limit (spall 1.2 GPa) fails 20 elements on the foot's axis 2 us after impact, which the experiment
// does not show, and mode fem has no remedy for the failed elements when they turn over: the run ends in a guard. Disabled
// until that is settled: run with --gtest_also_run_disabled_tests.
TEST(TaylorBarInHexes, DISABLED_CopperAt190WithSpall) { bar(true, 0.08, 0.10); }

}  // namespace
