// SPDX-License-Identifier: Apache-2.0
// Johnson & Cook, Eng. Fract. Mech. 21 (1985) 31, eqs 3-5: damage is the sum of d(eps_p)/eps_f,
//   eps_f = [D1 + D2 exp(D3 sigma*)](1 + D4 ln max(rate/rate_0, 1))(1 + D5 T*),   sigma* = -p/sigma_eff.
// sigma* is held at or above -30, where no number is large any more, and at or below 1.5, the end of the paper's fit. Some fits
// (6061-T6) end sooner: carried on they give no strain at all at 1.5, and a plate would part at a third of its measured tension limit.
// Theirs is held where it falls to 0.15, the strain at which ductile spall parts (Grady, J. Mech. Phys. Solids 36 (1988) 353).
#pragma once

#include "material/johnson_cook.hpp"

namespace material {

constexpr double smallest_fracture_strain = 1e-4;
constexpr double largest_triaxiality = 1.5;
constexpr double ductile_spall_strain = 0.15;

/// D1 + D2 exp(D3 sigma*) of a sigma* up to 1.5, held where a fit that would vanish before ends [-].
template <class T>
T fit_of_triaxiality(const JohnsonCookDamage& d, T triaxiality) {
  const T strain = T(d.D1) + T(d.D2) * core::exp(T(d.D3) * triaxiality);
  if (!core::any(strain < T(ductile_spall_strain))) return strain;
  const T at_the_end = T(d.D1) + T(d.D2) * core::exp(T(d.D3 * largest_triaxiality));
  return core::select(at_the_end > T(0.0), strain, core::max(strain, T(ductile_spall_strain)));
}

/// Equivalent plastic strain at fracture [-]; p and sigma_eff in Pa, rate in 1/s, temperature in K.
template <class T>
T fracture_strain(const JohnsonCookDamage& d, T p, T sigma_eff, T rate, T temperature) {
  const T triaxiality = core::min(core::max(-p / core::max(sigma_eff, T(1e-3)), T(-30.0)), T(largest_triaxiality));
  const T t = homologous_temperature(temperature, d.T_room, d.T_melt);
  const T eps_f = fit_of_triaxiality(d, triaxiality) *
                  (T(1.0) + T(d.D4) * log_rate(rate, d.rate_0)) * (T(1.0) + T(d.D5) * t);
  return core::max(eps_f, T(smallest_fracture_strain));
}

}  // namespace material
