// SPDX-License-Identifier: Apache-2.0
// exp, log, pow and cbrt on doubles and packs: the same source, hence the same bits, for one point and for lanes.
// Source: argument reductions and rational approximations of S. L. Moshier, Cephes Mathematical Library (1984-2000),
// exp.c and log.c; relative error below 3e-16 over the ranges stated.
#pragma once

#include "core/pack.hpp"

namespace core {

/// e^x for |x| < 708; beyond that it saturates at e^+-708.
template <class T>
T exp(T x) {
  x = min(max(x, T(-708.0)), T(708.0));
  const T magic = T(6755399441055744.0);  // 1.5 * 2^52: adding it rounds to an integer in the low bits
  const T shifted = x * T(1.4426950408889634073599) + magic;
  const T k = shifted - magic;
  x = x - k * T(6.93145751953125e-1);
  x = x - k * T(1.42860682030941723212e-6);
  const T xx = x * x;
  const T px = x * ((T(1.26177193074810590878e-4) * xx + T(3.02994407707441961300e-2)) * xx +
                    T(9.99999999999999999910e-1));
  const T qx = ((T(3.00198505138664455042e-6) * xx + T(2.52448340349684104192e-3)) * xx +
                T(2.27265548208155028766e-1)) * xx + T(2.00000000000000000009e0);
  const T r = T(1.0) + T(2.0) * (px / (qx - px));
  return r * from_bits((bits(shifted) + 1023) << 52, r);
}

/// ln x for normal x > 0. For x <= 0 the result has no meaning: guard before.
template <class T>
T log(T x) {
  // x = m 2^k with m in [sqrt(1/2), sqrt(2))
  const auto u = bits(x);
  const auto shift = u - 0x3fe6a09e667f3bcdLL;
  const auto k_bits = shift >> 52;  // arithmetic shift: floor
  const T m = from_bits(u - (k_bits << 52), x);
  const T magic = T(6755399441055744.0);
  const T k = from_bits(bits(magic) + k_bits, x) - magic;
  const T f = m - T(1.0);
  const T z = f * f;
  const T p = ((((T(1.01875663804580931796e-4) * f + T(4.97494994976747001425e-1)) * f +
                 T(4.70579119878881725854e0)) * f + T(1.44989225341610930846e1)) * f +
               T(1.79368678507819816313e1)) * f + T(7.70838733755885391666e0);
  const T q = ((((f + T(1.12873587189167450590e1)) * f + T(4.52279145837532221105e1)) * f +
                T(8.29875266912776603211e1)) * f + T(7.11544750618563894466e1)) * f +
              T(2.31251620126765340583e1);
  T y = f * (z * (p / q));
  y = y - k * T(2.121944400546905827679e-4);
  y = y - T(0.5) * z;
  return (f + y) + k * T(0.693359375);
}

/// x^y for x >= 0; 0^y is 0 for every y that a material law uses (y > 0).
template <class T>
T pow(T x, T y) {
  const T tiny = T(1e-300);
  return select(x > tiny, exp(y * log(max(x, tiny))), T(0.0));
}
template <class T>
T cbrt(T x) { return pow(x, T(1.0 / 3.0)); }

}  // namespace core
