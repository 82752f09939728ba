// SPDX-License-Identifier: Apache-2.0
// Polynomial equation of state (LS-DYNA Theory Manual, *EOS_LINEAR_POLYNOMIAL; e here per mass):
//   p = C0 + C1 mu + C2 mu^2 + C3 mu^3 + (C4 + C5 mu + C6 mu^2) rho_0 e,  mu = rho/rho_0 - 1;  C2 = C6 = 0 for mu < 0.
// C4 = C5 = gamma - 1 and the rest zero is the ideal gas. Range: that of the fit; far expansion is as the formula has it.
// Temperature: eos/reference_isentrope.hpp, up to five times rho_0 and held from there on.
#pragma once

#include <cassert>

#include "core/lane_math.hpp"
#include "eos/reference_isentrope.hpp"
#include "eos/state.hpp"

namespace eos {

struct Polynomial {
  double rho_0 = 0;                         ///< [kg/m3], > 0
  double C0 = 0, C1 = 0, C2 = 0, C3 = 0;    ///< [Pa]
  double C4 = 0, C5 = 0, C6 = 0;            ///< [-]
  double cv = 1000, T_0 = 294;              ///< [J/(kg K)] > 0, [K]

  ReferenceIsentrope isentrope = {};        ///< derived by prepare()
};

/// Fills in the derived fields; to be called once, after the last change of a parameter.
void prepare(Polynomial& m);

/// rho [kg/m3] > 0, e [J/kg].
template <class T>
State<T> state(const Polynomial& m, T rho, T e) {
  assert(m.isentrope.energy.x_max > 0 && "prepare() was not called");
  const T mu = rho / T(m.rho_0) - T(1.0);
  const T squeezed = core::max(mu, T(0.0));  // the even terms act in compression only
  const T g = T(m.C4) + T(m.C5) * mu + T(m.C6) * squeezed * squeezed;
  const T p = T(m.C0) + mu * (T(m.C1) + T(m.C3) * mu * mu) + T(m.C2) * squeezed * squeezed + g * T(m.rho_0) * e;
  const T dp_dmu = T(m.C1) + T(3.0 * m.C3) * mu * mu + T(2.0 * m.C2) * squeezed +
                   (T(m.C5) + T(2.0 * m.C6) * squeezed) * T(m.rho_0) * e;
  const T c2 = dp_dmu / T(m.rho_0) + p * g * T(m.rho_0) / (rho * rho);
  const T x = core::min(core::max(T(1.0) - T(m.rho_0) / rho, T(m.isentrope.energy.x_min)),
                        T(m.isentrope.energy.x_max));
  const T temperature = T(m.T_0) * core::exp(m.isentrope.heating(x)) + (e - m.isentrope.energy(x)) / T(m.cv);
  constexpr double floor = min_sound_speed_ratio * min_sound_speed_ratio, smallest_c2 = 1e-20;
  return {p, core::max(c2, T(floor * m.C1 / m.rho_0 + smallest_c2)), core::max(temperature, T(0.0))};
}

/// Energy at absolute zero [J/kg]: e_s - cv T_s.
double cold_energy(const Polynomial& m, double rho);

}  // namespace eos
