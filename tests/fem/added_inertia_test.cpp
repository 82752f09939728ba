// SPDX-License-Identifier: Apache-2.0
// Selective mass scaling against what it must do by its definition: M_e = inertia m / 8 (1 - P), P the projection on rigid motions.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "fem/added_inertia.hpp"
#include "fem/elements.hpp"
#include "fem/generate.hpp"

namespace {

using core::Vec3;

constexpr double rho = 1000;

fem::Mesh mesh_of(const fem::HexMesh& hexes) {
  fem::Mesh mesh;
  fem::add_body(mesh, hexes, 0, rho);
  fem::finish(mesh);
  fem::make_room_for_forces(mesh);
  std::fill(mesh.elements.pt.c.begin(), mesh.elements.pt.c.end(), 1000.0);
  std::fill(mesh.elements.dt.begin(), mesh.elements.dt.end(), 1.0);
  mesh.elements.dt_0 = mesh.elements.dt;
  return mesh;
}

void set_force(fem::Mesh& mesh, std::size_t el, int corner, const Vec3& f) {
  for (int d = 0; d < 3; ++d) *fem::force_of(mesh.elements, fem::corner_index(el, corner, d)) = f[d];
}

/// Corner forces that f(x) gives a cube about the origin, before and after three masses of inertia are added: the ratio along f.
double left(const std::function<Vec3(const Vec3&)>& f) {
  auto mesh = mesh_of(fem::box({-0.5, 0.5}, {-0.5, 0.5}, {-0.5, 0.5}));
  for (int c = 0; c < 8; ++c) set_force(mesh, 0, c, f(mesh.nodes.x[static_cast<std::size_t>(mesh.elements.node[0][static_cast<std::size_t>(c)])]));
  fem::add_inertia(mesh, {{0, 3.0}});
  double along = 0, size = 0;
  for (std::size_t nd = 0; nd < 8; ++nd) along += force_at(mesh, nd).dot(f(mesh.nodes.x[nd])), size += f(mesh.nodes.x[nd]).squaredNorm();
  return along / size;
}

TEST(AddedInertia, SlowsStrainAndHourglassingAndLeavesRigidMotion) {
  EXPECT_NEAR(left([](const Vec3& x) { return Vec3(x[0], 0, 0); }), 0.25, 1e-12) << "stretch";
  EXPECT_NEAR(left([](const Vec3& x) { return Vec3(x[1], x[0], 0); }), 0.25, 1e-12) << "shear";
  EXPECT_NEAR(left([](const Vec3& x) { return Vec3(x[1] * x[2], 0, 0); }), 0.25, 1e-12) << "hourglass";
  EXPECT_NEAR(left([](const Vec3&) { return Vec3(1, 2, 3); }), 1, 1e-12) << "translation";
  EXPECT_NEAR(left([](const Vec3& x) { return Vec3(-x[1], x[0], 0); }), 1, 1e-12) << "rotation";
}

/// A distorted block of 27 under any forces, ten of its elements with inertia added.
struct Block {
  fem::Mesh mesh;
  std::vector<fem::Slowed> slowed;
  std::vector<Vec3> before;
  Block() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(-1, 1);
    auto hexes = fem::box({0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 3});
    for (auto& x : hexes.x) x += 0.2 * Vec3(u(random), u(random), u(random));
    mesh = mesh_of(hexes);
    for (std::size_t el = 0; el < 27; ++el)
      for (int c = 0; c < 8; ++c) set_force(mesh, el, c, {u(random), u(random), u(random)});
    for (auto& v : mesh.nodes.v) v = {u(random), u(random), u(random)};
    for (std::uint32_t el = 0; el < 20; el += 2) slowed.push_back({el, 0.3 * (el + 1)});
    for (std::size_t nd = 0; nd < mesh.nodes.size(); ++nd) before.push_back(force_at(mesh, nd));
  }
};

TEST(AddedInertia, GivesNeitherMomentumNorSpin) {
  Block b;
  fem::add_inertia(b.mesh, b.slowed);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0;
  for (std::size_t nd = 0; nd < b.before.size(); ++nd) {
    const Vec3 df = force_at(b.mesh, nd) - b.before[nd];
    force += df, torque += b.mesh.nodes.x[nd].cross(df), size += df.norm();
  }
  EXPECT_GT(size, 1) << "something must have been added";
  EXPECT_LT(force.norm(), 1e-13 * size);
  EXPECT_LT(torque.norm(), 1e-12 * size);
}

TEST(AddedInertia, AcceleratesAsTheEquationOfMotionSays) {
  // (M + sum of M_e) a = f: what the slowed elements lose is M_e a, which a second run with f = M a must find again
  Block b;
  b.mesh.nodes.fixed[3] = 5, b.mesh.nodes.fixed[21] = 2;
  fem::add_inertia(b.mesh, b.slowed);
  const auto free = [&](std::size_t nd, Vec3 a) {
    for (int d = 0; d < 3; ++d)
      if (b.mesh.nodes.fixed[nd] >> d & 1) a[d] = 0;
    return a;
  };
  // kinetic energy of the added inertia at the accelerations, twice it being a . M_e a
  auto v = b.mesh.nodes.v;
  double lost = 0, size = 0;
  for (std::size_t nd = 0; nd < v.size(); ++nd) {
    const Vec3 f = force_at(b.mesh, nd), a = free(nd, f) / b.mesh.nodes.m[nd];
    lost += a.dot(b.before[nd] - f), size += a.dot(b.before[nd]);
    b.mesh.nodes.v[nd] = a;
  }
  EXPECT_NEAR(2 * fem::add_inertia(b.mesh, b.slowed), lost, 1e-3 * size);
  EXPECT_GT(lost, 0.05 * size);
}

TEST(AddedInertia, EnergyIsThatOfTheStrainingPartOfTheMotion) {
  auto mesh = mesh_of(fem::box({0, 1}, {0, 1}, {0, 1}));
  // stretching at 2 /s: corners at +-1 m/s, and half the inertia's 3 rho; flight and spin count for nothing
  for (std::size_t nd = 0; nd < 8; ++nd) mesh.nodes.v[nd] = Vec3(2 * (mesh.nodes.x[nd][0] - 0.5), 0, 0) + Vec3(7, 8, 9) + Vec3(1, 1, 2).cross(mesh.nodes.x[nd]);
  EXPECT_NEAR(fem::add_inertia(mesh, {{0, 3.0}}), 0.5 * 3 * rho, 1e-9 * rho);
}

TEST(FewSlowed, AreSqueezedQuietAndOneInAHundred) {
  std::vector<double> line;
  for (int k = 0; k <= 10; ++k) line.push_back(k);
  auto mesh = mesh_of(fem::box(line, line, line));
  auto& dt = mesh.elements.dt;
  const auto step = [&] { return fem::step_with_few_slowed(mesh, fem::stable_step(mesh, 0)); };
  std::fill(mesh.elements.deformation.begin(), mesh.elements.deformation.end(), 0.1);
  EXPECT_EQ(step(), 1) << "as built";
  for (std::size_t k = 0; k < 8; ++k) dt[100 * k] = 0.6 + 0.01 * static_cast<double>(k);
  const double all = step();
  EXPECT_LE(all, 1);
  EXPECT_GT(all, 1 - 0.6 / 32) << "to a thirty-second of the shortest";
  const auto slowed = fem::slowed_elements(mesh, all);
  ASSERT_EQ(slowed.size(), 8u);
  EXPECT_EQ(slowed[1].element, 100u);
  EXPECT_NEAR(slowed[1].inertia, std::pow(all / 0.61, 2) - 1, 1e-12);

  const auto awake = mesh.awake_blocks;
  mesh.awake_blocks.resize(10);
  EXPECT_EQ(step(), all) << "whatever sleeps";
  mesh.awake_blocks = awake;
  std::fill_n(mesh.elements.deformation.begin() + 200, 300, 0.0);
  EXPECT_LT(step(), 0.67) << "eight of seven hundred that were strained";
  std::fill_n(mesh.elements.deformation.begin() + 200, 300, 0.1);

  dt[0] = 0.3;
  EXPECT_EQ(step(), 0.6) << "none by more than twice";
  dt[0] = 0.6;
  mesh.nodes.v[static_cast<std::size_t>(mesh.elements.node[300][0])] = {13, 0, 0};
  EXPECT_LE(step(), 0.63) << "one that strains faster than a hundredth of the sound holds the step";
  EXPECT_GT(step(), 0.61);
  mesh.nodes.v[static_cast<std::size_t>(mesh.elements.node[300][0])] = {9, 0, 0};
  EXPECT_EQ(step(), all);
  for (std::size_t el = 801; el < 804; ++el) dt[el] = 0.8;
  EXPECT_LE(step(), 0.8) << "eleven of a thousand";
  EXPECT_GT(step(), 0.8 - 0.6 / 32);
  mesh.elements.dt_0[0] = 0.65;
  EXPECT_EQ(step(), 0.6) << "built as small as this";
}

}  // namespace
