// SPDX-License-Identifier: Apache-2.0
// Contact of single points with faces, without forces: swept in time, on edges and corners, at grazing angles, through
// openings, with friction, and with rigid walls. Judged by a brute-force count of crossings (crossings.hpp), by momentum,
// and by closed-form inelastic impacts.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/coupling/crossings.hpp"
#include "tests/coupling/scene.hpp"

namespace {

using core::Vec3;
using scene::Kinematic;

constexpr double mm = 1e-3;

/// A plate of 1 mm elements, its top face at z = 0, and one particle.
Kinematic plate_and_particle(int n, int through, double mass, const Vec3& x, const Vec3& v) {
  Kinematic k;
  k.add(scene::plate(n, through, mm), 2785);
  fem::finish(k.mesh);
  scene::add_particle(k.particles, mass, x, v, 0);
  return k;
}

/// Steps, and counts crossings by brute force.
std::size_t crossings_of_a_step(Kinematic& k, double dt) {
  const auto before = brute::remember(k.mesh, k.particles);
  k.step(dt);
  return brute::count(before, k.mesh, k.particles, 200);
}

TEST(PointContact, TheSlowTwinSeesACrossing) {
  auto k = plate_and_particle(4, 1, 1e-9, Vec3(0.3, 0.2, 2) * mm, Vec3(0, 0, -1e4));
  k.settings.enabled = false;
  EXPECT_EQ(crossings_of_a_step(k, 1e-6), 1u);
}

TEST(PointContact, AStepOfTenFacesIsStopped) {
  // 10 km/s for 1 us is 10 mm: ten times the face and the plate's thickness.
  auto k = plate_and_particle(4, 1, 1e-9, Vec3(0.3, 0.2, 2) * mm, Vec3(0, 0, -1e4));
  const Vec3 p0 = k.momentum();
  const double k0 = k.kinetic();
  EXPECT_EQ(crossings_of_a_step(k, 1e-6), 0u);
  EXPECT_LT((k.momentum() - p0).norm(), 1e-14 * p0.norm());  // round-off of five additions
  EXPECT_GT(k.contact.dissipated, 0);
  EXPECT_LT(k.kinetic(), k0);
  // one impulse a pair: all that is dissipated is heat, and kinetic energy lost is what was dissipated
  EXPECT_NEAR(k.contact.dissipated, k0 - k.kinetic(), 1e-12 * k0);
  EXPECT_NEAR(k.heat(), k.contact.heated, 1e-12 * k0);
  EXPECT_EQ(k.contact.leaks, 0u);
}

/// The step that contact allows while a cube of 1 mm comes down at 1 km/s, 0.1 mm above a plate of 1 mm elements that has been drawn
/// by `wide` along x and y and by `thick` along z.
double step_above_plate(double wide, double thick) {
  Kinematic k;
  const auto plate = k.add(scene::plate(4, 1, mm), 2785);
  auto cube = scene::plate(1, 1, mm);
  for (auto& x : cube.x) x += Vec3(0, 0, 1.1) * mm;
  const auto striker = k.add(cube, 2785);
  fem::finish(k.mesh);
  for (auto nd = k.mesh.body_nodes[plate].first; nd < k.mesh.body_nodes[plate].last; ++nd)
    k.mesh.nodes.x[nd] = Vec3(wide, wide, thick).cwiseProduct(k.mesh.nodes.x[nd]);
  for (auto el = k.mesh.body_elements[plate].first; el < k.mesh.body_elements[plate].last; ++el)
    k.mesh.elements.pt.rho[el] = 2785 / (wide * wide * thick);
  for (auto el = k.mesh.body_elements[striker].first; el < k.mesh.body_elements[striker].last; ++el) k.mesh.elements.pt.rho[el] = 2785;
  k.move_body(striker, [](const Vec3&) { return Vec3(0, 0, -1000); });
  k.step(1e-7);
  return k.contact.step;
}

// 0.4 of the face's edge or of the depth of the matter behind it, whichever is less. That depth is of the volume now: an element of an
// eroded sphere that had been drawn out to a sheet of thin matter once held a run to steps of a tenth of a nanosecond.
TEST(PointContact, StepClosesByAPartOfEdgeOrDepth) {
  EXPECT_NEAR(step_above_plate(1, 1), 0.4e-6, 1e-12);
  EXPECT_NEAR(step_above_plate(1, 0.25), 0.1e-6, 1e-12);
  EXPECT_NEAR(step_above_plate(4, 1), 0.4e-6, 1e-12);
}

TEST(PointContact, TiltedMovingRotatingFacesStopEverything) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  std::size_t crossed = 0, leaks = 0, cases = 0;
  double momentum_error = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Kinematic k;
    auto hexes = scene::plate(4, 1, mm);
    const core::Mat3 turn = Eigen::AngleAxisd(3 * u(random), scene::random_vector(random, 1).normalized()).toRotationMatrix();
    for (auto& x : hexes.x) x = turn * x;
    k.add(hexes, 2785);
    fem::finish(k.mesh);
    const Vec3 drift = scene::random_vector(random, 5000), spin = scene::random_vector(random, 3e5);
    k.move_body(0, [&](const Vec3& x) { return Vec3(drift + spin.cross(x)); });
    // a particle that would go through a random place of the plate's top within the step
    const double dt = 1e-6, part = 0.5 * (1 + u(random));
    const Vec3 target = turn * Vec3(1.8 * u(random) * mm, 1.8 * u(random) * mm, 0);
    const Vec3 there = target + part * dt * (drift + spin.cross(target));
    const Vec3 v = -1e4 * (turn * Vec3(0.7 * u(random), 0.7 * u(random), 1).normalized()) + drift;
    scene::add_particle(k.particles, 1e-9 * std::pow(10.0, 2 * u(random)), there - part * dt * v, v, 0);
    const Vec3 p0 = k.momentum();
    const auto before = brute::remember(k.mesh, k.particles);
    k.step(dt);
    cases += k.contact.dissipated > 0;
    const auto now = brute::count(before, k.mesh, k.particles, 200);
    if (now != 0)
      std::printf("trial %d: crossed by brute force %zu, leaks %llu\n", trial, now, (unsigned long long)k.contact.leaks);
    crossed += now;
    leaks += k.contact.leaks;
    momentum_error = std::max(momentum_error, (k.momentum() - p0).norm() / p0.norm());
  }
  EXPECT_EQ(crossed, 0u);
  EXPECT_EQ(leaks, 0u);
  EXPECT_GT(cases, 300u);                // the aim is good: most of them do meet
  EXPECT_LT(momentum_error, 1e-12);      // hundreds of impulses of a few ulp
}

TEST(PointContact, EdgesAndCornersOfFacesLeaveNoGap) {
  // Exactly on, and a hair beside, edges shared by two faces, nodes shared by four, centres shared by four triangles, and
  // the plate's outer edge and corner.
  std::size_t crossed = 0, leaks = 0, met = 0;
  for (const double offset : {0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6})
    for (const Vec3& spot : {Vec3(0, 0, 0), Vec3(0, 0.5, 0), Vec3(1, 0.25, 0), Vec3(0.5, 0.5, 0), Vec3(1, 1, 0)})
      for (const Vec3& direction : {Vec3(0, 0, -1), Vec3(1, 0, -1), Vec3(0.3, -0.9, -0.4), Vec3(1, 1, -0.1)}) {
        const Vec3 v = 1e4 * direction.normalized(), aim = spot * mm + Vec3(offset, -0.37 * offset, 0);
        auto k = plate_and_particle(6, 1, 1e-9, aim - v * 2e-7, v);
        crossed += crossings_of_a_step(k, 1e-6);
        leaks += k.contact.leaks;
        met += k.contact.dissipated > 0;
        EXPECT_GT(k.contact.dissipated, 0) << "missed at " << aim.transpose() << " along " << direction.transpose();
      }
  EXPECT_EQ(crossed, 0u);
  EXPECT_EQ(leaks, 0u);
  EXPECT_EQ(met, 11u * 5 * 4);
}

TEST(PointContact, OuterEdgesAndCornersAreSolid) {
  // Diagonally at the convex edge (3, y, 0) and corner (3, 3, 0) of the block, exactly and a hair beside.
  std::size_t crossed = 0, leaks = 0;
  for (const double offset : {0.0, 1e-15, -1e-15, 1e-9, -1e-9, 1e-6, -1e-6, 1e-5, -1e-5})
    for (const Vec3& spot : {Vec3(3, 0.25, 0), Vec3(3, 1, 0), Vec3(3, 3, 0)})
      for (const Vec3& direction : {Vec3(-1, 0, -1), Vec3(-1, -0.2, -0.3), Vec3(-1, -1, -1), Vec3(-0.1, -0.1, -1)}) {
        const Vec3 v = 1e4 * direction.normalized();
        auto k = plate_and_particle(6, 6, 1e-9, spot * mm + Vec3(offset, 0, 0) - v * 2e-7, v);
        const auto now = crossings_of_a_step(k, 1e-6);
        if (now) std::printf("offset %g at %g %g along %g %g %g: leaks %llu\n", offset, spot[0], spot[1], direction[0],
                             direction[1], direction[2], (unsigned long long)k.contact.leaks);
        crossed += now;
        leaks += k.contact.leaks;
      }
  EXPECT_EQ(crossed, 0u);
  EXPECT_EQ(leaks, 0u);
}

TEST(PointContact, GrazingOverAnOuterEdgeIsStopped) {
  // From beside the block, in flat, down onto its top: the point is nearer to the top's plane than any margin while it is
  // still beside the block.
  std::size_t crossed = 0, leaks = 0, cases = 0;
  for (const double slope : {0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 3e-4})
    for (const double beyond : {0.001, 0.01, 0.05, 0.2, 0.5, 0.9})  // how far inside the top it would cross [mm]
      for (const double start : {0.05, 0.5, 3.0}) {                 // how far outside it begins [mm]
        const Vec3 v = 1e4 * Vec3(-1, 0, -slope).normalized();
        const Vec3 spot = Vec3(3 - beyond, 0.3, 0) * mm;
        const Vec3 x = spot + Vec3(beyond + start, 0, (beyond + start) * slope) * mm;
        auto k = plate_and_particle(6, 6, 1e-9, x, v);
        const auto now = crossings_of_a_step(k, 1e-6);
        if (now) std::printf("slope %g, crosses %g mm inside, starts %g mm outside: leaks counted %llu\n", slope, beyond, start,
                             (unsigned long long)k.contact.leaks);
        crossed += now;
        leaks += k.contact.leaks;
        ++cases;
      }
  EXPECT_EQ(crossed, 0u) << "of " << cases;
  EXPECT_EQ(leaks, crossed) << "the leak counter and the brute-force count differ";
  EXPECT_EQ(leaks, 0u);
}

TEST(PointContact, ManyStepsAgainstAClosingCorner) {
  // A particle in the inner corner of an L: it must stay between both faces while pushed into the corner step after step.
  Kinematic k;
  k.add(scene::plate(6, 1, mm), 2785);
  auto upright = fem::box(rig::line(-4 * mm, -3 * mm, 1), rig::line(-3 * mm, 3 * mm, 6), rig::line(0, 6 * mm, 6));
  k.add(upright, 2785);
  fem::finish(k.mesh);
  scene::add_particle(k.particles, 1e-9, Vec3(-2, 0.2, 1) * mm, Vec3(0, 0, 0), 0);
  std::size_t crossed = 0;
  for (int i = 0; i < 50; ++i) {
    k.particles.v[0] = Vec3(-9000, 10, -9000);
    crossed += crossings_of_a_step(k, 3e-7);
  }
  EXPECT_EQ(crossed, 0u);
  EXPECT_EQ(k.contact.leaks, 0u);
}

TEST(PointContact, AnOpeningIsOpen) {
  // A plate with its middle element gone. What goes through the hole keeps its velocity to the last bit; the walls of the
  // hole are faces now and stop what goes for them.
  for (const double x : {0.0, 0.3, 0.45, -0.47}) {  // triangles reach 2 % beyond their edges, to 0.48
    auto k = plate_and_particle(5, 1, 1e-9, Vec3(x, 0.1, 2) * mm, Vec3(0, 0, -1e4));
    for (std::uint32_t el = 0; el < k.mesh.elements.size(); ++el)
      if (k.mesh.elements.alive[el] && fem::centre(k.mesh, el, k.mesh.nodes.x).head<2>().norm() < 0.1 * mm)
        fem::remove_element(k.mesh, el, false);
    const Vec3 v = k.particles.v[0];
    for (int i = 0; i < 20; ++i) k.step(5e-8);
    EXPECT_EQ(k.particles.v[0], v) << "at x = " << x << " mm";
    EXPECT_EQ(k.contact.dissipated, 0);
  }
  auto k = plate_and_particle(5, 1, 1e-9, Vec3(-1.5, 0.1, 1.5) * mm, Vec3(1e4, 0, -1e4));  // would meet the hole's far wall
  k.particles.x[0] += Vec3(0.3, 0, -0.2) * mm;
  for (std::uint32_t el = 0; el < k.mesh.elements.size(); ++el)
    if (k.mesh.elements.alive[el] && fem::centre(k.mesh, el, k.mesh.nodes.x).head<2>().norm() < 0.1 * mm)
      fem::remove_element(k.mesh, el, false);
  std::size_t crossed = 0;
  for (int i = 0; i < 20; ++i) crossed += crossings_of_a_step(k, 5e-8);
  EXPECT_EQ(crossed, 0u);
  EXPECT_GT(k.contact.dissipated, 0);
  EXPECT_LT(k.particles.x[0][0], 0.5 * mm);
}

TEST(PointContact, AParallelPasserByIsNotTouched) {
  auto k = plate_and_particle(6, 1, 1e-9, Vec3(-5, 0.1, 0.02) * mm, Vec3(1e4, 0, 0));
  const Vec3 v = k.particles.v[0];
  for (int i = 0; i < 20; ++i) k.step(1e-7);
  EXPECT_EQ(k.particles.v[0], v);
}

TEST(PointContact, FrictionIsCoulomb) {
  for (const double mu : {0.0, 0.1, 0.3}) {
    // one element as heavy as a planet: the particle alone changes its velocity
    Kinematic k;
    k.add(scene::plate(1, 1, mm), 1e12);
    fem::finish(k.mesh);
    k.settings.friction = mu;
    scene::add_particle(k.particles, 1e-9, Vec3(0, 0.1, 0.01) * mm, Vec3(1000, 0, -1000), 0);
    k.step(1e-7);
    const double normal = k.particles.v[0][2] + 1000, tangential = 1000 - k.particles.v[0][0];
    EXPECT_NEAR(tangential, mu * normal, 1e-6 * normal) << "mu = " << mu;  // the face gives way by 1e-9 / 1e-3 of mass
  }
  Kinematic k;
  k.add(scene::plate(1, 1, mm), 1e12);
  fem::finish(k.mesh);
  k.settings.friction = 10;  // sticks: slip stops and never turns round
  scene::add_particle(k.particles, 1e-9, Vec3(0, 0.1, 0.001) * mm, Vec3(1000, 0, -1000), 0);
  k.step(1e-7);
  EXPECT_NEAR(k.particles.v[0][0], 0, 1e-3);
}

TEST(PointContact, ARigidWallIsPassedByNothing) {
  std::mt19937 random(2);
  Kinematic k;
  k.add(scene::plate(4, 2, mm), 2785);
  fem::finish(k.mesh);
  k.walls.push_back({Vec3(0, 0, -4 * mm), Vec3(0.3, -0.2, 1).normalized()});
  k.move_body(0, [](const Vec3&) { return Vec3(0, 0, -3000); });
  for (int i = 0; i < 100; ++i)
    scene::add_particle(k.particles, 1e-9, Vec3(0, 0, 3 * mm) + scene::random_vector(random, 2 * mm),
                        Vec3(0, 0, -1e4) + scene::random_vector(random, 5e3), 0);
  const Vec3 p0 = k.momentum();
  const double k0 = k.kinetic();
  double deepest = 0;
  for (int i = 0; i < 60; ++i) {
    k.step(1e-7);
    const auto& w = k.walls[0];
    for (const Vec3& x : k.mesh.nodes.x) deepest = std::min(deepest, w.normal.dot(x - w.point));
    for (const Vec3& x : k.particles.x) deepest = std::min(deepest, w.normal.dot(x - w.point));
  }
  EXPECT_GT(deepest, -1e-9 * mm) << "as a part of an element's edge: " << deepest / mm;
  EXPECT_LT((k.momentum() - p0 - k.contact.wall_impulse).norm(), 1e-12 * p0.norm());
  EXPECT_NEAR(k.contact.dissipated, k0 - k.kinetic(), 1e-9 * k0);
}

/// The part of a plate of 1 mm elements in front of the planes x = 0 and y = 0.
Kinematic quarter_plate(int n) {
  Kinematic k;
  fem::HexMesh hexes = fem::box(rig::line(0, n * mm, n), rig::line(0, n * mm, n), rig::line(-mm, 0, 1));
  k.add(hexes, 2785);
  fem::finish(k.mesh);
  k.settings.symmetry.plane = {true, true, false};
  return k;
}

// What passes a symmetry plane goes on as its image, and meets what lies in front of the plane within the same step.
TEST(PointContact, WhatPassesASymmetryPlaneStrikesAsItsImage) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const double dt = 5e-7, strikes = u(random);  // the part of the step after which it is on the plate
    Vec3 there = Vec3(3.6 * u(random) - 1.8, 3.6 * u(random) - 1.8, 0) * mm, v(6000 * u(random) - 3000, 6000 * u(random) - 3000, -4000);
    Vec3 x = there - strikes * dt * v;
    for (int d = 0; d < 2; ++d)
      if (x[d] < 0) x[d] = -x[d], v[d] = -v[d], there[d] = -there[d];  // it begins in front of the planes
    auto quarter = quarter_plate(4);
    scene::add_particle(quarter.particles, 1e-9, x, v, 0);
    auto whole = plate_and_particle(8, 1, 1e-9, x, v);
    const double k0 = quarter.kinetic(), z0 = quarter.momentum().z();
    quarter.step(dt);
    whole.step(dt);
    EXPECT_GT(quarter.contact.dissipated, 0) << trial << " at " << there.transpose();
    EXPECT_GT(quarter.particles.x[0].z(), -0.01 * mm) << trial << " at " << there.transpose();
    EXPECT_EQ(quarter.contact.leaks, 0u);
    EXPECT_NEAR(quarter.momentum().z(), z0, 1e-14 * std::abs(z0));
    EXPECT_NEAR(quarter.contact.dissipated, k0 - quarter.kinetic(), 1e-12 * k0);
    EXPECT_NEAR(quarter.heat(), quarter.contact.heated, 1e-12 * k0);
    // away from the planes, where no image strikes the same corners, it is the same as on the whole plate
    if (std::min(std::abs(there.x()), std::abs(there.y())) > 1.1 * mm) {
      EXPECT_LT((quarter.particles.v[0] - whole.particles.v[0]).norm(), 1e-9 * v.norm()) << trial;
      EXPECT_NEAR(quarter.contact.dissipated, whole.contact.dissipated, 1e-9 * k0);
    }
  }
}

TEST(PointContact, FrictionAlongARigidWallIsCoulomb) {
  for (const double mu : {0.0, 0.1, 0.3, 10.0}) {
    Kinematic k;
    k.add(scene::plate(1, 1, mm), 2785);
    fem::finish(k.mesh);
    k.settings.friction = mu;
    k.walls.push_back({Vec3(0, 0, -5 * mm), Vec3(0, 0, 1)});
    scene::add_particle(k.particles, 1e-9, Vec3(9, 9, -5) * mm, Vec3(300, 400, -1000), 0);
    k.step(1e-7);
    EXPECT_NEAR(k.particles.v[0][0], 300 * std::max(0.0, 1 - mu * 1000 / 500), 1e-9) << mu;
    EXPECT_NEAR(k.particles.v[0][1], 400 * std::max(0.0, 1 - mu * 1000 / 500), 1e-9) << mu;
    EXPECT_NEAR(k.contact.wall_impulse[2], 1e-6, 1e-15);
  }
}

TEST(PointContact, WhatSlidesAlongDoesNotCatchOnEdges) {
  // Clear of the plate by the gap that contact keeps and more: nothing touches, whichever edges lie over whichever faces.
  for (const double clear : {2.1e-3, 5e-3, 1e-2}) {
    Kinematic k;
    k.add(scene::plate(8, 1, mm), 2785);
    k.add(fem::box(rig::line(-3.3 * mm, -1.3 * mm, 2), rig::line(-1.1 * mm, 0.9 * mm, 2), rig::line(clear * mm, (2 + clear) * mm, 2)), 2785);
    fem::finish(k.mesh);
    k.move_body(1, [](const Vec3&) { return Vec3(1000, 30, 0); });
    const double before = k.kinetic();
    for (int i = 0; i < 400; ++i) k.step(1e-8);
    EXPECT_EQ(k.kinetic(), before) << clear;
  }
}

TEST(PointContact, StackedPlatesDoNotCatchOnEachOthersEdges) {
  // Two plates of one size lie on each other; the upper one widens. The lower one's edge nodes lie on the outlines of its side faces, and
  // were taken along by them.
  Kinematic k;
  k.add(scene::plate(6, 1, mm), 2785);
  k.add(fem::box(rig::line(-3 * mm, 3 * mm, 6), rig::line(-3 * mm, 3 * mm, 6), rig::line(-2 * mm, -1 * mm, 1)), 2785);
  fem::finish(k.mesh);
  k.move_body(0, [](const Vec3& x) { return Vec3(1e4 * x[0], 1e4 * x[1], 0); });
  for (int i = 0; i < 10; ++i) k.step(1e-8);
  EXPECT_GT(k.contact.searches, 0u);
  EXPECT_EQ(k.contact.dissipated, 0);
  EXPECT_EQ(k.contact.leaks, 0u);
  for (auto nd = k.mesh.body_nodes[1].first; nd < k.mesh.body_nodes[1].last; ++nd) EXPECT_EQ(k.mesh.nodes.v[nd], Vec3(0, 0, 0)) << nd;
  // pressed together they are stopped
  k.move_body(1, [](const Vec3&) { return Vec3(0, 0, 100); });
  for (int i = 0; i < 10; ++i) k.step(1e-8);
  EXPECT_GT(k.contact.dissipated, 0);
  EXPECT_EQ(k.contact.leaks, 0u);
}

TEST(PointContact, AWallTakesTheNormalVelocityOnly) {
  Kinematic k;
  k.add(scene::plate(1, 1, mm), 2785);
  fem::finish(k.mesh);
  k.walls.push_back({Vec3(0, 0, -5 * mm), Vec3(0, 0, 1)});
  scene::add_particle(k.particles, 1e-9, Vec3(9, 9, -4.9) * mm, Vec3(70, 20, -1e4), 0);
  k.step(1e-7);
  k.step(1e-7);
  EXPECT_EQ(k.particles.v[0][0], 70);
  EXPECT_EQ(k.particles.v[0][1], 20);
  EXPECT_NEAR(k.particles.v[0][2], 0, 1e-9);
  EXPECT_NEAR(k.particles.x[0][2], -5 * mm, 1e-15);
}

/// Index of the first vector that is not the same to the bit, -1 where there is none.
std::ptrdiff_t first_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const auto at = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  return at == a.end() ? -1 : at - a.begin();
}

/// A cloud and a block on their way to a plate.
Kinematic cloud_and_block() {
  Kinematic k;
  k.add(scene::plate(8, 2, mm), 2785);
  auto block = fem::box(rig::line(-1.7 * mm, 1.3 * mm, 4), rig::line(-1.2 * mm, 1.8 * mm, 4), rig::line(0.3 * mm, 3.3 * mm, 4));
  k.add(block, 2785);
  fem::finish(k.mesh);
  k.move_body(1, [](const Vec3& x) { return Vec3(300 - 2e5 * x[1], -200 + 2e5 * x[0], -4000); });
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i)
    scene::add_particle(k.particles, 1e-8, Vec3(0, 0, 7 * mm) + scene::random_vector(random, 3.5 * mm),
                        Vec3(0, 0, -5000) + scene::random_vector(random, 2e3), 0);
  return k;
}

/// The next element alive from `el` on becomes a particle.
void convert_element(Kinematic& k, std::size_t el) {
  el %= k.mesh.elements.size();
  while (!k.mesh.elements.alive[el]) el = (el + 1) % k.mesh.elements.size();
  Vec3 v = Vec3::Zero();
  for (const auto nd : k.mesh.elements.node[el]) v += k.mesh.nodes.v[static_cast<std::size_t>(nd)] / 8;
  scene::add_particle(k.particles, k.mesh.elements.pt.m[el], fem::centre(k.mesh, el, k.mesh.nodes.x), v, k.mesh.elements.body(el));
  k.particles.parent.back() = static_cast<std::uint32_t>(el);
  fem::remove_element(k.mesh, el, false);
}

TEST(PointContact, NothingDependsOnWhenListsWereMade) {
  // The plate loses an element now and then: lists kept and extended give the bits of lists made anew at every step.
  auto kept = cloud_and_block(), anew = cloud_and_block();
  for (int i = 0; i < 150; ++i) {
    for (Kinematic* k : {&kept, &anew}) {
      if (i % 10 == 5) convert_element(*k, static_cast<std::size_t>(i) * 7);
      if (k == &anew) coupling::invalidate(k->contact);
      k->step(2e-8);
    }
    ASSERT_EQ(first_difference(kept.mesh.nodes.v, anew.mesh.nodes.v), -1) << "node, step " << i;
    ASSERT_EQ(first_difference(kept.particles.v, anew.particles.v), -1) << "particle, step " << i;
    ASSERT_EQ(kept.contact.step, anew.contact.step) << "step " << i;
  }
  EXPECT_GT(kept.contact.dissipated, 0);
  EXPECT_EQ(kept.contact.leaks, 0u);
  EXPECT_LT(3 * kept.contact.searches, anew.contact.searches);
}

TEST(PointContact, WhereOneBodyIsAloneNothingIsListed) {
  // A block slides across a wide plate, and elements of the plate become particles with velocities of their own, under the block and where
  // nothing was near. Lists that leave out what is quiet, kept and extended, give the bits of lists made anew at every step.
  const auto scene = [] {
    Kinematic k;
    k.add(scene::plate(90, 1, mm), 2785);
    k.add(fem::box(rig::line(-42 * mm, -38 * mm, 4), rig::line(-2.2 * mm, 1.8 * mm, 4), rig::line(0.1 * mm, 4.1 * mm, 4)), 2785);
    fem::finish(k.mesh);
    k.move_body(1, [](const Vec3& x) { return Vec3(4000 - 1e4 * x[1], 1e4 * (x[0] + 40 * mm), -60); });
    return k;
  };
  auto kept = scene(), anew = scene();
  std::size_t most_quiet = 0, least_quiet = 1000000;
  for (int i = 0; i < 180; ++i) {
    for (Kinematic* k : {&kept, &anew}) {
      if (i % 12 == 7) {
        std::mt19937 random(static_cast<unsigned>(i));
        convert_element(*k, i % 24 == 7 ? 45 * 90 + static_cast<std::size_t>(i) / 3 : random());
        k->particles.v.back() += Vec3(0, 0, 100) + scene::random_vector(random, 600);
      }
      if (k == &anew) coupling::invalidate(k->contact);
      k->step(1e-7);
    }
    ASSERT_EQ(first_difference(kept.mesh.nodes.v, anew.mesh.nodes.v), -1) << "node, step " << i;
    ASSERT_EQ(first_difference(kept.particles.v, anew.particles.v), -1) << "particle, step " << i;
    ASSERT_EQ(kept.contact.step, anew.contact.step) << "step " << i;
    most_quiet = std::max(most_quiet, kept.contact.lists.quiet.size());
    least_quiet = std::min(least_quiet, kept.contact.lists.quiet.size());
  }
  EXPECT_GT(most_quiet, kept.mesh.nodes.size() / 2);
  EXPECT_LT(least_quiet, most_quiet / 2) << "where particles have come, it is not quiet";
  EXPECT_GT(kept.contact.dissipated, 0);
  EXPECT_EQ(kept.contact.leaks, 0u);
  EXPECT_LT(2 * kept.contact.searches, anew.contact.searches);
}

TEST(PointContact, WhatAppearsBesideQuietFacesStrikesThem) {
  // Whether the faces that a new particle of the plate comes down on were near anything when the lists were made or not.
  std::size_t quiet = 0, near = 0;
  for (int i = 12; i < 86; ++i) {
    Kinematic k;
    k.add(scene::plate(90, 1, mm), 2785);
    k.add(fem::box(rig::line(-42 * mm, -38 * mm, 4), rig::line(-2.2 * mm, 1.8 * mm, 4), rig::line(0.01 * mm, 4 * mm, 4)), 2785);
    fem::finish(k.mesh);
    k.move_body(1, [](const Vec3&) { return Vec3(0, 0, -200); });
    k.step(1e-7);
    std::size_t el = 0;
    while ((fem::centre(k.mesh, el, k.mesh.nodes.x) - Vec3((i - 44.5) * mm, 0.5 * mm, -0.5 * mm)).norm() > 1e-6) ++el;
    const auto& were_quiet = k.contact.lists.quiet;
    (std::find(were_quiet.begin(), were_quiet.end(), k.mesh.elements.node[el][0]) != were_quiet.end() ? quiet : near) += 1;
    convert_element(k, el);
    k.particles.x.back() += Vec3(1.7, 0.3, 0.6) * mm;
    k.particles.v.back() = Vec3(0, 0, -2000);
    for (int n = 0; n < 4; ++n) k.step(1e-7);
    EXPECT_GT(k.particles.v[0][2], -1500) << "it was not stopped at " << i;
  }
  EXPECT_GT(near, 10u);
  EXPECT_GT(quiet, 10u);
}

TEST(PointContact, WhatHasChangedFindsItsPairs) {
  // Every candidate that the matter asked for has a part in, each once, whether it stood in the lists from the start or came later.
  auto k = cloud_and_block();
  coupling::ContactLists& l = k.contact.lists;
  std::mt19937 random(5);
  std::size_t from_rows = 0, later = 0;
  for (int i = 0; i < 60; ++i) {
    if (i % 10 == 5) convert_element(k, static_cast<std::size_t>(i) * 7);
    k.step(2e-8);
    std::vector<coupling::ContactPoint> matter;
    std::vector<std::uint8_t> node(k.mesh.nodes.size()), particle(k.particles.size());
    for (int n = 0; n < 12; ++n) {
      const bool of_particles = n % 2 == 1;
      auto& chosen = of_particles ? particle : node;
      const std::size_t at = random() % chosen.size();
      if (!chosen[at]) matter.push_back({static_cast<std::uint32_t>(at), of_particles});
      chosen[at] = 1;
    }
    const auto part = [&](const coupling::Candidate& c) {
      const auto& p = l.points[c.point];
      const auto& f = l.faces[c.face].node;
      return (p.particle ? particle : node)[p.index] || std::any_of(f.begin(), f.end(), [&](auto nd) { return node[nd] != 0; });
    };
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    std::set<Pair> found, expected;
    const auto given = coupling::candidates_of(matter, l);
    for (const auto& c : given) found.insert({c.point, c.face});
    EXPECT_EQ(found.size(), given.size()) << "given twice in step " << i;
    for (std::size_t c = 0; c < l.candidates.size(); ++c)
      if (c >= l.rows.n || part(l.candidates[c])) expected.insert({l.candidates[c].point, l.candidates[c].face}), ++(c < l.rows.n ? from_rows : later);
    EXPECT_EQ(found, expected) << "step " << i;
  }
  EXPECT_GT(from_rows, 100u);
  EXPECT_GT(later, 0u);
}

TEST(PointContact, FarBodiesAreNotSearched) {
  auto k = plate_and_particle(6, 1, 1e-9, Vec3(0, 0, 100) * mm, Vec3(0, 0, -1e4));
  for (int i = 0; i < 50; ++i) k.step(1e-7);
  EXPECT_EQ(k.contact.searches, 0u);
  for (int i = 0; i < 100; ++i) k.step(1e-7);
  EXPECT_GT(k.contact.dissipated, 0) << "the quiet time ran past the meeting";
  EXPECT_GT(k.particles.x[0][2], -1 * mm);
}

}  // namespace
