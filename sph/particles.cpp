// SPDX-License-Identifier: Apache-2.0
#include "sph/particles.hpp"

#include <type_traits>

#include "core/octree.hpp"
#include "core/parallel.hpp"

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
  if (p.h_0[i] == 0) p.h_0[i] = h_over_spacing * core::cbrt(p.pt.m[i] / p.pt.rho[i]);
  p.h[i] = smoothing_length(p.pt.m[i], p.pt.rho[i], p.h_0[i]);
}

void sort_along_curve(Particles& p) {
  core::Octree tree;
  tree.build(p.x);
  const auto order = tree.order();
  const auto sort = [&](auto& a) {
    auto sorted = a;
    core::for_each(order.size(), [&](std::size_t k) { sorted[k] = a[order[k]]; });
    a.swap(sorted);
  };
  p.pt.each_field(sort);
  p.each_array(sort);
}

}  // namespace sph
