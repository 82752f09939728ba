// SPDX-License-Identifier: Apache-2.0
// Hex meshes of simple bodies. Corner order of a hex (bottom face counter-clockwise seen from above, then the top
// face): 0 (-,-,-) 1 (+,-,-) 2 (+,+,-) 3 (-,+,-) 4 (-,-,+) 5 (+,-,+) 6 (+,+,+) 7 (-,+,+). Guaranteed for every mesh
// made here: welded by index (no two nodes at one place, none unused); nodes and elements in Morton order of the
// structured index, so neighbours lie close in memory; the same arguments give the same bits. Sphere and cylinder,
// besides: every corner det J positive; mirror images of each other bit by bit across x = 0, y = 0 and z = 0, with
// nodes on those planes at exactly 0.0, so that a half or quarter model is a part of the full one, node for node; nodes
// of the curved surface on it to round-off. The volume is therefore that of an inscribed body, short of the true one at
// second order in the element size; app/body_mesh.cpp makes up for it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace fem {

/// Nodes [m] and hexes of one body, in the body's own axes, centred on the origin.
struct HexMesh {
  std::vector<core::Vec3> x;
  std::vector<std::array<std::int32_t, 8>> node;
};

/// A solid sphere as a rounded core block with six caps (no degenerate hexes). n_across elements over the diameter,
/// rounded up to an even number, at least 4. For every plane in keep_positive only the half on its positive side is
/// kept; nodes on the plane lie on it exactly. Shortest edge about 0.7 diameter / n_across, longest (on the surface)
/// about 1.8; angles above 1 rad; corner det J within an element vary by 2.8 at n_across 8, 1.25 at 48.
HexMesh sphere(double diameter, int n_across, core::Symmetry keep_positive = {});

/// A solid cylinder along z, from -length / 2 to length / 2, rounded core with four caps in the cross-section. n_across
/// as for the sphere; n_along elements along the axis, rounded up to an even number where only z > 0 is kept.
HexMesh cylinder(double diameter, double length, int n_across, int n_along, core::Symmetry keep_positive = {});

/// Spacing along one axis: uniform of about `fine` within [-fine_half, fine_half] about `focus`, growing by at most
/// `growth` from element to element outside, to the ends exactly.
struct Grading {
  double fine = 0;        ///< element size in the fine part [m]
  double fine_half = 0;   ///< half-width of the fine part [m]
  double focus = 0;       ///< its centre along the axis [m]
  double growth = 1.15;   ///< largest ratio of neighbouring edges
  double coarse = 1e300;  ///< largest element [m]
};
/// Coordinates from first to last [m], both exactly. The fine part, cut off at the ends, has its length over `fine`
/// elements, rounded, at least one. Outside it edges grow outward by one ratio in [1, growth], never beyond `coarse`,
/// chosen such that the last one ends at the end. Where no such ratio exists (too little room beside the fine part) the
/// fine part is stretched to that end. Where first = -last and focus = 0, the line is its own mirror image bit by bit,
/// with 0 a grid point, and its positive half is graded_line(0, last). Throws core::CaseError for last <= first,
/// fine <= 0 or growth < 1.
std::vector<double> graded_line(double first, double last, const Grading& grading);

/// A box of hexes on the tensor product of three lines of ascending coordinates.
HexMesh box(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z);

/// How good a mesh is: for tests and for `ejecta check`.
struct MeshQuality {
  double shortest_edge = 0;   ///< [m]
  double jacobian_ratio = 0;  ///< largest over elements of largest / smallest det J among the element's eight corners
                              ///< and eight Gauss points; 1e300 where the smallest is not positive
  double smallest_angle = 0;  ///< between two edges at a face's corner [rad]
  double volume = 0;          ///< sum of the elements' exact volumes (Flanagan & Belytschko 1981) [m3]
};
MeshQuality quality(const HexMesh& mesh);

}  // namespace fem
