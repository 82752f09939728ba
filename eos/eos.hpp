// SPDX-License-Identifier: Apache-2.0
// Equations of state: pressure, bulk sound speed and temperature from density and specific internal energy. A closed
// set of plain parameter structs (one header each) and the calls that everyone uses. Energy is zero in the reference
// state (rho_0, T_0, p = 0); for the ideal gas at absolute zero.
#pragma once

#include <variant>

#include "eos/ideal_gas.hpp"
#include "eos/mie_grueneisen.hpp"
#include "eos/polynomial.hpp"
#include "eos/sesame.hpp"
#include "eos/tillotson.hpp"

namespace eos {

using Eos = std::variant<IdealGas, Polynomial, MieGrueneisen, Tillotson, Sesame>;

/// Derives what the models keep ready (reference isentrope, poles). Whoever builds or changes an equation of state calls
/// it before the first state(). Throws core::CaseError where a parameter has no sense.
void prepare(Eos& model);

/// Pressure, sound speed and temperature at rho [kg/m3] > 0 and e [J/kg].
template <class T>
State<T> state(const Eos& model, T rho, T e) {
  if (const auto* m = std::get_if<MieGrueneisen>(&model)) return state(*m, rho, e);
  if (const auto* m = std::get_if<Tillotson>(&model)) return state(*m, rho, e);
  if (const auto* m = std::get_if<Sesame>(&model)) return state(*m, rho, e);
  if (const auto* m = std::get_if<Polynomial>(&model)) return state(*m, rho, e);
  return state(*std::get_if<IdealGas>(&model), rho, e);
}

/// Specific energy at absolute zero [J/kg]: the lowest that a state of this density may have.
double cold_energy(const Eos& model, double rho);

/// Density that no shock reaches, the pole of the Mie-Grueneisen Hugoniot [kg/m3]; 1e300 for the other models.
double max_density(const Eos& model);

}  // namespace eos
