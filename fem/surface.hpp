// SPDX-License-Identifier: Apache-2.0
// The outer skin of a mesh that loses elements: faces that belong to one alive element only. Built when contact first
// needs it, then kept up at the cost of the elements that went.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fem/hex8.hpp"
#include "fem/mesh.hpp"

namespace fem {

/// Nodes of a face, in outward order.
using FaceNodes = std::array<std::uint32_t, 4>;
inline FaceNodes face_nodes(const Mesh& mesh, const Face& face) {
  FaceNodes node;
  for (std::size_t k = 0; k < 4; ++k)
    node[k] = static_cast<std::uint32_t>(mesh.elements.node[face.element][static_cast<std::size_t>(face_corner[face.face][k])]);
  return node;
}

struct Surface {
  std::vector<Face> faces;                             ///< exposed, ascending by (element, face), without those on symmetry planes
  std::vector<std::uint32_t> nodes;                    ///< nodes of exposed faces, ascending
  std::vector<Face> new_faces;                         ///< those that the last update added, ascending
  std::vector<std::uint32_t> new_nodes, lost_nodes;    ///< nodes that it added and dropped, ascending
  std::vector<std::uint8_t> alive;                     ///< [element] when the lists were made
  std::vector<std::uint16_t> faces_at;                 ///< [node] exposed faces there
  std::vector<std::uint8_t> exposed;                   ///< [element] a bit for each of its faces that is
  std::size_t n_removed = 0;                           ///< elements removed when the lists were made
  bool built = false;
};

/// Brings the lists up to date with the elements alive.
void update_surface(const Mesh& mesh, Surface& surface);

}  // namespace fem
