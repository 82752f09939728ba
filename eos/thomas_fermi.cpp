// SPDX-License-Identifier: Apache-2.0
#include "eos/thomas_fermi.hpp"

#include <array>
#include <cmath>

#include "core/parallel.hpp"
#include "core/types.hpp"

namespace eos {

namespace {

using core::pi;

// CODATA 2018
constexpr double bohr = 5.29177210903e-11, hartree = 4.3597447222071e-18, boltzmann = 1.380649e-23, atomic_mass = 1.66053906660e-27;
constexpr double hartree_K = hartree / boltzmann;

constexpr double eta_low = -12, eta_high = 60, eta_step = 0.02;

/// Integral of x^k/(1 + exp(x - eta)) with x = t^2; the trapezoidal rule converges exponentially.
double quadrature(double k, double eta) {
  constexpr double h = 0.02;
  double sum = k < 0 ? 0.5 * 2 / (1 + std::exp(-eta)) : 0;  // the integrand at t = 0
  const double end = std::sqrt(std::max(eta, 0.0) + 45);
  for (double t = h; t < end; t += h) sum += 2 * std::pow(t, 2 * k + 1) / (1 + std::exp(t * t - eta));
  return sum * h;
}

struct FermiTable {
  std::vector<std::array<double, 3>> a;  ///< I_-1/2, I_1/2, I_3/2
  FermiTable() {
    for (double eta = eta_low; eta < eta_high + 1.5 * eta_step; eta += eta_step)
      a.push_back({quadrature(-0.5, eta), quadrature(0.5, eta), quadrature(1.5, eta)});
  }
};

double hermite(double t, double y0, double y1, double s0, double s1) {
  const double r = 1 - t;
  return y0 * r * r * (1 + 2 * t) + y1 * t * t * (3 - 2 * t) + t * r * (r * s0 - t * s1);
}

/// Second derivatives of the natural cubic spline through y at steps of h.
std::vector<double> spline(const std::vector<double>& y, double h) {
  const std::size_t n = y.size();
  std::vector<double> m(n, 0.0), c(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double d = 6 * (y[i + 1] - 2 * y[i] + y[i - 1]) / (h * h), pivot = 4 - c[i - 1];
    c[i] = 1 / pivot;
    m[i] = (d - m[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) m[i] -= c[i] * m[i + 1];
  return m;
}

struct Curve {
  double value, slope;
};

/// The spline at x (in steps from the first point); beyond the ends the end tangents.
Curve evaluate(const std::vector<double>& y, const std::vector<double>& m, double h, double x) {
  const double last = static_cast<double>(y.size() - 1);
  const double held = std::min(std::max(x, 0.0), last);
  const auto i = std::min(static_cast<std::size_t>(held), y.size() - 2);
  const double b = held - static_cast<double>(i), a = 1 - b;
  const double value = a * y[i] + b * y[i + 1] + ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]) * h * h / 6;
  const double slope = (y[i + 1] - y[i]) / h + ((1 - 3 * a * a) * m[i] + (3 * b * b - 1) * m[i + 1]) * h / 6;
  return {value + slope * (x - held) * h, slope};
}

constexpr double ln_rho_step = 0.4, ln_T_step = 0.4;
constexpr double T_first = 0.01;  ///< hartree; below, heat follows the power of T found here
constexpr int n_T = 36;           ///< to 0.01 e^14 hartree, 4e9 K

double cell_radius(double A, double rho) { return std::cbrt(3 * A * atomic_mass / (4 * pi * rho)) / bohr; }

}  // namespace

FermiIntegrals fermi_integrals(double eta) {
  static const FermiTable table;
  if (eta < eta_low) {
    const double g = std::exp(eta), root = std::sqrt(pi);
    return {0.5 * root * g * (1 - g / std::sqrt(8.0)), 0.75 * root * g * (1 - g / std::sqrt(32.0))};
  }
  if (eta >= eta_high) {  // Sommerfeld's expansion
    const double s = 1 / (eta * eta), r = std::sqrt(eta), p2 = pi * pi, p4 = p2 * p2;
    return {2.0 / 3 * eta * r * (1 + s * (p2 / 8 + s * (7 * p4 / 640 + s * 31 * p4 * p2 / 3072))),
            0.4 * eta * eta * r * (1 + s * (5 * p2 / 8 - s * (7 * p4 / 384 + s * 155 * p4 * p2 / 21504)))};
  }
  const double at = (eta - eta_low) / eta_step;
  const auto i = static_cast<std::size_t>(at);
  const auto &lo = table.a[i], &hi = table.a[i + 1];
  const double t = at - static_cast<double>(i);
  return {hermite(t, lo[1], hi[1], 0.5 * eta_step * lo[0], 0.5 * eta_step * hi[0]),
          hermite(t, lo[2], hi[2], 1.5 * eta_step * lo[1], 1.5 * eta_step * hi[1])};
}

ThomasFermiCell thomas_fermi(double Z, double R, double T) {
  const double density = std::sqrt(2.0) / (pi * pi) * std::pow(T, 1.5);
  struct Sums {
    double psi, phi, K, J;  ///< phi = psi', J = integral of n T eta
  };
  // in s = sqrt(r/R), in which every integrand stays finite at the nucleus
  const auto slope = [&](double s, const Sums& y) -> Sums {
    const double r = R * s * s, dr = 2 * R * s, eta = y.psi / (r * T);
    const FermiIntegrals I = fermi_integrals(eta);
    const double n = density * I.half, shell = 4 * pi * r * r * dr;
    return {dr * y.phi, dr * 4 * pi * r * n, shell * density * T * I.three_halves, shell * n * T * eta};
  };
  const auto inwards = [&](double eta_R) {
    constexpr int n_steps = 400;
    constexpr double s_end = 1e-3;
    Sums y{R * T * eta_R, T * eta_R, 0, 0};
    const double h = (s_end - 1) / n_steps;
    const auto plus = [](const Sums& a, double w, const Sums& b) {
      return Sums{a.psi + w * b.psi, a.phi + w * b.phi, a.K + w * b.K, a.J + w * b.J};
    };
    for (int i = 0; i < n_steps; ++i) {
      const double s = 1 + h * i;
      const Sums k1 = slope(s, y), k2 = slope(s + h / 2, plus(y, h / 2, k1)), k3 = slope(s + h / 2, plus(y, h / 2, k2)),
                 k4 = slope(s + h, plus(y, h, k3));
      y = plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    }
    const Sums rest = slope(s_end, y);
    y.K -= s_end * rest.K, y.J -= s_end * rest.J;  // to the nucleus; both integrals run inwards, so they are negative
    y.psi -= R * s_end * s_end * y.phi;
    return y;
  };
  // psi(0) rises with the boundary value: bracket, then false position (Illinois)
  const double V = 4 * pi / 3 * R * R * R;
  double lo = std::log(Z / (V * density)) - 60, hi = lo + 60;
  const auto excess = [&](double eta) {
    const double value = inwards(eta).psi / Z - 1;
    return std::isfinite(value) ? std::min(value, 1e3) : 1e3;  // far too many electrons: psi runs away
  };
  double f_lo = -1, f_hi = excess(hi);
  for (double grow = 1; f_hi < 0; grow *= 2) lo = hi, f_lo = f_hi, hi += grow, f_hi = excess(hi);
  for (int i = 0; i < 200 && hi - lo > 1e-15 * std::abs(hi); ++i) {
    const bool halve = i % 4 == 3 || !(f_hi - f_lo > 0);
    const double mid = halve ? 0.5 * (lo + hi) : hi - f_hi * (hi - lo) / (f_hi - f_lo);
    if (mid <= lo || mid >= hi) break;
    const double f = excess(mid);
    if (std::abs(f) < 1e-14) {
      lo = hi = mid;
      break;
    }
    if (f < 0)
      lo = mid, f_lo = f, f_hi *= 0.5;
    else
      hi = mid, f_hi = f, f_lo *= 0.5;
  }
  const double eta = 0.5 * (lo + hi);
  const Sums y = inwards(eta);
  const double p = 2.0 / 3 * density * T * fermi_integrals(eta).three_halves, K = -y.K, J = -y.J;
  return {p, 3 * p * V - K, 3 * p * V - 8.0 / 3 * K + J};
}

ElectronHeat::ElectronHeat(double Z, double A, double rho_min, double rho_max) : Z_(Z), A_(A), ln_rho_min_(std::log(rho_min)) {
  const int n = 2 + static_cast<int>(std::ceil((std::log(rho_max) - ln_rho_min_) / ln_rho_step));
  ln_f_.assign(static_cast<std::size_t>(n), std::vector<double>(n_T));
  curvature_.resize(ln_f_.size());
  fermi_integrals(0);  // its table, before threads need it
  core::for_each_block(ln_f_.size(), 1, [&](std::size_t row, std::size_t) {
    const double R = cell_radius(A, std::exp(ln_rho_min_ + static_cast<double>(row) * ln_rho_step));
    const double cold = thomas_fermi(Z, R, 1e-5).f;
    for (std::size_t k = 0; k < n_T; ++k)
      ln_f_[row][k] = std::log(cold - thomas_fermi(Z, R, T_first * std::exp(static_cast<double>(k) * ln_T_step)).f);
    curvature_[row] = spline(ln_f_[row], ln_T_step);
  });
}

ElectronHeat::Value ElectronHeat::operator()(double rho, double T) const {
  const double at = (std::log(T / hartree_K) - std::log(T_first)) / ln_T_step;
  std::vector<double> value, slope;
  for (std::size_t i = 0; i < ln_f_.size(); ++i) {
    const Curve c = evaluate(ln_f_[i], curvature_[i], ln_T_step, at);
    value.push_back(c.value), slope.push_back(c.slope);
  }
  const double x = (std::log(rho) - ln_rho_min_) / ln_rho_step;
  const Curve f = evaluate(value, spline(value, ln_rho_step), ln_rho_step, x);
  const Curve s = evaluate(slope, spline(slope, ln_rho_step), ln_rho_step, x);
  const double F = -std::exp(f.value) * hartree / (A_ * atomic_mass);
  return {F, F * (1 - s.value), rho * F * f.slope};  // e = f - T df/dT, p = rho^2 df/drho
}

double ElectronHeat::cold_pressure(double rho) const {
  return thomas_fermi(Z_, cell_radius(A_, rho), 1e-5).p * hartree / (bohr * bohr * bohr);
}

}  // namespace eos
