// SPDX-License-Identifier: Apache-2.0
#include "coupling/contact.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <iterator>
#include <memory>
#include <tuple>

#include "core/parallel.hpp"
#include "fem/elements.hpp"

namespace coupling {

using core::Vec3;

constexpr int steps_ahead = 4;  // bodies that cannot meet for so many steps are not searched
constexpr int most_sweeps = 100;
constexpr int two_way_sweeps = 30;  // of those, in which impulses are taken back too

/// Is there something that could strike something: more than one body, particles and elements, or walls?
static bool contact_possible(const fem::Mesh& mesh, const sph::Particles& particles, const std::vector<Wall>& walls) {
  return !walls.empty() || (mesh.n_alive > 0 && (mesh.body_elements.size() > 1 || particles.size() > 0));
}

// ------------------------------------------------------------------------------------------------ moving things

/// The matter of one step, and when whose velocity was changed.
struct Matter {
  fem::Mesh& mesh;
  sph::Particles& particles;
  double dt;
  const core::Symmetry& symmetry;
  Changes& changes;
};

/// What a point is made of, read and written through one door.
struct PointRef {
  ContactPoint point;
  Vec3* x;
  Vec3* v;
  Vec3* v_mean;
  std::uint32_t* changed;
  double m;
  int fixed;
};

static PointRef point_ref(const Matter& a, const ContactPoint& point) {
  const std::size_t i = point.index;
  auto& p = a.particles;
  auto& n = a.mesh.nodes;
  if (point.particle) return {point, &p.x[i], &p.v[i], &p.v_mean[i], &a.changes.particle[i], p.pt.m[i], 0};
  return {point, &n.x[i], &n.v[i], &n.v_mean[i], &a.changes.node[i], n.m[i], n.fixed[i]};
}

static PointRef node_ref(const Matter& a, std::uint32_t nd) { return point_ref(a, {nd, false}); }

/// A vector seen in symmetry planes: bits 1, 2, 4 those across x, y, z.
static Vec3 seen(Vec3 a, int image) {
  for (int d = 0; d < 3; ++d)
    if (image >> d & 1) a[d] = -a[d];
  return a;
}

/// f(image) for a point and the images that it may go on as within the time ahead: what passes a symmetry plane changes
/// places with its image there. Only matter that no element holds passes one.
template <class F>
static void each_image(const Matter& a, const PointRef& p, double ahead, F&& f) {
  int passed = 0;
  for (int d = 0; d < 3; ++d)
    if (a.symmetry.plane[static_cast<std::size_t>(d)] && p.point.body < 0 && (*p.x)[d] + ahead * (*p.v)[d] < 0) passed |= 1 << d;
  f(0);
  for (int image = passed; image > 0; image = (image - 1) & passed) f(image);
}

// ------------------------------------------------------------------------------------------------ impulses

static void note_change(const Matter& a, const PointRef& p) {
  *p.changed = ++a.changes.count;
  a.changes.log.push_back(p.point);
}

/// Changes a velocity by dv where it is free, and the mean velocity over the step with it.
static void push(const Matter& a, const PointRef& p, const Vec3& dv) {
  const Vec3 d = fem::free_part(dv, p.fixed);
  *p.v += d;
  *p.v_mean += 0.5 * d;
  note_change(a, p);
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
  for (const auto el : fem::elements_at(mesh, nd))
    if (e.alive[el]) mass += e.pt.m[el];
  if (mass == 0) return false;
  for (const auto el : fem::elements_at(mesh, nd))
    if (e.alive[el]) {
      e.pt.e[el] += heat / mass;
      if (!e.booked.empty()) e.booked[el] += heat * (e.pt.m[el] / mass);
    }
  return true;
}

static bool heat_point(const Matter& a, const ContactPoint& point, double heat) {
  if (!point.particle) return heat_node(a.mesh, point.index, heat);
  auto& pt = a.particles.pt;
  pt.e[point.index] += heat / pt.m[point.index];
  return true;
}

/// image: the one of the point that meets.
static void apply(const Matter& a, const PointRef& p, int image, const FaceNodes& node, const Meeting& m,
                  const ContactSettings& settings, Exchange& exchange) {
  auto& n = a.mesh.nodes;
  // of the motion in one direction that an impulse in another makes
  const auto inverse_mass = [&](const Vec3& direction, const Vec3& pushed) {
    double s = fem::free_part(direction, p.fixed).dot(pushed) / p.m;
    for (std::size_t k = 0; k < 4; ++k)
      s += m.weight[k] * m.weight[k] * fem::free_part(direction, n.fixed[node[k]]).dot(pushed) / n.m[node[k]];
    return s;
  };
  const double inverse = inverse_mass(m.normal, m.push);
  if (!(inverse > 0)) {  // nothing can give way: it stays a pair that meets
    note_change(a, p);
    return;
  }
  const double size = (m.target - m.gap_end) / a.dt / inverse;
  Vec3 impulse = size * m.push;
  if (settings.friction > 0) {
    Vec3 slip = seen(*p.v, image);
    for (std::size_t k = 0; k < 4; ++k) slip -= m.weight[k] * n.v[node[k]];
    slip -= slip.dot(m.push) * m.push;
    const double speed = slip.norm();
    if (speed > 0) impulse -= std::min(settings.friction * size, speed / inverse_mass(slip / speed, slip / speed)) * (slip / speed);
  }
  push(a, p, seen(impulse, image) / p.m);
  exchange.on_point += seen(impulse, image);
  for (std::size_t k = 0; k < 4; ++k) {
    push(a, node_ref(a, node[k]), -m.weight[k] * impulse / n.m[node[k]]);
    exchange.on_corner[k] -= m.weight[k] * impulse;
    n.awake[node[k]] = 1;
  }
}

// ------------------------------------------------------------------------------------------------ the solver

/// A pair that has met in this step. Ordered by face (element, side), then point (nodes before particles, images last): the
/// same for whatever lists it came from.
struct ActivePair {
  std::uint64_t face_key, point_key;
  Candidate candidate;
  int image = 0;             ///< of the point
  std::uint32_t tested = 0;  ///< count of changes when it was last tested
  Outward outward;           ///< of the face's corners
  Exchange exchange;
  Meeting last;              ///< the one that was last met with an impulse
  bool operator<(const ActivePair& o) const {
    return std::tie(face_key, point_key) < std::tie(o.face_key, o.point_key);
  }
  bool operator==(const ActivePair& o) const { return face_key == o.face_key && point_key == o.point_key; }
};

static std::uint64_t key(const ContactPoint& p) { return (static_cast<std::uint64_t>(p.particle) << 32) | p.index; }
static std::uint64_t key(const ContactPoint& p, int image) { return static_cast<std::uint64_t>(image) << 33 | key(p); }

static std::uint32_t last_change(const Matter& a, const FaceNodes& node) {
  const auto& c = a.changes.node;
  return std::max({c[node[0]], c[node[1]], c[node[2]], c[node[3]]});
}

/// What each face that stands in candidates sweeps within `ahead` at the velocities now.
static std::vector<FaceSweep> sweeps_of_paired(const Matter& a, const ContactLists& l, double ahead) {
  std::vector<FaceSweep> swept(l.paired.size());
  core::for_each(swept.size(), [&](std::size_t k) {
    const ContactFace& f = l.faces[l.paired[k]];
    if (a.mesh.elements.alive[f.face.element]) swept[k] = face_sweep(a.mesh.nodes, f.node, ahead);
  });
  return swept;
}

/// Candidates that may meet within the next steps_covered steps at the velocities now.
static std::vector<Candidate> near_pairs(const Matter& a, const ContactLists& l) {
  const auto& alive = a.mesh.elements.alive;
  const double ahead = steps_covered * a.dt;
  const auto swept = sweeps_of_paired(a, l, ahead);
  return core::collect<Candidate>(l.candidates.size(), [&](std::size_t k, std::vector<Candidate>& found) {
    const Candidate pair = l.candidates[k];
    const PointRef p = point_ref(a, l.points[pair.point]);
    const ContactFace& f = l.faces[pair.face];
    if (!alive[f.face.element] || !(p.m > 0)) return;
    bool near = false;
    each_image(a, p, ahead, [&](int image) { near = near || swept[f.paired].reaches(seen(*p.x, image), seen(*p.v, image)); });
    if (near) found.push_back(pair);
  });
}

/// Candidates with a side that contact may have changed after `since`.
static std::vector<Candidate> changed_pairs(const Matter& a, ContactLists& l, std::uint32_t since) {
  const Changes& c = a.changes;
  if (c.count == since) return {};
  std::vector<ContactPoint> changed;
  for (std::uint32_t count = since + 1; count <= c.count; ++count) {
    const ContactPoint& p = c.log[count - Changes::none - 1];
    if (*point_ref(a, p).changed == count) changed.push_back(p);  // the last of its changes
  }
  return candidates_of(changed, l);
}

/// The plane through a face's middle.
struct FacePlane {
  Vec3 centre, normal;
  double area;
};
static FacePlane plane_of(const std::vector<Vec3>& x, const FaceNodes& f) {
  const Vec3 area_2 = (x[f[2]] - x[f[0]]).cross(x[f[3]] - x[f[1]]);
  return {0.25 * (x[f[0]] + x[f[1]] + x[f[2]] + x[f[3]]), area_2.normalized(), 0.5 * area_2.norm()};
}

/// Is a node at a face from beside: next to its plane, with the matter that it belongs to behind that plane? So lie the edges of plates
/// of one size that are stacked: each node of one is on the outline of the other's side face, and moves past it, not into it.
static bool beside(const fem::Mesh& mesh, const ContactPoint& point, const FaceNodes& f) {
  constexpr double next_to = 2 * margin_part;  // of the face's size
  constexpr double behind = 0.3;   // sine of an angle
  if (point.particle) return false;
  const auto& x = mesh.nodes.x;
  const auto [centre, normal, area] = plane_of(x, f);
  if (normal.dot(x[point.index] - centre) > next_to * std::sqrt(area)) return false;
  Vec3 inside = Vec3::Zero();
  for (const auto el : fem::elements_at(mesh, point.index))
    if (mesh.elements.alive[el]) inside += fem::centre(mesh, el, x) - x[point.index];
  return normal.dot(inside) < -behind * inside.norm();
}

/// Across a face, or smoothed over the faces round its corners that it meets without a crease: the skin is round there and its facets are the mesh's.
/// What strikes a corner of several facets is pushed off by all of them then, and not aside by the one that comes first.
static Outward outward_of(const Matter& a, const fem::Surface& s, const ContactFace& f) {
  constexpr double crease = 0.7;  // cosine of the angle
  const fem::Elements& e = a.mesh.elements;
  const auto& n = a.mesh.nodes;
  const Vec3 across = plane_of(n.x, f.node).normal;
  Outward outward;
  for (std::size_t k = 0; k < 4; ++k) {
    Vec3 sum = Vec3::Zero();
    const auto add = [&](const Vec3& area) {
      if (area.dot(across) > crease * area.norm()) sum += area;
    };
    for (const auto el : fem::elements_at(a.mesh, f.node[k])) {
      if (!e.alive[el]) continue;
      for (std::uint8_t side = 0; side < 6; ++side) {
        if (!(s.exposed[el] >> side & 1)) continue;
        const FaceNodes node = face_nodes(a.mesh, {el, side});
        if (std::find(node.begin(), node.end(), f.node[k]) == node.end()) continue;
        const FacePlane plane = plane_of(n.x, node);
        for (int image = 0; image < 8; ++image)  // what lies behind symmetry planes is there as well
          if ((image & n.fixed[f.node[k]]) == image) add(plane.area * seen(plane.normal, image));
      }
    }
    outward[k] = sum.isZero(0) ? across : Vec3(sum.normalized());
  }
  return outward;
}

/// Those of the pairs that meet, ascending. strict: that cross.
static std::vector<ActivePair> detect(const Matter& a, const std::vector<Candidate>& pairs, bool strict, Contact& c) {
  const ContactLists& l = c.lists;
  c.pairs_tested += pairs.size();
  std::vector<FaceSweep> paired;  // each face's once, where most of them have pairs here
  if (pairs.size() > l.paired.size()) paired = sweeps_of_paired(a, l, a.dt);
  auto met = core::collect<ActivePair>(pairs.size(), [&](std::size_t k, std::vector<ActivePair>& found) {
    const ContactPoint& point = l.points[pairs[k].point];
    const ContactFace& f = l.faces[pairs[k].face];
    const PointRef p = point_ref(a, point);
    if (!a.mesh.elements.alive[f.face.element] || !(p.m > 0)) return;
    const FaceSweep swept = paired.empty() ? face_sweep(a.mesh.nodes, f.node, a.dt) : paired[f.paired];
    each_image(a, p, a.dt, [&](int image) {
      const Vec3 x = seen(*p.x, image), v = seen(*p.v, image);
      if (swept.reaches(x, v) && meet(a.mesh.nodes, f.node, nullptr, x, v, a.dt, strict).found && !beside(a.mesh, point, f.node))
        found.push_back({f.face.element * std::uint64_t{6} + f.face.face, key(point, image), pairs[k], image, 0, {}, {}, {}});
    });
  });
  std::sort(met.begin(), met.end());
  if (strict) return met;
  const auto first_of_face = [&](std::size_t k) { return k == 0 || met[k - 1].face_key != met[k].face_key; };
  core::for_each(met.size(), [&](std::size_t k) {
    if (first_of_face(k)) met[k].outward = outward_of(a, l.surface, l.faces[met[k].candidate.face]);
  });
  for (std::size_t k = 0; k < met.size(); ++k)
    if (!first_of_face(k)) met[k].outward = met[k - 1].outward;
  return met;
}

/// The time step that a node's approach to a face allows [s].
static double approach_step(const Matter& a, const ContactLists& l, const Candidate& pair) {
  constexpr double any = 1e300;
  const ContactPoint& point = l.points[pair.point];
  if (point.particle) return any;
  const auto& n = a.mesh.nodes;
  const FaceNodes& f = l.faces[pair.face].node;
  const auto [xc, normal, area] = plane_of(n.x, f);
  const Vec3 vc = 0.25 * (n.v[f[0]] + n.v[f[1]] + n.v[f[2]] + n.v[f[3]]);
  const double closing = normal.dot(vc - n.v[point.index]);
  if (!(closing > 0)) return any;
  const double when = std::max(0.0, normal.dot(n.x[point.index] - xc) / closing);
  if (when > steps_covered * a.dt) return any;
  core::Box box;
  for (const auto nd : f) box.add(n.x[nd] + when * n.v[nd]);
  const Vec3 x = n.x[point.index] + when * n.v[point.index];
  const double outside = (box.low - x).cwiseMax(x - box.high).maxCoeff();
  if (outside > edge_tolerance * (box.high - box.low).maxCoeff()) return any;
  const auto& pt = a.mesh.elements.pt;
  const std::uint32_t behind = l.faces[pair.face].face.element;
  const double depth = pt.m[behind] / pt.rho[behind] / area;
  return closing_part * std::min(std::sqrt(area), depth) / closing;
}

/// Takes back what of a pair's impulses is more than it needs, now that others have pushed its sides as well. Without this
/// the first pairs of a sweep push nodes off, which come back within a few steps, and where meshes are unlike that drives
/// the hourglass motion of the elements behind them.
static bool take_back(const Matter& a, const PointRef& p, const FaceNodes& node, ActivePair& pair) {
  Exchange& e = pair.exchange;
  if (e.on_point.isZero(0)) return false;
  const auto& n = a.mesh.nodes;
  const Meeting& m = pair.last;
  const double spare = gap_at_end(n, node, m.triangle, seen(*p.x, pair.image), seen(*p.v, pair.image), a.dt) - m.target;
  if (!(spare > m.slack)) return false;
  double opening = m.normal.dot(seen(fem::free_part(e.on_point, p.fixed), pair.image)) / p.m;  // that the impulses make [m/s]
  for (std::size_t k = 0; k < 4; ++k)
    opening -= m.weight[k] * m.normal.dot(fem::free_part(e.on_corner[k], n.fixed[node[k]])) / n.m[node[k]];
  if (!(opening > 0)) return false;
  const double kept = std::max(0.0, 1 - spare / (a.dt * opening));
  push(a, p, (kept - 1) * e.on_point / p.m);
  e.on_point *= kept;
  for (std::size_t k = 0; k < 4; ++k) {
    push(a, node_ref(a, node[k]), (kept - 1) * e.on_corner[k] / n.m[node[k]]);
    e.on_corner[k] *= kept;
  }
  return true;
}

/// One pass over the pairs in order; returns how many changed their impulse.
static std::size_t sweep(const Matter& a, std::vector<ActivePair>& active, const ContactSettings& settings,
                         const ContactLists& l, bool two_way) {
  std::size_t changed = 0;
  for (ActivePair& pair : active) {
    const PointRef p = point_ref(a, l.points[pair.candidate.point]);
    const FaceNodes& node = l.faces[pair.candidate.face].node;
    if (std::max(*p.changed, last_change(a, node)) <= pair.tested) continue;
    pair.tested = a.changes.count;
    const Meeting m = meet(a.mesh.nodes, node, &pair.outward, seen(*p.x, pair.image), seen(*p.v, pair.image), a.dt, false);
    if (m.found) {
      pair.last = m;
      apply(a, p, pair.image, node, m, settings, pair.exchange);
      ++changed;
    } else if (two_way) {
      changed += take_back(a, p, node, pair);
    }
  }
  return changed;
}

/// An impulse on one point that has no single partner: of a rigid wall, or within an impact zone.
struct LoneExchange {
  ContactPoint point;
  Vec3 impulse;
};

static double book_lone(const Matter& a, const LoneExchange& e, Contact& c) {
  const double work = e.impulse.dot(*point_ref(a, e.point).v_mean);
  c.dissipated -= work;
  return work;
}

/// The velocity along a wall's normal that takes a point to the wall within the step, and no farther [m/s].
static double allowed_at(const Wall& wall, const PointRef& p, double dt) { return -std::max(wall.normal.dot(*p.x - wall.point), 0.0) / dt; }

/// Rigid impact zones (Provot 1997; Bridson, Fedkiw & Anderson, ACM Trans. Graph. 21 (2002) 594, section 7.5): where
/// impulses have not parted a cluster of points and faces in most_sweeps passes (a light particle between two heavy
/// faces), its members go on together at the velocity of their common momentum; it grows until nothing crosses.
class ImpactZones {
 public:
  ImpactZones(const Matter& matter, const std::vector<Wall>& walls, Contact& c) : a_(matter), walls_(walls), c_(c) {}

  /// met: pairs that still meet.
  void move(std::vector<ActivePair> met) {
    constexpr int most_rounds = 50;
    for (int round = 0; round < most_rounds && !met.empty(); ++round) {
      for (const auto& pair : met) join(pair);
      const auto since = a_.changes.count;
      move_together();
      met = detect(a_, changed_pairs(a_, c_.lists, since), false, c_);
    }
  }

  /// After everything that may still change velocities.
  void book() {
    double dissipated = 0;
    for (const auto& [k, e] : exchanges_) dissipated -= book_lone(a_, e, c_);
    // heat to the zone's members by mass
    double mass = 0;
    for (const auto& [k, e] : exchanges_) mass += point_ref(a_, e.point).m;
    for (const auto& [k, e] : exchanges_) {
      const double heat = dissipated * point_ref(a_, e.point).m / mass;
      if (heat_point(a_, e.point, heat)) c_.heated += heat;
    }
  }

 private:
  using Key = std::uint64_t;
  static ContactPoint point(Key k) { return {static_cast<std::uint32_t>(k), (k >> 32) != 0}; }

  Key root(Key k) {
    const auto found = parent_.try_emplace(k, k).first;
    return found->second == k ? k : found->second = root(found->second);
  }
  void join(const ActivePair& pair) {
    const ContactPoint& point = c_.lists.points[pair.candidate.point];
    const Key a = root(key(point));
    held_[key(point)] |= pair.image;  // it and its image go on together where neither moves across the plane
    for (const auto nd : c_.lists.faces[pair.candidate.face].node) {
      const Key b = root(key({nd, false})), ra = root(a);
      parent_[std::max(ra, b)] = std::min(ra, b);
    }
  }
  /// Velocity of members that would go on at v, held in front of the walls that they lie at. What that takes is booked.
  Vec3 in_front_of_walls(const std::vector<Key>& zone, double mass, Vec3 v) {
    for (const Wall& wall : walls_) {
      double least = -1e300;
      Vec3 moment = Vec3::Zero();
      for (const Key k : zone) {
        const PointRef p = point_ref(a_, point(k));
        least = std::max(least, allowed_at(wall, p, a_.dt));
        moment += p.m * *p.x;
      }
      const double lacks = least - wall.normal.dot(v);
      if (!(lacks > 0)) continue;
      v += lacks * wall.normal;
      c_.wall_impulse += mass * lacks * wall.normal;
      c_.wall_angular_impulse += moment.cross(lacks * wall.normal);
    }
    return v;
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
        const PointRef p = point_ref(a_, point(k));
        momentum += p.m * *p.v;
        mass += p.m;
        fixed |= p.fixed | held_[k];
      }
      const Vec3 v = in_front_of_walls(zone, mass, fem::free_part(momentum / mass, fixed));
      for (const Key k : zone) {
        PointRef p = point_ref(a_, point(k));
        p.fixed = 0;  // v has no part along what is held
        auto& e = exchanges_.try_emplace(k, LoneExchange{point(k), Vec3::Zero()}).first->second;
        e.impulse += p.m * (v - *p.v);
        push(a_, p, v - *p.v);
        if (!e.point.particle) a_.mesh.nodes.awake[e.point.index] = 1;
      }
    }
  }

  Matter a_;
  const std::vector<Wall>& walls_;
  Contact& c_;
  std::map<Key, Key> parent_;
  std::map<Key, int> held_;  ///< directions in which a member must not move
  std::map<Key, LoneExchange> exchanges_;
};

static void wake_struck(fem::Mesh& mesh, const std::vector<ActivePair>& active, const ContactLists& l) {
  std::vector<std::uint32_t> struck;
  for (const auto& pair : active) {
    struck.push_back(l.faces[pair.candidate.face].face.element);
    const auto& point = l.points[pair.candidate.point];
    if (point.particle) continue;
    for (const auto el : fem::elements_at(mesh, point.index))
      if (mesh.elements.alive[el]) struck.push_back(el);
  }
  fem::wake_elements(mesh, struck);
}

/// What a step's contacts exchanged, to be booked once all velocities are final.
struct Exchanges {
  std::vector<ActivePair> active;      ///< pairs that met, ascending
  std::unique_ptr<ImpactZones> zones;
  std::vector<LoneExchange> walls;
};

/// Stops those of the points that would pass a wall during the step, with Coulomb friction along it. Returns how many.
template <class Point>
static std::size_t stop_at_walls(const Matter& a, const std::vector<Wall>& walls, double friction, std::size_t n_points, Point&& point,
                                 std::vector<LoneExchange>& exchanges) {
  std::size_t met = 0;
  for (const Wall& wall : walls) {
    const auto stopped = core::collect<ContactPoint>(n_points, [&](std::size_t k, auto& found) {
      const PointRef p = point_ref(a, point(k));
      if (p.m > 0 && wall.normal.dot(*p.v) < allowed_at(wall, p, a.dt)) found.push_back(point(k));
    });
    met += stopped.size();
    for (const auto& k : stopped) {
      const PointRef p = point_ref(a, k);
      const Vec3 old = *p.v;
      const double across = wall.normal.dot(old), stop = allowed_at(wall, p, a.dt) - across;
      if (!(stop > 0)) continue;  // it is in the list twice
      const Vec3 along = old - across * wall.normal;
      const double speed = along.norm();
      push(a, p, stop * wall.normal - (speed > 0 ? std::min(friction * stop / speed, 1.0) : 0.0) * along);
      exchanges.push_back({k, p.m * (*p.v - old)});
    }
  }
  return met;
}

/// The same of all points.
static void stop_all_at_walls(const Matter& a, const std::vector<Wall>& walls, double friction, std::vector<LoneExchange>& exchanges) {
  const std::size_t n_nodes = a.mesh.nodes.size();
  stop_at_walls(a, walls, friction, n_nodes + a.particles.size(), [&](std::size_t k) {
    return k < n_nodes ? ContactPoint{static_cast<std::uint32_t>(k), false} : ContactPoint{static_cast<std::uint32_t>(k - n_nodes), true};
  }, exchanges);
}

/// The same of what contact has changed after `since`.
static std::size_t stop_changed_at_walls(const Matter& a, const std::vector<Wall>& walls, double friction, std::uint32_t since,
                                         std::vector<LoneExchange>& exchanges) {
  if (walls.empty()) return 0;
  const auto& log = a.changes.log;
  const std::vector<ContactPoint> changed(log.begin() + (since - Changes::none), log.end());
  return stop_at_walls(a, walls, friction, changed.size(), [&](std::size_t k) { return changed[k]; }, exchanges);
}

static void resolve_faces(const Matter& a, const std::vector<Wall>& walls, const ContactSettings& settings, Contact& c, Exchanges& x) {
  const auto near = near_pairs(a, c.lists);
  c.step = core::min_where(near.size(), [&](std::size_t k) { return approach_step(a, c.lists, near[k]); }).value;
  auto met = detect(a, near, false, c);
  for (int sweeps = 0; !met.empty() && sweeps < most_sweeps;) {
    // pairs found in earlier rounds stay in: they are the ones that impulses set moving again
    std::vector<ActivePair> merged;
    std::set_union(x.active.begin(), x.active.end(), met.begin(), met.end(), std::back_inserter(merged));
    x.active.swap(merged);
    const auto since = a.changes.count;
    for (int k = 0; k < 20 && sweeps < most_sweeps; ++k, ++sweeps) {
      const auto before = a.changes.count;
      const std::size_t pairs = sweep(a, x.active, settings, c.lists, sweeps < two_way_sweeps);
      if (stop_changed_at_walls(a, walls, settings.friction, before, x.walls) + pairs == 0) break;
    }
    met = detect(a, changed_pairs(a, c.lists, since), false, c);
  }
  if (x.active.empty()) return;
  x.zones = std::make_unique<ImpactZones>(a, walls, c);
  x.zones->move(std::move(met));
}

static void resolve_bodies(const Matter& a, const std::vector<Wall>& walls, const ContactSettings& settings, double time, Contact& c, Exchanges& x) {
  if (!settings.enabled || a.mesh.n_alive == 0) return;
  if (time + steps_covered * a.dt < c.quiet_until && c.quiet_removed == a.mesh.n_removed) return;
  if (!keep_lists(a.mesh, a.particles, time, a.dt, c.lists)) {
    const auto times = times_to_meet(a.mesh, a.particles);
    const double quiet = *std::min_element(times.begin(), times.end());
    if (quiet > steps_ahead * a.dt) {
      c.quiet_until = time + quiet;
      c.quiet_removed = a.mesh.n_removed;
      c.lists.valid = false;
      return;
    }
    make_lists(a.mesh, a.particles, times, time, a.dt, c.lists);
    ++c.searches;
  }
  resolve_faces(a, walls, settings, c, x);
}

// ------------------------------------------------------------------------------------------------ books

/// Books the work of a pair's impulses; what they dissipate becomes heat of both sides, half and half.
static void book_pair(const Matter& a, const ActivePair& pair, Contact& c) {
  const ContactPoint& point = c.lists.points[pair.candidate.point];
  const FaceNodes& node = c.lists.faces[pair.candidate.face].node;
  const auto& on_corner = pair.exchange.on_corner;
  double work = pair.exchange.on_point.dot(*point_ref(a, point).v_mean), pushed = 0;
  for (std::size_t k = 0; k < 4; ++k) work += on_corner[k].dot(a.mesh.nodes.v_mean[node[k]]), pushed += on_corner[k].norm();
  if (pushed == 0) return;
  c.dissipated -= work;
  // half to the point's side, half round the corners where it met the face: one element alone would be left too hot
  double heated = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (const double part = -0.5 * work * on_corner[k].norm() / pushed; heat_node(a.mesh, node[k], part)) heated += part;
  if (heat_point(a, point, -0.5 * work)) heated -= 0.5 * work;
  c.heated += heated;
}

static void book_walls(const Matter& a, const std::vector<LoneExchange>& exchanges, Contact& c) {
  for (const auto& e : exchanges) {
    const double work = book_lone(a, e, c);
    if (heat_point(a, e.point, -work)) c.heated -= work;
    c.wall_impulse += e.impulse;
    c.wall_angular_impulse += point_ref(a, e.point).x->cross(e.impulse);
  }
}

/// What contact has not changed in this step was found not to meet: only the rest could cross.
static void book(const Matter& a, std::uint32_t start, Contact& c, const Exchanges& x) {
  book_walls(a, x.walls, c);
  if (x.active.empty()) return;
  for (const auto& pair : x.active) book_pair(a, pair, c);
  x.zones->book();
  c.leaks += detect(a, changed_pairs(a, c.lists, start), true, c).size();
  wake_struck(a.mesh, x.active, c.lists);
}

void resolve_contact(fem::Mesh& mesh, sph::Particles& particles, const std::vector<Wall>& walls,
                     const ContactSettings& settings, double time, double dt, Contact& c) {
  c.step = 1e300;
  c.changes.count = Changes::none;
  c.changes.log.clear();
  if (!contact_possible(mesh, particles, walls)) return;
  c.changes.node.assign(mesh.nodes.size(), Changes::none);
  c.changes.particle.assign(particles.size(), Changes::none);
  const Matter matter{mesh, particles, dt, settings.symmetry, c.changes};
  Exchanges x;
  stop_all_at_walls(matter, walls, settings.friction, x.walls);
  const auto start = c.changes.count;
  resolve_bodies(matter, walls, settings, time, c, x);
  book(matter, start, c, x);
}

}  // namespace coupling
