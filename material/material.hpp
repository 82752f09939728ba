// SPDX-License-Identifier: Apache-2.0
// What a material is: a name, a reference density, an equation of state, a strength law and how it fails. Plain structs
// of named parameters in SI; the laws are the functions beside them. Built by io/material_file from the library
// (material/library.toml) or from a case.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "eos/eos.hpp"

namespace material {

/// No shear strength: a fluid.
struct NoStrength {};

/// Elastic, perfectly plastic (von Mises): Y = const.
struct PerfectlyPlastic {
  double G = 0;  ///< shear modulus [Pa]
  double Y = 0;  ///< yield stress [Pa]
};

/// Johnson & Cook, Proc. 7th Int. Symp. Ballistics (1983) 541, eq. 1:
/// Y = (A + B eps^n)(1 + C ln max(rate/rate_0, 1))(1 - T*^m), T* = (T - T_room)/(T_melt - T_room) held in [0, 1].
/// G is constant below T_melt and zero from there on. Law: material/johnson_cook.hpp.
struct JohnsonCook {
  double G = 0;                 ///< shear modulus [Pa]
  double A = 0, B = 0, n = 1;   ///< [Pa], [Pa], [-]
  double C = 0;                 ///< [-]
  double m = 1;                 ///< [-]
  double rate_0 = 1;            ///< reference strain rate [1/s]
  double T_room = 294;          ///< [K]
  double T_melt = 1e9;          ///< [K]
};

/// Steinberg, Cochran & Guinan, J. Appl. Phys. 51 (1980) 1498, eqs 1-3, with melting after Steinberg,
/// UCRL-MA-106439 (1996): above T_melt(rho) both G and Y are zero. Law: material/steinberg_guinan.hpp.
struct SteinbergGuinan {
  double G_0 = 0;                    ///< [Pa]
  double Y_0 = 0, Y_max = 0;         ///< [Pa]
  double beta = 0, n = 0, eps_i = 0; ///< work hardening [-]
  double A = 0;                      ///< (dG/dp)/G_0 [1/Pa]
  double B = 0;                      ///< -(dG/dT)/G_0 [1/K]
  double T_melt_0 = 1e9;             ///< melting temperature at rho_0 [K]
  double gamma_0 = 2, a = 1.5;       ///< T_melt = T_melt_0 exp(2a(1 - 1/eta)) eta^(2(gamma_0 - a - 1/3)), eta = rho/rho_0
};

/// Zerilli & Armstrong, J. Appl. Phys. 61 (1987) 1816, fcc (C1 = C5 = 0) and bcc (C2 = 0) in one:
/// Y = C0 + [C1 + C2 sqrt(eps)] exp(-C3 T + C4 T ln(rate s)) + C5 eps^n. C0 holds the paper's term of the grain size, k l^(-1/2).
/// G is constant; at T_melt, which the paper does not have, G and Y fall to zero. Law: material/zerilli_armstrong.hpp.
struct ZerilliArmstrong {
  double G = 0;                   ///< shear modulus [Pa]
  double C0 = 0, C1 = 0, C2 = 0;  ///< [Pa]
  double C3 = 0, C4 = 0;          ///< [1/K]
  double C5 = 0, n = 1;           ///< [Pa], [-]
  double T_melt = 1e9;            ///< [K]
};

using Strength = std::variant<NoStrength, PerfectlyPlastic, JohnsonCook, SteinbergGuinan, ZerilliArmstrong>;

/// Johnson & Cook, Eng. Fract. Mech. 21 (1985) 31, eqs 3-5: damage grows by d(eps_p)/eps_f,
/// eps_f = [D1 + D2 exp(D3 p*)](1 + D4 ln max(rate/rate_0, 1))(1 + D5 T*), p* = -p/sigma_eff held at or below 1.5, or where
/// a fit ends that would vanish before (their sigma*, positive in tension; with D3 < 0 tension embrittles). Law:
/// material/johnson_cook_damage.hpp.
struct JohnsonCookDamage {
  double D1 = 0, D2 = 0, D3 = 0, D4 = 0, D5 = 0;  ///< [-]
  double rate_0 = 1;                              ///< [1/s]
  double T_room = 294, T_melt = 1e9;              ///< [K]
};

struct Material {
  std::string name;
  double rho_0 = 0;                          ///< [kg/m3]
  eos::Eos eos;
  Strength strength;
  std::optional<JohnsonCookDamage> damage;   ///< none: plastic strain does no damage
  double spall = 1e300;                      ///< tension at which the point begins to tear, positive [Pa]
  double fracture_energy = 0;                ///< work that a unit of area of crack takes once solid matter tears [J/m2]
  double e_melt = 1e300;                     ///< specific energy at which melting begins on release to zero pressure [J/kg]
  double e_melted = 1e300;                   ///< ... at which it is complete [J/kg]
  double e_vapour = 1e300;                   ///< ... at which vaporisation begins [J/kg]
  double e_vaporised = 1e300;                ///< ... at which it is complete [J/kg]

  struct Constant {
    std::string key, value, source;  ///< as the library or the case states it, for `ejecta materials`
  };
  std::vector<Constant> constants;
};

/// Makes the equation of state ready (eos::prepare) and checks the constants of the strength and damage laws. Whoever
/// builds or changes a material calls it before the first update(). Throws core::CaseError.
void prepare(Material& material);

/// The shear modulus in the reference state [Pa]; 0 without strength.
double shear_modulus(const Strength& strength);

/// Speed of longitudinal waves in the reference state [m/s].
double sound_speed(const Material& material);

}  // namespace material
