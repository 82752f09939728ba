// SPDX-License-Identifier: Apache-2.0
#include "coupling/contact.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "core/octree.hpp"
#include "core/parallel.hpp"
#include "fem/elements.hpp"
#include "fem/hex8.hpp"

namespace coupling {

using core::Vec3;

constexpr double margin_part = 2e-3;   // gap kept, over the square root of a face's area
constexpr double edge_tolerance = 0.02;  // triangles reach this part of their size beyond their edges
constexpr int steps_ahead = 4;         // candidates serve about this many steps
constexpr int most_sweeps = 100;

bool contact_possible(const fem::Mesh& mesh, const sph::Particles& particles, const std::vector<Wall>& walls) {
  return !walls.empty() || (mesh.n_alive > 0 && (mesh.body_elements.size() > 1 || particles.size() > 0));
}

// ------------------------------------------------------------------------------------------------ moving things

/// What a point is made of, read and written through one door.
struct PointRef {
  Vec3* x;
  Vec3* v;
  Vec3* v_mean;
  double m;
  int fixed;
};

static PointRef point_ref(fem::Mesh& mesh, sph::Particles& p, const ContactPoint& point) {
  const std::size_t i = point.index;
  if (point.particle) return {&p.x[i], &p.v[i], &p.v_mean[i], p.pt.m[i], 0};
  return {&mesh.nodes.x[i], &mesh.nodes.v[i], &mesh.nodes.v_mean[i], mesh.nodes.m[i], mesh.nodes.fixed[i]};
}

static std::array<std::size_t, 4> face_nodes(const fem::Mesh& mesh, const fem::Face& face) {
  std::array<std::size_t, 4> n;
  for (std::size_t k = 0; k < 4; ++k)
    n[k] = static_cast<std::size_t>(
        mesh.elements.node[face.element][static_cast<std::size_t>(fem::face_corner[face.face][k])]);
  return n;
}

static Vec3 free_part(Vec3 a, int fixed) {
  for (int d = 0; d < 3; ++d)
    if (fixed >> d & 1) a[d] = 0;
  return a;
}

/// The meeting of a point with one of a face's four triangles during the step.
struct Meeting {
  bool found = false;
  double gap_end = 0;                 ///< signed distance at the end [m]
  double target = 0;                  ///< gap to be left at the end [m]
  Vec3 normal{0, 0, 0};               ///< of the triangle at the end
  std::array<double, 4> weight{};     ///< shape functions of the corners where it meets
};

struct Triangle {
  Vec3 a, b, c;  // c: the face's centre
  Vec3 normal() const { return (a - c).cross(b - c); }
};

static Triangle moved(const Triangle& t, const Triangle& v, double dt) {
  return {t.a + dt * v.a, t.b + dt * v.b, t.c + dt * v.c};
}

/// Barycentric coordinates (a, b) of the foot of p on the triangle; c has the rest.
static std::array<double, 2> barycentric(const Triangle& t, const Vec3& p) {
  const Vec3 u = t.a - t.c, w = t.b - t.c, d = p - t.c;
  const double uu = u.dot(u), ww = w.dot(w), uw = u.dot(w), du = d.dot(u), dw = d.dot(w);
  const double det = uu * ww - uw * uw;
  return {(du * ww - dw * uw) / det, (dw * uu - du * uw) / det};
}

static double gap_at(const Triangle& t, const Triangle& v, const Vec3& p, const Vec3& vp, double time) {
  const Triangle now = moved(t, v, time);
  return now.normal().normalized().dot(p + time * vp - now.c);
}

/// Time at which the signed distance falls to `gap`, by bracketed secant steps; 0 where it starts below.
static double time_of_gap(const Triangle& t, const Triangle& v, const Vec3& p, const Vec3& vp, double dt, double gap,
                          double gap_start, double gap_end, double tolerance) {
  double t0 = 0, g0 = gap_start - gap, t1 = dt, g1 = gap_end - gap, when = 0;
  if (g1 >= 0) return dt;
  for (int k = 0; k < 12 && g0 > tolerance; ++k) {
    when = t0 + (t1 - t0) * g0 / (g0 - g1);
    const double g = gap_at(t, v, p, vp, when) - gap;
    if (std::abs(g) < tolerance) break;
    if (g > 0)
      t0 = when, g0 = g;
    else
      t1 = when, g1 = g;
  }
  return when;
}

/// Does p(t) come nearer than the margin to the moving triangle, from outside, within dt?
static bool meets(const Triangle& t, const Triangle& v, const Vec3& p, const Vec3& vp, double dt, double margin,
                  bool strict, Meeting& m, std::array<double, 2>& where) {
  const Vec3 n0 = t.normal();
  const double area2 = n0.norm();
  if (!(area2 > 0)) return false;
  const double gap_0 = n0.dot(p - t.c) / area2;
  if (gap_0 < -1e-3 * margin) return false;  // already behind this sheet's plane: not from outside
  m.target = strict ? 0.0 : std::max(0.0, std::min(gap_0, margin));
  const Triangle end = moved(t, v, dt);
  const Vec3 n1 = end.normal();
  const double end_norm = n1.norm();
  if (!(end_norm > 0)) return false;
  m.normal = n1 / end_norm;
  m.gap_end = m.normal.dot(p + dt * vp - end.c);
  if (m.gap_end >= (strict ? -1e-9 * margin : 0.5 * m.target)) return false;
  const double low = strict ? 0.0 : -edge_tolerance;
  const auto inside_at = [&](double gap) {
    const double when = time_of_gap(t, v, p, vp, dt, gap, gap_0, m.gap_end, 0.1 * margin);
    where = barycentric(moved(t, v, when), p + when * vp);
    return where[0] >= low && where[1] >= low && where[0] + where[1] <= 1 - low;
  };
  // A point that slides along while it closes in may come over the triangle only between margin and sheet.
  if (!inside_at(m.target) && !(m.target > 0 && m.gap_end < 0 && inside_at(0.0))) return false;
  if (strict) return true;
  where = {std::clamp(where[0], 0.0, 1.0), std::clamp(where[1], 0.0, 1.0)};
  if (const double sum = where[0] + where[1]; sum > 1) where = {where[0] / sum, where[1] / sum};
  // The impulse acts on positions of the step's start: there its line must pass through the foot, or it makes a couple.
  const auto foot = barycentric(t, p - n0.dot(p - t.c) / n0.dot(m.normal) * m.normal);
  if (foot[0] > -0.5 && foot[1] > -0.5 && foot[0] + foot[1] < 1.5) where = foot;
  return true;
}

/// The deepest meeting of a point with a face. strict: only a true crossing of the sheet.
static Meeting meet(const fem::Mesh& mesh, const std::array<std::size_t, 4>& node, const PointRef& p, double dt,
                    bool strict) {
  const auto& n = mesh.nodes;
  const Vec3 xc = 0.25 * (n.x[node[0]] + n.x[node[1]] + n.x[node[2]] + n.x[node[3]]);
  const Vec3 vc = 0.25 * (n.v[node[0]] + n.v[node[1]] + n.v[node[2]] + n.v[node[3]]);
  const Vec3 diagonals = (n.x[node[2]] - n.x[node[0]]).cross(n.x[node[3]] - n.x[node[1]]);
  const double margin = margin_part * std::sqrt(0.5 * diagonals.norm());
  Meeting best;
  const double reach = margin + (*p.v - vc).norm() * dt;
  double face = 0;
  for (const auto k : node) face = std::max(face, (n.x[k] - xc).norm() + (n.v[k] - vc).norm() * dt);
  if ((*p.x - xc).norm() > reach + face) return best;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t a = node[k], b = node[(k + 1) % 4];
    Meeting m;
    std::array<double, 2> w;
    if (!meets({n.x[a], n.x[b], xc}, {n.v[a], n.v[b], vc}, *p.x, *p.v, dt, margin, strict, m, w)) continue;
    if (best.found && best.gap_end <= m.gap_end) continue;
    best = m;
    best.found = true;
    best.weight.fill(0.25 * (1 - w[0] - w[1]));
    best.weight[k] += w[0];
    best.weight[(k + 1) % 4] += w[1];
  }
  return best;
}

// ------------------------------------------------------------------------------------------------ impulses

/// Changes a velocity by dv where it is free, and the mean velocity over the step with it.
static void push(Vec3& v, Vec3& v_mean, int fixed, const Vec3& dv) {
  const Vec3 d = free_part(dv, fixed);
  v += d;
  v_mean += 0.5 * d;
}

/// The impulses that one pair exchanged during a step. Their work is taken with the mean velocities at the end, as that of
/// all other forces: a contact that lasts then does none, and one that begins dissipates what an inelastic impact does.
struct Exchange {
  Vec3 on_point{0, 0, 0};                              ///< [N s]
  std::array<Vec3, 4> on_corner{Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)};
};

/// Heat [J] into the elements alive at a node, by mass. False where there is none.
static bool heat_node(fem::Mesh& mesh, std::size_t nd, double heat) {
  fem::Elements& e = mesh.elements;
  double mass = 0;
  for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k)
    if (e.alive[mesh.corners[k] / 8]) mass += e.pt.m[mesh.corners[k] / 8];
  if (mass == 0) return false;
  for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k)
    if (e.alive[mesh.corners[k] / 8]) e.pt.e[mesh.corners[k] / 8] += heat / mass;
  return true;
}

static bool heat_point(fem::Mesh& mesh, sph::Particles& p, const ContactPoint& point, double heat) {
  if (!point.particle) return heat_node(mesh, point.index, heat);
  p.pt.e[point.index] += heat / p.pt.m[point.index];
  return true;
}

static void apply(fem::Mesh& mesh, const PointRef& p, const std::array<std::size_t, 4>& node, const Meeting& m,
                  const ContactSettings& settings, double dt, Exchange& exchange) {
  auto& n = mesh.nodes;
  const auto inverse_mass = [&](const Vec3& direction) {
    double s = free_part(direction, p.fixed).squaredNorm() / p.m;
    for (std::size_t k = 0; k < 4; ++k)
      s += m.weight[k] * m.weight[k] * free_part(direction, n.fixed[node[k]]).squaredNorm() / n.m[node[k]];
    return s;
  };
  const double inverse = inverse_mass(m.normal);
  if (!(inverse > 0)) return;
  const double size = (m.target - m.gap_end) / dt / inverse;
  Vec3 impulse = size * m.normal;
  if (settings.friction > 0) {
    Vec3 slip = *p.v;
    for (std::size_t k = 0; k < 4; ++k) slip -= m.weight[k] * n.v[node[k]];
    slip -= slip.dot(m.normal) * m.normal;
    const double speed = slip.norm();
    if (speed > 0) impulse -= std::min(settings.friction * size, speed / inverse_mass(slip / speed)) * (slip / speed);
  }
  push(*p.v, *p.v_mean, p.fixed, impulse / p.m);
  exchange.on_point += impulse;
  for (std::size_t k = 0; k < 4; ++k) {
    push(n.v[node[k]], n.v_mean[node[k]], n.fixed[node[k]], -m.weight[k] * impulse / n.m[node[k]]);
    exchange.on_corner[k] -= m.weight[k] * impulse;
    n.awake[node[k]] = 1;
  }
}

/// Books the work of a pair's impulses; what they dissipate becomes heat of both sides, half and half.
static void book(fem::Mesh& mesh, sph::Particles& particles, const ContactPoint& point, const fem::Face& face,
                 const Exchange& exchange, Contact& contact) {
  double work = exchange.on_point.dot(*point_ref(mesh, particles, point).v_mean);
  const auto node = face_nodes(mesh, face);
  for (std::size_t k = 0; k < 4; ++k) work += exchange.on_corner[k].dot(mesh.nodes.v_mean[node[k]]);
  contact.dissipated -= work;
  // half to the point's side, half round the face's corners: one element alone would be left too hot
  double heated = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (heat_node(mesh, node[k], -0.125 * work)) heated -= 0.125 * work;
  if (heat_point(mesh, particles, point, -0.5 * work)) heated -= 0.5 * work;
  contact.heated += heated;
}

// ------------------------------------------------------------------------------------------------ search

struct Box {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool empty() const { return low[0] > high[0]; }
  double distance(const Box& o) const {
    return (o.low - high).cwiseMax(low - o.high).cwiseMax(Vec3::Zero()).norm();
  }
};

static void list_points(const fem::Mesh& mesh, const sph::Particles& particles, Contact& c) {
  c.points.clear();
  std::vector<std::uint8_t> listed(mesh.nodes.size(), 0);
  for (const auto nd : c.surface.nodes) {
    c.points.push_back({nd, false});
    listed[nd] = 1;
  }
  if (mesh.n_removed > 0)  // free nodes: mass but no element alive
    for (std::size_t nd = 0; nd < mesh.nodes.size(); ++nd) {
      if (listed[nd] || mesh.nodes.m[nd] == 0) continue;
      bool alive = false;
      for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k)
        alive = alive || mesh.elements.alive[mesh.corners[k] / 8];
      if (!alive) c.points.push_back({static_cast<std::uint32_t>(nd), false});
    }
  for (std::uint32_t i = 0; i < particles.size(); ++i) c.points.push_back({i, true});
}

static int body_of_node(const fem::Mesh& mesh, std::size_t nd) {
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b)
    if (mesh.body_nodes[b].contains(nd)) return static_cast<int>(b);
  return -1;
}

static bool is_free(const fem::Mesh& mesh, std::size_t nd) {
  for (auto k = mesh.corner_start[nd]; k < mesh.corner_start[nd + 1]; ++k)
    if (mesh.elements.alive[mesh.corners[k] / 8]) return false;
  return true;
}

/// The time before which no two groups (elements of one body, particles of one body) can touch [s].
static double time_to_meet(const fem::Mesh& mesh, const sph::Particles& particles) {
  const std::size_t n = mesh.body_elements.size();
  std::vector<Box> solid(n), cloud(n);
  double speed = 0;
  for (std::size_t b = 0; b < n; ++b)
    for (std::size_t nd = mesh.body_nodes[b].first; nd < mesh.body_nodes[b].last; ++nd) {
      if (mesh.nodes.m[nd] == 0) continue;
      solid[b].add(mesh.nodes.x[nd]);
      speed = std::max(speed, mesh.nodes.v[nd].norm());
    }
  for (std::size_t i = 0; i < particles.size(); ++i) {
    cloud[particles.body[i]].add(particles.x[i]);
    speed = std::max(speed, particles.v[i].norm());
  }
  double gap = 1e300;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      if (solid[b].empty()) continue;
      if (a < b && !solid[a].empty()) gap = std::min(gap, solid[a].distance(solid[b]));
      if (!cloud[a].empty()) gap = std::min(gap, cloud[a].distance(solid[b]));
    }
  return gap / (2 * 1.2 * speed + 1e-300);  // both may move, and be sped up a little meanwhile
}

static void find_candidates(const fem::Mesh& mesh, const sph::Particles& particles, double dt, Contact& c) {
  fem::update_surface(mesh, c.surface);
  list_points(mesh, particles, c);
  const auto& nodes = mesh.nodes;
  double speed = 0, edge = 1e300;
  c.point_x.resize(c.points.size());
  for (std::size_t k = 0; k < c.points.size(); ++k) {
    const auto& point = c.points[k];
    c.point_x[k] = point.particle ? particles.x[point.index] : nodes.x[point.index];
    speed = std::max(speed, (point.particle ? particles.v[point.index] : nodes.v[point.index]).norm());
  }
  for (const auto& f : c.surface.faces) {
    const auto n = face_nodes(mesh, f);
    edge = std::min(edge, (nodes.x[n[2]] - nodes.x[n[0]]).squaredNorm());
  }
  c.reach = std::max(steps_ahead * 1.1 * speed * dt, 0.05 * std::sqrt(edge));
  core::Octree tree;
  tree.build(c.point_x);
  Box all;
  for (const auto& x : c.point_x) all.add(x);
  c.candidates.clear();
  std::vector<std::vector<Candidate>> part((c.surface.faces.size() + 255) / 256);
  core::for_each_block(c.surface.faces.size(), 256, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint32_t> found;
    for (std::size_t f = first; f < last; ++f) {
      const auto n = face_nodes(mesh, c.surface.faces[f]);
      Box box;
      for (const auto k : n) box.add(nodes.x[k]);
      found.clear();
      tree.in_box(box.low.array() - 2 * c.reach, box.high.array() + 2 * c.reach, found);
      const int body = mesh.elements.body[c.surface.faces[f].element];
      for (const auto k : found) {
        const auto& point = c.points[k];
        if (!point.particle) {
          if (std::find(n.begin(), n.end(), point.index) != n.end()) continue;
          if (body_of_node(mesh, point.index) == body && !is_free(mesh, point.index)) continue;
        }
        part[first / 256].push_back({k, static_cast<std::uint32_t>(f)});
      }
    }
  });
  for (const auto& list : part) c.candidates.insert(c.candidates.end(), list.begin(), list.end());
  c.valid = true;
  ++c.searches;
}

/// Could anything have left the reach it was given?
static bool still_valid(const fem::Mesh& mesh, const sph::Particles& particles, double dt, const Contact& c) {
  if (!c.valid || c.surface.n_removed != mesh.n_removed) return false;
  const auto far = [&](const Vec3& x, const Vec3& v, const Vec3& old) { return -((x - old).norm() + v.norm() * dt); };
  const double points = -core::min_where(c.points.size(), [&](std::size_t k) {
                           const auto& p = c.points[k];
                           return p.particle ? far(particles.x[p.index], particles.v[p.index], c.point_x[k])
                                             : far(mesh.nodes.x[p.index], mesh.nodes.v[p.index], c.point_x[k]);
                         }).value;
  return points <= c.reach;
}

// ------------------------------------------------------------------------------------------------ the solver

static std::vector<std::uint32_t> detect(fem::Mesh& mesh, sph::Particles& particles, double dt, bool strict,
                                         const Contact& c) {
  std::vector<std::uint8_t> hit(c.candidates.size());
  core::for_each_block(c.candidates.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const auto node = face_nodes(mesh, c.surface.faces[c.candidates[k].face]);
      const PointRef p = point_ref(mesh, particles, c.points[c.candidates[k].point]);
      hit[k] = p.m > 0 && meet(mesh, node, p, dt, strict).found;
    }
  });
  std::vector<std::uint32_t> list;
  for (std::size_t k = 0; k < hit.size(); ++k)
    if (hit[k]) list.push_back(static_cast<std::uint32_t>(k));
  return list;
}

/// Size of the smallest face that a node may strike, and how fast a node comes nearer to one.
static void measure_closing(const fem::Mesh& mesh, Contact& c) {
  const auto& n = mesh.nodes;
  c.edge = 1e300;
  c.closing = -core::min_where(c.candidates.size(), [&](std::size_t k) {
                 const auto& point = c.points[c.candidates[k].point];
                 if (point.particle) return 0.0;
                 const auto f = face_nodes(mesh, c.surface.faces[c.candidates[k].face]);
                 const Vec3 normal = (n.x[f[2]] - n.x[f[0]]).cross(n.x[f[3]] - n.x[f[1]]).normalized();
                 const Vec3 v = 0.25 * (n.v[f[0]] + n.v[f[1]] + n.v[f[2]] + n.v[f[3]]);
                 return std::min(0.0, normal.dot(n.v[point.index] - v));
               }).value;
  for (const auto& k : c.candidates) {
    if (c.points[k.point].particle) continue;
    const auto f = face_nodes(mesh, c.surface.faces[k.face]);
    c.edge = std::min(c.edge, 0.5 * (n.x[f[2]] - n.x[f[0]]).cross(n.x[f[3]] - n.x[f[1]]).norm());
  }
  c.edge = std::sqrt(c.edge);
}

/// One pass over the pairs in order; returns how many still met.
static std::size_t sweep(fem::Mesh& mesh, sph::Particles& particles, const std::vector<std::uint32_t>& active,
                         const ContactSettings& settings, double dt, const Contact& c, std::vector<Exchange>& exchanges) {
  std::size_t met = 0;
  for (const auto k : active) {
    const PointRef p = point_ref(mesh, particles, c.points[c.candidates[k].point]);
    const auto node = face_nodes(mesh, c.surface.faces[c.candidates[k].face]);
    const Meeting m = meet(mesh, node, p, dt, false);
    if (!m.found) continue;
    ++met;
    apply(mesh, p, node, m, settings, dt, exchanges[k]);
  }
  return met;
}

/// An impulse on one point that has no single partner: of a rigid wall, or within an impact zone.
struct LoneExchange {
  ContactPoint point;
  Vec3 impulse;
};

static double book_lone(fem::Mesh& mesh, sph::Particles& particles, const LoneExchange& e, Contact& c) {
  const double work = e.impulse.dot(*point_ref(mesh, particles, e.point).v_mean);
  c.dissipated -= work;
  return work;
}

/// Rigid impact zones (Provot 1997; Bridson, Fedkiw & Anderson, ACM Trans. Graph. 21 (2002) 594, section 7.5): where
/// impulses have not parted a cluster of points and faces in most_sweeps passes (a light particle between two heavy
/// faces), its members go on together at the velocity of their common momentum; it grows until nothing crosses.
class ImpactZones {
 public:
  ImpactZones(fem::Mesh& mesh, sph::Particles& particles, double dt, Contact& c)
      : mesh_(mesh), particles_(particles), dt_(dt), c_(c) {}

  void move() {
    constexpr int most_rounds = 50;
    for (int round = 0; round < most_rounds; ++round) {
      const auto active = detect(mesh_, particles_, dt_, false, c_);
      if (active.empty()) break;
      for (const auto k : active) join(k);
      move_together();
    }
  }

  /// After everything that may still change velocities.
  void book() {
    double dissipated = 0;
    for (const auto& [k, e] : exchanges_) dissipated -= book_lone(mesh_, particles_, e, c_);
    // heat to the zone's members by mass
    double mass = 0;
    for (const auto& [k, e] : exchanges_) mass += point_ref(mesh_, particles_, e.point).m;
    for (const auto& [k, e] : exchanges_) {
      const double heat = dissipated * point_ref(mesh_, particles_, e.point).m / mass;
      if (heat_point(mesh_, particles_, e.point, heat)) c_.heated += heat;
    }
  }

 private:
  using Key = std::uint64_t;
  static Key key(const ContactPoint& p) { return (static_cast<Key>(p.particle) << 32) | p.index; }
  static ContactPoint point(Key k) { return {static_cast<std::uint32_t>(k), (k >> 32) != 0}; }

  Key root(Key k) {
    const auto found = parent_.try_emplace(k, k).first;
    return found->second == k ? k : found->second = root(found->second);
  }
  void join(std::uint32_t candidate) {
    const Key a = root(key(c_.points[c_.candidates[candidate].point]));
    for (const auto nd : face_nodes(mesh_, c_.surface.faces[c_.candidates[candidate].face])) {
      const Key b = root(key({static_cast<std::uint32_t>(nd), false})), ra = root(a);
      parent_[std::max(ra, b)] = std::min(ra, b);
    }
  }
  void move_together() {
    std::map<Key, std::vector<Key>> zones;
    std::vector<Key> members;
    for (const auto& [k, unused] : parent_) members.push_back(k);
    for (const Key k : members) zones[root(k)].push_back(k);
    for (const auto& [first, zone] : zones) {
      Vec3 momentum = Vec3::Zero();
      double mass = 0;
      int fixed = 0;
      for (const Key k : zone) {
        const PointRef p = point_ref(mesh_, particles_, point(k));
        momentum += p.m * *p.v;
        mass += p.m;
        fixed |= p.fixed;
      }
      const Vec3 v = free_part(momentum / mass, fixed);
      for (const Key k : zone) {
        const PointRef p = point_ref(mesh_, particles_, point(k));
        auto& e = exchanges_.try_emplace(k, LoneExchange{point(k), Vec3::Zero()}).first->second;
        e.impulse += p.m * (v - *p.v);
        push(*p.v, *p.v_mean, 0, v - *p.v);
        if (!e.point.particle) mesh_.nodes.awake[e.point.index] = 1;
      }
    }
  }

  fem::Mesh& mesh_;
  sph::Particles& particles_;
  double dt_;
  Contact& c_;
  std::map<Key, Key> parent_;
  std::map<Key, LoneExchange> exchanges_;
};

static void wake_struck(fem::Mesh& mesh, const std::vector<std::uint32_t>& active, const Contact& c) {
  std::vector<std::uint32_t> struck;
  for (const auto k : active) {
    struck.push_back(c.surface.faces[c.candidates[k].face].element);
    const auto& point = c.points[c.candidates[k].point];
    if (point.particle) continue;
    for (auto i = mesh.corner_start[point.index]; i < mesh.corner_start[point.index + 1]; ++i)
      if (mesh.elements.alive[mesh.corners[i] / 8]) struck.push_back(mesh.corners[i] / 8);
  }
  fem::wake_elements(mesh, struck);
}

/// What a step's contacts exchanged, to be booked once all velocities are final.
struct Exchanges {
  std::vector<std::uint32_t> active;   ///< candidates that met
  std::vector<Exchange> pair;          ///< [candidate]
  std::unique_ptr<ImpactZones> zones;
  std::vector<LoneExchange> walls;
};

static void resolve_faces(fem::Mesh& mesh, sph::Particles& particles, const ContactSettings& settings, double dt,
                          Contact& c, Exchanges& x) {
  for (int sweeps = 0; sweeps < most_sweeps;) {
    const auto met = detect(mesh, particles, dt, false, c);
    c.pairs_tested += c.candidates.size();
    if (met.empty()) break;
    x.pair.resize(c.candidates.size());
    // pairs found in earlier rounds stay in: they are the ones that impulses set moving again
    std::vector<std::uint32_t> merged;
    std::set_union(x.active.begin(), x.active.end(), met.begin(), met.end(), std::back_inserter(merged));
    x.active.swap(merged);
    for (int k = 0; k < 20 && sweeps < most_sweeps; ++k, ++sweeps)
      if (sweep(mesh, particles, x.active, settings, dt, c, x.pair) == 0) break;
  }
  if (x.active.empty()) return;
  x.zones = std::make_unique<ImpactZones>(mesh, particles, dt, c);
  x.zones->move();
}

/// Stops what would pass a wall during the step.
static void resolve_walls(fem::Mesh& mesh, sph::Particles& particles, const std::vector<Wall>& walls, double dt,
                          std::vector<LoneExchange>& exchanges) {
  for (const Wall& wall : walls) {
    const auto stop = [&](const ContactPoint& point) {
      const PointRef p = point_ref(mesh, particles, point);
      const double gap = wall.normal.dot(*p.x - wall.point), speed = wall.normal.dot(*p.v);
      const double allowed = -std::max(gap, 0.0) / dt;
      if (p.m == 0 || speed >= allowed) return;
      const Vec3 old = *p.v;
      push(*p.v, *p.v_mean, p.fixed, (allowed - speed) * wall.normal);
      exchanges.push_back({point, p.m * (*p.v - old)});
    };
    for (std::uint32_t nd = 0; nd < mesh.nodes.size(); ++nd) stop({nd, false});
    for (std::uint32_t i = 0; i < particles.size(); ++i) stop({i, true});
  }
}

static void book_walls(fem::Mesh& mesh, sph::Particles& particles, const std::vector<LoneExchange>& exchanges,
                       Contact& c) {
  for (const auto& e : exchanges) {
    const double work = book_lone(mesh, particles, e, c);
    if (heat_point(mesh, particles, e.point, -work)) c.heated -= work;
    c.wall_impulse += e.impulse;
    c.wall_angular_impulse += point_ref(mesh, particles, e.point).x->cross(e.impulse);
  }
}

static void resolve_bodies(fem::Mesh& mesh, sph::Particles& particles, const ContactSettings& settings, double time,
                           double dt, Contact& c, Exchanges& x) {
  if (!settings.enabled || mesh.n_alive == 0 || time + dt < c.quiet_until) return;
  if (!still_valid(mesh, particles, dt, c)) {
    const double quiet = time_to_meet(mesh, particles);
    if (quiet > steps_ahead * dt) {
      c.quiet_until = time + quiet;
      c.valid = false;
      return;
    }
    find_candidates(mesh, particles, dt, c);
  }
  measure_closing(mesh, c);
  resolve_faces(mesh, particles, settings, dt, c, x);
}

static void book(fem::Mesh& mesh, sph::Particles& particles, double dt, Contact& c, const Exchanges& x) {
  book_walls(mesh, particles, x.walls, c);
  if (x.active.empty()) return;
  for (const auto k : x.active)
    book(mesh, particles, c.points[c.candidates[k].point], c.surface.faces[c.candidates[k].face], x.pair[k], c);
  x.zones->book();
  c.leaks += detect(mesh, particles, dt, true, c).size();
  wake_struck(mesh, x.active, c);
}

void resolve_contact(fem::Mesh& mesh, sph::Particles& particles, const std::vector<Wall>& walls,
                     const ContactSettings& settings, double time, double dt, Contact& c) {
  Exchanges x;
  resolve_walls(mesh, particles, walls, dt, x.walls);
  resolve_bodies(mesh, particles, settings, time, dt, c, x);
  if (!x.active.empty()) resolve_walls(mesh, particles, walls, dt, x.walls);  // what bodies pushed against walls
  book(mesh, particles, dt, c, x);
}

}  // namespace coupling
