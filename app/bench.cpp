// SPDX-License-Identifier: Apache-2.0
#include "app/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "app/setup.hpp"
#include "core/error.hpp"
#include "core/isa.hpp"
#include "core/octree.hpp"
#include "core/parallel.hpp"
#include "fem/elements.hpp"
#include "io/atomic_file.hpp"
#include "io/material_file.hpp"

namespace app {

using core::Vec3;

Spread spread(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double part) { return samples[static_cast<std::size_t>(std::lround(part * static_cast<double>(samples.size() - 1)))]; };
  return {at(0.5), at(0.25), at(0.75), static_cast<int>(samples.size())};
}

double work_clock() {
  if (core::threads() == 1) {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Seconds of each repetition of `run` after `prepare`, of which only `run` counts: as many as fit into `seconds`, at least
/// five. A first one warms caches and page tables and is not counted.
template <class Prepare, class Run>
static std::vector<double> repeat(double seconds, Prepare&& prepare, Run&& run) {
  constexpr std::size_t fewest = 5, most = 41;
  std::vector<double> times;
  double spent = 0;
  for (bool warm = false; times.size() < fewest || (spent < seconds && times.size() < most); warm = true) {
    prepare();
    const double start = work_clock();
    run();
    const double t = work_clock() - start;
    spent += t;
    if (warm) times.push_back(t);
  }
  return times;
}

// ------------------------------------------------------------------------------------------------ what is timed

/// A flow with strains of `rate` [1/s] in shear, squeeze and stretch everywhere in a cube of the given length about 0.
static Vec3 stirring(const Vec3& x, double length, double rate) {
  const double k = core::pi / length, u = rate / k;
  const Vec3 a = k * x;
  return {u * std::sin(a[0]) * std::cos(a[1]), -0.7 * u * std::cos(a[0]) * std::sin(a[1]) + 0.3 * u * std::sin(a[2]),
          -0.3 * u * std::sin(a[2]) + 0.3 * u * std::cos(a[0])};
}

std::unique_ptr<Simulation> straining_block(int edge, const material::Material& material, io::Mode mode) {
  constexpr double size = 1e-4;
  const double length = edge * size;
  io::Case spec;
  spec.title = "straining block";
  spec.file = "bench";
  spec.mode = mode;
  spec.end = 1;
  spec.sleep = -1;
  spec.symmetry_auto = false;
  spec.contact = false;
  spec.elements_across = edge;
  io::BodySpec block;
  block.name = "block";
  block.shape = io::Shape::box;
  block.size = Vec3::Constant(length);
  block.element_size = size;
  block.fine_radius = length;
  block.elements_through = edge;
  block.material = material.name;
  spec.bodies.push_back(block);
  spec.materials[material.name] = material;
  auto s = set_up(spec);
  const double dt = spec.cfl * size / s->mesh.elements.pt.c[0];
  auto& n = s->mesh.nodes;
  for (std::size_t nd = 0; nd < n.size(); ++nd) n.v[nd] = n.v_mean[nd] = stirring(n.x[nd], length, strain_per_step / dt);
  begin(*s);
  return s;
}

material::Material bench_material() {
  auto m = io::find_material("Al2024-T351");
  m.damage.reset();
  m.spall = 1e300;
  return m;
}

void step_elements(Simulation& s) {
  s.dt = s.spec.cfl * fem::stable_step(s.mesh, 0).value;
  const fem::StepTimes times{0.5 * (s.dt_old + s.dt), s.dt};
  fem::kick_nodes(s.mesh, times.kick);
  fem::drift_nodes(s.mesh, s.dt);
  fem::update_awake_elements(s.mesh, s.materials, s.element_settings, times);
  s.dt_old = s.dt;
}

static void whole_step(Simulation& s) {
  choose_step(s, s.spec.end);
  step(s);
}

/// Steps in one repetition: enough for the clock, few enough that the matter stays solid.
static int steps_for(double seconds_a_step) {
  constexpr double shortest = 0.05;
  constexpr int most = 60;
  return std::clamp(static_cast<int>(std::ceil(shortest / std::max(seconds_a_step, 1e-9))), 3, most);
}

template <class Step>
static std::vector<double> seconds_a_step(Simulation& warm, double seconds, Step&& one_step) {
  constexpr int until_plastic = 8;
  for (int k = 0; k < until_plastic; ++k) one_step(warm);
  Simulation s = warm;
  const double start = work_clock();
  one_step(s);
  const int steps = steps_for(work_clock() - start);
  auto times = repeat(seconds, [&] { s = warm; },
                      [&] {
                        for (int k = 0; k < steps; ++k) one_step(s);
                      });
  for (double& t : times) t /= steps;
  return times;
}

static Spread rates(double work, const std::vector<double>& seconds) {
  std::vector<double> r;
  for (const double t : seconds) r.push_back(work / t);
  return spread(r);
}

HexRate time_hex(int edge, const material::Material& material, double seconds) {
  const auto s = straining_block(edge, material, io::Mode::fem);
  HexRate r;
  r.elements = s->mesh.n_alive;
  r.element_steps_per_second = rates(static_cast<double>(r.elements), seconds_a_step(*s, seconds, step_elements));
  return r;
}

SphRate time_sph(std::size_t n, const material::Material& material, double seconds) {
  const auto s = straining_block(std::max(8, static_cast<int>(std::lround(std::cbrt(n)))), material, io::Mode::sph);
  SphRate r;
  r.particles = s->particles.size();
  std::uint64_t steps = 0, builds = 0;
  r.particle_steps_per_second = rates(static_cast<double>(r.particles), seconds_a_step(*s, seconds, [&](Simulation& a) {
                                        const auto before = a.hood.builds;
                                        whole_step(a);
                                        ++steps;
                                        builds += a.hood.builds - before;
                                      }));
  r.neighbours_each = static_cast<double>(s->hood.pairs.list.size()) / static_cast<double>(s->hood.actors.size());
  r.steps_between_lists = static_cast<double>(steps) / static_cast<double>(std::max<std::uint64_t>(builds, 1));
  return r;
}

// ------------------------------------------------------------------------------------------------ octree

Cloud jittered_lattice(int edge) {
  std::mt19937 random(42);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  Cloud c{fmt::format("lattice {}^3", edge), {}, {}};
  for (int k = 0; k < edge; ++k)
    for (int j = 0; j < edge; ++j)
      for (int i = 0; i < edge; ++i) c.x.push_back(Vec3(i + jitter(random), j + jitter(random), k + jitter(random)));
  constexpr double wanted = 61;
  c.radius.assign(c.x.size(), std::cbrt(wanted * 3 / (4 * core::pi)));
  return c;
}

Cloud read_cloud(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (!file || error) throw core::CaseError(fmt::format("{}: cannot be read; --points wants a file of float32 x y z radius", path));
  float p[4];
  if (bytes == 0 || bytes % sizeof p != 0)
    throw core::CaseError(fmt::format("{}: holds {} bytes, which is no number of points of float32 x y z radius (16 bytes each)", path, bytes));
  Cloud c{std::filesystem::path(path).filename().string(), {}, {}};
  while (file.read(reinterpret_cast<char*>(p), sizeof p)) {
    if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]) && std::isfinite(p[3]) && p[3] >= 0))
      throw core::CaseError(fmt::format("{}: point {} is ({}, {}, {}) with radius {}: coordinates must be finite and radii >= 0", path,
                                        c.x.size(), p[0], p[1], p[2], p[3]));
    c.x.push_back(Vec3(p[0], p[1], p[2]));
    c.radius.push_back(p[3]);
  }
  return c;
}

OctreeTime time_octree(const Cloud& cloud, double seconds) {
  constexpr double moved = 0.01;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> shift(-1, 1);
  std::vector<Vec3> x = cloud.x;
  core::Octree tree;
  core::Neighbours found;
  OctreeTime r;
  r.points = x.size();
  tree.build(x);
  tree.neighbours_along_curve(cloud.radius, false, found);
  r.neighbours = found.list.size();
  std::vector<double> build, query;
  const auto both = repeat(
      seconds,
      [&] {
        for (std::size_t i = 0; i < x.size(); ++i)
          for (int d = 0; d < 3; ++d) x[i][d] = cloud.x[i][d] + moved * cloud.radius[i] * shift(random);
      },
      [&] {
        const double start = work_clock();
        tree.build(x);
        const double built = work_clock();
        tree.neighbours_along_curve(cloud.radius, false, found);
        build.push_back(1e3 * (built - start));
        query.push_back(1e3 * (work_clock() - built));
      });
  std::vector<double> ms;
  for (const double t : both) ms.push_back(1e3 * t);
  build.erase(build.begin()), query.erase(query.begin());  // the one that warmed
  r.build_ms = spread(build), r.query_ms = spread(query), r.both_ms = spread(ms);
  return r;
}

// ------------------------------------------------------------------------------------------------ the command

std::string processor_name() {
  std::ifstream f("/proc/cpuinfo");
  for (std::string line; std::getline(f, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(std::min(line.find(':') + 2, line.size()));
  return "unknown";
}

static nlohmann::json to_json(const Spread& s) {
  return {{"median", s.median}, {"lower_quartile", s.low}, {"upper_quartile", s.high}, {"repetitions", s.repetitions}};
}

static void print_row(const std::string& what, const Spread& s, double scale, const char* unit) {
  fmt::print("{:<46} {:>10.3f} {:>10.3f} {:>10.3f} {:>5}  {}\n", what, s.median * scale, s.low * scale, s.high * scale, s.repetitions, unit);
}

static void bench_hex(const BenchRequest& q, const material::Material& material, nlohmann::json& j) {
  const int edge = q.size > 0 ? q.size : 60;
  const HexRate r = time_hex(edge, material);
  print_row(fmt::format("hex: {0} elements ({1}^3)", r.elements, edge), r.element_steps_per_second, 1e-6, "million element-steps/s");
  j["element_steps_per_second"] = r.element_steps_per_second.median;
  j["hex"] = {{"elements", r.elements}, {"element_steps_per_second", to_json(r.element_steps_per_second)}};
}

static void bench_sph(const BenchRequest& q, const material::Material& material, nlohmann::json& j) {
  const double edge = q.size;
  const auto n = static_cast<std::size_t>(q.size <= 0 ? 50000 : q.kernel == "all" ? edge * edge * edge : edge);
  const SphRate r = time_sph(n, material);
  print_row(fmt::format("sph: {} particles, {:.1f} in each list", r.particles, r.neighbours_each), r.particle_steps_per_second, 1e-6,
            "million particle-steps/s");
  j["particle_steps_per_second"] = r.particle_steps_per_second.median;
  j["sph"] = {{"particles", r.particles},
              {"neighbours_each", r.neighbours_each},
              {"steps_between_lists", r.steps_between_lists},
              {"particle_steps_per_second", to_json(r.particle_steps_per_second)}};
}

/// given: the points asked for; none for the lattice.
static void bench_octree(const BenchRequest& q, const Cloud& given, nlohmann::json& j) {
  const int edge = q.size <= 0 ? 100 : q.kernel == "all" ? q.size : std::max(2, static_cast<int>(std::lround(std::cbrt(q.size))));
  const Cloud cloud = given.x.empty() ? jittered_lattice(edge) : given;
  const OctreeTime r = time_octree(cloud);
  const double each = static_cast<double>(r.neighbours) / static_cast<double>(r.points);
  print_row(fmt::format("octree: {} points, {:.1f} neighbours each", r.points, each), r.both_ms, 1, "ms");
  print_row("  of that to build the tree", r.build_ms, 1, "ms");
  print_row("  to find all neighbours", r.query_ms, 1, "ms");
  j["octree_ms"] = r.both_ms.median;
  j["neighbours"] = r.neighbours;
  j["octree"] = {{"cloud", cloud.name},        {"points", r.points},           {"both_ms", to_json(r.both_ms)},
                 {"build_ms", to_json(r.build_ms)}, {"query_ms", to_json(r.query_ms)}};
}

void bench(const BenchRequest& q) {
  const bool all = q.kernel == "all";
  if (!q.points.empty() && !all && q.kernel != "octree")
    throw core::CaseError(fmt::format("--points {}: only octree takes points; \"{}\" does not", q.points, q.kernel));
  if (!q.json.empty()) io::require_place("--json", q.json);
  const Cloud cloud = q.points.empty() ? Cloud{} : read_cloud(q.points);
  const auto material = bench_material();
  nlohmann::json j;
  j["version"] = EJECTA_VERSION;
  j["machine"] = {{"cpu", processor_name()}, {"isa", core::isa_name()}, {"threads", core::threads()}};
  j["material"] = material.name;
  fmt::print("{}, kernels for {}, {} thread{}; {}\n", processor_name(), core::isa_name(), core::threads(), core::threads() == 1 ? "" : "s",
             core::threads() == 1 ? "processor time" : "time on the wall");
  fmt::print("{:<46} {:>10} {:>10} {:>10} {:>5}\n", "kernel", "median", "lower 1/4", "upper 1/4", "reps");
  if (all || q.kernel == "hex") bench_hex(q, material, j);
  if (all || q.kernel == "sph") bench_sph(q, material, j);
  if (all || q.kernel == "octree") bench_octree(q, cloud, j);
  if (!q.json.empty()) io::write_atomically(q.json, j.dump(2) + "\n");
}

}  // namespace app
