// SPDX-License-Identifier: Apache-2.0
#include "eos/wide_range.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/types.hpp"

namespace eos {

namespace {

constexpr double boltzmann = 1.380649e-23, atomic_mass = 1.66053906660e-27;  // CODATA 2018
constexpr double T_rest = 298.15, atmosphere = 1e5;
constexpr double gas_below = 0.1;     ///< rho/rho_0 around which the entropy of the gas comes in
constexpr double max_stretch = 0.92;  ///< lowest rho/rho_0 of a solid under tension: -4 GPa in aluminium, more than any spall limit
constexpr double eta_end = 30;        ///< rho/rho_0 from which the cold curve is Thomas and Fermi's
constexpr double table_rho_min = 1e-5, table_rho_max = 10;  ///< of rho_0

/// D_3(u) = 3/u^3 times the integral of x^3/(e^x - 1) from 0 to u.
double debye(double u) {
  constexpr int n = 64;  // Simpson
  const double end = std::min(u, 40.0), h = end / n;
  double sum = 0;
  for (int i = 1; i <= n; ++i) {
    const double x = h * i;
    sum += x * x * x / std::expm1(x) * (i == n ? 1 : i % 2 ? 4 : 2);
  }
  return sum * h / 3 * 3 / (u * u * u);
}

double bisect(double lo, double hi, auto&& f) {  // f rises
  for (int i = 0; i < 60; ++i) {
    const double mid = 0.5 * (lo + hi);
    (f(mid) < 0 ? lo : hi) = mid;
  }
  return 0.5 * (lo + hi);
}

double gruneisen(double gamma_0, double eta) {
  const double y = 1 - eta;
  return 2.0 / 3 + (gamma_0 - 2.0 / 3) * (eta > 1 ? 1 / eta : 1 + y - y * y);
}
/// Integral of gamma/eta from 1.
double ln_debye(double gamma_0, double eta) {
  const double varying = eta > 1 ? 1 - 1 / eta : std::log(eta) + eta - 0.5 * eta * eta - 0.5;
  return 2.0 / 3 * std::log(eta) + (gamma_0 - 2.0 / 3) * varying;
}

const std::vector<Metal> metals = {
    {"Al", 13, 26.98154, 2700, 5350, 1.34, 8000, 2.10, 390, 12.1e6, 933.5, 0.397e6, 2792, 13700,
     "Us(up): Marsh, LASL Shock Hugoniot Data (1980), Mitchell & Nellis, J. Appl. Phys. 52 (1981) 3363; heats: CRC Handbook of Chemistry and Physics"},
    {"Cu", 29, 63.546, 8930, 3940, 1.489, 8000, 2.02, 315, 5.30e6, 1357.8, 0.209e6, 2835, 13336,
     "Us(up), gamma: Steinberg, UCRL-MA-106439 (1996); heats: CRC Handbook of Chemistry and Physics"},
    {"Fe", 26, 55.845, 7850, 3574, 1.92, 5000, 1.69, 420, 7.40e6, 1811, 0.247e6, 3134, 12140,
     "Us(up) above 13 GPa: Marsh, LASL Shock Hugoniot Data (1980), so the transition at 13 GPa is not resolved; heats: CRC Handbook of Chemistry and Physics"},
    {"Ti", 22, 47.867, 4510, 4937, 1.04, 6000, 1.23, 380, 9.78e6, 1941, 0.295e6, 3560, 12961,
     "Us(up): Marsh, LASL Shock Hugoniot Data (1980); heats: CRC Handbook of Chemistry and Physics"},
};

}  // namespace

const Metal& find_metal(const std::string& name) {
  std::string valid;
  for (const Metal& m : metals) {
    if (m.name == name) return m;
    valid += (valid.empty() ? "" : ", ") + m.name;
  }
  throw core::CaseError("no wide-range model of '" + name + "'; valid: " + valid);
}

std::vector<std::string> metal_names() {
  std::vector<std::string> names;
  for (const Metal& m : metals) names.push_back(m.name);
  return names;
}

/// Equilibrium on one isotherm: vertices of the lower convex hull of F over v, falling in density.
struct WideRange::Hull {
  std::vector<double> rho, f;
  std::vector<std::size_t> place;   ///< on the fine grid of densities
  double T = 0;

  std::size_t segment(double density) const {  // rho[k] >= density > rho[k + 1]
    std::size_t k = 0;
    while (k + 2 < rho.size() && rho[k + 1] >= density) ++k;
    return k;
  }
  bool mixed(std::size_t k) const { return place[k + 1] > place[k] + 1; }
  double pressure(std::size_t k) const { return std::max(-(f[k + 1] - f[k]) / (1 / rho[k + 1] - 1 / rho[k]), 0.0); }
};

WideRange::WideRange(const Metal& metal)
    : m_(metal), R_(boltzmann / (metal.A * atomic_mass)),
      electrons_(metal.Z, metal.A, table_rho_min * metal.rho_0, 2 * eta_end * metal.rho_0) {
  p_rest_ = 0, T_m0_ = 1.25 * m_.T_melt, S_m_ = m_.heat_of_fusion / m_.T_melt;
  const auto heat = [&](double rho) {
    const Value i = ion(rho, T_rest, true);
    return i.p + electrons_(rho, T_rest).p;
  };
  p_rest_ = -heat(m_.rho_0);
  // rho dp_c/drho = rho_0 c_0^2 less the same of the thermal part on the isentrope
  const double step = 1e-3;
  const auto on_isentrope = [&](double rho) {
    const double T = T_rest * std::exp(ln_debye(m_.gamma_0, rho / m_.rho_0));
    return ion(rho, T, true).p + electrons_(rho, T).p;
  };
  const double K = m_.rho_0 * m_.c_0 * m_.c_0 -
                   (on_isentrope(m_.rho_0 * (1 + step)) - on_isentrope(m_.rho_0 * (1 - step))) / (2 * step);
  // p_c = B (eta^m - eta^2) + p_rest eta^2 with the modulus and the work to separate the atoms
  B_ = 0, power_ = bisect(2.05, 12, [&](double m) {
    const double b = (K - 2 * p_rest_) / (m - 2);
    return (b / (m - 1) - b + p_rest_) / m_.rho_0 + m_.E_coh;  // the integral of p_c/rho^2 up to rho_0 is minus the work
  });
  B_ = (K - 2 * p_rest_) / (power_ - 2);
  for (int i = 0; i < 2; ++i) {  // each is all but independent of the other
    calibrate_melting();
    integrate_cold_curve();
    calibrate_boiling();
  }
}

WideRange::Value WideRange::ion(double rho, double T, bool solid) const {
  const double eta = rho / m_.rho_0, gamma = gruneisen(m_.gamma_0, eta), rt = R_ * T;
  const double ln_theta = ln_debye(m_.gamma_0, eta);
  if (solid) {
    const double theta = m_.theta_0 * std::exp(ln_theta), u = theta / T, d = debye(u);
    const double e = rt * (9.0 / 8 * u + 3 * d);
    return {rt * (9.0 / 8 * u + 3 * std::log(-std::expm1(-u)) - d), e, gamma * rho * e};
  }
  const double T_m = T_m0_ * std::exp(2 * ln_theta) * std::pow(eta, -2.0 / 3), root = std::cbrt(T_m / T);
  const double rise = 2 * gamma - 2.0 / 3;  // d ln T_m/d ln rho
  const double y = eta / gas_below, fade = 1 / (1 + y * y), dfade = -2 * y * y * fade * fade;  // eta d(fade)/d(eta)
  const double ln_ratio = 2 * std::log(m_.theta_0) + 2 * ln_theta - std::log(T * T_m);
  return {rt * (-5.5 + 4.5 * root + 1.5 * ln_ratio) - S_m_ * (T - T_m) - S_gas_ * T * fade,
          1.5 * rt * (1 + root) + S_m_ * T_m,
          rho * (rt * (1 + 1.5 * rise * root) + S_m_ * T_m * rise - S_gas_ * T * dfade)};
}

double WideRange::melting_temperature(double rho) const {
  const double eta = rho / m_.rho_0;
  return T_m0_ * std::exp(2 * ln_debye(m_.gamma_0, eta)) * std::pow(eta, -2.0 / 3);
}

WideRange::Cold WideRange::cold(double rho) const {
  const double eta = rho / m_.rho_0;
  if (eta <= 1) {
    const double p = B_ * (std::pow(eta, power_) - eta * eta) + p_rest_ * eta * eta;
    const double e = (B_ * (std::pow(eta, power_ - 1) - 1) / (power_ - 1) + (p_rest_ - B_) * (eta - 1)) / m_.rho_0;
    return {e, p};
  }
  const double at = (eta - 1) / d_eta_, last = static_cast<double>(e_cold_.size() - 1);
  if (at <= last) {
    // e cubic with de/deta = p/(rho_0 eta^2); p is its derivative, so that both stay of one function
    const auto i = std::min(static_cast<std::size_t>(at), e_cold_.size() - 2);
    const double t = at - static_cast<double>(i), r = 1 - t, eta_0 = 1 + static_cast<double>(i) * d_eta_, eta_1 = eta_0 + d_eta_;
    const double s0 = p_cold_[i] / (m_.rho_0 * eta_0 * eta_0) * d_eta_, s1 = p_cold_[i + 1] / (m_.rho_0 * eta_1 * eta_1) * d_eta_;
    const double rise = e_cold_[i + 1] - e_cold_[i];
    const double e = e_cold_[i] + rise * t * t * (3 - 2 * t) + t * r * (r * s0 - t * s1);
    const double de = 6 * rise * t * r + s0 * r * (1 - 3 * t) + s1 * t * (3 * t - 2);
    return {e, de / d_eta_ * m_.rho_0 * eta * eta};
  }
  const auto pressure = [&](double y) {
    if (y >= y_end_) return std::exp(ln_p_end_ + slope_end_ * (y - y_end_));
    const double w = y_end_ - y_fit_, t = (y - y_fit_) / w, r = 1 - t;
    return std::exp(ln_p_fit_ + (ln_p_end_ - ln_p_fit_) * t * t * (3 - 2 * t) + w * t * r * (r * slope_fit_ - t * slope_end_));
  };
  // e = integral of p/rho dy, Simpson
  const double y = std::log(eta);
  constexpr int n = 40;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double z = y_fit_ + (y - y_fit_) * i / n;
    sum += pressure(z) * std::exp(-z) * (i == 0 || i == n ? 1 : i % 2 ? 4 : 2);
  }
  return {e_fit_ + sum * (y - y_fit_) / (3 * n) / m_.rho_0, pressure(y)};
}

WideRange::Value WideRange::phase(double rho, double T, bool solid) const {
  const Cold c = cold(rho);
  const Value i = ion(rho, T, solid);
  const auto el = electrons_(rho, T);
  return {c.e + i.f + el.f, c.e + i.e + el.e - e_rest_, c.p + i.p + el.p};
}

double WideRange::density_at_rest(double T, bool solid) const {
  // p falls with rho from rho_0 down to the limit of stability; the branch near rho_0 is the condensed one
  double hi = m_.rho_0 * 1.02, lo = hi;
  while (lo > 0.3 * m_.rho_0 && phase(lo, T, solid).p > 0) hi = lo, lo *= 0.99;
  return bisect(lo, hi, [&](double rho) { return phase(rho, T, solid).p; });
}

/// T_m(rho_0) and S_m such that solid and liquid have the same Gibbs energy at (T_melt, p = 0) and differ by the heat of fusion.
/// Only densities up to rho_0 matter here, where the cold curve is known already.
void WideRange::calibrate_melting() {
  d_eta_ = 1, e_cold_ = {0, 0}, p_cold_ = {p_rest_, p_rest_ + m_.rho_0 * m_.c_0 * m_.c_0};  // never used beyond rho_0 (1.02)
  const double T = m_.T_melt;
  for (int i = 0; i < 40; ++i) {
    const double rho_s = density_at_rest(T, true), rho_l = density_at_rest(T, false);
    const Value s = phase(rho_s, T, true), l = phase(rho_l, T, false);
    S_m_ += 0.7 * (m_.heat_of_fusion - (l.e - s.e)) / T;
    // g_l - g_s = 0: a higher T_m raises the fluid's F by about S_m dT_m
    T_m0_ -= 0.7 * (l.f - s.f) / (S_m_ + R_ * 1.5);
  }
}

/// Pressure of ions and electrons at the thermal energy e; between solid and fluid the melting at constant density.
double WideRange::thermal_pressure(double rho, double e) const {
  const auto energy = [&](double T, bool solid) { return ion(rho, T, solid).e + electrons_(rho, T).e; };
  const auto pressure = [&](double T, bool solid) { return ion(rho, T, solid).p + electrons_(rho, T).p; };
  const double T_m = melting_temperature(rho);
  const double begins = energy(T_m, true), ends = energy(T_m, false);
  if (e > begins && e < ends) {
    const double share = (e - begins) / (ends - begins);
    return (1 - share) * pressure(T_m, true) + share * pressure(T_m, false);
  }
  const bool solid = e <= begins;
  const double T = std::exp(bisect(0, std::log(1e8), [&](double ln_T) { return energy(std::exp(ln_T), solid) - e; }));
  return pressure(T, solid);
}

void WideRange::integrate_cold_curve() {
  const auto thermal_rest = ion(m_.rho_0, T_rest, true).e + electrons_(m_.rho_0, T_rest).e;
  const double eta_fit = [&] {
    const double x = m_.up_fit / (m_.c_0 + m_.s * m_.up_fit);
    return 1 / (1 - x);
  }();
  constexpr int n = 120;
  d_eta_ = (eta_fit - 1) / n;
  const auto pressure = [&](double eta, double e_c) {
    const double x = 1 - 1 / eta, Us = m_.c_0 / (1 - m_.s * x), p_H = m_.rho_0 * Us * Us * x;
    return p_H - thermal_pressure(m_.rho_0 * eta, 0.5 * p_H * x / m_.rho_0 + thermal_rest - e_c);
  };
  std::vector<double> e{0}, p{pressure(1, 0)};
  const auto slope = [&](double eta, double e_c) { return pressure(eta, e_c) / (m_.rho_0 * eta * eta); };
  for (int i = 0; i < n; ++i) {  // classical Runge-Kutta
    const double eta = 1 + i * d_eta_, h = d_eta_;
    const double k1 = slope(eta, e[e.size() - 1]), k2 = slope(eta + h / 2, e.back() + h / 2 * k1),
                 k3 = slope(eta + h / 2, e.back() + h / 2 * k2), k4 = slope(eta + h, e.back() + h * k3);
    e.push_back(e.back() + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4));
    p.push_back(pressure(eta + h, e.back()));
  }
  e_cold_ = e, p_cold_ = p, e_fit_ = e.back();
  y_fit_ = std::log(eta_fit), y_end_ = std::log(eta_end);
  ln_p_fit_ = std::log(p.back());
  slope_fit_ = (p[n] - p[n - 4]) / (4 * d_eta_) * eta_fit / p.back();
  const double at_end = electrons_.cold_pressure(eta_end * m_.rho_0);
  ln_p_end_ = std::log(at_end);
  slope_end_ = std::log(electrons_.cold_pressure(1.05 * eta_end * m_.rho_0) / at_end) / std::log(1.05);
}

WideRange::Hull WideRange::equilibrium(double T) const {
  // densities: fine where there is condensed matter, ever thinner vapour down to where none is left
  std::vector<double> rho;
  for (double eta = table_rho_max * 1.05; eta > 1.5; eta /= 1.01) rho.push_back(eta * m_.rho_0);
  for (double eta = rho.back() / m_.rho_0 - 0.001; eta > 0.3; eta -= 0.001) rho.push_back(eta * m_.rho_0);
  for (double eta = rho.back() / m_.rho_0 / 1.01; eta > table_rho_min * 0.9; eta /= 1.01) rho.push_back(eta * m_.rho_0);
  for (double r = rho.back() / 2; r > 1e-40; r /= 2) rho.push_back(r);
  Hull h;
  h.T = T;
  for (std::size_t i = 0; i < rho.size(); ++i) {
    const double f = phase(rho[i], T, T < melting_temperature(rho[i])).f, v = 1 / rho[i];
    while (h.rho.size() >= 2) {
      const std::size_t k = h.rho.size() - 1;
      const double v0 = 1 / h.rho[k - 1], v1 = 1 / h.rho[k];
      if ((h.f[k] - h.f[k - 1]) * (v - v0) < (f - h.f[k - 1]) * (v1 - v0)) break;
      h.rho.pop_back(), h.f.pop_back(), h.place.pop_back();
    }
    h.rho.push_back(rho[i]), h.f.push_back(f), h.place.push_back(i);
  }
  return h;
}

/// The entropy of the gas such that liquid and vapour are in equilibrium at (T_boil, 1e5 Pa).
void WideRange::calibrate_boiling() {
  const double T = m_.T_boil;
  const auto boiling = [&](const Hull& h) {  // the widest tie line
    std::size_t best = 0;
    for (std::size_t k = 0; k + 1 < h.rho.size(); ++k)
      if (h.mixed(k) && h.rho[k] * h.rho[best + 1] > h.rho[best] * h.rho[k + 1]) best = k;
    return best;
  };
  double lo = -10 * R_, hi = 10 * R_;
  for (int i = 0; i < 20; ++i) {
    S_gas_ = 0.5 * (lo + hi);
    const Hull h = equilibrium(T);
    (h.pressure(boiling(h)) < atmosphere ? lo : hi) = S_gas_;
  }
  e_rest_ = 0;
  e_rest_ = phase(m_.rho_0, T_rest, true).e;
  const Hull h = equilibrium(T);
  const std::size_t k = boiling(h);
  phases_ = {phase(density_at_rest(m_.T_melt, true), m_.T_melt, true).e, phase(density_at_rest(m_.T_melt, false), m_.T_melt, false).e,
             phase(h.rho[k], T, false).e, phase(h.rho[k + 1], T, false).e};
}

SesameMaterial WideRange::table() const {
  SesameMaterial out;
  out.number = m_.number, out.Z = m_.Z, out.A = m_.A, out.rho_0 = m_.rho_0;
  out.bulk_modulus = m_.rho_0 * m_.c_0 * m_.c_0;
  SesameGrid g;
  for (double eta = table_rho_min; eta < 0.5; eta *= 1.15) g.rho.push_back(eta * m_.rho_0);
  for (double eta = 0.5; eta < 1.7 - 1e-9; eta += 0.0125) g.rho.push_back(eta * m_.rho_0);
  for (double eta = 1.7; eta < table_rho_max; eta *= 1.02) g.rho.push_back(eta * m_.rho_0);
  g.rho.push_back(table_rho_max * m_.rho_0);
  for (const double T : {20.0, 50.0, 100.0, 150.0, 200.0, 250.0, T_rest}) g.T.push_back(T);
  for (double T = 350; T < 1200; T += 50) g.T.push_back(T);
  for (double T = 1200; T < 1.05e6; T *= 1.06) g.T.push_back(T);
  const std::size_t n = g.rho.size();
  g.p.resize(n * g.T.size()), g.e = g.f = g.p;
  struct Bounds {
    double rho_liquid = 0, rho_vapour = 0, p = 0;
  };
  std::vector<Bounds> dome(g.T.size());
  core::for_each_block(g.T.size(), 1, [&](std::size_t k, std::size_t) {
    const double T = g.T[k];
    const Hull h = equilibrium(T);
    for (std::size_t s = 0; s + 1 < h.rho.size(); ++s)
      if (h.mixed(s) && h.rho[s] > 1.3 * h.rho[s + 1]) dome[k] = {h.rho[s], h.rho[s + 1], h.pressure(s)};
    for (std::size_t i = 0; i < n; ++i) {
      const double rho = g.rho[i];
      const bool solid = T < melting_temperature(rho);
      const std::size_t s = h.segment(rho), at = k * n + i;
      const bool stretched = solid && rho >= max_stretch * m_.rho_0 && rho < m_.rho_0;
      if (!h.mixed(s) || (stretched && rho <= h.rho[s] && h.rho[s] > 1.3 * h.rho[s + 1])) {
        const Value v = phase(rho, T, solid);
        g.p[at] = v.p, g.e[at] = v.e, g.f[at] = v.f;
        continue;
      }
      const auto end = [&](std::size_t q) { return phase(h.rho[q], T, T < melting_temperature(h.rho[q])).e; };
      const double v0 = 1 / h.rho[s], v1 = 1 / h.rho[s + 1], share = (1 / rho - v0) / (v1 - v0);
      g.p[at] = h.pressure(s);
      g.e[at] = (1 - share) * end(s) + share * end(s + 1);
      g.f[at] = (1 - share) * h.f[s] + share * h.f[s + 1];
    }
  });
  for (double& f : g.f) f -= e_rest_;  // e = F + T S holds with the zero of e
  SesameVapour v;
  for (std::size_t k = 0; k < g.T.size(); ++k) {
    const Bounds& b = dome[k];
    if (!(b.rho_vapour > 1e-30) || g.T[k] < m_.T_melt) continue;
    const Value l = phase(b.rho_liquid, g.T[k], false), gas = phase(b.rho_vapour, g.T[k], false);
    v.T.push_back(g.T[k]), v.p.push_back(b.p), v.rho_liquid.push_back(b.rho_liquid), v.rho_vapour.push_back(b.rho_vapour);
    v.e_liquid.push_back(l.e), v.e_vapour.push_back(gas.e), v.f_liquid.push_back(l.f - e_rest_), v.f_vapour.push_back(gas.f - e_rest_);
  }
  out.grids[301] = std::move(g);
  out.vapour = std::move(v);
  return out;
}

}  // namespace eos
