// SPDX-License-Identifier: Apache-2.0
// A block of particles and one whole step of it, from the public functions of sph/ alone.
#pragma once

#include <cmath>
#include <random>

#include "core/parallel.hpp"
#include "sph/particle_forces.hpp"
#include "sph/particle_update.hpp"

struct ParticleBlock {
  enum Pass { search, gradients, forces, kick, work, update, n_passes };
  static constexpr const char* pass_names[] = {"search", "gradients", "forces", "kick, drift", "work", "update"};

  sph::Particles p;
  sph::Neighbourhood hood;
  sph::ParticleSettings settings;
  std::vector<material::Material> materials;
  std::vector<double> rho_0;
  std::vector<int> body_material{0};
  std::vector<core::Mat3> correction, velocity_gradient;

  /// side^3 particles `spacing` apart, off their places by up to `jitter` spacings, in a field of velocities that stretches,
  /// squeezes and shears them.
  ParticleBlock(int side, double spacing, double jitter, double speed, const material::Material& material)
      : materials{material}, rho_0{material.rho_0} {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(-jitter, jitter);
    const auto n = static_cast<std::size_t>(side);
    p.resize(n * n * n);
    std::vector<core::Vec3> x;
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j)
        for (int k = 0; k < side; ++k) {
          const double a = u(random), b = u(random), c = u(random);
          x.push_back(spacing * core::Vec3(i + a, j + b, k + c));
        }
    core::Octree tree;
    tree.build(x);
    const auto start = eos::state(material.eos, material.rho_0, 0.0);
    const double wave = 2 * core::pi / (16 * spacing);
    for (std::size_t i = 0; i < p.size(); ++i) {
      p.x[i] = x[tree.order()[i]];
      p.v[i] = speed * core::Vec3(std::sin(wave * p.x[i][1]), std::sin(wave * p.x[i][2]), std::sin(wave * p.x[i][2]));
      p.v_mean[i] = p.v[i];
      p.pt.m[i] = material.rho_0 * spacing * spacing * spacing;
      p.pt.rho[i] = material.rho_0;
      p.pt.c[i] = std::sqrt(start.c2 + 4.0 / 3.0 * material::shear_modulus(material.strength) / material.rho_0);
      p.pt.T[i] = start.temperature;
      p.spread[i] = 1;
      p.id[i] = p.parent[i] = static_cast<std::uint32_t>(i);
      sph::set_smoothing_length(p, i);
      p.dt[i] = 0.5 * p.h[i] / p.pt.c[i];
    }
  }

  double stable_step() const {
    return 0.5 * core::min_where(p.size(), [&](std::size_t i) { return p.dt[i]; }).value;
  }

  /// One step; after(pass) is called at the end of each.
  template <class After>
  void step(double dt, After&& after) {
    if (!hood.valid) hood.actors.resize(hood.n_particles = p.size());
    sph::fill_actors(p, rho_0, hood);
    if (!hood.valid || !sph::still_valid(hood, {})) sph::build(hood, {}, 0);
    after(search);
    sph::correct_gradients(p, settings, hood, correction);
    after(gradients);
    sph::add_pair_forces(settings, hood, p);
    after(forces);
    sph::kick_particles(p, dt);
    core::for_each(p.size(), [&](std::size_t i) { sph::set_motion(hood, i, p.v[i]); });
    after(kick);
    sph::pair_work(settings, rho_0, dt, dt, correction, hood, p, velocity_gradient);
    after(work);
    sph::drift_particles(p, dt);
    after(kick);
    sph::update_particles(p, materials, body_material, velocity_gradient, dt);
    hood.age += dt;
    after(update);
  }
};
