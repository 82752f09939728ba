// SPDX-License-Identifier: Apache-2.0
// Meshes and loose particles for contact tests.
#pragma once

#include <cmath>
#include <random>

#include "coupling/contact.hpp"
#include "fem/elements.hpp"
#include "fem/generate.hpp"
#include "tests/verification/rig.hpp"

namespace scene {

using core::Vec3;

inline material::Material aluminium() { return rig::mie_grueneisen(2785, 5328, 1.338, 2.0); }

/// n elements of `size` a side, centred on the origin in x and y, top at z = 0.
inline fem::HexMesh plate(int n, int through, double size) {
  return fem::box(rig::line(-0.5 * n * size, 0.5 * n * size, n), rig::line(-0.5 * n * size, 0.5 * n * size, n),
                  rig::line(-through * size, 0, through));
}

inline void add_particle(sph::Particles& p, double m, const Vec3& x, const Vec3& v, std::uint16_t body, double rho = 2785,
                         double c = 5328) {
  const std::size_t i = p.size();
  p.resize(i + 1);
  p.pt.m[i] = m, p.pt.rho[i] = rho, p.pt.c[i] = c, p.pt.T[i] = 294;
  p.x[i] = x, p.v[i] = p.v_mean[i] = v;
  p.body[i] = body, p.id[i] = static_cast<std::uint32_t>(i);
  p.spread[i] = 1;
  sph::set_smoothing_length(p, i);
  p.dt[i] = 0.5 * p.h[i] / c;
}

/// A body of particles only, in a rig that has not begun.
inline std::uint16_t add_particle_body(rig::Rig& r, const material::Material& material) {
  r.s->materials.push_back(material);
  r.s->rho_0.push_back(material.rho_0);
  fem::add_empty_body(r.s->mesh, static_cast<int>(r.s->materials.size()) - 1);
  return static_cast<std::uint16_t>(r.s->materials.size() - 1);
}

inline Vec3 random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-1, 1);
  const double x = u(random), y = u(random), z = u(random);
  return size * Vec3(x, y, z);
}

/// A mesh and particles that only drift and touch: contact without forces.
struct Kinematic {
  fem::Mesh mesh;
  sph::Particles particles;
  std::vector<coupling::Wall> walls;
  coupling::ContactSettings settings;
  coupling::Contact contact;
  double time = 0;

  std::size_t add(const fem::HexMesh& hexes, double rho) {
    fem::add_body(mesh, hexes, 0, rho);
    return mesh.body_nodes.size() - 1;
  }
  void move_body(std::size_t body, const std::function<Vec3(const Vec3&)>& velocity) {
    for (auto nd = mesh.body_nodes[body].first; nd < mesh.body_nodes[body].last; ++nd)
      mesh.nodes.v[nd] = mesh.nodes.v_mean[nd] = velocity(mesh.nodes.x[nd]);
  }
  Vec3 momentum() const {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) p += mesh.nodes.m[i] * mesh.nodes.v[i];
    for (std::size_t i = 0; i < particles.size(); ++i) p += particles.pt.m[i] * particles.v[i];
    return p;
  }
  double kinetic() const {
    double k = 0;
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) k += 0.5 * mesh.nodes.m[i] * mesh.nodes.v[i].squaredNorm();
    for (std::size_t i = 0; i < particles.size(); ++i) k += 0.5 * particles.pt.m[i] * particles.v[i].squaredNorm();
    return k;
  }
  double heat() const {
    double h = 0;
    for (std::size_t i = 0; i < mesh.elements.size(); ++i) h += mesh.elements.pt.m[i] * mesh.elements.pt.e[i];
    for (std::size_t i = 0; i < particles.size(); ++i) h += particles.pt.m[i] * particles.pt.e[i];
    return h;
  }
  /// One step without forces.
  void step(double dt) {
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) mesh.nodes.v_mean[i] = mesh.nodes.v[i];
    for (std::size_t i = 0; i < particles.size(); ++i) particles.v_mean[i] = particles.v[i];
    coupling::resolve_contact(mesh, particles, walls, settings, time, dt, contact);
    fem::drift_nodes(mesh, dt);
    for (std::size_t i = 0; i < particles.size(); ++i) particles.x[i] += dt * particles.v[i];
    time += dt;
  }
};

}  // namespace scene
