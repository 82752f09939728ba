// SPDX-License-Identifier: Apache-2.0
// SIMD lanes: Pack<W> is W doubles that behave like one. Kernels are written once as templates on the number type T
// and are instantiated for double (one point) and for packs as wide as the instruction set that a source file is built
// for. Every operation is correctly rounded and no multiply-add is fused (-ffp-contract=off), so a lane's result has
// the same bits at every width.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace core {

template <int W>
struct LaneType;  // the compilers' vector extension, one width each (g++ 12 drops a size that depends on W)
template <>
struct LaneType<2> {
  typedef double Real __attribute__((vector_size(16)));
  typedef std::int64_t Int __attribute__((vector_size(16)));
};
template <>
struct LaneType<4> {
  typedef double Real __attribute__((vector_size(32)));
  typedef std::int64_t Int __attribute__((vector_size(32)));
};
template <>
struct LaneType<8> {
  typedef double Real __attribute__((vector_size(64)));
  typedef std::int64_t Int __attribute__((vector_size(64)));
};

template <int W>
struct Mask {
  using Bits = typename LaneType<W>::Int;
  Bits m;
  friend Mask operator&(Mask a, Mask b) { return {a.m & b.m}; }
  friend Mask operator|(Mask a, Mask b) { return {a.m | b.m}; }
  friend Mask operator!(Mask a) { return {~a.m}; }
  bool operator[](int lane) const { return m[lane] != 0; }
};

template <int W>
struct Pack {
  using Real = typename LaneType<W>::Real;
  using Bits = typename LaneType<W>::Int;
  static constexpr int width = W;
  Real v;

  Pack() = default;
  Pack(double a) : v(a - Real{}) {}  // broadcast; a - 0 keeps the sign of a negative zero
  explicit Pack(Real a) : v(a) {}

  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double a) { v[lane] = a; }

  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
  Pack& operator+=(Pack b) { v += b.v; return *this; }
  Pack& operator-=(Pack b) { v -= b.v; return *this; }
  Pack& operator*=(Pack b) { v *= b.v; return *this; }
  friend Mask<W> operator<(Pack a, Pack b) { return {a.v < b.v}; }
  friend Mask<W> operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend Mask<W> operator<=(Pack a, Pack b) { return {a.v <= b.v}; }
  friend Mask<W> operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
};

template <class T>
struct Lanes {  // how many points one T holds
  static constexpr int width = 1;
};
template <int W>
struct Lanes<Pack<W>> {
  static constexpr int width = W;
};

inline double select(bool m, double a, double b) { return m ? a : b; }
template <int W>
Pack<W> select(Mask<W> m, Pack<W> a, Pack<W> b) {
  return Pack<W>(typename Pack<W>::Real(m.m ? a.v : b.v));
}
template <int W>
Pack<W> select(Mask<W> m, double a, Pack<W> b) { return select(m, Pack<W>(a), b); }
template <int W>
Pack<W> select(Mask<W> m, Pack<W> a, double b) { return select(m, a, Pack<W>(b)); }

inline bool any(bool m) { return m; }
template <int W>
bool any(Mask<W> m) {
#ifdef __AVX512F__
  if constexpr (W == 8) return _mm512_test_epi64_mask((__m512i)m.m, (__m512i)m.m) != 0;
#endif
#ifdef __AVX__
  if constexpr (W == 4) return _mm256_movemask_pd((__m256d)m.m) != 0;
#endif
  std::int64_t r = 0;
  for (int i = 0; i < W; ++i) r |= m.m[i];
  return r != 0;
}

/// min and max return b where either is NaN or both are equal, in every width alike: what the processor's instructions do.
template <class T>
T min(T a, T b) { return select(a < b, a, b); }
template <class T>
T max(T a, T b) { return select(a > b, a, b); }
template <int W>
Pack<W> min(Pack<W> a, Pack<W> b) {
  using Real [[maybe_unused]] = typename Pack<W>::Real;
#ifdef __AVX512F__
  if constexpr (W == 8) return Pack<W>((Real)_mm512_min_pd((__m512d)a.v, (__m512d)b.v));
#endif
#ifdef __AVX__
  if constexpr (W == 4) return Pack<W>((Real)_mm256_min_pd((__m256d)a.v, (__m256d)b.v));
#endif
  return select(a < b, a, b);
}
template <int W>
Pack<W> max(Pack<W> a, Pack<W> b) {
  using Real [[maybe_unused]] = typename Pack<W>::Real;
#ifdef __AVX512F__
  if constexpr (W == 8) return Pack<W>((Real)_mm512_max_pd((__m512d)a.v, (__m512d)b.v));
#endif
#ifdef __AVX__
  if constexpr (W == 4) return Pack<W>((Real)_mm256_max_pd((__m256d)a.v, (__m256d)b.v));
#endif
  return select(a > b, a, b);
}
template <int W>
Pack<W> min(Pack<W> a, double b) { return min(a, Pack<W>(b)); }
template <int W>
Pack<W> max(Pack<W> a, double b) { return max(a, Pack<W>(b)); }

template <class T>
T abs(T a) { return max(a, -a); }

inline double sqrt(double a) { return std::sqrt(a); }
template <int W>
Pack<W> sqrt(Pack<W> a) {
#ifdef __AVX512F__
  if constexpr (W == 8) return Pack<W>((typename Pack<W>::Real)_mm512_sqrt_pd((__m512d)a.v));
#endif
#ifdef __AVX__
  if constexpr (W == 4) return Pack<W>((typename Pack<W>::Real)_mm256_sqrt_pd((__m256d)a.v));
#endif
#ifdef __SSE2__
  if constexpr (W == 2) return Pack<W>((typename Pack<W>::Real)_mm_sqrt_pd((__m128d)a.v));
#endif
  Pack<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = std::sqrt(a.v[i]);
  return r;
}

/// W consecutive doubles.
template <class T>
T load(const double* a) {
  T r;
  std::memcpy(&r, a, sizeof(T));
  return r;
}
template <class T>
void store(double* a, T v) { std::memcpy(a, &v, sizeof(T)); }

/// Three-vectors at W places, turned round: lane l of out[d] is at[l][d]. Reads nothing beyond the three.
template <int W>
void load_vectors(const double* const at[W], Pack<W> out[3]) {
#ifdef __AVX512VL__
  if constexpr (W == 8) {
    // Lanes l and l + 2 share a register, so that the two transpositions below leave lanes in order.
    const auto pair = [&](int l, int k) {
      return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_maskz_loadu_pd(7, at[l])), _mm256_maskz_loadu_pd(7, at[k]), 1);
    };
    const __m512d a = pair(0, 2), b = pair(1, 3), c = pair(4, 6), d = pair(5, 7);
    const __m512d xz_low = _mm512_unpacklo_pd(a, b), y_low = _mm512_unpackhi_pd(a, b);
    const __m512d xz_high = _mm512_unpacklo_pd(c, d), y_high = _mm512_unpackhi_pd(c, d);
    out[0] = Pack<W>((typename Pack<W>::Real)_mm512_shuffle_f64x2(xz_low, xz_high, 0x88));
    out[1] = Pack<W>((typename Pack<W>::Real)_mm512_shuffle_f64x2(y_low, y_high, 0x88));
    out[2] = Pack<W>((typename Pack<W>::Real)_mm512_shuffle_f64x2(xz_low, xz_high, 0xdd));
    return;
  }
#endif
#ifdef __AVX__
  if constexpr (W == 4) {
    const auto halves = [](__m128d low, __m128d high) { return _mm256_insertf128_pd(_mm256_castpd128_pd256(low), high, 1); };
    const auto thirds = [&](int l, int k) { return _mm_loadh_pd(_mm_load_sd(at[l] + 2), at[k] + 2); };
    const __m256d even = halves(_mm_loadu_pd(at[0]), _mm_loadu_pd(at[2])), odd = halves(_mm_loadu_pd(at[1]), _mm_loadu_pd(at[3]));
    out[0] = Pack<W>((typename Pack<W>::Real)_mm256_unpacklo_pd(even, odd));
    out[1] = Pack<W>((typename Pack<W>::Real)_mm256_unpackhi_pd(even, odd));
    out[2] = Pack<W>((typename Pack<W>::Real)halves(thirds(0, 1), thirds(2, 3)));
    return;
  }
#endif
  for (int l = 0; l < W; ++l)
    for (int d = 0; d < 3; ++d) out[d].v[l] = at[l][d];
}

/// One lane of a number that may be a plain double.
inline double lane(double a, int) { return a; }
template <int W>
double lane(Pack<W> a, int i) { return a.v[i]; }
inline bool lane(bool a, int) { return a; }
template <int W>
bool lane(Mask<W> a, int i) { return a.m[i] != 0; }

// Bit-level access for lane_math.hpp.
inline std::int64_t bits(double a) {
  std::int64_t r;
  std::memcpy(&r, &a, 8);
  return r;
}
inline double from_bits(std::int64_t b, double) {
  double r;
  std::memcpy(&r, &b, 8);
  return r;
}
template <int W>
typename Pack<W>::Bits bits(Pack<W> a) { return (typename Pack<W>::Bits)a.v; }
template <int W>
Pack<W> from_bits(typename Pack<W>::Bits b, Pack<W>) { return Pack<W>((typename Pack<W>::Real)b); }

}  // namespace core
