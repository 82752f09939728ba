// SPDX-License-Identifier: Apache-2.0
// The loops over nodes and elements: kick, drift, update, sleep. The physics of one element is in element_kernel.hpp.
#pragma once

#include <span>
#include <vector>

#include "core/parallel.hpp"
#include "fem/element_kernel.hpp"
#include "fem/mesh.hpp"

namespace fem {

/// v(n-1/2) -> v(n+1/2) by the corner forces and those of bonded particles of time n over `dt`; leaves v_mean, the mean of both, with which
/// the forces do their work. Corner forces are gathered in fixed order.
void kick_nodes(Mesh& mesh, double dt);

/// x(n) -> x(n+1) with v(n+1/2).
void drift_nodes(Mesh& mesh, double dt);

/// Elements of all awake blocks to n + 1. materials[mesh.body_material[body]]; ring: as in element_kernel.hpp.
ElementSums update_awake_elements(Mesh& mesh, const std::vector<material::Material>& materials,
                                  const ElementSettings& settings, const StepTimes& times, std::span<const std::uint8_t> ring = {});

/// The first states of elements: a step of no length by the routine that all later steps use. What rests and is under no pressure goes
/// to sleep if it may.
void begin_elements(Mesh& mesh, const std::vector<material::Material>& materials, const ElementSettings& settings, bool may_sleep);

/// Nodes without elements that have passed a symmetry plane change places with their images, as particles do.
void keep_in_front(const core::Symmetry& symmetry, Mesh& mesh);

/// Wakes the elements at every node that moves faster than `threshold` [m/s]. A block wakes as a whole. Bodies of which
/// everything is asleep are looked at where contact may have struck them.
void wake_moving(Mesh& mesh, double threshold, bool struck_bodies);

/// Wakes the blocks of these elements.
void wake_elements(Mesh& mesh, std::span<const std::uint32_t> elements);

/// Blocks in which nothing is alive any more leave the list.
void drop_dead_blocks(Mesh& mesh);

/// Rows of awake blocks.
inline std::size_t n_awake(const Mesh& mesh) { return mesh.awake_blocks.size() * block_size; }

/// The smallest stable step [s] of a body's elements and where; those asleep count with their first one.
core::MinWhere stable_step(const Mesh& mesh, std::size_t body);

/// Nothing of the body moves, has ever been strained or is under pressure.
bool at_rest(const Mesh& mesh, std::size_t body);

}  // namespace fem
