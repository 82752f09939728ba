// SPDX-License-Identifier: Apache-2.0
// Blocks that run into each other, with the whole step: momentum and energy books, velocities of a symmetric and of an
// extreme impact.
#include <gtest/gtest.h>

#include "tests/coupling/crossings.hpp"
#include "tests/coupling/scene.hpp"

namespace {

using core::Vec3;

constexpr double a = 1e-4;  // element [m]

fem::HexMesh block(double z, int nz, int n = 6, double shift = 0, double size = a) {
  return fem::box(rig::line(shift - 0.5 * n * size, shift + 0.5 * n * size, n), rig::line(shift - 0.5 * n * size, shift + 0.5 * n * size, n),
                  rig::line(z, z + nz * size, nz));
}

/// Runs and watches crossings, the ledger and momentum.
struct Watch {
  std::size_t crossings = 0;
  double energy = 0, momentum = 0;
};
Watch run(rig::Rig& r, double end) {
  Watch w;
  auto& s = *r.s;
  while (s.time < end * (1 - 1e-12)) {
    app::choose_step(s, end);
    const auto before = brute::remember(s.mesh, s.particles);
    app::step(s);
    w.crossings += brute::count(before, s.mesh, s.particles, 8);
    w.energy = std::max(w.energy, std::abs(s.ledger.energy_error));
    w.momentum = std::max(w.momentum, s.ledger.momentum_error);
  }
  return w;
}

double mean_velocity(const app::Simulation& s, std::size_t body) {
  double p = 0, m = 0;
  for (auto nd = s.mesh.body_nodes[body].first; nd < s.mesh.body_nodes[body].last; ++nd)
    p += s.mesh.nodes.m[nd] * s.mesh.nodes.v[nd][2], m += s.mesh.nodes.m[nd];
  return p / m;
}

/// Uniaxial strain: no node moves sideways, so no release comes in from the sides.
void confine(rig::Rig& r) {
  r.fix(1 | 2, [](const Vec3&) { return true; });
}

TEST(BlockImpact, EqualBlocksStopAtTheInterface) {
  // Uniaxial, nodes of one block off the other's (6 elements on 4): the plane of impact of a symmetric collision moves at
  // the mean of both velocities, and the pressure behind the shocks is that of the Hugoniot at up = 500 m/s.
  rig::Rig r;
  r.add(block(0.02 * a, 15), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, -500); });
  r.add(block(-15 * a, 10, 4, 0, 1.5 * a), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, 500); });
  confine(r);
  r.begin();
  const Watch w = run(r, 0.18e-6);  // the shock has passed 1.1 of 1.5 mm
  EXPECT_EQ(w.crossings, 0u);
  EXPECT_EQ(r.s->contact.leaks, 0u);
  EXPECT_LT(w.energy, 1e-9);
  EXPECT_LT(w.momentum, 1e-12);
  const auto& n = r.s->mesh.nodes;
  for (std::size_t b = 0; b < 2; ++b) {
    double worst = 0, mean = 0;
    int counted = 0;
    for (auto nd = r.s->mesh.body_nodes[b].first; nd < r.s->mesh.body_nodes[b].last; ++nd) {
      if (std::abs(n.x[nd][2]) > 0.3 * a) continue;
      worst = std::max(worst, std::abs(n.v[nd][2]));
      mean += n.v[nd][2], ++counted;
    }
    ASSERT_GT(counted, 0);
    EXPECT_LT(std::abs(mean / counted), 25) << "body " << b << ": the mean velocity of its face, 5 % of each block's";
    EXPECT_LT(worst, 150) << "body " << b << ": nodes of 4 elements under 6 do not share alike; 30 %";
  }
  const double hugoniot = 2785 * (5328 + 1.338 * 500) * 500;
  double p = 0;
  int counted = 0;
  for (std::size_t el = 0; el < r.s->mesh.elements.size(); ++el) {
    const double z = std::abs(fem::centre(r.s->mesh, el, n.x)[2]);
    if (!r.s->mesh.elements.alive[el] || z < 2 * a || z > 6 * a) continue;
    p += r.s->mesh.elements.pt.p[el], ++counted;
  }
  EXPECT_NEAR(p / counted, hugoniot, 0.03 * hugoniot);
  // An inelastic impact of the nodes on the faces: of order one layer's kinetic energy, and it shrinks with the mesh.
  EXPECT_LT(r.s->contact.dissipated, 0.1 * r.s->ledger.initial.kinetic);
}

TEST(BlockImpact, ContactTakesTheShocksHeatOfHalfALayerEach) {
  // Nodes of a face hold half of its layer's mass: h1/2 and h2/2 of depth that the impact brings to one velocity at once, in inelastic
  // collision: rho (h1 h2 / (h1 + h2)) v^2 / 4 a unit of area. Like layers: rho h v^2 / 8, the heat up^2 / 2 that shocks leave in both halves.
  constexpr double v = 1000;
  for (const double h : {a, 0.5 * a}) {
    rig::Rig r;
    r.add(block(0.02 * a, 12, 4), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, -v); });
    r.add(fem::box(rig::line(-2 * a, 2 * a, 4), rig::line(-2 * a, 2 * a, 4), rig::line(-12 * a, 0, static_cast<int>(std::lround(12 * a / h)))),
          scene::aluminium(), [](const Vec3&) { return Vec3::Zero(); });
    confine(r);
    r.begin();
    run(r, 0.1e-6);
    const double taken = 2785 * (a * h / (a + h)) * v * v / 4 * (16 * a * a);
    EXPECT_NEAR(r.s->contact.dissipated, taken, 0.03 * taken) << h;
  }
}

TEST(BlockImpact, WhatMeetsFlatIsNotPushedSideways) {
  // Like meshes, node on node, free to slide, until release from the edges has come half way to the middle.
  rig::Rig r;
  r.add(block(0.02 * a, 8, 16), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, -1000); });
  r.add(block(-8 * a, 8, 16), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, 1000); });
  r.begin();
  run(r, 0.05e-6);
  const auto& n = r.s->mesh.nodes;
  for (std::size_t b = 0; b < 2; ++b) {
    Vec3 sum = Vec3::Zero();
    double counted = 0, worst = 0;
    for (auto nd = r.s->mesh.body_nodes[b].first; nd < r.s->mesh.body_nodes[b].last; ++nd) {
      if (std::abs(n.x[nd].z()) > 0.3 * a || n.x[nd].head<2>().cwiseAbs().maxCoeff() > 3 * a) continue;
      sum += n.v[nd], ++counted, worst = std::max(worst, n.v[nd].head<2>().norm());
    }
    ASSERT_GT(counted, 0);
    EXPECT_LT((sum / counted).head<2>().norm(), 1) << "m/s, 0.1 % of the speed of each";
    EXPECT_LT(worst, 10);
  }
}

TEST(BlockImpact, UnlikeMeshesPressedTogetherDoNotRing) {
  // Eight elements on ten, free to slide: behind both shocks the state of the Hugoniot, up to the interface, and no hourglassing.
  rig::Rig r;
  r.add(block(0.01 * a, 15, 8), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, -1000); });
  r.add(block(-15.2 * a, 19, 10, 0, 0.8 * a), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, 1000); });
  for (const int d : {0, 1}) r.fix(1 << d, [&](const Vec3& x) { return std::abs(x[d]) > 3.999 * a; });  // uniaxial as a whole
  r.begin();
  run(r, 0.2e-6);  // the shocks have passed 1.1 of 1.5 mm
  const double hugoniot = 2785 * (5328 + 1.338 * 1000) * 1000;
  double p = 0, square = 0;
  int counted = 0;
  const auto& e = r.s->mesh.elements;
  for (std::size_t el = 0; el < e.size(); ++el) {
    const Vec3 x = fem::centre(r.s->mesh, el, r.s->mesh.nodes.x);
    if (!e.alive[el] || std::abs(x[2]) > 6 * a) continue;
    p += e.pt.p[el], square += e.pt.p[el] * e.pt.p[el], ++counted;
  }
  p /= counted;
  EXPECT_NEAR(p, hugoniot, 0.01 * hugoniot);
  EXPECT_LT(std::sqrt(square / counted - p * p), 0.02 * p);
  EXPECT_LT(r.s->ledger.hourglass, 5e-4 * r.s->ledger.initial.kinetic);
}

TEST(BlockImpact, BooksStayClosedUntilTheyPart) {
  rig::Rig r;
  r.add(block(0.02 * a, 4, 4, a / 3), scene::aluminium(), [](const Vec3&) { return Vec3(3, 0, -200); });
  r.add(block(-4 * a, 4, 4, 0), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, 0); });
  r.begin();
  const Watch w = run(r, 0.8e-6);
  EXPECT_EQ(w.crossings, 0u);
  EXPECT_LT(w.energy, 1e-9);
  EXPECT_LT(w.momentum, 1e-12);
  EXPECT_LT(r.s->ledger.angular_momentum_error, 1e-11);
  // Equal masses: elastic waves hand the velocity over, all of it but what the impact dissipated.
  EXPECT_LE(mean_velocity(*r.s, 0), mean_velocity(*r.s, 1) + 1e-9) << "they part and do not overlap";
  EXPECT_NEAR(mean_velocity(*r.s, 0) + mean_velocity(*r.s, 1), -200, 1e-9);
}

/// rho and c of the material: bulk modulus rho c^2.
material::Material fluid(double rho, double c) { return rig::mie_grueneisen(rho, c, 1.3, 1.5); }

TEST(BlockImpact, MassRatioOfAThousandIsStable) {
  for (const bool heavy_on_top : {true, false}) {
    rig::Rig r;  // same stiffness, 1000 times the density
    const auto heavy = fluid(20000, 1000), light = fluid(20, 31622.8);
    r.add(block(0.02 * a, 6, 6, a / 3), heavy_on_top ? heavy : light, [](const Vec3&) { return Vec3(0, 0, -100); });
    r.add(block(-6 * a, 6, 6), heavy_on_top ? light : heavy, [](const Vec3&) { return Vec3(0, 0, 0); });
    r.begin();
    const Watch w = run(r, 0.3e-6);
    EXPECT_EQ(w.crossings, 0u);
    EXPECT_EQ(r.s->contact.leaks, 0u);
    EXPECT_LT(w.energy, 1e-9);
    EXPECT_LT(w.momentum, 1e-12);
    EXPECT_LE(r.s->ledger.now.kinetic, r.s->ledger.initial.kinetic * (1 + 1e-9));
    // the heavy one hardly notices; the light one is not shot off faster than an elastic impact would
    EXPECT_NEAR(mean_velocity(*r.s, heavy_on_top ? 0 : 1), heavy_on_top ? -100 : 0, 1.0);
    EXPECT_LT(std::abs(mean_velocity(*r.s, heavy_on_top ? 1 : 0)), 200 * 1.05);
  }
}

TEST(BlockImpact, StiffnessRatioOfAThousandIsStable) {
  for (const bool stiff_on_top : {true, false}) {
    rig::Rig r;  // same density, 1000 times the bulk modulus; coarse elements on fine
    const auto stiff = fluid(2000, 10000), soft = fluid(2000, 316.2);
    r.add(block(0.02 * a, 6, 6, a / 3), stiff_on_top ? stiff : soft, [](const Vec3&) { return Vec3(0, 0, -60); });
    r.add(block(-12 * a, 6, 6, 0, 2 * a), stiff_on_top ? soft : stiff, [](const Vec3&) { return Vec3(0, 0, 0); });
    r.begin();
    const Watch w = run(r, 1.0e-6);
    EXPECT_EQ(w.crossings, 0u);
    EXPECT_EQ(r.s->contact.leaks, 0u);
    EXPECT_LT(w.energy, 1e-9);
    EXPECT_LT(w.momentum, 1e-12);
    EXPECT_LE(r.s->ledger.now.kinetic, r.s->ledger.initial.kinetic * (1 + 1e-9));
  }
}

TEST(BlockImpact, AgainstARigidWall) {
  rig::Rig r;
  r.add(block(0.02 * a, 15), scene::aluminium(), [](const Vec3&) { return Vec3(0, 0, -500); });
  confine(r);
  r.s->walls.push_back({Vec3::Zero(), Vec3::UnitZ()});
  r.s->hood.mirrors.push_back({Vec3::Zero(), Vec3::UnitZ(), true});
  r.begin();
  run(r, 0.18e-6);
  double deepest = 0, worst = 0;
  const auto& n = r.s->mesh.nodes;
  for (std::size_t nd = 0; nd < n.size(); ++nd) {
    deepest = std::min(deepest, n.x[nd][2]);
    if (n.x[nd][2] < 0.3 * a) worst = std::max(worst, std::abs(n.v[nd][2]));
  }
  EXPECT_GT(deepest, -1e-9 * a);
  EXPECT_LT(worst, 1e-6);
  EXPECT_LT(std::abs(r.s->ledger.energy_error), 1e-9);
  EXPECT_LT(r.s->ledger.momentum_error, 1e-12);
  // The wall's impulse is the Hugoniot's pressure over the face and the time; the contact began 4 ns late (0.02 a).
  const double expected = 2785 * (5328 + 1.338 * 500) * 500 * 36 * a * a * 0.176e-6;
  EXPECT_NEAR(r.s->contact.wall_impulse[2], expected, 0.05 * expected);
}

TEST(BlockImpact, SqueezedBetweenABlockAndAWall) {
  // Bodies and walls pull in opposite directions in the same step: neither may give way.
  rig::Rig r;
  r.add(block(0, 2, 4), fluid(2000, 1000), [](const Vec3&) { return Vec3(0, 0, 0); });
  r.add(block(2.02 * a, 6, 6, a / 3), fluid(20000, 3000), [](const Vec3&) { return Vec3(0, 0, -100); });
  r.s->walls.push_back({Vec3::Zero(), Vec3::UnitZ()});
  r.begin();
  const Watch w = run(r, 0.3e-6);
  double deepest = 0;
  for (const Vec3& x : r.s->mesh.nodes.x) deepest = std::min(deepest, x[2]);
  EXPECT_GT(deepest, -1e-6 * a) << "through the wall by this part of an element: " << -deepest / a;
  EXPECT_EQ(w.crossings, 0u);
  EXPECT_LT(w.energy, 1e-9);
  EXPECT_LT(w.momentum, 1e-12);
}

}  // namespace
