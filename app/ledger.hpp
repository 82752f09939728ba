// SPDX-License-Identifier: Apache-2.0
// Mass, momentum, angular momentum and energy, with every term by name. Kinetic energy is that of the half-step
// velocities; internal energy is what the compatible update left. The heat that hourglass control, contact and conversion
// put into matter is in matter's internal energy; the ledger shows it in its own rows and the rest as `internal`, so the
// rows add up to the total.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace app {

struct Simulation;

struct Totals {
  double mass = 0, kinetic = 0, internal = 0;  ///< of the matter there is [kg] [J] [J]
  core::Vec3 momentum{0, 0, 0};                ///< [kg m/s]
  core::Vec3 angular_momentum{0, 0, 0};        ///< about the origin [kg m2/s]
  double momentum_size = 0;                    ///< sum of m |v| [kg m/s]
  double angular_size = 0;                     ///< sum of m |x| |v| [kg m2/s]
  Totals operator+(const Totals& o) const;
  Totals& operator+=(const Totals& o);
};

struct Ledger {
  Totals initial, now;
  std::vector<std::optional<Totals>> solid;  ///< [body] elements' part of `now`; holds as long as the body is asleep
  double hourglass = 0;         ///< heat from hourglass forces [J]
  double conversion = 0;        ///< heat from kinetic energy that new particles could not carry [J]
  double contact = 0;           ///< kinetic energy taken by contact impulses [J]
  double contact_heat = 0;      ///< part of it that is heat of matter [J]
  double eroded_kinetic = 0, eroded_internal = 0, eroded_mass = 0;  ///< [J] [J] [kg]
  double eroded_booked = 0;     ///< heat of what went that stands in the rows above [J]
  core::Vec3 eroded_momentum{0, 0, 0}, eroded_angular_momentum{0, 0, 0};
  core::Vec3 wall_impulse{0, 0, 0}, wall_angular_impulse{0, 0, 0};  ///< given by rigid walls

  double internal() const;      ///< internal energy less the heat in other rows [J]
  double total() const;         ///< all rows [J]
  double energy_error = 0, mass_error = 0, momentum_error = 0, angular_momentum_error = 0;  ///< relative
  double largest_energy_error = 0;
  double added_inertia = 0;     ///< kinetic energy that inertia added to slowed elements had, the most at one time; in `internal` [J]
};

/// Sums over the matter there is.
Totals totals(const Simulation& s);

/// Brings the ledger's errors up to date and checks the invariants; throws core::GuardError.
void account(Simulation& s);

/// A slower check (every few steps): energy below the cold curve.
void check_health(const Simulation& s);

/// Adds a warning if a point of matter has borne more than shocks explain. Points are caught between what is heavier than they are, and
/// few of them hold little of the energy: the run is no worse for it, but its highest pressures are.
void check_peaks(Simulation& s);

/// Adds a warning for each material with a tabular equation of state whose matter is off the table now, once a material.
void check_tables(Simulation& s);

/// What to try where a guard stops a run.
std::string advice(const Simulation& s);

}  // namespace app
