// SPDX-License-Identifier: Apache-2.0
#include "eos/hugoniot.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"

namespace eos {

namespace {

/// Bisection of f, negative at lo and not at hi, to the last bit.
template <class F>
double bisect(double lo, double hi, F&& f) {
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (lo + hi);
    if (mid <= lo || mid >= hi) break;
    (f(mid) < 0 ? lo : hi) = mid;
  }
  return 0.5 * (lo + hi);
}

/// Largest 1 - rho_0/rho to look at.
double search_limit(const Eos& model, double rho_0) {
  const auto* m = std::get_if<MieGrueneisen>(&model);
  if (!m) return 0.99999;
  const double rho_guard = m->rho_0 / (1 - m->x_guard);
  return 1 - rho_0 / rho_guard;
}

}  // namespace

HugoniotPoint hugoniot(const Eos& model, double rho_0, double up, double e_0) {
  const State<double> ahead = state(model, rho_0, e_0);
  if (up == 0) return {0, std::sqrt(ahead.c2), ahead.p, rho_0, e_0, ahead.temperature};
  // x = 1 - rho_0/rho = up/Us; e follows from up and x, and momentum is the equation left: (p - p_0) x = rho_0 up^2
  const auto energy = [&](double x) { return e_0 + 0.5 * up * up + ahead.p * x / rho_0; };
  const auto excess = [&](double x) {
    return (state(model, rho_0 / (1 - x), energy(x)).p - ahead.p) * x - rho_0 * up * up;
  };
  const double x_end = search_limit(model, rho_0);
  if (!(up > 0) || !(excess(x_end) > 0))
    throw core::CaseError("Hugoniot: particle velocity " + std::to_string(up) +
                          " m/s is outside the range of the equation of state; the largest compression it covers is " +
                          std::to_string(1 / (1 - x_end)));
  const double x = bisect(0, x_end, excess);
  const double rho = rho_0 / (1 - x), e = energy(x);
  return {up, up / x, ahead.p + rho_0 * up * up / x, rho, e, state(model, rho, e).temperature};
}

double impact_pressure(const Eos& a, double rho_0_a, const Eos& b, double rho_0_b, double v) {
  if (!(v > 0)) return 0;
  const double u = bisect(0, v, [&](double up_b) {
    return hugoniot(b, rho_0_b, up_b).p - hugoniot(a, rho_0_a, v - up_b).p;
  });
  return hugoniot(b, rho_0_b, u).p;
}

}  // namespace eos
