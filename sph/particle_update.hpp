// SPDX-License-Identifier: Apache-2.0
// Particles to n + 1: density by continuity, the shared point update, smoothing length.
#pragma once

#include <vector>

#include "core/types.hpp"
#include "material/material.hpp"
#include "sph/particles.hpp"

namespace sph {

/// v(n-1/2) -> v(n+1/2); leaves v_mean.
void kick_particles(Particles& particles, double dt);

/// x(n) -> x(n+1).
void drift_particles(Particles& particles, double dt);

/// velocity_gradient [1/s] at mid-step. body_material[body] indexes materials.
void update_particles(Particles& particles, const std::vector<material::Material>& materials,
                      const std::vector<int>& body_material, const std::vector<core::Mat3>& velocity_gradient, double dt);

}  // namespace sph
