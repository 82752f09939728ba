// SPDX-License-Identifier: Apache-2.0
#include "coupling/convert.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/hex8.hpp"

namespace coupling {

using core::Vec3;

/// Kinetic energy that the corners of an element carry of its mass [J].
static double corner_kinetic(const fem::Mesh& mesh, std::size_t el) {
  double k = 0;
  for (const auto nd : mesh.elements.node[el]) k += mesh.nodes.v[static_cast<std::size_t>(nd)].squaredNorm();
  return 0.0625 * mesh.elements.pt.m[el] * k;
}

static void copy_row(core::Points& from, std::size_t row, core::Points& to, std::size_t new_row) {
  std::vector<std::vector<double>*> source;
  from.each_field([&](std::vector<double>& a) { source.push_back(&a); });
  std::size_t k = 0;
  to.each_field([&](std::vector<double>& a) { a[new_row] = (*source[k++])[row]; });
}

/// Speeds up what an element's corners still belong to along their velocities relative to each other: momentum stays, and at
/// most `lost` [J] of kinetic energy stays with it. Corner c with the mass m/8 that goes and M that is left gains the momentum
///   a (m/8) w (v_c - v_w),  w = M/(M + m/8),  v_w the mean by w,  a <= 1
/// in each direction that is free. Returns what stayed [J].
static double leave_to_neighbours(fem::Mesh& mesh, std::size_t el, double lost) {
  constexpr double most = 1;  // of the deviation of an element's momentum from its particle's
  fem::Nodes& n = mesh.nodes;
  const auto& corner = mesh.elements.node[el];
  const double m = 0.125 * mesh.elements.pt.m[el];
  std::array<Vec3, 8> weight, apart;
  double linear = 0, quadratic = 0;
  for (int d = 0; d < 3; ++d) {
    double sum = 0, mean = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      const auto nd = static_cast<std::size_t>(corner[c]);
      weight[c][d] = n.fixed[nd] >> d & 1 ? 0.0 : n.m[nd] / (n.m[nd] + m);
      sum += weight[c][d];
      mean += weight[c][d] * n.v[nd][d];
    }
    if (!(sum > 0)) continue;
    mean /= sum;
    for (std::size_t c = 0; c < 8; ++c) {
      const auto nd = static_cast<std::size_t>(corner[c]);
      apart[c][d] = n.v[nd][d] - mean;
      linear += m * weight[c][d] * apart[c][d] * apart[c][d];
      if (weight[c][d] > 0) quadratic += m * m * weight[c][d] * weight[c][d] / n.m[nd] * apart[c][d] * apart[c][d];
    }
  }
  if (!(linear > 0) || !(lost > 0)) return 0;
  // linear a + quadratic a^2/2 = lost
  const double a = std::min(most, 2 * lost / (linear + std::sqrt(linear * linear + 2 * quadratic * lost)));
  for (std::size_t c = 0; c < 8; ++c) {
    const auto nd = static_cast<std::size_t>(corner[c]);
    for (int d = 0; d < 3; ++d)
      if (weight[c][d] > 0) n.v[nd][d] += a * m * weight[c][d] * apart[c][d] / n.m[nd];
  }
  return a < most ? lost : a * (linear + 0.5 * a * quadratic);
}

/// Mean strain rate of an element, xx yy zz and xy yz zx [1/s].
static void strain_rate(const fem::Mesh& mesh, std::size_t el, Vec3& stretch, Vec3& shear) {
  fem::Corners<double> x, v;
  fem::gather(mesh.elements, el, mesh.nodes.x, [&](int i, int d, double a) { x.c[i][d] = a; });
  fem::gather(mesh.elements, el, mesh.nodes.v, [&](int i, int d, double a) { v.c[i][d] = a; });
  const auto m = fem::modes(x);
  const auto g = fem::gradient(m);
  double l[3][3];
  fem::contract(fem::modes(v), g, l);
  const double inverse = 1 / fem::volume(m, g);
  stretch = inverse * Vec3(l[0][0], l[1][1], l[2][2]);
  shear = 0.5 * inverse * Vec3(l[0][1] + l[1][0], l[1][2] + l[2][1], l[2][0] + l[0][2]);
}

constexpr std::size_t most_parts = 27;
using PartMasses = std::array<double, most_parts>;  ///< of the parts of an element [kg]

static PartMasses equal_masses(const fem::Mesh& mesh, std::size_t el, int n) {
  PartMasses m{};
  m.fill(mesh.elements.pt.m[el] / (n * n * n));
  return m;
}

/// Volume of part k of an n x n x n division of the parent cube [m3]. Parts are trilinear hexes themselves and add up to the element.
static double part_volume(const fem::Mesh& mesh, std::size_t el, int n, int k) {
  const Vec3 centre = fem::part_centre(n, k);
  fem::Corners<double> x;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = fem::at(mesh, el, mesh.nodes.x, centre + fem::corner(i) / n);
    for (int d = 0; d < 3; ++d) x.c[i][d] = corner[d];
  }
  const auto m = fem::modes(x);
  return fem::volume(m, fem::gradient(m));
}

/// What a body that begins as particles is made of. Equal masses in the unequal parts of a sphere's skewed hexes, three an edge, 4 hexes across, would
/// be lumps of 0.75 to 1.6 of its density, and strike at 2.6 times the pressure of the Hugoniot.
static PartMasses masses_by_volume(const fem::Mesh& mesh, std::size_t el, int n) {
  PartMasses m{};
  double all = 0;
  for (int k = 0; k < n * n * n; ++k) all += m[static_cast<std::size_t>(k)] = part_volume(mesh, el, n, k);
  for (double& part : m) part = mesh.elements.pt.m[el] * (part / all);
  return m;
}

/// The particles of one element, from row `first` on. Returns their kinetic energy [J].
static double make_particles(fem::Mesh& mesh, sph::Particles& p, std::size_t el, int n, std::size_t first, const PartMasses& mass) {
  fem::Elements& e = mesh.elements;
  double kinetic = 0;
  Vec3 stretch, shear;
  strain_rate(mesh, el, stretch, shear);
  std::size_t i = first;
  for (int k = 0; k < n * n * n; ++k, ++i) {
    const Vec3 xi = fem::part_centre(n, k);
    copy_row(e.pt, el, p.pt, i);
    p.pt.m[i] = mass[static_cast<std::size_t>(k)];
    p.pt.q[i] = 0;
    p.x[i] = fem::at(mesh, el, mesh.nodes.x, xi);
    p.v[i] = fem::at(mesh, el, mesh.nodes.v, xi);
    p.v_mean[i] = p.v[i];
    p.body[i] = e.body(el);
    p.parent[i] = static_cast<std::uint32_t>(el);
    p.id[i] = static_cast<std::uint32_t>(i);
    p.spread[i] = 1;
    p.stretch[i] = stretch;
    p.shear[i] = shear;
    p.dt[i] = e.dt[el];
    sph::set_smoothing_length(p, i);
    kinetic += 0.5 * p.pt.m[i] * p.v[i].squaredNorm();
  }
  return kinetic;
}

static double convert(fem::Mesh& mesh, sph::Particles& p, std::size_t el, std::size_t first, int per_edge) {
  const std::size_t each = static_cast<std::size_t>(per_edge * per_edge * per_edge);
  double lost = corner_kinetic(mesh, el) - make_particles(mesh, p, el, per_edge, first, equal_masses(mesh, el, per_edge));
  fem::remove_element(mesh, el, false);
  lost -= leave_to_neighbours(mesh, el, lost);
  for (std::size_t k = first; k < first + each; ++k) p.pt.e[k] += lost / mesh.elements.pt.m[el];
  return lost;
}

Removal convert_elements(fem::Mesh& mesh, sph::Particles& particles, std::span<const std::uint32_t> elements,
                         int per_edge) {
  Removal r;
  const std::size_t each = static_cast<std::size_t>(per_edge * per_edge * per_edge);
  std::size_t next = particles.size();
  particles.resize(next + each * elements.size());
  for (const auto el : elements) {
    r.conversion += convert(mesh, particles, el, next, per_edge);
    next += each;
  }
  return r;
}

void fill_with_particles(fem::Mesh& mesh, sph::Particles& particles, std::span<const std::uint32_t> elements, int per_edge) {
  const std::size_t each = static_cast<std::size_t>(per_edge * per_edge * per_edge);
  std::size_t next = particles.size();
  particles.resize(next + each * elements.size());
  for (const auto el : elements) {
    make_particles(mesh, particles, el, per_edge, next, masses_by_volume(mesh, el, per_edge));
    next += each;
  }
}

Removal erode_elements(fem::Mesh& mesh, std::span<const std::uint32_t> elements, bool keep_nodes) {
  Removal r;
  const fem::Elements& e = mesh.elements;
  for (const auto el : elements) {
    const double booked = e.booked.empty() ? 0 : e.booked[el];
    r.eroded_internal += e.pt.m[el] * e.pt.e[el] - booked;
    r.eroded_booked += booked;
    if (!keep_nodes) {
      r.eroded_kinetic += corner_kinetic(mesh, el);
      r.eroded_mass += e.pt.m[el];
      for (const auto node : e.node[el]) {
        const auto nd = static_cast<std::size_t>(node);
        const Vec3 momentum = 0.125 * e.pt.m[el] * mesh.nodes.v[nd];
        r.eroded_momentum += momentum;
        r.eroded_angular_momentum += mesh.nodes.x[nd].cross(momentum);
      }
    }
    fem::remove_element(mesh, el, keep_nodes);
  }
  return r;
}

}  // namespace coupling
