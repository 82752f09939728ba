// SPDX-License-Identifier: Apache-2.0
#include "sph/particle_update.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "material/update.hpp"

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

static material::Point<double> load(const core::Points& pt, std::size_t i) {
  material::Point<double> r;
  r.rho = pt.rho[i], r.e = pt.e[i], r.p = pt.p[i], r.c = pt.c[i], r.temperature = pt.T[i];
  for (std::size_t k = 0; k < 6; ++k) r.s[k] = pt.s[k][i];
  r.eps_p = pt.eps_p[i], r.damage = pt.damage[i];
  return r;
}

static void store(core::Points& pt, std::size_t i, const material::Point<double>& r) {
  pt.rho[i] = r.rho, pt.e[i] = r.e, pt.p[i] = r.p, pt.c[i] = r.c, pt.T[i] = r.temperature;
  for (std::size_t k = 0; k < 6; ++k) pt.s[k][i] = r.s[k];
  pt.eps_p[i] = r.eps_p, pt.damage[i] = r.damage;
  pt.p_max[i] = std::max(pt.p_max[i], r.p);
}

void update_particles(Particles& p, const std::vector<material::Material>& materials,
                      const std::vector<int>& body_material, const std::vector<Mat3>& gradient, double dt) {
  core::for_each_block(p.size(), 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Mat3& l = gradient[i];
      const double half = 0.5 * dt, tr = std::clamp(l.trace() * dt, -1.0, 1.0);
      const material::Increment<double> inc{
          {l(0, 0) * dt, l(1, 1) * dt, l(2, 2) * dt, (l(0, 1) + l(1, 0)) * half, (l(1, 2) + l(2, 1)) * half,
           (l(2, 0) + l(0, 2)) * half},
          {(l(2, 1) - l(1, 2)) * half, (l(0, 2) - l(2, 0)) * half, (l(1, 0) - l(0, 1)) * half}};
      auto pt = load(p.pt, i);
      const auto& material = materials[static_cast<std::size_t>(body_material[p.body[i]])];
      // continuity at mid-step: exact to second order and never negative
      const double rho = pt.rho * (1 - 0.5 * tr) / (1 + 0.5 * tr);
      material::update(material, dt, rho, inc, 0.0, pt);
      store(p.pt, i, pt);
      const double div = std::abs(l.trace());
      const double curl = Vec3(l(2, 1) - l(1, 2), l(0, 2) - l(2, 0), l(1, 0) - l(0, 1)).norm();
      p.spread[i] = div / (div + curl + 1e-4 * pt.c / p.h[i]);
      set_smoothing_length(p, i);
    }
  });
}

}  // namespace sph
