// SPDX-License-Identifier: Apache-2.0
// Selective mass scaling of a few: an element that was squeezed and has come to rest would hold the step of the whole run for good.
// It is given inertia against strain and hourglassing alone, M_e = inertia m / 8 (1 - P) on its corners' accelerations, P the projection on
// rigid motions: its stable step grows by sqrt(1 + inertia), while whatever moves as a whole moves as before. Form: Olovsson, Simonsson &
// Unosson, Int. J. Numer. Meth. Engng 63 (2005) 1436, eqs 8-10, with rotations taken out besides translations. The inertia acts as a
// corner force like any other, so momentum, angular momentum and energy are those of the scene: what it holds of kinetic energy is for
// the time being in the element's heat, and is reported.
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.hpp"
#include "fem/mesh.hpp"

namespace fem {

struct Slowed {
  std::uint32_t element;
  double inertia;  ///< added, in masses of the element [-]
};

/// The step [s] for all elements if a few may be slowed: those squeezed to less than they bore at first, and which deform by less than
/// a hundredth while sound crosses them; one in a hundred of those ever strained, and none by more than twice. shortest: of all
/// elements that count, and where.
double step_with_few_slowed(const Mesh& mesh, core::MinWhere shortest);

/// What must be slowed for steps that elements bear of dt [s]; by element.
std::vector<Slowed> slowed_elements(const Mesh& mesh, double dt);

/// Adds the forces of that inertia to the corner forces of time n, all others being known. Returns the kinetic energy that
/// the added inertia has at the velocities now [J].
double add_inertia(Mesh& mesh, const std::vector<Slowed>& slowed);

}  // namespace fem
