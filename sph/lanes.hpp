// SPDX-License-Identifier: Apache-2.0
// Lanes of the pair sums: sixteen singles or eight doubles that behave like one, in as many registers as the instruction set
// needs for them. Every operation is correctly rounded and none is fused, so the bits are the same on each.
#pragma once

#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "core/isa.hpp"
#include "core/packed_lanes.hpp"

namespace sph::EJECTA_ISA {

constexpr int register_bytes = core::native_lanes * static_cast<int>(sizeof(double));
typedef float SingleRegister __attribute__((vector_size(register_bytes)));
typedef double DoubleRegister __attribute__((vector_size(register_bytes)));
typedef std::int32_t IntRegister __attribute__((vector_size(register_bytes)));

constexpr int parts = 64 / register_bytes;

/// f(part) for every register; written out, because compilers take loops for copies and make them in pieces of their own,
/// which then cannot be loaded at once for a while.
template <class F>
[[gnu::always_inline]] inline void each_part(F&& f) {
  f(0);
  if constexpr (parts > 1) f(1);
  if constexpr (parts > 2) f(2), f(3);
}

template <class V>
inline V load_register(const void* a) {
  V v;
  std::memcpy(&v, a, sizeof v);
  return v;
}

/// N numbers T in registers V.
template <class T, class V, int N>
struct Lanes {
  using Register = V;
  V part[parts];

  Lanes() = default;
  Lanes(T a) {
    each_part([&](int p) { part[p] = a - V{}; });  // a - 0 keeps the sign of a negative zero
  }
  Lanes(const Lanes& a) { *this = a; }
  Lanes& operator=(const Lanes& a) {
    each_part([&](int p) { part[p] = a.part[p]; });
    return *this;
  }
  static Lanes load(const T* a) {
    Lanes r;
    each_part([&](int p) { r.part[p] = load_register<V>(a + p * (N / parts)); });
    return r;
  }
  void store(T* a) const {
    each_part([&](int p) { std::memcpy(a + p * (N / parts), &part[p], sizeof(V)); });
  }

#define EJECTA_OPERATOR(op)                                                \
  friend Lanes operator op(Lanes a, Lanes b) {                             \
    each_part([&](int p) { a.part[p] = a.part[p] op b.part[p]; });    \
    return a;                                                              \
  }
  EJECTA_OPERATOR(+)
  EJECTA_OPERATOR(-)
  EJECTA_OPERATOR(*)
  EJECTA_OPERATOR(/)
  EJECTA_OPERATOR(&)
#undef EJECTA_OPERATOR
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
};

using Singles = Lanes<float, SingleRegister, 16>;
using Doubles = Lanes<double, DoubleRegister, 8>;
using Ints = Lanes<std::int32_t, IntRegister, 16>;

/// The first in four lanes, the second in the others.
inline Doubles two_halves(double low, double high) {
  Doubles r(low);
#if defined(__AVX512F__)
  r.part[0] = (DoubleRegister)_mm512_mask_broadcastsd_pd((__m512d)r.part[0], 0xf0, _mm_set_sd(high));
#else
  each_part([&](int p) { r.part[p] = (p < parts / 2 ? low : high) - DoubleRegister{}; });
#endif
  return r;
}

/// Four doubles, twice.
inline Doubles twice(const double* a) {
  Doubles r;
#if defined(__AVX512F__)
  r.part[0] = (DoubleRegister)_mm512_broadcast_f64x4(_mm256_loadu_pd(a));
#else
  each_part([&](int p) { r.part[p] = load_register<DoubleRegister>(a + p * (8 / parts) % 4); });
#endif
  return r;
}
/// Lane l of each four, in all of the four.
template <int l>
inline Doubles spread(Doubles a) {
#if defined(__AVX512F__)
  a.part[0] = (DoubleRegister)_mm512_permutex_pd((__m512d)a.part[0], l * 0x55);
#elif defined(__AVX2__)
  for (DoubleRegister& v : a.part) v = (DoubleRegister)_mm256_permute4x64_pd((__m256d)v, l * 0x55);
#else
  for (int p = 0; p < parts; p += 2) a.part[p] = a.part[p + 1] = a.part[p + l / 2][l % 2] - DoubleRegister{};
#endif
  return a;
}

typedef double Four __attribute__((vector_size(32)));
inline Four all(double a) { return Four{a, a, a, a}; }
inline Four last_four(Doubles a) {
  Four r;
#if defined(__AVX512F__)
  r = (Four)_mm512_extractf64x4_pd((__m512d)a.part[0], 1);
#elif defined(__AVX2__)
  r = (Four)a.part[1];
#else
  r = Four{a.part[2][0], a.part[2][1], a.part[3][0], a.part[3][1]};
#endif
  return r;
}
inline Four first_four(Doubles a) {
  Four r;
#if defined(__AVX512F__)
  r = (Four)_mm512_castpd512_pd256((__m512d)a.part[0]);
#elif defined(__AVX2__)
  r = (Four)a.part[0];
#else
  r = Four{a.part[0][0], a.part[0][1], a.part[1][0], a.part[1][1]};
#endif
  return r;
}

/// Yes or no in each of sixteen lanes.
#if defined(__AVX512F__)
struct Yes {
  __mmask16 m;
  friend Yes operator&(Yes a, Yes b) { return {static_cast<__mmask16>(a.m & b.m)}; }
  friend Yes operator!(Yes a) { return {static_cast<__mmask16>(~a.m)}; }
  unsigned bits() const { return m; }
};
inline Yes operator<(Singles a, Singles b) { return {_mm512_cmp_ps_mask((__m512)a.part[0], (__m512)b.part[0], _CMP_LT_OQ)}; }
inline Yes operator<(Ints a, Ints b) { return {_mm512_cmplt_epi32_mask((__m512i)a.part[0], (__m512i)b.part[0])}; }
inline Yes operator==(Ints a, Ints b) { return {_mm512_cmpeq_epi32_mask((__m512i)a.part[0], (__m512i)b.part[0])}; }
inline Singles select(Yes m, Singles a, Singles b) {
  b.part[0] = (SingleRegister)_mm512_mask_mov_ps((__m512)b.part[0], m.m, (__m512)a.part[0]);
  return b;
}
#else
struct Yes {
  IntRegister m[parts];
  friend Yes operator&(Yes a, Yes b) {
    each_part([&](int p) { a.m[p] &= b.m[p]; });
    return a;
  }
  friend Yes operator!(Yes a) {
    each_part([&](int p) { a.m[p] = ~a.m[p]; });
    return a;
  }
  unsigned bits() const {
    unsigned r = 0;
    constexpr int lanes = 16 / parts;
    for (int p = 0; p < parts; ++p)
#if defined(__AVX2__)
      r |= static_cast<unsigned>(_mm256_movemask_ps((__m256)m[p])) << lanes * p;
#elif defined(__SSE2__)
      r |= static_cast<unsigned>(_mm_movemask_ps((__m128)m[p])) << lanes * p;
#else
      for (int l = 0; l < lanes; ++l) r |= static_cast<unsigned>(m[p][l] != 0) << (lanes * p + l);
#endif
    return r;
  }
};
inline Yes operator<(Singles a, Singles b) {
  Yes r;
  each_part([&](int p) { r.m[p] = a.part[p] < b.part[p]; });
  return r;
}
inline Yes operator<(Ints a, Ints b) {
  Yes r;
  each_part([&](int p) { r.m[p] = a.part[p] < b.part[p]; });
  return r;
}
inline Yes operator==(Ints a, Ints b) {
  Yes r;
  each_part([&](int p) { r.m[p] = a.part[p] == b.part[p]; });
  return r;
}
inline Singles select(Yes m, Singles a, Singles b) {
  each_part([&](int p) { b.part[p] = m.m[p] ? a.part[p] : b.part[p]; });
  return b;
}
#endif
inline Yes operator>(Singles a, Singles b) { return b < a; }
inline bool any(Yes a) { return a.bits() != 0; }

/// min and max return b where both are equal, on every instruction set alike.
inline float min(float a, float b) { return a < b ? a : b; }
inline float max(float a, float b) { return b < a ? a : b; }
inline Singles min(Singles a, Singles b) {
#if defined(__AVX512F__)
  a.part[0] = (SingleRegister)_mm512_min_ps((__m512)a.part[0], (__m512)b.part[0]);
  return a;
#else
  each_part([&](int p) { b.part[p] = a.part[p] < b.part[p] ? a.part[p] : b.part[p]; });
  return b;
#endif
}
inline Singles max(Singles a, Singles b) {
#if defined(__AVX512F__)
  a.part[0] = (SingleRegister)_mm512_max_ps((__m512)a.part[0], (__m512)b.part[0]);
  return a;
#else
  each_part([&](int p) { b.part[p] = b.part[p] < a.part[p] ? a.part[p] : b.part[p]; });
  return b;
#endif
}

inline Doubles max(Doubles a, Doubles b) {
#if defined(__AVX512F__)
  a.part[0] = (DoubleRegister)_mm512_max_pd((__m512d)a.part[0], (__m512d)b.part[0]);
  return a;
#else
  each_part([&](int p) { b.part[p] = b.part[p] < a.part[p] ? a.part[p] : b.part[p]; });
  return b;
#endif
}
inline Doubles positive_part(Doubles a) { return max(a, Doubles(0.0)); }

inline float sqrt(float a) { return __builtin_sqrtf(a); }
inline Singles sqrt(Singles a) {
#if defined(__AVX512F__)
  a.part[0] = (SingleRegister)_mm512_sqrt_ps((__m512)a.part[0]);
#elif defined(__AVX2__)
  each_part([&](int p) { a.part[p] = (SingleRegister)_mm256_sqrt_ps((__m256)a.part[p]); });
#elif defined(__SSE2__)
  each_part([&](int p) { a.part[p] = (SingleRegister)_mm_sqrt_ps((__m128)a.part[p]); });
#else
  for (SingleRegister& v : a.part)
    for (int l = 0; l < 16 / parts; ++l) v[l] = __builtin_sqrtf(v[l]);
#endif
  return a;
}

/// Singles 0 to 7 (half 0) or 8 to 15 (half 1).
template <int half>
inline Doubles widen(Singles a) {
  Doubles r;
#if defined(__AVX512F__)
  r.part[0] = (DoubleRegister)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)a.part[0], half));
#elif defined(__AVX2__)
  r.part[0] = (DoubleRegister)_mm256_cvtps_pd(_mm256_castps256_ps128((__m256)a.part[half]));
  r.part[1] = (DoubleRegister)_mm256_cvtps_pd(_mm256_extractf128_ps((__m256)a.part[half], 1));
#elif defined(__SSE2__)
  for (int p = 0; p < 2; ++p) {
    const __m128 s = (__m128)a.part[2 * half + p];
    r.part[2 * p] = (DoubleRegister)_mm_cvtps_pd(s), r.part[2 * p + 1] = (DoubleRegister)_mm_cvtps_pd(_mm_movehl_ps(s, s));
  }
#else
  for (int p = 0; p < 2; ++p)
    for (int l = 0; l < 4; ++l) r.part[2 * p + l / 2][l % 2] = a.part[2 * half + p][l];
#endif
  return r;
}
inline Singles narrow(Doubles low, Doubles high) {
  Singles r;
#if defined(__AVX512F__)
  r.part[0] = (SingleRegister)_mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)low.part[0])), _mm512_cvtpd_ps((__m512d)high.part[0]), 1);
#elif defined(__AVX2__)
  const auto join = [](Doubles a) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps((__m256d)a.part[0])), _mm256_cvtpd_ps((__m256d)a.part[1]), 1);
  };
  r.part[0] = (SingleRegister)join(low), r.part[1] = (SingleRegister)join(high);
#elif defined(__SSE2__)
  const auto join = [](DoubleRegister a, DoubleRegister b) { return (SingleRegister)_mm_movelh_ps(_mm_cvtpd_ps((__m128d)a), _mm_cvtpd_ps((__m128d)b)); };
  r.part[0] = join(low.part[0], low.part[1]), r.part[1] = join(low.part[2], low.part[3]);
  r.part[2] = join(high.part[0], high.part[1]), r.part[3] = join(high.part[2], high.part[3]);
#else
  for (int l = 0; l < 16; ++l) r.part[l / 4][l % 4] = static_cast<float>((l < 8 ? low : high).part[l % 8 / 2][l % 2]);
#endif
  return r;
}

/// The sum of eight lanes, in one order: halves, halves of those, and so on.
inline double total(Doubles sum) {
  const Four four = first_four(sum) + last_four(sum);
  return (four[0] + four[2]) + (four[1] + four[3]);
}
/// The greatest of the lanes and zero.
inline float greatest(Singles m) {
  float a[16];
  max(m, Singles(0.0f)).store(a);
  for (int n = 8; n > 0; n /= 2)
    for (int l = 0; l < n; ++l) a[l] = max(a[l], a[l + n]);
  return a[0];
}

/// Rows of 32 bytes, each as four doubles, of eight indices: column by column.
[[gnu::always_inline]] inline void load_columns(const void* rows, const std::uint32_t* id, Doubles* out) {
  const auto row = [&](int l) { return reinterpret_cast<const double*>(static_cast<const char*>(rows) + std::size_t{id[l]} * 32); };
#if defined(__AVX512F__)
  // Lanes l and l + 2 share a register, so that the two transpositions below leave lanes in order.
  const auto two = [&](int l, int k) { return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(row(l))), _mm256_load_pd(row(k)), 1); };
  const __m512d a = two(0, 2), b = two(1, 3), c = two(4, 6), d = two(5, 7);
  const __m512d ab = _mm512_unpacklo_pd(a, b), ab_odd = _mm512_unpackhi_pd(a, b), cd = _mm512_unpacklo_pd(c, d), cd_odd = _mm512_unpackhi_pd(c, d);
  out[0].part[0] = (DoubleRegister)_mm512_shuffle_f64x2(ab, cd, 0x88);
  out[1].part[0] = (DoubleRegister)_mm512_shuffle_f64x2(ab_odd, cd_odd, 0x88);
  out[2].part[0] = (DoubleRegister)_mm512_shuffle_f64x2(ab, cd, 0xdd);
  out[3].part[0] = (DoubleRegister)_mm512_shuffle_f64x2(ab_odd, cd_odd, 0xdd);
#elif defined(__AVX2__)
  for (int p = 0; p < 2; ++p) {
    const __m256d a = _mm256_load_pd(row(4 * p)), b = _mm256_load_pd(row(4 * p + 1)), c = _mm256_load_pd(row(4 * p + 2)), d = _mm256_load_pd(row(4 * p + 3));
    const __m256d ab = _mm256_unpacklo_pd(a, b), ab_odd = _mm256_unpackhi_pd(a, b), cd = _mm256_unpacklo_pd(c, d), cd_odd = _mm256_unpackhi_pd(c, d);
    out[0].part[p] = (DoubleRegister)_mm256_permute2f128_pd(ab, cd, 0x20);
    out[1].part[p] = (DoubleRegister)_mm256_permute2f128_pd(ab_odd, cd_odd, 0x20);
    out[2].part[p] = (DoubleRegister)_mm256_permute2f128_pd(ab, cd, 0x31);
    out[3].part[p] = (DoubleRegister)_mm256_permute2f128_pd(ab_odd, cd_odd, 0x31);
  }
#else
  for (int l = 0; l < 8; l += 2)
    for (int k = 0; k < 4; k += 2) {
      const auto a = load_register<DoubleRegister>(row(l) + k), b = load_register<DoubleRegister>(row(l + 1) + k);
      out[k].part[l / 2] = __builtin_shufflevector(a, b, 0, 2);
      out[k + 1].part[l / 2] = __builtin_shufflevector(a, b, 1, 3);
    }
#endif
}

/// Doubles that are pairs of singles, of sixteen lanes: the first and the second of each pair.
[[gnu::always_inline]] inline void split_pairs(Doubles low, Doubles high, Singles& first, Singles& second) {
#if defined(__AVX512F__)
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30), odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
  const __m512 a = _mm512_castpd_ps((__m512d)low.part[0]), b = _mm512_castpd_ps((__m512d)high.part[0]);
  first.part[0] = (SingleRegister)_mm512_permutex2var_ps(a, even, b);
  second.part[0] = (SingleRegister)_mm512_permutex2var_ps(a, odd, b);
#elif defined(__AVX2__)
  const Doubles half[2] = {low, high};
  for (int p = 0; p < 2; ++p) {
    const __m256 a = _mm256_castpd_ps((__m256d)half[p].part[0]), b = _mm256_castpd_ps((__m256d)half[p].part[1]);
    const auto in_order = [](__m256 s) { return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(s), 0xd8)); };
    first.part[p] = (SingleRegister)in_order(_mm256_shuffle_ps(a, b, 0x88));
    second.part[p] = (SingleRegister)in_order(_mm256_shuffle_ps(a, b, 0xdd));
  }
#else
  for (int p = 0; p < 4; ++p) {
    const Doubles& half = p < 2 ? low : high;
    const SingleRegister a = (SingleRegister)half.part[p % 2 * 2], b = (SingleRegister)half.part[p % 2 * 2 + 1];
    first.part[p] = __builtin_shufflevector(a, b, 0, 2, 4, 6);
    second.part[p] = __builtin_shufflevector(a, b, 1, 3, 5, 7);
  }
#endif
}

/// Rows of three doubles and two singles, of sixteen indices.
[[gnu::always_inline]] inline void load_rows(const void* rows, const std::uint32_t* id, Doubles three[2][4], Singles& first, Singles& second) {
  load_columns(rows, id, three[0]);
  load_columns(rows, id + 8, three[1]);
  split_pairs(three[0][3], three[1][3], first, second);
}

/// Rows of eight singles, of sixteen indices.
[[gnu::always_inline]] inline void load_rows(const void* rows, const std::uint32_t* id, Singles out[8]) {
  Doubles pair[2][4];
  load_columns(rows, id, pair[0]);
  load_columns(rows, id + 8, pair[1]);
  for (int k = 0; k < 4; ++k) split_pairs(pair[0][k], pair[1][k], out[2 * k], out[2 * k + 1]);
}

/// One number at each of sixteen indices.
template <class L, class T>
[[gnu::always_inline]] inline L load_at(const T* a, const std::uint32_t* id) {
  const auto at = [&](int l) { return a[id[l]]; };
  // in registers: what is stored one by one cannot be loaded at once for a while
  L r;
#if defined(__AVX512F__)
  r.part[0] = typename L::Register{at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9), at(10), at(11), at(12), at(13), at(14), at(15)};
#elif defined(__AVX2__)
  for (int p = 0; p < 2; ++p)
    r.part[p] = typename L::Register{at(8 * p), at(8 * p + 1), at(8 * p + 2), at(8 * p + 3), at(8 * p + 4), at(8 * p + 5), at(8 * p + 6), at(8 * p + 7)};
#else
  for (int p = 0; p < 4; ++p) r.part[p] = typename L::Register{at(4 * p), at(4 * p + 1), at(4 * p + 2), at(4 * p + 3)};
#endif
  return r;
}

/// The first n of sixteen indices, `self` in place of the others.
[[gnu::always_inline]] inline void load_some(const std::uint32_t* from, std::size_t n, std::uint32_t self, std::uint32_t* to) {
#if defined(__AVX512F__)
  const __mmask16 m = static_cast<__mmask16>(n < 16 ? (1u << n) - 1 : 0xffffu);
  _mm512_store_si512(to, _mm512_mask_loadu_epi32(_mm512_set1_epi32(static_cast<int>(self)), m, from));
#else
  for (std::size_t l = 0; l < 16; ++l) to[l] = l < n ? from[l] : self;
#endif
}

#if defined(__AVX2__) && !defined(__AVX512F__)
inline void store_packed(void* to, unsigned bits, __m256i low, __m256i high) {
  const auto place = static_cast<std::uint32_t*>(to);
  const auto put = [](std::uint32_t* at, unsigned set, __m256i half) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(at), _mm256_permutevar8x32_epi32(half, core::EJECTA_ISA::packed_lanes(set)));
  };
  put(place, bits & 0xff, low);
  put(place + __builtin_popcount(bits & 0xff), bits >> 8, high);
}
#endif

/// Stores those of sixteen numbers whose bit is set. roomy: what lies behind them, up to sixteen, may be written over; else
/// nothing else is.
[[gnu::always_inline]] inline void store_some(std::uint32_t* to, unsigned bits, const std::uint32_t* from, [[maybe_unused]] bool roomy) {
#if defined(__AVX512F__)
  const auto first = static_cast<__mmask16>((1u << __builtin_popcount(bits)) - 1);
  _mm512_mask_storeu_epi32(to, first, _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), _mm512_load_si512(from)));
#else
#if defined(__AVX2__)
  if (roomy) {
    const auto half = reinterpret_cast<const __m256i*>(from);
    return store_packed(to, bits, _mm256_load_si256(half), _mm256_load_si256(half + 1));
  }
#endif
  for (; bits != 0; bits &= bits - 1) *to++ = from[__builtin_ctz(bits)];
#endif
}
[[gnu::always_inline]] inline void store_some(float* to, unsigned bits, Singles from, [[maybe_unused]] bool roomy) {
#if defined(__AVX512F__)
  const auto first = static_cast<__mmask16>((1u << __builtin_popcount(bits)) - 1);
  _mm512_mask_storeu_ps(to, first, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), (__m512)from.part[0]));
#else
#if defined(__AVX2__)
  if (roomy) return store_packed(to, bits, (__m256i)from.part[0], (__m256i)from.part[1]);
#endif
  float a[16];
  from.store(a);
  for (; bits != 0; bits &= bits - 1) *to++ = a[__builtin_ctz(bits)];
#endif
}

}  // namespace sph::EJECTA_ISA
