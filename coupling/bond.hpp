// SPDX-License-Identifier: Apache-2.0
// The bond: alive elements within a kernel's reach of a particle stand in the SPH sums as foreign actors: as the particles
// that they would become, one or n^3 parts an element. The elements' own faces towards the particles are left unbalanced by what was converted,
// so that is where the reaction to its own body's particles goes: to the nodes of the seam next to each foreign element. The
// particle's stress makes that force, and the particle's energy pays for its work at the nodes. What strangers push goes to the element's corners
// as the shape functions share it, and what their work leaves over to its energy.
// Elements of the particle's own body hold it (bond = true) or only push (bond = false); elements of other bodies only push.
#pragma once

#include <cstdint>
#include <vector>

#include "fem/mesh.hpp"
#include "sph/neighbourhood.hpp"
#include "sph/particles.hpp"

namespace coupling {

struct Bond {
  int per_edge = 1;                     ///< n: particles an element would become along its edge
  std::vector<std::uint32_t> elements;  ///< in reach, ascending
  std::vector<core::Vec3> x;            ///< centres of their parts: the foreign actors, n^3 an element [m]
  double h_most = 0;                    ///< smoothing lengths of parts are held to this: what lists are made by is what the sums see [m]
  std::vector<std::uint32_t> watched;   ///< elements not in reach but near enough to come into it soon, ascending
  std::vector<core::Vec3> watched_x;    ///< their centres [m]
  std::vector<std::uint32_t> seam_start, seam_node;  ///< rows of the nodes that take the reaction, one an element
  std::vector<std::uint32_t> seam_of;   ///< the elements, as they were when those rows were made
  std::vector<std::uint32_t> seam;      ///< the nodes of all rows, each once
  std::vector<std::uint32_t> seam_row;  ///< of each of seam_node: where it stands in seam
  std::vector<std::uint8_t> on_seam;    ///< [node] an element at it was converted
  std::vector<std::uint8_t> ring;       ///< [element] 1: has a node on the seam, 2: touches one that has, 0: neither
  std::size_t seam_removed = 0;         ///< elements removed when these two were made; empty before the first
  bool hold = true;                     ///< [convert] bond

  int parts() const { return per_edge * per_edge * per_edge; }
};

/// Elements whose centre lies within reach of a particle, and a skin; and those to be watched. Images need no search of their own: an element in
/// reach of an image has its own image in reach of the particle.
void find_elements(const fem::Mesh& mesh, const sph::Particles& particles, Bond& bond);

/// Nodes that take each bonded element's reaction: its corners on the seam (where an element was converted), else those of the
/// elements around it, else none.
void find_seam(const fem::Mesh& mesh, Bond& bond);

/// Centres of the bonded and the watched elements now.
void update_centres(const fem::Mesh& mesh, Bond& bond);

/// The foreign rows of hood.actors, all but velocities after the kick, and how many anchors each has.
void fill_foreign(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood);

/// The anchors of those that have somebody near.
void fill_anchors(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood);

/// v_new of the same, and the velocity of their seams.
void fill_foreign_velocities(const fem::Mesh& mesh, const Bond& bond, sph::Neighbourhood& hood);

/// Reaction of the particles to the seam; wakes what is pushed.
void add_reaction(const sph::Neighbourhood& hood, const Bond& bond, fem::Mesh& mesh);

/// Work of pairs with strangers over `dt_kick` into the elements' energy.
void add_heat(const sph::Neighbourhood& hood, const Bond& bond, double dt_kick, fem::Mesh& mesh);

}  // namespace coupling
