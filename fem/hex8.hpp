// SPDX-License-Identifier: Apache-2.0
// The one-point hexahedron: pure functions of eight corners, for one element (T = double) or lanes of elements.
//   volume and mean gradient: Flanagan & Belytschko, Int. J. Numer. Meth. Engng 17 (1981) 679, eqs 15-17 and 79:
//     B_jI = integral of dN_I/dx_j over the element (exact), V = x_I B_xI, mean dv_i/dx_j = v_iI B_jI / V
//   hourglass shape vectors: the same, eqs 34-36: gamma_aI = h_aI - B_jI (x_jJ h_aJ) / V
// Corner order: fem/generate.hpp.
#pragma once

#include "core/pack.hpp"

namespace fem {

/// Coordinates or velocities of eight corners: c[corner][direction].
template <class T>
struct Corners {
  T c[8][3];
};

/// B_jI [corner][direction], units of area.
template <class T>
struct Gradient {
  T b[8][3];
};

/// Which corners take the places of 1..8 in the formula for corner I (Flanagan & Belytschko, table 1).
constexpr int fb_order[8][8] = {{0, 1, 2, 3, 4, 5, 6, 7}, {1, 2, 3, 0, 5, 6, 7, 4}, {2, 3, 0, 1, 6, 7, 4, 5},
                                {3, 0, 1, 2, 7, 4, 5, 6}, {4, 7, 6, 5, 0, 3, 2, 1}, {5, 4, 7, 6, 1, 0, 3, 2},
                                {6, 5, 4, 7, 2, 1, 0, 3}, {7, 6, 5, 4, 3, 2, 1, 0}};

/// Exact mean gradient operator [m2].
template <class T>
void gradient(const Corners<T>& x, Gradient<T>& g) {
  for (int j = 0; j < 3; ++j) {
    const int y = (j + 1) % 3, z = (j + 2) % 3;
    for (int i = 0; i < 8; ++i) {
      const int* o = fb_order[i];
      const auto Y = [&](int k) { return x.c[o[k - 1]][y]; };
      const auto Z = [&](int k) { return x.c[o[k - 1]][z]; };
      const T z25 = Z(2) - Z(5), z24 = Z(2) - Z(4), z45 = Z(4) - Z(5);
      g.b[i][j] = T(1.0 / 12.0) * (Y(2) * ((Z(6) - Z(3)) - z45) + Y(3) * z24 + Y(4) * ((Z(3) - Z(8)) + z25) +
                                   Y(5) * ((Z(8) - Z(6)) - z24) - Y(6) * z25 + Y(8) * z45);
    }
  }
}

/// Volume [m3] from corners and their gradient operator.
template <class T>
T volume(const Corners<T>& x, const Gradient<T>& g) {
  T v = x.c[0][0] * g.b[0][0];
  for (int i = 1; i < 8; ++i) v += x.c[i][0] * g.b[i][0];
  return v;
}

/// The length [m] that sound crosses in a stable step. An element by itself allows 2 V / sqrt(8 B_jI B_jI): the edge of one
/// that is thin, 1 / sqrt 3 of it in a cube (Flanagan & Belytschko, J. Appl. Mech. 51 (1984) 35; with the trace of B B^T in
/// place of its largest eigenvalue no Poisson's ratio makes it too long). Among others a cube allows its whole edge, of which
/// two thirds are taken. edge: volume over the largest face area [m].
template <class T>
T stable_length(const Gradient<T>& g, T volume, T edge) {
  constexpr double in_a_body = 2.0 / 3;
  T trace(0.0);
  for (const auto& b : g.b) trace += b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  return core::max(T(2.0) * volume / core::sqrt(T(8.0) * trace), T(in_a_body) * edge);
}

/// Sum over corners of a_iI b_jI: l[i][j]; divided by the volume it is the mean gradient of a.
template <class T>
void contract(const Corners<T>& a, const Gradient<T>& g, T l[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      T s = a.c[0][i] * g.b[0][j];
      for (int k = 1; k < 8; ++k) s += a.c[k][i] * g.b[k][j];
      l[i][j] = s;
    }
}

/// Corners of the six faces, outward by the right-hand rule.
constexpr int face_corner[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Square of the largest face area [m4], from the diagonals.
template <class T>
T largest_face_area_squared(const Corners<T>& x) {
  T largest(0.0);
  for (const auto& f : face_corner) {
    T d[3], e[3];
    for (int k = 0; k < 3; ++k) {
      d[k] = x.c[f[2]][k] - x.c[f[0]][k];
      e[k] = x.c[f[3]][k] - x.c[f[1]][k];
    }
    const T nx = d[1] * e[2] - d[2] * e[1], ny = d[2] * e[0] - d[0] * e[2], nz = d[0] * e[1] - d[1] * e[0];
    largest = core::max(largest, nx * nx + ny * ny + nz * nz);
  }
  return T(0.25) * largest;
}

/// The four hourglass base vectors, orthogonal to constant and linear fields on a cube.
constexpr double hourglass_base[4][8] = {{1, 1, -1, -1, -1, -1, 1, 1},
                                         {1, -1, -1, 1, -1, 1, 1, -1},
                                         {1, -1, 1, -1, 1, -1, 1, -1},
                                         {-1, 1, -1, 1, 1, -1, 1, -1}};

/// Sums over corners of a_I times each base vector, in one direction.
template <class T>
void hourglass_sums(const Corners<T>& a, int direction, T sum[4]) {
  T along[2], across[2], twist[2];
  for (int k = 0; k < 2; ++k) {  // the faces of corners 0-3 and 4-7
    const auto at = [&](int i) { return a.c[4 * k + i][direction]; };
    const T u = at(0) - at(2), w = at(1) - at(3);
    along[k] = u + w;
    across[k] = u - w;
    twist[k] = (at(0) + at(2)) - (at(1) + at(3));
  }
  sum[0] = along[0] - along[1];
  sum[1] = across[0] - across[1];
  sum[2] = twist[0] + twist[1];
  sum[3] = twist[1] - twist[0];
}

/// Sum over modes of q_a times each base vector, subtracted from f at every corner, in one direction.
template <class T>
void subtract_modes(const T q[4], int direction, T f[8][3]) {
  const T a = q[0] + q[1], b = q[0] - q[1], c = q[2] - q[3], e = q[2] + q[3];
  f[0][direction] -= a + c;
  f[1][direction] -= b - c;
  f[2][direction] -= c - a;
  f[3][direction] += b + c;
  f[4][direction] -= e - a;
  f[5][direction] += b + e;
  f[6][direction] -= a + e;
  f[7][direction] -= b - e;
}

/// Rates of the hourglass modes, sum over corners of gamma_aI v_iI [mode][direction], without the shape vectors gamma
/// themselves: h_a . v_i - (dv_i/dx_j) (h_a . x_j). `position` receives h_a . x_j.
/// l: mean velocity gradient on this element.
template <class T>
void hourglass_rates(const Corners<T>& x, const Corners<T>& v, const T l[3][3], T position[4][3], T rate[4][3]) {
  for (int d = 0; d < 3; ++d) {
    T hx[4], hv[4];
    hourglass_sums(x, d, hx);
    hourglass_sums(v, d, hv);
    for (int a = 0; a < 4; ++a) position[a][d] = hx[a], rate[a][d] = hv[a];
  }
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d)
      rate[a][d] -= l[d][0] * position[a][0] + l[d][1] * position[a][1] + l[d][2] * position[a][2];
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
