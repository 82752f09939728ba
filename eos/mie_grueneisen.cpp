// SPDX-License-Identifier: Apache-2.0
#include "eos/mie_grueneisen.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"

namespace eos {

namespace {

/// Smallest x in (0, 1) at which f falls to zero, 1 if none.
template <class F>
double first_root(F&& f) {
  constexpr int n_cells = 10000;
  for (int i = 1; i < n_cells; ++i) {
    double hi = static_cast<double>(i) / n_cells, lo = hi - 1.0 / n_cells;
    if (f(hi) > 0) continue;
    for (int k = 0; k < 60; ++k) (f(0.5 * (lo + hi)) > 0 ? lo : hi) = 0.5 * (lo + hi);
    return hi;
  }
  return 1.0;
}

}  // namespace

void prepare(MieGrueneisen& m) {
  if (!(m.rho_0 > 0 && m.c_0 > 0 && m.cv > 0))
    throw core::CaseError("mie_grueneisen: rho_0, c_0 and cv must be positive; they are " + std::to_string(m.rho_0) +
                          " kg/m3, " + std::to_string(m.c_0) + " m/s, " + std::to_string(m.cv) + " J/(kg K)");
  const auto D = [&](double x) { return 1 - x * (m.s_1 + x * (m.s_2 + x * m.s_3)); };
  const auto g = [&](double x) { return m.gamma_0 + m.a * x / (1 - x); };
  constexpr double part_of_range = 0.9;
  m.x_pole = first_root(D);
  const double x_limit = first_root([&](double x) { return 2 * part_of_range - g(x) * x; });
  m.x_guard = std::min({part_of_range * m.x_pole, x_limit, part_of_range});
  m.gamma_2 = std::min(2.0 / 3.0, m.gamma_0) - m.gamma_0 + (m.a - m.gamma_0);
  const auto slope = [&](double x, double e) -> std::array<double, 2> {
    const double p_H = m.c_0 * m.c_0 * x / (D(x) * D(x));  // over rho_0
    return {p_H * (1 - g(x) * x / 2) + g(x) * e, g(x)};
  };
  m.isentrope = fit_reference_isentrope(0, m.x_guard, slope, [&](double x) { return D(x) * D(x); }).energy;
}

double cold_energy(const MieGrueneisen& m, double rho) {
  const double u = std::clamp(1 - rho / m.rho_0, 0.0, max_condensed_expansion);
  const auto ref = detail::reference(m, 1 - m.rho_0 / rho, u);
  return ref.e - m.cv * ref.temperature;
}

}  // namespace eos
