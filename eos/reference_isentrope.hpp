// SPDX-License-Identifier: Apache-2.0
// The isentrope through the reference state (rho_0, T_0, e = 0), from which a temperature follows for an equation of state
// that is incomplete: with a constant specific heat at constant volume,
//   T = T_s(rho) + (e - e_s(rho)) / cv,   de_s/dv = -p(v, e_s),   d ln T_s/dv = -gamma/v
// (e.g. Meyers, Dynamic Behavior of Materials, 1994, eqs 5.29-5.32). In x = 1 - rho_0/rho these are
//   de_s/dx = p/rho_0,   d ln T_s/dx = (dp/de at constant rho)/rho_0.
// Both are integrated once (Runge-Kutta) and kept as polynomials through Chebyshev nodes, so that lanes evaluate them
// without a table look-up.
#pragma once

#include <array>
#include <functional>

#include "core/pack.hpp"

namespace eos {

/// f(x) ~ x * polynomial on [x_min, x_max]; x outside is the caller's to hold back.
struct IsentropeFit {
  static constexpr int n_coefficients = 16;
  double x_min = 0, x_max = 0;
  std::array<double, n_coefficients> a{};  ///< powers of the coordinate that runs over [-1, 1]

  template <class T>
  T operator()(T x) const {
    const T t = (x - T(x_min)) * T(2.0 / (x_max - x_min)) - T(1.0);
    T r = T(a[n_coefficients - 1]);
    for (int i = n_coefficients - 2; i >= 0; --i) r = r * t + T(a[i]);
    return r * x;
  }
};

struct ReferenceIsentrope {
  IsentropeFit energy;   ///< e_s(x) * weight(x) [J/kg]
  IsentropeFit heating;  ///< ln(T_s(x)/T_0) [-]
};

/// Integrates from x = 0 both ways. slope(x, e) returns {de_s/dx, d ln T_s/dx}; weight(x) removes a known pole from e_s
/// before it is fitted. x_min <= 0 < x_max.
ReferenceIsentrope fit_reference_isentrope(double x_min, double x_max,
                                           const std::function<std::array<double, 2>(double, double)>& slope,
                                           const std::function<double(double)>& weight);

}  // namespace eos
