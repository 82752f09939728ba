// SPDX-License-Identifier: Apache-2.0
// Johnson & Cook, Proc. 7th Int. Symp. Ballistics (1983) 541, eq. 1:
//   Y = (A + B eps^n)(1 + C ln max(rate/rate_0, 1))(1 - T*^m),   T* = (T - T_room)/(T_melt - T_room) held in [0, 1].
// The paper gives no shear modulus: G is constant below T_melt and zero from there on, as Y is.
#pragma once

#include "material/flow.hpp"

namespace material {

/// T*, in [0, 1].
template <class T>
T homologous_temperature(T temperature, double T_room, double T_melt) {
  return core::min(core::max((temperature - T(T_room)) / T(T_melt - T_room), T(0.0)), T(1.0));
}

/// ln max(rate/rate_0, 1).
template <class T>
T log_rate(T rate, double rate_0) { return core::log(core::max(rate / T(rate_0), T(1.0))); }

template <class T>
struct JohnsonCookFlow {
  T G;     ///< shear modulus in this state [Pa]
  T a, b;  ///< A and B times the factors of rate and temperature [Pa]
  double n;

  Yield<T> operator()(T eps_p) const {
    const T hardening = b * core::pow(eps_p, T(n)), inverse = T(1.0) / core::max(eps_p, T(1e-300)), slope = T(n) * hardening * inverse;
    return {a + hardening, slope, T(n - 1) * slope * inverse};
  }
};

template <class T>
JohnsonCookFlow<T> flow(const JohnsonCook& s, const FlowState<T>& at) {
  const T t = homologous_temperature(at.temperature, s.T_room, s.T_melt);
  const T factor = (T(1.0) + T(s.C) * log_rate(at.rate, s.rate_0)) * (T(1.0) - (s.m == 1 ? t : core::pow(t, T(s.m))));
  const auto solid = t < T(1.0);
  const T held = core::select(solid, core::max(factor, T(0.0)), T(0.0));
  return {core::select(solid, T(s.G), T(0.0)), T(s.A) * held, T(s.B) * held, s.n};
}

}  // namespace material
