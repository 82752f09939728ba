// SPDX-License-Identifier: Apache-2.0
// Bodies that touch as they are given may overlap as they are meshed: round ones are widened to their volume, and decks are facets. Contact
// takes what lies behind a face as none of its business.
#pragma once

#include "fem/mesh.hpp"

namespace fem {

/// Puts nodes of a body's surface that lie inside another body, by less than a quarter of a face's edge and half of what lies behind it, onto that face; on the
/// planes of symmetry they stay there. Round-off, which contact takes for touching, is left as it is. The mesh is finished, and is so anew, with the masses of
/// what was moved. Returns whether anything was.
bool part_bodies(Mesh& mesh);

}  // namespace fem
