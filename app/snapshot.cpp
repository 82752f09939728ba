// SPDX-License-Identifier: Apache-2.0
#include "app/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "measure/whole.hpp"

namespace app {

using core::Vec3;

static const std::string frozen_prefix = "frozen:";
static std::string impulse_name(const std::string& body, int d) { return std::string("impulse_") + "xyz"[d] + ":" + body; }

constexpr std::size_t n_fields = 12;  // of give_snapshot()

io::SnapshotSize snapshot_size(const Simulation& s) {
  return {s.time, s.steps, s.mesh.nodes.size(), s.mesh.n_alive, s.particles.size(), n_fields};
}

void give_snapshot(const Simulation& s, io::SnapshotSink& to) {
  const auto& e = s.mesh.elements;
  const auto& p = s.particles;
  /// A row each of the elements alive, of(el), one piece after the other.
  const auto of_alive = [&](auto&& of) {
    return [&e, of, el = std::size_t{0}](auto rows) mutable {
      for (auto& row : rows) {
        while (!e.alive[el]) ++el;
        row = of(el++);
      }
    };
  };
  /// of_element(el), of_particle(i)
  const auto rows = [&](const char* name, auto&& of_element, auto&& of_particle) {
    const auto next_particles = [&, i = std::size_t{0}](std::span<double> particle) mutable {
      for (double& row : particle) row = of_particle(i++);
    };
    to.field(name, s.mesh.n_alive, of_alive(of_element), p.size(), next_particles);
  };
  const auto point = [&](const char* name, const std::vector<double>& a, const std::vector<double>& b) {
    rows(name, [&](std::size_t el) { return a[el]; }, [&](std::size_t i) { return b[i]; });
  };
  const auto edge = [](const core::Points& pt) { return [&pt](std::size_t k) { return std::cbrt(pt.m[k] / pt.rho[k]); }; };

  to.nodes(s.mesh.nodes.x, s.mesh.nodes.v);
  to.corners(s.mesh.n_alive, of_alive([&](std::size_t el) { return e.node[el]; }));
  to.particles(p.x, p.v);
  point("mass", e.pt.m, p.pt.m);
  point("density", e.pt.rho, p.pt.rho);
  point("pressure", e.pt.p, p.pt.p);
  point("internal_energy", e.pt.e, p.pt.e);
  point("temperature", e.pt.T, p.pt.T);
  point("plastic_strain", e.pt.eps_p, p.pt.eps_p);
  point("damage", e.pt.damage, p.pt.damage);
  point("peak_pressure", e.pt.p_max, p.pt.p_max);
  rows("speed", [&](std::size_t el) { return fem::centre(s.mesh, el, s.mesh.nodes.v).norm(); }, [&](std::size_t i) { return p.v[i].norm(); });
  rows("body", [&](std::size_t el) { return e.body(el); }, [&](std::size_t i) { return p.body[i]; });
  rows("size", edge(e.pt), edge(p.pt));
  rows("id", [&](std::size_t el) { return static_cast<double>(el); }, [&](std::size_t i) { return p.parent[i]; });

  const measure::Scene scene = scene_now(s);
  to.scalar("peak_pressure_axis", scene.peak_pressure_axis);
  to.scalar("peak_pressure_max", scene.peak_pressure_max);
  for (const auto& b : scene.bodies)
    for (int d = 0; d < 3; ++d) to.scalar(impulse_name(b.name, d), b.impulse[d]);
  for (const auto& v : s.frozen) to.scalar(frozen_prefix + v.key + "|" + v.unit, v.value);
}

io::Snapshot take_snapshot(const Simulation& s) {
  return io::collect(snapshot_size(s), [&](io::SnapshotSink& to) { give_snapshot(s, to); });
}

/// Element numbers must be those of the mesh that the case builds.
static void check_elements(const io::Snapshot& snapshot, const measure::Scene& scene) {
  double last = 0;
  if (const auto* id = snapshot.find("id"))
    for (const auto* rows : {&id->element, &id->particle})
      for (const double i : *rows) last = std::max(last, i);
  if (last >= static_cast<double>(scene.built.size()))
    throw core::CaseError(fmt::format(
        "the stored state holds element {:.0f}, but the case.toml beside it builds {}: it was changed since, or the run is of another version; run it again",
        last, scene.built.size()));
}

std::vector<measure::Value> recall(const io::Snapshot& snapshot, measure::Scene& scene) {
  check_elements(snapshot, scene);
  std::vector<measure::Value> frozen;
  scene.time = snapshot.time;
  for (const auto& [name, value] : snapshot.scalars) {
    if (name == "peak_pressure_axis") scene.peak_pressure_axis = value;
    if (name == "peak_pressure_max") scene.peak_pressure_max = value;
    for (auto& b : scene.bodies)
      for (int d = 0; d < 3; ++d)
        if (name == impulse_name(b.name, d)) b.impulse[d] = value;
    if (name.rfind(frozen_prefix, 0) == 0) {
      const auto bar = name.rfind('|');
      frozen.push_back({name.substr(frozen_prefix.size(), bar - frozen_prefix.size()), value, name.substr(bar + 1)});
    }
  }
  return frozen;
}

/// "bumper.cloud." of "bumper.cloud.mass".
static std::string family(const std::string& key) { return key.substr(0, key.rfind('.') + 1); }

measure::Result measure_snapshot(io::Snapshot snapshot, const measure::Scene& scene,
                                 const std::vector<measure::Value>& frozen) {
  measure::Result r = measure::measure(matter_of(std::move(snapshot)), scene);
  // a cloud that was taken before it struck stands as it was, with what it had no value of
  std::erase_if(r.values, [&](const auto& v) {
    return std::any_of(frozen.begin(), frozen.end(), [&](const auto& f) { return family(f.key) == family(v.key); });
  });
  r.values.insert(r.values.end(), frozen.begin(), frozen.end());
  return r;
}

/// What is between the k-th plate and the next one at a time, 0 where they touch [m].
static double gap_behind(const measure::Scene& scene, std::size_t k, double time) {
  const auto &plate = scene.bodies[static_cast<std::size_t>(scene.plates[k])], &wall = scene.bodies[static_cast<std::size_t>(scene.plates[k + 1])];
  const Vec3 normal = measure::plate_frame(scene, scene.plates[k + 1]).axes.row(2), apart = plate.center - wall.center + time * (plate.velocity - wall.velocity);
  return std::max(0.0, normal.dot(apart) - 0.5 * (plate.thickness + wall.thickness));
}

constexpr double near_part = 0.25;

/// How near a cloud's front may come to the next plate before the cloud is measured: a quarter of the projectile's size, or of what
/// is between the plates [m].
static double near_enough(const measure::Scene& scene, std::size_t k) { return near_part * std::min(scene.projectile_size, gap_behind(scene, k, scene.time)); }

/// The plate behind which the first impact is over: layers that lie on each other, or nearly so, are struck as one.
static std::size_t last_of_first_impact(const measure::Scene& scene) {
  std::size_t k = 0;
  while (k + 1 < scene.plates.size() && gap_behind(scene, k, 0) < near_part * scene.projectile_size) ++k;
  return k;
}

/// Is this on its way from a plate, and no part of a plate whose edge comes near the next one, or of what stands between them?
/// x, v: place and velocity as seen from that plate.
static bool has_left(const measure::PlateFrame& plate, double impact_speed, const Vec3& x, const Vec3& v) {
  const double speed = v.norm();
  return speed > measure::loose_speed * impact_speed || (speed > measure::settled_speed * impact_speed && x.z() < -plate.thickness);
}

constexpr double fastest_debris = 2;  ///< of the impact speed: more than any flies at

void freeze_clouds(Simulation& s) {
  if (s.time < s.clouds_due) return;
  s.clouds_due = 1e300;
  s.scene.time = s.time;
  const measure::Scene& scene = s.scene;
  s.cloud_frozen.resize(scene.plates.size(), 0);
  for (std::size_t k = 0; k + 1 < scene.plates.size(); ++k) {
    if (s.cloud_frozen[k]) continue;
    const measure::PlateFrame plate = measure::plate_frame(scene, scene.plates[k]), wall = measure::plate_frame(scene, scene.plates[k + 1]);
    const Vec3 flown = scene.bodies[static_cast<std::size_t>(scene.plates[k])].velocity;
    const double impact_speed = scene.impact_velocity.norm();
    const auto may_strike = measure::built_before(scene, k);
    double nearest = 1e300, ahead = 1e300;  // what may be the front, and what lies before it
    const auto note = [&](const Vec3& x, const Vec3& v) {
      const Vec3 local = wall.local(x);
      const double height = local.z() - wall.half.z();
      ahead = std::min(ahead, height);
      if (height < nearest && wall.rim(local) <= 1 && has_left(plate, impact_speed, plate.local(x), v - flown)) nearest = height;
    };
    for (std::size_t i = 0; i < s.particles.size(); ++i)
      if (may_strike[s.particles.body[i]]) note(s.particles.x[i], s.particles.v[i]);
    for (std::size_t b = 0; b < s.mesh.body_nodes.size(); ++b) {
      if (!may_strike[b]) continue;
      for (std::size_t nd = s.mesh.body_nodes[b].first; nd < s.mesh.body_nodes[b].last; ++nd)
        if (s.mesh.nodes.m[nd] > 0) note(s.mesh.nodes.x[nd], s.mesh.nodes.v[nd]);
    }
    if (nearest > near_enough(scene, k)) {
      const double closing = impact_speed + (scene.bodies[static_cast<std::size_t>(scene.plates[k + 1])].velocity - scene.rest).norm();
      s.clouds_due = std::min(s.clouds_due, s.time + std::max(0.0, ahead - near_enough(scene, k)) / (fastest_debris * closing));
      continue;
    }
    s.cloud_frozen[k] = 1;
    const measure::Scene now = scene_now(s);
    if (k == last_of_first_impact(scene)) s.peak_impact = now.peak_pressure_axis;
    const auto r = measure::measure_cloud(matter_of(take_snapshot(s)), now, k);
    s.frozen.insert(s.frozen.end(), r.values.begin(), r.values.end());
  }
}

/// Takes a field out of a snapshot: elements, then particles. Empty where it has none of that name.
static std::vector<double> take_field(io::Snapshot& s, const char* name) {
  const auto f = std::find_if(s.fields.begin(), s.fields.end(), [&](const auto& field) { return field.name == name; });
  if (f == s.fields.end()) return {};
  std::vector<double> a = std::move(f->element);
  a.reserve(a.size() + f->particle.size());
  a.insert(a.end(), f->particle.begin(), f->particle.end());
  s.fields.erase(f);
  return a;
}

measure::Matter matter_of(io::Snapshot s) {
  measure::Matter m;
  m.n_elements = s.element_node.size();
  auto &x = m.x.own, &v = m.v.own;
  x.reserve(m.n_elements + s.particle_x.size());
  v.reserve(m.n_elements + s.particle_x.size());
  for (const auto& corners : s.element_node) {
    Vec3 at = Vec3::Zero(), speed = Vec3::Zero();
    for (const auto nd : corners) {
      at += s.node_x[static_cast<std::size_t>(nd)];
      speed += s.node_v[static_cast<std::size_t>(nd)];
    }
    x.push_back(at / 8);
    v.push_back(speed / 8);
  }
  m.node = std::move(s.element_node);
  m.node_x = std::move(s.node_x);
  core::free_all(s.node_v);
  x.insert(x.end(), s.particle_x.begin(), s.particle_x.end());
  v.insert(v.end(), s.particle_v.begin(), s.particle_v.end());
  m.m.own = take_field(s, "mass");
  m.rho.own = take_field(s, "density");
  m.e.own = take_field(s, "internal_energy");
  m.T.own = take_field(s, "temperature");
  m.damage.own = take_field(s, "damage");
  m.size.own = take_field(s, "size");
  const auto body = take_field(s, "body"), id = take_field(s, "id");
  m.body.own.assign(body.begin(), body.end());
  m.parent.own.assign(id.begin(), id.end());
  return m;
}

/// Momentum of what is left of each body's own elements is no measure of its impulse; momentum of all its matter is, against the
/// velocity that the body began with.
static void add_impulses(const Simulation& s, measure::Scene& scene) {
  const auto& n = s.mesh.nodes;
  std::vector<Vec3> momentum = s.taken_along;
  for (std::size_t b = 0; b < s.mesh.body_nodes.size(); ++b)
    for (auto nd = s.mesh.body_nodes[b].first; nd < s.mesh.body_nodes[b].last; ++nd) momentum[b] += n.m[nd] * (n.v[nd] - scene.bodies[b].velocity);
  for (std::size_t i = 0; i < s.particles.size(); ++i)
    momentum[s.particles.body[i]] += s.particles.pt.m[i] * (s.particles.v[i] - scene.bodies[s.particles.body[i]].velocity);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    Vec3 p = momentum[b];
    for (int d = 0; d < 3; ++d)
      if (s.spec.symmetry.plane[static_cast<std::size_t>(d)]) p[d] = 0;  // the other half cancels it
    scene.bodies[b].impulse = p * s.spec.symmetry.copies();
  }
}

measure::Scene scene_now(const Simulation& s) {
  measure::Scene scene = s.scene;
  scene.time = s.time;
  add_impulses(s, scene);
  double all = s.peak_removed, axis = s.peak_removed_axis;
  const auto& e = s.mesh.elements;
  for (std::size_t el = 0; el < e.size(); ++el)
    if (e.alive[el]) all = std::max(all, e.pt.p_max[el]);
  for (const auto el : s.on_axis)
    if (el < e.size() && e.alive[el]) axis = std::max(axis, e.pt.p_max[el]);
  for (std::size_t i = 0; i < s.particles.size(); ++i) {
    all = std::max(all, s.particles.pt.p_max[i]);
    if (std::binary_search(s.on_axis.begin(), s.on_axis.end(), s.particles.parent[i])) axis = std::max(axis, s.particles.pt.p_max[i]);
  }
  scene.peak_pressure_axis = s.peak_impact > 0 ? s.peak_impact : axis;
  scene.peak_pressure_max = all;
  return scene;
}

}  // namespace app
