// SPDX-License-Identifier: Apache-2.0
// Clouds of particles and lone particles against plates and walls, with the whole step: nothing tunnels, counted by brute
// force, and what has no neighbour flies on as a stone does.
#include <gtest/gtest.h>

#include "tests/coupling/crossings.hpp"
#include "tests/coupling/scene.hpp"

namespace {

using core::Vec3;

class CloudAtSpeed : public testing::TestWithParam<double> {};

TEST_P(CloudAtSpeed, NothingPassesAFace) {
  const double speed = GetParam(), a = 2e-4;
  rig::Rig r;
  r.s->spec.mode = io::Mode::hybrid;
  r.s->spec.particles_per_edge = 1;
  r.s->criteria.use_jacobian = true;
  r.s->criteria.expansion = 0.8;
  r.s->spec.energy_tolerance = 1e-7;
  auto m = scene::aluminium();
  m.strength = material::PerfectlyPlastic{27e9, 300e6};
  material::prepare(m);
  r.add(scene::plate(12, 3, a), m, [](const Vec3&) { return Vec3(0, 0, 0); });
  const auto cloud = scene::add_particle_body(r, m);
  std::mt19937 random(7);
  const double mass = 2785 * std::pow(0.7 * a, 3);
  for (int i = 0; i < 150; ++i)
    scene::add_particle(r.s->particles, mass, Vec3(0, 0, 5 * a) + scene::random_vector(random, 4.5 * a),
                        Vec3(0, 0, -speed) + scene::random_vector(random, 0.2 * speed), cloud);
  r.begin();
  auto& s = *r.s;
  const double end = 25 * a / speed;
  std::size_t crossings = 0;
  double energy = 0, momentum = 0;
  while (s.time < end * (1 - 1e-12)) {
    app::choose_step(s, end);
    const auto before = brute::remember(s.mesh, s.particles);
    const auto leaks = s.contact.leaks;
    app::step(s);
    // the cloud and the plate's own particles: those that were there at the start of the step
    sph::Particles then = s.particles;
    then.x.resize(before.particle.size());
    const auto now = brute::count(before, s.mesh, then, 8);
    if (now || s.contact.leaks != leaks)
      std::printf("step %lld: %zu crossings by brute force, %llu counted\n", (long long)s.steps, now,
                  (unsigned long long)(s.contact.leaks - leaks));
    crossings += now;
    energy = std::max(energy, std::abs(s.ledger.energy_error));
    momentum = std::max(momentum, s.ledger.momentum_error);
  }
  std::printf("%lld steps, %zu converted, dissipated %.3g of %.3g J\n", (long long)s.steps, s.n_converted, s.contact.dissipated,
              s.ledger.initial.kinetic);
  EXPECT_EQ(crossings, 0u);
  EXPECT_EQ(s.contact.leaks, 0u);
  if (speed > 5e3) {
    EXPECT_GT(s.contact.dissipated, 0);  // slower ones are turned round by the pair forces before they touch a face
  }
  EXPECT_LT(energy, 1e-9);
  EXPECT_LT(momentum, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(At, CloudAtSpeed, testing::Values(1e3, 7e3, 15e3),
                         [](const auto& i) { return std::to_string(int(i.param)) + "_m_s"; });

TEST(LoneParticle, FliesStraightForAThousandStepsAndStillHits) {
  const double a = 1e-3;
  rig::Rig r;
  auto m = scene::aluminium();
  m.strength = material::PerfectlyPlastic{27e9, 300e6};
  material::prepare(m);
  r.add(scene::plate(4, 2, a), m, [](const Vec3&) { return Vec3(0, 0, 0); });
  const auto cloud = scene::add_particle_body(r, m);
  const double dt = 1e-8;
  const Vec3 v(30, -20, -3000), x0(-0.3e-3, 0.2e-3, 1010 * dt * 3000);
  scene::add_particle(r.s->particles, 1e-9, x0, v, cloud);
  r.begin();
  auto& s = *r.s;
  const auto pt = s.particles.pt;
  Vec3 x = x0;
  for (int i = 0; i < 1000; ++i) {
    s.dt = dt;
    app::step(s);
    x += dt * v;
  }
  EXPECT_EQ(s.particles.v[0], v);
  EXPECT_EQ(s.particles.x[0], x);
  EXPECT_EQ(s.particles.pt.rho[0], pt.rho[0]);
  EXPECT_EQ(s.particles.pt.e[0], pt.e[0]);
  EXPECT_EQ(s.contact.dissipated, 0);
  for (int i = 0; i < 30; ++i) {
    s.dt = dt;
    app::step(s);
  }
  EXPECT_GT(s.contact.dissipated, 0);
  EXPECT_GT(s.particles.x[0][2], -0.2 * a);
  EXPECT_GT(s.particles.v[0][2], -600);
  EXPECT_EQ(s.contact.leaks, 0u);
}

TEST(LoneParticle, HitsARigidWall) {
  rig::Rig r;
  const auto m = scene::aluminium();
  const auto cloud = scene::add_particle_body(r, m);
  r.s->walls.push_back({Vec3::Zero(), Vec3::UnitZ()});
  r.s->hood.mirrors.push_back({Vec3::Zero(), Vec3::UnitZ(), true});
  const double dt = 1e-8;
  scene::add_particle(r.s->particles, 1e-9, Vec3(0, 0, 1010 * dt * 3000), Vec3(30, 0, -3000), cloud);
  r.begin();
  auto& s = *r.s;
  for (int i = 0; i < 1200; ++i) {
    s.dt = dt;
    app::step(s);
  }
  // its own image stops it or the wall does; never beyond
  EXPECT_GE(s.particles.x[0][2], -1e-12);
  EXPECT_GT(s.particles.v[0][2], -1e-3);
  EXPECT_LT(std::abs(s.ledger.energy_error), 1e-9);
  EXPECT_LT(s.ledger.momentum_error, 1e-12);
}

TEST(ParticlesAndBodies, OnlyParticlesMakeNoContactSearch) {
  rig::Rig r;
  const auto m = scene::aluminium();
  const auto cloud = scene::add_particle_body(r, m);
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) scene::add_particle(r.s->particles, 1e-9, scene::random_vector(random, 3e-4), Vec3(0, 0, 0), cloud);
  r.begin();
  for (int i = 0; i < 10; ++i) {
    app::choose_step(*r.s, 1);
    app::step(*r.s);
  }
  EXPECT_EQ(r.s->contact.searches, 0u);
  EXPECT_EQ(r.s->contact.lists.surface.built, false);
}

}  // namespace
