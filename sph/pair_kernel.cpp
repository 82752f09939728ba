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

constexpr int group = 4;  // neighbours that go through together
constexpr int W = core::native_lanes < group ? core::native_lanes : group, parts = group / W;
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
#if defined(__AVX2__)
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
/// The double at `offset` of each of W actors.
template <std::size_t offset>
[[gnu::always_inline]] inline Real load_one(const PairView& v, const std::uint32_t* id) {
  const auto at = [&](int l) { return *row<offset>(v, id[l]); };
#if defined(__AVX2__)
  return Real(Lanes{at(0), at(1), at(2), at(3)});
#else
  return Real(Lanes{at(0), at(1)});
#endif
}

inline unsigned lane_bits(Yes m) {
#if defined(__AVX2__)
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

/// The sum of four lanes, in one order.
inline double total(const double* a) { return (a[0] + a[2]) + (a[1] + a[3]); }

/// A sum over a row's neighbours, in four lanes.
struct Sum {
  Real part[parts];
  Sum() {
    for (Real& a : part) a = Real(0.0);
  }
  double total() const {
    double a[group];
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

constexpr std::size_t most_groups = 68;  ///< that each_piece passes on at a time

/// Calls f(ids, how many) for the near neighbours of row i, in the order of the list and in pieces of whole fours; the last
/// four are filled up with i itself, which contributes nothing to any sum. With `search`, finds them first.
template <bool search, class F>
[[gnu::always_inline]] inline void each_piece(const PairView& v, std::size_t i, const Own& own, F&& f) {
  constexpr std::size_t room = group * most_groups - near_word;
  alignas(64) std::uint32_t id[room + 3 * near_word];
  std::uint32_t* end = id;
  std::uint32_t n_near = 0;
  const auto self = static_cast<std::uint32_t>(i);
  std::uint64_t k = v.start[i];
  const std::uint64_t last = v.start[i + 1];
  std::uint16_t* word = v.near + first_near_word(k, i);
  for (bool done = false; !done;) {
    for (; k < last && end < id + room; k += near_word, ++word) {
      unsigned bits;
      if constexpr (search) {
        bits = in_reach(v, own, v.list + k, last - k, self);
        *word = static_cast<std::uint16_t>(bits);
        n_near += static_cast<std::uint32_t>(__builtin_popcount(bits));
      } else {
        bits = *word;
      }
      end = store_some(end, bits, v.list + k);
    }
    done = k >= last;
    if (done)
      for (int l = 0; l < group; ++l) end[l] = self;
    const std::size_t n = (static_cast<std::size_t>(end - id) + (done ? group - 1 : 0)) / group * group;
    f(static_cast<const std::uint32_t*>(id), n);
    std::uint32_t* to = id;
    for (const std::uint32_t* from = id + n; from < end;) *to++ = *from++;
    end = to;
  }
  if constexpr (search) v.n_near[i] = n_near;
}

/// Asks for lines first ... last of the neighbours' rows while their distances are worked out.
template <std::size_t first, std::size_t last>
[[gnu::always_inline]] inline void fetch_lines(const PairView& v, const std::uint32_t* id, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t line = first; line <= last; ++line) __builtin_prefetch(row<0>(v, id[k]) + 8 * line);
}

// --------------------------------------------------------------------------------------------------------- physics

// Where Actor keeps what is loaded in lanes [bytes].
constexpr std::size_t at_x = 0, at_volume = 32, at_v = 64, at_v_new = 96, at_spread = 120, at_artificial = 128, at_yy = 240,
                      at_contact = 248, at_rate = 256;
static_assert(offsetof(Actor, x) == at_x && offsetof(Actor, volume) == at_volume && offsetof(Actor, v) == at_v &&
              offsetof(Actor, v_new) == at_v_new && offsetof(Actor, spread) == at_spread &&
              offsetof(Actor, artificial) == at_artificial && offsetof(Actor, artificial_yy) == at_yy &&
              offsetof(Actor, p_contact) == at_contact && offsetof(Actor, rate) == at_rate && offsetof(Actor, firm) == at_rate + 48);

/// Where two actors stand to each other. reach = 2 h of the pair.
struct Geometry {
  Real d[3], r, reach, inverse_reach, inverse_soft, slope;
  Real q() const { return Real(2.0) * (r * inverse_reach); }
};

template <class T>
inline T dot(const T* a, const T* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

[[gnu::always_inline]] inline Geometry geometry(const PairView& v, const Own& own, const std::uint32_t* id) {
  Real place[4];  // x y z h
  load_four<at_x>(v, id, place);
  Geometry g;
  for (int d = 0; d < 3; ++d) g.d[d] = own.x[d] - place[d];
  g.reach = own.h + place[3];
  const Real r2 = dot(g.d, g.d), soft = r2 + Real(0.0025) * (g.reach * g.reach), both = Real(1.0) / (g.reach * soft);
  g.r = core::sqrt(r2);
  g.inverse_reach = both * soft;
  g.inverse_soft = both * g.reach;
  g.slope = kernel_slope_in(g.r, g.reach, g.inverse_reach);
  return g;
}

/// h / (r^2 + 0.01 h^2)
inline Real approach_factor(const Geometry& g) { return Real(0.5) * g.reach * g.inverse_soft; }

/// Where four neighbours stand to their row, for the loops that follow: short loops of their own keep the processor busy
/// with several fours at a time.
struct alignas(64) Places {
  double d[3][group];
  double slope[group];
  double approach[group];  ///< mu of the viscosity is this times how fast their distance shrinks: h / (r^2 + 0.01 h^2)
  double q[group];         ///< r / h
};

[[gnu::always_inline]] inline void find_places(const PairView& v, const Own& own, const std::uint32_t* id, std::size_t n, Places* to) {
  for (std::size_t k = 0; k < n; k += group, ++to)
    for (int p = 0; p < group; p += W) {
      const Geometry g = geometry(v, own, id + k + p);
      for (int d = 0; d < 3; ++d) core::store(to->d[d] + p, g.d[d]);
      core::store(to->slope + p, g.slope);
      core::store(to->approach + p, approach_factor(g));
      core::store(to->q + p, g.q());
    }
}

/// What of a neighbour matters but its stress.
struct Near {
  Real body[4];  ///< V, body and tension, m, c
  Real flow[4];  ///< v, rho
  const Real& volume() const { return body[0]; }
  const Real& m() const { return body[2]; }
  const Real& c() const { return body[3]; }
  const Real& rho() const { return flow[3]; }
  Yes in_tension() const { return Yes{core::bits(body[1]) > std::int64_t{0xffffffff}}; }
  Yes of_body(std::int32_t b) const {
    return Yes{(core::bits(body[1]) & 0xffffffff) == std::int64_t{static_cast<std::uint32_t>(b)}};
  }
  Near(const PairView& v, const std::uint32_t* id) {
    load_four<at_volume>(v, id, body);
    load_four<at_v>(v, id, flow);
  }
};
static_assert(offsetof(Actor, body) == at_volume + 8 && offsetof(Actor, tension) == at_volume + 12 && offsetof(Actor, m) == at_volume + 16 &&
              offsetof(Actor, c) == at_volume + 24 && offsetof(Actor, rho) == at_v + 24);

/// Monaghan's viscosity: m_j Pi, zero for pairs that part. mu = h (v_j - v_i) . d / (r^2 + 0.01 h^2), positive where a pair
/// approaches [m/s].
[[gnu::always_inline]] inline Real viscosity(const ParticleSettings& s, const Actor& a, const Near& b, Real b_spread, Real mu) {
  const Real closing = core::max(mu, Real(0.0)), rho = Real(a.rho) + b.rho();
  const Real c = (Real(a.c) + b.c()) * (Real(a.spread) + b_spread);  // four times the product of means
  return closing * (Real(0.5 * s.viscosity_linear) * c + Real(2.0 * s.viscosity_quadratic) * closing) * (b.m() / rho);
}

/// d . D d of a strain rate (xx yy zz xy yz zx); `dd` are the products of d's components, mixed ones twice.
template <class T>
[[gnu::always_inline]] inline Real stretch_along(const T* rate, const Real* dd) {
  return ((Real(rate[0]) * dd[0] + Real(rate[1]) * dd[1]) + (Real(rate[2]) * dd[2] + Real(rate[3]) * dd[3])) +
         (Real(rate[4]) * dd[4] + Real(rate[5]) * dd[5]);
}

/// The same in the row of a firm particle: with its firm neighbours of one body the linear viscosity leaves out what the
/// strain rates explain, and hourglass control damps what they do not.
[[gnu::always_inline]] inline Real firm_viscosity(const PairView& v, const ParticleSettings& s, const Actor& a, const std::uint32_t* id,
                                                  const Near& b, Real b_spread, Real mu, const Real* d, Real approach, Yes same) {
  const Real closing = core::max(mu, Real(0.0)), rho = Real(a.rho) + b.rho(), c = Real(a.c) + b.c();
  const Real alpha = Real(0.5 * s.viscosity_linear) * (Real(a.spread) + b_spread);
  Real rate[8];
  load_four<at_rate>(v, id, rate);
  load_four<at_rate + 32>(v, id, rate + 4);
  const Yes firm = same & (rate[6] > Real(0.0));
  const Real twice[3] = {d[0] + d[0], d[1] + d[1], d[2] + d[2]};
  const Real dd[6] = {d[0] * d[0], d[1] * d[1], d[2] * d[2], twice[0] * d[1], twice[1] * d[2], twice[2] * d[0]};
  const Real mine = stretch_along(a.rate.data(), dd), theirs = stretch_along(rate, dd), both = mine + theirs, product = mine * theirs;
  // van Leer's limiter: the harmonic mean where the signs agree
  const Yes agree = product > Real(0.0);
  const Real limited = core::select(agree, Real(2.0) * product / core::select(agree, both, Real(1.0)), Real(0.0));
  const Real unexplained = core::min(core::max(mu + approach * limited, Real(0.0)), closing);
  const Real hourglass = Real(s.hourglass) * (mu + approach * (Real(0.5) * both));
  const Real linear = core::select(firm, alpha * unexplained + hourglass, alpha * closing);
  return (c * linear + Real(2.0 * s.viscosity_quadratic) * (closing * closing)) * (b.m() / rho);
}

/// Pairs closer than the regular spacing: few, and the only ones in which artificial stress acts.
inline Yes crowded(Real q) { return q < Real(1 / h_over_spacing); }

/// Gray's factor of the artificial stress in a crowded pair: nothing at the regular spacing, where it would only weaken the
/// matter; held where pairs nearly meet, below 0.8 of it.
template <class T>
T artificial_weight(T q) {
  const T w = kernel_over_spacing(q), w2 = w * w;
  return core::min(core::max(w2 * w2 - T(1.0), T(0.0)), T(4.0));
}

/// One bit for each of a piece's neighbours.
struct Chosen {
  std::uint64_t word[(group * most_groups + 63) / 64];
  explicit Chosen(std::size_t n) {
    for (std::size_t k = 0; k < n; k += 64) word[k / 64] = 0;
  }
  void add(std::size_t k, Yes lanes) { word[k / 64] |= std::uint64_t{lane_bits(lanes)} << k % 64; }
  template <class F>
  [[gnu::always_inline]] void each(std::size_t n, F&& f) const {
    for (std::size_t k = 0; k < n; k += 64)
      for (std::uint64_t left = word[k / 64]; left != 0; left &= left - 1) f(k + static_cast<std::size_t>(__builtin_ctzll(left)));
  }
};

/// The actor's stress on a vector, and its artificial stress.
template <class T>
[[gnu::always_inline]] inline void apply_stress(const Actor& a, const T* g, T* out) {
  const double* s = a.stress.data();
  for (int d = 0; d < 3; ++d) out[d] = T(s[d]) * g[0] + T(s[d + 3]) * g[1] + T(s[d + 6]) * g[2];
}
template <class A, class T>
[[gnu::always_inline]] inline void apply_symmetric(const A* a, const A& yy, const T* g, T* out) {  // xx xy zx yz zz
  out[0] = T(a[0]) * g[0] + T(a[1]) * g[1] + T(a[2]) * g[2];
  out[1] = T(a[1]) * g[0] + T(yy) * g[1] + T(a[3]) * g[2];
  out[2] = T(a[2]) * g[0] + T(a[3]) * g[1] + T(a[4]) * g[2];
}

/// Vectors on which the stresses of four neighbours act.
struct alignas(64) Vectors {
  double g[3][group];
};

/// The sum of the neighbours' stresses on vectors, n of them: the stresses stay in their rows, a column to four lanes, and the
/// vectors come one by one.
class StressSum {
 public:
  [[gnu::always_inline]] void add(const PairView& v, const std::uint32_t* id, std::size_t n, const Vectors* on) {
    Four x = x_, y = y_, z = z_, x_odd{}, y_odd{}, z_odd{};
    for (std::size_t k = 0; k < n; k += group, ++on)
      for (int l = 0; l < group; l += 2) {
        const double *s = v.actor[id[k + l]].stress.data(), *t = v.actor[id[k + l + 1]].stress.data();
        x += load_as<Four>(s - 1) * all(on->g[0][l]);
        y += load_as<Four>(s + 3) * all(on->g[1][l]);
        z += load_as<Four>(s + 6) * all(on->g[2][l]);
        x_odd += load_as<Four>(t - 1) * all(on->g[0][l + 1]);
        y_odd += load_as<Four>(t + 3) * all(on->g[1][l + 1]);
        z_odd += load_as<Four>(t + 6) * all(on->g[2][l + 1]);
      }
    x_ = x + x_odd, y_ = y + y_odd, z_ = z + z_odd;
  }
  void total(double* f) const {
    const auto a = lanes(x_), b = lanes(y_), c = lanes(z_);
    for (std::size_t d = 0; d < 3; ++d) f[d] = (a[d + 1] + b[d]) + c[d];  // the first column is loaded one lane late, see Actor
  }

 private:
  using Four = core::LaneType<4>::Real;
  static Four all(double a) { return Four{a, a, a, a}; }
  static std::array<double, 4> lanes(Four a) { return {a[0], a[1], a[2], a[3]}; }
  Four x_{}, y_{}, z_{};
};
static_assert(offsetof(Actor, stress) == at_artificial + 40 && offsetof(Actor, artificial_yy) == offsetof(Actor, stress) + 72);

struct PairForce {
  Real own[3];       ///< part of the force on i that i's own stress makes: its work is i's
  Real other[3];     ///< part that j's stress makes
  Real viscous[3];   ///< shared half and half
};

/// The force between a foreigner's row and W particles, its parts one by one. Foreigners are not firm.
[[gnu::always_inline]] inline void pair_force(const PairView& v, const ParticleSettings& s, const Own& own, const std::uint32_t* id,
                                              const Near& b, const Geometry& g, PairForce& f) {
  const Actor& a = own.a;
  const Real slope = (Real(a.volume) * b.volume()) * g.slope;
  const Real gradient[3] = {slope * g.d[0], slope * g.d[1], slope * g.d[2]};
  apply_stress(a, gradient, f.own);
  Real stress[12];  // from the second entry on
  load_four<at_artificial + 32>(v, id, stress);
  load_four<at_artificial + 64>(v, id, stress + 4);
  load_four<at_artificial + 88>(v, id, stress + 7);
  for (int d = 0; d < 3; ++d) f.other[d] = stress[d + 1] * gradient[0] + stress[d + 4] * gradient[1] + stress[d + 7] * gradient[2];
  const Yes b_pulls = b.in_tension() & crowded(g.q());
  if (core::any(b_pulls)) {
    Real artificial[8], push[3];
    load_four<at_artificial>(v, id, artificial);
    load_four<at_artificial + 32>(v, id, artificial + 4);
    apply_symmetric(artificial, load_one<at_yy>(v, id), gradient, push);
    const Real weight = core::select(b_pulls, artificial_weight(g.q()), Real(0.0));
    for (int d = 0; d < 3; ++d) f.other[d] += weight * push[d];
  }
  const Yes same = b.of_body(a.body);
  if (core::any(!same)) {
    const Real p = load_one<at_contact>(v, id);
    for (int d = 0; d < 3; ++d) {
      f.own[d] = core::select(same, f.own[d], -(Real(a.p_contact) * gradient[d]));
      f.other[d] = core::select(same, f.other[d], -(p * gradient[d]));
    }
  }
  const Real dv[3] = {Real(a.v[0]) - b.flow[0], Real(a.v[1]) - b.flow[1], Real(a.v[2]) - b.flow[2]};
  const Real mu = -(dot(dv, g.d) * approach_factor(g));
  const Real push = Real(a.m) * (viscosity(s, a, b, load_one<at_spread>(v, id), mu) * g.slope);
  for (int d = 0; d < 3; ++d) f.viscous[d] = -(push * g.d[d]);
}

/// Weights of a foreigner's anchors in its pairs with W particles, into scratch, 16 doubles an anchor from the offset on:
/// they add up to one and fall to nothing within one spacing of anchors from the middle of the pair. A lattice under uniform
/// stress is then held still within 2e-3 of the stress at any seam. What strangers push acts at the centre.
inline void weigh_anchors(const AnchorView& anchors, std::size_t k, const Own& own, const Near& b, const Geometry& g,
                          double* scratch) {
  constexpr double radius_over_h = 0.9 / h_over_spacing, floor = 1e-9;
  const Real radius = Real(0.5 * anchors.spacing * radius_over_h) * g.reach, scale = Real(1.0) / (radius * radius);
  Real middle[3], sum(0.0);
  for (int d = 0; d < 3; ++d) middle[d] = own.x[d] - Real(0.5) * g.d[d];
  const std::size_t centre = anchors.start[k + 1] - anchors.start[k] - 1;
  const core::Vec3* const x = anchors.x + anchors.start[k];
  for (std::size_t n = 0; n < centre; ++n) {
    Real off[3];
    for (int d = 0; d < 3; ++d) off[d] = Real(x[n][d]) - middle[d];
    const Real u = core::max(Real(1.0) - dot(off, off) * scale, Real(0.0)), weight = u * u + Real(floor);
    core::store(scratch + 4 * group * n, weight);
    sum += weight;
  }
  if (centre == 0) return core::store(scratch, Real(1.0));
  const Yes kin = b.of_body(own.a.body);
  const Real inverse = core::select(kin, Real(1.0) / sum, Real(0.0));
  for (std::size_t n = 0; n < centre; ++n) core::store(scratch + 4 * group * n, core::load<Real>(scratch + 4 * group * n) * inverse);
  core::store(scratch + 4 * group * centre, core::select(kin, Real(0.0), Real(1.0)));
}

}  // namespace

void find_near(const PairView& v, std::size_t first, std::size_t last, Moment* moment) {
  for (std::size_t i = first; i < last; ++i) {
    const Own own(v.actor[i]);
    Sum sum[6];
    each_piece<true>(v, i, own, [&](const std::uint32_t* id, std::size_t n) __attribute__((always_inline)) {
      if (!moment) return;
      for (std::size_t k = 0; k < n; k += group)
        for (int p = 0; p < parts; ++p) {
          const std::uint32_t* const part = id + k + p * W;
          const Geometry g = geometry(v, own, part);
          const Real w = -(load_one<at_volume>(v, part) * g.slope), x = w * g.d[0], y = w * g.d[1], z = w * g.d[2];
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

// Stress on the sum of gradients is what the row's own stress adds to the force: V_i sigma_i sum_j V_j grad W.
void pair_forces(const PairView& v, const ParticleSettings& s, std::size_t first, std::size_t last, RowForce* force) {
  Places places[most_groups];
  Vectors vectors[most_groups];
  for (std::size_t i = first; i < last; ++i) {
    RowForce& to = force[i - first];
    to = {};
    if (v.n_near[i] == 0) continue;
    const Own own(v.actor[i]);
    const Actor& a = own.a;
    const bool a_pulls = a.tension != 0, a_firm = a.firm > 0;
    StressSum stress;
    Sum gradients[3], contact[3], viscous[3], wall[3];
    double weighted[3] = {}, pushed[3] = {};
    each_piece<false>(v, i, own, [&](const std::uint32_t* id, std::size_t n) __attribute__((always_inline)) {
      if (a_firm)
        fetch_lines<1, 4>(v, id, n);
      else
        fetch_lines<1, 3>(v, id, n);
      find_places(v, own, id, n, places);
      Chosen pulled(n);
      for (std::size_t k = 0; k < n; k += group) {
        const Places& at = places[k / group];
        Vectors& vector = vectors[k / group];
        for (int p = 0; p < parts; ++p) {
          const std::uint32_t* const part = id + k + p * W;
          const Near b(v, part);
          Real d[3], dv[3], gradient[3];
          for (int e = 0; e < 3; ++e) {
            d[e] = core::load<Real>(at.d[e] + p * W);
            dv[e] = b.flow[e] - Real(a.v[e]);
          }
          const Real slope = core::load<Real>(at.slope + p * W), approach = core::load<Real>(at.approach + p * W);
          const Real mu = dot(dv, d) * approach, spread = load_one<at_spread>(v, part);
          const Yes same = b.of_body(a.body);
          const Real m_pi = a_firm ? firm_viscosity(v, s, a, part, b, spread, mu, d, approach, same) : viscosity(s, a, b, spread, mu);
          const Real push = m_pi * slope, weight = b.volume() * slope;
          for (int e = 0; e < 3; ++e) {
            viscous[e].part[p] += push * d[e];
            gradient[e] = weight * d[e];
          }
          if (core::any(!same)) {
            const Real pressure = Real(a.p_contact) + load_one<at_contact>(v, part);
            const Yes behind = b.of_body(wall_body);
            for (int e = 0; e < 3; ++e) {
              const Real squeezed = core::select(same, Real(0.0), pressure * gradient[e]);
              contact[e].part[p] += squeezed;
              wall[e].part[p] += core::select(behind, Real(a.volume) * squeezed + Real(a.m) * (push * d[e]), Real(0.0));
              gradient[e] = core::select(same, gradient[e], Real(0.0));
            }
          }
          for (int e = 0; e < 3; ++e) {
            gradients[e].part[p] += gradient[e];
            core::store(vector.g[e] + p * W, gradient[e]);
          }
          const Yes close = crowded(core::load<Real>(at.q + p * W));
          pulled.add(k + p * W, a_pulls ? close : close & b.in_tension());
        }
      }
      stress.add(v, id, n, vectors);
      pulled.each(n, [&](std::size_t k) {
        const auto& g = vectors[k / group].g;
        const double weight = artificial_weight(places[k / group].q[k % group]);
        double w[3], push[3];
        for (int e = 0; e < 3; ++e) {
          w[e] = weight * g[e][k % group];
          weighted[e] += w[e];
        }
        const Actor& b = v.actor[id[k]];
        if (!b.tension) return;
        apply_symmetric(b.artificial.data(), b.artificial_yy, w, push);
        for (int e = 0; e < 3; ++e) pushed[e] += push[e];
      });
    });
    double sum[3], others[3], own_force[3];
    for (int d = 0; d < 3; ++d) sum[d] = gradients[d].total();
    stress.total(others);
    apply_stress(a, sum, own_force);
    if (a_pulls) {
      double push[3];
      apply_symmetric(a.artificial.data(), a.artificial_yy, weighted, push);
      for (int d = 0; d < 3; ++d) own_force[d] += push[d];
    }
    for (int d = 0; d < 3; ++d) {
      to.all[d] = a.volume * ((own_force[d] + (others[d] + pushed[d])) - contact[d].total()) - a.m * viscous[d].total();
      to.wall[d] = -wall[d].total();
    }
  }
}

void pair_work(const PairView& v, const ParticleSettings& s, std::size_t first, std::size_t last, RowWork* work) {
  Places places[most_groups];
  for (std::size_t i = first; i < last; ++i) {
    RowWork& to = work[i - first];
    to = {};
    if (v.n_near[i] == 0) continue;
    const Own own(v.actor[i]);
    const Actor& a = own.a;
    const bool a_firm = a.firm > 0;
    Sum stressed, viscous, rate[3][3], fastest;
    double pushed = 0;
    each_piece<false>(v, i, own, [&](const std::uint32_t* id, std::size_t n) __attribute__((always_inline)) {
      fetch_lines<1, 1>(v, id, n);
      if (a_firm) fetch_lines<4, 4>(v, id, n);
      find_places(v, own, id, n, places);
      Chosen pulled(n);
      for (std::size_t k = 0; k < n; k += group) {
        const Places& at = places[k / group];
        for (int p = 0; p < parts; ++p) {
          const std::uint32_t* const part = id + k + p * W;
          const Near b(v, part);
          Real end[4];  // v_new, shear switch
          load_four<at_v_new>(v, part, end);
          Real d[3], dv_old[3], dv[3], dv_sum[3];
          for (int e = 0; e < 3; ++e) {
            d[e] = core::load<Real>(at.d[e] + p * W);
            dv_old[e] = b.flow[e] - Real(a.v[e]);
            dv[e] = end[e] - Real(a.v_new[e]);
            dv_sum[e] = dv_old[e] + dv[e];  // twice the mean
          }
          const Real approach = core::load<Real>(at.approach + p * W), slope = core::load<Real>(at.slope + p * W);
          const Real closing_old = dot(dv_old, d), closing = dot(dv, d), closing_sum = closing_old + closing;
          const Real mu = closing * approach;
          const Real mu_old = closing_old * approach;
          const Yes same = b.of_body(a.body);
          const Real m_pi = a_firm ? firm_viscosity(v, s, a, part, b, end[3], mu_old, d, approach, same) : viscosity(s, a, b, end[3], mu_old);
          viscous.part[p] += m_pi * slope * closing_sum;
          fastest.part[p] = core::max(fastest.part[p], mu);
          Real traction[3];
          apply_stress(a, d, traction);
          const Real volume_slope = b.volume() * slope;
          Real power = dot(traction, dv_sum), weight = volume_slope;
          if (core::any(!same)) {
            power = core::select(same, power, -(Real(a.p_contact) * closing_sum));
            // a stranger that recedes leaves no tension behind: nothing would have paid for it
            if (!(a.p_contact > 0)) weight = core::select(same | (mu > Real(0.0)), weight, Real(0.0));
          }
          stressed.part[p] += volume_slope * power;
          if (a.tension) pulled.add(k + p * W, same & crowded(core::load<Real>(at.q + p * W)));
          for (int e = 0; e < 3; ++e) {
            const Real volume_speed = weight * dv[e];
            for (int c = 0; c < 3; ++c) rate[e][c].part[p] += volume_speed * d[c];
          }
        }
      }
      if (!a.tension) return;
      pulled.each(n, [&](std::size_t k) {
        const Places& at = places[k / group];
        const std::size_t l = k % group;
        const Actor& b = v.actor[id[k]];
        double dv_sum[3], push[3];
        const double d[3] = {at.d[0][l], at.d[1][l], at.d[2][l]};
        for (int e = 0; e < 3; ++e) dv_sum[e] = (b.v[e] - a.v[e]) + (b.v_new[e] - a.v_new[e]);
        apply_symmetric(a.artificial.data(), a.artificial_yy, d, push);
        pushed += (b.volume * at.slope[l]) * artificial_weight(at.q[l]) * dot(push, dv_sum);
      });
    });
    to.power = 0.25 * (a.m * viscous.total()) - 0.5 * (a.volume * (stressed.total() + pushed));
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
    for (std::size_t n = 0; n < 4 * group * n_anchors; ++n) anchors.scratch[n] = 0;  // of each anchor: weights, force x, y, z
    const Own own(v.actor[i]);
    each_piece<false>(v, i, own, [&](const std::uint32_t* ids, std::size_t n_ids) __attribute__((always_inline)) {
      for (const std::uint32_t* id = ids; id < ids + n_ids; id += group)
        for (int p = 0; p < parts; ++p) {
          const std::uint32_t* const part = id + p * W;
          const Geometry g = geometry(v, own, part);
          const Near b(v, part);
          PairForce f;
          pair_force(v, s, own, part, b, g, f);
          double* lanes = anchors.scratch + p * W;
          weigh_anchors(anchors, k, own, b, g, lanes);
          for (std::size_t n = 0; n < n_anchors; ++n, lanes += 4 * group) {
            const Real weight = core::load<Real>(lanes);
            for (int d = 0; d < 3; ++d) {
              double* sum = lanes + group * (d + 1);
              core::store(sum, core::load<Real>(sum) + weight * ((f.own[d] + f.other[d]) + f.viscous[d]));
            }
          }
        }
    });
    for (std::size_t n = 0; n < n_anchors; ++n)
      for (int d = 0; d < 3; ++d) force[n][d] = total(anchors.scratch + 4 * group * n + group * (static_cast<std::size_t>(d) + 1));
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
    each_piece<false>(v, i, own, [&](const std::uint32_t* ids, std::size_t n_ids) __attribute__((always_inline)) {
      for (const std::uint32_t* id = ids; id < ids + n_ids; id += group)
        for (int p = 0; p < parts; ++p) {
          const std::uint32_t* const part = id + p * W;
          const Geometry g = geometry(v, own, part);
          const Near b(v, part);
          PairForce f;
          pair_force(v, s, own, part, b, g, f);
          Real end[4];  // v_new, shear switch
          load_four<at_v_new>(v, part, end);
          weigh_anchors(anchors, k, own, b, g, anchors.scratch);
          Real at_anchors[3] = {Real(0.0), Real(0.0), Real(0.0)};
          for (std::size_t n = 0; n < n_anchors; ++n)
            for (int d = 0; d < 3; ++d)
              at_anchors[d] += core::load<Real>(anchors.scratch + 4 * group * n) * Real(anchors.v_mean[anchors.start[k] + n][d]);
          // what the particle does not book of the pair's work: its force acts on the anchors, not at the centre
          Real all[3], booked[3], from_anchors[3], from_centre[3];
          for (int d = 0; d < 3; ++d) {
            all[d] = (f.own[d] + f.other[d]) + f.viscous[d];
            booked[d] = f.other[d] + Real(0.5) * f.viscous[d];
            const Real mean = Real(0.5) * (b.flow[d] + end[d]);
            from_anchors[d] = at_anchors[d] - mean;
            from_centre[d] = Real(0.5 * (own.a.v[d] + own.a.v_new[d])) - mean;
          }
          sum.part[p] += dot(all, from_anchors) - dot(booked, from_centre);
        }
    });
    power[i - first] = sum.total();
  }
}

}  // namespace sph::EJECTA_ISA
