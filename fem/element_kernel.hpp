// SPDX-License-Identifier: Apache-2.0
// The element kernel: one pass a step over blocks of awake elements. For each element it
//   1 pays for the work that its corner forces of time n did on the nodes: e -= f . v_mean dt_kick / m   (compatible,
//     Caramana et al., J. Comput. Phys. 146 (1998) 227), so that total energy closes to round-off,
//   2 takes the velocity gradient at the mid-step geometry, the new volume and density, bulk viscosity, and
//   3 calls the material's point update,
//   4 leaves the new corner forces of stress, viscosity and hourglass control, and the stable time step.
// Sources: Flanagan & Belytschko 1981 (gradient, hourglass); von Neumann & Richtmyer 1950 and Landshoff 1955 (viscosity);
// stable step: hex8.hpp, with viscosity as in Hallquist, LS-DYNA Theory Manual (2006), eq. 22.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fem/mesh.hpp"
#include "material/material.hpp"

namespace fem {

struct ElementSettings {
  double viscosity_quadratic = 0.7;  ///< q = rho l |D| (C_q l |D| + C_l c) where D = tr(grad v) < 0 [-]
  double viscosity_linear = 0.15;    ///< with these two a plane shock overshoots by less than 1 % at any strength [-]
  bool hourglass_stiffness = false;  ///< stiffness form in place of the viscous one
  double hourglass = 0.02;           ///< coefficient of the form chosen [-]
  double hourglass_at_seam = 0.2;    ///< what an element gets besides on whose nodes particles act, while it only rings [-]
};

struct StepTimes {
  double kick = 0;   ///< time over which the last forces acted: (dt_old + dt) / 2 [s]
  double drift = 0;  ///< time over which the nodes moved [s]
};

/// Sums over the blocks that one call went through.
struct ElementSums {
  double hourglass = 0;  ///< work taken from the nodes by hourglass forces [J]
};

/// Brings the elements of the blocks (all of one material) to n + 1; forces are left where there is room for them. ring: [element] 1 where particles act on its nodes; or empty.
ElementSums update_elements(Mesh& mesh, const material::Material& material, const ElementSettings& settings,
                            const StepTimes& times, std::span<const std::uint8_t> ring, std::span<const std::uint32_t> blocks);

/// Volumes of all elements, into pt-independent `volume` [m3]; the routine that the kernel itself uses.
void element_volumes(const Mesh& mesh, std::vector<double>& volume);

}  // namespace fem
