// SPDX-License-Identifier: Apache-2.0
// Hex meshes of simple bodies. Corner order of a hex (bottom face counter-clockwise seen from above, then the top face):
// 0 (-,-,-) 1 (+,-,-) 2 (+,+,-) 3 (-,+,-) 4 (-,-,+) 5 (+,-,+) 6 (+,+,+) 7 (-,+,+).
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
/// rounded up to an even number. For every plane in keep_positive only the half on its positive side is kept; nodes on
/// the plane lie on it exactly.
HexMesh sphere(double diameter, int n_across, core::Symmetry keep_positive = {});

/// A solid cylinder along z, rounded core with four caps in the cross-section.
HexMesh cylinder(double diameter, double length, int n_across, int n_along, core::Symmetry keep_positive = {});

/// Spacing along one axis: uniform of about `fine` within [-fine_half, fine_half] about `focus`, growing by at most
/// `growth` from element to element outside, to the ends exactly.
struct Grading {
  double fine = 0;       ///< element size in the fine part [m]
  double fine_half = 0;  ///< half-width of the fine part [m]
  double focus = 0;      ///< its centre along the axis [m]
  double growth = 1.15;  ///< largest ratio of neighbouring edges
  double coarse = 1e300; ///< largest element [m]
};
/// Coordinates from first to last [m].
std::vector<double> graded_line(double first, double last, const Grading& grading);

/// A box of hexes on the tensor product of three lines of coordinates.
HexMesh box(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z);

/// Smallest edge [m], smallest and largest det J over corners of all elements relative to the element's mean, smallest
/// corner angle [rad]: for tests and for `ejecta check`.
struct MeshQuality {
  double shortest_edge = 0, jacobian_ratio = 0, smallest_angle = 0, volume = 0;
};
MeshQuality quality(const HexMesh& mesh);

}  // namespace fem
