// SPDX-License-Identifier: Apache-2.0
// Contact of points (surface nodes of other bodies, free nodes, particles) with the exposed faces of elements, and of
// both with rigid walls. A face is a sheet of four triangles about its centre, so neighbouring faces leave no gap. Between
// kick and drift, every pair whose motion over the coming step would end behind a face gets an inelastic impulse along the
// skin's normal, smoothed over facets, that lets it close the gap but for a small margin, and no more: nothing is ever pushed out, so no energy
// is fed in, and whatever the stiffness nothing tunnels. Impulses are equal and opposite (mass split to the corners by the
// shape functions of the point of contact), swept in a fixed order, and taken back where others have made them needless, until no pair is left that would cross.
// Sources: velocity-level unilateral contact with a gap, Moreau (1988) and Stewart & Trinkle, IJNME 39 (1996) 2673, eqs
// 8-11 (without restitution); projected Gauss-Seidel; averaged normals, Puso & Laursen, CMAME 193 (2004) 601.
#pragma once

#include <cstdint>
#include <vector>

#include "core/types.hpp"
#include "coupling/contact_search.hpp"
#include "fem/mesh.hpp"
#include "sph/particles.hpp"

namespace coupling {

struct Wall {
  core::Vec3 point{0, 0, 0}, normal{0, 0, 1};
};

struct ContactSettings {
  bool enabled = true;
  double friction = 0;  ///< Coulomb coefficient, between bodies and along rigid walls [-]
  core::Symmetry symmetry;  ///< planes that particles and free nodes pass as their images
};

/// When contact last changed the velocity of a node or a particle in this step, by a count of changes.
struct Changes {
  static constexpr std::uint32_t none = 1;
  std::uint32_t count = none;
  std::vector<std::uint32_t> node, particle;
  std::vector<ContactPoint> log;  ///< [count - none - 1] what was changed
};

struct Contact {
  ContactLists lists;
  Changes changes;
  double step = 1e300;                   ///< time step that the last one's approaches allow [s]
  double quiet_until = 0;                ///< time before which no two bodies can meet, [s]
  std::size_t quiet_removed = 0;         ///< unless elements have gone since there were this many
  std::uint64_t searches = 0, pairs_tested = 0;

  double dissipated = 0;                 ///< kinetic energy that impulses took, cumulative [J]
  double heated = 0;                     ///< part of it that became heat of matter, cumulative [J]
  core::Vec3 wall_impulse{0, 0, 0};      ///< given to the matter by rigid walls, cumulative [N s]
  core::Vec3 wall_angular_impulse{0, 0, 0};
  std::uint64_t leaks = 0;               ///< crossings of a face's sheet by a point: stays 0
};

/// Corrects the velocities at n + 1/2 so that nothing crosses a face or a wall during the drift over dt. time: of the
/// step's start [s].
void resolve_contact(fem::Mesh& mesh, sph::Particles& particles, const std::vector<Wall>& walls,
                     const ContactSettings& settings, double time, double dt, Contact& contact);

/// A node may close on a face in a step by this part of the face's edge and of the depth (volume now over area) of the element
/// behind it: a first impact is then resolved in time as it is in space, and does not start with elements struck out of shape.
constexpr double closing_part = 0.4;

/// The arrays are others than before (restart). Elements that go and particles that come are noticed without.
inline void invalidate(Contact& contact) {
  contact.lists.valid = false;
  contact.quiet_until = 0;
}

}  // namespace coupling
