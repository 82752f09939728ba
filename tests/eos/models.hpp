// SPDX-License-Identifier: Apache-2.0
// Equations of state that the tests use, made ready. Constants: Steinberg, UCRL-MA-106439 (1996), and Melosh, Impact
// Cratering (1989), table AII.3.
#pragma once

#include "eos/eos.hpp"

inline eos::MieGrueneisen aluminium_2024() {
  eos::MieGrueneisen m{.rho_0 = 2785, .c_0 = 5328, .s_1 = 1.338, .gamma_0 = 2.0, .a = 0.48, .cv = 875};
  eos::prepare(m);
  return m;
}
inline eos::MieGrueneisen copper() {
  eos::MieGrueneisen m{.rho_0 = 8930, .c_0 = 3940, .s_1 = 1.489, .gamma_0 = 2.02, .a = 0.47, .cv = 383};
  eos::prepare(m);
  return m;
}
inline eos::MieGrueneisen iron() {
  eos::MieGrueneisen m{.rho_0 = 7850, .c_0 = 3574, .s_1 = 1.92, .gamma_0 = 1.69, .a = 0, .cv = 452};
  eos::prepare(m);
  return m;
}
inline eos::MieGrueneisen hafnium() {  // all three slopes
  eos::MieGrueneisen m{.rho_0 = 13300, .c_0 = 2980, .s_1 = 1.448, .s_2 = -3.852, .s_3 = 7.0, .gamma_0 = 1.09,
                       .a = 0.15, .cv = 144};
  eos::prepare(m);
  return m;
}
inline eos::Tillotson aluminium_tillotson() {
  eos::Tillotson m{.rho_0 = 2700, .a = 0.5, .b = 1.63, .A = 75.2e9, .B = 65e9, .alpha = 5, .beta = 5, .E_0 = 5e6,
                   .E_iv = 3e6, .E_cv = 13.9e6, .cv = 884};
  eos::prepare(m);
  return m;
}
inline eos::Polynomial cubic() {
  eos::Polynomial m{.rho_0 = 2700, .C1 = 75e9, .C2 = 60e9, .C3 = 90e9, .C4 = 2, .C5 = 0.5, .C6 = 0.3, .cv = 900};
  eos::prepare(m);
  return m;
}
