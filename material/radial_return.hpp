// SPDX-License-Identifier: Apache-2.0
// The deviatoric stress over one step: rotation, elastic trial, return to the yield surface.
// Rotation: Hughes & Winget, IJNME 15 (1980) 1862, eqs 18-20: s <- Q s Q^T with Q = (1 - W/2)^-1 (1 + W/2), orthogonal for any
// step. Return: Wilkins, Methods in Computational Physics 3 (1964) 211; Simo & Hughes, Computational Inelasticity (1998),
// box 3.1: s = s_trial Y/sigma_trial with the plastic strain increment d from
//   sigma_trial - 3 G d = Y(eps_p + d).
// When G falls to zero (melting) that d has no bound; physically it cannot exceed the strain that the step brings plus the
// elastic strain that the step releases, and this is where d is held.
#pragma once

#include "core/types.hpp"
#include "material/flow.hpp"

namespace material {

/// a : b of two symmetric tensors of six components.
template <class T>
T contract(const T* a, const T* b) {
  using namespace core;
  return a[xx] * b[xx] + a[yy] * b[yy] + a[zz] * b[zz] + T(2.0) * (a[xy] * b[xy] + a[yz] * b[yz] + a[zx] * b[zx]);
}

/// von Mises stress sqrt(3/2 s:s) [Pa].
template <class T>
T effective_stress(const T* s) { return core::sqrt(T(1.5) * contract(s, s)); }

/// Turns s by the rotation increments w [rad], exactly orthogonal, second order in |w|.
template <class T>
void rotate(T* s, const T* w) {
  using namespace core;
  // Q = 1 + k (W + W W/2), W x = w cross x, W W = w w^T - w^2 1
  const T w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  const T k = T(1.0) / (T(1.0) + T(0.25) * w2), h = T(0.5) * k;
  const T xy_ = h * w[0] * w[1], yz_ = h * w[1] * w[2], zx_ = h * w[2] * w[0];
  const T kx = k * w[0], ky = k * w[1], kz = k * w[2];
  const T q[3][3] = {{T(1.0) - h * (w[1] * w[1] + w[2] * w[2]), xy_ - kz, zx_ + ky},
                     {xy_ + kz, T(1.0) - h * (w[2] * w[2] + w[0] * w[0]), yz_ - kx},
                     {zx_ - ky, yz_ + kx, T(1.0) - h * (w[0] * w[0] + w[1] * w[1])}};
  const T full[3][3] = {{s[xx], s[xy], s[zx]}, {s[xy], s[yy], s[yz]}, {s[zx], s[yz], s[zz]}};
  T a[3][3];  // Q s
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[i][j] = q[i][0] * full[0][j] + q[i][1] * full[1][j] + q[i][2] * full[2][j];
  const auto entry = [&](int i, int j) { return a[i][0] * q[j][0] + a[i][1] * q[j][1] + a[i][2] * q[j][2]; };
  s[xx] = entry(0, 0);
  s[yy] = entry(1, 1);
  s[zz] = entry(2, 2);
  s[xy] = entry(0, 1);
  s[yz] = entry(1, 2);
  s[zx] = entry(2, 0);
}

template <class T>
struct Return {
  T increment;  ///< of equivalent plastic strain [-]
  T Y;          ///< flow stress after it [Pa]
};

/// Halley's step towards the root of a gap with slope -s and second derivative -bend; at most twice Newton's.
template <class T>
T halley_step(T gap, T s, T bend) {
  const T s_2 = s * s;
  return gap * (T(2.0) * s) / core::max(T(2.0) * s_2 + gap * bend, s_2);
}

/// Solves sigma_trial - 3 G d = Y(eps_p + d) for d in [0, largest]. Zero where the trial is elastic; `largest` where the
/// solution lies beyond. Halley's method (cubic) from eps_p, which in steady flow is there at once; from zero plastic strain, where the
/// slope is infinite, from the right end; kept in a bracket.
template <class F, class T>
Return<T> plastic_increment(const F& flow, T sigma_trial, T eps_p, T largest) {
  constexpr int max_iterations = 60;
  constexpr double rel_tol = 1e-11;  // of the trial stress
  constexpr double shrink = 0.05;    // of the bracket when a step leaves it to the left
  const Yield<T> before = flow(eps_p);
  const auto plastic = sigma_trial > before.Y;
  if (!core::any(plastic)) return {T(0.0), before.Y};
  const T stiffness = T(3.0) * flow.G, smallest = T(1e-150);
  // hardening only lowers d below the perfectly plastic value
  const T excess = core::max(sigma_trial - before.Y, T(0.0));
  const auto free = excess < largest * stiffness;
  T lo = T(0.0), hi = core::select(free, excess / core::max(stiffness, smallest), largest);
  T d = core::select(free, core::min(halley_step(excess, core::max(stiffness + before.slope, smallest), before.bend), hi), hi);
  Yield<T> now = flow(eps_p + d);
  T gap = sigma_trial - stiffness * d - now.Y;
  const T tol = T(rel_tol) * sigma_trial;
  // a gap left at `largest` means that d is held there
  auto active = plastic & (core::abs(gap) > tol) & (free | (gap < T(0.0)));
  for (int i = 0; i < max_iterations && core::any(active); ++i) {
    lo = core::select(active & (gap > T(0.0)), d, lo);
    hi = core::select(active & (gap < T(0.0)), d, hi);
    const T step = d + halley_step(gap, core::max(stiffness + now.slope, smallest), now.bend);
    T next = core::select(step > lo, step, lo + T(shrink) * (hi - lo));
    next = core::select(next < hi, next, T(0.5) * (lo + hi));
    d = core::select(active, next, d);
    now = flow(eps_p + d);
    gap = sigma_trial - stiffness * d - now.Y;
    active = active & (core::abs(gap) > tol) & (hi - lo > T(1e-15) * hi);
  }
  return {core::select(plastic, d, T(0.0)), core::select(plastic, now.Y, before.Y)};
}

}  // namespace material
