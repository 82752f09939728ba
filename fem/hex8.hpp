// SPDX-License-Identifier: Apache-2.0
// The one-point hexahedron: pure functions of eight corners, for one element (T = double) or lanes of elements.
//   volume and mean gradient: Flanagan & Belytschko, Int. J. Numer. Meth. Engng 17 (1981) 679, eqs 15-17 and 79:
//     B_jI = integral of dN_I/dx_j over the element (exact), V = x_I B_xI, mean dv_i/dx_j = v_iI B_jI / V
//   hourglass shape vectors: the same, eqs 34-36: gamma_aI = Gamma_aI - B_jI (x_jJ Gamma_aJ) / V
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

/// Sum over corners of a_I h_aI for one base vector.
template <class T>
T hourglass_sum(const Corners<T>& a, int mode, int direction) {
  T s(0.0);
  for (int i = 0; i < 8; ++i) s = hourglass_base[mode][i] > 0 ? s + a.c[i][direction] : s - a.c[i][direction];
  return s;
}

/// Shape vectors gamma[mode][corner], orthogonal to constant and linear fields on the actual element.
template <class T>
void hourglass_shape(const Corners<T>& x, const Gradient<T>& g, T inverse_volume, T gamma[4][8]) {
  for (int a = 0; a < 4; ++a) {
    T h[3];
    for (int j = 0; j < 3; ++j) h[j] = hourglass_sum(x, a, j) * inverse_volume;
    for (int i = 0; i < 8; ++i)
      gamma[a][i] = T(hourglass_base[a][i]) - (g.b[i][0] * h[0] + g.b[i][1] * h[1] + g.b[i][2] * h[2]);
  }
}

/// det J at a point of the parent cube, xi in [-1, 1]^3.
double jacobian_at(const Corners<double>& x, double xi, double eta, double zeta);

/// Largest over smallest det J of the eight points of the 2x2x2 Gauss rule; 1e300 where the smallest is not positive.
/// Source: Campbell & Vignjevic, Int. J. Impact Engng 20 (1997) 143, criterion "Jacobian".
double jacobian_ratio(const Corners<double>& x);

/// Smallest det J of the eight corners [m3 / 8]: positive in a convex element.
double smallest_corner_jacobian(const Corners<double>& x);

/// Smallest of the angles between the two edges that meet at a face's corner, all corners of all faces [rad].
double smallest_angle(const Corners<double>& x);

}  // namespace fem
