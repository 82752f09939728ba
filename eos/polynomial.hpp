// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace eos {
/// p = C0 + C1 mu + C2 mu^2 + C3 mu^3 + (C4 + C5 mu + C6 mu^2) rho_0 e, mu = rho/rho_0 - 1; C2 = C6 = 0 for mu < 0.
struct Polynomial {
  double rho_0 = 0;                                               ///< [kg/m3]
  double C0 = 0, C1 = 0, C2 = 0, C3 = 0;                          ///< [Pa]
  double C4 = 0, C5 = 0, C6 = 0;                                  ///< [-]
  double cv = 1000, T_0 = 294;                                    ///< [J/(kg K)], [K]
};
}
