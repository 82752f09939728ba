// SPDX-License-Identifier: Apache-2.0
#include "app/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/simulation.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "eos/hugoniot.hpp"

namespace app {

using core::Vec3;

Totals& Totals::operator+=(const Totals& o) {
  mass += o.mass;
  kinetic += o.kinetic;
  internal += o.internal;
  momentum += o.momentum;
  angular_momentum += o.angular_momentum;
  momentum_size += o.momentum_size;
  angular_size += o.angular_size;
  return *this;
}

Totals Totals::operator+(const Totals& o) const {
  Totals r = *this;
  return r += o;
}

static Totals moving(double m, const Vec3& x, const Vec3& v) {
  Totals t;
  t.mass = m;
  t.kinetic = 0.5 * m * v.squaredNorm();
  t.momentum = m * v;
  t.angular_momentum = x.cross(t.momentum);
  t.momentum_size = m * v.norm();
  t.angular_size = x.norm() * t.momentum_size;
  return t;
}

static Totals solid_totals(const fem::Mesh& mesh, std::size_t body) {
  const auto& n = mesh.nodes;
  const auto& e = mesh.elements;
  const std::size_t nd = mesh.body_nodes[body].first, el = mesh.body_elements[body].first;
  Totals t = core::sum(mesh.body_nodes[body].size(), Totals{},
                       [&](std::size_t k) { return moving(n.m[nd + k], n.x[nd + k], n.v[nd + k]); });
  t.internal = core::sum(mesh.body_elements[body].size(), 0.0,
                         [&](std::size_t k) { return e.alive[el + k] ? e.pt.m[el + k] * e.pt.e[el + k] : 0.0; });
  return t;
}

/// solid: [body] sums over elements, kept for those that are asleep.
static Totals totals(const Simulation& s, std::vector<std::optional<Totals>>& solid) {
  const auto& p = s.particles;
  Totals t = core::sum(p.size(), Totals{}, [&](std::size_t i) { return moving(p.pt.m[i], p.x[i], p.v[i]); });
  t.internal = core::sum(p.size(), 0.0, [&](std::size_t i) { return p.pt.m[i] * p.pt.e[i]; });
  solid.resize(s.mesh.body_nodes.size());
  for (std::size_t b = 0; b < solid.size(); ++b) {
    if (s.mesh.body_awake[b] || !solid[b]) solid[b] = solid_totals(s.mesh, b);
    t += *solid[b];
  }
  return t;
}

Totals totals(const Simulation& s) {
  std::vector<std::optional<Totals>> solid;
  return totals(s, solid);
}

double Ledger::internal() const { return now.internal - hourglass - conversion - contact_heat + eroded_booked; }

double Ledger::total() const {
  return now.kinetic + internal() + hourglass + contact + conversion + eroded_kinetic + eroded_internal;
}

/// A component of momentum that no symmetry plane gives or takes; of angular momentum likewise.
static Vec3 conserved(const core::Symmetry& symmetry, Vec3 momentum, bool angular) {
  for (int d = 0; d < 3; ++d) {
    if (!symmetry.plane[static_cast<std::size_t>(d)]) continue;
    if (!angular)
      momentum[d] = 0;
    else
      momentum[(d + 1) % 3] = momentum[(d + 2) % 3] = 0;
  }
  return momentum;
}

std::string advice(const Simulation& s) {
  if (s.spec.mode == io::Mode::fem)
    return "elements of mode \"fem\" keep what distorts them; mode \"hybrid\" converts such elements, \"erosion\" deletes them";
  return fmt::format("try a smaller run.cfl (now {:g}){}", s.spec.cfl, s.spec.mode == io::Mode::sph ? "" : " or a lower limit of distortion (convert)");
}

void account(Simulation& s) {
  Ledger& l = s.ledger;
  l.now = totals(s, l.solid);
  l.contact = s.contact.dissipated;
  l.contact_heat = s.contact.heated;
  l.wall_impulse = s.contact.wall_impulse;
  l.wall_angular_impulse = s.contact.wall_angular_impulse;
  const double scale = std::max(l.initial.kinetic, 1e-300);
  const Totals& a = l.initial;
  l.energy_error = (l.total() - (a.kinetic + a.internal)) / scale;
  l.largest_energy_error = std::max(l.largest_energy_error, std::abs(l.energy_error));
  l.mass_error = (l.now.mass + l.eroded_mass - a.mass) / a.mass;
  const Vec3 dp = l.now.momentum + l.eroded_momentum - a.momentum - l.wall_impulse;
  const Vec3 dj = l.now.angular_momentum + l.eroded_angular_momentum - a.angular_momentum - l.wall_angular_impulse;
  l.momentum_error = conserved(s.spec.symmetry, dp, false).norm() / std::max(a.momentum_size, 1e-300);
  l.angular_momentum_error = conserved(s.spec.symmetry, dj, true).norm() / std::max(a.angular_size, 1e-300);
  if (!std::isfinite(l.energy_error) || std::abs(l.energy_error) > s.spec.energy_tolerance)
    throw core::GuardError(fmt::format(
        "energy is not conserved: the ledger is off by {:.3e} of the initial kinetic energy (limit {:.1e}) at step {}, "
        "t = {:.4g} us; {}",
        l.energy_error, s.spec.energy_tolerance, s.steps, s.time * 1e6, advice(s)));
  if (l.initial.kinetic <= 0) return;
  constexpr double most = 0.02;
  const double grown = l.now.kinetic + l.eroded_kinetic - l.initial.kinetic -
                       std::max(0.0, l.initial.internal);
  if (!(grown <= most * l.initial.kinetic))
    throw core::GuardError(fmt::format(
        "kinetic energy has grown by {:.2g} of its initial value (limit {:g}) without a source, at step {}, t = {:.4g} us; {}",
        grown / l.initial.kinetic, most, s.steps, s.time * 1e6, advice(s)));
}

/// Energy that matter misses below its cold curve, summed [J].
static double cold_deficit(const Simulation& s) {
  const auto missing = [&](const core::Points& pt, std::size_t i, std::size_t body) {
    const auto& material = s.materials[static_cast<std::size_t>(s.mesh.body_material[body])];
    return pt.m[i] * std::max(0.0, eos::cold_energy(material.eos, pt.rho[i]) - pt.e[i]);
  };
  const auto& e = s.mesh.elements;
  const auto& p = s.particles;
  return core::sum(fem::block_size * s.mesh.awake_blocks.size(), 0.0,
                   [&](std::size_t k) {
                     const std::size_t el = s.mesh.awake_blocks[k / fem::block_size] * fem::block_size + k % fem::block_size;
                     return e.alive[el] ? missing(e.pt, el, e.body(el)) : 0.0;
                   }) +
         core::sum(p.size(), 0.0, [&](std::size_t i) { return missing(p.pt, i, p.body[i]); });
}

void check_tables(Simulation& s) {
  s.off_table.resize(s.materials.size());
  for (std::size_t k = 0; k < s.materials.size(); ++k) {
    const auto* table = std::get_if<eos::Sesame>(&s.materials[k].eos);
    if (!table || s.off_table[k]) continue;
    const auto search = [&](const core::Points& pt, auto&& body, std::size_t n, const char* kind, auto&& present) {
      std::size_t count = 0, first = n;
      for (std::size_t i = n; i-- > 0;)
        if (present(i) && s.mesh.body_material[body(i)] == static_cast<int>(k) && !eos::inside(*table, pt.rho[i], pt.e[i])) ++count, first = i;
      if (count == 0 || s.off_table[k]) return;
      for (std::size_t j = 0; j < s.materials.size(); ++j)  // bodies may share it
        if (s.materials[j].name == s.materials[k].name) s.off_table[j] = 1;
      s.warnings.push_back(fmt::format(
          "material '{}' has left its table ({}, number {}) at t = {:.6g} us, step {}: {} {} at rho = {:.5g} kg/m3, e = {:.5g} MJ/kg, {} of "
          "them now; the table covers {}. The run goes on with the table's edge continued; use a table of wider range, or do not "
          "rely on this matter",
          s.materials[k].name, table->file, table->number, s.time * 1e6, s.steps, kind, first, pt.rho[first], pt.e[first] * 1e-6, count,
          eos::range_text(*table, pt.rho[first])));
    };
    const auto& e = s.mesh.elements;
    search(e.pt, [&](std::size_t i) { return e.body(i); }, e.size(), "element", [&](std::size_t i) { return e.alive[i] != 0; });
    search(s.particles.pt, [&](std::size_t i) { return s.particles.body[i]; }, s.particles.size(), "particle", [](std::size_t) { return true; });
  }
}

/// What two shocks of the bodies' own speeds make where they meet head on, or one at a rigid wall: one of twice the speed. 0 where nothing
/// closes or the range of an equation of state ends before [Pa].
static double highest_explained(const Simulation& s) {
  double highest = 0;
  const auto& bodies = s.spec.bodies;
  const auto note = [&](std::size_t a, std::size_t b, double closing) {
    if (!(closing > 0)) return true;
    const double p = eos::impact_pressure(s.materials[a].eos, s.rho_0[a], s.materials[b].eos, s.rho_0[b], 2 * closing);
    highest = std::max(highest, p);
    return p > 0;
  };
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b)
      if (!note(a, b, (bodies[a].velocity - bodies[b].velocity).norm())) return 0;
    for (const auto& wall : s.walls)
      if (!note(a, a, 2 * std::max(0.0, -bodies[a].velocity.dot(wall.normal)))) return 0;
  }
  return highest;
}

void check_peaks(Simulation& s) {
  const double limit = highest_explained(s);
  if (!(limit > 0)) return;
  double most = 0;
  std::size_t n = 0;
  std::string who;
  const auto look = [&](const core::Points& pt, auto&& body, const char* kind, auto&& present) {
    for (std::size_t i = 0; i < pt.size(); ++i) {
      if (!present(i) || !(pt.p_max[i] > limit)) continue;
      ++n;
      if (pt.p_max[i] > most) most = pt.p_max[i], who = fmt::format("{} of body \"{}\"", kind, s.spec.bodies[body(i)].name);
    }
  };
  const auto& e = s.mesh.elements;
  look(e.pt, [&](std::size_t i) { return e.body(i); }, "an element", [&](std::size_t i) { return e.alive[i] != 0; });
  look(s.particles.pt, [&](std::size_t i) { return s.particles.body[i]; }, "a particle", [](std::size_t) { return true; });
  if (n == 0) return;
  s.warnings.push_back(fmt::format(
      "{} has borne {:.4g} GPa, and {} more than {:.4g} GPa, which two shocks of these bodies' speeds make where they meet head on: no shock explains "
      "that, and peak_pressure_max is no pressure to rely on; {}, or meshes that are finer or more alike where bodies meet",
      who, most * 1e-9, n == 1 ? std::string("nothing else") : fmt::format("{} points", n), limit * 1e-9, advice(s)));
}

void check_health(const Simulation& s) {
  const double kinetic = s.ledger.initial.kinetic;
  if (kinetic <= 0) return;
  const double deficit = cold_deficit(s);
  constexpr double most = 0.02;
  if (!(deficit <= most * kinetic))
    throw core::GuardError(fmt::format(
        "internal energy lies {:.3e} J below the cold curve, {:.2g} of the initial kinetic energy (limit {:g}), at step {}, "
        "t = {:.4g} us: energy is being drawn from matter that has none; {}",
        deficit, deficit / kinetic, most, s.steps, s.time * 1e6, advice(s)));
}

}  // namespace app
