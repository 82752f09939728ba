// SPDX-License-Identifier: Apache-2.0
// Where a point meets a face during a step: swept in time, against the four triangles about the face's centre. Positions
// are those of the step's start, velocities constant over it.
#pragma once

#include <array>

#include "core/types.hpp"
#include "fem/mesh.hpp"

namespace coupling {

constexpr double margin_part = 2e-3;     ///< gap kept, over the square root of a face's area
constexpr double edge_tolerance = 0.02;  ///< triangles reach this part of their size beyond their edges

/// Nodes of an exposed face, in outward order.
using FaceNodes = std::array<std::uint32_t, 4>;

struct Meeting {
  bool found = false;
  double gap_end = 0;                 ///< signed distance at the end [m]
  double target = 0;                  ///< gap to be left at the end [m]
  core::Vec3 normal{0, 0, 0};         ///< of the triangle at the end
  std::array<double, 4> weight{};     ///< shape functions of the corners where it meets
};

/// The deepest meeting of a point at x with velocity v with a face within dt. strict: only a true crossing of the sheet.
Meeting meet(const fem::Nodes& nodes, const FaceNodes& node, const core::Vec3& x, const core::Vec3& v, double dt, bool strict);

/// A face as a sphere that flies along: what lies farther from its centre than radius and what the relative velocity
/// covers in dt is not met.
struct FaceSphere {
  core::Vec3 x, v;
  double radius;  ///< margin and the corners' own motion included [m]

  bool reaches(const core::Vec3& point_x, const core::Vec3& point_v, double dt) const {
    const double r = radius + dt * (point_v - v).norm();
    return (point_x - x).squaredNorm() <= r * r;
  }
};
FaceSphere face_sphere(const fem::Nodes& nodes, const FaceNodes& node, double dt);

}  // namespace coupling
