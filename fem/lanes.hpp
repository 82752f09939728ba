// SPDX-License-Identifier: Apache-2.0
// W consecutive elements in lanes: for sources that are compiled once for each instruction set (CMakeLists.txt).
#pragma once

#include <cstring>

#include "core/isa.hpp"
#include "core/pack.hpp"
#include "fem/mesh.hpp"

namespace fem::EJECTA_ISA {

using Real = core::Pack<core::native_lanes>;
using Lanes = core::Mask<core::native_lanes>;
constexpr int W = core::native_lanes;
static_assert(block_size % W == 0);

using Index = const std::int32_t (*)[8];

/// The eight corners' nodes of W consecutive elements.
inline Index nodes_of(const Elements& e, std::size_t el) { return reinterpret_cast<Index>(e.node[el].data()); }

/// A node array at corner i of W consecutive elements.
[[gnu::always_inline]] inline void gather_corner(Index node, int i, const double* a, Real out[3]) {
  const double* at[W];
  for (int l = 0; l < W; ++l) at[l] = a + 3 * static_cast<std::size_t>(node[l][i]);
  core::load_vectors<W>(at, out);
}

/// Which of W consecutive elements are alive.
inline Lanes alive_lanes(const Elements& e, std::size_t el) {
  alignas(64) std::int64_t alive[W];
  for (int l = 0; l < W; ++l) alive[l] = -static_cast<std::int64_t>(e.alive[el + static_cast<std::size_t>(l)]);
  Lanes r;
  std::memcpy(&r.m, alive, sizeof r.m);
  return r;
}

}  // namespace fem::EJECTA_ISA
