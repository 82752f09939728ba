// SPDX-License-Identifier: Apache-2.0
#include "fem/criteria.hpp"

#include <bit>
#include <cmath>

#include "core/parallel.hpp"
#include "fem/elements.hpp"
#include "fem/hex8.hpp"

namespace fem {

static Corners<double> corners_of(const Mesh& mesh, std::size_t el) {
  Corners<double> x;
  gather(mesh.elements, el, mesh.nodes.x, [&](int i, int d, double v) { x.c[i][d] = v; });
  return x;
}

/// An element none of whose nodes moved keeps its shape: what the deformation says without looking at corners. Below
/// this total deformation neither ratio nor angle can have come near a useful limit.
constexpr double smallest_deformation = 0.02;

/// Is it being compressed to pressures where matter flows? Then a shock is passing or a jet forms; its corners part again
/// soon after. Converted at that moment, it gives its particles a velocity that is nobody's, turns the rest into heat, and
/// a lone particle between two surfaces is squeezed to twice the pressure that the element would have reached.
static bool in_shock(const core::Points& pt, std::size_t el) {
  constexpr double of_modulus = 0.01;
  return pt.q[el] > 0 && pt.p[el] > of_modulus * pt.rho[el] * pt.c[el] * pt.c[el];
}

/// Is it pressed no more, and does it hang on to little? Then nothing will give it back the step that it has lost.
static bool left_over(const Mesh& mesh, std::size_t el) {
  constexpr double of_modulus = 0.002;
  constexpr int most_corners = 20;  // of alive elements, at its nodes: 64 inside a body, 48 on a face, 36 on an edge, 8 alone
  const core::Points& pt = mesh.elements.pt;
  if (std::abs(pt.p[el]) + pt.q[el] > of_modulus * pt.rho[el] * pt.c[el] * pt.c[el]) return false;
  int corners = 0;
  for (const auto node : mesh.elements.node[el]) {
    const auto nd = static_cast<std::size_t>(node);
    for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k) corners += mesh.elements.alive[mesh.corners[k] / 8];
  }
  return corners <= most_corners;
}

static bool too_distorted(const Mesh& mesh, std::size_t el, const Criteria& c, double rho_0, double from) {
  const Elements& e = mesh.elements;
  if (e.dt[el] < c.collapse * e.dt_0[el]) return true;
  if (e.deformation[el] < from) return false;
  if (e.pt.rho[el] < c.expansion * rho_0) return true;
  if (in_shock(e.pt, el)) return e.deformation[el] > smallest_deformation && smallest_corner_jacobian(corners_of(mesh, el)) <= 0;
  if (c.use_deformation && e.deformation[el] > c.deformation) return true;
  if (c.use_plastic_strain && e.pt.eps_p[el] > c.plastic_strain) return true;
  if (c.use_timestep && e.dt[el] < c.timestep_ratio * e.dt_0[el]) return true;
  if (c.use_damage && e.pt.damage[el] >= c.damage) return true;
  if (from == 0 && e.dt[el] < c.left_over * e.dt_0[el] && left_over(mesh, el)) return true;
  if (e.deformation[el] < smallest_deformation) return false;
  const auto x = corners_of(mesh, el);
  if (smallest_corner_jacobian(x) <= 0) return true;
  if (!c.use_jacobian) return false;
  return jacobian_ratio(x) > c.jacobian_ratio * e.ratio_0[el] || smallest_angle(x) < c.min_angle;
}

/// Has one of a block's elements collapsed, or been deformed enough to be looked at?
static bool worth_a_look(const Elements& e, std::size_t first, double collapse, double from) {
  bool any = false;
  for (std::size_t el = first; el < first + block_size; ++el) any |= (e.dt[el] < collapse * e.dt_0[el]) | (e.deformation[el] >= from);
  return any;
}

std::vector<std::uint32_t> flag_elements(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0,
                                         double from) {
  static_assert(block_size <= 8);
  const Elements& e = mesh.elements;
  std::vector<std::uint8_t> flags(mesh.awake_blocks.size(), 0);  // one bit an element
  core::for_each(flags.size(), [&](std::size_t b) {
    const std::size_t first = mesh.awake_blocks[b] * block_size;
    if (!worth_a_look(e, first, criteria.collapse, from)) return;
    for (std::size_t l = 0; l < block_size; ++l)
      if (e.alive[first + l] && too_distorted(mesh, first + l, criteria, rho_0[e.body[first + l]], from))
        flags[b] = static_cast<std::uint8_t>(flags[b] | 1u << l);
  });
  std::vector<std::uint32_t> flagged;
  for (std::size_t b = 0; b < flags.size(); ++b)
    for (unsigned left = flags[b]; left != 0; left &= left - 1)
      flagged.push_back(static_cast<std::uint32_t>(mesh.awake_blocks[b] * block_size + static_cast<std::size_t>(std::countr_zero(left))));
  return flagged;
}

void store_initial_shape(Mesh& mesh) {
  core::for_each(mesh.elements.size(),
                 [&](std::size_t el) { mesh.elements.ratio_0[el] = jacobian_ratio(corners_of(mesh, el)); });
}

}  // namespace fem
