// SPDX-License-Identifier: Apache-2.0
// Fragments: connected pieces (elements that share a node, bonded particles, of whatever bodies) of the debris that is
// behind the first plate and flies on. Sums run in row order, so masses and momenta add up to those of the debris.
#include <algorithm>
#include <cmath>

#include "core/octree.hpp"
#include "measure/families.hpp"

namespace measure {
namespace {

using core::Vec3;

constexpr double kernel_reach = 2.6;  // spacings: support of a kernel of smoothing length 1.3 spacings

std::vector<char> downstream_debris(const Whole& whole, const Scene& scene) {
  std::vector<char> mask(whole.size(), 0);
  const bool any_plate = !scene.plates.empty();
  const PlateFrame frame = any_plate ? plate_frame(scene, scene.plates.front()) : PlateFrame{};
  for (std::size_t row = 0; row < whole.size(); ++row) {
    const bool behind = !any_plate || (whole.matter.v[row].dot(whole.flight) > 0 &&
                                       frame.local(whole.matter.x[row]).z() < -frame.half.z());
    mask[row] = whole.debris[row] && behind;
  }
  return mask;
}

void add_row(const Whole& whole, const Scene& scene, std::size_t row, Fragment& f) {
  const Matter& m = whole.matter;
  f.mass += m.m[row];
  f.x += m.m[row] * m.x[row];
  f.v += m.m[row] * m.v[row];
  f.size += m.size[row] * m.size[row] * m.size[row];
  if (!m.T.empty()) f.temperature += m.m[row] * m.T[row];
  if (scene.bodies[m.body[row]].is_projectile) f.projectile_fraction += m.m[row];
  ++f.n_points;
}

void finish(Fragment& f) {
  f.size = std::cbrt(6 * f.size / core::pi);
  if (f.mass <= 0) return;
  f.x /= f.mass;
  f.v /= f.mass;
  f.temperature /= f.mass;
  f.projectile_fraction /= f.mass;
}

/// True where no other row of the mask comes within a kernel of the particle.
bool out_of_reach(const Whole& whole, std::span<const char> mask, const core::Octree& tree, std::size_t row,
                  double spacing) {
  const Vec3& x = whole.matter.x[row];
  const double reach = kernel_reach * spacing;
  std::vector<std::uint32_t> near;
  tree.in_box(x - Vec3::Constant(reach), x + Vec3::Constant(reach), near);
  return std::none_of(near.begin(), near.end(), [&](std::uint32_t other) {
    return other != row && mask[other] && (whole.matter.x[other] - x).norm() < reach;
  });
}

}  // namespace

void measure_fragments(const Whole& whole, const Scene& scene, Result& result) {
  const std::vector<char> mask = downstream_debris(whole, scene);
  const std::vector<std::int64_t> piece = connected_pieces(whole, mask, true);
  std::vector<std::int64_t> number(whole.size(), -1);
  std::vector<Fragment>& fragments = result.fragments;
  std::vector<std::size_t> first_row;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (piece[row] < 0) continue;
    if (number[piece[row]] < 0) {
      number[piece[row]] = static_cast<std::int64_t>(fragments.size());
      fragments.emplace_back();
      first_row.push_back(row);
    }
    add_row(whole, scene, row, fragments[number[piece[row]]]);
  }
  core::Octree tree;
  if (!fragments.empty()) tree.build(whole.matter.x);
  double mass = 0, lone_mass = 0;
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    Fragment& f = fragments[k];
    finish(f);
    const std::size_t row = first_row[k];
    f.lone = f.n_points == 1 && !whole.is_element(row) &&
             out_of_reach(whole, mask, tree, row, bond_spacing(whole.matter, scene, row));
    mass += f.mass;
    if (f.lone) lone_mass += f.mass;
  }
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.mass > b.mass; });
  add(result, "fragments.count", static_cast<double>(fragments.size()), "");
  add(result, "fragments.mass", mass, "kg");
  if (mass <= 0) return;
  add(result, "fragments.largest_mass", fragments.front().mass, "kg");
  add(result, "fragments.lone_mass_fraction", lone_mass / mass, "");
}

}  // namespace measure
