// SPDX-License-Identifier: Apache-2.0
// Mie-Grueneisen equation of state on the principal Hugoniot of a solid, e counted from the reference state.
//
// Shock speed: Us = c_0 + s_1 up + s_2 (up/Us) up + s_3 (up/Us)^2 up (Steinberg, UCRL-MA-106439, 1996, eq. 1), that is,
// with x = up/Us = 1 - rho_0/rho and D = 1 - s_1 x - s_2 x^2 - s_3 x^3:  p_H = rho_0 c_0^2 x / D^2,  e_H = p_H x/(2 rho_0).
// Compression (LS-DYNA Theory Manual, *EOS_GRUNEISEN; the same curve written in mu = rho/rho_0 - 1):
//   p = p_H (1 - (gamma_0 + a mu) x/2) + (gamma_0 + a mu) rho_0 e,    rho gamma = rho_0 (gamma_0 + a mu).
// Expansion: the reference is a cold curve, p_c = rho_0 c_0^2 mu eta^2, e_c = c_0^2 mu^2/2, eta = rho/rho_0, and
//   p = p_c + rho gamma (e - e_c),  gamma = gamma_0 + (a - gamma_0) mu + k mu^2 with k such that gamma = min(2/3, gamma_0)
// at zero density. To first order this is the usual p = rho_0 c_0^2 mu + (gamma_0 + a mu) rho_0 e; pressure and sound speed
// are continuous at rho_0. Unlike the usual form, tension does not grow to rho_0 c_0^2 as matter thins out: it peaks at
// 4/27 rho_0 c_0^2 (11.7 GPa in aluminium, near the ideal strength), the work to separate all matter is c_0^2/2 (14 MJ/kg in
// aluminium, near the heat of sublimation, 12 MJ/kg), and hotter vapour is an ideal gas of monatomic molecules.
// Temperature: eos/reference_isentrope.hpp, no latent heats.
//
// Range: compression up to x_guard, 90 % of the way to the pole D = 0 or to the limit (gamma_0 + a mu) x = 2 of shock
// compression; beyond it the pressure goes on along the tangent of p_H, so it stays finite and rises.
#pragma once

#include <cassert>

#include "core/lane_math.hpp"
#include "eos/reference_isentrope.hpp"
#include "eos/state.hpp"

namespace eos {

struct MieGrueneisen {
  double rho_0 = 0;                  ///< reference density, p = 0 at T_0 [kg/m3], > 0
  double c_0 = 0;                    ///< bulk sound speed, intercept of Us(up) [m/s], > 0
  double s_1 = 0, s_2 = 0, s_3 = 0;  ///< slopes of Us(up), see above [-]
  double gamma_0 = 0;                ///< Grueneisen coefficient at rho_0 [-]
  double a = 0;                      ///< first-order volume correction: gamma = (gamma_0 + a mu)/(1 + mu) [-]
  double cv = 0;                     ///< specific heat [J/(kg K)], > 0
  double T_0 = 294;                  ///< temperature of the reference state [K]

  // Derived by prepare() from the parameters above.
  double x_pole = 0;                 ///< smallest root of D, 1 if there is none below 1 [-]
  double x_guard = 0;                ///< end of the range, see above [-]
  double gamma_2 = 0;                ///< k of the expansion [-]
  IsentropeFit isentrope = {};       ///< e_s D^2 [J/kg]
};

/// Fills in the derived fields; to be called once, after the last change of a parameter.
void prepare(MieGrueneisen& m);

namespace detail {
template <class T>
struct PressureSlopes {
  T p;        ///< [Pa]
  T dp_drho;  ///< at constant e
  T dp_de;    ///< at constant rho
};

template <class T>
PressureSlopes<T> compressed(const MieGrueneisen& m, T x, T rho, T e) {
  const T xg = core::min(core::max(x, T(0.0)), T(m.x_guard));
  const auto inside = x < T(m.x_guard);
  const T D = T(1.0) - xg * (T(m.s_1) + xg * (T(m.s_2) + xg * T(m.s_3)));
  const T dD = -(T(m.s_1) + xg * (T(2.0 * m.s_2) + xg * T(3.0 * m.s_3)));
  const T stiffness = T(m.rho_0 * m.c_0 * m.c_0) / (D * D);
  const T p_H = stiffness * xg;
  const T dp_H = stiffness * (T(1.0) - T(2.0) * xg * dD / D);
  const T eta = T(1.0) / (T(1.0) - xg);
  const T g = T(m.gamma_0) + T(m.a) * (eta - T(1.0));  // rho gamma / rho_0
  const T dg = T(m.a) * eta * eta;
  const T half = T(1.0) - T(0.5) * g * xg;
  const T slope = dp_H * half - T(0.5) * p_H * (g + xg * dg) + dg * T(m.rho_0) * e;
  const T p = p_H * half + g * T(m.rho_0) * e + dp_H * (core::max(x, xg) - xg);
  return {p, core::select(inside, slope, dp_H) * T(m.rho_0) / (rho * rho), g * T(m.rho_0)};
}

template <class T>
PressureSlopes<T> expanded(const MieGrueneisen& m, T mu, T e) {
  const T y = core::min(mu, T(0.0));
  const T eta = T(1.0) + y;
  const T gamma = T(m.gamma_0) + y * (T(m.a - m.gamma_0) + y * T(m.gamma_2));
  const T dgamma = T(m.a - m.gamma_0) + y * T(2.0 * m.gamma_2);
  const T k = T(m.c_0 * m.c_0);
  const T thermal = e - T(0.5) * k * y * y;
  const T p = T(m.rho_0) * eta * (k * y * eta + gamma * thermal);
  const T dp = k * eta * (eta + T(2.0) * y) + (gamma + eta * dgamma) * thermal - eta * gamma * k * y;
  return {p, dp, T(m.rho_0) * eta * gamma};
}

/// Expansion that the condensed part is credited with: what heat drives it to at zero pressure (from p = 0 with gamma =
/// gamma_0), a half at most, or max_condensed_expansion where that is more. Keeps T rising with e on release.
template <class T>
T condensed_expansion(const MieGrueneisen& m, T mu, T e) {
  const T h = core::max(e, T(0.0)) * T(m.gamma_0 / (m.c_0 * m.c_0));
  const T root = core::sqrt(core::max(T(1.0) - T(4.0 * (1.0 - 0.5 * m.gamma_0)) * h, T(0.0)));
  const T released = core::min(T(2.0) * h / (T(1.0) + root), T(0.5));
  return core::min(core::max(-mu, T(0.0)), core::max(released, T(max_condensed_expansion)));
}

template <class T>
struct Reference {
  T e, temperature;
};

/// The reference isentrope at x in compression, at the expansion u >= 0 elsewhere (one of them is 0).
template <class T>
Reference<T> reference(const MieGrueneisen& m, T x, T u) {
  const T xg = core::min(core::max(x, T(0.0)), T(m.x_guard));
  const auto squeezed = xg > T(0.0);
  const T eta = core::select(squeezed, T(1.0) / (T(1.0) - xg), T(1.0) - u);
  const T log_eta = core::log(eta);
  // ln(T_s/T_0) is the integral of gamma/eta
  const T in_compression = T(m.gamma_0 - m.a) * xg + T(m.a) * log_eta;
  const double b_1 = m.a - m.gamma_0 - 2.0 * m.gamma_2;
  const double gamma_vapour = m.gamma_0 - (m.a - m.gamma_0) + m.gamma_2;
  const T in_expansion =
      T(gamma_vapour) * log_eta - T(b_1) * u + T(0.5 * m.gamma_2) * (eta * eta - T(1.0));
  const T D = T(1.0) - xg * (T(m.s_1) + xg * (T(m.s_2) + xg * T(m.s_3)));
  const T e_s = core::select(squeezed, m.isentrope(xg) / (D * D), T(0.5 * m.c_0 * m.c_0) * u * u);
  return {e_s, T(m.T_0) * core::exp(core::select(squeezed, in_compression, in_expansion))};
}
}  // namespace detail

/// rho [kg/m3] > 0, e [J/kg] from the reference state.
template <class T>
State<T> state(const MieGrueneisen& m, T rho, T e) {
  assert(m.x_guard > 0 && "prepare() was not called");
  const T x = T(1.0) - T(m.rho_0) / rho;
  const T mu = rho / T(m.rho_0) - T(1.0);
  const auto squeezed = x > T(0.0);
  const detail::PressureSlopes<T> in = detail::compressed(m, x, rho, e);
  const detail::PressureSlopes<T> out = detail::expanded(m, mu, e);
  const T p = core::select(squeezed, in.p, out.p);
  const T c2 = core::select(squeezed, in.dp_drho, out.dp_drho) +
               p * core::select(squeezed, in.dp_de, out.dp_de) / (rho * rho);
  const detail::Reference<T> ref = detail::reference(m, x, detail::condensed_expansion(m, mu, e));
  constexpr double floor = min_sound_speed_ratio * min_sound_speed_ratio;
  return {p, core::max(c2, T(floor * m.c_0 * m.c_0)),
          core::max(ref.temperature + (e - ref.e) / T(m.cv), T(0.0))};
}

/// Energy at absolute zero [J/kg]: e_s - cv T_s.
double cold_energy(const MieGrueneisen& m, double rho);

/// Density of the pole of the Hugoniot, where Us becomes infinite [kg/m3].
inline double max_density(const MieGrueneisen& m) { return m.x_pole < 1 ? m.rho_0 / (1 - m.x_pole) : 1e300; }

}  // namespace eos
