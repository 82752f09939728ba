// SPDX-License-Identifier: Apache-2.0
#include "sph/particles.hpp"

#include <algorithm>
#include <cmath>

namespace sph {

void Particles::resize(std::size_t n) {
  pt.resize(n);
  each_array([n](auto& a) {
    using Row = typename std::decay_t<decltype(a)>::value_type;
    if constexpr (std::is_same_v<Row, core::Vec3>)
      a.resize(n, core::Vec3::Zero());
    else
      a.resize(n, Row{});
  });
}

void set_smoothing_length(Particles& p, std::size_t i) {
  const double h = h_over_spacing * std::cbrt(p.pt.m[i] / p.pt.rho[i]);
  if (p.h_0[i] == 0) p.h_0[i] = h;
  p.h[i] = std::clamp(h, 0.5 * p.h_0[i], 1.5 * p.h_0[i]);
}

}  // namespace sph
