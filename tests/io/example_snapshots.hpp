// SPDX-License-Identifier: Apache-2.0
// A small made-up run for tests: a row of hexes that turns into particles. paraview_check.py knows its numbers.
#pragma once

#include "io/snapshot.hpp"

namespace example {

/// n unit hexes in a row along x, and particles behind them; time 1e-6 * step.
inline io::Snapshot snapshot(std::int64_t step, int n_elements, int n_particles) {
  io::Snapshot s;
  s.step = step;
  s.time = 1e-6 * static_cast<double>(step);
  for (int i = 0; n_elements > 0 && i <= n_elements; ++i)
    for (int k = 0; k < 4; ++k) {
      s.node_x.emplace_back(i, k == 1 || k == 2 ? 1 : 0, k >= 2 ? 1 : 0);
      s.node_v.emplace_back(0, 0, -8000);
    }
  for (std::int32_t el = 0; el < n_elements; ++el) {
    const std::int32_t a = 4 * el, b = a + 4;
    s.element_node.push_back({a, b, b + 1, a + 1, a + 3, b + 3, b + 2, a + 2});
  }
  for (int i = 0; i < n_particles; ++i) {
    s.particle_x.emplace_back(-1.0 - i, 0.5, 0.5);
    s.particle_v.emplace_back(100.0 * i, 0, -1);
  }
  const auto field = [&](const char* name, double element, double particle, double slope) {
    io::Snapshot::Field f{name, {}, {}};
    for (int i = 0; i < n_elements; ++i) f.element.push_back(element + slope * i);
    for (int i = 0; i < n_particles; ++i) f.particle.push_back(particle + slope * i);
    s.fields.push_back(f);
  };
  field("pressure", 1e9, -1e6, 1e3);
  field("speed", 8000, 0, 100);
  field("temperature", 294, 900, 1);
  field("damage", 0, 1, 0);
  field("body", 0, 1, 0);
  field("mass", 1e-6, 1e-6, 0);
  s.scalars = {{"peak_pressure", 1.5e11}, {"a second one", -3}};
  return s;
}

}  // namespace example
