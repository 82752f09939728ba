// SPDX-License-Identifier: Apache-2.0
#include "fem/hex8.hpp"

#include <algorithm>
#include <cmath>

namespace fem {

constexpr double corner_sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

double jacobian_at(const Corners<double>& x, double xi, double eta, double zeta) {
  double j[3][3] = {};
  for (int i = 0; i < 8; ++i) {
    const double *s = corner_sign[i], a = 1 + s[0] * xi, b = 1 + s[1] * eta, c = 1 + s[2] * zeta;
    const double d[3] = {s[0] * b * c / 8, a * s[1] * c / 8, a * b * s[2] / 8};
    for (int p = 0; p < 3; ++p)
      for (int q = 0; q < 3; ++q) j[p][q] += d[p] * x.c[i][q];
  }
  return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) - j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
         j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

double jacobian_ratio(const Corners<double>& x) {
  const double g = 1 / std::sqrt(3.0);
  double low = 1e300, high = -1e300;
  for (const auto& s : corner_sign) {
    const double d = jacobian_at(x, g * s[0], g * s[1], g * s[2]);
    low = std::min(low, d);
    high = std::max(high, d);
  }
  return low > 0 ? high / low : 1e300;
}

double smallest_corner_jacobian(const Corners<double>& x) {
  double low = 1e300;
  for (const auto& s : corner_sign) low = std::min(low, jacobian_at(x, s[0], s[1], s[2]));
  return low;
}

double smallest_angle(const Corners<double>& x) {
  double largest_cosine = -1;
  for (const auto& f : face_corner)
    for (int k = 0; k < 4; ++k) {
      const double *o = x.c[f[k]], *a = x.c[f[(k + 1) % 4]], *b = x.c[f[(k + 3) % 4]];
      double ab = 0, aa = 0, bb = 0;
      for (int d = 0; d < 3; ++d) {
        ab += (a[d] - o[d]) * (b[d] - o[d]);
        aa += (a[d] - o[d]) * (a[d] - o[d]);
        bb += (b[d] - o[d]) * (b[d] - o[d]);
      }
      largest_cosine = std::max(largest_cosine, ab / std::sqrt(aa * bb + 1e-300));
    }
  return std::acos(std::clamp(largest_cosine, -1.0, 1.0));
}

}  // namespace fem
