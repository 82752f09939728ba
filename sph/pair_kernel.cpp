// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set (CMakeLists.txt); see pair_kernel.hpp for what it does.
#include "sph/pair_kernel.hpp"

#include "core/isa.hpp"
#include "sph/kernel.hpp"
#include "sph/lanes.hpp"
#include "sph/particle_forces.hpp"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 on its own AVX-512 header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace sph::EJECTA_ISA {
namespace {

static_assert(sizeof(Place) == 32 && sizeof(Flow) == 32 && sizeof(Strain) == 32, "rows as load_rows() reads them");

template <class T>
inline T dot(const T* a, const T* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Vectors of sixteen neighbours, in double and rounded.
struct Vectors {
  Doubles exact[2][3];
  Singles rounded[3];

  /// Own minus theirs; theirs in columns of load_rows().
  [[gnu::always_inline]] void set(const core::Vec3& own, const Doubles theirs[2][4]) {
    for (int e = 0; e < 3; ++e) {
      for (int half = 0; half < 2; ++half) exact[half][e] = Doubles(own[e]) - theirs[half][e];
      rounded[e] = narrow(exact[0][e], exact[1][e]);
    }
  }
};

/// Calls f(half) for singles 0 to 7 and 8 to 15, the half as a constant.
template <class F>
[[gnu::always_inline]] inline void each_half(F&& f) {
  f(std::integral_constant<int, 0>{});
  f(std::integral_constant<int, 1>{});
}

/// A sum of vectors.
struct VectorSum {
  Doubles sum[3] = {0.0, 0.0, 0.0};
  void add(Doubles weight, const Doubles d[3]) {
    for (int e = 0; e < 3; ++e) sum[e] += weight * d[e];
  }
  [[gnu::always_inline]] void add(Singles weight, const Vectors& d) {
    each_half([&](auto half) { add(widen<half>(weight), d.exact[half]); });
  }
  void total(double* to) const {
    for (int e = 0; e < 3; ++e) to[e] = EJECTA_ISA::total(sum[e]);
  }
};

// ------------------------------------------------------------------------------------------------- who is near

/// V_i V_j (dW/dr)/r in units of unit^3 (sph/kernel.hpp), nothing out of reach. The same when i and j change places.
[[gnu::always_inline]] inline Singles pair_weight(Singles volumes, Singles r2, Singles reach, float unit) {
  const Singles inverse = Singles(1.0f) / reach, l = Singles(unit) * inverse;
  const Singles u = max(Singles(1.0f) - sqrt(r2) * inverse, Singles(0.0f));
  return (volumes * (Singles(static_cast<float>(kernel_slope_factor)) * (u * u * u))) * ((l * l * l) * (inverse * inverse));
}

/// Sixteen pairs of a row, and how many are left from here on.
struct NearGroup {
  std::uint32_t* id;
  float* weight;
  float* push;
  float* pull = nullptr;  ///< of rows where artificial stress acts
  std::size_t left;
  NearGroup(const PairView& v, std::size_t i) : left(v.n_near[i]) {
    const std::uint64_t k = v.near_start[i];
    id = v.near[k].at, weight = v.weight[k].at, push = v.push[k].at;
  }
  /// For what keeps or reads artificial stress.
  void find_pull(const PairView& v, std::size_t i) { pull = v.pull[v.pull_start[i]].at; }
  /// Those that are not the row itself.
  std::size_t count() const { return left < group ? left : group; }
  void advance() {
    id += group, weight += group, push += group, left -= count();
    if (pull) pull += group;
  }
};

// --------------------------------------------------------------------------------------------------------- physics

struct Own {
  const Place& place;
  const Flow& flow;
  const Strain& strain;
  Kind kind;
  Own(const PairView& v, std::size_t i) : place(v.place[i]), flow(v.flow[i]), strain(v.strain[i]), kind(v.kind[i]) {}
  /// Which neighbours are of its body.
  Yes same(Ints kinds) const { return (kinds & Ints(body_bits)) == Ints(kind & body_bits); }
};
inline Yes has(Ints kinds, Kind bit) { return (kinds & Ints(bit)) == Ints(bit); }

/// d . D d of a strain rate (xx yy zz xy yz zx); `dd` are the products of d's components, mixed ones twice.
template <class T>
[[gnu::always_inline]] inline Singles stretch_along(const T* rate, const Singles* dd) {
  return ((Singles(rate[0]) * dd[0] + Singles(rate[1]) * dd[1]) + (Singles(rate[2]) * dd[2] + Singles(rate[3]) * dd[3])) +
         (Singles(rate[4]) * dd[4] + Singles(rate[5]) * dd[5]);
}

/// Where sixteen neighbours stand to their row and how they approach it, for the loops that follow: short loops of their own
/// keep the processor busy with several groups at a time.
struct alignas(64) Meeting {
  Vectors d;
  Singles r2, reach;  ///< reach = 2 h of the pair
  Singles approach;   ///< mu is this times how fast their distance shrinks: h / (r^2 + 0.01 h^2)
  Singles mu;         ///< of the viscosity, positive where a pair approaches [m/s]
  Singles c, rho;     ///< sums of both

  [[gnu::always_inline]] void place(const PairView& v, const Own& own, const std::uint32_t* id) {
    Doubles x[2][4];
    Singles h, volume;
    load_rows(v.place, id, x, h, volume);
    d.set(own.place.x, x);
    r2 = dot(d.rounded, d.rounded);
    reach = Singles(own.place.h) + h;
    approach = (Singles(0.5f) * reach) / (r2 + Singles(0.0025f) * (reach * reach));
  }
  [[gnu::always_inline]] void flow(const PairView& v, const Own& own, const std::uint32_t* id) {
    Doubles u[2][4];
    load_rows(v.flow, id, u, c, rho);
    Vectors dv;
    dv.set(own.flow.v, u);
    mu = Singles(0.0f) - dot(dv.rounded, d.rounded) * approach;
    c = Singles(own.flow.c) + c;
    rho = Singles(own.flow.rho) + rho;
  }
};

/// m_i m_j Pi (dW/dr)/r of Monaghan's viscosity, in units of unit^3 and zero for plain pairs that part. Between firm neighbours
/// of one body the linear part leaves out what the strain rates explain, and hourglass control damps what they do not.
template <bool firm_row>
[[gnu::always_inline]] inline Singles viscous_push(const ParticleSettings& s, const Own& own, const Meeting& pair, const Singles* strain, Singles weight,
                                                   Yes firm) {
  const Singles closing = max(pair.mu, Singles(0.0f));
  const Singles alpha = Singles(static_cast<float>(0.5 * s.viscosity_linear)) * (Singles(own.strain.spread) + strain[7]);  // four times the product of means
  Singles linear = alpha * closing;
  if constexpr (firm_row) {
    const Singles* const d = pair.d.rounded;
    const Singles twice[3] = {d[0] + d[0], d[1] + d[1], d[2] + d[2]};
    const Singles dd[6] = {d[0] * d[0], d[1] * d[1], d[2] * d[2], twice[0] * d[1], twice[1] * d[2], twice[2] * d[0]};
    const Singles mine = pair.approach * stretch_along(own.strain.rate.data(), dd), theirs = pair.approach * stretch_along(strain, dd);
    const Singles both = mine + theirs, product = mine * theirs;
    // van Leer's limiter: the harmonic mean where the signs agree
    const Yes agree = Singles(0.0f) < product;
    const Singles limited = select(agree, (product + product) / select(agree, both, Singles(1.0f)), Singles(0.0f));
    const Singles unexplained = min(max(pair.mu + limited, Singles(0.0f)), closing);
    const Singles hourglass = Singles(static_cast<float>(s.hourglass)) * (pair.mu + Singles(0.5f) * both);
    linear = select(firm, alpha * unexplained + hourglass, linear);
  }
  const Singles densities = (Singles(own.strain.density) * strain[6]) / pair.rho;
  return ((pair.c * linear + Singles(static_cast<float>(2.0 * s.viscosity_quadratic)) * (closing * closing)) * densities) * weight;
}

/// The same of one group, from and to its numbers.
[[gnu::always_inline]] inline void find_push(const PairView& v, const ParticleSettings& s, const Own& own, const Meeting& pair, const NearGroup& near,
                                             Ints kinds, Yes same) {
  Singles strain[8];
  load_rows(v.strain, near.id, strain);
  const Singles weight = Singles::load(near.weight);
  if (own.kind & firm_bit)
    viscous_push<true>(s, own, pair, strain, weight, same & has(kinds, firm_bit)).store(near.push);
  else
    viscous_push<false>(s, own, pair, strain, weight, same).store(near.push);
}

/// r / h
template <class T>
inline T separation(T r2, T reach) { return (sqrt(r2) + sqrt(r2)) / reach; }

/// Pairs closer than the regular spacing: few, and the only ones in which artificial stress acts.
constexpr float crowded = static_cast<float>(1 / h_over_spacing);

/// Gray's factor of the artificial stress in a crowded pair: nothing at the regular spacing, where it would only weaken the
/// matter; held where pairs nearly meet, so that it takes most of a pull but makes no push of it: a point in tension would be
/// driven apart, the harder the more it expands.
template <class T>
T artificial_weight(T q) {
  const T w = kernel_over_spacing(q), w2 = w * w;
  return min(max(w2 * w2 - T(1.0f), T(0.0f)), T(static_cast<float>(0.9 / ParticleSettings{}.artificial_stress)));
}

inline Four load_four(const double* a) { return load_register<Four>(a); }
inline Four column(const Stress& s, int c) {
#if defined(__AVX2__)
  return (Four)_mm256_cvtps_pd(_mm_load_ps(s.column[c]));
#else
  return Four{s.column[c][0], s.column[c][1], s.column[c][2], 0};
#endif
}

/// A row's crowded pairs.
template <std::size_t groups>
struct Crowd {
  std::size_t n = 0;
  alignas(64) std::uint32_t place[groups * group + group];  ///< in the row
  alignas(64) float r2[groups * group + group], reach[groups * group + group];
  alignas(64) float weight[groups * group + group];  ///< of the pair, then times Gray's factor

  [[gnu::always_inline]] void add(unsigned bits, std::size_t k, const Meeting& pair, Singles pair_weight) {
    if (bits == 0) return;
    store_some(r2 + n, bits, pair.r2, true);
    store_some(reach + n, bits, pair.reach, true);
    store_some(weight + n, bits, pair_weight, true);
    for (; bits != 0; bits &= bits - 1) place[n++] = static_cast<std::uint32_t>(k * group) + static_cast<std::uint32_t>(__builtin_ctz(bits));
  }
  [[gnu::always_inline]] void weigh() {
    for (std::size_t k = 0; k < n; k += group)
      (Singles::load(weight + k) * artificial_weight(separation(Singles::load(r2 + k), Singles::load(reach + k)))).store(weight + k);
  }
};

/// The sum of neighbours' stresses on vectors: the stresses stay in their rows, a column to four lanes, and the vectors come
/// one by one.
struct StressSum {
  Four part[3] = {Four{}, Four{}, Four{}};
  [[gnu::always_inline]] void add(const Stress& s, double x, double y, double z) {
    part[0] += column(s, 0) * all(x);
    part[1] += column(s, 1) * all(y);
    part[2] += column(s, 2) * all(z);
  }
  void total(double* f) const {
    const Four a = (part[0] + part[1]) + part[2];
    for (int e = 0; e < 3; ++e) f[e] = a[e];
  }
};
inline void apply_stress(const Stress& s, const double* g, double* out) {
  for (int e = 0; e < 3; ++e) out[e] = double(s.column[0][e]) * g[0] + double(s.column[1][e]) * g[1] + double(s.column[2][e]) * g[2];
}

/// What strangers do to a row. Sums over them and, of those, over images behind rigid walls: of weight times d, the same times
/// their pressure, and viscosity.
struct Contact {
  VectorSum weighted, pressed, weighted_wall, pressed_wall, viscous_wall;
  bool met = false, wall_met = false;

  [[gnu::always_inline]] void add(const PairView& v, const std::uint32_t* id, Ints kinds, Yes same, Singles weight, Singles push, const Vectors& d) {
    met = true;
    const Singles p = load_at<Singles>(v.p_contact, id), none(0.0f), theirs = select(same, none, weight);
    add(theirs, p, d, weighted, pressed);
    const Yes wall = kinds < Ints(0);
    if (!any(wall)) return;
    wall_met = true;
    add(select(wall, weight, none), p, d, weighted_wall, pressed_wall);
    viscous_wall.add(select(wall, push, none), d);
  }
  /// Own pressure on one sum and theirs in the other.
  static void force(const VectorSum& weighted, const VectorSum& pressed, double p, double* f) {
    double own[3], other[3];
    weighted.total(own), pressed.total(other);
    for (int e = 0; e < 3; ++e) f[e] = p * own[e] + other[e];
  }

 private:
  [[gnu::always_inline]] static void add(Singles weight, Singles p, const Vectors& d, VectorSum& weighted, VectorSum& pressed) {
    each_half([&](auto half) {
      const Doubles w = widen<half>(weight);
      weighted.add(w, d.exact[half]);
      pressed.add(w * widen<half>(p), d.exact[half]);
    });
  }
};
static_assert(kind_of_body(wall_body) + (firm_bit | tension_bit) < 0, "no kind but the walls' is negative");

/// A foreigner's group: whose forces act on its anchors (1) and whose at its place (0), weights of strangers, and where.
struct ForeignGroup {
  Meeting pair;
  Singles anchored, contact;
  Ints kinds;
  [[gnu::always_inline]] ForeignGroup(const PairView& v, const Own& own, const NearGroup& near) {
    pair.place(v, own, near.id);
    kinds = load_at<Ints>(v.kind, near.id);
    const Yes same = own.same(kinds);
    const Singles all = Singles::load(near.weight), none(0.0f);
    anchored = select(same, Singles(1.0f), none);
    contact = select(same, none, all);
  }
};

/// What j's stress makes of the force on foreigner i, over unit^3.
[[gnu::always_inline]] inline Four force_of_other(const PairView& v, std::size_t i, const NearGroup& near, std::size_t l) {
  const std::uint32_t j = near.id[l];
  const Four d = load_four(v.place[i].x.data()) - load_four(v.place[j].x.data()), g = all(double(near.weight[l])) * d;
  if (!kin(v.kind[i], v.kind[j])) return all(-double(v.p_contact[j])) * g;
  StressSum sum;
  sum.add(v.stress[j], g[0], g[1], g[2]);
  return (sum.part[0] + sum.part[1]) + sum.part[2];
}

/// Does any pair of a foreigner's group press or pull? Powder that lies at its seam does not.
inline bool bears(const PairView& v, const Own& own, const NearGroup& near) {
  for (std::size_t l = 0, n = near.count(); l < n; ++l)
    if (const std::uint32_t j = near.id[l]; !kin(own.kind, v.kind[j]) || near.push[l] != 0 || v.stress[j].most() != 0) return true;
  return false;
}

/// Forces of half of a foreigner's group on it [N]: the same bits as in the particles' rows.
template <int half>
[[gnu::always_inline]] inline void pair_force(const PairView& v, std::size_t i, const NearGroup& near, const ForeignGroup& at, Doubles f[3]) {
  const Doubles scale(v.unit * v.unit * v.unit), p(double(v.p_contact[i]));
  const Doubles* const d = at.pair.d.exact[half];
  const Doubles anchored = widen<half>(at.anchored), contact = widen<half>(at.contact), push = widen<half>(Singles::load(near.push));
  alignas(64) Four rows[8];
  for (std::size_t l = 0; l < 8; ++l) rows[l] = 8 * half + l < near.left ? force_of_other(v, i, near, 8 * half + l) : Four{};
  constexpr std::uint32_t in_order[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  Doubles other[4];
  load_columns(rows, in_order, other);
  for (int e = 0; e < 3; ++e) {
    const Doubles own = scale * (anchored * other[e] - p * (contact * d[e]));  // stands for the own stress: theirs once more among kin, the own pressure among strangers
    f[e] = (own + scale * other[e]) - scale * (push * d[e]);
  }
}

/// Adds the part of images behind rigid walls, over half of a foreigner's group.
template <int half>
inline void add_wall_force(const ForeignGroup& at, const Doubles f[3], core::Vec3& wall) {
  const Yes behind = at.kinds < Ints(0);
  if (!any(behind)) return;
  const unsigned bits = behind.bits() >> (8 * half);
  for (int e = 0; e < 3; ++e) {
    alignas(64) double lanes[8];
    f[e].store(lanes);
    for (int l = 0; l < 8; ++l)
      if (bits >> l & 1) wall[e] += lanes[l];
  }
}

/// Weights of a foreigner's anchors in its pairs with eight particles, into scratch, anchor_scratch doubles an anchor: they
/// add up to one. What strangers push acts at the centre.
template <int half>
inline void weigh_anchors(const AnchorView& anchors, std::size_t i, const ForeignGroup& at, double* scratch) {
  const std::size_t row = i - anchors.n_particles, centre = anchors.start[row + 1] - anchors.start[row] - 1;
  if (centre == 0) return Doubles(1.0).store(scratch);
  const core::Vec3* const xi = anchors.xi + anchors.start[row];
  const Frame& frame = anchors.frame[row];
  const Doubles* const d = at.pair.d.exact[half];
  Doubles middle[3], sum(0.0);
  for (int e = 0; e < 3; ++e) {
    const auto& g = frame.per_x;
    middle[e] = Doubles(frame.xi[e]) - Doubles(0.5) * ((Doubles(g(e, 0)) * d[0] + Doubles(g(e, 1)) * d[1]) + Doubles(g(e, 2)) * d[2]);
  }
  for (std::size_t n = 0; n < centre; ++n) {
    Doubles off[3];
    for (int e = 0; e < 3; ++e) off[e] = Doubles(xi[n][e]) - middle[e];
    const Doubles weight = anchor_weight(dot(off, off));
    weight.store(scratch + anchor_scratch * n);
    sum += weight;
  }
  const Doubles anchored = widen<half>(at.anchored), share = anchored / sum;
  for (std::size_t n = 0; n < centre; ++n) (Doubles::load(scratch + anchor_scratch * n) * share).store(scratch + anchor_scratch * n);
  (Doubles(1.0) - anchored).store(scratch + anchor_scratch * centre);
}

/// Asks for the stresses of neighbours while their viscosity is worked out.
[[gnu::always_inline]] inline void fetch_stress(const PairView& v, const std::uint32_t* id) {
  for (std::size_t l = 0; l < group; ++l) __builtin_prefetch(v.stress + id[l]);
}

/// Over who is near alone, in their order: the same bits whatever else the list holds.
inline Moment moment_of(const PairView& v, std::size_t i) {
  const Four own = load_four(v.place[i].x.data());
  Four pure{}, mixed{};
  for (NearGroup near(v, i); near.left > 0; near.advance()) {
    alignas(64) double weight[group];
    each_half([&](auto half) { widen<half>(Singles::load(near.weight)).store(weight + 8 * half); });
    for (std::size_t l = 0, n = near.count(); l < n; ++l) {
      const Four d = own - load_four(v.place[near.id[l]].x.data()), weighted = all(weight[l]) * d;
      pure += weighted * d;
      mixed += weighted * __builtin_shufflevector(d, d, 1, 2, 0, 3);
    }
  }
  const double scale = -1 / double(v.place[i].volume);
  return {{scale * pure[0], scale * pure[1], scale * pure[2], scale * mixed[0], scale * mixed[1], scale * mixed[2]}};
}

/// Asks for the list of a row, and for where those of it that are near go.
[[gnu::always_inline]] inline void fetch_row(const PairView& v, std::size_t i) {
  constexpr int written = 1;
  for (std::uint64_t k = v.start[i]; k < v.start[i + 1]; k += group) __builtin_prefetch(v.list + k);
  for (std::uint64_t k = v.near_start[i]; k < v.near_start[i + 1]; ++k) {
    __builtin_prefetch(v.near + k, written);
    __builtin_prefetch(v.weight + k, written);
  }
}

}  // namespace

void find_near(const PairView& v, std::size_t first, std::size_t last, Moment* moment) {
  constexpr std::size_t ahead = 2;
  for (std::size_t i = first; i < last; ++i) {
    if (i + ahead < last) fetch_row(v, i + ahead);
    const Place& own = v.place[i];
    const std::uint64_t end = v.start[i + 1];
    const NearGroup row(v, i);
    const std::uint64_t room = group * (v.near_start[i + 1] - v.near_start[i]);
    std::uint32_t n = 0;
    for (std::uint64_t k = v.start[i]; k < end; k += group) {
      alignas(64) std::uint32_t id[group];
      load_some(v.list + k, end - k, static_cast<std::uint32_t>(i), id);
      Doubles x[2][4];
      Singles h, volume;
      load_rows(v.place, id, x, h, volume);
      Vectors d;
      d.set(own.x, x);
      const Singles r2 = dot(d.rounded, d.rounded), reach = Singles(own.h) + h;
      static_assert(kernel_reach == 2.0);
      unsigned bits = (r2 < reach * reach).bits();
      if (end - k < group) bits &= (1u << (end - k)) - 1;
      const Singles weight = pair_weight(Singles(own.volume) * volume, r2, reach, static_cast<float>(v.unit));
      const std::uint32_t before = n;
      n += static_cast<std::uint32_t>(__builtin_popcount(bits));
      if (n > room) continue;
      const bool roomy = before + group <= room;
      store_some(row.id + before, bits, id, roomy);
      store_some(row.weight + before, bits, weight, roomy);
    }
    v.n_near[i] = n;
    if (n > room) {
      if (moment) moment[i - first] = {};
      continue;
    }
    for (; n % group != 0; ++n) row.id[n] = static_cast<std::uint32_t>(i), row.weight[n] = 0;
    if (moment) moment[i - first] = moment_of(v, i);
  }
}

void find_strangers(const PairView& v, std::size_t first, std::size_t last, core::Vec3* towards) {
  for (std::size_t i = first; i < last; ++i) {
    core::Vec3& sum = towards[i - first] = core::Vec3::Zero();
    const Own own(v, i);
    for (NearGroup near(v, i); near.left > 0; near.advance()) {
      const unsigned strange = (!own.same(load_at<Ints>(v.kind, near.id))).bits() & ((1u << near.count()) - 1);
      for (unsigned left = strange; left != 0; left &= left - 1) {
        const int l = __builtin_ctz(left);
        sum += double(near.weight[l]) * (own.place.x - v.place[near.id[l]].x);
      }
    }
  }
}

namespace {

constexpr std::size_t at_once = 8;  ///< groups that go through each of the loops of pair_forces() in turn

/// A piece of a row on its way through those loops.
struct Piece {
  std::size_t n;  ///< groups
  Meeting pair[at_once];
  Ints kinds[at_once];
  Crowd<at_once> crowd;
};

/// Sums of a row's forces, over unit^3. Stress on the sum of weight times d is what the row's own stress adds to the force:
/// V_i sigma_i sum_j V_j grad W.
struct ForceSums {
  StressSum stress;              ///< the neighbours', on weight times d
  VectorSum gradients, viscous;  ///< of weight times d among kin, of push times d
  double weighted[3] = {};       ///< of weight times Gray's factor times d, if the own artificial stress acts
  double again[3] = {};          ///< of weight times d among kin that are foreign
  Contact contact;
  Singles fastest = 0.0f;
  bool anchored = false;

  /// In pairs with foreigners the own stress acts in place of theirs too: their nodes answer with it.
  void take_twice(const Own& own, Ints kinds, unsigned foreign, double (&g)[3][group]) {
    anchored |= (foreign & own.same(kinds).bits()) != 0;
    for (int e = 0; e < 3; ++e)
      for (unsigned left = foreign; left != 0; left &= left - 1) {
        double& at = g[e][__builtin_ctz(left)];
        again[e] += at;
        at = 0;
      }
  }
};

/// Viscosity of a piece that begins at `near`.
[[gnu::always_inline]] inline void find_viscosity(const PairView& v, const ParticleSettings& s, const Own& own, NearGroup near, Piece& piece) {
  for (std::size_t k = 0; k < piece.n; ++k) piece.pair[k].place(v, own, near.id + group * k);
  for (std::size_t k = 0; k < piece.n; ++k) piece.pair[k].flow(v, own, near.id + group * k);
  for (std::size_t k = 0; k < piece.n; ++k, near.advance()) {
    fetch_stress(v, near.id);
    piece.kinds[k] = load_at<Ints>(v.kind, near.id);
    find_push(v, s, own, piece.pair[k], near, piece.kinds[k], own.same(piece.kinds[k]));
  }
}

/// Group k of a piece, all but artificial stress: that of crowded pairs is left in piece.crowd.
[[gnu::always_inline]] inline void add_group(const PairView& v, const Own& own, const NearGroup& near, Piece& piece, std::size_t k, ForceSums& sums) {
  const Meeting& pair = piece.pair[k];
  const Vectors& d = pair.d;
  const Ints kinds = piece.kinds[k];
  const Yes same = own.same(kinds);
  const Singles weight = Singles::load(near.weight), push = Singles::load(near.push);
  sums.fastest = max(sums.fastest, pair.mu);
  Singles kin = weight;
  if (any(!same)) {
    kin = select(same, weight, Singles(0.0f));
    sums.contact.add(v, near.id, kinds, same, weight, push, d);
  }
  alignas(64) double g[3][group];
  each_half([&](auto half) {
    sums.viscous.add(widen<half>(push), d.exact[half]);
    const Doubles w = widen<half>(kin);
    for (int e = 0; e < 3; ++e) {
      const Doubles product = w * d.exact[half][e];
      product.store(g[e] + 8 * half);
      sums.gradients.sum[e] += product;
    }
  });
  const std::size_t count = near.count();
  const Yes of_elements = has(kinds, foreign_bit);
  if (const unsigned foreign = of_elements.bits() & ((1u << count) - 1)) sums.take_twice(own, kinds, foreign, g);
  for (std::size_t l = 0; l < count; ++l) sums.stress.add(v.stress[near.id[l]], g[0][l], g[1][l], g[2][l]);

  Yes pulled = same & !of_elements & (Singles(4.0f) * pair.r2 < Singles(crowded * crowded) * (pair.reach * pair.reach));
  if (near.pull)
    Singles(0.0f).store(near.pull);
  else
    pulled = pulled & has(kinds, tension_bit);
  piece.crowd.add(pulled.bits() & ((1u << count) - 1), k, pair, weight);
}

/// Artificial stress of the crowded pairs of a piece that begins at `near`.
[[gnu::always_inline]] inline void add_crowd(const PairView& v, const Own& own, const NearGroup& near, Piece& piece, ForceSums& sums) {
  piece.crowd.weigh();
  for (std::size_t c = 0; c < piece.crowd.n; ++c) {
    const std::uint32_t at = piece.crowd.place[c], j = near.id[at];
    const double w = double(piece.crowd.weight[c]);
    double g[3];
    for (int e = 0; e < 3; ++e) g[e] = w * (own.place.x[e] - v.place[j].x[e]);
    if (v.kind[j] & tension_bit) sums.stress.add(v.artificial[j], g[0], g[1], g[2]);
    if (!near.pull) continue;
    near.pull[at] = piece.crowd.weight[c];
    for (int e = 0; e < 3; ++e) sums.weighted[e] += g[e];
  }
}

void finish(const PairView& v, std::size_t i, const ForceSums& sums, RowForce& to) {
  const double scale = v.unit * v.unit * v.unit, p = double(v.p_contact[i]);
  double sum[3], others[3], own[3], pulled[3] = {}, viscosity[3], contact[3] = {};
  sums.gradients.total(sum);
  for (int e = 0; e < 3; ++e) sum[e] += sums.again[e];
  sums.stress.total(others);
  sums.viscous.total(viscosity);
  apply_stress(v.stress[i], sum, own);
  if (v.kind[i] & tension_bit) apply_stress(v.artificial[i], sums.weighted, pulled);
  if (sums.contact.met) Contact::force(sums.contact.weighted, sums.contact.pressed, p, contact);
  for (int e = 0; e < 3; ++e) to.all[e] = scale * (((own[e] + pulled[e]) + others[e]) - (viscosity[e] + contact[e]));
  to.approach = double(greatest(sums.fastest));
  if (!sums.contact.wall_met) return;
  Contact::force(sums.contact.weighted_wall, sums.contact.pressed_wall, p, contact);
  sums.contact.viscous_wall.total(viscosity);
  for (int e = 0; e < 3; ++e) to.wall[e] = -scale * (contact[e] + viscosity[e]);
}

}  // namespace

void pair_forces(const PairView& v, const ParticleSettings& s, std::size_t first, std::size_t last, RowForce* force) {
  Piece piece;
  for (std::size_t i = first; i < last; ++i) {
    force[i - first] = {};
    v.mixed[i] = v.anchored[i] = 0;
    if (v.n_near[i] == 0) continue;
    const Own own(v, i);
    ForceSums sums;
    NearGroup near(v, i);
    if (own.kind & tension_bit) near.find_pull(v, i);
    while (near.left > 0) {
      const NearGroup begin = near;
      piece.n = near.left < group * at_once ? (near.left + group - 1) / group : at_once;
      piece.crowd.n = 0;
      find_viscosity(v, s, own, begin, piece);
      for (std::size_t k = 0; k < piece.n; ++k, near.advance()) add_group(v, own, near, piece, k, sums);
      add_crowd(v, own, begin, piece, sums);
    }
    finish(v, i, sums, force[i - first]);
    v.mixed[i] = sums.contact.met;
    v.anchored[i] = sums.anchored;
  }
}

namespace {

/// How fast i and j approach, times their distance, the same seen from both [m2/s].
inline double closing_of(const PairView& v, std::size_t i, std::size_t j) {
  double closing = 0;
  for (int e = 0; e < 3; ++e) closing += (v.motion[j].end[e] - v.motion[i].end[e]) * (v.place[i].x[e] - v.place[j].x[e]);
  return closing;
}

/// Part of their approach by which stranger j gives way to i's pressure. What divides two bodies moves at the difference of their
/// pressures over their acoustic impedance (Godunov, Mat. Sb. 47 (1959) 271): the approach makes a difference of impedance times its
/// speed at most, and what is beyond that moves j rather than strain i. Rigid walls do not give way.
inline double gives_way(const PairView& v, std::size_t i, std::size_t j, double closing) {
  const double over = double(v.p_contact[i]) - double(v.p_contact[j]);
  if (!(over > 0) || !(closing > 0) || v.kind[i] < 0 || v.kind[j] < 0) return 0;
  const double impedance = 0.5 * (double(v.flow[i].rho) * double(v.flow[i].c) + double(v.flow[j].rho) * double(v.flow[j].c));
  double r2 = 0;
  for (int e = 0; e < 3; ++e) {
    const double d = v.place[i].x[e] - v.place[j].x[e];
    r2 += d * d;
  }
  const double made = impedance * closing / __builtin_sqrt(r2);
  return over > made ? 1 - made / over : 0;
}

/// Weights of sixteen pairs in the sums of pair_work().
struct alignas(64) WorkWeights {
  double power[group];  ///< of the row's own stress
  double rate[group];   ///< of the velocity gradient
  double pushed[group] = {};  ///< of the part of it that is not corrected
  double push[group];   ///< of viscosity, and of twice the row's share of what strangers press

  explicit WorkWeights(const NearGroup& near) {
    each_half([&](auto half) {
      const Doubles w = widen<half>(Singles::load(near.weight));
      w.store(power + 8 * half), w.store(rate + 8 * half);
      widen<half>(Singles::load(near.push)).store(push + 8 * half);
    });
  }
  /// Strangers feel pressure alone, without the gradient correction; so the strain they make goes without it too, or a point would be
  /// compressed further than it is paid for. Images behind walls complete the lattice: theirs is corrected.
  void set_strangers(const PairView& v, std::size_t i, const NearGroup& near) {
    for (std::size_t l = 0; l < group; ++l) {
      const std::uint32_t j = near.id[l];
      if (kin(v.kind[i], v.kind[j])) continue;
      const double p = double(v.p_contact[i]), closing = closing_of(v, i, j);
      const double given = gives_way(v, i, j, closing), taken = v.kind[j] & foreign_bit ? 0 : gives_way(v, j, i, closing);
      push[l] += 2 * (p * (1 - given) + double(v.p_contact[j]) * taken) * power[l];
      power[l] = 0;
      // one that recedes leaves no tension behind: nothing would have paid for it
      if (!(p > 0) && !(closing > 0)) rate[l] = 0;
      if (v.kind[j] < 0) continue;
      pushed[l] = rate[l] * (1 - given + taken);
      rate[l] = 0;
    }
  }
};

/// Sums of a row: of dv (x) d by rows of dv, with twice the mean velocities in lanes 0 to 2 and the new ones in 4 to 6; the
/// same in twice the mean velocities alone where artificial stress acts; of push d . dv in those.
struct WorkSums {
  Doubles strain[3] = {0.0, 0.0, 0.0};
  Four pulled[3] = {Four{}, Four{}, Four{}};
  Four pushed[3] = {Four{}, Four{}, Four{}};  ///< of the new velocities of strangers
  Four viscous{};
};

template <bool mixed, bool pulls>
[[gnu::always_inline]] inline WorkSums sum_work(const PairView& v, std::size_t i) {
  const Doubles motion = Doubles::load(v.motion[i].sum), place = twice(v.place[i].x.data());
  WorkSums sums;
  NearGroup near(v, i);
  if constexpr (pulls) near.find_pull(v, i);
  for (; near.left > 0; near.advance()) {
    WorkWeights weights(near);
    if constexpr (mixed) weights.set_strangers(v, i, near);
    for (std::size_t l = 0, n = near.count(); l < n; ++l) {
      const Doubles dv = Doubles::load(v.motion[near.id[l]].sum) - motion, d = place - twice(v.place[near.id[l]].x.data());
      Doubles w(weights.power[l]);
      if constexpr (mixed) w = two_halves(weights.power[l], weights.rate[l]);
      const Doubles weighted = w * d, along[3] = {spread<0>(dv), spread<1>(dv), spread<2>(dv)};
      for (int e = 0; e < 3; ++e) sums.strain[e] += along[e] * weighted;
      if constexpr (mixed) {
        const Four pushed = all(weights.pushed[l]) * first_four(d);
        for (int e = 0; e < 3; ++e) sums.pushed[e] += last_four(along[e]) * pushed;
      }
      sums.viscous += (all(weights.push[l]) * first_four(d)) * first_four(dv);
      if constexpr (pulls) {
        const Four pulled = all(double(near.pull[l])) * first_four(d);
        for (int e = 0; e < 3; ++e) sums.pulled[e] += first_four(along[e]) * pulled;
      }
    }
  }
  return sums;
}

}  // namespace

void pair_work(const PairView& v, std::size_t first, std::size_t last, RowWork* work) {
  const double scale = v.unit * v.unit * v.unit;
  for (std::size_t i = first; i < last; ++i) {
    RowWork& to = work[i - first];
    to = {};
    if (v.n_near[i] == 0) continue;
    const bool pulls = (v.kind[i] & tension_bit) != 0;
    const WorkSums sums = v.mixed[i] ? pulls ? sum_work<true, true>(v, i) : sum_work<true, false>(v, i)
                                     : pulls ? sum_work<false, true>(v, i) : sum_work<false, false>(v, i);
    const double per_volume = 1 / double(v.place[i].volume);
    double power = 0;
    for (int r = 0; r < 3; ++r) {
      alignas(64) double a[8];
      sums.strain[r].store(a);
      for (int c = 0; c < 3; ++c) {
        power += double(v.stress[i].column[c][r]) * a[c];
        if (pulls) power += double(v.artificial[i].column[c][r]) * sums.pulled[r][c];
        to.rate[r][c] = a[4 + c] * per_volume;
        to.pushed[r][c] = sums.pushed[r][c] * per_volume;
      }
    }
    to.power = scale * (0.25 * ((sums.viscous[0] + sums.viscous[1]) + sums.viscous[2]) - 0.5 * power);
  }
}

void foreign_forces(const PairView& v, const ParticleSettings& s, const AnchorView& anchors, std::size_t first,
                    std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t k = i - anchors.n_particles, n_anchors = anchors.start[k + 1] - anchors.start[k];
    core::Vec3* force = anchors.force + anchors.start[k];
    for (std::size_t n = 0; n < n_anchors; ++n) force[n] = core::Vec3(0, 0, 0);
    if (anchors.wall) anchors.wall[k] = core::Vec3(0, 0, 0);
    anchors.bears[k] = 0;
    const Own own(v, i);
    for (NearGroup near(v, i); near.left > 0; near.advance()) {
      ForeignGroup at(v, own, near);
      at.pair.flow(v, own, near.id);
      find_push(v, s, own, at.pair, near, at.kinds, own.same(at.kinds));
      if (!bears(v, own, near)) continue;
      if (!anchors.bears[k])
        for (std::size_t n = 0; n < anchor_scratch * n_anchors; ++n) anchors.scratch[n] = 0;  // of each anchor: weights, force x, y, z
      anchors.bears[k] = 1;
      each_half([&](auto half) {
        if (8 * half >= near.left) return;  // foreigners have few near ones: mostly one half is filling
        Doubles f[3];
        pair_force<half>(v, i, near, at, f);
        if (anchors.wall) add_wall_force<half>(at, f, anchors.wall[k]);
        weigh_anchors<half>(anchors, i, at, anchors.scratch);
        for (std::size_t n = 0; n < n_anchors; ++n) {
          double* const lanes = anchors.scratch + anchor_scratch * n;
          const Doubles weight = Doubles::load(lanes);
          for (int e = 0; e < 3; ++e) {
            double* const sum = lanes + 8 * (e + 1);
            (Doubles::load(sum) + weight * f[e]).store(sum);
          }
        }
      });
    }
    if (!anchors.bears[k]) continue;
    for (std::size_t n = 0; n < n_anchors; ++n)
      for (int e = 0; e < 3; ++e) force[n][e] = total(Doubles::load(anchors.scratch + anchor_scratch * n + 8 * static_cast<std::size_t>(e + 1)));
  }
}

void foreign_work(const PairView& v, const AnchorView& anchors, std::size_t first, std::size_t last, double* power) {
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t k = i - anchors.n_particles;
    double left = 0;  // of what is done at its place, beyond what strangers book
    for (NearGroup near(v, i); near.left > 0 && anchors.bears[k]; near.advance())
      for (std::size_t l = 0, n = near.count(); l < n; ++l) {
        const std::uint32_t j = near.id[l];
        if (kin(v.kind[i], v.kind[j])) continue;
        const double weight = double(near.weight[l]), push = double(near.push[l]), kept = 1 - gives_way(v, j, i, closing_of(v, i, j));
        for (int e = 0; e < 3; ++e) {
          const double d = v.place[i].x[e] - v.place[j].x[e], mean = 0.5 * v.motion[j].sum[e];
          const double own = -double(v.p_contact[i]) * (weight * d), other = -double(v.p_contact[j]) * (weight * d), viscous = -(push * d);
          left += ((own + other) + viscous) * (anchors.v_mean[anchors.start[k + 1] - 1][e] - mean) -
                  (kept * other + 0.5 * viscous) * (0.5 * v.motion[i].sum[e] - mean);
        }
      }
    power[i - first] = v.unit * v.unit * v.unit * left;
  }
}

}  // namespace sph::EJECTA_ISA
