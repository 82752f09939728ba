// SPDX-License-Identifier: Apache-2.0
#include "material/material.hpp"

#include <cmath>

#include "core/error.hpp"

namespace material {

namespace {

void require(bool ok, const Material& m, const std::string& what) {
  if (!ok) throw core::CaseError("material '" + m.name + "': " + what);
}

std::string number(double a) { return std::to_string(a); }

void check(const NoStrength&, const Material&) {}

void check(const PerfectlyPlastic& s, const Material& m) {
  require(s.G > 0, m, "strength.G is " + number(s.G) + " Pa, must be positive; use model = \"none\" for a fluid");
  require(s.Y >= 0, m, "strength.Y is " + number(s.Y) + " Pa, must not be negative");
}

void check(const JohnsonCook& s, const Material& m) {
  require(s.G > 0, m, "strength.G is " + number(s.G) + " Pa, must be positive");
  require(s.A >= 0 && s.B >= 0, m, "strength.A and B must not be negative");
  require(s.n > 0 || s.B == 0, m, "strength.n is " + number(s.n) + ", must be positive");
  require(s.m > 0, m, "strength.m is " + number(s.m) + ", must be positive");
  require(s.rate_0 > 0, m, "strength.rate_0 is " + number(s.rate_0) + " 1/s, must be positive");
  require(s.T_melt > s.T_room, m, "strength.T_melt must exceed T_room");
}

void check(const SteinbergGuinan& s, const Material& m) {
  require(s.G_0 > 0, m, "strength.G_0 is " + number(s.G_0) + " Pa, must be positive");
  require(s.Y_0 >= 0 && s.Y_max >= s.Y_0, m, "strength.Y_max must be at or above Y_0, and Y_0 not negative");
  require(s.n >= 0 && s.beta >= 0 && s.eps_i >= 0, m, "strength.n, beta and eps_i must not be negative");
  require(s.T_melt_0 > 0, m, "strength.T_melt_0 must be positive");
}

void check(const ZerilliArmstrong& s, const Material& m) {
  require(s.G > 0, m, "strength.G is " + number(s.G) + " Pa, must be positive");
  require(s.C0 >= 0 && s.C1 >= 0 && s.C2 >= 0 && s.C5 >= 0, m, "strength.C0, C1, C2 and C5 must not be negative");
  require(s.C3 >= 0 && s.C4 >= 0, m, "strength.C3 and C4 must not be negative");
  require(s.n > 0 && s.n <= 1, m, "strength.n is " + number(s.n) + ", must be above 0 and at most 1");
  require(s.T_melt > 0, m, "strength.T_melt must be positive");
}

double modulus(const NoStrength&) { return 0; }
double modulus(const PerfectlyPlastic& s) { return s.G; }
double modulus(const JohnsonCook& s) { return s.G; }
double modulus(const SteinbergGuinan& s) { return s.G_0; }
double modulus(const ZerilliArmstrong& s) { return s.G; }

}  // namespace

void prepare(Material& m) {
  require(m.rho_0 > 0, m, "rho_0 is " + number(m.rho_0) + " kg/m3, must be positive");
  require(m.spall > 0, m, "spall limit is " + number(m.spall) + " Pa, must be positive");
  require(m.fracture_energy >= 0, m, "fracture energy is " + number(m.fracture_energy) + " J/m2, must not be negative");
  std::visit([&](const auto& s) { check(s, m); }, m.strength);
  if (m.damage) {
    require(m.damage->rate_0 > 0, m, "damage.rate_0 must be positive");
    require(m.damage->T_melt > m.damage->T_room, m, "damage.T_melt must exceed T_room");
  }
  eos::prepare(m.eos);
}

double shear_modulus(const Strength& strength) {
  return std::visit([](const auto& s) { return modulus(s); }, strength);
}

double sound_speed(const Material& m) {
  return std::sqrt(eos::state(m.eos, m.rho_0, 0.0).c2 + 4.0 / 3.0 * shear_modulus(m.strength) / m.rho_0);
}

}  // namespace material
