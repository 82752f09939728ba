// SPDX-License-Identifier: Apache-2.0
// Neighbour rows from the octree, compiled once for each instruction set.
//
// Points that follow one another and lie close together form a party. The tree is descended once a party: the points of
// leaves within reach of the party's box are thinned out against that box and packed side by side, in blocks of 16 with a
// box each. Every row then passes over the blocks within its own reach, a register of floats at a time, and stores those
// within its radius with a compress-store.
//
// The answer is the one of double arithmetic, bit for bit, though the passes run in float:
// - Boxes. Rounding is monotone, so the gap between two boxes, summed up like the distance of two points, is never
//   greater than the computed distance of any two points in them.
// - Distances. Candidates are taken relative to the party's centre c and divided by a power of two s > M, M the greatest
//   of |x - c| that can matter. With u = 2^-24 each coordinate is then off by at most u, each difference by e = 4u, and
//   d^2 by 2 sqrt(3) e d + 3 e^2 + 4 u d^2. Where |d^2 - r^2| is below band(r) = 16 u r + 8 u r^2 + 64 u^2, which
//   exceeds that for d near r, the pair is decided in double.
#include "core/octree_kernel.hpp"

#include <cmath>
#ifdef __SSE2__
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 on its own AVX-512 header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include "core/packed_lanes.hpp"

namespace core::EJECTA_ISA {
namespace {

// The few vector operations needed: `lanes` floats or 32-bit integers, `real_lanes` doubles, a bit a lane.
#if defined(__AVX512F__)
constexpr int lanes = 16, real_lanes = 8;
using Floats = __m512;
using Ints = __m512i;
using Reals = __m512d;
using Bits = __mmask16;
inline Floats load(const float* a) { return _mm512_loadu_ps(a); }
inline Ints load(const std::uint32_t* a) { return _mm512_loadu_si512(a); }
inline Reals load(const double* a) { return _mm512_loadu_pd(a); }
inline Floats all(float a) { return _mm512_set1_ps(a); }
inline Ints all(std::uint32_t a) { return _mm512_set1_epi32(static_cast<int>(a)); }
inline Ints numbers(std::uint32_t first) {
  return _mm512_add_epi32(all(first), _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
}
inline Reals all(double a) { return _mm512_set1_pd(a); }
inline void store(float* to, Floats a) { _mm512_storeu_ps(to, a); }
inline void store(std::uint32_t* to, Ints a) { _mm512_storeu_si512(to, a); }
inline Floats max(Floats a, Floats b) { return _mm512_max_ps(a, b); }
inline Reals max(Reals a, Reals b) { return _mm512_max_pd(a, b); }
inline Floats multiply_add(Floats a, Floats b, Floats c) { return _mm512_fmadd_ps(a, b, c); }
inline Floats lesser_magnitude(Floats a, Floats b) { return _mm512_range_ps(a, b, 0b1010); }
inline Bits less(Floats a, Floats b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
inline Bits less(Reals a, Reals b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
inline Bits differ(Bits among, Ints a, Ints b) { return _mm512_mask_cmpneq_epi32_mask(among, a, b); }
inline float greatest(Floats a) { return _mm512_reduce_max_ps(a); }
inline int count(Bits m) { return __builtin_popcount(m); }
// In halves: a whole register would straddle two cache lines nearly always.
inline void store_some(std::uint32_t* to, Bits m, Ints a) {
  const Ints packed = _mm512_maskz_compress_epi32(m, a);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_castsi512_si256(packed));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + 8), _mm512_extracti64x4_epi64(packed, 1));
}
inline void store_some(float* to, Bits m, Floats a) {
  store_some(reinterpret_cast<std::uint32_t*>(to), m, _mm512_castps_si512(a));
}
inline Floats to_floats(Reals a, Reals b) {
  return _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(a)), _mm512_cvtpd_ps(b), 1);
}
#elif defined(__AVX2__)
constexpr int lanes = 8, real_lanes = 4;
using Floats = __m256;
using Ints = __m256i;
using Reals = __m256d;
using Bits = unsigned;
inline Floats load(const float* a) { return _mm256_loadu_ps(a); }
inline Ints load(const std::uint32_t* a) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a)); }
inline Reals load(const double* a) { return _mm256_loadu_pd(a); }
inline Floats all(float a) { return _mm256_set1_ps(a); }
inline Ints all(std::uint32_t a) { return _mm256_set1_epi32(static_cast<int>(a)); }
inline Ints numbers(std::uint32_t first) {
  return _mm256_add_epi32(all(first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}
inline Reals all(double a) { return _mm256_set1_pd(a); }
inline void store(float* to, Floats a) { _mm256_storeu_ps(to, a); }
inline void store(std::uint32_t* to, Ints a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), a); }
inline Floats max(Floats a, Floats b) { return _mm256_max_ps(a, b); }
inline Reals max(Reals a, Reals b) { return _mm256_max_pd(a, b); }
inline Floats multiply_add(Floats a, Floats b, Floats c) { return _mm256_fmadd_ps(a, b, c); }
inline Floats lesser_magnitude(Floats a, Floats b) {
  const Floats sign = all(-0.0f);
  return _mm256_min_ps(_mm256_andnot_ps(sign, a), _mm256_andnot_ps(sign, b));
}
inline Bits less(Floats a, Floats b) { return static_cast<Bits>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ))); }
inline Bits less(Reals a, Reals b) { return static_cast<Bits>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ))); }
inline Bits differ(Bits among, Ints a, Ints b) {
  return among & ~static_cast<Bits>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))));
}
inline float greatest(Floats a) {
  const __m128 four = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
  const __m128 two = _mm_max_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps(two, two, 1)));
}
inline int count(Bits m) { return __builtin_popcount(m); }
inline void store_some(float* to, Bits m, Floats a) {
  _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(a, packed_lanes(m)));
}
inline void store_some(std::uint32_t* to, Bits m, Ints a) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(a, packed_lanes(m)));
}
inline Floats to_floats(Reals a, Reals b) { return _mm256_set_m128(_mm256_cvtpd_ps(b), _mm256_cvtpd_ps(a)); }
#else
constexpr int lanes = 4, real_lanes = 2;
typedef float Floats __attribute__((vector_size(16)));
typedef std::int32_t Ints __attribute__((vector_size(16)));
typedef double Reals __attribute__((vector_size(16)));
using Bits = unsigned;
typedef std::int64_t LongInts __attribute__((vector_size(16)));
template <class V, class R>
inline V load_as(const R* a) {
  V v;
  __builtin_memcpy(&v, a, sizeof v);
  return v;
}
inline Floats load(const float* a) { return load_as<Floats>(a); }
inline Ints load(const std::uint32_t* a) { return load_as<Ints>(a); }
inline Reals load(const double* a) { return load_as<Reals>(a); }
inline Floats all(float a) { return Floats{a, a, a, a}; }
inline Ints all(std::uint32_t a) {
  const std::int32_t b = static_cast<std::int32_t>(a);
  return Ints{b, b, b, b};
}
inline Ints numbers(std::uint32_t first) { return all(first) + Ints{0, 1, 2, 3}; }
inline Reals all(double a) { return Reals{a, a}; }
inline void store(float* to, Floats a) { __builtin_memcpy(to, &a, sizeof a); }
inline void store(std::uint32_t* to, Ints a) { __builtin_memcpy(to, &a, sizeof a); }
inline Floats max(Floats a, Floats b) { return a > b ? a : b; }
inline float greatest(Floats a) {
  const float b = a[0] > a[1] ? a[0] : a[1], c = a[2] > a[3] ? a[2] : a[3];
  return b > c ? b : c;
}
inline Reals max(Reals a, Reals b) { return a > b ? a : b; }
inline Floats multiply_add(Floats a, Floats b, Floats c) { return a * b + c; }
inline Floats lesser_magnitude(Floats a, Floats b) { return -max(-max(a, -a), -max(b, -b)); }
inline Bits lane_bits(Ints m) {
#ifdef __SSE2__
  return static_cast<Bits>(_mm_movemask_ps(reinterpret_cast<__m128>(m)));
#else
  return (m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8);
#endif
}
inline Bits less(Floats a, Floats b) { return lane_bits(a < b); }
inline Bits less(Reals a, Reals b) {
  const LongInts m = a < b;
  return static_cast<Bits>((m[0] & 1) | (m[1] & 2));
}
inline Bits differ(Bits among, Ints a, Ints b) { return among & lane_bits(a != b); }
inline int count(Bits m) {
  constexpr signed char n[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
  return n[m];
}
template <class R, class V>
inline void store_each(R* to, Bits m, V a) {
  for (int b = 0; b < lanes; ++b) {
    *to = static_cast<R>(a[b]);
    to += m >> b & 1;
  }
}
inline void store_some(float* to, Bits m, Floats a) { store_each(to, m, a); }
inline void store_some(std::uint32_t* to, Bits m, Ints a) { store_each(to, m, a); }
inline Floats to_floats(Reals a, Reals b) {
  return Floats{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(b[0]), static_cast<float>(b[1])};
}
#endif

inline Bits first_lanes(std::size_t n) { return static_cast<Bits>(n < lanes ? (1u << n) - 1 : (1u << lanes) - 1); }

/// Stores first + k for each bit k of eight. Returns the end.
inline std::uint32_t* store_numbers(std::uint32_t* to, Bits m, std::uint32_t first) {
#ifdef __AVX512F__
  const __m256i eight = _mm512_castsi512_si256(numbers(first));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_maskz_compress_epi32(static_cast<__mmask8>(m), eight));
  return to + count(m);
#else
  for (std::uint32_t k = 0; k < 8; k += lanes) {
    const Bits part = m >> k & first_lanes(lanes);
    store_some(to, part, numbers(first + k));
    to += count(part);
  }
  return to;
#endif
}

constexpr std::size_t party_rows = 128;
constexpr std::size_t block = octree_block;
constexpr std::size_t few_blocks = 3;  // of which rows pass over all
constexpr double party_width = 2.6;  // greatest edge of the box in units of the smallest radius
// A party of fewer rows (where points are far apart, measured by their radii) may be wider, if that brings few leaves
// within reach.
constexpr std::size_t few_rows = 6, loose_rows = 16, loose_leaves = 32;
constexpr double loose_width = 8.0;
constexpr double radius_spread = 1.5;  // greatest ratio of two radii in a party
constexpr float u = 0x1p-24f;
constexpr float no_place = 3e38f;  // coordinate of the padding behind the candidates: infinitely far

/// Rows that are found with one descent of the tree, and the frame of their floats: (x - centre) * scale.
struct Party {
  std::size_t n;
  std::uint32_t place[party_rows];
  double low[3], high[3];
  double smallest, radius;  // of all radii the least and the greatest
  double centre[3], scale;
};

struct Thresholds {
  float high, low;  // of d^2 in the frame: out beyond the first, in below the second
};
inline Thresholds thresholds(double radius) {
  const float r = static_cast<float>(radius), band = u * (16 * r + 8 * r * r) + 64 * u * u;
  return {r * r + band, r * r - band};
}

typedef double Four __attribute__((vector_size(32)));  // x y z radius

/// Fills the party with rows from `first` on, in a box of at most `width` times the smallest radius.
void gather_party(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, std::size_t most_rows,
                  double width, Party& p) {
  const Four widths{width, width, width, radius_spread - 1};
  Four low{}, high{};
  std::size_t n = 0;
  for (std::size_t k = first; k < last && n < most_rows; ++k) {
    const std::uint32_t place = query.along_curve ? static_cast<std::uint32_t>(k) : tree.rank[k];
    const Four own{tree.x[0][place], tree.x[1][place], tree.x[2][place], query.radius[place]};
    if (n == 0) low = high = own;
    const Four new_low = own < low ? own : low, new_high = own > high ? own : high;
    const auto apart = new_high - new_low > widths * new_low[3];
    if (apart[0] | apart[1] | apart[2] | apart[3]) break;
    low = new_low;
    high = new_high;
    p.place[n++] = place;
  }
  for (int d = 0; d < 3; ++d) {
    p.low[d] = low[d];
    p.high[d] = high[d];
  }
  p.smallest = low[3];
  p.radius = high[3];
  p.n = n;
}

/// Which of eight nodes in a row are within reach of the party.
template <bool symmetric>
inline Bits nodes_in_reach(const OctreeView& tree, const RowQuery& query, const Party& p, std::size_t node) {
  Bits hit = 0;
  for (int half = 0; half < 8; half += real_lanes) {
    Reals gap_2[3];
    for (int d = 0; d < 3; ++d) {
      const Reals below = load(tree.box[d] + node + half) - all(p.high[d]);
      const Reals above = all(p.low[d]) - load(tree.box[3 + d] + node + half);
      const Reals gap = max(max(below, above), all(0.0));
      gap_2[d] = gap * gap;
    }
    Reals reach_2 = all(p.radius * p.radius);
    if constexpr (symmetric) reach_2 = max(reach_2, load(query.node_radius_2 + node + half));
    hit |= less(gap_2[0] + gap_2[1] + gap_2[2], reach_2) << half;
  }
  return hit;
}

/// Finds the leaves within reach of the party, level by level and in order, in s.leaf. Returns their number.
template <bool symmetric>
std::size_t descend(const OctreeView& whole, const RowQuery& query, const Party& party, RowScratch& s) {
  const OctreeView tree = whole;  // copies, which the numbers stored cannot change
  const Party p = party;
  std::size_t n = 1;
  s.leaf[0] = 0;
  for (int level = tree.n_levels - 1; level >= 0; --level) {
    std::uint32_t* const above = s.leaf;
    s.leaf = s.node;
    s.node = above;
    if (n * octree_fan + 2 * lanes > s.node_room) s.grow_nodes(n * octree_fan + 2 * lanes);
    const std::uint32_t* const node = s.node;
    const std::size_t first = tree.level[level];
    std::uint32_t* end = s.leaf;
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t child = node[k] * octree_fan;
      const Bits hit = nodes_in_reach<symmetric>(tree, query, p, first + child);
      end = store_numbers(end, hit, child);
    }
    n = static_cast<std::size_t>(end - s.leaf);
  }
  return n;
}

/// The party's frame: centre of its box, and the power of two that brings everything of interest below 1.
template <bool symmetric>
void set_frame(Party& p, const RowQuery& query, const std::uint32_t* leaf, std::size_t n_leaves) {
  double reach_2 = p.radius * p.radius, half = 0;
  if constexpr (symmetric)  // the leaves are the first nodes
    for (std::size_t k = 0; k < n_leaves; ++k)
      if (query.node_radius_2[leaf[k]] > reach_2) reach_2 = query.node_radius_2[leaf[k]];
  for (int d = 0; d < 3; ++d) {
    p.centre[d] = 0.5 * (p.low[d] + p.high[d]);
    const double h = p.high[d] - p.centre[d], l = p.centre[d] - p.low[d];
    half = h > half ? h : half;
    half = l > half ? l : half;
  }
  int exponent = 0;
  std::frexp(1.001 * (half + std::sqrt(reach_2)), &exponent);
  exponent = exponent < -1000 ? -1000 : exponent > 1000 ? 1000 : exponent;
  p.scale = std::ldexp(1.0, -exponent);
}

inline float in_frame(const Party& p, int d, double x) { return static_cast<float>((x - p.centre[d]) * p.scale); }
inline Floats in_frame(const Party& p, int d, const double* x) {
  const Reals c = all(p.centre[d]), s = all(p.scale);
  return to_floats((load(x) - c) * s, (load(x + real_lanes) - c) * s);
}

inline Floats squared_length(Floats x, Floats y, Floats z) { return multiply_add(x, x, multiply_add(y, y, z * z)); }

/// The party's box in the frame, and how far its rows reach.
struct Box {
  Floats low[3], high[3], reach;
};
inline Floats gap_2(const Box& box, Floats x, Floats y, Floats z) {
  const Floats zero = all(0.0f);
  return squared_length(max(max(box.low[0] - x, x - box.high[0]), zero), max(max(box.low[1] - y, y - box.high[1]), zero),
                        max(max(box.low[2] - z, z - box.high[2]), zero));
}

/// Packs those candidates on the curve that may be within reach of the party's box. Returns their number.
template <bool symmetric>
std::size_t pack_for_party(const OctreeView& tree, const RowQuery& query, const Party& p, std::size_t n_leaves,
                           RowScratch& s) {
  if (n_leaves * octree_leaf + 2 * lanes > s.candidate_room) s.grow_candidates(n_leaves * octree_leaf + 2 * lanes);
  Box box;
  for (int d = 0; d < 3; ++d) {
    box.low[d] = all(in_frame(p, d, p.low[d]));
    box.high[d] = all(in_frame(p, d, p.high[d]));
  }
  box.reach = all(thresholds(p.radius * p.scale).high);
  const Candidates to = s.party;
  std::size_t n = 0;
  for (std::size_t k = 0; k < n_leaves; ++k) {
    const std::size_t end = tree.leaf[s.leaf[k] + 1];
    for (std::size_t j = tree.leaf[s.leaf[k]]; j < end; j += lanes) {
      const Floats x = in_frame(p, 0, tree.x[0] + j), y = in_frame(p, 1, tree.x[1] + j), z = in_frame(p, 2, tree.x[2] + j);
      Bits hit;
      if constexpr (symmetric) {
        const Reals scale = all(p.scale);
        const Floats r = to_floats(load(query.radius + j) * scale, load(query.radius + j + real_lanes) * scale);
        const Floats band = all(u) * (all(16.0f) * r + all(8.0f) * r * r) + all(64 * u * u);
        hit = less(gap_2(box, x, y, z), max(box.reach, r * r + band)) & first_lanes(end - j);
        store_some(to.high + n, hit, r * r + band);
        store_some(to.low + n, hit, r * r - band);
      } else {
        hit = less(gap_2(box, x, y, z), box.reach) & first_lanes(end - j);
      }
      store_some(to.x + n, hit, x);
      store_some(to.y + n, hit, y);
      store_some(to.z + n, hit, z);
      store_some(to.id + n, hit, load(tree.order + j));
      n += static_cast<std::size_t>(count(hit));
    }
  }
  return n;
}

inline float greatest_of_block(const float* a) {
  Floats most = load(a);
  for (std::size_t k = lanes; k < block; k += lanes) most = max(most, load(a + k));
  return greatest(most);
}
inline float least_of_block(const float* a) {
  Floats most = -load(a);
  for (std::size_t k = lanes; k < block; k += lanes) most = max(most, -load(a + k));
  return -greatest(most);
}

/// Puts boxes around the blocks of n candidates, and behind them some that are never near. Returns the number of blocks.
/// Few blocks get no boxes.
template <bool symmetric>
std::size_t box_blocks(const Candidates& c, std::size_t n, const Blocks& b) {
  const std::size_t n_blocks = (n + block - 1) / block;
  float* const x[3] = {c.x, c.y, c.z};
  for (std::size_t k = n; k < n_blocks * block; k += lanes) {  // the last block is filled with what leaves its box as it is
    for (int d = 0; d < 3; ++d) store(x[d] + k, all(x[d][n - 1]));
    store(c.id + k, all(std::uint32_t{0}));
    if constexpr (symmetric) store(c.high + k, all(0.0f)), store(c.low + k, all(0.0f));
  }
  if (n_blocks > few_blocks) {
    for (std::size_t k = 0; k < n_blocks; ++k) {
      for (int d = 0; d < 3; ++d) {
        b.low[d][k] = least_of_block(x[d] + block * k);
        b.high[d][k] = greatest_of_block(x[d] + block * k);
      }
      if constexpr (symmetric) b.reach[k] = greatest_of_block(c.high + block * k);
    }
    for (int d = 0; d < 3; ++d) store(b.low[d] + n_blocks, all(no_place)), store(b.high[d] + n_blocks, all(no_place));
    if constexpr (symmetric) store(b.reach + n_blocks, all(0.0f));
  }
  for (std::size_t k = n; k < n_blocks * block; k += lanes) store(c.x + k, all(no_place));
  return n_blocks;
}

/// Decides in double which of the undecided candidates k + lane are neighbours of the point at `place`.
template <bool symmetric>
[[gnu::noinline]] Bits decide(const OctreeView& tree, const RowQuery& query, const std::uint32_t* id, Bits undecided,
                              std::size_t place) {
  Bits in = 0;
  for (Bits left = undecided; left != 0; left &= left - 1) {
    const int at = __builtin_ctz(left);
    const std::size_t other = tree.rank[id[at]];
    double r = query.radius[place];
    if (symmetric && query.radius[other] > r) r = query.radius[other];
    const double dx = tree.x[0][other] - tree.x[0][place], dy = tree.x[1][other] - tree.x[1][place],
                 dz = tree.x[2][other] - tree.x[2][place];
    if (dx * dx + dy * dy + dz * dz < r * r) in |= static_cast<Bits>(1u << at);
  }
  return in;
}

/// A row in the frame.
struct Row {
  float x[3];
  Thresholds limit;
};

/// Finds the blocks of candidates within reach of the row. Returns their number.
template <bool symmetric>
std::size_t find_blocks(const Row& own, std::size_t n_blocks, const Blocks& b, std::uint32_t* near) {
  const Floats zero = all(0.0f);
  std::uint32_t* end = near;
  for (std::size_t k = 0; k < n_blocks; k += lanes) {
    Floats gap[3];
    for (int d = 0; d < 3; ++d) {
      const Floats x = all(own.x[d]);
      gap[d] = max(max(load(b.low[d] + k) - x, x - load(b.high[d] + k)), zero);
    }
    Floats reach = all(own.limit.high);
    if constexpr (symmetric) reach = max(reach, load(b.reach + k));
    const Bits hit = less(squared_length(gap[0], gap[1], gap[2]), reach);
    store_some(end, hit, numbers(static_cast<std::uint32_t>(k)));
    end += count(hit);
  }
  return static_cast<std::size_t>(end - near);
}

/// Stores those candidates of the blocks that are neighbours of the point at `place`. Returns their number. Pairs that floats
/// leave undecided are decided in double where `exact`; else `sure` says that there were none.
template <bool symmetric, bool exact>
std::size_t find_row(const OctreeView& tree, const RowQuery& query, const Row& own, std::size_t place, const Candidates& all_of,
                     const std::uint32_t* near, std::size_t n_near, std::uint32_t* row, bool& sure) {
  const Candidates from = all_of;  // a copy, which the indices stored cannot change
  const Floats x = all(own.x[0]), y = all(own.x[1]), z = all(own.x[2]);
  const Floats own_high = all(own.limit.high), own_low = all(own.limit.low);
  const Ints self = all(tree.order[place]);
  Bits undecided = 0;
  Floats closest = all(no_place);  // to own_high, of all squared distances
  std::uint32_t* end = row;
  for (const std::uint32_t* b = near; b < near + n_near; ++b)
    for (std::size_t i = 0; i < block; i += lanes) {
      const std::size_t k = *b * block + i;
      const Floats d_2 = squared_length(load(from.x + k) - x, load(from.y + k) - y, load(from.z + k) - z);
      const Ints id = load(from.id + k);
      Floats high = own_high, low = own_low;
      if constexpr (symmetric) high = max(high, load(from.high + k)), low = max(low, load(from.low + k));
      Bits hit = less(d_2, high);
      if constexpr (exact) {
        const Bits certain = less(d_2, low);
        hit = certain | decide<symmetric>(tree, query, from.id + k, hit & ~certain, place);
      } else if constexpr (symmetric) {
        undecided |= hit ^ less(d_2, low);
      } else {
        closest = lesser_magnitude(d_2 - high, closest);
      }
      hit = differ(hit, id, self);
      store_some(end, hit, id);
      end += count(hit);
    }
  if constexpr (!symmetric) undecided = less(closest, all(2 * (own.limit.high - own.limit.low)));
  sure = undecided == 0;
  return static_cast<std::size_t>(end - row);
}

bool ascending(const std::uint32_t* id, std::size_t n) {
  unsigned wrong = 0;
  for (std::size_t k = 1; k < n; ++k) wrong |= id[k] < id[k - 1];
  return wrong == 0;
}

/// The next party, and the leaves within its reach. Returns the number of leaves.
template <bool symmetric>
std::size_t meet(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, Party& p,
                 RowScratch& s) {
  gather_party(tree, query, first, last, party_rows, party_width, p);
  if (p.n < few_rows && first + p.n < last) {
    gather_party(tree, query, first, last, loose_rows, loose_width, p);
    const std::size_t n_leaves = descend<symmetric>(tree, query, p, s);
    if (n_leaves <= loose_leaves) return n_leaves;
    gather_party(tree, query, first, last, party_rows, party_width, p);
  }
  return descend<symmetric>(tree, query, p, s);
}

template <bool symmetric>
void find_rows_as(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, RowScratch& s) {
  std::size_t n_stored = 0;
  Party p;
  std::uint32_t* n_neighbours = s.count;
  const auto wanted = [&](std::size_t index) { return !query.wanted || query.wanted[index]; };
  for (std::size_t k = first; k < last; k += p.n) {
    if (!wanted(query.along_curve ? tree.order[k] : k)) {
      *n_neighbours++ = 0;
      p.n = 1;
      continue;
    }
    const std::size_t n_leaves = meet<symmetric>(tree, query, k, last, p, s);
    set_frame<symmetric>(p, query, s.leaf, n_leaves);
    const std::size_t n = pack_for_party<symmetric>(tree, query, p, n_leaves, s);
    if (query.sorted && !tree.in_order && !ascending(s.party.id, n)) s.sort_party(n, symmetric);
    const std::size_t n_blocks = box_blocks<symmetric>(s.party, n, s.block);
    const bool few = n_blocks <= few_blocks;
    if (few) store_numbers(s.near, first_lanes(n_blocks), 0);
    Row row;
    row.limit = thresholds(p.radius * p.scale);
    for (std::size_t a = 0; a < p.n; ++a) {
      const std::uint32_t place = p.place[a];
      if (!wanted(tree.order[place])) {
        *n_neighbours++ = 0;
        continue;
      }
      for (int d = 0; d < 3; ++d) row.x[d] = in_frame(p, d, tree.x[d][place]);
      if (p.smallest < p.radius) row.limit = thresholds(query.radius[place] * p.scale);
      const std::size_t n_near = few ? n_blocks : find_blocks<symmetric>(row, n_blocks, s.block, s.near);
      const std::size_t needed = n_stored + n_near * block + lanes;
      if (needed > s.row_room) s.grow_rows(needed);
      std::uint32_t* const to = s.row + n_stored;
      bool sure;
      std::size_t found = find_row<symmetric, false>(tree, query, row, place, s.party, s.near, n_near, to, sure);
      if (!sure) found = find_row<symmetric, true>(tree, query, row, place, s.party, s.near, n_near, to, sure);
      *n_neighbours++ = static_cast<std::uint32_t>(found);
      n_stored += found;
    }
  }
}

/// Spreads the low 21 bits to every third place.
inline std::uint64_t spread(std::uint64_t a) {
  a = (a | a << 32) & 0x1f00000000ffffull;
  a = (a | a << 16) & 0x1f0000ff0000ffull;
  a = (a | a << 8) & 0x100f00f00f00f00full;
  a = (a | a << 4) & 0x10c30c30c30c30c3ull;
  return (a | a << 2) & 0x1249249249249249ull;
}

}  // namespace

void morton_keys(const double* xyz, std::size_t n, const double* low, double scale, std::uint64_t* key) {
  const double low_x = low[0], low_y = low[1], low_z = low[2];
  const auto cell = [scale](double x, double l) {
    const std::int32_t c = static_cast<std::int32_t>((x - l) * scale);
    return static_cast<std::uint64_t>(c < 0x1fffff ? c : 0x1fffff);
  };
  for (std::size_t i = 0; i < n; ++i)
    key[i] = spread(cell(xyz[3 * i], low_x)) << 2 | spread(cell(xyz[3 * i + 1], low_y)) << 1 |
             spread(cell(xyz[3 * i + 2], low_z));
}

void find_rows(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, RowScratch& scratch) {
  if (query.node_radius_2)
    find_rows_as<true>(tree, query, first, last, scratch);
  else
    find_rows_as<false>(tree, query, first, last, scratch);
}

}  // namespace core::EJECTA_ISA
