// SPDX-License-Identifier: Apache-2.0
#include "fem/elements.hpp"

#include <algorithm>

namespace fem {

using core::Vec3;

void kick_nodes(Mesh& mesh, double dt) {
  Nodes& n = mesh.nodes;
  for_each_node_awake(mesh, [&](std::size_t nd) {
    if (!n.awake[nd] || n.m[nd] == 0) return;
    const Vec3 dv = free_part(force_at(mesh, nd) * (dt / n.m[nd]), n.fixed[nd]);
    n.v_mean[nd] = n.v[nd] + 0.5 * dv;
    n.v[nd] += dv;
  });
}

void keep_in_front(const core::Symmetry& symmetry, Mesh& mesh) {
  Nodes& n = mesh.nodes;
  for (std::size_t d = 0; d < 3; ++d) {
    if (!symmetry.plane[d]) continue;
    const auto axis = static_cast<Eigen::Index>(d);
    core::for_each(n.size(), [&](std::size_t nd) {
      if (!(n.x[nd][axis] < 0) || !(n.m[nd] > 0) || (n.fixed[nd] & 1 << d) || belongs_to_elements(mesh, nd)) return;
      for (auto* a : {&n.x, &n.v, &n.v_mean}) (*a)[nd][axis] *= -1;
    });
  }
}

void drift_nodes(Mesh& mesh, double dt) {
  Nodes& n = mesh.nodes;
  for_each_node_awake(mesh, [&](std::size_t nd) {
    if (n.awake[nd] && n.m[nd] > 0) n.x[nd] += n.v[nd] * dt;
  });
}

static ElementSums update_blocks(Mesh& mesh, std::span<const std::uint32_t> blocks, const std::vector<material::Material>& materials,
                                 const ElementSettings& settings, const StepTimes& times, std::span<const std::uint8_t> ring) {
  ElementSums total;
  constexpr std::size_t chunk = 16;
  std::vector<ElementSums> part;
  std::vector<std::size_t> chunks;  // first of each in the list
  for (std::size_t body = 0; body < mesh.body_elements.size(); ++body) {
    const auto range = mesh.body_elements[body];
    const auto first = std::lower_bound(blocks.begin(), blocks.end(), range.first / block_size),
               last = std::lower_bound(first, blocks.end(), range.last / block_size);
    // chunks by place in the mesh and not among those awake: sums have the same bits whatever sleeps
    chunks.clear();
    for (auto at = first; at != last; ++at)
      if (at == first || *at / chunk != at[-1] / chunk) chunks.push_back(static_cast<std::size_t>(at - blocks.begin()));
    part.assign(chunks.size(), {});
    chunks.push_back(static_cast<std::size_t>(last - blocks.begin()));
    const auto& material = materials[static_cast<std::size_t>(mesh.body_material[body])];
    core::for_each_block(part.size(), 1, [&](std::size_t k, std::size_t) {
      part[k] = update_elements(mesh, material, settings, times, ring, blocks.subspan(chunks[k], chunks[k + 1] - chunks[k]));
    });
    for (const auto& p : part) total.hourglass += p.hourglass;
  }
  return total;
}

ElementSums update_awake_elements(Mesh& mesh, const std::vector<material::Material>& materials,
                                  const ElementSettings& settings, const StepTimes& times, std::span<const std::uint8_t> ring) {
  return update_blocks(mesh, mesh.awake_blocks, materials, settings, times, ring);
}

/// The sorted list of awake blocks in which something is alive, with room for their forces, and which bodies have any awake.
static void list_awake(Mesh& mesh) {
  mesh.awake_blocks.clear();
  for (std::size_t body = 0; body < mesh.body_elements.size(); ++body) {
    const std::size_t before = mesh.awake_blocks.size();
    for (std::size_t b = mesh.body_elements[body].first / block_size; b < mesh.body_elements[body].last / block_size; ++b)
      if (mesh.block_awake[b]) mesh.awake_blocks.push_back(static_cast<std::uint32_t>(b));
    mesh.body_awake[body] = mesh.awake_blocks.size() > before;
  }
  drop_dead_blocks(mesh);
  make_room_for_forces(mesh);
}

static bool wake_block(Mesh& mesh, std::size_t b) {
  if (mesh.block_awake[b]) return false;
  mesh.block_awake[b] = 1;
  for (std::size_t el = b * block_size; el < (b + 1) * block_size; ++el)
    for (const auto nd : mesh.elements.node[el]) mesh.nodes.awake[static_cast<std::size_t>(nd)] = 1;
  return true;
}

/// Is any node of the block in motion?
static bool moves(const Mesh& mesh, std::size_t block) {
  for (std::size_t el = block * block_size; el < (block + 1) * block_size; ++el)
    for (const auto nd : mesh.elements.node[el])
      if (!mesh.nodes.v[static_cast<std::size_t>(nd)].isZero(0)) return true;
  return false;
}

static bool under_pressure(const Mesh& mesh, std::size_t block) {
  const auto p = mesh.elements.pt.p.begin() + static_cast<std::ptrdiff_t>(block * block_size);
  return std::any_of(p, p + block_size, [](double a) { return a != 0; });
}

void begin_elements(Mesh& mesh, const std::vector<material::Material>& materials, const ElementSettings& settings, bool may_sleep) {
  const StepTimes none{0.0, 1e-18};
  const std::vector<std::uint32_t> all = mesh.awake_blocks;
  if (may_sleep) {
    std::fill(mesh.nodes.awake.begin(), mesh.nodes.awake.end(), 0);
    std::fill(mesh.block_awake.begin(), mesh.block_awake.end(), 0);
    for (const auto b : all)
      if (moves(mesh, b)) wake_block(mesh, b);
    list_awake(mesh);
  } else {
    make_room_for_forces(mesh);
  }
  update_blocks(mesh, all, materials, settings, none, {});
  std::vector<std::uint32_t> about_to_move;  // had no room for their forces
  for (const auto b : all)
    if (under_pressure(mesh, b) && wake_block(mesh, b)) about_to_move.push_back(b);
  if (about_to_move.empty()) return;
  list_awake(mesh);
  update_blocks(mesh, about_to_move, materials, settings, none, {});
}

void wake_moving(Mesh& mesh, double threshold, bool struck_bodies) {
  if (mesh.awake_blocks.size() == mesh.block_awake.size()) return;
  const double limit = threshold * threshold;
  const Nodes& n = mesh.nodes;
  std::vector<std::uint8_t> struck(mesh.block_awake.size());
  for (std::size_t body = 0; body < mesh.body_elements.size(); ++body) {
    if (!mesh.body_awake[body] && !struck_bodies) continue;
    const std::size_t first = mesh.body_elements[body].first / block_size;
    core::for_each(mesh.body_elements[body].size() / block_size, [&](std::size_t k) {
      const std::size_t b = first + k;
      if (mesh.block_awake[b]) return;
      for (std::size_t el = b * block_size; el < (b + 1) * block_size; ++el)
        for (const auto node : mesh.elements.node[el]) {
          const auto nd = static_cast<std::size_t>(node);
          if (n.awake[nd] && mesh.elements.alive[el] && n.v[nd].squaredNorm() > limit) struck[b] = 1;
        }
    });
  }
  bool woke = false;
  for (std::size_t b = 0; b < struck.size(); ++b)
    if (struck[b]) woke |= wake_block(mesh, b);
  if (woke) list_awake(mesh);
}

void wake_elements(Mesh& mesh, std::span<const std::uint32_t> elements) {
  bool woke = false;
  for (const auto el : elements) woke |= wake_block(mesh, el / block_size);
  if (woke) list_awake(mesh);
}

void drop_dead_blocks(Mesh& mesh) {
  std::erase_if(mesh.awake_blocks, [&](std::uint32_t b) {
    for (std::size_t el = b * block_size; el < (b + 1) * block_size; ++el)
      if (mesh.elements.alive[el]) return false;
    return true;
  });
}

core::MinWhere stable_step(const Mesh& mesh, std::size_t body) {
  const core::Range range = mesh.body_elements[body];
  const double* dt = mesh.elements.dt.data() + range.first;
  auto r = core::min_where(range.size(), [&](std::size_t k) { return dt[k]; });
  r.index += range.first;
  return r;
}

bool at_rest(const Mesh& mesh, std::size_t body) {
  if (!mesh.body_awake[body]) return true;
  const Elements& e = mesh.elements;
  for (std::size_t el = mesh.body_elements[body].first; el < mesh.body_elements[body].last; ++el)
    if (e.alive[el] && (e.deformation[el] > 0 || e.pt.p[el] != 0)) return false;
  for (std::size_t nd = mesh.body_nodes[body].first; nd < mesh.body_nodes[body].last; ++nd)
    if (!mesh.nodes.v[nd].isZero(0)) return false;
  return true;
}

}  // namespace fem
