// SPDX-License-Identifier: Apache-2.0
#include "sph/particle_update.hpp"

#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "sph/update_kernel.hpp"

namespace sph {

using core::Mat3;
using core::Vec3;

void kick_particles(Particles& p, double dt) {
  core::for_each(p.size(), [&](std::size_t i) {
    const Vec3 dv = p.f[i] * (dt / p.pt.m[i]);
    p.v_mean[i] = p.v[i] + 0.5 * dv;
    p.v[i] += dv;
  });
}

void drift_particles(Particles& p, double dt) {
  core::for_each(p.size(), [&](std::size_t i) { p.x[i] += p.v[i] * dt; });
}

void update_particles(Particles& p, const std::vector<material::Material>& materials,
                      const std::vector<int>& body_material, const std::vector<Mat3>& gradient, double dt) {
  if (p.size() == 0) return;
  const UpdateView v{p, materials.data(), body_material.data(), gradient[0].data()};
  const auto isa = core::isa();
  const auto update = isa == core::Isa::avx512 ? avx512::update_particles
                      : isa == core::Isa::avx2 ? avx2::update_particles
                                               : baseline::update_particles;
  core::for_each_block(p.size(), 256, [&](std::size_t first, std::size_t last) { update(v, first, last, dt); });
}

}  // namespace sph
