// SPDX-License-Identifier: Apache-2.0
// Tillotson, General Atomic report GA-3216 (1962); regions as in Melosh, Impact Cratering (1989), appendix II.
// eta = rho/rho_0, mu = eta - 1, w = e/(E_0 eta^2) + 1:
//   1 compressed, or expanded with e <= E_iv:   p_1 = (a + b/w) rho e + A mu + B mu^2
//   2 expanded, e >= E_cv:   p_2 = a rho e + [b rho e/w + A mu exp(-beta (1/eta - 1))] exp(-alpha (1/eta - 1)^2)
//   3 expanded, E_iv < e < E_cv:   p = [(e - E_iv) p_2 + (E_cv - e) p_1]/(E_cv - E_iv)
// As published p_1 pulls with up to A^2/4B however thin cold matter is. Here it fades out smoothly between fade_begin and
// fade_end of rho_0, far beyond any spall strength, and it does so as a whole: were it only for the cold part, liquid that has parted
// into drops would push like a gas of gamma a + b and give up its heat. A negative energy counts in the thermal terms with
// b/w = b. Temperature: eos/reference_isentrope.hpp, up to four times rho_0 and held from there on.
#pragma once

#include <cassert>

#include "core/lane_math.hpp"
#include "eos/reference_isentrope.hpp"
#include "eos/state.hpp"

namespace eos {

struct Tillotson {
  double rho_0 = 0;              ///< [kg/m3], > 0
  double a = 0, b = 0;           ///< a + b is gamma at rho_0, a + 1 the ratio of specific heats of the hot vapour [-]
  double A = 0, B = 0;           ///< bulk modulus and its growth [Pa]
  double alpha = 0, beta = 0;    ///< decay of the solid's terms in expansion [-]
  double E_0 = 0;                ///< energy scale of b's decline [J/kg]
  double E_iv = 0, E_cv = 0;     ///< incipient and complete vaporisation [J/kg]
  double cv = 0, T_0 = 294;      ///< [J/(kg K)] > 0, [K]

  ReferenceIsentrope isentrope = {};  ///< derived by prepare()
};

constexpr double tillotson_fade_begin = 0.8, tillotson_fade_end = 0.5;  ///< [rho/rho_0]

/// Fills in the derived fields; to be called once, after the last change of a parameter.
void prepare(Tillotson& m);

namespace detail {
template <class T>
struct TillotsonBranch {
  T p, dp_drho, dp_de;
};

template <class T>
TillotsonBranch<T> condensed(const Tillotson& m, T rho, T e) {
  const T eta = rho / T(m.rho_0), mu = eta - T(1.0);
  const T hot = core::max(e, T(0.0));
  const T w = hot / (T(m.E_0) * eta * eta) + T(1.0);
  const T gamma = T(m.a) + T(m.b) / w;
  // smooth step, 0 at fade_end, 1 from fade_begin on
  constexpr double width = tillotson_fade_begin - tillotson_fade_end;
  const T t = core::min(core::max((eta - T(tillotson_fade_end)) / T(width), T(0.0)), T(1.0));
  const T fade = t * t * (T(3.0) - T(2.0) * t), dfade = T(6.0 / width) * t * (T(1.0) - t);
  const T cold = mu * (T(m.A) + T(m.B) * mu), dcold = T(m.A) + T(2.0 * m.B) * mu;
  // d(1/w)/de = -(w - 1)/(e w^2), d(1/w)/drho = 2 (w - 1)/(rho w^2)
  const T excess = T(m.b) * (w - T(1.0)) / (w * w);
  const T p = gamma * rho * e + cold;
  const T dp_drho = dcold / T(m.rho_0) + gamma * e + T(2.0) * excess * hot;
  return {p * fade, dp_drho * fade + p * dfade / T(m.rho_0), rho * (gamma - excess) * fade};
}

template <class T>
TillotsonBranch<T> vapour(const Tillotson& m, T rho, T e) {
  const T eta = core::min(rho / T(m.rho_0), T(1.0)), mu = eta - T(1.0);
  const T hot = core::max(e, T(0.0));
  const T w = hot / (T(m.E_0) * eta * eta) + T(1.0);
  const T y = T(1.0) / eta - T(1.0);
  const T decay = core::exp(-(T(m.alpha) * y * y)), cold_decay = core::exp(-(T(m.beta) * y)) * decay;
  const T excess = T(m.b) * (w - T(1.0)) / (w * w);
  const T solid = T(m.b) * rho * e / w;
  const T dy = -(T(1.0) / (eta * eta * T(m.rho_0)));  // dy/drho
  const T cold = T(m.A) * mu * cold_decay;
  const T p = T(m.a) * rho * e + solid * decay + cold;
  const T dp_drho = T(m.a) * e + (T(m.b) * e / w + T(2.0) * excess * hot) * decay -
                    solid * decay * T(2.0 * m.alpha) * y * dy + T(m.A / m.rho_0) * cold_decay -
                    cold * (T(m.beta) + T(2.0 * m.alpha) * y) * dy;
  return {p, dp_drho, rho * (T(m.a) + (T(m.b) / w - excess) * decay)};
}
}  // namespace detail

/// rho [kg/m3] > 0, e [J/kg].
template <class T>
State<T> state(const Tillotson& m, T rho, T e) {
  assert(m.isentrope.energy.x_max > 0 && "prepare() was not called");
  const detail::TillotsonBranch<T> one = detail::condensed(m, rho, e), two = detail::vapour(m, rho, e);
  // share of region 2: 0 in region 1, 1 in region 2, between them in region 3
  const double span = m.E_cv - m.E_iv;
  const auto thin = rho < T(m.rho_0);
  const auto mixed = thin & (e > T(m.E_iv)) & (e < T(m.E_cv));
  const T share =
      core::select(thin, core::min(core::max((e - T(m.E_iv)) / T(span), T(0.0)), T(1.0)), T(0.0));
  const T rest = T(1.0) - share;
  const T p = share * two.p + rest * one.p;
  const T dp_drho = share * two.dp_drho + rest * one.dp_drho;
  const T dp_de = share * two.dp_de + rest * one.dp_de + core::select(mixed, (two.p - one.p) / T(span), T(0.0));
  const T c2 = dp_drho + p * dp_de / (rho * rho);
  const T x = core::min(core::max(T(1.0) - T(m.rho_0) / rho, T(m.isentrope.energy.x_min)),
                        T(m.isentrope.energy.x_max));
  const T temperature = T(m.T_0) * core::exp(m.isentrope.heating(x)) + (e - m.isentrope.energy(x)) / T(m.cv);
  constexpr double floor = min_sound_speed_ratio * min_sound_speed_ratio;
  return {p, core::max(c2, T(floor * m.A / m.rho_0)), core::max(temperature, T(0.0))};
}

/// Energy at absolute zero [J/kg]: e_s - cv T_s.
double cold_energy(const Tillotson& m, double rho);

}  // namespace eos
