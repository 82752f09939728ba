// SPDX-License-Identifier: Apache-2.0
#include "app/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "app/body_mesh.hpp"
#include "core/error.hpp"
#include "eos/hugoniot.hpp"
#include "fem/hex8.hpp"
#include "fem/parting.hpp"

namespace app {

using core::Vec3;

// ------------------------------------------------------------------------------------------------ symmetry

/// Is this body its own mirror image about the plane through the origin with normal along `axis`?
static bool symmetric(const io::BodySpec& b, int axis) {
  if (b.shape == io::Shape::mesh) return false;
  if (b.center[axis] != 0 || b.velocity[axis] != 0) return false;
  if (!lies_along(b, axis)) return false;
  // a spin is an axial vector: only its component along the plane's normal survives the mirror
  return b.spin[(axis + 1) % 3] == 0 && b.spin[(axis + 2) % 3] == 0;
}

static bool symmetric(const io::RigidWall& w, int axis) { return w.normal[axis] == 0; }

core::Symmetry find_symmetry(const io::Case& spec) {
  core::Symmetry s = spec.symmetry;
  for (int axis = 0; axis < 3; ++axis) {
    std::string odd;  // the first that is not its own image
    for (std::size_t w = spec.walls.size(); w-- > 0;)
      if (!symmetric(spec.walls[w], axis)) odd = fmt::format("wall.{}", w);
    for (auto b = spec.bodies.rbegin(); b != spec.bodies.rend(); ++b)
      if (!symmetric(*b, axis)) odd = fmt::format("body \"{}\"", b->name);
    const auto k = static_cast<std::size_t>(axis);
    if (spec.symmetry_auto)
      s.plane[k] = odd.empty() && axis < 2;  // about z only where a case asks: the line of flight is along it
    else if (s.plane[k] && !odd.empty())
      throw core::CaseError(fmt::format(
          "{}: run.symmetry names \"{}\", but the scene is not its own mirror image about that plane, for {} is not: every body must have "
          "center and velocity in it, one of its edges across it, and none a mesh from a file; use symmetry = \"auto\" or \"none\"",
          spec.file, "xyz"[axis], odd));
  }
  return s;
}

// ------------------------------------------------------------------------------------------------ scene

/// Does the line of flight meet the middle of a body that is no plate, a ball that lies on one, before it comes to a plate at `aim`?
static bool strikes_another_first(const io::Case& spec, int shot, int plate, const Vec3& aim) {
  const auto& bodies = spec.bodies;
  const auto& s = bodies[static_cast<std::size_t>(shot)];
  const Vec3 from = middle(s);
  const auto when = [&](const Vec3& to, const Vec3& v) { return (to - from).dot(v) / std::max(v.squaredNorm(), 1e-300); };
  const double at_plate = when(aim, s.velocity - bodies[static_cast<std::size_t>(plate)].velocity);
  return std::any_of(bodies.begin(), bodies.end(), [&](const io::BodySpec& b) {
    if (&b == &s || is_box(b)) return false;
    const Vec3 v = s.velocity - b.velocity;
    const double time = when(middle(b), v);
    return time > 0 && time < at_plate && (from + time * v - middle(b)).norm() < 0.5 * extent(b).maxCoeff();
  });
}

/// Warns where there is no reference pressure: shocks beyond the range of an equation of state are extrapolated.
static measure::Scene make_scene(const io::Case& spec, const std::vector<PlacedBody>& placed, std::vector<std::string>& warnings) {
  measure::Scene scene;
  scene.symmetry = spec.symmetry;
  scene.projectile = projectile_of(spec);
  const auto& shot = spec.bodies[static_cast<std::size_t>(scene.projectile)];
  scene.plates = plates_in_order(spec);
  scene.rest = scene.plates.empty() ? at_rest(spec) : spec.bodies[static_cast<std::size_t>(scene.plates[0])].velocity;
  scene.impact_velocity = shot.velocity - scene.rest;
  scene.projectile_size = smallest_extent(shot);
  scene.element_size = placed[static_cast<std::size_t>(scene.projectile)].element_size;
  const Vec3 rest = at_rest(spec);
  for (std::size_t b = 0; b < spec.bodies.size(); ++b) {
    const auto& body = spec.bodies[b];
    const auto& material = spec.materials.at(body.material);
    measure::BodyScene k;
    k.name = body.name;
    k.is_projectile = static_cast<int>(b) == scene.projectile;
    k.is_plate = !k.is_projectile && is_box(body) && body.velocity == rest;
    k.center = body.center;
    k.normal = body.normal.normalized();
    k.velocity = body.velocity;
    k.extent = io::extent(body);
    k.thickness = k.extent[2];
    for (const auto& wall : spec.walls) {
      const Vec3 away = wall.normal.normalized();
      if (body.shape == io::Shape::cylinder && std::abs(away.dot(k.normal)) >= 1 - 1e-9 && body.velocity.dot(away) < 0) k.bar_axis = away;
    }
    k.rho_0 = material.rho_0;
    k.e_melt = material.e_melt, k.e_melted = material.e_melted;
    k.e_vapour = material.e_vapour, k.e_vaporised = material.e_vaporised;
    scene.bodies.push_back(k);
  }
  for (const int b : scene.plates)
    if (struck_from_side(spec, static_cast<std::size_t>(b)))
      warnings.push_back(fmt::format("the line of flight enters body \"{}\" through a side: its craters, holes, bulge and impulse are those along its normal; "
                                     "let the normal be that of the face which is struck", spec.bodies[static_cast<std::size_t>(b)].name));
  scene.aim = middle(shot);
  if (!scene.plates.empty()) {
    const auto& first = scene.bodies[static_cast<std::size_t>(scene.plates[0])];
    scene.aim = where_struck(spec, static_cast<std::size_t>(scene.plates[0]));
    scene.element_size = placed[static_cast<std::size_t>(scene.plates[0])].element_size;
    if (strikes_another_first(spec, scene.projectile, scene.plates[0], scene.aim)) return scene;  // no reference for what that is
    const std::string& struck = spec.bodies[static_cast<std::size_t>(scene.plates[0])].material;
    const auto &a = spec.materials.at(shot.material), &b = spec.materials.at(struck);
    const double closing = std::abs(scene.impact_velocity.dot(first.normal));
    const bool square = shot.shape == io::Shape::sphere && closing > 0.999 * scene.impact_velocity.norm();
    try {
      scene.peak_pressure_axis_hugoniot = eos::impact_pressure(a.eos, a.rho_0, b.eos, b.rho_0, closing);
      if (square) scene.peak_pressure_jetting = eos::onset_of_jetting(a.eos, a.rho_0, b.eos, b.rho_0, closing).p;
    } catch (const core::CaseError& e) {
      throw core::CaseError(fmt::format("{}: eos of \"{}\" or \"{}\", which meet at {:.4g} km/s: {}", spec.file, shot.material, struck, closing * 1e-3, e.what()));
    }
    if (closing > 0 && !(scene.peak_pressure_axis_hugoniot > 0))
      warnings.push_back(fmt::format(
          "{} on {} at {:.4g} km/s compresses one of them beyond the range of its equation of state: pressures there are extrapolated and "
          "peak_pressure_hugoniot is left out; a model of wider range (tillotson, or a table from \"ejecta eos table\") would cover it",
          shot.material, struck, closing * 1e-3));
  }
  return scene;
}

// ------------------------------------------------------------------------------------------------ state

/// Holds the nodes on symmetry planes in their plane.
static void hold_symmetry(const core::Symmetry& symmetry, fem::Nodes& nodes) {
  double size = 0;
  for (const Vec3& x : nodes.x) size = std::max(size, x.cwiseAbs().maxCoeff());
  for (std::size_t nd = 0; nd < nodes.size(); ++nd)
    for (int d = 0; d < 3; ++d)
      if (symmetry.plane[static_cast<std::size_t>(d)] && std::abs(nodes.x[nd][d]) < 1e-12 * size) {
        nodes.x[nd][d] = 0;
        nodes.v[nd][d] = 0;
        nodes.fixed[nd] = static_cast<std::uint8_t>(nodes.fixed[nd] | 1 << d);
      }
}

static void start_moving(const io::BodySpec& body, core::Range nodes, fem::Nodes& n) {
  for (std::size_t nd = nodes.first; nd < nodes.last; ++nd) {
    n.v[nd] = body.velocity + body.spin.cross(n.x[nd] - body.center);
    n.v_mean[nd] = n.v[nd];
  }
}

/// A coarse surface node carries more mass into fine elements than stands there: until the wave has come back to it, they are
/// pushed at its speed.
static void warn_of_mismatch(const io::Case& spec, const std::vector<PlacedBody>& placed, std::vector<std::string>& warnings) {
  constexpr double fair = 0.6, fairly_flat = 0.49;  // of what the projectile has
  const auto& shot = placed[static_cast<std::size_t>(projectile_of(spec))];
  for (const auto& b : placed)
    if (b.too_coarse)
      warnings.push_back(fmt::format("body \"{}\" has the coarse mesh of a plate that nothing can get to before run.mesh_end = {:.4g} us, and something may before run.end = {:.4g} us",
                                     b.spec->name, spec.mesh_end * 1e6, spec.end * 1e6));
  for (const int b : plates_in_order(spec)) {
    const auto& plate = placed[static_cast<std::size_t>(b)];
    const bool fine = plate.element_size < fair * shot.element_size, flat = spec.mode != io::Mode::sph && plate.layer < fairly_flat * shot.element_size;
    if (fine || flat)
      warnings.push_back(fmt::format(
          "body \"{}\" has {} of {:.3g} mm and \"{}\", which strikes it, elements of {:.3g} mm: pressures where they meet come out too high, by 6 % (elements) and "
          "12 to 15 % (layers) at half the size, by 30 to 40 % at 0.4 and by 80 % at a quarter (8 km/s); take like sizes for both",
          plate.spec->name, flat ? "layers of elements" : "elements", (flat ? plate.layer : plate.element_size) * 1e3, shot.spec->name, shot.element_size * 1e3));
  }
}

/// The column of elements built next to the line of flight: where the pressure on the axis is read.
static void mark_axis(Simulation& s) {
  s.on_axis.clear();
  if (s.scene.impact_velocity.isZero(0)) return;
  const Vec3 along = s.scene.impact_velocity.normalized();
  for (std::uint32_t el = 0; el < s.mesh.elements.size(); ++el) {
    const Vec3 d = fem::centre(s.mesh, el, s.mesh.nodes.x) - s.scene.aim;
    if ((d - d.dot(along) * along).norm() <= 1.25 * s.scene.element_size) s.on_axis.push_back(el);
  }
}

static void choose_settings(Simulation& s) {
  const io::Case& c = s.spec;
  auto& e = s.element_settings;
  if (c.viscosity_linear >= 0) e.viscosity_linear = c.viscosity_linear;
  if (c.viscosity_quadratic >= 0) e.viscosity_quadratic = c.viscosity_quadratic;
  e.hourglass_stiffness = c.hourglass == "stiffness";
  if (c.hourglass_coefficient >= 0) e.hourglass = c.hourglass_coefficient;
  if (e.hourglass_stiffness) s.mesh.elements.hourglass.assign(s.mesh.elements.size() * 12, 0.0);
  if (c.mode == io::Mode::erosion) s.mesh.elements.booked.assign(s.mesh.elements.size(), 0.0);

  auto& k = s.criteria;
  for (const auto& name : c.criteria) {
    k.use_deformation |= name == "deformation";
    k.use_jacobian |= name == "jacobian";
    k.use_plastic_strain |= name == "plastic_strain";
    k.use_timestep |= name == "timestep";
    k.use_damage |= name == "damage";
  }
  k.deformation = c.deformation, k.jacobian_ratio = c.jacobian_ratio, k.min_angle = c.min_angle;
  k.plastic_strain = c.plastic_strain, k.timestep_ratio = c.timestep_ratio, k.damage = c.damage;
  // Matter that has expanded this far is a spray and not a solid; as an element it would reach a kernel's sums too thin.
  k.expansion = c.mode == io::Mode::hybrid ? 0.8 : 0.0;
  k.left_over = c.mode == io::Mode::hybrid ? 0.7 : 0.0;

  s.contact_settings = {c.contact, c.friction, c.symmetry};
  s.bond.hold = c.bond;
  s.bond.per_edge = c.particles_per_edge;
  s.sleep_threshold = c.sleep;
  for (const auto& w : c.walls) {
    s.walls.push_back({w.point, w.normal.normalized()});
    s.hood.mirrors.push_back({w.point, w.normal.normalized(), true});
  }
  for (int d = 0; d < 3; ++d)
    if (c.symmetry.plane[static_cast<std::size_t>(d)]) s.hood.mirrors.push_back({Vec3::Zero(), Vec3::Unit(d), false});
}

double available_memory() {
  std::ifstream f("/proc/meminfo");
  std::string key;
  double kib = 0;
  for (std::string unit; f >> key >> kib; std::getline(f, unit))
    if (key == "MemAvailable:") return kib * 1024;
  return 1e300;
}

constexpr double bytes_per_element = 640, bytes_per_particle = 2400;

Estimate estimate(const io::Case& given) {
  io::Case spec = given;
  measure_decks(spec);
  spec.symmetry = find_symmetry(spec);
  Estimate r;
  for (const auto& b : place_bodies(spec)) {
    r.bodies.push_back({b.spec->name, b.count, b.element_size});
    r.elements += b.count;
  }
  r.bytes = r.elements * bytes_per_element;
  if (spec.mode == io::Mode::sph) r.bytes += r.elements * std::pow(spec.particles_per_edge, 3) * bytes_per_particle;
  r.available = available_memory();
  return r;
}

std::unique_ptr<Simulation> set_up(const io::Case& given) {
  auto s = std::make_unique<Simulation>();
  s->spec = given;
  io::Case& spec = s->spec;
  measure_decks(spec);
  spec.symmetry = find_symmetry(spec);
  spec.symmetry_auto = false;
  if (!(spec.mesh_end > 0)) spec.mesh_end = spec.end;
  const Estimate cost = estimate(spec);
  if (cost.bytes > cost.available)
    throw core::CaseError(fmt::format(
        "{}: {} gives {:.0f} elements, which need about {:.1f} GiB; this machine has {:.1f} GiB free. A coarser fidelity (draft, "
        "standard, fine, reference), fewer elements_across or a smaller fine_radius would fit",
        spec.file,
        spec.fidelity == "custom" ? fmt::format("run.elements_across = {}", spec.elements_across)
                                  : fmt::format("run.fidelity = \"{}\" ({} elements across)", spec.fidelity, spec.elements_across), cost.elements, cost.bytes / (1 << 30), cost.available / (1 << 30)));
  auto placed = place_bodies(spec);
  check_places(spec, placed);
  warn_of_mismatch(spec, placed, s->warnings);
  for (auto& b : placed) {
    const auto& material = spec.materials.at(b.spec->material);
    s->materials.push_back(material);
    s->rho_0.push_back(material.rho_0);
    fem::add_body(s->mesh, b.make(), static_cast<int>(s->materials.size()) - 1, material.rho_0);
    start_moving(*b.spec, s->mesh.body_nodes.back(), s->mesh.nodes);
  }
  fem::finish(s->mesh);
  hold_symmetry(spec.symmetry, s->mesh.nodes);
  fem::part_bodies(s->mesh);
  s->scene = make_scene(spec, placed, s->warnings);
  s->built.reserve(s->mesh.elements.size());
  for (std::size_t el = 0; el < s->mesh.elements.size(); ++el)
    s->built.push_back(fem::centre(s->mesh, el, s->mesh.nodes.x).cast<float>());
  s->scene.built = s->built;
  for (std::size_t b = 0; b < placed.size(); ++b) {
    auto& e = s->mesh.elements;
    const auto& material = s->materials[b];
    const double temperature = eos::state(material.eos, material.rho_0, 0.0).temperature, sound = material::sound_speed(material);
    for (std::size_t el = s->mesh.body_elements[b].first; el < s->mesh.body_elements[b].last; ++el) {
      e.pt.T[el] = temperature;
      e.pt.p[el] = 0;
      e.pt.c[el] = sound;
    }
  }
  choose_settings(*s);
  mark_axis(*s);
  return s;
}

}  // namespace app
