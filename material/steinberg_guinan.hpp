// SPDX-License-Identifier: Apache-2.0
// Steinberg, Cochran & Guinan, J. Appl. Phys. 51 (1980) 1498, eqs 1-3:
//   G = G_0 f,   Y = min(Y_0 [1 + beta (eps + eps_i)]^n, Y_max) f,   f = 1 + A p/eta^(1/3) - B (T - 300 K),
// with eta = rho/rho_0. Melting after Steinberg, UCRL-MA-106439 (1996): G = Y = 0 from
//   T_melt = T_melt_0 exp(2a (1 - 1/eta)) eta^(2 (gamma_0 - a - 1/3)).
// f is held at or above zero (far tension). No strain rate: meant for rates above 1e5 1/s.
#pragma once

#include "material/flow.hpp"

namespace material {

/// Melting temperature [K] at the density eta = rho/rho_0.
template <class T>
T melting_temperature(const SteinbergGuinan& s, T eta) {
  const double power = 2.0 * (s.gamma_0 - s.a - 1.0 / 3.0);
  return T(s.T_melt_0) * core::exp(T(2.0 * s.a) * (T(1.0) - T(1.0) / eta) + T(power) * core::log(eta));
}

template <class T>
struct SteinbergGuinanFlow {
  T G;       ///< shear modulus in this state [Pa]
  T factor;  ///< f, or zero when melted [-]
  double Y_0, Y_max, beta, n, eps_i;

  Yield<T> operator()(T eps_p) const {
    const T base = T(1.0) + T(beta) * (eps_p + T(eps_i));
    const T Y = T(Y_0) * core::pow(base, T(n));
    const auto free = Y < T(Y_max);
    const T slope = factor * core::select(free, T(n * beta) * Y / base, T(0.0));
    return {factor * core::select(free, Y, T(Y_max)), slope, T((n - 1) * beta) * slope / base};
  }
};

template <class T>
SteinbergGuinanFlow<T> flow(const SteinbergGuinan& s, const FlowState<T>& at) {
  constexpr double T_ref = 300.0;  // of the paper's eqs 1 and 2 [K]
  const T f = T(1.0) + T(s.A) * at.p / core::cbrt(at.eta) - T(s.B) * (at.temperature - T(T_ref));
  const auto solid = at.temperature < melting_temperature(s, at.eta);
  const T held = core::select(solid, core::max(f, T(0.0)), T(0.0));
  return {T(s.G_0) * held, held, s.Y_0, s.Y_max, s.beta, s.n, s.eps_i};
}

}  // namespace material
