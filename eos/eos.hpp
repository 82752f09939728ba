// SPDX-License-Identifier: Apache-2.0
// Equations of state: pressure, bulk sound speed and temperature from density and specific internal energy. A closed
// set of plain parameter structs (one header each) and two calls that everyone uses. Energy is zero in the reference
// state (rho_0, T_0, p = 0).
#pragma once

#include <variant>

#include "eos/ideal_gas.hpp"
#include "eos/mie_grueneisen.hpp"
#include "eos/polynomial.hpp"
#include "eos/tillotson.hpp"

namespace eos {

using Eos = std::variant<IdealGas, Polynomial, MieGrueneisen, Tillotson>;

}  // namespace eos
