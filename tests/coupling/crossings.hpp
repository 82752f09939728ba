// SPDX-License-Identifier: Apache-2.0
// A slow twin of the contact search: which points crossed which faces during a step, by brute force over every point and
// every face, the step cut into pieces. It shares no code with coupling/contact.cpp; only the meaning of a face's sheet,
// four triangles about the mean of its corners, is the same.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "fem/hex8.hpp"
#include "fem/mesh.hpp"
#include "sph/particles.hpp"

namespace brute {

using core::Vec3;
using Quad = std::array<std::size_t, 4>;

struct Sheet {
  Quad node;
  int body = 0;
};

/// Faces that belong to one alive element only, corners in outward order.
inline std::vector<Sheet> exposed(const fem::Mesh& mesh) {
  struct Seen {
    int times = 0;
    Sheet sheet;
  };
  std::map<Quad, Seen> seen;
  const auto& e = mesh.elements;
  for (std::size_t el = 0; el < e.size(); ++el) {
    if (!e.alive[el]) continue;
    for (int f = 0; f < 6; ++f) {
      Sheet s;
      for (std::size_t k = 0; k < 4; ++k)
        s.node[k] = static_cast<std::size_t>(e.node[el][static_cast<std::size_t>(fem::face_corner[f][k])]);
      s.body = e.body(el);
      Quad key = s.node;
      std::sort(key.begin(), key.end());
      auto& entry = seen[key];
      ++entry.times;
      entry.sheet = s;
    }
  }
  std::vector<Sheet> r;
  for (const auto& [key, entry] : seen)
    if (entry.times == 1) r.push_back(entry.sheet);
  return r;
}

struct Moving {
  Vec3 x0, x1;
  Vec3 at(double part) const { return (1 - part) * x0 + part * x1; }
};

/// Signed distance from the plane of triangle (a, b, c), and whether the foot lies inside.
struct Foot {
  double gap = 0;
  bool inside = false;
};
inline Foot foot(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 n = (a - c).cross(b - c);
  const double area2 = n.norm();
  Foot r;
  if (!(area2 > 0)) return r;
  r.gap = n.dot(p - c) / area2;
  const double wa = n.dot((b - p).cross(c - p)), wb = n.dot((c - p).cross(a - p)), wc = n.dot((a - p).cross(b - p));
  r.inside = wa >= 0 && wb >= 0 && wc >= 0;
  return r;
}

/// Does the point cross one of the sheet's triangles from its outer side? Ends closer than `least` behind do not count.
inline bool crosses(const std::array<Moving, 4>& corner, const Moving& p, int pieces, double least) {
  const auto triangle = [&](std::size_t k, double t) {
    const Vec3 c = 0.25 * (corner[0].at(t) + corner[1].at(t) + corner[2].at(t) + corner[3].at(t));
    return std::array<Vec3, 3>{corner[k].at(t), corner[(k + 1) % 4].at(t), c};
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const auto gap = [&](double t) {
      const auto tri = triangle(k, t);
      return foot(tri[0], tri[1], tri[2], p.at(t));
    };
    Foot before = gap(0);
    for (int i = 1; i <= pieces; ++i) {
      const double t = double(i) / pieces;
      const Foot after = gap(t);
      if (before.gap >= 0 && after.gap < 0) {
        double low = double(i - 1) / pieces, high = t;
        for (int n = 0; n < 50; ++n) {
          const double mid = 0.5 * (low + high);
          (gap(mid).gap >= 0 ? low : high) = mid;
        }
        if (gap(high).inside && gap(1).gap < -least) return true;
      }
      before = after;
    }
  }
  return false;
}

/// Everything as it was when a step began.
struct Before {
  std::vector<Sheet> sheets;
  std::vector<Vec3> node, particle;
  std::vector<std::uint8_t> node_listed;
};

inline Before remember(const fem::Mesh& mesh, const sph::Particles& particles) {
  Before b;
  b.sheets = exposed(mesh);
  b.node = mesh.nodes.x;
  b.particle = particles.x;
  b.node_listed.assign(mesh.nodes.size(), 0);
  for (const auto& s : b.sheets)
    for (const auto nd : s.node) b.node_listed[nd] = 1;
  return b;
}

inline int body_of(const fem::Mesh& mesh, std::size_t nd) {
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b)
    if (mesh.body_nodes[b].contains(nd)) return static_cast<int>(b);
  return -1;
}

/// Points (particles, nodes of other bodies) that crossed a sheet between `b` and positions now.
inline std::size_t count(const Before& b, const fem::Mesh& mesh, const sph::Particles& particles, int pieces = 24) {
  std::size_t crossings = 0;
  for (const auto& s : b.sheets) {
    std::array<Moving, 4> corner;
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (std::size_t k = 0; k < 4; ++k) {
      corner[k] = {b.node[s.node[k]], mesh.nodes.x[s.node[k]]};
      low = low.cwiseMin(corner[k].x0).cwiseMin(corner[k].x1);
      high = high.cwiseMax(corner[k].x0).cwiseMax(corner[k].x1);
    }
    const double least = 1e-6 * (corner[2].x0 - corner[0].x0).norm();
    const auto test = [&](const Moving& p) {
      if ((p.x0.cwiseMax(p.x1).array() < low.array()).any() || (p.x0.cwiseMin(p.x1).array() > high.array()).any()) return;
      crossings += crosses(corner, p, pieces, least);
    };
    for (std::size_t i = 0; i < b.particle.size(); ++i) test({b.particle[i], particles.x[i]});
    for (std::size_t nd = 0; nd < b.node.size(); ++nd)
      if (b.node_listed[nd] && mesh.body_nodes.size() > 1 && body_of(mesh, nd) != s.body) test({b.node[nd], mesh.nodes.x[nd]});
  }
  return crossings;
}

}  // namespace brute
