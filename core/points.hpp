// SPDX-License-Identifier: Apache-2.0
// The state of matter at material points, one row a point. Elements and particles carry the same rows and go through
// the same update (material/update.hpp), so that conversion copies a row and nothing is translated.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace core {

struct Points {
  std::vector<double> m;        ///< mass [kg]
  std::vector<double> rho;      ///< density [kg/m3]
  std::vector<double> e;        ///< specific internal energy [J/kg], 0 in the cold reference state
  std::vector<double> p;        ///< pressure [Pa]
  std::vector<double> q;        ///< bulk viscous pressure [Pa] (elements; particles have it pairwise)
  std::vector<double> c;        ///< bulk + shear sound speed, longitudinal [m/s]
  std::vector<double> T;        ///< temperature [K]
  std::array<std::vector<double>, 6> s;  ///< deviatoric stress [Pa], xx yy zz xy yz zx
  std::vector<double> eps_p;    ///< equivalent plastic strain [-]
  std::vector<double> damage;   ///< 0 whole ... 1 failed (carries no tension and no shear) [-]
  std::vector<double> p_max;    ///< highest pressure seen so far [Pa]

  std::size_t size() const { return m.size(); }

  /// Calls f(vector&) for every field, in a fixed order: resizing, reordering, checkpoints.
  template <class F>
  void each_field(F&& f) {
    for (auto* a : {&m, &rho, &e, &p, &q, &c, &T}) f(*a);
    for (auto& a : s) f(a);
    for (auto* a : {&eps_p, &damage, &p_max}) f(*a);
  }

  void resize(std::size_t n) {
    each_field([n](std::vector<double>& a) { a.resize(n, 0.0); });
  }
};

/// Stress of one of them, xx yy zz xy yz zx [Pa].
inline std::array<double, 6> stress(const Points& pt, std::size_t i) {
  const double p = pt.p[i];
  return {pt.s[0][i] - p, pt.s[1][i] - p, pt.s[2][i] - p, pt.s[3][i], pt.s[4][i], pt.s[5][i]};
}

}  // namespace core
