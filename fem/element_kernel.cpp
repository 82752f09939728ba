// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see element_kernel.hpp for what it does.
#include "fem/element_kernel.hpp"

#include <cmath>

#include "core/isa.hpp"
#include "core/lane_math.hpp"
#include "fem/hex8.hpp"
#include "material/update.hpp"

namespace fem::EJECTA_ISA {

using Real = core::Pack<core::native_lanes>;
constexpr int W = core::native_lanes;
static_assert(block_size % W == 0);

/// Corners of W consecutive elements.
static void gather_lanes(const std::int32_t (*node)[8], const double* a, Corners<Real>& c) {
  alignas(64) double buffer[24][W];
  for (int l = 0; l < W; ++l)
    for (int i = 0; i < 8; ++i) {
      const double* p = a + 3 * static_cast<std::size_t>(node[l][i]);
      for (int d = 0; d < 3; ++d) buffer[i * 3 + d][l] = p[d];
    }
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) c.c[i][d] = core::load<Real>(buffer[i * 3 + d]);
}

/// Work that the corner forces did on the nodes: sum of f . v [W].
static Real corner_power(const double* force, const Corners<Real>& v) {
  Real power(0.0);
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) power += core::load<Real>(force + (i * 3 + d) * block_size) * v.c[i][d];
  return power;
}

static void load_point(const core::Points& pt, std::size_t el, material::Point<Real>& r) {
  r.rho = core::load<Real>(&pt.rho[el]);
  r.e = core::load<Real>(&pt.e[el]);
  r.p = core::load<Real>(&pt.p[el]);
  r.c = core::load<Real>(&pt.c[el]);
  r.temperature = core::load<Real>(&pt.T[el]);
  for (std::size_t k = 0; k < 6; ++k) r.s[k] = core::load<Real>(&pt.s[k][el]);
  r.eps_p = core::load<Real>(&pt.eps_p[el]);
  r.damage = core::load<Real>(&pt.damage[el]);
}

static void store_point(core::Points& pt, std::size_t el, const material::Point<Real>& r) {
  core::store(&pt.rho[el], r.rho);
  core::store(&pt.e[el], r.e);
  core::store(&pt.p[el], r.p);
  core::store(&pt.c[el], r.c);
  core::store(&pt.T[el], r.temperature);
  for (std::size_t k = 0; k < 6; ++k) core::store(&pt.s[k][el], r.s[k]);
  core::store(&pt.eps_p[el], r.eps_p);
  core::store(&pt.damage[el], r.damage);
  core::store(&pt.p_max[el], core::max(r.p, core::load<Real>(&pt.p_max[el])));
}

/// Hourglass forces, subtracted from the corner forces f; returns their power [W].
static Real add_hourglass(const ElementSettings& set, const StepTimes& times, const Corners<Real>& x,
                          const Corners<Real>& v, const Gradient<Real>& g, Real inverse_volume, Real mass, Real rho_c,
                          Real c, Real length, double* stored, Real f[8][3]) {
  Real gamma[4][8];
  hourglass_shape(x, g, inverse_volume, gamma);
  // A mode of amplitude u at every corner has the rate 8 u and feels a force of 8 k u against a mass of m / 8: the
  // viscous form stays stable below m / (64 dt) and is held to half of that.
  const Real viscous = core::min(Real(set.hourglass / 4) * rho_c * length * length,
                                 mass * Real(0.5 / (64 * times.drift)));
  const Real stiffness = Real(set.hourglass / 4 * times.drift) * rho_c * c * length;
  Real power(0.0);
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d) {
      Real rate(0.0);
      for (int i = 0; i < 8; ++i) rate += gamma[a][i] * v.c[i][d];
      Real force;
      if (set.hourglass_stiffness) {
        double* q = stored + (a * 3 + d) * block_size;
        const Real old = core::load<Real>(q);
        force = old + stiffness * rate;
        core::store(q, force);
        power += Real(0.5) * (old + force) * rate;
      } else {
        force = viscous * rate;
        power += force * rate;
      }
      for (int i = 0; i < 8; ++i) f[i][d] -= force * gamma[a][i];
    }
  return power;
}

struct Context {
  Mesh& mesh;
  const material::Material& material;
  const ElementSettings& settings;
  const StepTimes& times;
};

/// One pack of elements starting at row el; returns the hourglass work [J].
static double update_pack(const Context& k, std::size_t el) {
  Elements& e = k.mesh.elements;
  const Nodes& n = k.mesh.nodes;
  const std::int32_t(*node)[8] = reinterpret_cast<const std::int32_t(*)[8]>(e.node[el].data());
  alignas(64) double alive_lane[W];
  bool any_alive = false;
  for (int l = 0; l < W; ++l) {
    alive_lane[l] = e.alive[el + static_cast<std::size_t>(l)];
    any_alive = any_alive || alive_lane[l] != 0;
  }
  if (!any_alive) return 0;
  const auto alive = core::load<Real>(alive_lane) > Real(0.5);

  double* force = &e.corner_force[corner_index(el, 0, 0)];
  const Real mass = core::load<Real>(&e.pt.m[el]), volume_0 = core::load<Real>(&e.volume_0[el]);
  material::Point<Real> pt;
  load_point(e.pt, el, pt);
  Corners<Real> x, v;

  // 1 the work of the forces of time n
  gather_lanes(node, n.v_mean[0].data(), v);
  pt.e = core::select(alive, pt.e - corner_power(force, v) * Real(k.times.kick) / mass, pt.e);

  // 2 velocity gradient at mid-step, volume and density at its end
  gather_lanes(node, n.x[0].data(), x);
  gather_lanes(node, n.v[0].data(), v);
  Corners<Real> mid;
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) mid.c[i][d] = x.c[i][d] - Real(0.5 * k.times.drift) * v.c[i][d];
  Gradient<Real> g;
  gradient(mid, g);
  Real l[3][3];
  contract(v, g, l);
  const Real to_rate = Real(1.0) / volume(mid, g), dt(k.times.drift), half(0.5 * k.times.drift);
  for (auto& row : l)
    for (auto& a : row) a *= to_rate;
  gradient(x, g);
  const Real vol = core::max(volume(x, g), Real(1e-3) * volume_0), inverse_volume = Real(1.0) / vol;
  const Real rho = Real(k.material.rho_0) * (volume_0 / vol);

  // 3 the material
  const material::Increment<Real> inc{
      {l[0][0] * dt, l[1][1] * dt, l[2][2] * dt, (l[0][1] + l[1][0]) * half, (l[1][2] + l[2][1]) * half,
       (l[2][0] + l[0][2]) * half},
      {(l[2][1] - l[1][2]) * half, (l[0][2] - l[2][0]) * half, (l[1][0] - l[0][1]) * half}};
  const material::Point<Real> old = pt;
  const Real q_old = core::load<Real>(&e.pt.q[el]);
  material::update(k.material, k.times.drift, rho, inc, q_old, pt);

  const Real tr = l[0][0] + l[1][1] + l[2][2], squeeze = core::max(-tr, Real(0.0));
  const Real length = core::cbrt(vol), c_q = Real(k.settings.viscosity_quadratic) * length * squeeze,
             c_l = Real(k.settings.viscosity_linear) * pt.c;
  const Real q = rho * length * squeeze * (c_q + c_l);

  // 4 corner forces and the stable step
  Real f[8][3];
  const Real sxx = pt.s[0] - pt.p - q, syy = pt.s[1] - pt.p - q, szz = pt.s[2] - pt.p - q, sxy = pt.s[3],
             syz = pt.s[4], szx = pt.s[5];
  for (int i = 0; i < 8; ++i) {
    const Real bx = g.b[i][0], by = g.b[i][1], bz = g.b[i][2];
    f[i][0] = -(sxx * bx + sxy * by + szx * bz);
    f[i][1] = -(sxy * bx + syy * by + syz * bz);
    f[i][2] = -(szx * bx + syz * by + szz * bz);
  }
  double* stored = e.hourglass.empty() ? nullptr : &e.hourglass[el / block_size * 12 * block_size + el % block_size];
  const Real power = add_hourglass(k.settings, k.times, x, v, g, inverse_volume, mass, rho * pt.c, pt.c, length, stored, f);

  const Real edge = vol / core::sqrt(largest_face_area_squared(x));
  const Real damping = core::select(squeeze > Real(0.0), c_q + c_l, Real(0.0));
  const Real dt_stable = edge / (damping + core::sqrt(damping * damping + pt.c * pt.c));

  const Real d2 = inc.d[0] * inc.d[0] + inc.d[1] * inc.d[1] + inc.d[2] * inc.d[2] +
                  Real(2.0) * (inc.d[3] * inc.d[3] + inc.d[4] * inc.d[4] + inc.d[5] * inc.d[5]);
  core::store(&e.deformation[el], core::load<Real>(&e.deformation[el]) + core::sqrt(Real(2.0 / 3.0) * d2));
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) core::store(force + (i * 3 + d) * block_size, core::select(alive, f[i][d], Real(0.0)));
  core::store(&e.dt[el], core::select(alive, dt_stable, Real(1e300)));
  core::store(&e.pt.q[el], core::select(alive, q, Real(0.0)));
  pt.rho = core::select(alive, pt.rho, old.rho);
  pt.p = core::select(alive, pt.p, old.p);
  pt.c = core::select(alive, pt.c, old.c);
  pt.temperature = core::select(alive, pt.temperature, old.temperature);
  for (int c = 0; c < 6; ++c) pt.s[c] = core::select(alive, pt.s[c], old.s[c]);
  pt.eps_p = core::select(alive, pt.eps_p, old.eps_p);
  pt.damage = core::select(alive, pt.damage, old.damage);
  store_point(e.pt, el, pt);

  const Real work = core::select(alive, power * dt, Real(0.0));
  double sum = 0;
  for (int lane = 0; lane < W; ++lane) sum += work[lane];
  return sum;
}

ElementSums update_elements(Mesh& mesh, const material::Material& material, const ElementSettings& settings,
                            const StepTimes& times, std::span<const std::uint32_t> blocks) {
  const Context k{mesh, material, settings, times};
  ElementSums sums;
  for (const std::uint32_t b : blocks)
    for (std::size_t part = 0; part < block_size; part += W) sums.hourglass += update_pack(k, b * block_size + part);
  return sums;
}

void element_volumes(const Mesh& mesh, std::vector<double>& result) {
  const Elements& e = mesh.elements;
  result.resize(e.size());
  for (std::size_t el = 0; el < e.size(); el += W) {
    Corners<Real> x;
    gather_lanes(reinterpret_cast<const std::int32_t(*)[8]>(e.node[el].data()), mesh.nodes.x[0].data(), x);
    Gradient<Real> g;
    gradient(x, g);
    core::store(&result[el], volume(x, g));
  }
}

}  // namespace fem::EJECTA_ISA
