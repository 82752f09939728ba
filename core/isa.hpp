// SPDX-License-Identifier: Apache-2.0
// Which instruction set this machine has. Kernels exist once for each set, in a namespace of that name, and are chosen
// at run time; EJECTA_ISA=baseline|avx2|avx512 in the environment asks for a narrower one.
#pragma once

namespace core {

enum class Isa { baseline, avx2, avx512 };

/// The widest set that the processor has and the environment allows. Constant during a run.
Isa isa();
const char* isa_name();

/// Lanes of double in a kernel file compiled for one instruction set.
#if defined(__AVX512F__)
constexpr int native_lanes = 8;
#elif defined(__AVX2__)
constexpr int native_lanes = 4;
#else
constexpr int native_lanes = 2;
#endif

}  // namespace core
