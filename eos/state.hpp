// SPDX-License-Identifier: Apache-2.0
// What every equation of state returns.
#pragma once

namespace eos {

/// T is double for one point or a core::Pack for lanes of points.
template <class T>
struct State {
  T p;            ///< pressure [Pa]
  T c2;           ///< square of the bulk sound speed, dp/drho at constant entropy, positive [m2/s2]
  T temperature;  ///< never negative [K]
};

/// Matter expands as a solid or liquid by 2 % at most; what looks thinner holds voids (a spalled or crushed solid) or is
/// vapour. Temperature and cold energy of thinner matter are those of its condensed part: without this, cold debris
/// that drifts apart would seem to be below absolute zero. 2 % is the strain of the highest tension (1.5 GPa in
/// aluminium) that the library's materials carry before they spall.
constexpr double max_condensed_expansion = 0.02;

/// The sound speed never falls below this fraction of its reference value: inside the region of mechanical
/// instability (dp/drho < 0) there is no sound speed, and the time step needs a number.
constexpr double min_sound_speed_ratio = 0.01;

}  // namespace eos
