// SPDX-License-Identifier: Apache-2.0
// Ideal gas with constant specific heats: p = (gamma - 1) rho e, c^2 = gamma (gamma - 1) e, T = e/cv. Energy counts from
// absolute zero. A negative energy is read as zero. Range: any density, any e >= 0.
#pragma once

#include "core/pack.hpp"
#include "eos/state.hpp"

namespace eos {

struct IdealGas {
  double gamma = 1.4;  ///< ratio of specific heats [-]
  double cv = 718;     ///< [J/(kg K)]
};

template <class T>
State<T> state(const IdealGas& gas, T rho, T e) {
  constexpr double smallest_c2 = 1e-20;  // positive, and nothing beside any speed in a run
  e = core::max(e, T(0.0));
  return {T(gas.gamma - 1.0) * rho * e, core::max(T(gas.gamma * (gas.gamma - 1.0)) * e, T(smallest_c2)),
          e / T(gas.cv)};
}

inline double cold_energy(const IdealGas&, double) { return 0.0; }

}  // namespace eos
