// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see criteria_kernel.hpp for what it does.
#include "fem/criteria_kernel.hpp"

#include <cmath>

#include "fem/hex8.hpp"
#include "fem/lanes.hpp"

namespace fem::EJECTA_ISA {

/// An element none of whose nodes moved keeps its shape: what the deformation says without looking at corners. Below
/// this total deformation neither ratio nor angle can have come near a useful limit.
constexpr double smallest_deformation = 0.02;

/// Matter flows under a pressure of this part of its modulus.
constexpr double flow_pressure = 0.01;

static Real at(const std::vector<double>& a, std::size_t el) { return core::load<Real>(&a[el]); }

/// Is it being compressed to pressures where matter flows? Then a shock is passing or a jet forms; its corners part again
/// soon after. Converted at that moment, it gives its particles a velocity that is nobody's, turns the rest into heat, and
/// a lone particle between two surfaces is squeezed to twice the pressure that the element would have reached.
static Lanes in_shock(const core::Points& pt, std::size_t el) {
  const Real c = at(pt.c, el);
  return (at(pt.q, el) > Real(0.0)) & (at(pt.p, el) > Real(flow_pressure) * at(pt.rho, el) * c * c);
}

/// Has it lost its step for good? It is pressed no more, and either hangs on to little or stands beside elements that have gone
/// and has lost half of the step. It would hold the step of the whole run.
static bool left_over(const Mesh& mesh, std::size_t el) {
  constexpr double no_pressure = 0.002;  // of the modulus
  constexpr int most_corners = 20;  // of alive elements, at its nodes: 64 inside a body, 48 on a face, 36 on an edge, 8 alone
  constexpr double half = 0.5;
  const Elements& e = mesh.elements;
  const core::Points& pt = e.pt;
  const double modulus = pt.rho[el] * pt.c[el] * pt.c[el], pressure = std::abs(pt.p[el]) + pt.q[el];
  if (pressure > flow_pressure * modulus) return false;
  int alive = 0, all = 0;
  for (const auto node : e.node[el]) {
    const auto nd = static_cast<std::size_t>(node);
    for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k, ++all) alive += e.alive[element_of(mesh.corners[k])];
  }
  return (alive <= most_corners && pressure <= no_pressure * modulus) || (alive < all && e.dt[el] < half * e.dt_0[el]);
}

/// What the criteria say of quantities that an element carries.
static Lanes past_limits(const Elements& e, std::size_t el, const Criteria& c) {
  Lanes past{};
  if (c.use_deformation) past = past | (at(e.deformation, el) > Real(c.deformation));
  if (c.use_plastic_strain) past = past | (at(e.pt.eps_p, el) > Real(c.plastic_strain));
  if (c.use_timestep) past = past | (at(e.dt, el) < Real(c.timestep_ratio) * at(e.dt_0, el));
  if (c.use_damage) past = past | (at(e.pt.damage, el) >= Real(c.damage));
  return past;
}

struct Look {
  const Mesh& mesh;
  const Criteria& criteria;
  double sharpest;  ///< c|c| of the cosine of the smallest angle allowed [-]
  double from;      ///< total deformation from which elements are looked at for more than collapse [-]
};

/// Adds those of the deformed elements whose shape is no longer allowed: at once, or unless a shock passes.
static void flag_shapes(const Look& k, std::size_t el, Lanes deformed, Lanes& at_once, Lanes& after_shock) {
  Corners<Real> x;
  for (int i = 0; i < 8; ++i) gather_corner(nodes_of(k.mesh.elements, el), i, k.mesh.nodes.x[0].data(), x.c[i]);
  const Edges<Real> edge = edges(x);
  at_once = at_once | (deformed & (smallest_corner_jacobian(edge) <= Real(0.0)));
  if (!k.criteria.use_jacobian) return;
  const Real limit = Real(k.criteria.jacobian_ratio) * at(k.mesh.elements.ratio_0, el);
  after_shock = after_shock | (deformed & (jacobian_ratio(edge) > limit));
  if (k.criteria.min_angle > 0) after_shock = after_shock | (deformed & sharper_than(edge, Real(k.sharpest)));
}

/// One pack of elements starting at row el: those that are too distorted.
static Lanes flag_pack(const Look& k, std::size_t el, double rho_0) {
  const Elements& e = k.mesh.elements;
  const Criteria& c = k.criteria;
  const Real dt = at(e.dt, el), dt_0 = at(e.dt_0, el), deformation = at(e.deformation, el);
  const Lanes collapsed = dt < Real(c.collapse) * dt_0;  // never where nothing is alive: the step is 1e300 there
  const Lanes worth_it = deformation >= Real(k.from);
  if (!core::any(worth_it)) return collapsed;

  const Lanes looked_at = worth_it & alive_lanes(e, el);
  const Lanes thin = at(e.pt.rho, el) < Real(c.expansion * rho_0);
  Lanes at_once = collapsed | (looked_at & thin), after_shock = looked_at & past_limits(e, el, c);
  if (const Lanes slow = looked_at & (dt < Real(c.left_over) * dt_0); k.from == 0 && core::any(slow)) {
    Real over(0.0);
    for (int l = 0; l < W; ++l)
      if (slow[l] && left_over(k.mesh, el + static_cast<std::size_t>(l))) over.set(l, 1.0);
    after_shock = after_shock | (over > Real(0.0));
  }
  const Lanes deformed = looked_at & (deformation >= Real(smallest_deformation));
  if (core::any(deformed)) flag_shapes(k, el, deformed, at_once, after_shock);
  if (!core::any(after_shock)) return at_once;
  return at_once | (after_shock & !in_shock(e.pt, el));
}

void flag_blocks(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0, double from,
                 std::span<const std::uint32_t> blocks, std::uint8_t* flags) {
  const double cosine = std::cos(criteria.min_angle);
  const Look k{mesh, criteria, cosine * std::abs(cosine), from};
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::size_t first = blocks[b] * block_size;
    unsigned bits = 0;
    for (std::size_t part = 0; part < block_size; part += W) {
      const Lanes flag = flag_pack(k, first + part, rho_0[mesh.elements.body(first)]);
      if (core::any(flag))
        for (std::size_t l = 0; l < W; ++l) bits |= static_cast<unsigned>(flag[static_cast<int>(l)]) << (part + l);
    }
    flags[b] = static_cast<std::uint8_t>(bits);
  }
}

}  // namespace fem::EJECTA_ISA
