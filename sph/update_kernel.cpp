// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see update_kernel.hpp for what it does.
#include "sph/update_kernel.hpp"

#include "core/isa.hpp"
#include "core/lane_math.hpp"
#include "material/update.hpp"

namespace sph::EJECTA_ISA {
namespace {

constexpr int W = core::native_lanes;
using Real = core::Pack<W>;

/// W lanes of one array from row i on; `n` rows are there, the last stands in for those that are missing.
Real load(const double* a, std::size_t n) {
  if (n >= W) return core::load<Real>(a);
  Real r;
  for (std::size_t l = 0; l < W; ++l) r.set(static_cast<int>(l), a[l < n ? l : n - 1]);
  return r;
}
void store(double* a, Real v, std::size_t n) {
  if (n >= W) return core::store(a, v);
  for (std::size_t l = 0; l < n; ++l) a[l] = v[static_cast<int>(l)];
}

material::Point<Real> load_point(const core::Points& pt, std::size_t i, std::size_t n) {
  material::Point<Real> r;
  r.m = load(&pt.m[i], n);
  r.rho = load(&pt.rho[i], n), r.e = load(&pt.e[i], n), r.p = load(&pt.p[i], n), r.c = load(&pt.c[i], n);
  r.temperature = load(&pt.T[i], n);
  for (std::size_t k = 0; k < 6; ++k) r.s[k] = load(&pt.s[k][i], n);
  r.eps_p = load(&pt.eps_p[i], n), r.damage = load(&pt.damage[i], n);
  return r;
}

void store_point(core::Points& pt, std::size_t i, std::size_t n, const material::Point<Real>& r) {
  store(&pt.rho[i], r.rho, n), store(&pt.e[i], r.e, n), store(&pt.p[i], r.p, n), store(&pt.c[i], r.c, n);
  store(&pt.T[i], r.temperature, n);
  for (std::size_t k = 0; k < 6; ++k) store(&pt.s[k][i], r.s[k], n);
  store(&pt.eps_p[i], r.eps_p, n), store(&pt.damage[i], r.damage, n);
  store(&pt.p_max[i], core::max(load(&pt.p_max[i], n), r.p), n);
}

/// Lanes [first, last) of b, the others of a.
Real blend(Real a, Real b, std::size_t first, std::size_t last) {
  for (std::size_t l = first; l < last; ++l) a.set(static_cast<int>(l), b[static_cast<int>(l)]);
  return a;
}

void blend_point(material::Point<Real>& a, const material::Point<Real>& b, std::size_t first, std::size_t last) {
  for (auto f : {&material::Point<Real>::rho, &material::Point<Real>::e, &material::Point<Real>::p,
                 &material::Point<Real>::c, &material::Point<Real>::temperature, &material::Point<Real>::eps_p,
                 &material::Point<Real>::damage})
    a.*f = blend(a.*f, b.*f, first, last);
  for (int k = 0; k < 6; ++k) a.s[k] = blend(a.s[k], b.s[k], first, last);
}

/// W particles from row i on.
void update_pack(const UpdateView& v, std::size_t i, std::size_t n, double dt) {
  Particles& p = v.particles;
  Real l[3][3];
  for (int lane = 0; lane < W; ++lane) {
    const double* g = v.gradient + 9 * (i + (static_cast<std::size_t>(lane) < n ? static_cast<std::size_t>(lane) : n - 1));
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) l[r][c].set(lane, g[3 * c + r]);
  }
  const Real step(dt), half(0.5 * dt), trace = l[0][0] + l[1][1] + l[2][2];
  const material::Increment<Real> inc{
      {l[0][0] * step, l[1][1] * step, l[2][2] * step, (l[0][1] + l[1][0]) * half, (l[1][2] + l[2][1]) * half,
       (l[2][0] + l[0][2]) * half},
      {(l[2][1] - l[1][2]) * half, (l[0][2] - l[2][0]) * half, (l[1][0] - l[0][1]) * half}};
  const material::Point<Real> old = load_point(p.pt, i, n);
  // continuity at mid-step: exact to second order and never negative
  const Real swell = Real(0.5) * core::min(core::max(trace * step, Real(-1.0)), Real(1.0));
  const Real rho = old.rho * (Real(1.0) - swell) / (Real(1.0) + swell);

  material::Point<Real> pt = old;
  const std::size_t lanes = n < W ? n : W;
  for (std::size_t first = 0, last; first < lanes; first = last) {  // runs of one material
    const int material = v.body_material[p.body[i + first]];
    for (last = first + 1; last < lanes && v.body_material[p.body[i + last]] == material;) ++last;
    material::Point<Real> now = old;
    material::update(v.materials[material], dt, rho, inc, Real(0.0), now);
    if (first == 0 && last == lanes)
      pt = now;
    else
      blend_point(pt, now, first, last);
  }
  store_point(p.pt, i, n, pt);

  const Real x = l[2][1] - l[1][2], y = l[0][2] - l[2][0], z = l[1][0] - l[0][1];
  const Real div = core::abs(trace), curl = core::sqrt(x * x + y * y + z * z);
  store(&p.spread[i], div / (div + curl + Real(1e-4) * pt.c / load(&p.h[i], n)), n);
  const Real h_0 = load(&p.h_0[i], n);
  store(&p.h[i], smoothing_length(load(&p.pt.m[i], n), pt.rho, h_0), n);
}

}  // namespace

void update_particles(const UpdateView& v, std::size_t first, std::size_t last, double dt) {
  for (std::size_t i = first; i < last; i += W) update_pack(v, i, last - i, dt);
}

}  // namespace sph::EJECTA_ISA
