// SPDX-License-Identifier: Apache-2.0
// Wendland C2 kernel in three dimensions, support 2h: W = 21/(16 pi h^3) (1 - r/2h)^4 (1 + 2r/h).
// Source: Wendland, Adv. Comput. Math. 4 (1995) 389; Dehnen & Aly, MNRAS 425 (2012) 1068, table 1.
#pragma once

#include "core/pack.hpp"
#include "core/types.hpp"

namespace sph {

constexpr double kernel_reach = 2.0;     ///< support radius over h
constexpr double h_over_spacing = 1.2;   ///< h over the spacing cbrt(m / rho)

/// W(r, h) [1/m3].
template <class T>
T kernel(T r, T h) {
  const T q = r / h, u = core::max(T(1.0) - T(0.5) * q, T(0.0)), u2 = u * u;
  return T(21.0 / (16.0 * core::pi)) * u2 * u2 * (T(1.0) + T(2.0) * q) / (h * h * h);
}

/// (dW/dr) / r [1/m5]: gradient of W with respect to x_i is kernel_slope * (x_i - x_j). Finite at r = 0. With R = 2h it is
/// this factor times (1 - r/R)^3 / R^5.
constexpr double kernel_slope_factor = -210.0 / core::pi;
template <class T>
T kernel_slope(T r, T h) {
  const T i = T(1.0) / (T(kernel_reach) * h), u = core::max(T(1.0) - r * i, T(0.0)), i2 = i * i;
  return T(kernel_slope_factor) * (u * u * u) * (i2 * i2 * i);
}

/// W at r = q h over its value at the regular spacing, h / h_over_spacing.
template <class T>
T kernel_over_spacing(T q) {
  constexpr double q_0 = 1 / h_over_spacing, u_0 = 1 - 0.5 * q_0, at_spacing = u_0 * u_0 * u_0 * u_0 * (1 + 2 * q_0);
  const T u = core::max(T(1.0) - T(0.5) * q, T(0.0)), u2 = u * u;
  return T(1 / at_spacing) * (u2 * u2) * (T(1.0) + T(2.0) * q);
}

}  // namespace sph
