// SPDX-License-Identifier: Apache-2.0
// THE point update, shared by elements and particles: brings a material point from step n to n+1.
//
// Time levels. Positions, density and stress live at n and n+1, velocities and the compatible energy at half steps. On entry
// e holds the work that the forces of n have done up to n+1/2; it is not touched here. The equation of state at n+1 needs
// the energy at n+1, estimated from half the step's work with the stress of n (the predictor of Wilkins, 1964, without
// its corrector: the energy that is booked is the compatible one, so an error here does not accumulate):
//   e_est = e + [-(p + q) tr d + s:d] / (2 rho_mid),   rho_mid = (rho + rho_new)/2
// Then p, c, T; strength by radial return (material/radial_return.hpp); failure:
//   damage    grows by d(eps_p)/eps_f; at 1 the point fails;
//   spall     a point bears the tension spall (1 - damage), and what is pulled further tears (tear, below).
// A failed point is powder: s = 0 and p >= 0 from then on, plastic strain and damage stay as they are. Nor is there tension as long as
// the energy lies below the cold curve, where no matter is: the lower it fell the harder it would pull, and pay for it with what it has not got.
// Strain rate: the step's equivalent deviatoric strain sqrt(2/3 d':d') over dt (elastic part included, which is negligible once matter flows).
#pragma once

#include <algorithm>
#include <type_traits>

#include "material/johnson_cook.hpp"
#include "material/johnson_cook_damage.hpp"
#include "material/radial_return.hpp"
#include "material/steinberg_guinan.hpp"
#include "material/zerilli_armstrong.hpp"

namespace material {

/// One point (T = double) or lanes of points (T = core::Pack) in registers; fields as in core::Points.
template <class T>
struct Point {
  T m;  ///< mass that the point stands for [kg]: the size that tears
  T rho, e, p, c, temperature;
  T s[6];  ///< xx yy zz xy yz zx
  T eps_p, damage;
};

/// What the motion does to a point over a step.
template <class T>
struct Increment {
  T d[6];  ///< strain increment D dt, tensor shear components [-]
  T w[3];  ///< rotation increment, half curl(v) dt [rad]
};

/// Shear modulus in the reference state [Pa].
inline double shear_modulus_of(const PerfectlyPlastic& s) { return s.G; }
inline double shear_modulus_of(const JohnsonCook& s) { return s.G; }
inline double shear_modulus_of(const SteinbergGuinan& s) { return s.G_0; }
inline double shear_modulus_of(const ZerilliArmstrong& s) { return s.G; }

/// Strength and damage over the step at the new state `at`; fails what has reached the end.
template <class Law, class T>
void update_strength(const Material& m, const Law& law, double dt, FlowState<T> at, const Increment<T>& inc,
                     Point<T>& pt) {
  using core::select;
  rotate(pt.s, inc.w);
  const T third = (inc.d[core::xx] + inc.d[core::yy] + inc.d[core::zz]) * T(1.0 / 3.0);
  T dev[6];
  for (int i = 0; i < 6; ++i) dev[i] = i < 3 ? inc.d[i] - third : inc.d[i];
  const T strain = core::sqrt(T(2.0 / 3.0) * contract(dev, dev));
  at.rate = strain / T(dt);

  const auto law_now = flow(law, at);
  const auto whole = pt.damage < T(1.0);
  const T G = select(whole, law_now.G, T(0.0));
  const T sigma_old = effective_stress(pt.s);
  for (int i = 0; i < 6; ++i) pt.s[i] = select(whole, pt.s[i] + T(2.0) * G * dev[i], T(0.0));
  const T sigma_trial = effective_stress(pt.s);

  const T largest = strain + sigma_old / T(3.0 * shear_modulus_of(law));
  const Return<T> back = plastic_increment(law_now, sigma_trial, pt.eps_p, largest);
  const T increment = select(whole, back.increment, T(0.0));
  const auto outside = sigma_trial > back.Y;
  const T scale = select(outside, back.Y / core::max(sigma_trial, T(1e-300)), T(1.0));
  pt.eps_p += increment;
  if (m.damage && core::any(increment > T(0.0))) {
    const T eps_f = fracture_strain(*m.damage, pt.p, scale * sigma_trial, at.rate, at.temperature);
    pt.damage = core::min(pt.damage + increment / eps_f, T(1.0));
  }
  const auto carries = pt.damage < T(1.0);
  for (int i = 0; i < 6; ++i) pt.s[i] = select(carries, scale * pt.s[i], T(0.0));
  pt.c = core::sqrt(pt.c * pt.c + select(carries, G, T(0.0)) * T(4.0 / 3.0) / pt.rho);
}

/// Spall as a crack band (Hillerborg, Modeer & Petersson, Cem. Concr. Res. 6 (1976) 773; Bazant & Oh, Mater. Struct. 16 (1983)
/// 155): one plane of crack opens through a point of edge L, reference size, and the tension across it falls linearly,
///   p >= -spall (1 - D),   dD = L tr(d) / opening,   opening = 2 f fracture_energy / spall,
/// so that parting takes f fracture_energy a unit of area whatever L is, and pieces as large as Grady's (J. Mech. Phys. Solids 36
/// (1988) 353) are left whole where the mesh is finer than they are. f is what is solid of the matter, by its energy; a liquid
/// takes its surface energy alone, a ten-thousandth of the solid's, and loses all at once.
template <class T>
void tear(const Material& m, T trace, Point<T>& pt) {
  using core::select;
  const auto torn = pt.p < T(-m.spall) * (T(1.0) - pt.damage);
  if (!core::any(torn)) return;
  T more(1.0);
  if (m.fracture_energy > 0) {
    const T left = (T(m.e_melted) - pt.e) / T(std::max(m.e_melted - m.e_melt, 1e-9 * m.e_melted));  // to melt
    const T solid = core::min(core::max(left, T(1e-4)), T(1.0));
    more = core::max(trace, T(0.0)) * core::cbrt(pt.m / T(m.rho_0)) * T(0.5 * m.spall / m.fracture_energy) / solid;
  }
  pt.damage = select(torn, core::min(pt.damage + more, T(1.0)), pt.damage);
  pt.p = select(torn, core::max(pt.p, T(-m.spall) * (T(1.0) - pt.damage)), pt.p);
}

/// Brings a point from step n to n+1. rho_new is the new density [kg/m3]; q the bulk viscous pressure at n [Pa], which adds
/// to p in the energy estimate only; dt [s] > 0.
template <class T>
void update(const Material& m, double dt, T rho_new, const Increment<T>& inc, T q, Point<T>& pt) {
  using core::select;
  const T trace = inc.d[core::xx] + inc.d[core::yy] + inc.d[core::zz];
  const T work = contract(pt.s, inc.d) - (pt.p + q) * trace;
  const T e_est = pt.e + work / (pt.rho + rho_new);
  const eos::State<T> state = eos::state(m.eos, rho_new, e_est);
  pt.rho = rho_new;
  pt.p = state.p;
  pt.c = core::sqrt(state.c2);
  pt.temperature = state.temperature;
  tear(m, trace, pt);

  std::visit(
      [&](const auto& law) {
        if constexpr (std::is_same_v<std::decay_t<decltype(law)>, NoStrength>) {
          for (T& a : pt.s) a = T(0.0);
        } else {
          update_strength(m, law, dt, FlowState<T>{rho_new / T(m.rho_0), pt.p, pt.temperature, T(0.0)}, inc, pt);
        }
      },
      m.strength);
  const auto bears_tension = (pt.damage < T(1.0)) & (pt.temperature > T(0.0));
  pt.p = select(bears_tension, pt.p, core::max(pt.p, T(0.0)));
}

}  // namespace material
