// SPDX-License-Identifier: Apache-2.0
// Which matter belongs to which plate: connected pieces (union-find) that hold the plate's outer rim. Elements of one
// piece share a node; particles hang on by bonds. Only a plate's own material belongs to it.
#include "measure/whole.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/orientation.hpp"

namespace measure {
namespace {

using core::Vec3;

constexpr double rim_begins = 0.98;  // of the half edges
constexpr double rim_waves = 0.25;   // of the smaller half edge: the rim of one piece is not farther from its own middle height, however dished

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = root(i), j = root(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);  // the lowest row is the root, whatever the order
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// How far out a row of a plate reaches, 1 at the edge.
double reach(const Matter& m, const PlateFrame& frame, std::size_t row) {
  const Vec3 local = frame.local(m.x[row]);
  if (row >= m.n_elements) return frame.rim(local) + 0.5 * m.size[row] / std::min(frame.half.x(), frame.half.y());
  double r = 0;
  for (const std::int32_t nd : m.node[row]) r = std::max(r, frame.rim(frame.local(m.node_x[nd])));
  return r;
}

/// What a free plate that was struck does as a whole, along the normal.
struct Drift {
  double by = 0;     ///< how far it is from where it was built, where that is more than its thickness [m]
  double speed = 0;  ///< against the velocity that it began with, where that is more than loose_speed and no more than bending_speed [m/s]
};

/// Read off its outermost matter: medians by mass, if half of that has stayed together. 0 elsewhere: of a plate in pieces, and where it is not
/// known where matter was built.
Drift drift_of(const Whole& whole, const PlateFrame& frame, int body, const Vec3& velocity, const Vec3& flown) {
  const Matter& m = whole.matter;
  if (m.built.empty()) return {};
  struct Row {
    double moved, speed, mass, reach;
  };
  std::vector<Row> outer;
  double farthest = 0;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (m.body[row] != body) continue;
    const Vec3 built = frame.local(m.built[row] + flown);
    outer.push_back({frame.local(m.x[row]).z() - built.z(), frame.axes.row(2).dot(m.v[row] - velocity), m.m[row], frame.rim(built)});
    farthest = std::max(farthest, outer.back().reach);
  }
  std::erase_if(outer, [&](const Row& r) { return r.reach < rim_begins * farthest; });
  double mass = 0;
  for (const Row& r : outer) mass += r.mass;
  const auto median = [&](double Row::*value, double least, double most, double together) {
    double sum = 0, at = 0, near = 0;
    std::sort(outer.begin(), outer.end(), [&](const Row& a, const Row& b) { return std::pair(a.*value, a.mass) < std::pair(b.*value, b.mass); });
    for (std::size_t k = 0; k < outer.size() && sum < 0.5 * mass; ++k) at = outer[k].*value, sum += outer[k].mass;
    for (const Row& r : outer)
      if (std::abs(r.*value - at) <= together) near += r.mass;
    return std::abs(at) > least && std::abs(at) <= most && near >= 0.5 * mass ? at : 0;
  };
  const double loose = loose_speed * whole.impact_speed;
  return {median(&Row::moved, frame.thickness, std::numeric_limits<double>::max(), rim_waves * std::min(frame.half.x(), frame.half.y())),
          median(&Row::speed, loose, bending_speed, loose)};
}

/// Rows of a plate that touch its edge, stayed in its slab and fly on with it; where there are none, those that reach farthest.
std::vector<std::uint32_t> rim_rows(const Whole& whole, const PlateFrame& frame, int body, const Vec3& velocity, const Vec3& flown) {
  const Matter& m = whole.matter;
  const Drift drift = drift_of(whole, frame, body, velocity, flown);
  const Vec3 carried = velocity + drift.speed * frame.axes.row(2).transpose();
  std::vector<std::uint32_t> candidates;
  std::vector<double> reaches;
  double farthest = 0;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (m.body[row] != body || std::abs(frame.local(m.x[row]).z() - drift.by) > frame.thickness) continue;
    if (whole.impact_speed > 0 && (m.v[row] - carried).norm() > loose_speed * whole.impact_speed) continue;
    const double r = reach(m, frame, row);
    candidates.push_back(static_cast<std::uint32_t>(row));
    reaches.push_back(r);
    farthest = std::max(farthest, r);
  }
  const double least = std::min(rim_begins, rim_begins * farthest);
  std::vector<std::uint32_t> rim;
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (reaches[k] >= least) rim.push_back(candidates[k]);
  return rim;
}

Rim rim_motion(const Matter& m, const PlateFrame& frame, std::span<const std::uint32_t> rows, const Vec3& flown) {
  Rim rim;
  double mass = 0, moment = 0;
  Vec3 momentum = Vec3::Zero();
  for (const std::uint32_t row : rows) {
    mass += m.m[row];
    momentum += m.m[row] * m.v[row];
    // where it was built is not always about the middle: of a graded plate's particles the large ones reach the edge first
    moment += m.m[row] * (frame.local(m.x[row]).z() - (m.built.empty() ? 0 : frame.local(m.built[row] + flown).z()));
  }
  rim.exists = mass > 0;
  if (rim.exists) rim.velocity = momentum / mass, rim.displacement = moment / mass;
  return rim;
}

double speed_limit(const Whole& whole, double part) {
  return whole.impact_speed > 0 ? part * whole.impact_speed : std::numeric_limits<double>::max();
}

/// Marks the rows of `mask` whose piece holds a rim row.
std::vector<char> connected_to_rim(const Whole& whole, std::span<const char> mask,
                                   std::span<const std::uint32_t> rim) {
  const std::vector<std::int64_t> piece = connected_pieces(whole, mask, false);
  std::vector<char> good(whole.size(), 0), result(whole.size(), 0);
  for (const std::uint32_t row : rim)
    if (piece[row] >= 0) good[piece[row]] = 1;
  for (std::size_t row = 0; row < whole.size(); ++row) result[row] = piece[row] >= 0 && good[piece[row]];
  return result;
}

void find_plates(const Scene& scene, Whole& whole) {
  whole.plates = scene.plates;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const int body = static_cast<int>(b);
    if (scene.bodies[b].is_plate && std::find(whole.plates.begin(), whole.plates.end(), body) == whole.plates.end())
      whole.plates.push_back(body);
  }
}

void find_members(const Scene& scene, Whole& whole) {
  const Matter& m = whole.matter;
  whole.rims.resize(scene.bodies.size());
  std::vector<std::uint32_t> rim;
  for (const int body : whole.plates) {
    const PlateFrame frame = plate_frame(scene, body);
    const Vec3 flown = scene.time * scene.bodies[body].velocity;
    const std::vector<std::uint32_t> rows = rim_rows(whole, frame, body, scene.bodies[body].velocity, flown);
    whole.rims[body] = rim_motion(m, frame, rows, flown);
    rim.insert(rim.end(), rows.begin(), rows.end());
  }
  std::vector<char> has_elements(scene.bodies.size(), 0);  // mode sph knows none
  for (std::size_t el = 0; el < m.n_elements; ++el) has_elements[m.body[el]] = 1;
  std::vector<char> own(whole.size(), 0), unfailed(whole.size(), 0), slow(whole.size(), 0), loose(whole.size(), 0);
  for (std::size_t row = 0; row < whole.size(); ++row) {
    const Rim& r = whole.rims[m.body[row]];
    const double speed = (m.v[row] - r.velocity).norm();
    // A failed particle carries no tension: it is powder that lies at the lip or drifts from it, holds to nothing and closes
    // no opening. Where it drifts it is no part of the plate either.
    const bool powder = !whole.is_element(row) && m.damage[row] >= 1, rests = speed < speed_limit(whole, settled_speed);
    unfailed[row] = r.exists && !powder;
    own[row] = r.exists && (!powder || rests);
    // A plate that still bends is whole all the same: its elements hang together by their nodes; of particles alone, by their bonds.
    const bool bends = whole.is_element(row) ? speed < std::max(speed_limit(whole, loose_speed), bending_speed)
                                             : !has_elements[m.body[row]] && speed < bending_speed;
    slow[row] = unfailed[row] && (rests || bends);
    loose[row] = speed > speed_limit(whole, r.exists ? loose_speed : settled_speed);
  }
  whole.joined = connected_to_rim(whole, own, rim);
  whole.sound = connected_to_rim(whole, unfailed, rim);
  whole.settled = connected_to_rim(whole, slow, rim);
  whole.held = whole.joined;
  whole.debris.assign(whole.size(), 0);
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (loose[row] && !whole.is_element(row) && !whole.settled[row]) whole.held[row] = 0;
    const bool free_body = !whole.rims[m.body[row]].exists && !scene.bodies[m.body[row]].is_projectile;
    whole.debris[row] = !whole.settled[row] && (!whole.joined[row] || loose[row]) && (!free_body || loose[row]);
  }
}

/// Fills in the place where each row's element was built, where that is known.
void find_origins(const Scene& scene, Matter& m) {
  if (scene.built.empty() || m.parent.size() != m.x.size()) return;
  m.built.own.reserve(m.parent.size());
  for (const std::uint32_t el : m.parent.own) m.built.own.push_back(scene.built[el].cast<double>());
}

}  // namespace

PlateFrame plate_frame(const Scene& scene, int body) {
  const BodyScene& b = scene.bodies[body];
  PlateFrame f;
  const Vec3 normal = b.normal.normalized(), front = normal.dot(scene.impact_velocity) > 0 ? Vec3(-normal) : normal;
  f.axes = core::orientation(core::upright(normal)).transpose();
  if (f.axes.row(2).dot(front) < 0) f.axes.row(1) *= -1, f.axes.row(2) *= -1;
  f.origin = b.center + scene.time * b.velocity;
  f.thickness = b.thickness;
  f.half = 0.5 * Vec3(b.extent.x(), b.extent.y(), b.thickness);
  const double least = std::max(1e-300, 1e-6 * b.thickness);
  f.half = f.half.cwiseMax(Vec3::Constant(least));
  return f;
}

std::vector<std::int64_t> connected_pieces(const Whole& whole, std::span<const char> mask, bool across_bodies) {
  const Matter& m = whole.matter;
  UnionFind sets(whole.size());
  std::vector<std::int32_t> first_at(m.node_x.size(), -1);
  for (std::size_t el = 0; el < m.n_elements; ++el) {
    if (!mask[el]) continue;
    for (const std::int32_t nd : m.node[el]) {
      if (first_at[nd] < 0) first_at[nd] = static_cast<std::int32_t>(el);
      else sets.join(static_cast<std::uint32_t>(first_at[nd]), static_cast<std::uint32_t>(el));
    }
  }
  for (const Bond& bond : whole.bonds)
    if (mask[bond.i] && mask[bond.j] && (across_bodies || m.body[bond.i] == m.body[bond.j])) sets.join(bond.i, bond.j);
  std::vector<std::int64_t> piece(whole.size(), -1);
  for (std::size_t row = 0; row < whole.size(); ++row)
    if (mask[row]) piece[row] = sets.root(static_cast<std::uint32_t>(row));
  return piece;
}

Whole make_whole(Matter part, const Scene& scene) {
  Whole whole;
  find_origins(scene, part);
  whole.matter = mirrored(std::move(part), scene.symmetry);
  whole.impact_speed = scene.impact_velocity.norm();
  if (whole.impact_speed > 0) whole.flight = scene.impact_velocity / whole.impact_speed;
  whole.bonds = all_bonds(whole.matter, scene, speed_limit(whole, bond_speed));
  find_plates(scene, whole);
  find_members(scene, whole);
  return whole;
}

std::vector<Face> bounding_faces(const Whole& whole) {
  return faces_where(whole.matter, [&](const Face& f) {
    return whole.rims[whole.matter.body[f.a]].exists && (f.b < 0 || !whole.settled[f.a] || !whole.settled[f.b]);
  });
}

}  // namespace measure
