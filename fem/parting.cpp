// SPDX-License-Identifier: Apache-2.0
#include "fem/parting.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/box.hpp"
#include "core/cells.hpp"
#include "fem/element_kernel.hpp"
#include "fem/surface.hpp"

namespace fem {

using core::Box;
using core::Vec3;

namespace {

constexpr double round_off = 1e-6;  // of a face's edge; half of what contact still takes for outside
constexpr double deepest = 0.25;    // of a face's edge
constexpr double through = 0.5;     // of what lies behind it

Box common(const Box& a, const Box& b) {
  Box r;
  r.low = a.low.cwiseMax(b.low), r.high = a.high.cwiseMin(b.high);
  return r;
}

/// Do two boxes have more in common than round-off?
bool overlap(const Box& a, const Box& b) {
  const Box both = common(a, b);
  const double size = std::max((a.high - a.low).maxCoeff(), (b.high - b.low).maxCoeff());
  return ((both.high - both.low).array() > 1e-9 * size).all();
}

/// A face that a node may lie behind.
struct Sheet {
  std::array<Vec3, 4> corner;
  Vec3 centre;
  double edge, behind;  ///< root of its area, and the mean thickness of its element [m]
  Box box;              ///< round the face and what lies behind it as far as `deepest`
};

Sheet sheet_of(const Mesh& mesh, const Face& face) {
  Sheet s;
  s.centre = Vec3::Zero();
  const FaceNodes node = face_nodes(mesh, face);
  for (std::size_t k = 0; k < 4; ++k) s.corner[k] = mesh.nodes.x[node[k]], s.centre += 0.25 * s.corner[k];
  const double area = 0.5 * (s.corner[2] - s.corner[0]).cross(s.corner[3] - s.corner[1]).norm();
  s.edge = std::sqrt(area);
  s.behind = mesh.elements.volume_0[face.element] / area;
  for (const Vec3& x : s.corner) s.box.add(x);
  s.box = s.box.widened(deepest * s.edge);
  return s;
}

/// How the node gets out of the sheet by the shortest way, if it lies behind it; of triangles that are as near the mean.
struct WayOut {
  double depth = 1e300;
  Vec3 sum = Vec3::Zero();
  int n = 0;

  void look_at(const Sheet& s, const Vec3& x) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 a = s.corner[k] - s.centre, b = s.corner[(k + 1) % 4] - s.centre, d = x - s.centre, cross = a.cross(b);
      const double area2 = cross.norm();
      if (!(area2 > 0)) continue;
      const Vec3 normal = cross / area2;
      const double here = -normal.dot(d);
      if (!(here > round_off * s.edge) || here > std::min(deepest * s.edge, through * s.behind)) continue;
      const Vec3 foot = d + here * normal;
      const double u = normal.dot(foot.cross(b)) / area2, v = normal.dot(a.cross(foot)) / area2;
      constexpr double rim = 1e-6;
      if (u < -rim || v < -rim || u + v > 1 + rim) continue;
      if (here > depth * (1 + 1e-6)) continue;
      if (here < depth * (1 - 1e-6)) depth = here, sum = Vec3::Zero(), n = 0;
      sum += here * normal, ++n;
    }
  }
};

/// Moves the nodes of one body out of another's faces.
std::size_t part(Mesh& mesh, const std::vector<std::uint32_t>& nodes, const std::vector<Face>& faces, const Box& both) {
  std::vector<Sheet> sheets;
  double widest = 0;
  for (const Face& f : faces) {
    const Sheet s = sheet_of(mesh, f);
    if (!s.box.touches(both)) continue;
    widest = std::max(widest, (s.box.high - s.box.low).maxCoeff());
    sheets.push_back(s);
  }
  if (sheets.empty()) return 0;
  core::Cells cells;
  cells.reset(widest);
  std::vector<std::vector<std::uint32_t>> in_cell;
  for (std::uint32_t k = 0; k < sheets.size(); ++k) {
    const core::Cell low = cells.cell(sheets[k].box.low), high = cells.cell(sheets[k].box.high);
    for (auto i = low[0]; i <= high[0]; ++i)
      for (auto j = low[1]; j <= high[1]; ++j)
        for (auto l = low[2]; l <= high[2]; ++l) {
          const auto c = cells.insert({i, j, l});
          if (c == in_cell.size()) in_cell.emplace_back();
          in_cell[c].push_back(k);
        }
  }
  std::size_t moved = 0;
  for (const auto nd : nodes) {
    Vec3& x = mesh.nodes.x[nd];
    if (!both.contains(x)) continue;
    const auto c = cells.find(cells.cell(x));
    if (c == core::Cells::none) continue;
    WayOut way;
    for (const auto k : in_cell[c]) way.look_at(sheets[k], x);
    if (way.n == 0) continue;
    x += free_part(way.sum / way.n, mesh.nodes.fixed[nd]);
    ++moved;
  }
  return moved;
}

}  // namespace

bool part_bodies(Mesh& mesh) {
  const std::size_t n_bodies = mesh.body_nodes.size();
  Surface surface;
  std::vector<std::vector<Face>> faces(n_bodies);
  std::vector<std::vector<std::uint32_t>> nodes(n_bodies);
  std::size_t moved = 0;
  for (std::size_t a = 0; a < n_bodies; ++a)
    for (std::size_t b = a + 1; b < n_bodies; ++b) {
      if (!overlap(mesh.body_box[a], mesh.body_box[b])) continue;
      if (!surface.built) {
        update_surface(mesh, surface);
        for (const Face& f : surface.faces) faces[mesh.elements.body(f.element)].push_back(f);
        for (std::size_t body = 0; body < n_bodies; ++body)
          for (const auto nd : surface.nodes)
            if (nd >= mesh.body_nodes[body].first && nd < mesh.body_nodes[body].last) nodes[body].push_back(nd);
      }
      const Box both = common(mesh.body_box[a], mesh.body_box[b]);
      // on an edge, and on the planes of symmetry, the mean way out leaves a part of the way to go
      constexpr int most_rounds = 8;
      for (int round = 0; round < most_rounds; ++round) {
        const std::size_t now = part(mesh, nodes[a], faces[b], both) + part(mesh, nodes[b], faces[a], both);
        if (now == 0) break;
        moved += now;
      }
    }
  if (moved == 0) return false;
  Elements& e = mesh.elements;
  element_volumes(mesh, e.volume_0);
  for (std::size_t el = 0; el < e.size(); ++el)
    if (e.alive[el]) e.pt.m[el] = e.pt.rho[el] * e.volume_0[el];
  finish(mesh);
  return true;
}

}  // namespace fem
