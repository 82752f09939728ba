// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see pair_kernel.hpp for what it does.
#include "sph/pair_kernel.hpp"

#include "core/isa.hpp"
#include "core/pack.hpp"
#include "sph/kernel.hpp"
#include "sph/particle_forces.hpp"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 on its own AVX-512 header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace sph::EJECTA_ISA {
namespace {

constexpr int W = core::native_lanes, parts = 8 / W;
using Real = core::Pack<W>;
using Lanes = Real::Real;
using Bits = Real::Bits;
using Yes = core::Mask<W>;

// ------------------------------------------------------------------------------------------- neighbours into lanes

template <std::size_t offset>
inline const double* row(const PairView& v, std::uint32_t i) {
  return reinterpret_cast<const double*>(reinterpret_cast<const char*>(v.actor + i) + offset);
}
template <class V>
inline V load_as(const double* a) {
  V v;
  __builtin_memcpy(&v, a, sizeof v);
  return v;
}

/// Four doubles, from `offset` bytes on, of each of W actors: field by field.
template <std::size_t offset>
[[gnu::always_inline]] inline void load_four(const PairView& v, const std::uint32_t* id, Real* out) {
#if defined(__AVX512F__)
  using Half = core::LaneType<4>::Real;
  Lanes a[4], b[4];
  for (int k = 0; k < 4; ++k)
    a[k] = __builtin_shufflevector(load_as<Half>(row<offset>(v, id[k])), load_as<Half>(row<offset>(v, id[k + 4])), 0, 1,
                                   2, 3, 4, 5, 6, 7);
  for (int k = 0; k < 4; k += 2) {
    b[k] = __builtin_shufflevector(a[k], a[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    b[k + 1] = __builtin_shufflevector(a[k], a[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int k = 0; k < 2; ++k) {
    out[k] = Real(Lanes(__builtin_shufflevector(b[k], b[k + 2], 0, 1, 8, 9, 4, 5, 12, 13)));
    out[k + 2] = Real(Lanes(__builtin_shufflevector(b[k], b[k + 2], 2, 3, 10, 11, 6, 7, 14, 15)));
  }
#elif defined(__AVX2__)
  Lanes a[4], b[4];
  for (int k = 0; k < 4; ++k) a[k] = load_as<Lanes>(row<offset>(v, id[k]));
  for (int k = 0; k < 4; k += 2) {
    b[k] = __builtin_shufflevector(a[k], a[k + 1], 0, 4, 2, 6);
    b[k + 1] = __builtin_shufflevector(a[k], a[k + 1], 1, 5, 3, 7);
  }
  for (int k = 0; k < 2; ++k) {
    out[k] = Real(Lanes(__builtin_shufflevector(b[k], b[k + 2], 0, 1, 4, 5)));
    out[k + 2] = Real(Lanes(__builtin_shufflevector(b[k], b[k + 2], 2, 3, 6, 7)));
  }
#else
  for (int k = 0; k < 4; k += 2) {
    const Lanes a = load_as<Lanes>(row<offset>(v, id[0]) + k), b = load_as<Lanes>(row<offset>(v, id[1]) + k);
    out[k] = Real(Lanes(__builtin_shufflevector(a, b, 0, 2)));
    out[k + 1] = Real(Lanes(__builtin_shufflevector(a, b, 1, 3)));
  }
#endif
}
template <std::size_t offset>
[[gnu::always_inline]] inline void load_eight(const PairView& v, const std::uint32_t* id, Real* out) {
  load_four<offset>(v, id, out);
  load_four<offset + 32>(v, id, out + 4);
}

inline unsigned lane_bits(Yes m) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask((__m512i)m.m);
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)m.m));
#else
  unsigned bits = 0;
  for (int l = 0; l < W; ++l) bits |= static_cast<unsigned>(m[l]) << l;
  return bits;
#endif
}

/// Stores those of sixteen numbers whose bit is set. Returns the end.
inline std::uint32_t* store_some(std::uint32_t* to, unsigned bits, const std::uint32_t* from) {
#if defined(__AVX512F__)
  const __mmask16 m = static_cast<__mmask16>(bits);
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(m, _mm512_maskz_loadu_epi32(m, from)));
  return to + __builtin_popcount(bits);
#else
  for (; bits != 0; bits &= bits - 1) *to++ = from[__builtin_ctz(bits)];
  return to;
#endif
}

/// The sum of eight lanes, in one order.
inline double total(const double* a) { return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7])); }

/// A sum over a row's neighbours, in eight lanes.
struct Sum {
  Real part[parts];
  Sum() {
    for (Real& a : part) a = Real(0.0);
  }
  double total() const {
    double a[8];
    for (int p = 0; p < parts; ++p) core::store(a + p * W, part[p]);
    return sph::EJECTA_ISA::total(a);
  }
  double greatest() const {
    double r = 0;
    for (int p = 0; p < parts; ++p)
      for (int l = 0; l < W; ++l) r = part[p][l] > r ? part[p][l] : r;
    return r;
  }
};

/// A row's own actor.
struct Own {
  const Actor& a;
  Real x[3], h;
  explicit Own(const Actor& actor) : a(actor), h(actor.h) {
    for (int d = 0; d < 3; ++d) x[d] = Real(actor.x[d]);
  }
};

/// Which of up to sixteen candidates are within 2 h of the row.
[[gnu::always_inline]] inline unsigned in_reach(const PairView& v, const Own& own, const std::uint32_t* list, std::size_t n, std::uint32_t self) {
  alignas(64) std::uint32_t id[near_word];
#if defined(__AVX512F__)
  const __mmask16 valid = static_cast<__mmask16>(n < near_word ? (1u << n) - 1 : 0xffffu);
  _mm512_store_si512(id, _mm512_mask_loadu_epi32(_mm512_set1_epi32(static_cast<int>(self)), valid, list));
#else
  for (std::size_t k = 0; k < near_word; ++k) id[k] = k < n ? list[k] : self;
#endif
  unsigned bits = 0;
  for (std::size_t k = 0; k < near_word && k < n; k += W) {
    Real b[4];
    load_four<0>(v, id + k, b);
    const Real dx = own.x[0] - b[0], dy = own.x[1] - b[1], dz = own.x[2] - b[2];
    const Real reach = own.h + b[3];  // 2 h of the pair
    static_assert(kernel_reach == 2.0);
    bits |= lane_bits(dx * dx + dy * dy + dz * dz < reach * reach) << k;
  }
  return n < near_word ? bits & ((1u << n) - 1) : bits;
}

/// Calls f(ids of eight) for all near neighbours of row i, in the order of the list; the last eight are filled up with i
/// itself, which contributes nothing to any sum. With `search`, finds them first.
template <bool search, class F>
[[gnu::always_inline]] inline void each_eight(const PairView& v, std::size_t i, const Own& own, F&& f) {
  constexpr std::size_t room = 256;
  alignas(64) std::uint32_t id[room + 2 * near_word];
  std::uint32_t* end = id;
  std::uint32_t n_near = 0;
  const auto self = static_cast<std::uint32_t>(i);
  std::uint64_t k = v.start[i];
  const std::uint64_t last = v.start[i + 1];
  std::uint16_t* word = v.near + first_near_word(k, i);
  for (bool done = false; !done;) {
    for (; k < last && end < id + room; k += near_word, ++word) {
      if constexpr (search) {
        *word = static_cast<std::uint16_t>(in_reach(v, own, v.list + k, last - k, self));
        n_near += static_cast<std::uint32_t>(__builtin_popcount(*word));
      }
      end = store_some(end, *word, v.list + k);
    }
    done = k >= last;
    if (done)
      for (int l = 0; l < 8; ++l) end[l] = self;
    const std::uint32_t* from = id;
    for (const std::uint32_t* stop = done ? end : end - 7; from < stop; from += 8) f(from);
    std::uint32_t* to = id;
    while (from < end) *to++ = *from++;
    end = to;
  }
  if constexpr (search) v.n_near[i] = n_near;
}

// --------------------------------------------------------------------------------------------------------- physics

/// A neighbour as the pair sees it; the layout is that of Actor.
struct Near {
  Real place[8];  ///< x y z h V m, in tension, body
  const Real& volume() const { return place[4]; }
  const Real& m() const { return place[5]; }
  Yes in_tension() const { return place[6] > Real(0.0); }
  Bits body() const { return core::bits(place[7]); }
};

/// Where two actors stand to each other.
struct Geometry {
  Real d[3], r2, h, r, inverse_h, slope;
};

[[gnu::always_inline]] inline Geometry geometry(const Own& own, const Near& b) {
  Geometry g;
  for (int d = 0; d < 3; ++d) g.d[d] = own.x[d] - b.place[d];
  g.h = Real(0.5) * (own.h + b.place[3]);
  g.r2 = g.d[0] * g.d[0] + g.d[1] * g.d[1] + g.d[2] * g.d[2];
  g.r = core::sqrt(g.r2);
  g.inverse_h = Real(1.0) / g.h;
  g.slope = kernel_slope(g.r, g.h, g.inverse_h);
  return g;
}

inline Real dot(const Real* a, const Real* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Second line of an actor: v, c, rho, shear switch, p_contact, stress xx.
struct Flow {
  Real at[8];
};

/// mu of the viscosity [m/s]: positive where a pair approaches.
inline Real approach(const Geometry& g, const Real* dv, Real inverse) { return -(g.h * dot(dv, g.d)) * inverse; }

/// a symmetric tensor (xx yy zz xy yz zx) on a vector.
template <class T>
inline void apply_symmetric(const T* t, const Real* g, Real* out) {
  out[0] = Real(t[0]) * g[0] + Real(t[3]) * g[1] + Real(t[5]) * g[2];
  out[1] = Real(t[3]) * g[0] + Real(t[1]) * g[1] + Real(t[4]) * g[2];
  out[2] = Real(t[5]) * g[0] + Real(t[4]) * g[1] + Real(t[2]) * g[2];
}

/// d . D d of a strain rate (xx yy zz xy yz zx).
template <class T>
inline Real stretch_along(const T* rate, const Real* d) {
  Real out[3];
  apply_symmetric(rate, d, out);
  return dot(out, d);
}

/// Monaghan's viscosity Pi; zero for pairs that part, but for the motion that hourglass control sees.
[[gnu::always_inline]] inline Real viscosity(const PairView& v, const ParticleSettings& s, const Actor& a, const std::uint32_t* id, const Flow& b,
                                             const Geometry& g, Real inverse, Yes same) {
  const Real dv[3] = {Real(a.v[0]) - b.at[0], Real(a.v[1]) - b.at[1], Real(a.v[2]) - b.at[2]};
  const Real mu_all = approach(g, dv, inverse), mu = core::max(mu_all, Real(0.0));
  const Real spread = Real(0.5) * (Real(a.spread) + b.at[5]), c = Real(0.5) * (Real(a.c) + b.at[3]);
  Real linear = Real(s.viscosity_linear) * spread * mu;
  if (a.firm > 0) {
    Real rate[8];
    load_eight<320>(v, id, rate);
    const Yes firm = same & (rate[6] > Real(0.0));
    const Real mine = stretch_along(a.rate.data(), g.d), theirs = stretch_along(rate, g.d), both = mine + theirs;
    const Real product = mine * theirs, scale = g.h * inverse;
    // van Leer's limiter: the harmonic mean where the signs agree
    const Yes agree = product > Real(0.0);
    const Real limited = core::select(agree, Real(2.0) * product / core::select(agree, both, Real(1.0)), Real(0.0));
    const Real unexplained = core::min(core::max(mu_all + scale * limited, Real(0.0)), mu);
    const Real hourglass = Real(s.hourglass) * (mu_all + scale * (Real(0.5) * both));
    linear = core::select(firm, Real(s.viscosity_linear) * spread * unexplained + hourglass, linear);
  }
  return (c * linear + Real(s.viscosity_quadratic) * (mu * mu)) / (Real(0.5) * (Real(a.rho) + b.at[4]));
}

struct PairForce {
  Real gradient[3];  ///< grad_i W
  Real own[3];       ///< part of the force on i that i's own stress makes: its work is i's
  Real other[3];     ///< part that j's stress makes
  Real viscous[3];   ///< shared half and half
};

/// Everything between a row and W neighbours at time n; the mirror image of what they see, to the last bit.
template <bool with_other>
[[gnu::always_inline]] inline void pair_force(const PairView& v, const ParticleSettings& s, const Own& own, const std::uint32_t* id, const Near& b,
                       const Geometry& g, Real inverse, PairForce& f) {
  const Actor& a = own.a;
  Flow flow;
  load_eight<64>(v, id, flow.at);
  for (int d = 0; d < 3; ++d) f.gradient[d] = g.slope * g.d[d];
  const Real vv = Real(a.volume) * b.volume();
  const double* as = a.stress.data();
  for (int d = 0; d < 3; ++d)
    f.own[d] = vv * (Real(as[d]) * f.gradient[0] + Real(as[d + 3]) * f.gradient[1] + Real(as[d + 6]) * f.gradient[2]);
  if constexpr (with_other) {
    Real rest[8];
    load_eight<128>(v, id, rest);
    for (int d = 0; d < 3; ++d) {
      const Real& first = d == 0 ? flow.at[7] : rest[d - 1];
      f.other[d] = vv * (first * f.gradient[0] + rest[d + 2] * f.gradient[1] + rest[d + 5] * f.gradient[2]);
    }
  }
  const bool a_pulls = a.tension > 0;
  const Yes b_pulls = b.in_tension();
  if (a_pulls || (with_other && core::any(b_pulls))) {
    // nothing at the regular spacing, where it would only weaken the matter; held where pairs nearly meet, below 0.8 of it
    const Real w = kernel_over_spacing(g.r * g.inverse_h), w2 = w * w;
    const Real weight = vv * core::min(core::max(w2 * w2 - Real(1.0), Real(0.0)), Real(4.0));
    Real push[3];
    if (a_pulls) {
      apply_symmetric(a.artificial.data(), f.gradient, push);
      for (int d = 0; d < 3; ++d) f.own[d] += weight * push[d];
    }
    if constexpr (with_other) {
      Real tensor[8];
      load_eight<192>(v, id, tensor);
      apply_symmetric(tensor, f.gradient, push);
      for (int d = 0; d < 3; ++d) f.other[d] += core::select(b_pulls, weight * push[d], Real(0.0));
    }
  }
  const Yes same{b.body() == a.body};
  if (core::any(!same)) {
    const Real mine = vv * Real(a.p_contact), theirs = vv * flow.at[6];
    for (int d = 0; d < 3; ++d) {
      f.own[d] = core::select(same, f.own[d], -(mine * f.gradient[d]));
      if constexpr (with_other) f.other[d] = core::select(same, f.other[d], -(theirs * f.gradient[d]));
    }
  }
  const Real pi = (Real(a.m) * b.m()) * viscosity(v, s, a, id, flow, g, inverse, same);
  for (int d = 0; d < 3; ++d) f.viscous[d] = -(pi * f.gradient[d]);
}

inline Real inverse_distance(const Geometry& g) { return Real(1.0) / (g.r2 + Real(0.01) * (g.h * g.h)); }

/// Weights of a foreigner's anchors in its pairs with W particles, into scratch, 32 doubles an anchor from the offset on:
/// they add up to one and fall to nothing within one spacing of anchors from the middle of the pair. A lattice under uniform
/// stress is then held still within 2e-3 of the stress at any seam. What strangers push acts at the centre.
inline void weigh_anchors(const AnchorView& anchors, std::size_t k, const Own& own, const Near& b, const Geometry& g,
                          double* scratch) {
  constexpr double radius_over_h = 0.9 / h_over_spacing, floor = 1e-9;
  const Real radius = Real(anchors.spacing * radius_over_h) * g.h, scale = Real(1.0) / (radius * radius);
  Real middle[3], sum(0.0);
  for (int d = 0; d < 3; ++d) middle[d] = Real(0.5) * (own.x[d] + b.place[d]);
  const std::size_t centre = anchors.start[k + 1] - anchors.start[k] - 1;
  const core::Vec3* const x = anchors.x + anchors.start[k];
  for (std::size_t n = 0; n < centre; ++n) {
    Real off[3];
    for (int d = 0; d < 3; ++d) off[d] = Real(x[n][d]) - middle[d];
    const Real u = core::max(Real(1.0) - dot(off, off) * scale, Real(0.0)), weight = u * u + Real(floor);
    core::store(scratch + 32 * n, weight);
    sum += weight;
  }
  if (centre == 0) return core::store(scratch, Real(1.0));
  const Yes kin{b.body() == own.a.body};
  const Real inverse = core::select(kin, Real(1.0) / sum, Real(0.0));
  for (std::size_t n = 0; n < centre; ++n) core::store(scratch + 32 * n, core::load<Real>(scratch + 32 * n) * inverse);
  core::store(scratch + 32 * centre, core::select(kin, Real(0.0), Real(1.0)));
}

}  // namespace

void find_near(const PairView& v, std::size_t first, std::size_t last, Moment* moment) {
  for (std::size_t i = first; i < last; ++i) {
    const Own own(v.actor[i]);
    Sum sum[6];
    each_eight<true>(v, i, own, [&](const std::uint32_t* id) __attribute__((always_inline)) {
      if (!moment) return;
      for (int p = 0; p < parts; ++p) {
        Near b;
        load_eight<0>(v, id + p * W, b.place);
        const Geometry g = geometry(own, b);
        const Real w = -(b.volume() * g.slope), x = w * g.d[0], y = w * g.d[1], z = w * g.d[2];
        sum[0].part[p] += x * g.d[0];
        sum[1].part[p] += y * g.d[1];
        sum[2].part[p] += z * g.d[2];
        sum[3].part[p] += x * g.d[1];
        sum[4].part[p] += y * g.d[2];
        sum[5].part[p] += z * g.d[0];
      }
    });
    if (moment)
      for (int k = 0; k < 6; ++k) moment[i - first].sum[k] = sum[k].total();
  }
}

void pair_forces(const PairView& v, const ParticleSettings& s, std::size_t first, std::size_t last, RowForce* force) {
  for (std::size_t i = first; i < last; ++i) {
    RowForce& to = force[i - first];
    to = {};
    if (v.n_near[i] == 0) continue;
    const Own own(v.actor[i]);
    Sum sum[3], wall[3];
    each_eight<false>(v, i, own, [&](const std::uint32_t* id) __attribute__((always_inline)) {
      for (int p = 0; p < parts; ++p) {
        Near b;
        load_eight<0>(v, id + p * W, b.place);
        const Geometry g = geometry(own, b);
        PairForce f;
        pair_force<true>(v, s, own, id + p * W, b, g, inverse_distance(g), f);
        Real all[3];
        for (int d = 0; d < 3; ++d) {
          all[d] = (f.own[d] + f.other[d]) + f.viscous[d];
          sum[d].part[p] += all[d];
        }
        const Yes behind{b.body() == std::int64_t{wall_body}};
        if (core::any(behind))
          for (int d = 0; d < 3; ++d) wall[d].part[p] += core::select(behind, all[d], Real(0.0));
      }
    });
    for (int d = 0; d < 3; ++d) to.all[d] = sum[d].total();
    for (int d = 0; d < 3; ++d) to.wall[d] = wall[d].total();
  }
}

void pair_work(const PairView& v, const ParticleSettings& s, std::size_t first, std::size_t last, RowWork* work) {
  for (std::size_t i = first; i < last; ++i) {
    RowWork& to = work[i - first];
    to = {};
    if (v.n_near[i] == 0) continue;
    const Own own(v.actor[i]);
    const Actor& a = own.a;
    Sum power, rate[3][3], fastest;
    each_eight<false>(v, i, own, [&](const std::uint32_t* id) __attribute__((always_inline)) {
      for (int p = 0; p < parts; ++p) {
        Near b;
        load_eight<0>(v, id + p * W, b.place);
        const Geometry g = geometry(own, b);
        const Real inverse = inverse_distance(g);
        PairForce f;
        pair_force<false>(v, s, own, id + p * W, b, g, inverse, f);
        Real speed[8];  // v_new, v_mean
        load_eight<256>(v, id + p * W, speed);
        Real dv[3], dv_mean[3], paid[3];
        for (int d = 0; d < 3; ++d) {
          dv[d] = Real(a.v_new[d]) - speed[d];
          dv_mean[d] = Real(a.v_mean[d]) - speed[d + 3];
          paid[d] = f.own[d] + Real(0.5) * f.viscous[d];
        }
        power.part[p] += dot(paid, dv_mean);
        const Real mu = approach(g, dv, inverse);
        fastest.part[p] = core::max(fastest.part[p], mu);
        Real weight = -b.volume();
        // a stranger that recedes leaves no tension behind: nothing would have paid for it
        const Yes same{b.body() == a.body};
        if (core::any(!same) && !(a.p_contact > 0)) weight = core::select(same | (mu > Real(0.0)), weight, Real(0.0));
        for (int d = 0; d < 3; ++d) {
          const Real volume_speed = weight * dv[d];
          for (int c = 0; c < 3; ++c) rate[d][c].part[p] += volume_speed * f.gradient[c];
        }
      }
    });
    to.power = power.total();
    to.approach = fastest.greatest();
    for (int d = 0; d < 3; ++d)
      for (int c = 0; c < 3; ++c) to.rate[d][c] = rate[d][c].total();
  }
}

void foreign_forces(const PairView& v, const ParticleSettings& s, const AnchorView& anchors, std::size_t first,
                    std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t k = i - anchors.n_particles, n_anchors = anchors.start[k + 1] - anchors.start[k];
    core::Vec3* force = anchors.force + anchors.start[k];
    for (std::size_t n = 0; n < n_anchors; ++n) force[n] = core::Vec3(0, 0, 0);
    if (v.n_near[i] == 0) continue;
    for (std::size_t n = 0; n < 32 * n_anchors; ++n) anchors.scratch[n] = 0;  // of each anchor: weights, force x, y, z
    const Own own(v.actor[i]);
    each_eight<false>(v, i, own, [&](const std::uint32_t* id) __attribute__((always_inline)) {
      for (int p = 0; p < parts; ++p) {
        Near b;
        load_eight<0>(v, id + p * W, b.place);
        const Geometry g = geometry(own, b);
        PairForce f;
        pair_force<true>(v, s, own, id + p * W, b, g, inverse_distance(g), f);
        double* lanes = anchors.scratch + p * W;
        weigh_anchors(anchors, k, own, b, g, lanes);
        for (std::size_t n = 0; n < n_anchors; ++n, lanes += 32) {
          const Real weight = core::load<Real>(lanes);
          for (int d = 0; d < 3; ++d) {
            double* sum = lanes + 8 * (d + 1);
            core::store(sum, core::load<Real>(sum) + weight * ((f.own[d] + f.other[d]) + f.viscous[d]));
          }
        }
      }
    });
    for (std::size_t n = 0; n < n_anchors; ++n)
      for (int d = 0; d < 3; ++d) force[n][d] = total(anchors.scratch + 32 * n + 8 * (static_cast<std::size_t>(d) + 1));
  }
}

void foreign_work(const PairView& v, const ParticleSettings& s, const AnchorView& anchors, std::size_t first,
                  std::size_t last, double* power) {
  for (std::size_t i = first; i < last; ++i) {
    power[i - first] = 0;
    if (v.n_near[i] == 0) continue;
    const std::size_t k = i - anchors.n_particles, n_anchors = anchors.start[k + 1] - anchors.start[k];
    const Own own(v.actor[i]);
    Sum sum;
    each_eight<false>(v, i, own, [&](const std::uint32_t* id) __attribute__((always_inline)) {
      for (int p = 0; p < parts; ++p) {
        Near b;
        load_eight<0>(v, id + p * W, b.place);
        const Geometry g = geometry(own, b);
        PairForce f;
        pair_force<true>(v, s, own, id + p * W, b, g, inverse_distance(g), f);
        Real speed[8];  // v_new, v_mean
        load_eight<256>(v, id + p * W, speed);
        weigh_anchors(anchors, k, own, b, g, anchors.scratch);
        Real at_anchors[3] = {Real(0.0), Real(0.0), Real(0.0)};
        for (std::size_t n = 0; n < n_anchors; ++n)
          for (int d = 0; d < 3; ++d)
            at_anchors[d] += core::load<Real>(anchors.scratch + 32 * n) * Real(anchors.v_mean[anchors.start[k] + n][d]);
        // what the particle does not book of the pair's work: its force acts on the anchors, not at the centre
        Real all[3], booked[3], from_anchors[3], from_centre[3];
        for (int d = 0; d < 3; ++d) {
          all[d] = (f.own[d] + f.other[d]) + f.viscous[d];
          booked[d] = f.other[d] + Real(0.5) * f.viscous[d];
          from_anchors[d] = at_anchors[d] - speed[d + 3];
          from_centre[d] = Real(own.a.v_mean[d]) - speed[d + 3];
        }
        sum.part[p] += dot(all, from_anchors) - dot(booked, from_centre);
      }
    });
    power[i - first] = sum.total();
  }
}

}  // namespace sph::EJECTA_ISA
