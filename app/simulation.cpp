// SPDX-License-Identifier: Apache-2.0
// One step. Positions and stress are known at n, velocities at n - 1/2; central difference. Each stage is one call, always
// made; a stage with nothing to do returns at once. Forces do their work with the mean of the velocities before and after
// the kick, and that work is exactly what internal energy gains (Caramana et al. 1998), so the ledger closes to round-off.
#include "app/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "coupling/convert.hpp"
#include "fem/elements.hpp"
#include "sph/particle_update.hpp"

namespace app {

/// Adds the time since the last mark to a stage.
class StageClock {
 public:
  explicit StageClock(Work& work) : work_(work), last_(Clock::now()) {}
  void mark(Stage stage) {
    const auto now = Clock::now();
    work_.seconds[static_cast<std::size_t>(stage)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Work& work_;
  Clock::time_point last_;
};

static double fastest_node(const fem::Mesh& mesh) {
  const auto& n = mesh.nodes;
  double fastest_2 = 0;
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b) {
    const auto at = [&](std::size_t k) {
      const std::size_t nd = mesh.body_nodes[b].first + k;
      return n.m[nd] > 0 ? -n.v[nd].squaredNorm() : 0.0;
    };
    if (mesh.body_awake[b]) fastest_2 = std::max(fastest_2, -core::min_where(mesh.body_nodes[b].size(), at).value);
  }
  return std::sqrt(fastest_2);
}

/// 0: neighbour lists, gradient corrections and stress of everything the pair sums touch.
static void find_neighbours(Simulation& s) {
  if (s.particles.size() == 0) return;
  auto& hood = s.hood;
  const auto fill = [&] {
    sph::fill_actors(s.particles, s.rho_0, hood);
    coupling::fill_foreign(s.mesh, s.bond, hood);
  };
  bool valid = hood.valid && hood.n_particles == s.particles.size();
  if (valid) {
    coupling::update_centres(s.mesh, s.bond);
    fill();
    valid = sph::still_valid(hood, s.bond.watched_x);
  }
  if (valid) {
    sph::reflect_places(hood);
  } else {
    coupling::find_elements(s.mesh, s.particles, s.bond);
    coupling::find_seam(s.mesh, s.bond);
    hood.n_particles = s.particles.size();
    hood.n_foreign = s.bond.x.size();
    hood.actors.resize(hood.n_particles + hood.n_foreign);
    fill();
    sph::build(hood, s.bond.watched_x, fastest_node(s.mesh));
  }
  sph::correct_gradients(s.particles, s.particle_settings, hood, s.correction);
  sph::reflect_images(hood);
  coupling::fill_anchors(s.mesh, s.bond, hood);
}

/// 1: forces of particles on each other and on the elements they are bonded to.
static void add_pair_forces(Simulation& s) {
  if (s.particles.size() == 0) return;
  fem::forget_pushes(s.mesh.nodes);
  sph::add_pair_forces(s.particle_settings, s.hood, s.particles);
  coupling::add_reaction(s.hood, s.bond, s.mesh);
  s.work.pair_updates += sph::n_pairs(s.hood);
}

/// Momentum that rigid walls give to particles, and to elements bonded to them, through their images.
static void book_wall_force(Simulation& s, double dt) {
  if (s.particles.size() == 0 || s.hood.wall_force.empty()) return;
  const auto& f = s.hood.wall_force;
  const core::Vec3 none = core::Vec3::Zero();
  s.contact.wall_impulse += dt * core::sum(f.size(), none, [&](std::size_t i) { return f[i]; });
  s.contact.wall_angular_impulse +=
      dt * core::sum(f.size(), none, [&](std::size_t i) { return core::Vec3(s.hood.actors.place[i].x.cross(f[i])); });
}

/// 4: the pairs' work, and the velocity gradient of the particles.
static void add_pair_work(Simulation& s, const fem::StepTimes& times) {
  if (s.particles.size() == 0) return;
  core::for_each(s.particles.size(), [&](std::size_t i) { sph::set_motion(s.hood, i, s.particles.v[i]); });
  coupling::fill_foreign_velocities(s.mesh, s.bond, s.hood);
  sph::reflect_velocities(s.hood);
  sph::pair_work(s.particle_settings, s.rho_0, times.kick, times.drift, s.correction, s.hood, s.particles, s.velocity_gradient);
  coupling::add_heat(s.hood, s.bond, times.kick, s.mesh);
}

/// 7: elements past the criteria become particles or go.
static void remove_distorted(Simulation& s) {
  if (s.spec.mode != io::Mode::hybrid && s.spec.mode != io::Mode::erosion) return;
  // elements change little in a step: all but collapsing ones are looked at every few, and go together
  constexpr int look_every = 4, look_at_all_every = 16;
  constexpr double deformed = 0.3, only_collapsing = 1e300;
  const double from = s.steps % look_at_all_every == 0 ? 0 : s.steps % look_every == 0 ? deformed : only_collapsing;
  const auto flagged = fem::flag_elements(s.mesh, s.criteria, s.rho_0, from);
  if (flagged.empty()) return;
  if (s.spec.mode == io::Mode::hybrid) {
    const auto r = coupling::convert_elements(s.mesh, s.particles, flagged, s.spec.particles_per_edge);
    s.ledger.conversion += r.conversion;
    s.n_converted += flagged.size();
  } else {
    for (const auto el : flagged) {
      const auto& e = s.mesh.elements;
      s.peak_removed = std::max(s.peak_removed, e.pt.p_max[el]);
      if (std::binary_search(s.on_axis.begin(), s.on_axis.end(), el)) s.peak_removed_axis = std::max(s.peak_removed_axis, e.pt.p_max[el]);
      if (!s.spec.keep_nodes) s.taken_along[e.body(el)] += e.pt.m[el] * (fem::centre(s.mesh, el, s.mesh.nodes.v) - s.scene.bodies[e.body(el)].velocity);
    }
    const auto r = coupling::erode_elements(s.mesh, flagged, s.spec.keep_nodes);
    s.ledger.eroded_kinetic += r.eroded_kinetic;
    s.ledger.eroded_internal += r.eroded_internal;
    s.ledger.eroded_booked += r.eroded_booked;
    s.ledger.eroded_mass += r.eroded_mass;
    s.ledger.eroded_momentum += r.eroded_momentum;
    s.ledger.eroded_angular_momentum += r.eroded_angular_momentum;
    s.n_eroded += flagged.size();
  }
  fem::drop_dead_blocks(s.mesh);
  s.hood.valid = false;
}

/// Particles that have drifted or were born apart are stored anew along the curve; at fixed steps, so that a resumed run
/// does the same. Few fit the cache in any order.
static void sort_particles(Simulation& s) {
  constexpr std::int64_t every = 256;
  constexpr std::size_t few = 8192;
  if (s.steps % every != 0 || s.particles.size() < few) return;
  sph::sort_along_curve(s.particles);
  coupling::invalidate(s.contact);
  s.hood.valid = false;
}

void step(Simulation& s) {
  const fem::StepTimes times{0.5 * (s.dt_old + s.dt), s.dt};
  StageClock clock(s.work);

  sort_particles(s);                                                                     // 0                        n
  find_neighbours(s);                                                                    //                         n
  clock.mark(Stage::search);
  add_pair_forces(s);                                                                    // 1                        n
  clock.mark(Stage::pair_forces);
  s.ledger.added_inertia = std::max(s.ledger.added_inertia, fem::add_inertia(s.mesh, s.slowed));  // 2 forces     n
  fem::kick_nodes(s.mesh, times.kick);                                                   //    v                 n+1/2
  sph::kick_particles(s.particles, times.kick);
  book_wall_force(s, times.kick);
  clock.mark(Stage::kick);
  coupling::resolve_contact(s.mesh, s.particles, s.walls, s.contact_settings, s.time, s.dt, s.contact);  // 3 v  n+1/2
  fem::wake_moving(s.mesh, s.sleep_threshold, s.contact.changes.count != coupling::Changes::none);
  clock.mark(Stage::contact);
  add_pair_work(s, times);                                                               // 4  e, grad v         n+1/2
  clock.mark(Stage::pair_work);
  fem::drift_nodes(s.mesh, s.dt);                                                        // 5  x                   n+1
  if (s.spec.keep_nodes) fem::keep_in_front(s.spec.symmetry, s.mesh);
  sph::drift_particles(s.particles, s.dt);
  clock.mark(Stage::drift);
  s.ledger.hourglass +=                                                                  // 6  stress, forces      n+1
      fem::update_awake_elements(s.mesh, s.materials, s.element_settings, times, s.bond.ring).hourglass;
  clock.mark(Stage::elements);
  sph::update_particles(s.particles, s.materials, s.mesh.body_material, s.velocity_gradient, s.dt);
  sph::keep_in_front(s.hood.mirrors, s.particles);
  clock.mark(Stage::particles);
  s.time += s.dt;
  s.hood.age += s.dt;
  s.dt_old = s.dt;
  ++s.steps;
  s.work.element_updates += fem::n_awake(s.mesh);
  s.work.element_updates_asleep += s.mesh.n_alive - std::min(s.mesh.n_alive, fem::n_awake(s.mesh));
  s.work.element_updates_slowed += s.slowed.size();
  s.work.particle_updates += s.particles.size();
  remove_distorted(s);                                                                   // 7                      n+1
  clock.mark(Stage::convert);
  app::account(s);                                                                       // 8                      n+1
  if (s.steps % 50 == 0) check_health(s);
  if (s.steps % 10 == 0) check_tables(s);
  clock.mark(Stage::account);
}

static core::MinWhere smallest_particle_step(const Simulation& s) {
  return core::min_where(s.particles.size(), [&](std::size_t i) { return s.particles.dt[i]; });
}

/// The smallest stable step of elements. A body at rest, asleep or not, that nothing can reach for many steps does not hold it.
static core::MinWhere elements_step(const Simulation& s) {
  constexpr double steps = 64;
  std::vector<std::pair<core::MinWhere, std::size_t>> of;
  for (std::size_t b = 0; b < s.mesh.body_elements.size(); ++b) of.push_back({fem::stable_step(s.mesh, b), b});
  std::sort(of.begin(), of.end(), [](const auto& a, const auto& b) { return a.first.value < b.first.value; });
  std::vector<double> meets;
  for (std::size_t k = 0; k + 1 < of.size(); ++k) {
    const auto& [limit, body] = of[k];
    if (limit.value >= 1e300 || s.mesh.elements.deformation[limit.index] > 0 || !fem::at_rest(s.mesh, body)) return limit;
    if (meets.empty()) meets = coupling::times_to_meet(s.mesh, s.particles);
    if (meets[body] < steps * std::min(of[k + 1].first.value, smallest_particle_step(s).value)) return limit;
  }
  return of.empty() ? core::MinWhere{} : of.back().first;
}

void choose_step(Simulation& s, double stop) {
  const auto el = elements_step(s);
  constexpr double collapsed = 0.01;
  if (el.value < 1e300 && el.value < collapsed * s.mesh.elements.dt_0[el.index])
    throw core::GuardError(fmt::format(
        "element {} of body \"{}\" is about to turn inside out at step {}, t = {:.4g} us: its stable step has fallen to {:.2g} "
        "of the first one (limit {:g}); {}",
        el.index, s.mesh.elements.body(el.index) < s.spec.bodies.size() ? s.spec.bodies[s.mesh.elements.body(el.index)].name : "",
        s.steps, s.time * 1e6, el.value / s.mesh.elements.dt_0[el.index], collapsed, advice(s)));
  const auto pt = smallest_particle_step(s);
  const double elements = fem::step_with_few_slowed(s.mesh, el);
  s.limit = elements <= pt.value ? StepLimit{"element", el.index, elements} : StepLimit{"particle", pt.index, pt.value};
  double dt = s.spec.cfl * s.limit.value;
  if (s.contact.step < dt) {
    dt = s.contact.step;
    s.limit = {"contact", 0, dt};
  }
  constexpr double growth = 1.1, first = 0.1;  // nothing is known yet of what the bodies are about to do to each other
  if (s.dt_old == 0) dt *= first;
  if (s.dt_old > 0 && dt > growth * s.dt_old) {
    dt = growth * s.dt_old;
    s.limit.kind = "growth";
  }
  // The last two steps before a stop share what is left, so that no step is a sliver.
  const double left = stop - s.time;
  if (2 * dt > left) {
    dt = dt >= left ? left : 0.5 * left;
    s.limit = {"end", 0, dt};
  }
  s.dt = dt;
  s.slowed = elements > el.value ? fem::slowed_elements(s.mesh, dt / s.spec.cfl) : std::vector<fem::Slowed>{};
}

/// Gas begins cold, and cold gas has no speed of sound: no step would be too long for it, and any that follows a shock would be no part of the first.
/// It counts as gas behind a shock of the impact's speed v, where sound runs at sqrt(gamma (gamma - 1)/2) v: half of v to three quarters.
static void limit_steps_of_cold_gas(Simulation& s) {
  constexpr double cold = 1e-3, shocked = 0.5;
  const double speed = s.scene.impact_velocity.norm();
  auto& e = s.mesh.elements;
  for (std::size_t el = 0; el < e.size(); ++el)
    if (e.alive[el] && e.pt.c[el] < cold * speed) e.dt[el] *= e.pt.c[el] / (shocked * speed);
}

void begin(Simulation& s) {
  fem::begin_elements(s.mesh, s.materials, s.element_settings, s.sleep_threshold >= 0);
  limit_steps_of_cold_gas(s);
  s.mesh.elements.dt_0 = s.mesh.elements.dt;
  std::fill(s.mesh.elements.deformation.begin(), s.mesh.elements.deformation.end(), 0.0);
  if (s.criteria.use_jacobian && s.spec.mode != io::Mode::fem) fem::store_initial_shape(s.mesh);
  s.n_elements_initial = s.mesh.n_alive;
  s.taken_along.assign(s.scene.bodies.size(), core::Vec3::Zero());
  if (s.spec.mode == io::Mode::sph) {
    std::vector<std::uint32_t> all;
    for (std::uint32_t el = 0; el < s.mesh.elements.size(); ++el)
      if (s.mesh.elements.alive[el]) all.push_back(el);
    coupling::fill_with_particles(s.mesh, s.particles, all, s.spec.particles_per_edge);
    s.mesh = fem::emptied(s.mesh);
  }
  s.ledger.initial = totals(s);
  account(s);
}

}  // namespace app
