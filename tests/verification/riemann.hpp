// SPDX-License-Identifier: Apache-2.0
// Sod's shock tube and Noh's planar problem: exact profiles.
// Sod: J. Comput. Phys. 27 (1978) 1; star values from reference/csv/verif_riemann_exact.csv (derived).
// Noh: J. Comput. Phys. 72 (1987) 78, eq. for the plane case; verif_noh.csv.
#pragma once

#include <cmath>

namespace riemann {

namespace sod {
constexpr double gamma = 1.4, rho_left = 1, p_left = 1, rho_right = 0.125, p_right = 0.1;
constexpr double p_star = 0.30313, u_star = 0.927453, rho_star_left = 0.426319, rho_star_right = 0.265574,
                 shock = 1.75216, head = -1.18322, tail = -0.0702728;

/// Density at x/t.
inline double density(double xi) {
  if (xi < head) return rho_left;
  if (xi < tail) {
    const double c = std::sqrt(gamma * p_left / rho_left);
    const double a = 2 / (gamma + 1) - (gamma - 1) / ((gamma + 1) * c) * xi;
    return rho_left * std::pow(a, 2 / (gamma - 1));
  }
  if (xi < u_star) return rho_star_left;
  return xi < shock ? rho_star_right : rho_right;
}
}  // namespace sod

namespace noh {
constexpr double gamma = 5.0 / 3.0, rho_behind = 4, p_behind = 4.0 / 3.0, shock = 1.0 / 3.0;
inline double density(double xi) { return xi < shock ? rho_behind : 1.0; }
}  // namespace noh

}  // namespace riemann
