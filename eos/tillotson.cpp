// SPDX-License-Identifier: Apache-2.0
#include "eos/tillotson.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace eos {

void prepare(Tillotson& m) {
  if (!(m.rho_0 > 0 && m.A > 0 && m.cv > 0 && m.E_0 > 0 && m.E_cv > m.E_iv))
    throw core::CaseError("tillotson: rho_0, A, cv and E_0 must be positive and E_cv above E_iv; they are " +
                          std::to_string(m.rho_0) + " kg/m3, " + std::to_string(m.A) + " Pa, " +
                          std::to_string(m.cv) + " J/(kg K), " + std::to_string(m.E_0) + " J/kg and " +
                          std::to_string(m.E_cv) + ", " + std::to_string(m.E_iv) + " J/kg");
  const auto slope = [&](double x, double e) -> std::array<double, 2> {
    const auto branch = detail::condensed(m, m.rho_0 / (1 - x), e);
    return {branch.p / m.rho_0, branch.dp_de / m.rho_0};
  };
  constexpr double x_max = 0.75;
  m.isentrope = fit_reference_isentrope(1 - 1 / (1 - max_condensed_expansion), x_max, slope,
                                        [](double) { return 1.0; });
}

double cold_energy(const Tillotson& m, double rho) {
  const double x = std::clamp(1 - m.rho_0 / rho, m.isentrope.energy.x_min, m.isentrope.energy.x_max);
  return m.isentrope.energy(x) - m.cv * m.T_0 * std::exp(m.isentrope.heating(x));
}

}  // namespace eos
