// SPDX-License-Identifier: Apache-2.0
// Tabular equation of state: SESAME tables (Lyon & Johnson, LA-UR-92-3407, 1992) of p and e over density and temperature,
// from a file (eos/sesame_file.hpp).
//
// Runs ask for (rho, e). On loading, the table is inverted once onto a grid that lanes address without a search:
//   density   u = y/(1 + |y|), y = ln(rho/rho_n), uniform: finest at the normal density rho_n, coarser away from it;
//   energy    h = e - e_c(rho) above the coldest isotherm, x = 1 + h/h_0, nodes evenly 16 to each doubling of x, so that
//             the leading bits of x are the row.
// Between nodes p is a monotone cubic (Fritsch & Butland, 1984, eos/monotone_cubic.hpp) in u and linear in h, which is
// exact where p is linear in e at constant density (Grueneisen). It has no overshoot at phase boundaries, is monotone in u
// where the table is, and its derivatives are those that c uses:  c^2 = dp/drho + (p/rho^2) dp/de. T is bilinear.
// Interpolation between the file's own densities and temperatures is by monotone cubics in rho, then in h.
//
// Reference state: rest (e = 0) is the table's state at p = 0 and T_0 on the condensed side; where a table has p > 0 in its
// two-phase region, p = 1e5 Pa stands for zero. What p is there, that or round-off, is taken off everywhere: matter at rest carries nothing. Where rho_0 differs (an alloy), the table is scaled as if its atoms were
// heavier or lighter by that ratio k = rho_ref/rho_0: rho' = k rho, e' = e/k, p' = p, c' = c/sqrt(k), so shock impedance
// follows; scaling by more than max_density_scaling is refused.
//
// Edges: above the largest density p goes on along its tangent; below the smallest in proportion to rho; above the hottest
// isotherm linearly in h; below the coldest p and T are those of the coldest. In the two-phase region of the table p and e
// are as tabulated (Maxwell construction, or tension where the table has it); where dp/drho < 0 the sound speed is held at
// its floor. inside() tells whether a state is on the table.
#pragma once

#include <cassert>
#include <memory>
#include <string>
#include <vector>

#include "core/lane_math.hpp"
#include "eos/sesame_file.hpp"
#include "eos/state.hpp"

namespace eos {

struct SesameTable {
  static constexpr int bits_per_doubling = 4;  ///< rows: 16 to a doubling of x
  static constexpr int shift = 52 - bits_per_doubling;
  static constexpr int n_node = 4;             ///< p [Pa], dp/du du [Pa], T [K], unused: corners stay in one cache line
  static constexpr int n_base = 3;             ///< e_c [J/kg], de_c/du du [J/kg], h of the hottest isotherm [J/kg]

  int columns = 0, rows = 0;
  double rho_n = 0, rho_min = 0, rho_max = 0;  ///< normal density and range [kg/m3]
  double u_min = 0, du = 0;
  double h_0 = 0;                              ///< [J/kg]
  std::vector<double> node;                    ///< [row][column][n_node]
  std::vector<double> base;                    ///< [column][n_base]
  std::vector<double> source_T;                ///< isotherms of the file, for messages [K]
};

/// Largest relative difference between the material's rho_0 and the table's that scaling may bridge.
constexpr double max_density_scaling = 0.08;

struct Sesame {
  std::string file;        ///< absolute
  int number = 0;          ///< of the material in the file
  double rho_0 = 0;        ///< of the material at rest [kg/m3]; 0: that of the table
  double T_0 = 294;        ///< of the material at rest [K]

  // Derived by prepare().
  std::shared_ptr<const SesameTable> table;
  double scale = 1;        ///< k
  double e_ref = 0;        ///< e' at rest [J/kg]
  double p_ref = 0;        ///< p' at rest, taken off [Pa]
  double c2_ref = 0;       ///< c^2 at rest [m2/s2]
};

/// Reads and inverts the table unless that is done, and finds the reference state.
void prepare(Sesame& m);

/// The grid described above from p and e over (rho, T). `name` is for messages; rho_n [kg/m3].
SesameTable invert(const SesameGrid& grid, double rho_n, const std::string& name);

namespace detail {
template <class T>
struct TableCell {
  T p0, p1, s0, s1, T0, T1;        ///< lower row: p, slopes, temperature
  T q0, q1, z0, z1, U0, U1;        ///< upper row
};

template <class T>
struct TableRow {
  T x, width;  ///< lower node and spacing of x
};

/// Corner values of cell (i, row of x), lane by lane.
template <class T>
TableCell<T> gather(const SesameTable& t, T column, T x, TableRow<T>& row) {
  constexpr int w = core::Lanes<T>::width;
  alignas(64) double a[14][w];
  for (int l = 0; l < w; ++l) {
    const auto i = static_cast<std::size_t>(core::lane(column, l));
    constexpr std::int64_t one = std::int64_t{1023} << SesameTable::bits_per_doubling;
    std::int64_t j = (core::bits(core::lane(x, l)) >> SesameTable::shift) - one;
    j = j > t.rows - 2 ? t.rows - 2 : j;
    a[0][l] = core::from_bits((j + one) << SesameTable::shift, 0.0);
    a[1][l] = core::from_bits((j + one + 1) << SesameTable::shift, 0.0) - a[0][l];
    const double* lo = t.node.data() + (static_cast<std::size_t>(j) * static_cast<std::size_t>(t.columns) + i) * SesameTable::n_node;
    const double* hi = lo + static_cast<std::size_t>(t.columns) * SesameTable::n_node;
    a[2][l] = lo[0], a[3][l] = lo[4], a[4][l] = lo[1], a[5][l] = lo[5], a[6][l] = lo[2], a[7][l] = lo[6];
    a[8][l] = hi[0], a[9][l] = hi[4], a[10][l] = hi[1], a[11][l] = hi[5], a[12][l] = hi[2], a[13][l] = hi[6];
  }
  const auto get = [&](int k) { return core::load<T>(a[k]); };
  row = {get(0), get(1)};
  return {get(2), get(3), get(4), get(5), get(6), get(7), get(8), get(9), get(10), get(11), get(12), get(13)};
}

template <class T>
struct ValueSlope {
  T value, slope;
};

/// Cubic Hermite on [0, 1].
template <class T>
ValueSlope<T> hermite(T a, T y0, T y1, T s0, T s1) {
  const T r = T(1.0) - a, rise = y1 - y0;
  return {y0 + rise * a * a * (T(3.0) - T(2.0) * a) + a * r * (r * s0 - a * s1),
          T(6.0) * rise * a * r + s0 * r * (T(1.0) - T(3.0) * a) + s1 * a * (T(3.0) * a - T(2.0))};
}

/// Column of rho (its whole part) and the place within it.
template <class T>
struct TablePlace {
  T column, a, du_drho;
};
template <class T>
TablePlace<T> place(const SesameTable& t, T rho) {
  const T y = core::log(rho * T(1.0 / t.rho_n));
  const T inverse = T(1.0) / (T(1.0) + core::abs(y));
  const T at = (y * inverse - T(t.u_min)) * T(1.0 / t.du);
  const T magic = T(6755399441055744.0);  // 1.5 * 2^52: rounds to a whole number
  T column = (core::max(at - T(0.5), T(0.0)) + magic) - magic;
  column = core::min(column, T(static_cast<double>(t.columns - 2)));
  return {column, at - column, inverse * inverse / (rho * T(t.du))};
}

/// The state in the table's own density and energy.
template <class T>
State<T> table_state(const SesameTable& t, T rho, T e) {
  const T held = core::min(core::max(rho, T(t.rho_min)), T(t.rho_max));
  const TablePlace<T> at = place(t, held);
  // the base first: the row depends on it
  constexpr int w = core::Lanes<T>::width;
  alignas(64) double base[4][w];
  for (int l = 0; l < w; ++l) {
    const double* b = t.base.data() + static_cast<std::size_t>(core::lane(at.column, l)) * SesameTable::n_base;
    base[0][l] = b[0], base[1][l] = b[3], base[2][l] = b[1], base[3][l] = b[4];
  }
  const ValueSlope<T> cold =
      hermite(at.a, core::load<T>(base[0]), core::load<T>(base[1]), core::load<T>(base[2]), core::load<T>(base[3]));
  const T h = e - cold.value;
  const auto warm = h > T(0.0);
  const T x = T(1.0) + core::max(h, T(0.0)) * T(1.0 / t.h_0);
  TableRow<T> row;
  const TableCell<T> c = gather(t, at.column, x, row);
  const T b = (x - row.x) / row.width;
  const ValueSlope<T> lower = hermite(at.a, c.p0, c.p1, c.s0, c.s1), upper = hermite(at.a, c.q0, c.q1, c.z0, c.z1);
  const T p = lower.value + b * (upper.value - lower.value);
  const T dp_de = core::select(warm, (upper.value - lower.value) / (row.width * T(t.h_0)), T(0.0));
  const T dp_drho = (lower.slope + b * (upper.slope - lower.slope) - dp_de * cold.slope) * at.du_drho;
  const T T_lo = c.T0 + at.a * (c.T1 - c.T0), T_hi = c.U0 + at.a * (c.U1 - c.U0);
  // beyond the densities of the table
  const auto thin = rho < T(t.rho_min);
  const T part = rho / held;
  const T outer = core::select(thin, p * part, p + core::max(rho - held, T(0.0)) * core::max(dp_drho, T(0.0)));
  const T slope = core::select(thin, p / held, dp_drho);
  const T stiffer = core::select(dp_drho > T(0.0), (upper.slope - lower.slope) / (row.width * T(t.h_0)) * at.du_drho, T(0.0));
  const T heat = core::select(thin, dp_de * part, dp_de + core::max(rho - held, T(0.0)) * stiffer);
  return {outer, slope + outer * heat / (rho * rho), T_lo + b * (T_hi - T_lo)};
}
}  // namespace detail

/// rho [kg/m3] > 0, e [J/kg] from the reference state.
template <class T>
State<T> state(const Sesame& m, T rho, T e) {
  assert(m.table && "prepare() was not called");
  const State<T> s = detail::table_state(*m.table, rho * T(m.scale), e * T(1.0 / m.scale) + T(m.e_ref));
  constexpr double floor = min_sound_speed_ratio * min_sound_speed_ratio;
  return {s.p - T(m.p_ref), core::max(s.c2 * T(m.scale), T(floor * m.c2_ref)), core::max(s.temperature, T(0.0))};
}

/// Energy on the coldest isotherm [J/kg], of the condensed part where matter is thinner (eos/state.hpp).
double cold_energy(const Sesame& m, double rho);

/// Whether (rho, e) is on the table. Expanded matter colder than the coldest isotherm is: it holds voids.
bool inside(const Sesame& m, double rho, double e);

/// The range of the table at rho, for messages.
std::string range_text(const Sesame& m, double rho);

}  // namespace eos
