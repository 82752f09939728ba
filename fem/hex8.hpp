// SPDX-License-Identifier: Apache-2.0
// The one-point hexahedron: pure functions of eight corners, for one element (T = double) or lanes of elements. Corner values
// are taken apart into the modes of the parent cube: of constants, xi eta zeta, and the hourglass modes eta zeta, zeta xi,
// xi eta and xi eta zeta, each +-1 at the corners; in these volume and mean gradient have a third of their terms.
//   volume and mean gradient: Flanagan & Belytschko, Int. J. Numer. Meth. Engng 17 (1981) 679, eqs 15-17:
//     B_jI = integral of dN_I/dx_j over the element (exact), V = x_I B_xI, mean dv_i/dx_j = v_iI B_jI / V
//   hourglass shape vectors: the same, eqs 34-36: gamma_aI = h_aI - B_jI (x_jJ h_aJ) / V
// Corner order: fem/generate.hpp.
#pragma once

#include <initializer_list>

#include "core/pack.hpp"

namespace fem {

/// Coordinates or velocities of eight corners: c[corner][direction].
template <class T>
struct Corners {
  T c[8][3];
};

constexpr int n_linear = 3;      ///< modes xi, eta, zeta
constexpr int n_straining = 6;   ///< those and eta zeta, zeta xi, xi eta: volume and gradient know no other
constexpr int n_modes = 7;       ///< those and xi eta zeta; the constant is left out

/// Sums over corners of a_I times a mode's value there: m[mode][direction].
template <class T>
struct Modes {
  T m[n_modes][3];
};

template <class T>
Modes<T> modes(const Corners<T>& a) {
  Modes<T> r;
  for (int d = 0; d < 3; ++d) {
    T c[2], x[2], y[2], xy[2];
    for (int k = 0; k < 2; ++k) {  // the faces of corners 0-3 and 4-7
      const auto at = [&](int i) { return a.c[4 * k + i][d]; };
      const T sum = at(0) + at(2), other = at(1) + at(3), rise = at(2) - at(0), fall = at(1) - at(3);
      c[k] = sum + other;
      xy[k] = sum - other;
      x[k] = rise + fall;
      y[k] = rise - fall;
    }
    r.m[0][d] = x[0] + x[1];
    r.m[1][d] = y[0] + y[1];
    r.m[2][d] = c[1] - c[0];
    r.m[3][d] = y[1] - y[0];
    r.m[4][d] = x[1] - x[0];
    r.m[5][d] = xy[0] + xy[1];
    r.m[6][d] = xy[1] - xy[0];
  }
  return r;
}

/// Corner values of q[mode] times each mode, in one direction: what modes() does, transposed.
template <class T>
void spread(const T q[n_modes], int direction, T f[8][3]) {
  for (int k = 0; k < 2; ++k) {
    const auto on = [&](T a, T b) { return k == 0 ? a - b : a + b; };
    const T c = k == 0 ? -q[2] : q[2], x = on(q[0], q[4]), y = on(q[1], q[3]), xy = on(q[5], q[6]);
    const T even = c + xy, odd = c - xy, rise = x + y, fall = x - y;
    f[4 * k + 0][direction] = even - rise;
    f[4 * k + 1][direction] = odd + fall;
    f[4 * k + 2][direction] = even + rise;
    f[4 * k + 3][direction] = odd - fall;
  }
}

/// B_jI as sums of modes: B_jI is the corner value of g[mode][j], units of area.
template <class T>
struct Gradient {
  T g[n_straining][3];
};

template <class T>
void cross(const T* a, const T* b, T* out) {
  for (int d = 0; d < 3; ++d) {
    const int y = (d + 1) % 3, z = (d + 2) % 3;
    out[d] = a[y] * b[z] - a[z] * b[y];
  }
}

/// Exact mean gradient operator. With x = a_1 xi + a_2 eta + a_3 zeta + p eta zeta + q zeta xi + r xi eta + ..., det J integrates to
///   V = 8 ([a_1 a_2 a_3] - ([a_1 q r] + [a_2 r p] + [a_3 p q]) / 3),
/// of which B is the derivative; xi eta zeta cancels. The modes hold 8 times those vectors.
template <class T>
Gradient<T> gradient(const Modes<T>& x) {
  Gradient<T> r;
  T h[3][3];  // p, q, r / 3
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d) h[k][d] = T(1.0 / 3.0) * x.m[3 + k][d];
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, n = (k + 2) % 3;
    T a[3], b[3];
    cross(x.m[l], x.m[n], a);
    cross(x.m[3 + l], h[n], b);
    for (int d = 0; d < 3; ++d) r.g[k][d] = T(1.0 / 64) * (a[d] - b[d]);
    cross(h[n], x.m[l], a);
    cross(x.m[n], h[l], b);
    for (int d = 0; d < 3; ++d) r.g[3 + k][d] = T(1.0 / 64) * (a[d] + b[d]);
  }
  return r;
}

/// Volume [m3] from the modes of the corners and their gradient operator.
template <class T>
T volume(const Modes<T>& x, const Gradient<T>& g) {
  T v = x.m[0][0] * g.g[0][0];
  for (int k = 1; k < n_straining; ++k) v += x.m[k][0] * g.g[k][0];
  return v;
}

/// The length [m] that sound crosses in a stable step. An element by itself allows 2 V / sqrt(8 B_jI B_jI): the edge of one
/// that is thin, 1 / sqrt 3 of it in a cube (Flanagan & Belytschko, J. Appl. Mech. 51 (1984) 35; with the trace of B B^T in
/// place of its largest eigenvalue no Poisson's ratio makes it too long). Among others a cube allows its whole edge, of which
/// two thirds are taken. edge: volume over the largest face area [m].
template <class T>
T stable_length(const Gradient<T>& g, T volume, T edge) {
  constexpr double in_a_body = 2.0 / 3;
  T trace(0.0);  // an eighth of B_jI B_jI: modes are orthogonal
  for (const auto& a : g.g) trace += a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  return core::max(T(0.25) * volume / core::sqrt(trace), T(in_a_body) * edge);
}

/// Sum over corners of a_iI B_jI: l[i][j]; divided by the volume it is the mean gradient of a.
template <class T>
void contract(const Modes<T>& a, const Gradient<T>& g, T l[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      T s = a.m[0][i] * g.g[0][j];
      for (int k = 1; k < n_straining; ++k) s += a.m[k][i] * g.g[k][j];
      l[i][j] = s;
    }
}

/// Corners of the six faces, outward by the right-hand rule.
constexpr int face_corner[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Square of the largest face area [m4]: of the face xi = +-1 it is 4 (a_2 +- r) x (a_3 +- q).
template <class T>
T largest_face_area_squared(const Modes<T>& x) {
  T largest(0.0);
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, n = (k + 2) % 3;
    T a[3], b[3], area[3];
    for (const bool upper : {false, true}) {
      for (int d = 0; d < 3; ++d) {
        a[d] = upper ? x.m[l][d] + x.m[3 + n][d] : x.m[l][d] - x.m[3 + n][d];
        b[d] = upper ? x.m[n][d] + x.m[3 + l][d] : x.m[n][d] - x.m[3 + l][d];
      }
      cross(a, b, area);
      largest = core::max(largest, area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    }
  }
  return T(1.0 / 256) * largest;
}

/// Rates of the hourglass modes, sum over corners of gamma_aI v_iI [mode][direction], without the shape vectors gamma
/// themselves: h_a . v_i - (dv_i/dx_j) (h_a . x_j). l: mean velocity gradient on this element.
template <class T>
void hourglass_rates(const Modes<T>& x, const Modes<T>& v, const T l[3][3], T rate[4][3]) {
  for (int a = 0; a < 4; ++a) {
    const T *position = x.m[n_linear + a], *speed = v.m[n_linear + a];
    for (int d = 0; d < 3; ++d) rate[a][d] = speed[d] - (l[d][0] * position[0] + l[d][1] * position[1] + l[d][2] * position[2]);
  }
}

/// The corners that the four edges along each parent direction join, in the order of the other two coordinates, lower
/// direction first: along xi (eta, zeta) = (-, -), (+, -), (-, +), (+, +).
constexpr int edge_corner[3][4][2] = {
    {{0, 1}, {3, 2}, {4, 5}, {7, 6}}, {{0, 3}, {1, 2}, {4, 7}, {5, 6}}, {{0, 4}, {1, 5}, {3, 7}, {2, 6}}};

/// Edges, or lines between them: a[direction][which][component] [m]; half of one is dx/dxi along it.
template <class T>
struct Edges {
  T a[3][4][3];
};

/// The twelve edges [m].
template <class T>
Edges<T> edges(const Corners<T>& x) {
  Edges<T> r;
  for (int d = 0; d < 3; ++d)
    for (int n = 0; n < 4; ++n)
      for (int k = 0; k < 3; ++k) r.a[d][n][k] = x.c[edge_corner[d][n][1]][k] - x.c[edge_corner[d][n][0]][k];
  return r;
}

/// The lines through the eight points of the 2x2x2 Gauss rule, from the edges.
template <class T>
Edges<T> gauss_lines(const Edges<T>& edge) {
  const T inwards(0.5 * (1 - 0.57735026918962576451));  // of the way across, (1 - 1/sqrt 3)/2
  Edges<T> r;
  for (int d = 0; d < 3; ++d)
    for (int k = 0; k < 3; ++k) {
      T first[4];
      for (int n = 0; n < 4; n += 2) {
        const T step = inwards * (edge.a[d][n + 1][k] - edge.a[d][n][k]);
        first[n] = edge.a[d][n][k] + step;
        first[n + 1] = edge.a[d][n + 1][k] - step;
      }
      for (int n = 0; n < 2; ++n) {
        const T step = inwards * (first[n + 2] - first[n]);
        r.a[d][n][k] = first[n] + step;
        r.a[d][n + 2][k] = first[n + 2] - step;
      }
    }
  return r;
}

/// Which line along each direction passes through point i, whose xi, eta, zeta are the bits 1, 2, 4 of i.
constexpr int line_at[8][3] = {{0, 0, 0}, {0, 1, 1}, {1, 0, 2}, {1, 1, 3}, {2, 2, 0}, {2, 3, 1}, {3, 2, 2}, {3, 3, 3}};

/// Smallest and largest det J of the eight points in which three of the lines meet [m3 / 8].
template <class T>
void extreme_jacobians(const Edges<T>& line, T& low, T& high) {
  low = T(1e300);
  high = T(-1e300);
  for (const auto& at : line_at) {
    const T *a = line.a[0][at[0]], *b = line.a[1][at[1]], *c = line.a[2][at[2]];
    const T det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    low = core::min(det, low);
    high = core::max(det, high);
  }
  low *= T(0.125);
  high *= T(0.125);
}

/// Smallest det J of the eight corners [m3 / 8]: positive in a convex element.
template <class T>
T smallest_corner_jacobian(const Edges<T>& edge) {
  T low, high;
  extreme_jacobians(edge, low, high);
  return low;
}

/// Largest over smallest det J of the eight points of the 2x2x2 Gauss rule [-]; 1e300 where the smallest is not positive.
/// Source: Campbell & Vignjevic, Int. J. Impact Engng 20 (1997) 143, criterion "Jacobian".
template <class T>
T jacobian_ratio(const Edges<T>& edge) {
  T low, high;
  extreme_jacobians(gauss_lines(edge), low, high);
  return core::select(low > T(0.0), high / low, T(1e300));
}

/// Do two edges of a face meet at an angle whose cosine c is above a limit? limit: c|c| of that cosine [-], which spares
/// roots and quotients.
template <class T>
auto sharper_than(const Edges<T>& edge, T limit) {
  T square[3][4];
  for (int d = 0; d < 3; ++d)
    for (int n = 0; n < 4; ++n) {
      const T* a = edge.a[d][n];
      square[d][n] = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    }
  T most(-1e300);  // of |a|^2 |b|^2 (c|c| - limit)
  for (int i = 0; i < 8; ++i)
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, m = line_at[i][d], n = line_at[i][e];
      const T *a = edge.a[d][m], *b = edge.a[e][n];
      const T along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      const T ab = (i >> d & 1) == (i >> e & 1) ? along : -along;  // of the edges as they leave the corner
      most = core::max(ab * core::abs(ab) - limit * (square[d][m] * square[e][n]), most);
    }
  return most > T(0.0);
}

/// Smallest of the angles between the two edges that meet at a face's corner, all corners of all faces [rad].
double smallest_angle(const Corners<double>& x);

}  // namespace fem
