// SPDX-License-Identifier: Apache-2.0
// AVX2 has no compress-store: a table says which of eight lanes go first. For kernels compiled for each instruction set.
#pragma once

#if defined(__AVX2__) && !defined(__AVX512F__)
#include <immintrin.h>

#include <cstdint>

namespace core::EJECTA_ISA {

struct Packing {  // for each set of lanes the lanes that are in it, in order, a byte each
  std::uint64_t lane[256];
  constexpr Packing() : lane{} {
    for (unsigned m = 0; m < 256; ++m)
      for (unsigned b = 0, at = 0; b < 8; ++b)
        if (m >> b & 1) lane[m] |= std::uint64_t{b} << (8 * at++);
  }
};
inline constexpr Packing packing;

/// Indices for a permutation that brings the lanes of a set (a bit each) to the front.
inline __m256i packed_lanes(unsigned set) { return _mm256_cvtepu8_epi32(_mm_loadu_si64(&packing.lane[set])); }

}  // namespace core::EJECTA_ISA
#endif
