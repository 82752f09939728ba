// SPDX-License-Identifier: Apache-2.0
// What a strength law says about one point in one state: its shear modulus, and its flow stress as a function of plastic
// strain alone, because rate, temperature and pressure are fixed while the stress returns to the yield surface. Every law
// here hardens ever more slowly (d2Y/deps2 <= 0), which the return relies on for speed, not for safety.
#pragma once

#include "core/lane_math.hpp"
#include "material/material.hpp"

namespace material {

/// Flow stress Y [Pa], its slope dY/deps_p [Pa] and d2Y/deps_p2 [Pa].
template <class T>
struct Yield {
  T Y, slope, bend;
};

/// Where a point is while it flows.
template <class T>
struct FlowState {
  T eta;          ///< density over that of the reference state [-]
  T p;            ///< [Pa]
  T temperature;  ///< [K]
  T rate;         ///< equivalent strain rate [1/s]
};

template <class T>
struct ConstantFlow {
  T G, Y;
  Yield<T> operator()(T) const { return {Y, T(0.0), T(0.0)}; }
};

/// Elastic, perfectly plastic: the same everywhere.
template <class T>
ConstantFlow<T> flow(const PerfectlyPlastic& s, const FlowState<T>&) {
  return {T(s.G), T(s.Y)};
}

}  // namespace material
