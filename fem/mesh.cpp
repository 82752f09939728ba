// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh.hpp"

#include <fmt/format.h>

#include <limits>

#include "core/error.hpp"
#include "core/rows.hpp"
#include "fem/element_kernel.hpp"

namespace fem {

using core::Vec3;

void add_empty_body(Mesh& mesh, int material) {
  const std::size_t n = mesh.nodes.size(), e = mesh.elements.size();
  mesh.body_nodes.push_back({n, n});
  mesh.body_elements.push_back({e, e});
  mesh.body_material.push_back(material);
}

void add_body(Mesh& mesh, HexMesh body, int material, double rho_0) {
  Nodes& n = mesh.nodes;
  Elements& e = mesh.elements;
  const std::size_t n0 = n.size(), e0 = e.size(), n1 = n0 + body.x.size(), count = body.node.size();
  const std::size_t e1 = e0 + (count + block_size - 1) / block_size * block_size;
  const std::size_t number = mesh.body_material.size();
  n.x.insert(n.x.end(), body.x.begin(), body.x.end());
  core::free_all(body.x);
  n.v.resize(n1, Vec3::Zero());
  n.v_mean.resize(n1, Vec3::Zero());
  n.m.resize(n1, 0.0);
  n.fixed.resize(n1, 0);
  n.awake.resize(n1, 1);
  // Padding rows repeat the last element's corners and stay dead, so that lanes never meet a hole.
  e.node.insert(e.node.end(), body.node.begin(), body.node.end());
  e.node.resize(e1, body.node.back());
  core::free_all(body.node);
  for (std::size_t el = e0; el < e1; ++el)
    for (auto& c : e.node[el]) c += static_cast<std::int32_t>(n0);
  e.alive.resize(e0 + count, 1);
  e.alive.resize(e1, 0);
  e.block_body.resize(e1 / block_size, static_cast<std::uint16_t>(number));
  mesh.n_alive += count;
  e.pt.resize(e1);
  e.deformation.resize(e1, 0.0);
  e.ratio_0.resize(e1, 1.0);
  e.dt.resize(e1, 1e300);
  e.dt_0.resize(e1, 0.0);
  element_volumes(mesh, e.volume_0);
  for (std::size_t el = e0; el < e1; ++el) {
    if (!(e.volume_0[el] > 0))
      throw core::CaseError(fmt::format("element {} of body {} has a volume of {:.3e} m3: its corners are not in order",
                                        el - e0, number, e.volume_0[el]));
    e.pt.m[el] = e.alive[el] ? rho_0 * e.volume_0[el] : 0.0;
    e.pt.rho[el] = rho_0;
  }
  mesh.body_nodes.push_back({n0, n1});
  mesh.body_elements.push_back({e0, e1});
  mesh.body_material.push_back(material);
}

void finish(Mesh& mesh) {
  Nodes& n = mesh.nodes;
  Elements& e = mesh.elements;
  e.corner_force.resize((e.n_blocks() + blocks_in_chunk - 1) / blocks_in_chunk);
  constexpr std::size_t most_chunks = std::numeric_limits<std::uint32_t>::max() / numbers_in_chunk;
  if (e.corner_force.size() > most_chunks)
    throw core::CaseError(fmt::format("{} elements: at most {} can be numbered; choose a lower fidelity", e.size(), most_chunks * blocks_in_chunk * block_size));
  core::sort_into_rows(
      n.size(),
      [&](auto&& put) {
        for (std::size_t el = 0; el < e.size(); ++el)
          if (e.alive[el])
            for (int i = 0; i < 8; ++i)
              put(static_cast<std::size_t>(e.node[el][static_cast<std::size_t>(i)]), static_cast<std::uint32_t>(corner_index(el, i, 0)));
      },
      mesh.corner_start, mesh.corners);
  std::fill(n.m.begin(), n.m.end(), 0.0);
  for (std::size_t el = 0; el < e.size(); ++el)
    if (e.alive[el])
      for (const auto node : e.node[el]) n.m[static_cast<std::size_t>(node)] += 0.125 * e.pt.m[el];
  mesh.block_awake.assign(e.n_blocks(), 1);
  mesh.awake_blocks.resize(e.n_blocks());
  for (std::size_t b = 0; b < e.n_blocks(); ++b) mesh.awake_blocks[b] = static_cast<std::uint32_t>(b);
  mesh.body_awake.assign(mesh.body_nodes.size(), 1);
  mesh.body_box.assign(mesh.body_nodes.size(), {});
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b)
    for (std::size_t nd = mesh.body_nodes[b].first; nd < mesh.body_nodes[b].last; ++nd) mesh.body_box[b].add(n.x[nd]);
}

void make_room_for_forces(Mesh& mesh) {
  for (std::size_t b = 0; b < mesh.block_awake.size(); ++b)
    if (auto& chunk = mesh.elements.corner_force[b / blocks_in_chunk]; mesh.block_awake[b] && chunk.empty())
      chunk.assign(blocks_in_chunk * 24 * block_size, 0.0);
}

Mesh emptied(const Mesh& mesh) {
  Mesh r;
  for (const int material : mesh.body_material) add_empty_body(r, material);
  finish(r);
  return r;
}

void forget_pushes(Nodes& n) {
  n.row_of_f.resize(n.size(), Nodes::not_pushed);
  for (const auto nd : n.pushed) n.row_of_f[nd] = Nodes::not_pushed;
  n.pushed.clear();
  n.f.clear();
}

void push(Nodes& n, std::size_t nd, const Vec3& force) {
  auto& row = n.row_of_f[nd];
  if (row == Nodes::not_pushed) {
    row = static_cast<std::uint32_t>(n.f.size());
    n.pushed.push_back(static_cast<std::uint32_t>(nd));
    n.f.push_back(Vec3::Zero());
  }
  n.f[row] += force;
}

void remove_element(Mesh& mesh, std::size_t el, bool keep_mass) {
  Elements& e = mesh.elements;
  e.alive[el] = 0;
  e.dt[el] = 1e300;
  e.pt.q[el] = 0;
  if (double* force = force_of(e, corner_index(el, 0, 0)))
    for (std::size_t k = 0; k < 24; ++k) force[k * block_size] = 0;
  --mesh.n_alive;
  ++mesh.n_removed;
  if (keep_mass) return;
  // The mass left is summed anew from the elements alive, so that it never drifts and ends at exactly zero.
  for (const auto node : e.node[el]) {
    const auto nd = static_cast<std::size_t>(node);
    double m = 0;
    for (const auto other : elements_at(mesh, nd))
      if (e.alive[other]) m += 0.125 * e.pt.m[other];
    mesh.nodes.m[nd] = m;
  }
}

}  // namespace fem
