// SPDX-License-Identifier: Apache-2.0
// From the moments of the kernel gradient to what particles bring into the pair sums: gradient corrections, corrected stress
// and artificial stress, in lanes of particles; compiled once for each instruction set and chosen at run time.
#pragma once

#include <cstddef>

#include "core/points.hpp"
#include "sph/pair_kernel.hpp"

namespace sph {

#define EJECTA_DECLARE(isa)                                                                                           \
  namespace isa {                                                                                                     \
  /** Rows [first, last): correction [row], acoustic share [row], and stress, artificial stress and kind of their actors. */ \
  void correct_rows(const core::Points&, double artificial_stress, std::size_t first, std::size_t last,               \
                    const Moment* moment, core::Mat3* correction, float* acoustic, Actors& actors);                      \
  }
EJECTA_DECLARE(baseline)
EJECTA_DECLARE(avx2)
EJECTA_DECLARE(avx512)
#undef EJECTA_DECLARE

}  // namespace sph
