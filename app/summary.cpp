// SPDX-License-Identifier: Apache-2.0
#include "app/summary.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "io/atomic_file.hpp"
#include "io/case_file.hpp"

namespace app {

using Json = nlohmann::ordered_json;

double cpu_seconds() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(u.ru_utime) + seconds(u.ru_stime);
}

double peak_memory() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return 1024.0 * static_cast<double>(u.ru_maxrss);
}

static const io::Case::Reference* reference(const io::Case& spec, const std::string& key) {
  const auto found = spec.reference.find(key);
  return found == spec.reference.end() ? nullptr : &found->second;
}

static Json measurements(const io::Case& spec, const measure::Result& result) {
  Json m = Json::object();
  for (const auto& v : result.values) {
    Json& entry = m[v.key];
    if (v.unit == "bool")
      entry["value"] = v.value != 0;
    else
      entry["value"] = v.value;
    entry["unit"] = v.unit == "bool" ? "" : v.unit;
    if (const auto* r = reference(spec, v.key)) {
      if (v.unit == "bool")
        entry["reference"] = r->value != 0;
      else
        entry["reference"] = r->value;
      if (r->value != 0 && v.unit != "bool") entry["relative_error"] = (v.value - r->value) / std::abs(r->value);
      entry["source"] = r->source;
    }
  }
  return m;
}

static Json conservation(const Simulation& s) {
  const Ledger& l = s.ledger;
  return {{"initial_kinetic", l.initial.kinetic},
          {"mass_error", l.mass_error},
          {"momentum_error", l.momentum_error},
          {"angular_momentum_error", l.angular_momentum_error},
          {"energy_error", l.energy_error},
          {"largest_energy_error", l.largest_energy_error},
          {"added_inertia", l.added_inertia / std::max(l.initial.kinetic, 1e-300)},
          {"eroded_mass", l.eroded_mass},
          {"ledger",
           {{"kinetic", l.now.kinetic},
            {"internal", l.internal()},
            {"hourglass", l.hourglass},
            {"contact", l.contact},
            {"conversion", l.conversion},
            {"eroded_kinetic", l.eroded_kinetic},
            {"eroded_internal", l.eroded_internal}}}};
}

/// What the scene did not need, and so did not pay for.
static Json not_needed(const Simulation& s, const RunInfo& info) {
  Json r = Json::array();
  if (info.particles == 0) r.push_back("particles: none were made, no neighbour search ran");
  if (s.contact.searches == 0) r.push_back("contact: nothing came near anything, no search ran");
  const int copies = s.spec.symmetry.copies();
  if (copies > 1) r.push_back(fmt::format("symmetry: 1/{} of the scene was computed", copies));
  const double all = static_cast<double>(s.work.element_updates + s.work.element_updates_asleep);
  if (s.work.element_updates_asleep > 0)
    r.push_back(fmt::format("sleep: {:.0f} % of the element updates were of elements at rest and were skipped",
                            100 * static_cast<double>(s.work.element_updates_asleep) / all));
  return r;
}

void write_summary(const std::string& dir, const Simulation& s, const measure::Result& result, const RunInfo& info) {
  Json stages = Json::object();
  for (std::size_t k = 0; k < n_stages; ++k) stages[stage_names[k]] = s.work.seconds[k];
  const Json j = {
      {"completed", info.completed},
      {"stop_reason", info.stop_reason},
      {"title", s.spec.title},
      {"mode", io::to_string(s.spec.mode)},
      {"fidelity", s.spec.fidelity},
      {"elements_across", s.spec.elements_across},
      {"time", s.time},
      {"steps", s.steps},
      {"threads", core::threads()},
      {"isa", core::isa_name()},
      {"wall_seconds", info.wall_seconds},
      {"cpu_seconds", info.cpu_seconds},
      {"peak_memory_bytes", peak_memory()},
      {"elements",
       {{"initial", s.n_elements_initial}, {"alive", info.elements}, {"converted", s.n_converted}, {"eroded", s.n_eroded}}},
      {"particles", {{"created", info.particles}, {"final", info.particles}}},
      {"work",
       {{"element_updates", s.work.element_updates},
        {"element_updates_asleep", s.work.element_updates_asleep},
        {"element_updates_slowed", s.work.element_updates_slowed},
        {"particle_updates", s.work.particle_updates},
        {"particle_updates_asleep", s.work.particle_updates_asleep},
        {"pair_updates", s.work.pair_updates},
        {"neighbour_builds", s.hood.builds},
        {"contact_searches", s.contact.searches},
        {"stage_seconds", stages}}},
      {"not_needed", not_needed(s, info)},
      {"warnings", s.warnings},
      {"contact", {{"leaks", s.contact.leaks}}},
      {"conservation", conservation(s)},
      {"measurements", measurements(s.spec, result)}};
  io::write_atomically(dir + "/summary.json", j.dump(2) + "\n");
}

bool summary_is_complete(const std::string& dir) {
  std::ifstream f(dir + "/summary.json");
  const Json j = Json::parse(f, nullptr, false);
  return j.is_object() && j.value("completed", Json()) == true;
}

void rewrite_measurements(const std::string& dir, const io::Case& spec, const measure::Result& result) {
  const std::string path = dir + "/summary.json";
  std::ifstream f(path);
  Json j = Json::parse(f, nullptr, false);
  if (!j.is_object()) throw core::CaseError(fmt::format("{}: is not there, or no summary of a run; finish the run with: ejecta resume {}", path, dir));
  j["measurements"] = measurements(spec, result);
  io::write_atomically(path, j.dump(2) + "\n");
}

void write_fragments(const std::string& dir, const measure::Result& result) {
  std::string text = "mass_kg,size_m,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,temperature_K,projectile_fraction,points,lone,failed_fraction,links_cut,cut_by_reach\n";
  for (const auto& f : result.fragments)
    text += fmt::format("{:.9e},{:.6e},{:.6e},{:.6e},{:.6e},{:.9e},{:.9e},{:.9e},{:.1f},{:.6f},{},{},{:.4f},{},{:.4f}\n", f.mass, f.size,
                        f.x[0], f.x[1], f.x[2], f.v[0], f.v[1], f.v[2], f.temperature, f.projectile_fraction, f.n_points,
                        f.lone ? 1 : 0, f.failed_fraction, f.links_cut, f.cut_by_reach);
  io::write_atomically(dir + "/fragments.csv", text);
}

std::string readable(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.4g} mm", value * 1e3);
  if (unit == "rad") return fmt::format("{:.2f} deg", value * 180 / core::pi);
  if (unit == "m/s") return fmt::format("{:.3f} km/s", value * 1e-3);
  if (unit == "Pa") return fmt::format("{:.4g} GPa", value * 1e-9);
  if (unit == "kg") return fmt::format("{:.4g} mg", value * 1e6);
  if (unit == "bool") return value != 0 ? "yes" : "no";
  return fmt::format("{:.4g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string measurement_table(const io::Case& spec, const measure::Result& result) {
  std::string text = fmt::format("{:<42} {:>14} {:>14} {:>8}\n", "measurement", "computed", "reference", "error");
  for (const auto& v : result.values) {
    const auto* r = reference(spec, v.key);
    text += fmt::format("{:<42} {:>14} {:>14} {:>8}\n", v.key, readable(v.value, v.unit), r ? readable(r->value, v.unit) : "",
                        r && r->value != 0 && v.unit != "bool"
                            ? fmt::format("{:+.1f} %", 100 * (v.value - r->value) / std::abs(r->value))
                            : "");
  }
  return text;
}

std::string ledger_table(const Simulation& s) {
  const Ledger& l = s.ledger;
  const double scale = l.initial.kinetic > 0 ? 100 / l.initial.kinetic : 0;
  std::string text = "energy, % of the initial kinetic energy:";
  const auto add = [&](const char* name, double value) { text += fmt::format("  {} {:.3f}", name, value * scale); };
  add("kinetic", l.now.kinetic), add("internal", l.internal()), add("hourglass", l.hourglass), add("contact", l.contact);
  add("conversion", l.conversion), add("eroded kinetic", l.eroded_kinetic), add("eroded internal", l.eroded_internal);
  return text + fmt::format("\nerrors: energy {:.1e}  mass {:.1e}  momentum {:.1e}  angular momentum {:.1e}  leaks {}\n",
                            l.energy_error, l.mass_error, l.momentum_error, l.angular_momentum_error, s.contact.leaks);
}

}  // namespace app
