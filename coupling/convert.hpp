// SPDX-License-Identifier: Apache-2.0
// Elements become particles, or are deleted. The only place where arrays grow. One hex gives n^3 particles at the centres
// of an n x n x n division of its parent cube, with the trilinear velocity there: mass and linear momentum are exact
// (every corner's shape function sums to n^3 / 8 over the centres). Kinetic energy that the new velocities cannot carry
// stays with the nodes that other elements still own, as far as they can take it (docs/theory.md, section 6); the rest
// becomes heat of the same matter and is booked. Density, energy, stress, plastic strain, damage and temperature are
// inherited: the row of the material point is copied.
#pragma once

#include <cstdint>
#include <span>

#include "core/types.hpp"
#include "fem/mesh.hpp"
#include "sph/particles.hpp"

namespace coupling {

/// What leaves the books of the mesh when elements go.
struct Removal {
  double conversion = 0;        ///< kinetic energy turned into heat [J]
  double eroded_kinetic = 0;    ///< [J]
  double eroded_internal = 0;   ///< but for what is booked already [J]
  double eroded_booked = 0;     ///< heat under names of its own (fem::Elements::booked) [J]
  double eroded_mass = 0;       ///< [kg]
  core::Vec3 eroded_momentum{0, 0, 0};          ///< [kg m/s]
  core::Vec3 eroded_angular_momentum{0, 0, 0};  ///< about the origin [kg m2/s]
};

/// Each element to per_edge^3 particles.
Removal convert_elements(fem::Mesh& mesh, sph::Particles& particles, std::span<const std::uint32_t> elements,
                         int per_edge);

/// The particles that a body begins as: each moves as its place does and has the mass of the part of its element that it stands for, and nothing
/// is left to neighbours or turned into heat. The elements stay.
void fill_with_particles(fem::Mesh& mesh, sph::Particles& particles, std::span<const std::uint32_t> elements, int per_edge);

/// Deletes the elements; with keep_nodes their mass stays with the nodes, which fly on once they are free.
Removal erode_elements(fem::Mesh& mesh, std::span<const std::uint32_t> elements, bool keep_nodes);

}  // namespace coupling
