// SPDX-License-Identifier: Apache-2.0
#include "fem/criteria.hpp"

#include <bit>

#include "core/parallel.hpp"
#include "fem/criteria_kernel.hpp"
#include "fem/hex8.hpp"

namespace fem {

static Corners<double> corners_of(const Mesh& mesh, std::size_t el) {
  Corners<double> x;
  gather(mesh.elements, el, mesh.nodes.x, [&](int i, int d, double v) { x.c[i][d] = v; });
  return x;
}

std::vector<std::uint32_t> flag_elements(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0,
                                         double from) {
  static_assert(block_size <= 8);
  constexpr std::size_t chunk = 128;
  std::vector<std::uint8_t> flags(mesh.awake_blocks.size());  // one bit an element
  const std::span<const std::uint32_t> blocks(mesh.awake_blocks);
  core::for_each_block(blocks.size(), chunk, [&](std::size_t first, std::size_t last) {
    flag_blocks(mesh, criteria, rho_0, from, blocks.subspan(first, last - first), &flags[first]);
  });
  std::vector<std::uint32_t> flagged;
  for (std::size_t b = 0; b < flags.size(); ++b)
    for (unsigned left = flags[b]; left != 0; left &= left - 1)
      flagged.push_back(static_cast<std::uint32_t>(mesh.awake_blocks[b] * block_size + static_cast<std::size_t>(std::countr_zero(left))));
  return flagged;
}

void store_initial_shape(Mesh& mesh) {
  core::for_each(mesh.elements.size(),
                 [&](std::size_t el) { mesh.elements.ratio_0[el] = jacobian_ratio(edges(corners_of(mesh, el))); });
}

}  // namespace fem
