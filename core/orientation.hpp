// SPDX-License-Identifier: Apache-2.0
// How a body that is the same upside down lies in the scene: one answer for its mesh and for what is measured on it.
#pragma once

#include "core/types.hpp"

namespace core {

/// Turns z into the unit vector n, and x and y along: a permutation of the axes where n is one of them, so that positive sides
/// of symmetry planes stay positive; else about the axis normal to z and n.
inline Mat3 orientation(const Vec3& n) {
  for (int d = 0; d < 3; ++d)
    if (n == Vec3::Unit(d)) {
      Mat3 r;
      for (int a = 0; a < 3; ++a) r.col(a) = Vec3::Unit((d + 1 + a) % 3);
      return r;
    }
  return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), n).toRotationMatrix();
}

/// The one of n and -n whose last component that is not zero is positive.
inline Vec3 upright(const Vec3& n) {
  for (int d = 2; d >= 0; --d)
    if (n[d] != 0) return n[d] > 0 ? n : Vec3(-n);
  return n;
}

}  // namespace core
