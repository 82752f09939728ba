// SPDX-License-Identifier: Apache-2.0
// How rows touch: faces that two elements share, and bonds between particles and between particles and elements. Distances
// to an element are distances to its free faces (each as two triangles), so long thin elements are treated as they are.
// Closest point on a triangle: Ericson, Real-Time Collision Detection (2005), section 5.1.5.
#include <algorithm>
#include <cmath>

#include "core/box.hpp"
#include "core/octree.hpp"
#include "core/parallel.hpp"
#include "core/rows.hpp"
#include "measure/whole.hpp"

namespace measure {
namespace {

using core::Vec3;

constexpr double bond_reach = 1.5;        // of the mean spacing of two particles
constexpr double least_expansion = 0.5;   // of the reference density: thinner material does not bond farther
constexpr std::array<std::array<int, 4>, 6> hex_faces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

struct Side {  // one face of one element, as it waits for its partner
  std::array<std::int32_t, 4> sorted;
  std::int32_t element;
  std::int32_t local;
};

std::array<std::int32_t, 4> corners_of(const Matter& m, const Side& s) {
  std::array<std::int32_t, 4> c;
  for (int a = 0; a < 4; ++a) c[a] = m.node[s.element][hex_faces[s.local][a]];
  return c;
}

std::array<std::int32_t, 4> sorted4(std::array<std::int32_t, 4> c) {
  if (c[0] > c[1]) std::swap(c[0], c[1]);
  if (c[2] > c[3]) std::swap(c[2], c[3]);
  if (c[0] > c[2]) std::swap(c[0], c[2]);
  if (c[1] > c[3]) std::swap(c[1], c[3]);
  if (c[1] > c[2]) std::swap(c[1], c[2]);
  return c;
}

Side side_of(const Matter& m, std::uint32_t number) {
  Side side{{}, static_cast<std::int32_t>(number / 6), static_cast<std::int32_t>(number % 6)};
  side.sorted = sorted4(corners_of(m, side));
  return side;
}

/// Sides, numbered 6 to the element, in rows by their lowest node, of nodes [first, last).
void bucket_sides(const Matter& m, std::size_t first, std::size_t last, std::vector<std::uint32_t>& start, std::vector<std::uint32_t>& sides) {
  core::sort_into_rows(
      last - first,
      [&](auto&& put) {
        for (std::uint32_t el = 0; el < m.n_elements; ++el) {
          const auto [low, high] = std::minmax_element(m.node[el].begin(), m.node[el].end());
          if (static_cast<std::size_t>(*high) < first || static_cast<std::size_t>(*low) >= last) continue;
          for (std::uint32_t s = 6 * el; s < 6 * el + 6; ++s)
            if (const std::size_t nd = static_cast<std::size_t>(side_of(m, s).sorted[0]) - first; nd < last - first) put(nd, s);
        }
      },
      start, sides);
}

double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - ab * (d1 / std::max(d1 - d3, 1e-300))).squaredNorm();
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - ac * (d2 / std::max(d2 - d6, 1e-300))).squaredNorm();
  const double along = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6) return (bp - (c - b) * ((d4 - d3) / std::max(along, 1e-300))).squaredNorm();
  const double sum = std::max(va + vb + vc, 1e-300);
  return (ap - ab * (vb / sum) - ac * (vc / sum)).squaredNorm();
}

/// The particles, sorted in space, with the spacing that decides about their bonds.
struct Particles {
  std::vector<Vec3> x;
  std::vector<double> spacing;
  double largest = 0;
  core::Octree tree;
};

bool parts_slowly(const Matter& m, std::size_t i, std::size_t j, double speed_limit) {
  return (m.v[i] - m.v[j]).squaredNorm() < speed_limit * speed_limit;
}

void bond_particles(const Matter& m, const Particles& p, double speed_limit, std::vector<Bond>& bonds) {
  std::vector<double> radius(p.spacing);
  for (double& r : radius) r *= bond_reach;
  core::Neighbours near;
  p.tree.neighbours(radius, true, near);
  for (std::size_t i = 0; i < p.x.size(); ++i)
    for (std::uint64_t k = near.start[i]; k < near.start[i + 1]; ++k) {
      const std::size_t j = near.list[k];
      if (j <= i) continue;
      const double reach = bond_reach * 0.5 * (p.spacing[i] + p.spacing[j]);
      if ((p.x[i] - p.x[j]).squaredNorm() >= reach * reach) continue;
      const std::size_t row_i = m.n_elements + i, row_j = m.n_elements + j;
      if (parts_slowly(m, row_i, row_j, speed_limit))
        bonds.push_back({static_cast<std::uint32_t>(row_i), static_cast<std::uint32_t>(row_j)});
    }
}

void bond_to_face(const Matter& m, const Face& face, const Particles& p, double speed_limit,
                  std::vector<std::uint32_t>& found, std::vector<Bond>& bonds) {
  const Vec3 &a = m.node_x[face.node[0]], &b = m.node_x[face.node[1]], &c = m.node_x[face.node[2]],
             &d = m.node_x[face.node[3]];
  const Vec3 margin = Vec3::Constant(p.largest);
  found.clear();
  p.tree.in_box(a.cwiseMin(b).cwiseMin(c).cwiseMin(d) - margin, a.cwiseMax(b).cwiseMax(c).cwiseMax(d) + margin, found);
  for (const std::uint32_t k : found) {
    const double distance2 = std::min(squared_distance(p.x[k], a, b, c), squared_distance(p.x[k], a, c, d));
    if (distance2 >= p.spacing[k] * p.spacing[k]) continue;
    const std::size_t row = m.n_elements + k;
    if (parts_slowly(m, face.a, row, speed_limit))
      bonds.push_back({static_cast<std::uint32_t>(face.a), static_cast<std::uint32_t>(row)});
  }
}

/// Cells of a coarse grid that particles come near: most faces of a scene are far from all of them.
class NearParticles {
 public:
  explicit NearParticles(const Particles& p) {
    low_ = high_ = p.x[0];
    for (const Vec3& x : p.x) low_ = low_.cwiseMin(x), high_ = high_.cwiseMax(x);
    low_.array() -= 2 * p.largest;
    high_.array() += 2 * p.largest;
    cell_ = std::max(2 * p.largest, (high_ - low_).maxCoeff() / 160);
    for (int k = 0; k < 3; ++k) n_[k] = static_cast<int>((high_[k] - low_[k]) / cell_) + 1;
    near_.assign(static_cast<std::size_t>(n_[0]) * n_[1] * n_[2], 0);
    const Vec3 margin = Vec3::Constant(p.largest);
    for (const Vec3& x : p.x) each_cell(x - margin, x + margin, [&](char& c) { c = 1; });
  }
  bool touches(const Vec3& low, const Vec3& high) const {
    if ((high.array() < low_.array()).any() || (low.array() > high_.array()).any()) return false;
    bool result = false;
    const_cast<NearParticles*>(this)->each_cell(low, high, [&](const char& c) { result = result || c != 0; });
    return result;
  }

 private:
  template <class F>
  void each_cell(const Vec3& low, const Vec3& high, F&& f) {
    std::array<int, 3> a, b;
    for (int k = 0; k < 3; ++k) {
      a[k] = static_cast<int>(std::clamp((low[k] - low_[k]) / cell_, 0.0, n_[k] - 1.0));
      b[k] = static_cast<int>(std::clamp((high[k] - low_[k]) / cell_, 0.0, n_[k] - 1.0));
    }
    for (int i = a[0]; i <= b[0]; ++i)
      for (int j = a[1]; j <= b[1]; ++j)
        for (int k = a[2]; k <= b[2]; ++k) f(near_[(static_cast<std::size_t>(i) * n_[1] + j) * n_[2] + k]);
  }
  Vec3 low_, high_;
  double cell_ = 1;
  std::array<int, 3> n_{1, 1, 1};
  std::vector<char> near_;
};

void bond_elements(const Matter& m, const Particles& p, double speed_limit, std::vector<Bond>& bonds) {
  const NearParticles near(p);
  const auto faces = faces_where(m, [&](const Face& f) {
    core::Box box;
    for (const std::int32_t nd : f.node) box.add(m.node_x[nd]);
    return f.b < 0 && near.touches(box.low, box.high);
  });
  constexpr std::size_t block = 512;
  std::vector<std::vector<Bond>> part((faces.size() + block - 1) / block);
  core::for_each_block(faces.size(), block, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint32_t> found;
    for (std::size_t k = first; k < last; ++k) bond_to_face(m, faces[k], p, speed_limit, found, part[first / block]);
  });
  for (const auto& piece : part) bonds.insert(bonds.end(), piece.begin(), piece.end());
}

}  // namespace

std::vector<Face> faces_where(const Matter& m, const std::function<bool(const Face&)>& wanted) {
  constexpr std::size_t at_once = 1 << 21;  // nodes whose faces are sorted at a time
  std::vector<std::uint32_t> start, sides;
  std::vector<Side> row;
  std::vector<Face> faces;
  for (std::size_t first = 0; first < m.node_x.size(); first += at_once) {
    bucket_sides(m, first, std::min(first + at_once, m.node_x.size()), start, sides);
    for (std::size_t nd = 0; nd + 1 < start.size(); ++nd) {
      row.clear();
      for (std::uint32_t k = start[nd]; k < start[nd + 1]; ++k) row.push_back(side_of(m, sides[k]));
      for (std::size_t k = 0; k < row.size(); ++k) {
        if (row[k].element < 0) continue;
        Face face{corners_of(m, row[k]), row[k].element, -1};
        for (std::size_t l = k + 1; l < row.size(); ++l) {
          if (row[l].element < 0 || row[l].sorted != row[k].sorted) continue;
          face.b = row[l].element;
          row[l].element = -1;
          break;
        }
        if (wanted(face)) faces.push_back(face);
      }
    }
  }
  return faces;
}

double bond_spacing(const Matter& m, const Scene& scene, std::size_t row) {
  const double rho_least = least_expansion * scene.bodies[m.body[row]].rho_0;
  if (rho_least <= 0 || m.rho.empty() || m.rho[row] >= rho_least) return m.size[row];
  return std::min(m.size[row], std::cbrt(m.m[row] / rho_least));
}

std::vector<Bond> all_bonds(const Matter& m, const Scene& scene, double speed_limit) {
  std::vector<Bond> bonds;
  if (m.x.size() == m.n_elements) return bonds;
  Particles p;
  for (std::size_t row = m.n_elements; row < m.x.size(); ++row) {
    p.x.push_back(m.x[row]);
    p.spacing.push_back(bond_spacing(m, scene, row));
    p.largest = std::max(p.largest, p.spacing.back());
  }
  p.tree.build(p.x);
  bond_particles(m, p, speed_limit, bonds);
  bond_elements(m, p, speed_limit, bonds);
  return bonds;
}

}  // namespace measure
