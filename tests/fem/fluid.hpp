// SPDX-License-Identifier: Apache-2.0
// A fluid of round numbers: rho 1000 kg/m3, sound speed 1000 m/s.
#pragma once

#include "material/material.hpp"

inline material::Material fluid() {
  material::Material m;
  m.rho_0 = 1000;
  eos::MieGrueneisen e;
  e.rho_0 = 1000, e.c_0 = 1000, e.s_1 = 1, e.gamma_0 = 1, e.cv = 1000;
  m.eos = e;
  m.strength = material::NoStrength{};
  material::prepare(m);
  return m;
}
