// SPDX-License-Identifier: Apache-2.0
#include "eos/hugoniot.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

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

/// The balance of momentum behind a shock to up [m/s] that compresses by x = 1 - rho_0/rho = up/Us; e follows from up and x.
struct Balance {
  const Eos& model;
  double rho_0, up, e_0, p_0;
  double energy(double x) const { return e_0 + 0.5 * up * up + p_0 * x / rho_0; }
  /// (p - p_0) x - rho_0 up^2 [Pa]: 0 on the Hugoniot
  double excess(double x) const { return (state(model, rho_0 / (1 - x), energy(x)).p - p_0) * x - rho_0 * up * up; }
  bool in_range() const { return up > 0 && excess(search_limit(model, rho_0)) > 0; }
};

Balance balance(const Eos& model, double rho_0, double up, double e_0) { return {model, rho_0, up, e_0, state(model, rho_0, e_0).p}; }

}  // namespace

HugoniotPoint hugoniot(const Eos& model, double rho_0, double up, double e_0) {
  const State<double> ahead = state(model, rho_0, e_0);
  if (up == 0) return {0, std::sqrt(ahead.c2), ahead.p, rho_0, e_0, ahead.temperature};
  const Balance shock = balance(model, rho_0, up, e_0);
  const double x_end = search_limit(model, rho_0);
  if (!shock.in_range())
    throw core::CaseError("Hugoniot: particle velocity " + std::to_string(up) +
                          " m/s is outside the range of the equation of state; the largest compression it covers is " +
                          std::to_string(1 / (1 - x_end)));
  const double x = bisect(0, x_end, [&](double a) { return shock.excess(a); });
  const double rho = rho_0 / (1 - x), e = shock.energy(x);
  return {up, up / x, ahead.p + rho_0 * up * up / x, rho, e, state(model, rho, e).temperature};
}

/// Largest particle velocity up to v whose shock the model's range covers [m/s].
static double largest_covered(const Eos& model, double rho_0, double v) {
  const auto covered = [&](double up) { return balance(model, rho_0, up, 0).in_range(); };
  return covered(v) ? v : (1 - 1e-9) * bisect(0, v, [&](double up) { return covered(up) ? -1 : 1; });
}

double impact_pressure(const Eos& a, double rho_0_a, const Eos& b, double rho_0_b, double v) {
  if (!(v > 0)) return 0;
  const auto excess = [&](double up_b) { return hugoniot(b, rho_0_b, up_b).p - hugoniot(a, rho_0_a, v - up_b).p; };
  const double slowest = v - largest_covered(a, rho_0_a, v), fastest = largest_covered(b, rho_0_b, v);
  if (!(slowest < fastest) || excess(slowest) > 0 || excess(fastest) < 0) return 0;
  return hugoniot(b, rho_0_b, bisect(slowest, fastest, excess)).p;
}

/// Angle by which an attached shock of pressure p turns a stream of speed q; less than nothing where none stands in it [rad].
static double turning(const HugoniotPoint& shock, double q) {
  if (shock.Us >= q) return -1;
  const double along = std::sqrt(q * q - shock.Us * shock.Us);
  return std::asin(shock.Us / q) - std::atan2(shock.Us - shock.up, along);
}

ObliqueImpact onset_of_jetting(const Eos& a, double rho_0_a, const Eos& b, double rho_0_b, double v) {
  if (!(v > 0)) return {0, 0};
  constexpr int n = 200;
  for (double reach = v;; reach *= 2) {  // slow bodies, and soft ones on hard, are sped up by more than v before they jet
    const double up_end = std::min(largest_covered(a, rho_0_a, reach), largest_covered(b, rho_0_b, reach));
    const double p_a_end = hugoniot(a, rho_0_a, up_end).p;
    double up_b_end = up_end;
    if (hugoniot(b, rho_0_b, up_end).p > p_a_end) up_b_end = bisect(0, up_end, [&](double up) { return hugoniot(b, rho_0_b, up).p - p_a_end; });
    std::vector<HugoniotPoint> in_a, in_b;  // shocks of equal pressure
    for (int k = 1; k <= n; ++k) {
      const HugoniotPoint shock = hugoniot(b, rho_0_b, up_b_end * k / n);
      in_b.push_back(shock);
      in_a.push_back(hugoniot(a, rho_0_a, bisect(0, up_end, [&](double up) { return hugoniot(a, rho_0_a, up).p - shock.p; })));
    }
    // B's surface runs into the point of touch at v / tan(angle), A's at v / sin(angle)
    const auto most = [&](double angle) {
      double turned = -1;
      std::size_t at = 0;
      for (std::size_t k = 0; k < in_b.size(); ++k) {
        const double ta = turning(in_a[k], v / std::sin(angle)), tb = turning(in_b[k], v / std::tan(angle));
        if (ta >= 0 && tb >= 0 && ta + tb > turned) turned = ta + tb, at = k;
      }
      return std::pair{turned, at};
    };
    const double angle = bisect(1e-6, 1.5, [&](double x) { return x - most(x).first; });
    const std::size_t at = most(angle).second;
    if (at + 1 < in_b.size()) return {angle, in_b[at].p};
    if (up_end < reach) return {0, 0};
  }
}

}  // namespace eos
