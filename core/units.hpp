// SPDX-License-Identifier: Apache-2.0
// Unit strings ("4 mm", "8 km/s", "875 J/(kg K)") to SI numbers, with the dimension checked: whoever asks names what he
// expects. A unit is a product of names with powers: "kg/m3", "kg m^-3", "J/(kg K)", "g/cc". SI prefixes p n u m c d k M
// G T (micro sign as well) go with m g s K N Pa J Hz bar rad; min h, deg, in ft mil, psi ksi atm, dyn erg, cc, rpm without.
// Powers of ten are applied to the decimal text, so that "2.05 mm" and 0.00205 are the same bits.
#pragma once

#include <string>
#include <string_view>

namespace core {

enum class Dimension {
  none, length, time, velocity, acceleration, mass, density, pressure, specific_energy, specific_heat, temperature,
  angle, rate, angular_velocity, inverse_pressure, inverse_temperature, momentum, energy, surface_energy
};

/// "pressure"; "1.2 GPa"; "Pa" ("" for none).
const char* dimension_name(Dimension d);
const char* dimension_example(Dimension d);
const char* si_unit(Dimension d);

/// The SI value of `text`. A bare number is SI. Throws CaseError that says what was given, which
/// dimension it has and what would be valid; the caller puts file, line and key in front.
double parse_quantity(std::string_view text, Dimension expected);

/// A finite number with nothing behind it; locale-independent, so that "0,5" never means 0.
bool parse_number(std::string_view text, double& value);

/// A short decimal that reads back to the same bits, by TOML too, which takes digits alone for an integer: -0 would lose its sign.
std::string exact_decimal(double value);

}  // namespace core
