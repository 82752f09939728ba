// SPDX-License-Identifier: Apache-2.0
// Fragments: connected pieces (elements that share a node, bonded particles, of whatever bodies) of the debris that is
// behind the first plate and flies on. Sums run in row order, so masses and momenta add up to those of the debris.
// What cut a piece off is read from its neighbours as built: where neither side has failed, nothing in the material did,
// but the two drew apart until no kernel reached across. The size of such a piece is that of the resolution.
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/box.hpp"
#include "core/octree.hpp"
#include "measure/families.hpp"

namespace measure {
namespace {

using core::Vec3;

constexpr double kernel_reach = 2.6;  // spacings: support of a kernel of smoothing length 1.3 spacings

constexpr double next_door = 1.25;    // of the mean size: neighbours of a grid of cubes through faces, not through edges

std::vector<char> downstream_debris(const Whole& whole, const Scene& scene) {
  if (scene.plates.empty()) return whole.debris;
  std::vector<char> mask(whole.size(), 0);
  for (const std::uint32_t row : cloud_rows(whole, scene, 0)) mask[row] = 1;
  return mask;
}

void add_row(const Whole& whole, const Scene& scene, std::size_t row, Fragment& f) {
  const Matter& m = whole.matter;
  f.mass += m.m[row];
  f.x += m.m[row] * m.x[row];
  f.v += m.m[row] * m.v[row];
  f.size += m.size[row] * m.size[row] * m.size[row];
  if (!m.T.empty()) f.temperature += m.m[row] * m.T[row];
  if (m.damage[row] >= 1) f.failed_fraction += m.m[row];
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
  f.failed_fraction /= f.mass;
}

/// Some rows, to be found by where they are.
struct Placed {
  std::vector<std::uint32_t> row;
  core::Octree tree;

  Placed(const Whole& whole, const Field<Vec3>& x, const std::function<bool(std::size_t)>& wanted) {
    std::vector<Vec3> at;
    for (std::size_t i = 0; i < whole.size(); ++i)
      if (wanted(i)) row.push_back(static_cast<std::uint32_t>(i)), at.push_back(x[i]);
    if (!at.empty()) tree.build(at);
  }
  std::vector<std::uint32_t> in_box(const Vec3& low, const Vec3& high) const {
    std::vector<std::uint32_t> near;
    if (!row.empty()) tree.in_box(low, high, near);
    for (auto& k : near) k = row[k];
    return near;
  }
};

/// True where no other row of those placed comes within a kernel of the particle.
bool out_of_reach(const Whole& whole, const Placed& placed, std::size_t row, double spacing) {
  const Vec3 x = whole.matter.x[row], reach = Vec3::Constant(kernel_reach * spacing);
  const auto near = placed.in_box(x - reach, x + reach);
  return std::none_of(near.begin(), near.end(), [&](std::uint32_t other) {
    return other != row && (whole.matter.x[other] - x).norm() < reach[0];
  });
}

/// Edge of the element that a row is, or was part of, as built.
double built_size(const Whole& whole, const Scene& scene, std::size_t row) {
  const double rho_0 = scene.bodies[whole.matter.body[row]].rho_0;
  return rho_0 > 0 ? std::cbrt(whole.matter.m[row] / rho_0) : whole.matter.size[row];
}

/// Counts, for every piece, its links as built to matter outside it. number[row] is the row's piece, -1 for the rest.
void count_cut_links(const Whole& whole, const Scene& scene, std::span<const std::int64_t> number,
                     std::vector<Fragment>& fragments) {
  const Matter& m = whole.matter;
  if (m.built.empty() || fragments.empty()) return;
  const auto size = [&](std::size_t row) { return built_size(whole, scene, row); };
  const auto reach = [&](std::size_t row) { return Vec3(Vec3::Constant(1.5 * next_door * size(row))); };  // a graded mesh: the other side may be larger
  core::Box around;
  for (std::size_t row = 0; row < whole.size(); ++row)
    if (number[row] >= 0) around.add(core::Box{m.built[row] - reach(row), m.built[row] + reach(row)});
  const Placed placed(whole, m.built, [&](std::size_t row) { return around.contains(m.built[row]); });
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (number[row] < 0) continue;
    Fragment& f = fragments[number[row]];
    for (const std::uint32_t other : placed.in_box(m.built[row] - reach(row), m.built[row] + reach(row))) {
      const double limit = next_door * 0.5 * (size(row) + size(other));
      if (number[other] == number[row] || m.body[other] != m.body[row]) continue;
      if ((m.built[other] - m.built[row]).squaredNorm() > limit * limit) continue;
      ++f.links_cut;
      if (m.damage[row] < 1 && m.damage[other] < 1) f.cut_by_reach += 1;
    }
  }
  for (Fragment& f : fragments)
    if (f.links_cut > 0) f.cut_by_reach /= f.links_cut;
}

}  // namespace

void measure_fragments(const Whole& whole, const Scene& scene, Result& result) {
  const std::vector<char> mask = downstream_debris(whole, scene);
  const std::vector<std::int64_t> piece = connected_pieces(whole, mask, true);
  std::vector<std::int64_t> number(whole.size(), -1);  // of the fragment that a row is part of; a piece is known by its first row
  std::vector<Fragment>& fragments = result.fragments;
  std::vector<std::size_t> first_row;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (piece[row] < 0) continue;
    if (number[piece[row]] < 0) {
      number[piece[row]] = static_cast<std::int64_t>(fragments.size());
      fragments.emplace_back();
      first_row.push_back(row);
    }
    number[row] = number[piece[row]];
    add_row(whole, scene, row, fragments[number[row]]);
  }
  const Placed placed(whole, whole.matter.x, [&](std::size_t row) { return mask[row] != 0; });
  count_cut_links(whole, scene, number, fragments);
  double mass = 0, momentum = 0, lone_mass = 0, failed_mass = 0, reach_mass = 0;
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    Fragment& f = fragments[k];
    finish(f);
    const std::size_t row = first_row[k];
    f.lone = f.n_points == 1 && !whole.is_element(row) &&
             out_of_reach(whole, placed, row, bond_spacing(whole.matter, scene, row));
    mass += f.mass;
    momentum += f.mass * f.v.dot(whole.flight);
    failed_mass += f.mass * f.failed_fraction;
    if (f.lone) lone_mass += f.mass;
    if (f.cut_by_reach > 0.5) reach_mass += f.mass;
  }
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.mass > b.mass; });
  add(result, "fragments.count", static_cast<double>(fragments.size()), "");
  add(result, "fragments.mass", mass, "kg");
  add(result, "fragments.momentum", momentum, "N s");
  if (mass <= 0) return;
  add(result, "fragments.largest_mass", fragments.front().mass, "kg");
  add(result, "fragments.lone_mass_fraction", lone_mass / mass, "");
  add(result, "fragments.failed_mass_fraction", failed_mass / mass, "");
  if (!whole.matter.built.empty()) add(result, "fragments.reach_mass_fraction", reach_mass / mass, "");
}

}  // namespace measure
