// SPDX-License-Identifier: Apache-2.0
#include "eos/sesame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.hpp"
#include "eos/monotone_cubic.hpp"

namespace eos {

namespace {

constexpr int n_columns = 768;

double to_u(double eta) {
  const double y = std::log(eta);
  return y / (1 + std::abs(y));
}
double from_u(double u) { return std::exp(u / (1 - std::abs(u))); }

/// Places of the values that rise; tables repeat a value where they change spacing, and some begin at zero density.
std::vector<std::size_t> rising(const std::vector<double>& a, double above) {
  std::vector<std::size_t> keep;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] > above && (keep.empty() || a[i] > a[keep.back()] * (1 + 1e-9))) keep.push_back(i);
  return keep;
}

/// p, e of every isotherm at one density.
struct Column {
  std::vector<double> p, e;
};

/// The file's isotherms as functions of density.
class Isotherms {
 public:
  Isotherms(const SesameGrid& g, const std::vector<std::size_t>& densities, const std::vector<std::size_t>& temperatures) {
    std::vector<double> rho, p(densities.size()), e(densities.size());
    for (const std::size_t i : densities) rho.push_back(g.rho[i]);
    for (const std::size_t k : temperatures) {
      for (std::size_t i = 0; i < densities.size(); ++i) {
        p[i] = g.p[k * g.rho.size() + densities[i]];
        e[i] = g.e[k * g.rho.size() + densities[i]];
      }
      p_.emplace_back(rho, p), e_.emplace_back(rho, e);
    }
  }
  Column operator()(double rho) const {
    Column c;
    for (std::size_t k = 0; k < p_.size(); ++k) c.p.push_back(p_[k](rho)), c.e.push_back(e_[k](rho));
    return c;
  }

 private:
  std::vector<MonotoneCubic> p_, e_;
};

double cold_of(const SesameTable& t, double rho) {
  const auto at = detail::place(t, std::clamp(rho, t.rho_min, t.rho_max));
  const double* b = t.base.data() + static_cast<std::size_t>(at.column) * SesameTable::n_base;
  return detail::hermite(at.a, b[0], b[3], b[1], b[4]).value;
}

/// On the coldest isotherm energy rises by the integral of (p - T dp/dT)/rho^2: told apart from it are pressures in Mbar or
/// TPa and energies in J/kg, which nothing in a file says.
void check_units(const Isotherms& isotherms, const std::vector<double>& T, double rho_n, const std::string& name) {
  constexpr int n = 32;
  constexpr double squeezed = 1.5;
  double work = 0, heat = 0, e[2] = {0, 0};
  for (int i = 0; i <= n; ++i) {  // Simpson
    const double rho = rho_n * (1 + (squeezed - 1) * i / n);
    const Column c = isotherms(rho);
    const double weight = (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * (squeezed - 1) * rho_n / (3 * n) / (rho * rho);
    work += weight * c.p[0], heat += weight * T[0] * (c.p[1] - c.p[0]) / (T[1] - T[0]);
    if (i % n == 0) e[i / n] = c.e[0];
  }
  if (std::abs(e[1] - e[0] - (work - heat)) > 0.5 * (std::abs(work) + std::abs(heat)))
    throw core::CaseError(name + ": pressures and energies do not belong together: from 1 to 1.5 times the normal density at " + std::to_string(T[0]) +
                          " K energy rises by " + std::to_string((e[1] - e[0]) * 1e-6) + " MJ/kg, the work of the pressure is " +
                          std::to_string((work - heat) * 1e-6) + " MJ/kg; valid: GPa, MJ/kg, g/cm3, K");
}

struct Rest {
  double rho, e;
};

/// The condensed state at T_0 without pressure: downwards from the normal density to where p falls to zero.
Rest find_rest(const SesameTable& t, double T_0, const std::string& name) {
  if (T_0 < t.source_T.front() || T_0 > t.source_T.back())
    throw core::CaseError(name + ": has isotherms from " + std::to_string(t.source_T.front()) + " to " + std::to_string(t.source_T.back()) +
                          " K; T_0 = " + std::to_string(T_0) + " K, of the material at rest, must be among them");
  const auto energy = [&](double rho) {  // T rises with e
    double lo = cold_of(t, rho), hi = 1e12;
    for (int i = 0; i < 200; ++i) {
      const double mid = 0.5 * (lo + hi);
      (detail::table_state(t, rho, mid).temperature < T_0 ? lo : hi) = mid;
    }
    return hi;
  };
  const auto pressure = [&](double rho) { return detail::table_state(t, rho, energy(rho)).p; };
  for (const double zero : {0.0, 1.1e5}) {  // the second a little above what tables have on their plateau
    double hi = t.rho_n * 1.25;
    double lo = hi;
    while (lo > 0.7 * t.rho_n && pressure(lo) > zero) hi = lo, lo *= 0.99;
    if (lo <= 0.7 * t.rho_n || lo == hi) continue;
    for (int i = 0; i < 100; ++i) {
      const double mid = 0.5 * (lo + hi);
      (pressure(mid) > zero ? hi : lo) = mid;
    }
    return {hi, energy(hi)};
  }
  throw core::CaseError(name + ": no state without pressure at " + std::to_string(T_0) + " K between 0.7 and 1.25 times the normal density " +
                        std::to_string(t.rho_n) + " kg/m3; valid: a T_0 within the table, " + std::to_string(t.source_T.front()) +
                        " to " + std::to_string(t.source_T.back()) + " K, at which the material is condensed");
}

double hottest(const SesameTable& t, double rho) {
  const auto at = detail::place(t, std::clamp(rho, t.rho_min, t.rho_max));
  const double* b = t.base.data() + static_cast<std::size_t>(at.column) * SesameTable::n_base;
  return std::min(b[2], b[5]);
}

}  // namespace

SesameTable invert(const SesameGrid& g, double rho_n, const std::string& name) {
  const auto densities = rising(g.rho, 0), temperatures = rising(g.T, -1);
  if (densities.size() < 4 || temperatures.size() < 4)
    throw core::CaseError(name + ": has " + std::to_string(densities.size()) + " densities and " + std::to_string(temperatures.size()) +
                          " temperatures; 4 of each are needed at least");
  SesameTable t;
  t.rho_n = rho_n, t.rho_min = g.rho[densities.front()], t.rho_max = g.rho[densities.back()];
  if (!(t.rho_min < 0.5 * rho_n && t.rho_max > 1.5 * rho_n))
    throw core::CaseError(name + ": covers " + std::to_string(t.rho_min) + " to " + std::to_string(t.rho_max) +
                          " kg/m3; 0.5 to 1.5 times the normal density " + std::to_string(rho_n) + " kg/m3 is needed at least");
  for (const auto k : temperatures) t.source_T.push_back(g.T[k]);
  t.columns = n_columns;
  t.u_min = to_u(t.rho_min / rho_n);
  t.du = (to_u(t.rho_max / rho_n) - t.u_min) / (n_columns - 1);
  const Isotherms isotherms(g, densities, temperatures);
  check_units(isotherms, t.source_T, rho_n, name);

  std::vector<Column> all;
  std::vector<double> u, cold;
  double h_top = 0;
  for (int i = 0; i < n_columns; ++i) {
    u.push_back(i);
    const double rho = std::clamp(rho_n * from_u(t.u_min + t.du * i), t.rho_min, t.rho_max);
    all.push_back(isotherms(rho));
    cold.push_back(all.back().e.front());
    h_top = std::max(h_top, all.back().e.back() - cold.back());
  }
  // the thermal energy at the normal density and 300 K sets where rows begin to spread
  const MonotoneCubic warming(t.source_T, isotherms(rho_n).e);
  t.h_0 = std::max(warming(300) - warming(t.source_T.front()), 1e-6 * h_top);
  if (!(h_top > 0)) throw core::CaseError(name + ": energy does not rise with temperature");
  t.rows = 2 + static_cast<int>(std::ceil((1 << SesameTable::bits_per_doubling) * (1 + std::log2(1 + h_top / t.h_0))));

  const auto n = static_cast<std::size_t>(n_columns);
  t.base.resize((n + 1) * SesameTable::n_base);
  t.node.resize(static_cast<std::size_t>(t.rows) * n * SesameTable::n_node);
  const auto slopes = monotone_slopes(u, cold);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> h, p, T;
    for (std::size_t k = 0; k < t.source_T.size(); ++k) {
      const double above = all[i].e[k] - cold[i];
      if (!h.empty() && !(above > h.back() + 1e-9 * t.h_0)) continue;  // a cold plateau; rounding of the file
      h.push_back(above), p.push_back(all[i].p[k]), T.push_back(t.source_T[k]);
    }
    if (h.size() < 2) throw core::CaseError(name + ": energy does not rise with temperature at " + std::to_string(rho_n * from_u(t.u_min + t.du * static_cast<double>(i))) + " kg/m3");
    const MonotoneCubic pressure(h, p), temperature(h, T);
    t.base[i * SesameTable::n_base] = cold[i], t.base[i * SesameTable::n_base + 1] = slopes[i], t.base[i * SesameTable::n_base + 2] = h.back();
    for (int j = 0; j < t.rows; ++j) {
      constexpr std::int64_t one = std::int64_t{1023} << SesameTable::bits_per_doubling;
      const double x = core::from_bits((j + one) << SesameTable::shift, 0.0);
      double* node = t.node.data() + (static_cast<std::size_t>(j) * n + i) * SesameTable::n_node;
      node[0] = pressure((x - 1) * t.h_0), node[2] = temperature((x - 1) * t.h_0);
    }
  }
  std::vector<double> row(n);
  for (int j = 0; j < t.rows; ++j) {
    double* nodes = t.node.data() + static_cast<std::size_t>(j) * n * SesameTable::n_node;
    for (std::size_t i = 0; i < n; ++i) row[i] = nodes[i * SesameTable::n_node];
    const auto s = monotone_slopes(u, row);
    for (std::size_t i = 0; i < n; ++i) nodes[i * SesameTable::n_node + 1] = s[i];
  }
  return t;
}

void prepare(Sesame& m) {
  const std::string name = m.file + ": material " + std::to_string(m.number);
  if (!m.table) {
    const SesameMaterial source = read_sesame(m.file, m.number);
    m.table = std::make_shared<const SesameTable>(invert(total(source, m.file), source.rho_0, name));
  }
  const Rest rest = find_rest(*m.table, m.T_0, name);
  if (!(m.rho_0 > 0)) m.rho_0 = rest.rho;
  m.scale = rest.rho / m.rho_0;
  if (std::abs(m.scale - 1) > max_density_scaling)
    throw core::CaseError(name + ": is at rest at " + std::to_string(rest.rho) + " kg/m3, the material at " + std::to_string(m.rho_0) +
                          " kg/m3; they may differ by " + std::to_string(100 * max_density_scaling) + " % at most");
  m.e_ref = rest.e;
  m.p_ref = detail::table_state(*m.table, m.rho_0 * m.scale, m.e_ref).p;
  m.c2_ref = detail::table_state(*m.table, rest.rho, rest.e).c2 * m.scale;
  if (!(m.c2_ref > 0)) throw core::CaseError(name + ": has no positive sound speed at rest");
}

double cold_energy(const Sesame& m, double rho) {
  // two-phase matter below the tension that a table allows lies lower than its stretched neighbours
  const double condensed = std::max(rho, m.rho_0 * (1 - max_condensed_expansion)) * m.scale;
  return (std::min(cold_of(*m.table, condensed), cold_of(*m.table, rho * m.scale)) - m.e_ref) * m.scale;
}

bool inside(const Sesame& m, double rho, double e) {
  const double dense = rho * m.scale, h = e / m.scale + m.e_ref - cold_of(*m.table, dense);
  if (!(dense >= m.table->rho_min && dense <= m.table->rho_max && h <= hottest(*m.table, dense))) return false;
  // round-off in cold matter is no departure
  return h > -1e-3 * m.table->h_0 || rho < m.rho_0;
}

std::string range_text(const Sesame& m, double rho) {
  const double dense = std::clamp(rho * m.scale, m.table->rho_min, m.table->rho_max);
  const double cold = (cold_of(*m.table, dense) - m.e_ref) * m.scale;
  char text[160];
  std::snprintf(text, sizeof text, "rho %.4g to %.4g kg/m3, e %.4g to %.4g MJ/kg at this density", m.table->rho_min / m.scale,
                m.table->rho_max / m.scale, cold * 1e-6, cold * 1e-6 + hottest(*m.table, dense) * m.scale * 1e-6);
  return text;
}

}  // namespace eos
