// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see stress_kernel.hpp for what it does.
#include "sph/stress_kernel.hpp"

#include "core/isa.hpp"
#include "core/pack.hpp"

namespace sph::EJECTA_ISA {
namespace {

constexpr int W = core::native_lanes;
using Real = core::Pack<W>;

/// B from the moment matrix M (symmetric: xx yy zz xy yz zx): its inverse where the neighbours span space, the identity
/// where they do not. Returns the part that the inverse has in it, 0 to 1.
template <class T>
T correction_of(const T* m, T* b) {
  using core::select;
  constexpr double poor = 0.004, enough = 0.016;  // det M on a lattice: 0.95 inside, 0.30 face, 0.093 edge, 0.028 corner
  constexpr double largest = 8;  // a thin sheet can have a fair determinant and one weak direction
  const T c[6] = {m[1] * m[2] - m[4] * m[4], m[2] * m[0] - m[5] * m[5], m[0] * m[1] - m[3] * m[3],
                  m[4] * m[5] - m[3] * m[2], m[5] * m[3] - m[4] * m[0], m[3] * m[4] - m[5] * m[1]};
  const T det = m[0] * c[0] + m[3] * c[3] + m[5] * c[5];
  const auto spans = det > T(poor);
  const T inverse = T(1.0) / select(spans, det, T(1.0));
  const T w = core::min((det - T(poor)) * T(1 / (enough - poor)), T(1.0));
  T size(0.0);
  for (int k = 0; k < 6; ++k) {
    b[k] = c[k] * inverse;
    size = core::max(core::abs(b[k]), size);
  }
  const auto good = spans & (size <= T(largest));
  for (int k = 0; k < 6; ++k) {
    const T one(k < 3 ? 1.0 : 0.0);
    b[k] = select(good, w * b[k] + (T(1.0) - w) * one, one);
  }
  return select(good, w, T(0.0));
}

/// Turns the symmetric a in the plane of axes p and q until a[p][q] is zero, and v with it: one rotation of Jacobi's.
template <class T>
void rotate_away(int p, int q, T a[3][3], T v[3][3]) {
  using core::select;
  const int r = 3 - p - q;
  const auto needed = core::abs(a[p][q]) > T(0.0);
  const T theta = (a[q][q] - a[p][p]) / select(needed, T(2.0) * a[p][q], T(1.0));
  const T size = T(1.0) / (core::abs(theta) + core::sqrt(theta * theta + T(1.0)));
  const T t = select(needed, select(theta < T(0.0), -size, size), T(0.0));
  const T c = T(1.0) / core::sqrt(t * t + T(1.0)), s = t * c;
  a[p][p] -= t * a[p][q];
  a[q][q] += t * a[p][q];
  a[p][q] = a[q][p] = T(0.0);
  const T rp = c * a[r][p] - s * a[r][q], rq = s * a[r][p] + c * a[r][q];
  a[r][p] = a[p][r] = rp;
  a[r][q] = a[q][r] = rq;
  for (int k = 0; k < 3; ++k) {
    const T vp = c * v[k][p] - s * v[k][q], vq = s * v[k][p] + c * v[k][q];
    v[k][p] = vp;
    v[k][q] = vq;
  }
}

/// -epsilon sigma for every tensile principal stress: pushes along it (Gray et al., eqs 3.12-3.14). Principal stresses by
/// Jacobi's rotations (Golub & Van Loan, Matrix Computations, 1996, section 8.4).
template <class T>
void artificial_stress(const T* sigma, double epsilon, T* push) {
  constexpr int sweeps = 6;         // converges quadratically: three or four do
  constexpr double rel_tol = 1e-15;
  T a[3][3] = {{sigma[0], sigma[3], sigma[5]}, {sigma[3], sigma[1], sigma[4]}, {sigma[5], sigma[4], sigma[2]}};
  T v[3][3] = {{T(1.0), T(0.0), T(0.0)}, {T(0.0), T(1.0), T(0.0)}, {T(0.0), T(0.0), T(1.0)}};
  const T size = core::abs(a[0][0]) + core::abs(a[1][1]) + core::abs(a[2][2]) + core::abs(a[0][1]) + core::abs(a[1][2]) +
                 core::abs(a[2][0]);
  for (int k = 0; k < sweeps; ++k) {
    const T off = core::abs(a[0][1]) + core::abs(a[1][2]) + core::abs(a[2][0]);
    const auto active = off > T(rel_tol) * size;
    if (!core::any(active)) break;
    // a lane that is done stays as it is, so that its bits do not depend on its company
    T b[3][3], u[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) b[i][j] = a[i][j], u[i][j] = v[i][j];
    rotate_away(0, 1, b, u);
    rotate_away(1, 2, b, u);
    rotate_away(0, 2, b, u);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) a[i][j] = core::select(active, b[i][j], a[i][j]), v[i][j] = core::select(active, u[i][j], v[i][j]);
  }
  constexpr int row[6] = {0, 1, 2, 0, 1, 2}, column[6] = {0, 1, 2, 1, 2, 0};
  for (int k = 0; k < 6; ++k) {
    push[k] = T(0.0);
    for (int e = 0; e < 3; ++e)
      push[k] -= (T(epsilon) * core::max(a[e][e], T(0.0))) * (v[row[k]][e] * v[column[k]][e]);
  }
}

/// Share of the speed of sound that the sums over a row answer with, for its stable step. Matter that bears shear is stable to
/// twice the step of a gas, liquid and powder to one and a half times it (bars, rings, drops, noise); gases behind a shock lose density
/// from that on (Noh). `loaded`, the pressure over rho c^2, tells them apart: above 0.5 in a gas, 0.2 behind the strongest shocks in
/// metals, next to nothing in metals at rest. A row without the correction answers in proportion to what stands round it, of
/// which the trace of the moment is the measure: 3 inside.
template <class T>
T acoustic_share(const T* m, T corrected, T bears, T loaded) {
  using core::select;
  constexpr double solid = 0.5, condensed = 0.65, as_gas = 0.05;
  const T fluid = T(condensed) + T(1 - condensed) * core::min(core::max(loaded, T(0.0)) * T(1 / as_gas), T(1.0));
  const T share = select(bears > T(0.0), T(solid), fluid);
  const T around = core::min(core::max(m[0] + m[1] + m[2], T(0.25)), T(1.0));
  return select(corrected > T(0.0), share, share * around);
}

/// W lanes of one array from row i on; `n` rows are there, the last stands in for those that are missing.
Real load(const std::vector<double>& a, std::size_t i, std::size_t n) {
  if (n >= W) return core::load<Real>(&a[i]);
  Real r;
  for (std::size_t l = 0; l < W; ++l) r.set(static_cast<int>(l), a[i + (l < n ? l : n - 1)]);
  return r;
}

}  // namespace

void correct_rows(const core::Points& pt, double epsilon, std::size_t first, std::size_t last, const Moment* moment,
                  core::Mat3* correction, float* acoustic, Actors& actors) {
  for (std::size_t i = first; i < last; i += W) {
    const std::size_t n = last - i, lanes = n < W ? n : W;
    Real m[6], b[6], sigma[6], push[6], stress[9], artificial[9];
    for (int k = 0; k < 6; ++k)
      for (std::size_t l = 0; l < W; ++l) m[k].set(static_cast<int>(l), moment[i - first + (l < lanes ? l : lanes - 1)].sum[k]);
    const Real corrected = correction_of(m, b);
    const Real p = load(pt.p, i, n);
    for (std::size_t k = 0; k < 6; ++k) sigma[k] = k < 3 ? load(pt.s[k], i, n) - p : load(pt.s[k], i, n);
    Real bears(0.0);  // shear: neither fluid nor powder
    for (std::size_t k = 0; k < 6; ++k) bears = core::max(bears, core::abs(load(pt.s[k], i, n)));
    const auto firm = (corrected >= Real(1.0)) & (bears > Real(0.0));
    const Real sound = load(pt.c, i, n), modulus = load(pt.rho, i, n) * sound * sound;
    const Real share = acoustic_share(m, corrected, bears, p / core::max(modulus, Real(1e-300)));
    // no principal stress exceeds the greatest of Gershgorin's bounds
    const Real xy = core::abs(sigma[3]), yz = core::abs(sigma[4]), zx = core::abs(sigma[5]);
    const Real bound = core::max(core::max(sigma[0] + xy + zx, sigma[1] + xy + yz), sigma[2] + yz + zx);
    const bool may_pull = epsilon > 0 && core::any(bound > Real(0.0));
    if (may_pull) artificial_stress(sigma, epsilon, push);
    constexpr int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    const auto corrected_by_b = [&](const Real* a, Real* out) {  // a B^T
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) out[r + 3 * c] = a[at[r][0]] * b[at[c][0]] + a[at[r][1]] * b[at[c][1]] + a[at[r][2]] * b[at[c][2]];
    };
    corrected_by_b(sigma, stress);
    if (may_pull) corrected_by_b(push, artificial);
    Real most(0.0);
    for (const Real& component : stress) most = core::max(most, core::abs(component));
    for (std::size_t l = 0; l < lanes; ++l) {
      const int lane = static_cast<int>(l);
      double* to = correction[i + l].data();
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          to[r + 3 * c] = b[at[r][c]][lane];
          actors.stress[i + l].column[c][r] = static_cast<float>(stress[r + 3 * c][lane]);
        }
      actors.stress[i + l].most() = static_cast<float>(most[lane]);
      acoustic[i + l] = static_cast<float>(share[lane]);
      Kind& kind = actors.kind[i + l];
      kind = (kind & ~(firm_bit | tension_bit)) | (firm[lane] ? firm_bit : 0);
      if (!may_pull || pt.e[i + l] < 0) continue;  // its work is no change of volume: who has nothing to pay it with does without
      if (!(bound[lane] > 0) || !(push[0][lane] + push[1][lane] + push[2][lane] < 0)) continue;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) actors.artificial[i + l].column[c][r] = static_cast<float>(artificial[r + 3 * c][lane]);
      kind |= tension_bit;
    }
  }
}

}  // namespace sph::EJECTA_ISA
