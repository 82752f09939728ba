// SPDX-License-Identifier: Apache-2.0
#include "fem/hex8.hpp"

#include <algorithm>
#include <cmath>

namespace fem {

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
