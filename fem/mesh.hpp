// SPDX-License-Identifier: Apache-2.0
// The finite-element half of the state: nodes, elements, and who touches whom. Plain named arrays.
// Time levels: positions, stress and energy's pressure at n; velocities at n - 1/2 (between the steps).
// Elements lie in blocks of eight (one body, one material a block; the last block of a body is padded with dead rows),
// so that a block fills whole SIMD lanes of any width and corner forces are stored lane by lane.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/aligned.hpp"
#include "core/box.hpp"
#include "core/parallel.hpp"
#include "core/points.hpp"
#include "core/types.hpp"
#include "fem/generate.hpp"

namespace fem {

constexpr std::size_t block_size = 8;
constexpr std::size_t blocks_in_chunk = 8;      ///< whose corner forces are stored together
constexpr std::size_t numbers_in_chunk = 2048;  ///< of those forces, not all of them used: a power of two, for the kick looks each of them up

struct Nodes {
  std::vector<core::Vec3> x;        ///< position [m]
  std::vector<core::Vec3> v;        ///< velocity [m/s]
  std::vector<core::Vec3> v_mean;   ///< mean of the velocities before and after the last kick [m/s]: does the forces' work
  std::vector<std::uint32_t> pushed;  ///< nodes that bonded particles act on
  std::vector<core::Vec3> f;        ///< [pushed] what those do to them [N]
  std::vector<std::uint32_t> row_of_f;  ///< [node] where it stands in the two, or not_pushed; empty before the first particle
  std::vector<double> m;            ///< lumped mass of the elements alive [kg]; 0: no longer part of anything
  std::vector<std::uint8_t> fixed;  ///< bits 1, 2, 4: no motion along x, y, z (symmetry planes)
  std::vector<std::uint8_t> awake;  ///< 1 where an element at the node is awake
  static constexpr std::uint32_t not_pushed = 0xffffffff;
  std::size_t size() const { return m.size(); }
};

struct Elements {
  std::vector<std::array<std::int32_t, 8>> node;
  core::Points pt;
  std::vector<double> volume_0;     ///< volume as built [m3]
  std::vector<double> deformation;  ///< total deformation, integral of sqrt(2/3 D:D) dt [-]
  std::vector<double> ratio_0;      ///< Jacobian ratio as built [-]
  std::vector<double> dt;           ///< stable time step [s]; 1e300 where dead or asleep
  std::vector<double> dt_0;         ///< the first one [s]
  /// [block][corner * 3 + direction][lane] [N], of time n, in chunks. One of blocks that have all slept from the start is empty: what rests exerts no force.
  std::vector<core::Aligned<double>> corner_force;
  std::vector<double> booked;       ///< heat that stands in the ledger under names of its own, hourglass and contact [J]; empty unless elements erode
  std::vector<double> hourglass;    ///< [block][mode * 3 + direction][lane] [N]; empty unless the stiffness form is used
  std::vector<std::uint8_t> alive;  ///< 0: deleted, converted or padding
  std::vector<std::uint16_t> block_body;  ///< [block]
  std::size_t size() const { return node.size(); }
  std::uint16_t body(std::size_t el) const { return block_body[el / block_size]; }
  std::size_t n_blocks() const { return node.size() / block_size; }
};

/// Number in corner_force of component `direction` of the force at `corner` of element `el`.
inline std::size_t corner_index(std::size_t el, int corner, int direction) {
  const std::size_t block = el / block_size;
  return block / blocks_in_chunk * numbers_in_chunk + block % blocks_in_chunk * 24 * block_size +
         static_cast<std::size_t>(corner * 3 + direction) * block_size + el % block_size;
}

/// The force with that number; null where nothing has been awake.
inline double* force_of(Elements& e, std::size_t number) {
  auto& chunk = e.corner_force[number / numbers_in_chunk];
  return chunk.empty() ? nullptr : &chunk[number % numbers_in_chunk];
}
inline const double* force_of(const Elements& e, std::size_t number) {
  const auto& chunk = e.corner_force[number / numbers_in_chunk];
  return chunk.empty() ? nullptr : &chunk[number % numbers_in_chunk];
}

/// The element whose corner has its force there.
inline std::uint32_t element_of(std::uint32_t corner) {
  constexpr auto lanes = static_cast<std::uint32_t>(block_size), blocks = static_cast<std::uint32_t>(blocks_in_chunk), numbers = static_cast<std::uint32_t>(numbers_in_chunk);
  return (corner / numbers * blocks + corner % numbers / (24 * lanes)) * lanes + corner % lanes;
}

struct Mesh {
  Nodes nodes;
  Elements elements;
  std::vector<core::Range> body_elements;  ///< of every body, padding included
  std::vector<core::Range> body_nodes;
  std::vector<core::Box> body_box;         ///< around the nodes as built, where they stay while the body sleeps [m]
  std::vector<int> body_material;          ///< index into the simulation's materials
  std::vector<std::uint32_t> corner_start; ///< [nodes + 1] rows of corners
  std::vector<std::uint32_t> corners;      ///< numbers of their forces; elements ascend within a row
  std::vector<std::uint32_t> awake_blocks; ///< ascending
  std::vector<std::uint8_t> block_awake;
  std::vector<std::uint8_t> body_awake;    ///< 1 where a block of the body is awake; the nodes of others are at rest
  std::size_t n_alive = 0, n_removed = 0;
};

/// The elements of a row of corners.
struct ElementsOf {
  const std::uint32_t *first, *last;
  struct Iterator {
    const std::uint32_t* at;
    std::uint32_t operator*() const { return element_of(*at); }
    Iterator& operator++() { return ++at, *this; }
    bool operator!=(const Iterator& o) const { return at != o.at; }
  };
  Iterator begin() const { return {first}; }
  Iterator end() const { return {last}; }
};

/// The elements at a node, dead ones included, ascending.
inline ElementsOf elements_at(const Mesh& mesh, std::size_t nd) {
  return {mesh.corners.data() + mesh.corner_start[nd], mesh.corners.data() + mesh.corner_start[nd + 1]};
}

/// Is an element alive at a node? A node with mass and none is free.
inline bool belongs_to_elements(const Mesh& mesh, std::size_t nd) {
  for (const auto el : elements_at(mesh, nd))
    if (mesh.elements.alive[el]) return true;
  return false;
}

/// Appends one body at rest with its own nodes. Positions are final (rotated and moved). Throws core::CaseError naming
/// the first element whose volume is not positive.
void add_body(Mesh& mesh, HexMesh body, int material, double rho_0);

/// Adds an empty body, so that bodies keep their numbers where one is made of particles from the start.
void add_empty_body(Mesh& mesh, int material);

/// The same bodies with nothing in them: what is left where all are made of particles.
Mesh emptied(const Mesh& mesh);

/// Node-to-corner rows, lumped masses, everything awake. Call once, after the last body.
void finish(Mesh& mesh);

/// Room for the corner forces of blocks that are or have been awake.
void make_room_for_forces(Mesh& mesh);

/// f(node) for every node of bodies that are awake, in no particular order.
template <class F>
void for_each_node_awake(const Mesh& mesh, F&& f) {
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b)
    if (mesh.body_awake[b]) {
      const std::size_t first = mesh.body_nodes[b].first;
      core::for_each(mesh.body_nodes[b].size(), [&](std::size_t k) { f(first + k); });
    }
}

/// The eight corners of an element.
template <class Get>
inline void gather(const Elements& elements, std::size_t el, const std::vector<core::Vec3>& a, Get&& put) {
  for (int i = 0; i < 8; ++i) {
    const core::Vec3& v = a[static_cast<std::size_t>(elements.node[el][static_cast<std::size_t>(i)])];
    for (int d = 0; d < 3; ++d) put(i, d, v[d]);
  }
}

/// The part of a vector along which a node may move. fixed: bits of Nodes::fixed.
inline core::Vec3 free_part(core::Vec3 a, int fixed) {
  for (int d = 0; d < 3; ++d)
    if (fixed >> d & 1) a[d] = 0;
  return a;
}

/// No bonded particle acts on any node.
void forget_pushes(Nodes& nodes);

/// Adds to what bonded particles do to a node [N].
void push(Nodes& nodes, std::size_t nd, const core::Vec3& force);

/// What elements and bonded particles do to a node [N]; summed in fixed order.
inline core::Vec3 force_at(const Mesh& mesh, std::size_t nd) {
  const Nodes& n = mesh.nodes;
  core::Vec3 f(0, 0, 0);
  if (!n.pushed.empty() && n.row_of_f[nd] != Nodes::not_pushed) f = n.f[n.row_of_f[nd]];
  for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k) {
    const double* at = force_of(mesh.elements, mesh.corners[k]);
    if (!at) continue;
    f[0] += at[0];
    f[1] += at[block_size];
    f[2] += at[2 * block_size];
  }
  return f;
}

/// Mean of the corners [m].
inline core::Vec3 centre(const Mesh& mesh, std::size_t el, const std::vector<core::Vec3>& a) {
  core::Vec3 s = core::Vec3::Zero();
  for (const auto node : mesh.elements.node[el]) s += a[static_cast<std::size_t>(node)];
  return s / 8;
}

/// A corner of the parent cube [-].
inline core::Vec3 corner(int k) {
  constexpr double sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                 {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  return {sign[k][0], sign[k][1], sign[k][2]};
}

/// Shape function of a corner at a point of the parent cube [-].
inline double shape(int k, const core::Vec3& xi) {
  const core::Vec3 s = corner(k);
  return 0.125 * (1 + s[0] * xi[0]) * (1 + s[1] * xi[1]) * (1 + s[2] * xi[2]);
}

/// Trilinear interpolation of a nodal vector at a point of the parent cube, xi in [-1, 1].
inline core::Vec3 at(const Mesh& mesh, std::size_t el, const std::vector<core::Vec3>& a, const core::Vec3& xi) {
  if (xi.isZero(0)) return centre(mesh, el, a);  // the same bits
  core::Vec3 r = core::Vec3::Zero();
  for (int i = 0; i < 8; ++i) r += shape(i, xi) * a[static_cast<std::size_t>(mesh.elements.node[el][static_cast<std::size_t>(i)])];
  return r;
}

/// Centre of part k of an n x n x n division of the parent cube: where particles of an element are born.
inline core::Vec3 part_centre(int n, int k) {
  return {(2 * (k / (n * n)) + 1.0) / n - 1, (2 * (k / n % n) + 1.0) / n - 1, (2 * (k % n) + 1.0) / n - 1};
}

/// Takes an element out: its corners carry no force, and its share of the nodes' mass goes with it unless keep_mass.
void remove_element(Mesh& mesh, std::size_t el, bool keep_mass);

/// Exposed faces of alive elements of the given body, as (element, local face), ascending.
struct Face {
  std::uint32_t element;
  std::uint8_t face;
};

}  // namespace fem
