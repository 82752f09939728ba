// SPDX-License-Identifier: Apache-2.0
#include "coupling/bond.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/cells.hpp"
#include "core/parallel.hpp"
#include "fem/elements.hpp"
#include "sph/kernel.hpp"

namespace coupling {

using core::Vec3;

/// Cells of one reach that hold a particle or touch one that does: a coarse sieve for centres of elements.
class OccupiedCells {
 public:
  OccupiedCells(const sph::Particles& p, double reach) {
    own_.reset(reach);
    cells_.reset(reach);
    for (const Vec3& x : p.x) {
      const core::Cell c = own_.cell(x);
      const std::size_t before = own_.size();
      own_.insert(c);
      if (own_.size() == before) continue;
      for (std::int64_t i = -1; i <= 1; ++i)
        for (std::int64_t j = -1; j <= 1; ++j)
          for (std::int64_t k = -1; k <= 1; ++k) cells_.insert({c[0] + i, c[1] + j, c[2] + k});
    }
  }
  bool near(const Vec3& x) const { return cells_.find(cells_.cell(x)) != core::Cells::none; }

 private:
  core::Cells own_, cells_;
};

/// Particles by cells of the longest reach.
class ParticlesByCell {
 public:
  ParticlesByCell(const sph::Particles& p, double reach) : p_(p) {
    cells_.reset(reach);
    std::vector<std::uint32_t> cell(p.size());
    for (std::size_t i = 0; i < p.size(); ++i) cell[i] = cells_.insert(cells_.cell(p.x[i]));
    start_.assign(cells_.size() + 1, 0);
    for (const auto c : cell) ++start_[c + 1];
    for (std::size_t c = 0; c < cells_.size(); ++c) start_[c + 1] += start_[c];
    index_.resize(p.size());
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < p.size(); ++i) index_[next[cell[i]]++] = static_cast<std::uint32_t>(i);
  }
  /// Is there a particle nearer than `reaches` times what its kernel and one of smoothing length h reach together?
  bool within(const Vec3& x, double h, double reaches) const {
    const core::Cell c = cells_.cell(x);
    for (std::int64_t i = -1; i <= 1; ++i)
      for (std::int64_t j = -1; j <= 1; ++j)
        for (std::int64_t k = -1; k <= 1; ++k) {
          const auto cell = cells_.find({c[0] + i, c[1] + j, c[2] + k});
          if (cell == core::Cells::none) continue;
          for (auto n = start_[cell]; n < start_[cell + 1]; ++n) {
            const double range = reaches * sph::kernel_reach * 0.5 * (h + p_.h[index_[n]]);
            if ((p_.x[index_[n]] - x).squaredNorm() < range * range) return true;
          }
        }
    return false;
  }

 private:
  const sph::Particles& p_;
  core::Cells cells_;
  std::vector<std::uint32_t> start_, index_;
};

void find_elements(const fem::Mesh& mesh, const sph::Particles& p, Bond& bond) {
  const fem::Elements& e = mesh.elements;
  bond.elements.clear();
  bond.watched.clear();
  bond.x.clear();
  bond.watched_x.clear();
  if (p.size() == 0 || mesh.n_alive == 0) return;
  core::Vec3 low = p.x[0], high = p.x[0];
  double h_max = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    low = low.cwiseMin(p.x[i]);
    high = high.cwiseMax(p.x[i]);
    h_max = std::max(h_max, p.h[i]);
  }
  const double range = sph::kernel_reach * h_max * bond.per_edge;  // centres of elements lie further than those of their parts
  const double reach = sph::watched_reaches * range;
  low.array() -= reach;
  high.array() += reach;
  const OccupiedCells cells(p, reach);
  constexpr double coarsest = 2;  // elements' smoothing lengths are searched up to this many times the particles'
  const ParticlesByCell particles(p, sph::foreign_reaches * 0.5 * (1 + coarsest) * range);
  std::vector<std::uint8_t> near(e.size());
  const auto look_at = [&](std::size_t el) {
    if (!e.alive[el]) return;
    const Vec3& corner = mesh.nodes.x[static_cast<std::size_t>(e.node[el][0])];
    if ((corner.array() < low.array() - reach).any() || (corner.array() > high.array() + reach).any()) return;
    const Vec3 x = fem::centre(mesh, el, mesh.nodes.x);
    if (!cells.near(x)) return;
    const double h = std::min(sph::h_over_spacing * std::cbrt(e.pt.m[el] / e.pt.rho[el]) / bond.per_edge, coarsest * h_max);
    near[el] = particles.within(x, h, sph::foreign_reaches * bond.per_edge) ? 2 : 1;
  };
  for (std::size_t b = 0; b < mesh.body_elements.size(); ++b) {
    const bool apart = (mesh.body_low[b].array() > high.array() + reach).any() || (mesh.body_high[b].array() < low.array() - reach).any();
    if (apart && !mesh.body_awake[b]) continue;
    core::for_each(mesh.body_elements[b].size(), [&](std::size_t k) { look_at(mesh.body_elements[b].first + k); });
  }
  for (std::size_t el = 0; el < near.size(); ++el)
    if (near[el]) (near[el] == 2 ? bond.elements : bond.watched).push_back(static_cast<std::uint32_t>(el));
  update_centres(mesh, bond);
}

void find_seam(const fem::Mesh& mesh, Bond& bond) {
  const auto& e = mesh.elements;
  const auto elements_at = [&](std::int32_t nd) {
    const auto n = static_cast<std::size_t>(nd);
    return std::span(mesh.corners).subspan(mesh.corner_start[n], mesh.corner_start[n + 1] - mesh.corner_start[n]);
  };
  enum : std::uint8_t { no, yes, unknown };
  std::vector<std::uint8_t> on_seam(mesh.nodes.size(), unknown), at_seam(e.size(), unknown);
  const auto seam = [&](std::int32_t nd) {
    auto& on = on_seam[static_cast<std::size_t>(nd)];
    if (on == unknown) {
      const auto around = elements_at(nd);
      on = std::any_of(around.begin(), around.end(), [&](std::uint32_t corner) { return !e.alive[corner / 8]; });
    }
    return on == yes;
  };
  const auto touches_seam = [&](std::size_t el) {
    if (at_seam[el] == unknown) at_seam[el] = std::any_of(e.node[el].begin(), e.node[el].end(), seam);
    return at_seam[el] == yes;
  };
  bond.seam_start.assign(1, 0);
  bond.seam_node.clear();
  std::vector<std::uint32_t> around;
  std::vector<std::int32_t> found;
  for (const std::uint32_t el : bond.elements) {
    found.clear();
    if (touches_seam(el)) {
      for (const auto nd : e.node[el])
        if (seam(nd)) found.push_back(nd);
    } else {
      around.clear();
      for (const auto nd : e.node[el])
        for (const auto corner : elements_at(nd))
          if (touches_seam(corner / 8) && std::find(around.begin(), around.end(), corner / 8) == around.end())
            around.push_back(corner / 8);
      for (const auto other : around)
        for (const auto nd : e.node[other])
          if (seam(nd)) found.push_back(nd);
      std::sort(found.begin(), found.end());
      found.erase(std::unique(found.begin(), found.end()), found.end());
    }
    bond.seam_node.insert(bond.seam_node.end(), found.begin(), found.end());
    bond.seam_start.push_back(static_cast<std::uint32_t>(bond.seam_node.size()));
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

/// Correction of the kernel's gradient inside a cubic lattice (particle_forces.hpp): B = 1 / 0.98523 for h = 1.2 spacings.
static const double lattice_correction = [] {
  constexpr double h = sph::h_over_spacing;
  double moment = 0;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k) moment -= sph::kernel_slope(std::sqrt(double(i * i + j * j + k * k)), h) * i * i;
  return 1 / moment;
}();

void fill_foreign(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const fem::Elements& e = mesh.elements;
  const auto parts = static_cast<std::size_t>(bond.parts());
  hood.anchor_spacing = bond.per_edge;
  hood.anchor_start.assign(1, 0);
  hood.anchor_x.clear();
  for (std::size_t k = 0; k < bond.x.size(); ++k) {
    for (const auto nd : seam_of(bond, k / parts)) hood.anchor_x.push_back(mesh.nodes.x[nd]);
    hood.anchor_x.push_back(bond.x[k]);
    hood.anchor_start.push_back(static_cast<std::uint32_t>(hood.anchor_x.size()));
  }
  core::for_each(bond.x.size(), [&](std::size_t k) {
    const std::size_t el = bond.elements[k / parts];
    sph::Actor& a = hood.actors[hood.n_particles + k];
    a = {};
    a.x = bond.x[k];
    a.v = fem::at(mesh, el, mesh.nodes.v, fem::part_centre(bond.per_edge, static_cast<int>(k % parts)));
    a.m = e.pt.m[el] / bond.parts();
    a.rho = e.pt.rho[el];
    a.volume = a.m / a.rho;
    a.h = sph::h_over_spacing * std::cbrt(a.volume);
    a.c = e.pt.c[el];
    a.spread = 1;
    const double p = e.pt.p[el];
    a.p_contact = std::max(p, 0.0);
    const auto& s = e.pt.s;
    a.stress << s[0][el] - p, s[3][el], s[5][el], s[3][el], s[1][el] - p, s[4][el], s[5][el], s[4][el], s[2][el] - p;
    a.stress *= lattice_correction;
    constexpr int stranger = 1 << 20;  // a body that no particle belongs to
    a.body = bond.hold ? e.body[el] : stranger + e.body[el];
  });
}

void fill_foreign_velocities(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  hood.anchor_v_mean.resize(hood.anchor_x.size());
  core::for_each(bond.x.size(), [&](std::size_t k) {
    const std::size_t el = bond.elements[k / parts];
    const Vec3 xi = fem::part_centre(bond.per_edge, static_cast<int>(k % parts));
    sph::Actor& a = hood.actors[hood.n_particles + k];
    a.v_new = fem::at(mesh, el, mesh.nodes.v, xi);
    a.v_mean = fem::at(mesh, el, mesh.nodes.v_mean, xi);
    auto row = hood.anchor_start[k];
    for (const auto nd : seam_of(bond, k / parts)) hood.anchor_v_mean[row++] = mesh.nodes.v_mean[nd];
    hood.anchor_v_mean[row] = a.v_mean;
  });
}

void add_reaction(const sph::Neighbourhood& hood, const Bond& bond, fem::Mesh& mesh) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  std::vector<std::uint32_t> pushed;
  for (std::size_t k = 0; k < bond.x.size(); ++k) {
    bool any = false;
    auto row = hood.anchor_start[k];
    for (const auto nd : seam_of(bond, k / parts)) {
      mesh.nodes.f[nd] += hood.anchor_force[row];
      any |= !hood.anchor_force[row++].isZero(0);
    }
    if (const Vec3& push = hood.anchor_force[row]; !push.isZero(0)) {
      const Vec3 xi = fem::part_centre(bond.per_edge, static_cast<int>(k % parts));
      for (int i = 0; i < 8; ++i)
        mesh.nodes.f[static_cast<std::size_t>(mesh.elements.node[bond.elements[k / parts]][static_cast<std::size_t>(i)])] += fem::shape(i, xi) * push;
      any = true;
    }
    if (any) pushed.push_back(bond.elements[k / parts]);
  }
  fem::wake_elements(mesh, pushed);
}

void add_heat(const sph::Neighbourhood& hood, const Bond& bond, fem::Mesh& mesh) {
  const auto parts = static_cast<std::size_t>(bond.parts());
  core::Points& pt = mesh.elements.pt;
  for (std::size_t k = 0; k < bond.x.size(); ++k)
    pt.e[bond.elements[k / parts]] += hood.foreign_heat[k] / pt.m[bond.elements[k / parts]];
}

}  // namespace coupling
