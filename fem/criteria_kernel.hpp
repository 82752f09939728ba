// SPDX-License-Identifier: Apache-2.0
// The criteria in lanes: one look at blocks of elements. A lane's verdict is the same on every instruction set.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/criteria.hpp"

namespace fem {

/// Flags of each block, one bit an element, into flags[blocks.size()]. criteria, rho_0 [kg/m3] and from [-] as in
/// flag_elements.
void flag_blocks(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0, double from,
                 std::span<const std::uint32_t> blocks, std::uint8_t* flags);

}  // namespace fem
