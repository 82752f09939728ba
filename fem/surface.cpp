// SPDX-License-Identifier: Apache-2.0
#include "fem/surface.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <tuple>

#include "core/parallel.hpp"

namespace fem {

/// Element across a local face, alive or not; -1 where there never was one.
static std::int64_t across(const Mesh& mesh, std::size_t el, int face) {
  const FaceNodes node = face_nodes(mesh, {static_cast<std::uint32_t>(el), static_cast<std::uint8_t>(face)});
  for (const std::size_t other : elements_at(mesh, node[0])) {
    const auto& corners = mesh.elements.node[other];
    const auto holds = [&](std::uint32_t nd) { return std::find(corners.begin(), corners.end(), static_cast<std::int32_t>(nd)) != corners.end(); };
    if (other != el && holds(node[2]) && holds(node[1]) && holds(node[3])) return static_cast<std::int64_t>(other);
  }
  return -1;
}

/// A face that lies in a symmetry plane is no surface: its nodes are held in one direction and lie in one plane across it.
static bool on_symmetry_plane(const Mesh& mesh, std::size_t el, int face) {
  const FaceNodes node = face_nodes(mesh, {static_cast<std::uint32_t>(el), static_cast<std::uint8_t>(face)});
  for (int d = 0; d < 3; ++d) {
    bool in_plane = true;
    for (const auto nd : node) in_plane = in_plane && (mesh.nodes.fixed[nd] >> d & 1) && mesh.nodes.x[nd][d] == mesh.nodes.x[node[0]][d];
    if (in_plane) return true;
  }
  return false;
}

/// Counts a face in or out at its corners.
static void count_corners(const Mesh& mesh, const Face& f, int by, Surface& s) {
  for (const auto nd : face_nodes(mesh, f)) s.faces_at[nd] = static_cast<std::uint16_t>(s.faces_at[nd] + by);
}

static bool alive_then(const Surface& s, std::int64_t el) { return el >= 0 && s.alive[static_cast<std::size_t>(el)]; }

/// All faces of a mesh seen for the first time.
static void list_faces(const Mesh& mesh, Surface& s) {
  s.alive = mesh.elements.alive;
  s.faces_at.assign(mesh.nodes.size(), 0);
  s.faces.clear();
  s.nodes.clear();
  s.exposed.assign(s.alive.size(), 0);
  core::for_each(s.exposed.size(), [&](std::size_t el) {
    for (int f = 0; s.alive[el] && f < 6; ++f)
      if (!alive_then(s, across(mesh, el, f)) && !on_symmetry_plane(mesh, el, f)) s.exposed[el] = static_cast<std::uint8_t>(s.exposed[el] | 1 << f);
  });
  s.new_faces.reserve(core::sum(s.exposed.size(), std::size_t{0}, [&](std::size_t el) { return static_cast<std::size_t>(std::popcount(s.exposed[el])); }));
  for (std::size_t el = 0; el < s.exposed.size(); ++el)
    for (std::uint8_t f = 0; f < 6; ++f)
      if (s.exposed[el] >> f & 1) s.new_faces.push_back({static_cast<std::uint32_t>(el), f});
}

/// Faces that appear where elements went since; those of the elements themselves go.
static void follow_removed(const Mesh& mesh, Surface& s) {
  const Elements& e = mesh.elements;
  std::vector<std::uint32_t> removed;
  for (std::uint32_t el = 0; el < s.alive.size(); ++el)
    if (s.alive[el] != e.alive[el]) removed.push_back(el), s.exposed[el] = 0;
  for (const Face& f : s.faces)
    if (!e.alive[f.element]) count_corners(mesh, f, -1, s);
  std::erase_if(s.faces, [&](const Face& f) { return !e.alive[f.element]; });
  s.alive = e.alive;
  for (const auto el : removed)
    for (int side = 0; side < 6; ++side) {
      const auto other = across(mesh, el, side);
      if (!alive_then(s, other)) continue;
      const auto o = static_cast<std::size_t>(other);
      for (std::uint8_t f = 0; f < 6; ++f)
        if (across(mesh, o, f) == static_cast<std::int64_t>(el) && !on_symmetry_plane(mesh, o, f)) {
          s.new_faces.push_back({static_cast<std::uint32_t>(o), f});
          s.exposed[o] = static_cast<std::uint8_t>(s.exposed[o] | 1 << f);
        }
    }
}

void update_surface(const Mesh& mesh, Surface& s) {
  core::free_all(s.new_faces, s.new_nodes, s.lost_nodes);  // of the first time, all there are
  if (s.built && s.n_removed == mesh.n_removed) return;
  s.built ? follow_removed(mesh, s) : list_faces(mesh, s);
  s.built = true;
  s.n_removed = mesh.n_removed;

  const auto before = [](const Face& a, const Face& b) { return std::tie(a.element, a.face) < std::tie(b.element, b.face); };
  std::sort(s.new_faces.begin(), s.new_faces.end(), before);
  const auto middle = s.faces.insert(s.faces.end(), s.new_faces.begin(), s.new_faces.end());
  std::inplace_merge(s.faces.begin(), middle, s.faces.end(), before);
  for (const Face& f : s.new_faces) count_corners(mesh, f, 1, s);

  std::vector<std::uint32_t> nodes;
  for (std::uint32_t nd = 0; nd < s.faces_at.size(); ++nd)
    if (s.faces_at[nd]) nodes.push_back(nd);
  std::set_difference(nodes.begin(), nodes.end(), s.nodes.begin(), s.nodes.end(), std::back_inserter(s.new_nodes));
  std::set_difference(s.nodes.begin(), s.nodes.end(), nodes.begin(), nodes.end(), std::back_inserter(s.lost_nodes));
  s.nodes.swap(nodes);
}

}  // namespace fem
