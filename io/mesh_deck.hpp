// SPDX-License-Identifier: Apache-2.0
// Hex meshes from LS-DYNA keyword decks (LS-DYNA Keyword User's Manual, volume I: *NODE, *ELEMENT_SOLID, and the
// section on card formats). Read: *NODE (columns 8, 16, 16, 16), *ELEMENT_SOLID on one line (element, part, n1..n8) or
// two (element, part; n1..n8 and two empty fields), both in fixed columns or comma-separated; $ comments; *END; wider
// columns by LONG=Y or I10=Y on *KEYWORD or a trailing +, % or - on a keyword. Other keywords are skipped with their
// data. Not read: *INCLUDE, *ELEMENT_SOLID with an option, solids other than 8-node hexes: each is an error, none is
// skipped.
#pragma once

#include <array>
#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace io {

/// Nodes [m] that a hex uses, in the order of the deck, and the hexes by 0-based rows of x; corner order as in the deck
/// (bottom face counter-clockwise seen from above, then the top face).
struct DeckMesh {
  std::vector<core::Vec3> x;
  std::vector<std::array<std::int32_t, 8>> node;
};

/// Reads a deck; scale is the deck's unit of length [m]. Throws core::CaseError "file:line: ..." for anything that
/// cannot be read, duplicate numbers, missing nodes, elements that are no hex and elements without positive volume.
DeckMesh read_mesh_deck(const std::string& path, double scale);

/// The same from a stream; `name` stands for the file in messages.
DeckMesh read_mesh_deck(std::istream& in, const std::string& name, double scale);

}  // namespace io
