// SPDX-License-Identifier: Apache-2.0
// Zerilli & Armstrong, J. Appl. Phys. 61 (1987) 1816, the laws for fcc and for bcc metals in one:
//   Y = C0 + [C1 + C2 sqrt(eps)] exp(-beta T) + C5 eps^n,   beta = C3 - C4 ln(rate s),
// fcc with C1 = C5 = 0 (strain widens the barrier that heat helps to pass: hardening softens with heat), bcc with C2 = 0. The
// rate is in 1/s. beta is held at or above zero, where heat no longer helps (rates above exp(C3/C4)/s, 4e10/s for copper).
// The laws know no melting: G and Y fall to zero at T_melt, as in johnson_cook.hpp.
#pragma once

#include "material/flow.hpp"

namespace material {

template <class T>
struct ZerilliArmstrongFlow {
  T G;        ///< shear modulus in this state [Pa]
  T a, b, c;  ///< of eps^0, eps^(1/2) and eps^n [Pa]
  double n;
  bool power;  ///< is there an eps^n?

  Yield<T> operator()(T eps_p) const {
    const T root = b * core::sqrt(eps_p);
    T Y = a + root, rise = T(0.5) * root, bend = T(-0.5) * rise;
    if (power) {
      const T hardening = c * core::pow(eps_p, T(n));
      Y += hardening;
      rise += T(n) * hardening;
      bend += T(n * (n - 1)) * hardening;
    }
    const T inverse = T(1.0) / core::max(eps_p, T(1e-300));
    return {Y, rise * inverse, bend * inverse * inverse};
  }
};

template <class T>
ZerilliArmstrongFlow<T> flow(const ZerilliArmstrong& s, const FlowState<T>& at) {
  const T beta = core::max(T(s.C3) - T(s.C4) * core::log(core::max(at.rate, T(1e-300))), T(0.0));
  const T thermal = core::exp(-(beta * at.temperature));
  const auto solid = at.temperature < T(s.T_melt);
  const auto held = [&](T stress) { return core::select(solid, stress, T(0.0)); };
  return {held(T(s.G)), held(T(s.C0) + T(s.C1) * thermal), held(T(s.C2) * thermal), held(T(s.C5)), s.n, s.C5 > 0};
}

}  // namespace material
