// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace eos {
/// Parameters; law to come with state(...).
struct MieGrueneisen {
  double rho_0 = 0;                  ///< [kg/m3]
  double c_0 = 0;                    ///< Us = c_0 + s_1 up + s_2 (up/Us) up + s_3 (up/Us)^2 up [m/s]
  double s_1 = 0, s_2 = 0, s_3 = 0;  ///< [-]
  double gamma_0 = 0;                ///< Grueneisen coefficient at rho_0 [-]
  double a = 0;                      ///< first-order volume correction: gamma = (gamma_0 + a mu)/(1 + mu), mu = rho/rho_0 - 1 [-]
  double cv = 0;                     ///< specific heat [J/(kg K)]
  double T_0 = 294;                  ///< temperature of the reference state [K]
};
}
