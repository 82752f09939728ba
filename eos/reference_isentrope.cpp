// SPDX-License-Identifier: Apache-2.0
#include "eos/reference_isentrope.hpp"

#include <algorithm>
#include <cmath>

#include "core/types.hpp"

namespace eos {

namespace {

using Pair = std::array<double, 2>;
using Slope = std::function<Pair(double, double)>;

constexpr int n = IsentropeFit::n_coefficients;

/// Carries {e_s, ln T_s/T_0} from x to x_end by classical Runge-Kutta.
Pair integrate(const Slope& slope, double x, Pair y, double x_end) {
  constexpr int n_steps = 100;  // between two nodes; the error is below round-off of the fit
  const double h = (x_end - x) / n_steps;
  for (int i = 0; i < n_steps; ++i) {
    const Pair k1 = slope(x, y[0]);
    const Pair k2 = slope(x + h / 2, y[0] + h / 2 * k1[0]);
    const Pair k3 = slope(x + h / 2, y[0] + h / 2 * k2[0]);
    const Pair k4 = slope(x + h, y[0] + h * k3[0]);
    for (int j = 0; j < 2; ++j) y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
    x += h;
  }
  return y;
}

/// Powers of t from the values at the Chebyshev nodes t_k = cos(pi (k + 1/2)/n).
std::array<double, n> powers(const std::array<double, n>& value) {
  std::array<double, n> result{}, before{}, now{};
  before[0] = 1;  // T_0
  now[1] = 1;     // T_1
  for (int j = 0; j < n; ++j) {
    double c = 0;
    for (int k = 0; k < n; ++k) c += value[k] * std::cos(core::pi * j * (k + 0.5) / n);
    c *= (j == 0 ? 1.0 : 2.0) / n;
    const auto& polynomial = j == 0 ? before : now;
    for (int i = 0; i < n; ++i) result[i] += c * polynomial[i];
    if (j == 0) continue;
    std::array<double, n> next{};
    for (int i = 0; i < n; ++i) next[i] = (i > 0 ? 2 * now[i - 1] : 0.0) - before[i];
    before = now;
    now = next;
  }
  return result;
}

}  // namespace

ReferenceIsentrope fit_reference_isentrope(double x_min, double x_max, const Slope& slope,
                                           const std::function<double(double)>& weight) {
  std::array<double, n> x{}, energy{}, heating{};
  for (int k = 0; k < n; ++k) {
    x[k] = x_min + (x_max - x_min) * (1 + std::cos(core::pi * (k + 0.5) / n)) / 2;
    // a node within rounding of the reference state would divide 0 by 0
    if (std::abs(x[k]) < 1e-9 * x_max) x[k] = 1e-9 * x_max;
  }
  const auto visit = [&](int k, double& from, Pair& y) {
    y = integrate(slope, from, y, x[k]);
    from = x[k];
    energy[k] = y[0] * weight(x[k]) / x[k];
    heating[k] = y[1] / x[k];
  };
  double from = 0;
  Pair y{};
  for (int k = n - 1; k >= 0; --k)  // nodes run from x_max down
    if (x[k] > 0) visit(k, from, y);
  from = 0;
  y = {};
  for (int k = 0; k < n; ++k)
    if (x[k] < 0) visit(k, from, y);
  return {{x_min, x_max, powers(energy)}, {x_min, x_max, powers(heating)}};
}

}  // namespace eos
