// SPDX-License-Identifier: Apache-2.0
#include "eos/polynomial.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace eos {

void prepare(Polynomial& m) {
  if (!(m.rho_0 > 0 && m.cv > 0))
    throw core::CaseError("polynomial: rho_0 and cv must be positive; they are " + std::to_string(m.rho_0) +
                          " kg/m3, " + std::to_string(m.cv) + " J/(kg K)");
  const auto slope = [&](double x, double e) -> std::array<double, 2> {
    const double mu = 1 / (1 - x) - 1, squeezed = std::max(mu, 0.0);
    const double g = m.C4 + m.C5 * mu + m.C6 * squeezed * squeezed;
    const double p = m.C0 + m.C1 * mu + m.C2 * squeezed * squeezed + m.C3 * mu * mu * mu + g * m.rho_0 * e;
    return {p / m.rho_0, g};
  };
  constexpr double x_max = 0.8;
  m.isentrope = fit_reference_isentrope(1 - 1 / (1 - max_condensed_expansion), x_max, slope,
                                        [](double) { return 1.0; });
}

double cold_energy(const Polynomial& m, double rho) {
  const double x = std::clamp(1 - m.rho_0 / rho, m.isentrope.energy.x_min, m.isentrope.energy.x_max);
  return m.isentrope.energy(x) - m.cv * m.T_0 * std::exp(m.isentrope.heating(x));
}

}  // namespace eos
