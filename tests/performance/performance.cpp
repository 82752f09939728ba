// SPDX-License-Identifier: Apache-2.0
// What things cost on this machine, as a JSON file that can be compared between commits (tools/compare_performance.py):
// rates of the element kernel by material model and mesh size, of whole particle steps by size, the octree, snapshot and
// checkpoint, bytes a row, and small cases with the time of each stage. Every number is the median of repetitions.
//   ejecta_performance [--cases DIR] [--json FILE] [--threads N] [--quick]
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/bench.hpp"
#include "app/checkpoint.hpp"
#include "app/cost.hpp"
#include "app/setup.hpp"
#include "app/snapshot.hpp"
#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "io/case_file.hpp"
#include "io/material_file.hpp"
#include "io/snapshot.hpp"

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::string cases, file = "performance.json";
  int threads = 1;
  bool quick = false;
};

/// One line a number: flat keys make two files easy to compare.
static json results;
static void note(const std::string& key, double value, const char* unit, const app::Spread* s = nullptr) {
  json row{{"value", value}, {"unit", unit}};
  if (s) row["lower_quartile"] = s->low, row["upper_quartile"] = s->high, row["repetitions"] = s->repetitions;
  results[key] = row;
  fmt::print("{:<52} {:>12.4g} {}\n", key, value, unit);
  std::cout.flush();
}
static void note(const std::string& key, const app::Spread& s, const char* unit) { note(key, s.median, unit, &s); }

static material::Material with(const std::string& name, eos::Eos state, material::Strength strength) {
  auto m = app::bench_material();
  m.name = name;
  m.eos = state;
  m.strength = strength;
  material::prepare(m);
  return m;
}

static void time_models(double seconds) {
  const auto al = app::bench_material();
  const auto jc = std::get<material::JohnsonCook>(al.strength);
  const auto plastic = material::PerfectlyPlastic{jc.G, jc.A};
  std::vector<material::Material> models{al, io::find_material("Al2024-T351")};
  models[0].name = "mie_grueneisen johnson_cook", models[1].name = "mie_grueneisen johnson_cook damage spall";
  models.push_back(with("mie_grueneisen none", al.eos, material::NoStrength{}));
  models.push_back(with("mie_grueneisen perfectly_plastic", al.eos, plastic));
  for (const auto& name : io::material_names()) {
    auto m = io::find_material(name);
    if (!std::holds_alternative<material::SteinbergGuinan>(m.strength)) continue;
    m.damage.reset(), m.spall = 1e300, m.name = "steinberg_guinan of " + name;
    models.push_back(m);
    break;
  }
  for (auto m : models) note("hex 30^3 " + m.name, app::time_hex(30, m, seconds).element_steps_per_second, "element-steps/s");
}

static void time_sizes(bool quick, double seconds) {
  for (const int edge : quick ? std::vector<int>{22, 47} : std::vector<int>{10, 22, 47, 100, 160}) {
    const auto r = app::time_hex(edge, app::bench_material(), seconds);
    note(fmt::format("hex {} elements", r.elements), r.element_steps_per_second, "element-steps/s");
  }
  for (const int n : quick ? std::vector<int>{10000} : std::vector<int>{1000, 10000, 100000, 1000000}) {
    const auto r = app::time_sph(static_cast<std::size_t>(n), app::bench_material(), seconds);
    note(fmt::format("sph {} particles", r.particles), r.particle_steps_per_second, "particle-steps/s");
    note(fmt::format("sph {} pairs", r.particles), r.particle_steps_per_second.median * r.neighbours_each, "pairs of a list/s");
  }
  for (const int edge : quick ? std::vector<int>{46} : std::vector<int>{22, 46, 100, 215}) {
    const auto r = app::time_octree(app::jittered_lattice(edge), seconds);
    note(fmt::format("octree {} points, tree", r.points), r.build_ms, "ms");
    note(fmt::format("octree {} points, neighbours", r.points), r.query_ms, "ms");
  }
}

static void weigh() {
  const double before = app::resident_bytes();
  const auto mesh = app::straining_block(80, app::bench_material(), io::Mode::fem);
  app::step_elements(*mesh);
  note("bytes an element", (app::resident_bytes() - before) / static_cast<double>(mesh->n_elements_initial), "byte");
  const auto block = app::straining_block(40, app::bench_material(), io::Mode::sph);
  const double set_up = app::resident_bytes();
  app::choose_step(*block, 1);
  app::step(*block);
  note("bytes a particle (lists, actors, scratch)", (app::resident_bytes() - set_up) / static_cast<double>(block->particles.size()), "byte");
}

template <class F>
static app::Spread time_of(F&& f) {
  std::vector<double> t;
  for (int k = -1; k < 7; ++k) {
    const double start = app::work_clock();
    f();
    if (k >= 0) t.push_back(app::work_clock() - start);
  }
  return app::spread(t);
}

static void time_files() {
  const auto dir = fs::temp_directory_path() / fmt::format("ejecta_performance_{}", getpid());
  fs::create_directories(dir);
  {
    const auto s = app::straining_block(47, app::bench_material(), io::Mode::fem);
    const auto step = time_of([&] { app::step_elements(*s); });
    io::SnapshotWriter writer(dir.string());
    const auto snapshot = time_of([&] {
      ++s->steps;
      writer.append(app::take_snapshot(*s));
    });
    const auto checkpoint = time_of([&] { app::write_checkpoint(*s, (dir / "checkpoint.h5").string()); });
    note("snapshot of 104k elements, in steps of them", snapshot.median / step.median, "steps");
    note("checkpoint of 104k elements, in steps of them", checkpoint.median / step.median, "steps");
    note("checkpoint of 104k elements", static_cast<double>(fs::file_size(dir / "checkpoint.h5")) / checkpoint.median, "byte/s");
  }
  fs::remove_all(dir);
}

struct SmallCase {
  const char *name, *mode;
  int across;
  const char* end;
};

static void time_case(const std::string& folder, const SmallCase& c) {
  const auto spec = io::read_case(folder + "/" + c.name, {fmt::format("run.elements_across={}", c.across), fmt::format("run.end=\"{}\"", c.end)}, c.mode);
  const auto s = app::set_up(spec);
  app::begin(*s);
  const double start = app::work_clock();
  while (s->time < spec.end * (1 - 1e-12)) {
    app::choose_step(*s, spec.end);
    app::step(*s);
  }
  const std::string key = fmt::format("{} {} {} across to {}", c.name, c.mode, c.across, c.end);
  note(key, app::work_clock() - start, "s");
  note(key + ", steps", static_cast<double>(s->steps), "steps");
  for (std::size_t k = 0; k < app::n_stages; ++k) note(key + ", " + app::stage_names[k], s->work.seconds[k], "s");
}

int main(int argc, char** argv) {
  Options o;
  for (int a = 1; a < argc; ++a) {
    const std::string key = argv[a];
    const auto value = [&]() -> std::string { return a + 1 < argc ? argv[++a] : ""; };
    if (key == "--cases") o.cases = value();
    else if (key == "--json") o.file = value();
    else if (key == "--threads") o.threads = std::max(1, std::atoi(value().c_str()));
    else if (key == "--quick") o.quick = true;
    else {
      fmt::print("unknown option {}; see the head of performance.cpp\n", key);
      return 2;
    }
  }
  core::set_threads(o.threads);
  const double seconds = o.quick ? 0.5 : 2;
  time_models(seconds);
  time_sizes(o.quick, seconds);
  weigh();
  time_files();
  if (!o.cases.empty())
    for (const auto& c : {SmallCase{"thin_plate", "hybrid", 8, "6 us"}, {"thin_plate", "erosion", 8, "6 us"}, {"semi_infinite", "hybrid", 6, "4 us"},
                          {"flyer_plate", "fem", 8, "0.4 us"}, {"taylor_copper", "fem", 8, "20 us"}})
      time_case(o.cases, c);
  const json all{{"machine", {{"cpu", app::processor_name()}, {"isa", core::isa_name()}, {"threads", o.threads}}}, {"results", results}};
  std::ofstream(o.file) << all.dump(1) << "\n";
}
