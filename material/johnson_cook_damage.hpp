// SPDX-License-Identifier: Apache-2.0
// Johnson & Cook, Eng. Fract. Mech. 21 (1985) 31, eqs 3-5: damage is the sum of d(eps_p)/eps_f,
//   eps_f = [D1 + D2 exp(D3 sigma*)](1 + D4 ln max(rate/rate_0, 1))(1 + D5 T*),   sigma* = -p/sigma_eff.
// sigma* is held at or below 1.5, the end of the paper's fit, and at or above -30, where no number is large any more.
// A negative eps_f (fits with D1 < 0 in strong tension) means failure at the first plastic strain: smallest_fracture_strain.
#pragma once

#include "material/johnson_cook.hpp"

namespace material {

constexpr double smallest_fracture_strain = 1e-4;

/// Equivalent plastic strain at fracture [-]; p and sigma_eff in Pa, rate in 1/s, temperature in K.
template <class T>
T fracture_strain(const JohnsonCookDamage& d, T p, T sigma_eff, T rate, T temperature) {
  const T triaxiality = core::min(core::max(-p / core::max(sigma_eff, T(1e-3)), T(-30.0)), T(1.5));
  const T t = homologous_temperature(temperature, d.T_room, d.T_melt);
  const T eps_f = (T(d.D1) + T(d.D2) * core::exp(T(d.D3) * triaxiality)) *
                  (T(1.0) + T(d.D4) * log_rate(rate, d.rate_0)) * (T(1.0) + T(d.D5) * t);
  return core::max(eps_f, T(smallest_fracture_strain));
}

}  // namespace material
