// SPDX-License-Identifier: Apache-2.0
// What every equation of state returns.
#pragma once

namespace eos {

/// T is double for one point or a core::Pack for lanes of points.
template <class T>
struct State {
  T p;   ///< pressure [Pa]
  T c2;  ///< square of the bulk sound speed, dp/drho at constant entropy, never negative [m2/s2]
  T temperature;  ///< [K]
};

}  // namespace eos
