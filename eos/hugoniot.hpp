// SPDX-License-Identifier: Apache-2.0
// Principal Hugoniot of any equation of state from the jump conditions of mass, momentum and energy,
//   rho_0 Us = rho (Us - up),   p - p_0 = rho_0 Us up,   e - e_0 = (p + p_0)(1/rho_0 - 1/rho)/2
// (Meyers, Dynamic Behavior of Materials, 1994, eqs 4.5, 4.7, 4.13), the pressure of a plane impact of two materials, and that of
// the oblique impact at which jetting begins (Walsh, Shreffler & Willig, J. Appl. Phys. 24 (1953) 349).
#pragma once

#include "eos/eos.hpp"

namespace eos {

struct HugoniotPoint {
  double up;           ///< particle velocity [m/s]
  double Us;           ///< shock velocity [m/s]
  double p;            ///< [Pa]
  double rho;          ///< [kg/m3]
  double e;            ///< specific internal energy behind the shock [J/kg]
  double temperature;  ///< [K]
};

/// State behind a shock that runs into matter at rest at (rho_0, e_0) and brings it to up >= 0 [m/s].
/// Throws core::CaseError where up is beyond the range of the model.
HugoniotPoint hugoniot(const Eos& model, double rho_0, double up, double e_0 = 0);

/// Pressure on the interface when A strikes B at the closing speed v [m/s], both at e = 0 (impedance match). 0 where v is not
/// positive or the range of a model ends before.
double impact_pressure(const Eos& a, double rho_0_a, const Eos& b, double rho_0_b, double v);

struct ObliqueImpact {
  double angle;  ///< between the surfaces [rad]
  double p;      ///< [Pa]
};

/// Surfaces of A and B at an angle close at speed v [m/s] along B's normal, both at e = 0. Seen from where they touch, both flow in
/// steadily and an attached shock turns each into the common interface. That has a solution up to an angle from which on
/// matter jets; the pressure rises on the way there, from impact_pressure() to the value returned. A sphere on a plate goes
/// through all these angles. {0, 0} where v is not positive or the range of a model ends before.
ObliqueImpact onset_of_jetting(const Eos& a, double rho_0_a, const Eos& b, double rho_0_b, double v);

}  // namespace eos
