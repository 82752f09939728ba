// SPDX-License-Identifier: Apache-2.0
// Where a point meets a face during a step: swept in time, against the four triangles about the face's centre. Positions
// are those of the step's start, velocities constant over it.
#pragma once

#include <algorithm>
#include <array>

#include "core/types.hpp"
#include "fem/surface.hpp"

namespace coupling {

constexpr double margin_part = 2e-3;     ///< gap kept, over the square root of a face's area
constexpr double edge_tolerance = 0.02;  ///< a face's four triangles reach this part of their size into each other
/// And this part beyond the face's edges: less than the gap kept, or what slides along would catch on them.
constexpr double overhang = margin_part;

using fem::FaceNodes;

struct Meeting {
  bool found = false;
  double gap_end = 0;                 ///< signed distance at the end [m]
  double target = 0;                  ///< gap to be left at the end [m]
  double slack = 0;                   ///< what impulses leave beyond that is taken back where it is more than this [m]
  core::Vec3 normal{0, 0, 0};         ///< of the triangle at the end
  core::Vec3 push{0, 0, 0};           ///< line of the impulse: outward where it meets, at the start
  std::array<double, 4> weight{};     ///< shape functions of the corners where it meets
  std::size_t triangle = 0;           ///< of the four: the one after that corner
};

/// Unit vectors that point away from the matter behind a face's corners, at the step's start.
using Outward = std::array<core::Vec3, 4>;

/// The deepest meeting of a point at x with velocity v with a face within dt. outward: null where nothing is to be pushed. strict: only a true
/// crossing of the sheet.
Meeting meet(const fem::Nodes& nodes, const FaceNodes& node, const Outward* outward, const core::Vec3& x, const core::Vec3& v, double dt, bool strict);

/// Signed distance at the end from one of the face's triangles [m].
double gap_at_end(const fem::Nodes& nodes, const FaceNodes& node, std::size_t triangle, const core::Vec3& x, const core::Vec3& v, double dt);

/// What a face sweeps within dt, seen from its centre: a sphere and a slab that hold it, its margin and its edges. A point
/// whose path stays outside either is not met.
struct FaceSweep {
  core::Vec3 x, v, normal;
  double radius = 0, low = 0, high = 0, dt = 0;

  bool reaches(const core::Vec3& point_x, const core::Vec3& point_v) const {
    const core::Vec3 d = point_x - x, w = dt * (point_v - v);
    const double r = radius + w.norm();
    if (d.squaredNorm() > r * r) return false;
    const double start = normal.dot(d), end = start + normal.dot(w);
    return std::min(start, end) <= high && std::max(start, end) >= low;
  }
};
FaceSweep face_sweep(const fem::Nodes& nodes, const FaceNodes& node, double dt);

}  // namespace coupling
