// SPDX-License-Identifier: Apache-2.0
// The particle half of the state. Plain named arrays, one row a particle; material points as in the elements.
// Time levels as in fem/mesh.hpp: positions and stress at n, velocities at n - 1/2.
#pragma once

#include <cstdint>
#include <vector>

#include "core/lane_math.hpp"
#include "core/points.hpp"
#include "core/types.hpp"
#include "sph/kernel.hpp"

namespace sph {

struct Particles {
  core::Points pt;
  std::vector<core::Vec3> x;         ///< position [m]
  std::vector<core::Vec3> v;         ///< velocity [m/s]
  std::vector<core::Vec3> v_mean;    ///< mean of the velocities before and after the last kick [m/s]
  std::vector<core::Vec3> f;         ///< force of time n [N]
  std::vector<double> h;             ///< smoothing length; the kernel reaches 2h [m]
  std::vector<double> h_0;           ///< at birth [m]
  std::vector<double> dt;            ///< stable time step [s]
  std::vector<double> spread;        ///< shear switch: |div v| / (|div v| + |curl v|) [-]
  std::vector<core::Vec3> stretch;   ///< strain rate of the last step, xx yy zz [1/s]
  std::vector<core::Vec3> shear;     ///< xy yz zx, tensor components [1/s]
  std::vector<std::uint16_t> body;   ///< parent body
  std::vector<std::uint32_t> parent; ///< element it came from; its own number where made at the start
  std::vector<std::uint32_t> id;     ///< number of birth: never changes, particles may be reordered
  std::size_t size() const { return x.size(); }

  /// Calls f(vector&) for every array but those of `pt`.
  template <class F>
  void each_array(F&& g) {
    g(x), g(v), g(v_mean), g(f), g(h), g(h_0), g(dt), g(spread), g(stretch), g(shear), g(body), g(parent), g(id);
  }
  void resize(std::size_t n);
};

/// h of a particle of mass m and density rho, held within bounds of h_0, its value at birth [m].
template <class T>
T smoothing_length(T m, T rho, T h_0) {
  const T h = T(h_over_spacing) * core::cbrt(m / rho);
  return core::min(core::max(h, T(0.5) * h_0), T(1.5) * h_0);
}

/// h of a particle whose mass and density are set, and its bounds where this is its birth.
void set_smoothing_length(Particles& particles, std::size_t i);

/// Stores the particles along the octree's curve, so that neighbours in space are neighbours in memory.
void sort_along_curve(Particles& particles);

}  // namespace sph
