// SPDX-License-Identifier: Apache-2.0
#include "coupling/bond.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/box.hpp"
#include "core/cells.hpp"
#include "core/parallel.hpp"
#include "core/rows.hpp"
#include "fem/elements.hpp"
#include "sph/kernel.hpp"

namespace coupling {

using core::Box;
using core::Vec3;

/// Some particles by cells of one reach, and for each cell that holds one or touches one that does, which those are.
class ParticlesByCell {
 public:
  ParticlesByCell(const sph::Particles& p, std::span<const std::uint32_t> rows, double reach) : p_(p) {
    core::Cells own;
    own.reset(reach);
    cells_.reset(reach);
    std::vector<std::uint32_t> cell(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) cell[k] = own.insert(own.cell(p.x[rows[k]]));
    core::sort_into_rows(
        own.size(),
        [&](auto&& put) {
          for (std::size_t k = 0; k < rows.size(); ++k) put(cell[k], rows[k]);
        },
        start_, index_);
    extent_.resize(own.size());
    for (std::size_t k = 0; k < rows.size(); ++k) extent_[cell[k]].add(p.x[rows[k]], p.h[rows[k]]);
    std::vector<std::uint32_t> around;
    for (std::uint32_t c = 0; c < own.size(); ++c)
      for (std::int64_t i = -1; i <= 1; ++i)
        for (std::int64_t j = -1; j <= 1; ++j)
          for (std::int64_t k = -1; k <= 1; ++k) around.push_back(cells_.insert({own[c][0] + i, own[c][1] + j, own[c][2] + k}));
    core::sort_into_rows(
        cells_.size(),
        [&](auto&& put) {
          for (std::size_t k = 0; k < around.size(); ++k) put(around[k], static_cast<std::uint32_t>(k / 27));
        },
        occupied_start_, occupied_);
    cells_.tabulate();
  }
  /// Is there one in the cell of x or in one that touches it?
  bool touch(const Vec3& x) const { return cells_.find(cells_.cell(x)) != core::Cells::none; }
  /// Is one of those nearer than `reaches` times what its kernel and one of smoothing length h reach together?
  bool within(const Vec3& x, double h, double reaches) const {
    const auto c = cells_.find(cells_.cell(x));
    const auto range_2 = [&](double h_other) {
      const double range = reaches * sph::kernel_reach * 0.5 * (h + h_other);
      return range * range;
    };
    for (auto o = occupied_start_[c]; o < occupied_start_[c + 1]; ++o) {
      const Extent& all = extent_[occupied_[o]];
      if (!(all.squared_distance(x) < range_2(all.h))) continue;
      for (auto n = start_[occupied_[o]]; n < start_[occupied_[o] + 1]; ++n)
        if ((p_.x[index_[n]] - x).squaredNorm() < range_2(p_.h[index_[n]])) return true;
    }
    return false;
  }

 private:
  /// Box around the particles of a cell, and the largest of their smoothing lengths [m].
  struct Extent {
    Box box;
    double h = 0;
    void add(const Vec3& x, double h_x) {
      box.add(x);
      h = std::max(h, h_x);
    }
    double squared_distance(const Vec3& x) const { return (box.low - x).cwiseMax(x - box.high).cwiseMax(0.0).squaredNorm(); }
  };

  const sph::Particles& p_;
  core::Cells cells_;
  std::vector<std::uint32_t> start_, index_, occupied_start_, occupied_;
  std::vector<Extent> extent_;
};

/// Box around what is left of a body.
static Box box_of(const fem::Mesh& mesh, std::size_t body) {
  if (!mesh.body_awake[body]) return mesh.body_box[body];
  const std::size_t begin = mesh.body_nodes[body].first;
  return core::reduce(
      mesh.body_nodes[body].size(), Box{},
      [&](std::size_t first, std::size_t last) {
        Box box;
        for (std::size_t nd = begin + first; nd < begin + last; ++nd)
          if (mesh.nodes.m[nd] > 0) box.add(mesh.nodes.x[nd]);
        return box;
      },
      Box::join);
}

/// Smoothing length of an element's part [m].
static double part_h(const fem::Elements& e, std::size_t el, const Bond& bond) {
  return std::min(sph::h_over_spacing * std::cbrt(e.pt.m[el] / e.pt.rho[el]) / bond.per_edge, bond.h_most);
}

void find_elements(const fem::Mesh& mesh, const sph::Particles& p, Bond& bond) {
  const fem::Elements& e = mesh.elements;
  bond.elements.clear();
  bond.watched.clear();
  bond.x.clear();
  bond.watched_x.clear();
  if (p.size() == 0 || mesh.n_alive == 0) return;
  constexpr double coarsest = 2;  // elements' smoothing lengths over the particles' at birth
  const double h_born = *std::max_element(p.h_0.begin(), p.h_0.end()), h_max = std::max(h_born, *std::max_element(p.h.begin(), p.h.end()));
  bond.h_most = coarsest * h_born;
  const double range = sph::kernel_reach * h_max * bond.per_edge;  // centres of elements lie further than those of their parts
  const double reach = sph::watched_reaches * range;
  std::vector<std::uint32_t> rows;
  std::vector<std::uint8_t> near;
  for (std::size_t b = 0; b < mesh.body_elements.size(); ++b) {
    const Box around = box_of(mesh, b).widened(reach);
    rows.clear();  // particles that can be near an element of the body
    for (std::uint32_t i = 0; i < p.size(); ++i)
      if (around.contains(p.x[i])) rows.push_back(i);
    if (rows.empty()) continue;
    const ParticlesByCell watched(p, rows, reach);
    const ParticlesByCell in_reach(p, rows, sph::foreign_reaches * 0.5 * (1 + coarsest) * range);
    const auto range_of = mesh.body_elements[b];
    near.assign(range_of.size(), 0);
    core::for_each(near.size(), [&](std::size_t k) {
      const std::size_t el = range_of.first + k;
      if (!e.alive[el]) return;
      const Vec3 x = fem::centre(mesh, el, mesh.nodes.x);
      if (!watched.touch(x)) return;
      near[k] = 1;
      if (!in_reach.touch(x)) return;
      if (in_reach.within(x, part_h(e, el, bond), sph::foreign_reaches * bond.per_edge)) near[k] = 2;
    });
    for (std::size_t k = 0; k < near.size(); ++k)
      if (near[k]) (near[k] == 2 ? bond.elements : bond.watched).push_back(static_cast<std::uint32_t>(range_of.first + k));
  }
  update_centres(mesh, bond);
}

/// How far elements and nodes are from where elements were converted, by topology. False where that is as it was.
static bool follow_seam(const fem::Mesh& mesh, Bond& bond) {
  if (bond.seam_removed == mesh.n_removed && !bond.ring.empty()) return false;
  bond.seam_removed = mesh.n_removed;
  const auto& e = mesh.elements;
  bond.on_seam.assign(mesh.nodes.size(), 0);
  bond.ring.assign(e.size(), 0);
  for (std::size_t el = 0; el < e.size(); ++el)
    if (!e.alive[el] && e.pt.m[el] > 0)  // padding has no mass
      for (const auto nd : e.node[el]) bond.on_seam[static_cast<std::size_t>(nd)] = 1;
  const auto mark_around = [&](std::size_t nd, std::uint8_t ring) {
    for (const auto el : fem::elements_at(mesh, nd)) {
      auto& r = bond.ring[el];
      if (r == 0) r = ring;
    }
  };
  for (std::size_t nd = 0; nd < bond.on_seam.size(); ++nd)
    if (bond.on_seam[nd]) mark_around(nd, 1);
  for (std::size_t el = 0; el < e.size(); ++el)
    if (bond.ring[el] == 1)
      for (const auto nd : e.node[el]) mark_around(static_cast<std::size_t>(nd), 2);
  return true;
}

/// The row of one element, appended to `to`.
static void add_seam_of(const fem::Mesh& mesh, Bond& bond, std::uint32_t el, std::vector<std::uint32_t>& to) {
  constexpr std::uint8_t taken = 0x80;  // marks what is in the row, or has been looked at, while it is made
  const auto& e = mesh.elements;
  const auto begin = static_cast<std::ptrdiff_t>(to.size());
  const auto take_corners = [&](std::size_t of) {
    for (const auto node : e.node[of])
      if (auto& mark = bond.on_seam[static_cast<std::size_t>(node)]; mark == 1) mark |= taken, to.push_back(static_cast<std::uint32_t>(node));
  };
  if (bond.ring[el] == 1) {
    take_corners(el);
  } else if (bond.ring[el] == 2) {
    std::vector<std::uint32_t> around;
    for (const auto node : e.node[el]) {
      const auto nd = static_cast<std::size_t>(node);
      for (const auto other : fem::elements_at(mesh, nd))
        if (bond.ring[other] == 1) bond.ring[other] |= taken, around.push_back(other);
    }
    for (const auto other : around) bond.ring[other] = 1, take_corners(other);
    std::sort(to.begin() + begin, to.end());
  }
  for (auto nd = to.begin() + begin; nd != to.end(); ++nd) bond.on_seam[*nd] = 1;
}

void find_seam(const fem::Mesh& mesh, Bond& bond) {
  if (follow_seam(mesh, bond)) bond.seam_of.clear();  // no row can be kept
  std::vector<std::uint32_t> of, start{0}, node;
  of.swap(bond.seam_of), start.swap(bond.seam_start), node.swap(bond.seam_node);  // the old rows, and new ones
  std::size_t old = 0;
  for (const std::uint32_t el : bond.elements) {
    while (old < of.size() && of[old] < el) ++old;
    if (old < of.size() && of[old] == el)
      bond.seam_node.insert(bond.seam_node.end(), node.begin() + start[old], node.begin() + start[old + 1]);
    else
      add_seam_of(mesh, bond, el, bond.seam_node);
    bond.seam_start.push_back(static_cast<std::uint32_t>(bond.seam_node.size()));
  }
  bond.seam_of = bond.elements;
  constexpr auto nowhere = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> row_of(mesh.nodes.size(), nowhere);
  bond.seam.clear();
  bond.seam_row.clear();
  for (const auto nd : bond.seam_node) {
    if (row_of[nd] == nowhere) row_of[nd] = static_cast<std::uint32_t>(bond.seam.size()), bond.seam.push_back(nd);
    bond.seam_row.push_back(row_of[nd]);
  }
}

void update_centres(const fem::Mesh& mesh, Bond& bond) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  bond.x.resize(bond.elements.size() * parts);
  core::for_each(bond.x.size(), [&](std::size_t k) {
    bond.x[k] = fem::at(mesh, bond.elements[k / parts], mesh.nodes.x, fem::part_centre(bond.per_edge, static_cast<int>(k % parts)));
  });
  bond.watched_x.resize(bond.watched.size());
  core::for_each(bond.watched.size(),
                 [&](std::size_t k) { bond.watched_x[k] = fem::centre(mesh, bond.watched[k], mesh.nodes.x); });
}

/// Nodes that take the reaction of the k-th bonded element.
static std::span<const std::uint32_t> seam_of(const Bond& bond, std::size_t k) {
  return std::span(bond.seam_node).subspan(bond.seam_start[k], bond.seam_start[k + 1] - bond.seam_start[k]);
}

/// Mean derivative of a nodal field in the element's parent cube.
static core::Mat3 by_corners(const fem::Mesh& mesh, std::size_t el, const std::vector<Vec3>& a) {
  double sum[3][3] = {};  // [direction in the cube][component]; in plain numbers, which stay in registers
  for (int i = 0; i < 8; ++i) {
    const Vec3 &at = a[static_cast<std::size_t>(mesh.elements.node[el][static_cast<std::size_t>(i)])], sign = fem::corner(i);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) sum[r][c] += sign[r] * at[c];
  }
  return 0.125 * Eigen::Map<const core::Mat3>(sum[0]);
}

/// The element's parent cube by its mean gradient, which hourglass motion leaves alone; a cube of its volume where that has collapsed.
static sph::Frame frame_of(const fem::Mesh& mesh, std::size_t el, const Vec3& part) {
  const fem::Elements& e = mesh.elements;
  const double volume = e.pt.m[el] / e.pt.rho[el];
  core::Mat3 per_xi = by_corners(mesh, el, mesh.nodes.x);
  constexpr double collapsed = 1e-3;
  if (!(8 * per_xi.determinant() > collapsed * volume)) per_xi = 0.5 * std::cbrt(volume) * core::Mat3::Identity();
  return {part, per_xi.inverse()};
}

/// Of the lattice that the parent cube's corners belong to.
static Vec3 nearest_corner(const Vec3& xi) {
  return 2 * (0.5 * xi).array().floor() + 1;
}

void fill_foreign(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const fem::Elements& e = mesh.elements;
  const auto parts = static_cast<std::size_t>(bond.parts());
  hood.anchor_start.assign(bond.x.size() + 1, 0);
  for (std::size_t k = 0; k < bond.x.size(); ++k)
    hood.anchor_start[k + 1] = hood.anchor_start[k] + static_cast<std::uint32_t>(seam_of(bond, k / parts).size()) + 1;
  hood.foreign_mass.resize(bond.x.size());
  using sph::single;
  const double per_unit = 1 / (hood.unit * hood.unit * hood.unit);
  core::for_each(bond.x.size(), [&](std::size_t k) {
    const std::size_t el = bond.elements[k / parts];
    const std::size_t i = hood.n_particles + k;
    sph::Actors& a = hood.actors;
    hood.foreign_mass[k] = e.pt.m[el];
    const double rho = e.pt.rho[el], volume = e.pt.m[el] / bond.parts() / rho;
    a.place[i] = {bond.x[k], single(part_h(e, el, bond)), single(volume * per_unit)};
    a.flow[i] = {fem::at(mesh, el, mesh.nodes.v, fem::part_centre(bond.per_edge, static_cast<int>(k % parts))), single(e.pt.c[el]), single(rho)};
    a.strain[i] = {};
    a.strain[i].density = single(rho);
    a.strain[i].spread = 1;
    a.p_contact[i] = single(std::max(e.pt.p[el], 0.0));
    constexpr int stranger = 1 << 20;  // a body that no particle belongs to
    a.kind[i] = sph::kind_of_body(bond.hold ? e.body(el) : stranger + e.body(el)) | sph::foreign_bit;
  });
}

/// Most elements in a list's reach of particles have none in a kernel's.
static bool lonely(const sph::Neighbourhood& hood, std::size_t k) { return hood.n_near[hood.n_particles + k] == 0; }

void fill_anchors(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  hood.anchor_xi.resize(hood.anchor_start.back());
  hood.anchor_x.resize(hood.anchor_start.back());
  hood.frame.resize(bond.x.size());
  core::for_each(bond.x.size(), [&](std::size_t k) {
    if (lonely(hood, k)) return;
    auto anchor = hood.anchor_start[k];
    const sph::Frame frame = hood.frame[k] = frame_of(mesh, bond.elements[k / parts], fem::part_centre(bond.per_edge, static_cast<int>(k % parts)));
    for (const auto nd : seam_of(bond, k / parts)) {
      hood.anchor_x[anchor] = mesh.nodes.x[nd];
      hood.anchor_xi[anchor++] = nearest_corner(frame.xi + frame.per_x * (mesh.nodes.x[nd] - bond.x[k]));
    }
    hood.anchor_x[anchor] = bond.x[k];
    hood.anchor_xi[anchor] = frame.xi;
  });
}

/// dv/dx round each foreigner's anchors: the mean over its seam's nodes of what the elements with a corner there have, in their mean motion; a foreigner
/// without a seam has its own element's.
static void fill_foreign_gradients(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  const auto rows_of = [&](std::size_t k) { return std::span(bond.seam_row).subspan(bond.seam_start[k / parts], seam_of(bond, k / parts).size()); };
  hood.foreign_gradient.resize(bond.x.size());
  core::for_each(bond.x.size(), [&](std::size_t k) {
    if (!lonely(hood, k)) hood.foreign_gradient[k] = by_corners(mesh, bond.elements[k / parts], mesh.nodes.v) * hood.frame[k].per_x;
  });
  std::vector<core::Mat3> at_node(bond.seam.size(), core::Mat3::Zero());
  std::vector<int> count(bond.seam.size(), 0);
  for (std::size_t k = 0; k < bond.x.size(); ++k)
    if (!lonely(hood, k) && bond.ring[bond.elements[k / parts]] == 1)
      for (const auto row : rows_of(k)) at_node[row] += hood.foreign_gradient[k], ++count[row];
  for (std::size_t row = 0; row < at_node.size(); ++row) {
    if (count[row] > 0) at_node[row] /= count[row];
    for (int d = 0; d < 3; ++d)  // the elements' images behind a symmetry plane have the rest
      if (mesh.nodes.fixed[bond.seam[row]] & (1 << d))
        for (const int other : {(d + 1) % 3, (d + 2) % 3}) at_node[row](d, other) = at_node[row](other, d) = 0;
  }
  core::for_each(bond.x.size(), [&](std::size_t k) {
    if (lonely(hood, k)) return;
    core::Mat3 sum = core::Mat3::Zero();
    int n = 0;
    for (const auto row : rows_of(k))
      if (count[row] > 0) sum += at_node[row], ++n;
    if (n > 0) hood.foreign_gradient[k] = sum / n;
  });
}

void fill_foreign_velocities(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  hood.anchor_v.resize(hood.anchor_xi.size());
  hood.anchor_v_mean.resize(hood.anchor_xi.size());
  core::for_each(bond.x.size(), [&](std::size_t k) {
    if (lonely(hood, k)) return;
    const std::size_t el = bond.elements[k / parts];
    const Vec3 xi = fem::part_centre(bond.per_edge, static_cast<int>(k % parts));
    const Vec3 v = fem::at(mesh, el, mesh.nodes.v, xi);
    sph::set_motion(hood, hood.n_particles + k, v);
    auto row = hood.anchor_start[k];
    for (const auto nd : seam_of(bond, k / parts)) {
      hood.anchor_v[row] = mesh.nodes.v[nd];
      hood.anchor_v_mean[row++] = mesh.nodes.v_mean[nd];
    }
    hood.anchor_v[row] = v;
    hood.anchor_v_mean[row] = fem::at(mesh, el, mesh.nodes.v_mean, xi);
  });
  fill_foreign_gradients(mesh, bond, hood);
}

void add_reaction(const sph::Neighbourhood& hood, const Bond& bond, fem::Mesh& mesh) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  std::vector<std::uint32_t> pushed;
  for (std::size_t k = 0; k < bond.x.size(); ++k) {
    if (lonely(hood, k)) continue;
    bool any = false;
    auto row = hood.anchor_start[k];
    for (const auto nd : seam_of(bond, k / parts)) {
      fem::push(mesh.nodes, nd, hood.anchor_force[row]);
      any |= !hood.anchor_force[row++].isZero(0);
    }
    if (const Vec3& push = hood.anchor_force[row]; !push.isZero(0)) {
      const Vec3 xi = fem::part_centre(bond.per_edge, static_cast<int>(k % parts));
      for (int i = 0; i < 8; ++i)
        fem::push(mesh.nodes, static_cast<std::size_t>(mesh.elements.node[bond.elements[k / parts]][static_cast<std::size_t>(i)]), fem::shape(i, xi) * push);
      any = true;
    }
    if (any) pushed.push_back(bond.elements[k / parts]);
  }
  fem::wake_elements(mesh, pushed);
}

void add_heat(const sph::Neighbourhood& hood, const Bond& bond, double dt_kick, fem::Mesh& mesh) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  core::Points& pt = mesh.elements.pt;
  for (std::size_t k = 0; k < bond.x.size(); ++k)
    pt.e[bond.elements[k / parts]] -= hood.foreign_power[k] * dt_kick / pt.m[bond.elements[k / parts]];
}

}  // namespace coupling
