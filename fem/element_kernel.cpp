// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see element_kernel.hpp for what it does.
#include "fem/element_kernel.hpp"

#include <array>
#include <cmath>

#include "core/lane_math.hpp"
#include "fem/hex8.hpp"
#include "fem/lanes.hpp"
#include "material/update.hpp"

namespace fem::EJECTA_ISA {

/// Positions and velocities of the corners; returns the power of the corner forces of time n, sum of f . v_mean [W].
static Real gather_motion(Index node, const Nodes& n, const double* force, Corners<Real>& x, Corners<Real>& v) {
  Real power(0.0);
  for (int i = 0; i < 8; ++i) {
    Real mean[3];
    gather_corner(node, i, n.v_mean[0].data(), mean);
    for (int d = 0; d < 3; ++d) power += core::load<Real>(force + (i * 3 + d) * block_size) * mean[d];
    gather_corner(node, i, n.x[0].data(), x.c[i]);
    gather_corner(node, i, n.v[0].data(), v.c[i]);
  }
  return power;
}

static void load_point(const core::Points& pt, std::size_t el, material::Point<Real>& r) {
  r.m = core::load<Real>(&pt.m[el]);
  r.rho = core::load<Real>(&pt.rho[el]);
  r.e = core::load<Real>(&pt.e[el]);
  r.p = core::load<Real>(&pt.p[el]);
  r.c = core::load<Real>(&pt.c[el]);
  r.temperature = core::load<Real>(&pt.T[el]);
  for (std::size_t k = 0; k < 6; ++k) r.s[k] = core::load<Real>(&pt.s[k][el]);
  r.eps_p = core::load<Real>(&pt.eps_p[el]);
  r.damage = core::load<Real>(&pt.damage[el]);
}

/// Lanes that are not alive get back what is stored (all but the energy, which they kept).
static void keep_dead(const core::Points& pt, std::size_t el, Lanes alive, material::Point<Real>& r) {
  if (!core::any(!alive)) return;
  material::Point<Real> old;
  load_point(pt, el, old);
  const auto keep = [&](Real& now, Real was) { now = core::select(alive, now, was); };
  keep(r.rho, old.rho);
  keep(r.p, old.p);
  keep(r.c, old.c);
  keep(r.temperature, old.temperature);
  for (std::size_t k = 0; k < 6; ++k) keep(r.s[k], old.s[k]);
  keep(r.eps_p, old.eps_p);
  keep(r.damage, old.damage);
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

/// Forces of the hourglass modes [mode][direction]; returns their power [W].
/// Of the stiffness form the coefficient's part beyond that of the settings, at a seam, is viscous: it comes and goes. rho_c2_l: modulus times edge.
/// kept: part of the stored forces that is left. Matter that has become softer, as it fails or thins out, gives way to them by less than it has taken up; held as
/// they were, they drove the failed lip of a hole, for its heat, until a plate of 24 mm was gone.
static Real hourglass_forces(const ElementSettings& set, Real coefficient, const StepTimes& times, Real mass, Real rho_c, Real rho_c2_l, Real length,
                             const Real rate[4][3], Real kept, double* stored, Real force[4][3]) {
  // A mode of amplitude u at every corner has the rate 8 u and feels a force of 8 k u against a mass of m / 8: the
  // viscous form stays stable below m / (64 dt) and is held to half of that.
  const Real damped = set.hourglass_stiffness ? coefficient - Real(set.hourglass) : coefficient;
  const Real viscous = core::min(Real(0.25) * damped * rho_c * length * length, mass * Real(0.5 / (64 * times.drift)));
  const Real stiffness = Real(0.25 * times.drift * set.hourglass) * rho_c2_l;
  Real power(0.0);
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d) {
      force[a][d] = viscous * rate[a][d];
      power += force[a][d] * rate[a][d];
      if (set.hourglass_stiffness) {
        double* q = stored + (a * 3 + d) * block_size;
        const Real old = kept * core::load<Real>(q), now = old + stiffness * rate[a][d];
        core::store(q, now);
        power += Real(0.5) * (old + now) * rate[a][d];
        force[a][d] += now;
      }
    }
  return power;
}

/// Corner forces of the stress [xx yy zz xy yz zx] and of the hourglass modes: f_iI = -s_ij B_jI - Q_ai gamma_aI. What gamma
/// takes from B adds to the stress, so the shape vectors are never formed.
static void corner_forces(const Real stress[6], const Gradient<Real>& g, const Real hourglass[4][3], const Modes<Real>& x,
                          Real inverse_volume, Real f[8][3]) {
  constexpr int at[3][3] = {{core::xx, core::xy, core::zx}, {core::xy, core::yy, core::yz}, {core::zx, core::yz, core::zz}};
  for (int d = 0; d < 3; ++d) {
    Real t[3];
    for (int j = 0; j < 3; ++j)
      t[j] = inverse_volume * (hourglass[0][d] * x.m[3][j] + hourglass[1][d] * x.m[4][j] + hourglass[2][d] * x.m[5][j] +
                               hourglass[3][d] * x.m[6][j]) - stress[at[d][j]];
    Real q[n_modes];
    for (int k = 0; k < n_straining; ++k) q[k] = t[0] * g.g[k][0] + t[1] * g.g[k][1] + t[2] * g.g[k][2];
    for (int a = 0; a < 3; ++a) q[n_linear + a] -= hourglass[a][d];
    q[6] = -hourglass[3][d];
    spread(q, d, f);
  }
}

struct Context {
  Mesh& mesh;
  const material::Material& material;
  const ElementSettings& settings;
  const StepTimes& times;
  std::span<const std::uint8_t> ring;
  double* none;  ///< in place of forces where there is no room for them: in a step of no length
};

/// Coefficient of the hourglass control. Particles push and pull single nodes of the elements beside them, which no mean strain
/// sees. While matter flows that is little; where it only rings, for long, it would drive hourglass motion at the expense of the
/// elements' heat, and is damped. strain: while sound crosses the element.
static Real hourglass_coefficient(const Context& k, std::size_t el, Real strain) {
  if (k.ring.empty()) return Real(k.settings.hourglass);
  constexpr double rings = 0.002;  // strain within which metals are elastic
  Real more(0.0);
  for (int lane = 0; lane < W; ++lane)
    if (k.ring[el + static_cast<std::size_t>(lane)] == 1) more.set(lane, k.settings.hourglass_at_seam);
  if (!core::any(more > Real(0.0))) return Real(k.settings.hourglass);
  const Real flows = strain * Real(1 / rings);
  return Real(k.settings.hourglass) + more / (Real(1.0) + flows * flows);
}

/// Viscosity damps a flat element's thickness mode by C_l l / edge of critical: with l = cbrt(V) an element 60 times as wide as
/// thick blows up by itself, with at most two edges it does not.
constexpr double flat = 2;

/// One pack of elements starting at row el; returns the hourglass work [J].
[[gnu::flatten]] static double update_pack(const Context& k, std::size_t el) {
  Elements& e = k.mesh.elements;
  const Nodes& n = k.mesh.nodes;
  const Lanes alive = alive_lanes(e, el);
  if (!core::any(alive)) return 0;

  double* force = force_of(e, corner_index(el, 0, 0));
  if (!force) force = k.none;
  const Real mass = core::load<Real>(&e.pt.m[el]), volume_0 = core::load<Real>(&e.volume_0[el]);
  material::Point<Real> pt;
  load_point(e.pt, el, pt);
  Corners<Real> corner_x, corner_v;

  // 1 the work of the forces of time n
  const Real power_n = gather_motion(nodes_of(e, el), n, force, corner_x, corner_v);
  pt.e = core::select(alive, pt.e - power_n * Real(k.times.kick) / mass, pt.e);

  // 2 velocity gradient at mid-step, volume and density at its end
  const Modes<Real> x = modes(corner_x), v = modes(corner_v);
  Modes<Real> mid;
  for (int m = 0; m < n_straining; ++m)
    for (int d = 0; d < 3; ++d) mid.m[m][d] = x.m[m][d] - Real(0.5 * k.times.drift) * v.m[m][d];
  const Gradient<Real> g_mid = gradient(mid);
  Real l[3][3];
  contract(v, g_mid, l);
  const Real to_rate = Real(1.0) / volume(mid, g_mid), dt(k.times.drift), half(0.5 * k.times.drift);
  for (auto& row : l)
    for (auto& a : row) a *= to_rate;
  const Gradient<Real> g = gradient(x);
  const Real vol = core::max(volume(x, g), Real(1e-3) * volume_0), inverse_volume = Real(1.0) / vol;
  const Real rho = Real(k.material.rho_0) * (volume_0 / vol);

  // 3 the material
  const material::Increment<Real> inc{
      {l[0][0] * dt, l[1][1] * dt, l[2][2] * dt, (l[0][1] + l[1][0]) * half, (l[1][2] + l[2][1]) * half,
       (l[2][0] + l[0][2]) * half},
      {(l[2][1] - l[1][2]) * half, (l[0][2] - l[2][0]) * half, (l[1][0] - l[0][1]) * half}};
  const Real q_old = core::load<Real>(&e.pt.q[el]), rho_c2_old = pt.rho * pt.c * pt.c, rho_old = pt.rho;
  material::update(k.material, k.times.drift, rho, inc, q_old, pt);

  const Real tr = l[0][0] + l[1][1] + l[2][2], squeeze = core::max(-tr, Real(0.0));
  const Real length = core::cbrt(vol), edge = vol / core::sqrt(largest_face_area_squared(x));
  const Real viscous_length = core::min(length, Real(flat) * edge);
  const Real c_q = Real(k.settings.viscosity_quadratic) * viscous_length * squeeze, c_l = Real(k.settings.viscosity_linear) * pt.c;
  const Real q = rho * viscous_length * squeeze * (c_q + c_l);

  // 4 corner forces and the stable step
  Real l_end[3][3], rate[4][3], mode[4][3], f[8][3];
  contract(v, g, l_end);
  for (auto& row : l_end)
    for (auto& a : row) a *= inverse_volume;
  hourglass_rates(x, v, l_end, rate);
  double* stored = e.hourglass.empty() ? nullptr : &e.hourglass[el / block_size * 12 * block_size + el % block_size];
  const Real d2 = inc.d[0] * inc.d[0] + inc.d[1] * inc.d[1] + inc.d[2] * inc.d[2] +
                  Real(2.0) * (inc.d[3] * inc.d[3] + inc.d[4] * inc.d[4] + inc.d[5] * inc.d[5]);
  const Real strain = core::sqrt(Real(2.0 / 3.0) * d2);
  const Real rho_c2_l = rho * pt.c * pt.c * length, kept = stored ? core::min(rho_c2_l / (rho_c2_old * core::cbrt(mass / rho_old)), Real(1.0)) : Real(1.0);
  const Real power = hourglass_forces(k.settings, hourglass_coefficient(k, el, strain * length / (pt.c * dt)), k.times, mass, rho * pt.c, rho_c2_l, length,
                                      rate, kept, stored, mode);
  const Real p_q = pt.p + q;
  const Real stress[6] = {pt.s[0] - p_q, pt.s[1] - p_q, pt.s[2] - p_q, pt.s[3], pt.s[4], pt.s[5]};
  corner_forces(stress, g, mode, x, inverse_volume, f);

  const Real reach = stable_length(g, vol, edge);
  // The linear part counts in expansion too: a step that follows the phase of the one element that sets it makes it ring louder.
  const Real damping = (c_q + c_l) * viscous_length / reach;
  const Real dt_stable = reach / (damping + core::sqrt(damping * damping + pt.c * pt.c));

  core::store(&e.deformation[el], core::load<Real>(&e.deformation[el]) + strain);
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) core::store(force + (i * 3 + d) * block_size, core::select(alive, f[i][d], Real(0.0)));
  core::store(&e.dt[el], core::select(alive, dt_stable, Real(1e300)));
  core::store(&e.pt.q[el], core::select(alive, q, Real(0.0)));
  keep_dead(e.pt, el, alive, pt);
  store_point(e.pt, el, pt);

  const Real work = core::select(alive, power * dt, Real(0.0));
  if (!e.booked.empty()) core::store(&e.booked[el], core::load<Real>(&e.booked[el]) + work);
  double sum = 0;
  for (int lane = 0; lane < W; ++lane) sum += work[lane];
  return sum;
}

/// Asks for a block ahead of its turn: its rows, one line of many arrays each, and of its nodes, in Morton order, those that no
/// block before it had. Inlined by force: g++ 12 takes a function that only prefetches for one without effect, and drops the
/// call.
[[gnu::always_inline]] inline void fetch_block(const Elements& e, const Nodes& n, std::size_t block) {
  constexpr std::size_t far_corner = 6;
  constexpr int written = 1;
  const std::size_t first = block * block_size;
  const core::Points& pt = e.pt;
  for (const auto* a : {&pt.rho, &pt.e, &pt.p, &pt.q, &pt.c, &pt.T, &pt.eps_p, &pt.damage, &pt.p_max, &e.deformation, &e.dt})
    __builtin_prefetch(a->data() + first, written);
  for (const auto& s : pt.s) __builtin_prefetch(s.data() + first, written);
  for (const auto* a : {&pt.m, &e.volume_0}) __builtin_prefetch(a->data() + first);
  for (std::size_t el = first; el < first + block_size; ++el) {
    __builtin_prefetch(e.node.data() + el + block_size);  // the next block's: those of this one are read below
    const auto nd = static_cast<std::size_t>(e.node[el][far_corner]);
    __builtin_prefetch(&n.v_mean[nd]);
    __builtin_prefetch(&n.x[nd]);
    __builtin_prefetch(&n.v[nd]);
  }
}

ElementSums update_elements(Mesh& mesh, const material::Material& material, const ElementSettings& settings,
                            const StepTimes& times, std::span<const std::uint8_t> ring, std::span<const std::uint32_t> blocks) {
  constexpr std::size_t ahead = 2;
  alignas(64) std::array<double, 24 * block_size> none{};
  const Context k{mesh, material, settings, times, ring, none.data()};
  ElementSums sums;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (b + ahead < blocks.size()) fetch_block(mesh.elements, mesh.nodes, blocks[b + ahead]);
    for (std::size_t part = 0; part < block_size; part += W) sums.hourglass += update_pack(k, blocks[b] * block_size + part);
  }
  return sums;
}

void element_volumes(const Mesh& mesh, std::vector<double>& result) {
  const Elements& e = mesh.elements;
  result.resize(e.size());
  for (std::size_t el = 0; el < e.size(); el += W) {
    Corners<Real> x;
    for (int i = 0; i < 8; ++i) gather_corner(nodes_of(e, el), i, mesh.nodes.x[0].data(), x.c[i]);
    const Modes<Real> m = modes(x);
    core::store(&result[el], volume(m, gradient(m)));
  }
}

}  // namespace fem::EJECTA_ISA
