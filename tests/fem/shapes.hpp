// SPDX-License-Identifier: Apache-2.0
// Shape measures of a hex written out point by point, which those in edges and lanes are compared with.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/hex8.hpp"

namespace shapes {

constexpr double sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                               {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/// det J at a point of the parent cube, xi in [-1, 1]^3, from the shape functions.
inline double jacobian_at(const fem::Corners<double>& x, double xi, double eta, double zeta) {
  double j[3][3] = {};
  for (int i = 0; i < 8; ++i) {
    const double *s = sign[i], a = 1 + s[0] * xi, b = 1 + s[1] * eta, c = 1 + s[2] * zeta;
    const double d[3] = {s[0] * b * c / 8, a * s[1] * c / 8, a * b * s[2] / 8};
    for (int p = 0; p < 3; ++p)
      for (int q = 0; q < 3; ++q) j[p][q] += d[p] * x.c[i][q];
  }
  return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) - j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
         j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

/// Smallest and largest det J of the eight points at `reach` of the way from the centre to the corners.
inline std::pair<double, double> jacobians(const fem::Corners<double>& x, double reach) {
  double low = 1e300, high = -1e300;
  for (const auto& s : sign) {
    const double j = jacobian_at(x, reach * s[0], reach * s[1], reach * s[2]);
    low = std::min(low, j), high = std::max(high, j);
  }
  return {low, high};
}

inline double jacobian_ratio(const fem::Corners<double>& x) {
  const auto [low, high] = jacobians(x, 1 / std::sqrt(3.0));
  return low > 0 ? high / low : 1e300;
}

}  // namespace shapes
