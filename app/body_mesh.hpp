// SPDX-License-Identifier: Apache-2.0
// Where the bodies of a case lie and how finely each is meshed. The projectile's smallest extent has elements_across
// elements; the first plate takes that size round where it is struck, later plates at least six elements through their
// thickness at no finer size; thin plates have five layers as far as those are not thinner than two thirds of that, and four as far as half; all
// coarsen away from there. A plate that nothing can get to before the run ends is coarse all over.
#pragma once

#include <functional>
#include <vector>

#include "fem/generate.hpp"
#include "io/case.hpp"

namespace app {

struct PlacedBody {
  const io::BodySpec* spec = nullptr;
  double element_size = 0;              ///< in the fine part [m]
  double layer = 0;                     ///< plate, box: its thinnest layer of elements [m]
  double count = 0;                     ///< elements, about
  bool too_coarse = false;              ///< meshed as one that nothing gets to (io::Case::mesh_end), which something may after all
  std::function<fem::HexMesh()> make;   ///< the mesh in place, cut at the symmetry planes
};

/// One a body, in the case's order. The symmetry of the case must be resolved.
std::vector<PlacedBody> place_bodies(const io::Case& spec);

/// Sets the size and the middle (of the box round it) and the element size (cube root of the mean volume) of bodies whose mesh is a file.
void measure_decks(io::Case& spec);

/// A plate or a box.
bool is_box(const io::BodySpec& b);

/// The velocity of what is struck, which decides about what flies: zero where there is a rigid wall, a plate or box at rest or none at
/// all, otherwise that of the widest body (the slowest of equals) [m/s].
core::Vec3 at_rest(const io::Case& spec);

/// The body that flies: the fastest one as seen from what is at rest (the first of equals).
int projectile_of(const io::Case& spec);

/// Plates and boxes that the projectile's line of flight, as seen from each, meets, in the order of meeting.
std::vector<int> plates_in_order(const io::Case& spec);

/// Where the line of flight of the projectile, as seen from the body, meets its front face as built, or its centre where it does not [m].
core::Vec3 where_struck(const io::Case& spec, std::size_t body);

/// Does the line of flight enter the body through another face than the front one?
bool struck_from_side(const io::Case& spec, std::size_t body);

double smallest_extent(const io::BodySpec& body);

/// Middle of the body, or of the box round it [m].
core::Vec3 middle(const io::BodySpec& body);

/// Is one of the body's own axes along this axis of the scene?
bool lies_along(const io::BodySpec& body, int axis);

/// Throws core::CaseError naming two bodies whose volumes overlap, or one that reaches behind a rigid wall.
void check_places(const io::Case& spec, const std::vector<PlacedBody>& placed);

}  // namespace app
