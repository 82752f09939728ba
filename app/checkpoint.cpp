// SPDX-License-Identifier: Apache-2.0
#include "app/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <sstream>

#include "app/summary.hpp"
#include "core/error.hpp"
#include "io/archive.hpp"
#include "io/case_file.hpp"

namespace app {

template <class Archive>
static void each_point_field(Archive& a, const std::string& name, core::Points& pt) {
  int k = 0;
  pt.each_field([&](std::vector<double>& field) { a(fmt::format("{}/{}", name, k++), field); });
}

/// Of blocks that are or have been awake, many chunks an array.
template <class Archive>
static void force_state(Archive& a, fem::Mesh& mesh) {
  constexpr std::size_t together = 64;
  auto& chunks = mesh.elements.corner_force;
  fem::make_room_for_forces(mesh);
  for (std::size_t first = 0; first < chunks.size(); first += together) {
    const std::span some = std::span(chunks).subspan(first, std::min(together, chunks.size() - first));
    std::vector<double> forces;
    forces.reserve(some.size() * fem::numbers_in_chunk);
    for (const auto& chunk : some) forces.insert(forces.end(), chunk.begin(), chunk.end());
    a(fmt::format("elements/corner_force/{}", first), forces);
    auto from = forces.begin();
    for (auto& chunk : some) {
      const auto to = from + static_cast<std::ptrdiff_t>(chunk.size());
      std::copy(from, to, chunk.begin());
      from = to;
    }
  }
}

template <class Archive>
static void mesh_state(Archive& a, fem::Mesh& mesh) {
  auto& n = mesh.nodes;
  a("nodes/x", n.x), a("nodes/v", n.v), a("nodes/v_mean", n.v_mean), a("nodes/m", n.m), a("nodes/awake", n.awake);
  auto& e = mesh.elements;
  each_point_field(a, "elements/points", e.pt);
  a("elements/deformation", e.deformation);
  a("elements/dt", e.dt), a("elements/dt_0", e.dt_0);
  a("elements/alive", e.alive);
  if (!e.hourglass.empty()) a("elements/hourglass", e.hourglass);
  if (!e.booked.empty()) a("elements/booked", e.booked);
  a("mesh/awake_blocks", mesh.awake_blocks), a("mesh/block_awake", mesh.block_awake);
  a("mesh/body_awake", mesh.body_awake);
  force_state(a, mesh);
  a("mesh/n_alive", mesh.n_alive), a("mesh/n_removed", mesh.n_removed);
}

template <class Archive>
static void particle_state(Archive& a, sph::Particles& p) {
  each_point_field(a, "particles/points", p.pt);
  int k = 0;
  p.each_array([&](auto& array) { a(fmt::format("particles/{}", k++), array); });
}

template <class Archive>
static void totals_state(Archive& a, const std::string& name, Totals& t) {
  a(name + "/mass", t.mass), a(name + "/kinetic", t.kinetic), a(name + "/internal", t.internal);
  a(name + "/momentum", t.momentum), a(name + "/angular_momentum", t.angular_momentum);
  a(name + "/momentum_size", t.momentum_size), a(name + "/angular_size", t.angular_size);
}

template <class Archive>
static void frozen_state(Archive& a, Simulation& s) {
  std::vector<std::string> keys, units;
  std::vector<double> values;
  for (const auto& v : s.frozen) keys.push_back(v.key), units.push_back(v.unit), values.push_back(v.value);
  a("frozen/keys", keys), a("frozen/units", units), a("frozen/values", values), a("frozen/plates", s.cloud_frozen);
  s.frozen.clear();
  for (std::size_t i = 0; i < keys.size(); ++i) s.frozen.push_back({keys[i], values[i], units[i]});
}

template <class Archive>
static void book_state(Archive& a, Simulation& s) {
  Ledger& l = s.ledger;
  totals_state(a, "ledger/initial", l.initial);
  a("ledger/hourglass", l.hourglass), a("ledger/conversion", l.conversion);
  a("ledger/eroded_kinetic", l.eroded_kinetic), a("ledger/eroded_internal", l.eroded_internal);
  a("ledger/eroded_booked", l.eroded_booked);
  a("ledger/eroded_mass", l.eroded_mass), a("ledger/eroded_momentum", l.eroded_momentum);
  a("ledger/eroded_angular_momentum", l.eroded_angular_momentum);
  a("ledger/largest_energy_error", l.largest_energy_error), a("ledger/added_inertia", l.added_inertia);
  auto& c = s.contact;
  a("contact/dissipated", c.dissipated), a("contact/heated", c.heated), a("contact/wall_impulse", c.wall_impulse);
  a("contact/wall_angular_impulse", c.wall_angular_impulse), a("contact/leaks", c.leaks);
  a("contact/step", c.step);
  a("run/time", s.time), a("run/dt", s.dt), a("run/dt_old", s.dt_old), a("run/steps", s.steps);
  a("run/n_elements_initial", s.n_elements_initial), a("run/n_converted", s.n_converted), a("run/n_eroded", s.n_eroded);
  a("run/peak_removed", s.peak_removed), a("run/peak_removed_axis", s.peak_removed_axis);
  a("run/peak_impact", s.peak_impact);
  a("run/taken_along", s.taken_along);
  frozen_state(a, s);
  auto& w = s.work;
  a("work/element_updates", w.element_updates), a("work/element_updates_asleep", w.element_updates_asleep);
  a("work/element_updates_slowed", w.element_updates_slowed);
  a("work/particle_updates", w.particle_updates), a("work/particle_updates_asleep", w.particle_updates_asleep);
  a("work/pair_updates", w.pair_updates), a("work/seconds", w.seconds);
  a("work/neighbour_builds", s.hood.builds), a("work/contact_searches", c.searches);
  a("run/warnings", s.warnings), a("run/off_table", s.off_table);
}

template <class Archive>
static void state(Archive& a, Simulation& s) {
  mesh_state(a, s.mesh);
  particle_state(a, s.particles);
  book_state(a, s);
}

/// With the processor time of this process among that of those before it.
template <class Archive>
static void whole_state(Archive& a, Simulation& s) {
  a("run/scene", io::write_scene(s.spec));
  state(a, s);
  a("work/cpu_seconds", s.work.cpu_seconds_before + cpu_seconds());
}

void write_checkpoint(Simulation& s, const std::string& path) {
  io::ArchiveWriter a(path);
  whole_state(a, s);
  a.commit();
}

io::ArchiveCopy copy_state(Simulation& s) {
  io::ArchiveCopy a;
  whole_state(a, s);
  return a;
}

double state_bytes(Simulation& s) {
  io::ArchiveSize a;
  state(a, s);
  return a.bytes;
}

/// The next line that is not about where numbers come from; at the end false, and nothing in `line`.
static bool next_line(std::istream& in, std::string& line) {
  while (std::getline(in, line))
    if (!line.starts_with("source = ")) return true;
  line.clear();
  return false;
}

/// Throws where the case beside a checkpoint says otherwise of its matter than the case of the run did.
static void check_scene(const std::string& path, const std::string& stored, const std::string& now) {
  std::istringstream was(stored), is(now);
  std::string part = "[run]", before, after;  // what the lines are of
  while (true) {
    const bool more = next_line(was, before), more_now = next_line(is, after);
    if (!more && !more_now) return;
    if (before != after)
      throw core::CaseError(fmt::format(
          "{}: is of a run whose case had, in {}, the line `{}` where case.toml beside it has `{}`; mode, bodies, walls and materials of a run that has begun "
          "stay as they are: put it back", path, part, before, after));
    if (before.starts_with("name =") || before.starts_with("[")) part = before;
  }
}

void read_checkpoint(Simulation& s, const std::string& path) {
  io::ArchiveReader a(path);
  check_scene(path, a.get<std::string>("run/scene"), io::write_scene(s.spec));
  const auto stored = a.get<std::size_t>("run/n_elements_initial");
  if (stored != s.n_elements_initial)
    throw core::CaseError(fmt::format("{}: is of a run of {} elements, but the case beside it builds {}: it belongs to another case",
                                      path, stored, s.n_elements_initial));
  const auto own_warnings = s.warnings;
  if (a.has("elements/hourglass") == s.mesh.elements.hourglass.empty())
    throw core::CaseError(path + ": is of a run with another form of hourglass control; put run.hourglass of the case beside it back");
  state(a, s);
  a("work/cpu_seconds", s.work.cpu_seconds_before);
  for (const auto& w : own_warnings)
    if (std::find(s.warnings.begin(), s.warnings.end(), w) == s.warnings.end()) s.warnings.push_back(w);
  s.bond.ring.clear();
  s.hood.valid = false;
  coupling::invalidate(s.contact);
}

}  // namespace app
