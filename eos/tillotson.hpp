// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace eos {
/// Tillotson, General Atomic GA-3216 (1962).
struct Tillotson {
  double rho_0 = 0;              ///< [kg/m3]
  double a = 0, b = 0;           ///< [-]
  double A = 0, B = 0;           ///< [Pa]
  double alpha = 0, beta = 0;    ///< [-]
  double E_0 = 0;                ///< [J/kg]
  double E_iv = 0, E_cv = 0;     ///< incipient and complete vaporisation [J/kg]
  double cv = 0, T_0 = 294;      ///< [J/(kg K)], [K]
};
}
