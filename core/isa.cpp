// SPDX-License-Identifier: Apache-2.0
#include "core/isa.hpp"

#include <cstdlib>
#include <cstring>

namespace core {

static Isa detect() {
  Isa best = Isa::baseline;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) best = Isa::avx2;
  if (best == Isa::avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    best = Isa::avx512;
#endif
  if (const char* wish = std::getenv("EJECTA_ISA")) {
    const Isa asked = !std::strcmp(wish, "baseline") ? Isa::baseline : !std::strcmp(wish, "avx2") ? Isa::avx2 : Isa::avx512;
    if (asked < best) best = asked;
  }
  return best;
}

Isa isa() {
  static const Isa chosen = detect();
  return chosen;
}

const char* isa_name() {
  const char* names[] = {"baseline", "avx2", "avx512"};
  return names[static_cast<int>(isa())];
}

}  // namespace core
