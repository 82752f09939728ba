// SPDX-License-Identifier: Apache-2.0
// Materials that the tests use, made ready, and a driver that leads one point through a strain history. Constants as in
// material/library.toml, typed again.
#pragma once

#include <cmath>

#include "material/update.hpp"

inline material::JohnsonCook jc_2024() {
  return {.G = 28.6e9, .A = 265e6, .B = 426e6, .n = 0.34, .C = 0.015, .m = 1.0, .T_melt = 775};
}
inline material::JohnsonCook jc_copper() {
  return {.G = 47.7e9, .A = 90e6, .B = 292e6, .n = 0.31, .C = 0.025, .m = 1.09, .T_melt = 1356};
}
inline material::SteinbergGuinan sg_2024() {
  return {.G_0 = 28.6e9, .Y_0 = 0.26e9, .Y_max = 0.76e9, .beta = 310, .n = 0.185, .A = 65.2e-12, .B = 0.616e-3,
          .T_melt_0 = 1220, .gamma_0 = 2.0, .a = 1.5};
}
inline material::ZerilliArmstrong za_copper() {
  return {.G = 47.7e9, .C0 = 65e6, .C2 = 890e6, .C3 = 0.0028, .C4 = 0.000115, .T_melt = 1356};
}
inline material::ZerilliArmstrong za_iron() {
  return {.G = 80e9, .C0 = 65e6, .C1 = 1033e6, .C3 = 0.00698, .C4 = 0.000415, .C5 = 266e6, .n = 0.289, .T_melt = 1811};
}
inline material::JohnsonCookDamage damage_4340() {
  return {.D1 = 0.05, .D2 = 3.44, .D3 = -2.12, .D4 = 0.002, .D5 = 0.61, .T_room = 294, .T_melt = 1793};
}

inline material::Material aluminium(material::Strength strength) {
  material::Material m;
  m.name = "aluminium";
  m.rho_0 = 2785;
  m.eos = eos::MieGrueneisen{
      .rho_0 = 2785, .c_0 = 5328, .s_1 = 1.338, .gamma_0 = 2.0, .a = 0.48, .cv = 875, .T_0 = 294};
  m.strength = strength;
  material::prepare(m);
  return m;
}

/// A point at rest in the reference state.
inline material::Point<double> virgin(const material::Material& m) {
  material::Point<double> pt{};
  pt.m = 1e-9;
  pt.rho = m.rho_0;
  const auto s = eos::state(m.eos, pt.rho, 0.0);
  pt.c = std::sqrt(s.c2);
  pt.temperature = s.temperature;
  return pt;
}

/// One step at strain increment d, the density following exactly; the energy stays as it is.
inline void step(const material::Material& m, const material::Increment<double>& inc, double dt,
                 material::Point<double>& pt) {
  const double trace = inc.d[0] + inc.d[1] + inc.d[2];
  material::update(m, dt, pt.rho * std::exp(-trace), inc, 0.0, pt);
}
