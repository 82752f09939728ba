// SPDX-License-Identifier: Apache-2.0
// Small types shared by every room. Units are SI throughout (m, kg, s, Pa, J/kg, K).
// Signs: stress positive in tension, pressure positive in compression, sigma = s - p 1; strain rate positive
// in extension; outward normals; x_ij = x_i - x_j.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace core {

using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;  // where a place is only told from its neighbours
using Mat3 = Eigen::Matrix3d;

/// Indices of the six components of a symmetric tensor, without Voigt's factor of two.
enum Sym { xx = 0, yy = 1, zz = 2, xy = 3, yz = 4, zx = 5 };

constexpr double pi = 3.14159265358979323846;

/// A half-open range of rows [first, last).
struct Range {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
  bool contains(std::size_t i) const { return i >= first && i < last; }
};

/// The three coordinate planes through the origin that may mirror the scene: normals +x, +y, +z. The matter lies on
/// the positive side of each.
struct Symmetry {
  std::array<bool, 3> plane{false, false, false};
  /// How many copies of the modelled part make the whole scene: 1, 2, 4 or 8.
  int copies() const { return (plane[0] ? 2 : 1) * (plane[1] ? 2 : 1) * (plane[2] ? 2 : 1); }
};

/// Gives back the memory of what is needed no more (`a = {}` keeps that of a vector).
template <class... T>
void free_all(T&... a) {
  ((void)std::exchange(a, T{}), ...);
}

}  // namespace core
