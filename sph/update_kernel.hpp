// SPDX-License-Identifier: Apache-2.0
// The particles' material update in lanes, compiled once for each instruction set and chosen at run time. Particles that
// follow one another and are of one material go through together; every lane has the bits that it would have alone.
#pragma once

#include <cstddef>

#include "material/material.hpp"
#include "sph/particles.hpp"

namespace sph {

struct UpdateView {
  Particles& particles;
  const material::Material* materials;
  const int* body_material;  ///< [body]
  const double* gradient;    ///< dv/dx at mid-step, nine a particle, column by column [1/s]
};

namespace baseline { void update_particles(const UpdateView&, std::size_t first, std::size_t last, double dt); }
namespace avx2 { void update_particles(const UpdateView&, std::size_t first, std::size_t last, double dt); }
namespace avx512 { void update_particles(const UpdateView&, std::size_t first, std::size_t last, double dt); }

}  // namespace sph
