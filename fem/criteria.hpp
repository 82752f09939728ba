// SPDX-License-Identifier: Apache-2.0
// What flags an element as too distorted: one list for conversion to particles and for deletion.
// Source: Campbell & Vignjevic, Int. J. Impact Engng 20 (1997) 143: `deformation` and `jacobian` with skew.
#pragma once

#include <cstdint>
#include <vector>

#include "fem/mesh.hpp"

namespace fem {

struct Criteria {
  bool use_deformation = false, use_jacobian = false, use_plastic_strain = false, use_timestep = false,
       use_damage = false;
  double deformation = 2.0;      ///< total deformation, integral of sqrt(2/3 D:D) dt [-]
  double jacobian_ratio = 2.5;   ///< largest over smallest det J at 2x2x2 points, relative to that as built [-]
  double min_angle = 0.5;        ///< smallest corner angle of a face [rad]
  double plastic_strain = 2.5;   ///< [-]
  double timestep_ratio = 0.1;   ///< stable step over the first one [-]
  double damage = 1.0;           ///< [-]
  double expansion = 0.0;        ///< always: density over the reference density below which matter is no longer solid [-]
  double left_over = 0;          ///< stable step over the first one below which an element may be a left-over that holds the step of all [-]
  double collapse = 0.06;        ///< always: stable step over the first one below which an element is about to invert [-]
};

/// Elements of awake blocks that the criteria flag, ascending. One that is being compressed to pressures where matter flows
/// is flagged afterwards, unless it turns inside out.
/// rho_0 [body]: reference density of each body [kg/m3]. Elements whose total deformation is less than `from` are looked at
/// for collapse only.
std::vector<std::uint32_t> flag_elements(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0,
                                         double from = 0);

/// Remembers the shape as built (Jacobian ratio); call once before the first step if the criteria use it.
void store_initial_shape(Mesh& mesh);

}  // namespace fem
