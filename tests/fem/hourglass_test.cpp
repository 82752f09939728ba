// SPDX-License-Identifier: Apache-2.0
// Hourglass control of one unit cube against powers worked out by hand: Flanagan & Belytschko, IJNME 17 (1981) 679, eqs 34-36:
// (k/4) rho c l^2 q^2, where corners that move by +-u along x in one mode have q = 8 u.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fem/elements.hpp"
#include "fem/generate.hpp"
#include "tests/fem/fluid.hpp"

namespace {

using core::Vec3;

constexpr double rho = 1000, c = 1000, u = 1e-3;  // of the fluid; of the corners [m/s]

/// Power [W] that the mode yz (+-u along x) is damped with, while the cube stretches along z by `strain` (equivalent, of the
/// deviator) in the time that sound takes to cross it.
double damping(const std::vector<std::uint8_t>& ring, double strain) {
  fem::Mesh mesh;
  fem::add_body(mesh, fem::box({0, 1}, {0, 1}, {0, 1}), 0, rho);
  fem::finish(mesh);
  const double rate = strain / std::sqrt(2.0 / 3.0) * c, dt = 1e-8;
  for (std::size_t nd = 0; nd < 8; ++nd) {
    const Vec3& x = mesh.nodes.x[nd];
    mesh.nodes.v[nd] = {(x[1] - 0.5) * (x[2] - 0.5) > 0 ? u : -u, 0, rate * x[2]};
  }
  return fem::update_awake_elements(mesh, {fluid()}, {}, {dt, dt}, ring).hourglass / dt;
}

constexpr double power = 0.02 / 4 * rho * c * (8 * u) * (8 * u);

TEST(Hourglass, ViscousPower) {
  EXPECT_NEAR(damping({}, 0), power, 1e-6 * power);
  EXPECT_NEAR(damping({}, 0.01), power, 1e-3 * power);
}

TEST(Hourglass, ElementsThatParticlesPushAreDampedWhileTheyOnlyRing) {
  const std::vector<std::uint8_t> beside(fem::block_size, 1), apart(fem::block_size, 2);
  EXPECT_NEAR(damping(apart, 0), power, 1e-6 * power);
  EXPECT_NEAR(damping(beside, 0), (1 + 0.2 / 0.02) * power, 1e-6 * power);
  EXPECT_NEAR(damping(beside, 0.002), (1 + 0.2 / 0.02 / 2) * power, 1e-3 * power);
  EXPECT_NEAR(damping(beside, 0.02), (1 + 0.2 / 0.02 / 101) * power, 1e-3 * power);
}

}  // namespace
