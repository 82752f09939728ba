// SPDX-License-Identifier: Apache-2.0
#include "fem/surface.hpp"

#include <algorithm>
#include <tuple>

#include "fem/hex8.hpp"

namespace fem {

struct FaceKey {
  std::array<std::int32_t, 4> node;  // sorted
  std::uint32_t element;
  std::uint8_t face;
  bool operator<(const FaceKey& o) const { return std::tie(node, element, face) < std::tie(o.node, o.element, o.face); }
};

static void link_neighbours(const Mesh& mesh, Surface& s) {
  const Elements& e = mesh.elements;
  s.neighbour.assign(e.size(), {-1, -1, -1, -1, -1, -1});
  for (const auto range : mesh.body_elements) {
    std::vector<FaceKey> keys;
    keys.reserve(range.size() * 6);
    for (std::size_t el = range.first; el < range.last; ++el) {
      if (e.pt.m[el] == 0) continue;  // padding
      for (std::uint8_t f = 0; f < 6; ++f) {
        FaceKey k{{}, static_cast<std::uint32_t>(el), f};
        for (std::size_t i = 0; i < 4; ++i) k.node[i] = e.node[el][static_cast<std::size_t>(face_corner[f][i])];
        std::sort(k.node.begin(), k.node.end());
        keys.push_back(k);
      }
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t i = 0; i + 1 < keys.size(); ++i)
      if (keys[i].node == keys[i + 1].node) {
        s.neighbour[keys[i].element][keys[i].face] = static_cast<std::int32_t>(keys[i + 1].element);
        s.neighbour[keys[i + 1].element][keys[i + 1].face] = static_cast<std::int32_t>(keys[i].element);
      }
  }
}

/// A face that lies in a symmetry plane is no surface: its nodes are held in one direction and lie in one plane across it.
static bool on_symmetry_plane(const Mesh& mesh, std::size_t el, int face) {
  const auto node = [&](int k) {
    return static_cast<std::size_t>(mesh.elements.node[el][static_cast<std::size_t>(face_corner[face][k])]);
  };
  for (int d = 0; d < 3; ++d) {
    bool in_plane = true;
    for (int k = 0; k < 4; ++k)
      in_plane = in_plane && (mesh.nodes.fixed[node(k)] >> d & 1) && mesh.nodes.x[node(k)][d] == mesh.nodes.x[node(0)][d];
    if (in_plane) return true;
  }
  return false;
}

void update_surface(const Mesh& mesh, Surface& s) {
  if (s.built && s.n_removed == mesh.n_removed) return;
  if (!s.built) link_neighbours(mesh, s);
  s.built = true;
  s.n_removed = mesh.n_removed;
  s.faces.clear();
  std::vector<std::uint8_t> is_surface(mesh.nodes.size(), 0);
  const Elements& e = mesh.elements;
  for (std::size_t el = 0; el < e.size(); ++el) {
    if (!e.alive[el]) continue;
    for (int f = 0; f < 6; ++f) {
      const std::int32_t other = s.neighbour[el][static_cast<std::size_t>(f)];
      if ((other >= 0 && e.alive[static_cast<std::size_t>(other)]) || on_symmetry_plane(mesh, el, f)) continue;
      s.faces.push_back({static_cast<std::uint32_t>(el), static_cast<std::uint8_t>(f)});
      for (const int c : face_corner[f])
        is_surface[static_cast<std::size_t>(e.node[el][static_cast<std::size_t>(c)])] = 1;
    }
  }
  s.nodes.clear();
  for (std::size_t nd = 0; nd < is_surface.size(); ++nd)
    if (is_surface[nd]) s.nodes.push_back(static_cast<std::uint32_t>(nd));
}

}  // namespace fem
