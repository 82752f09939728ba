// SPDX-License-Identifier: Apache-2.0
#include "app/cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <chrono>
#include <fstream>
#include <malloc.h>
#include <memory>
#include <numeric>
#include <unistd.h>

#include "app/bench.hpp"
#include "app/body_mesh.hpp"
#include "app/setup.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace app {

constexpr double most_trend = 1.0;  ///< powers of h; more is the scatter of two coarse pilots and no trend

/// What a run holds beyond the state as built, for each element: contact's lists; and where a cloud is
/// measured on its way to the next plate, a copy of each element and particle, and what each symmetry copy takes.
constexpr double more_bytes_per_element = 45, measured_bytes_per_row = 300, measured_bytes_per_copy = 90;
constexpr double small_arrays = 15e6;  ///< of any run: buffers, grids of measurements

/// The first pilot may take this many budgets, for one that ends says more than any other.
constexpr double most_first = 2;

enum Part { elements, particles, contact };
constexpr std::size_t n_parts = 3;

static Part part_of(Stage stage) {
  switch (stage) {
    case Stage::search:
    case Stage::pair_forces:
    case Stage::pair_work:
    case Stage::particles: return particles;
    case Stage::contact: return contact;
    default: return elements;
  }
}

/// What one resolution has to work on.
struct Size {
  double across = 0;               ///< elements across the projectile
  double n_elements = 0;
  double finest = 1e300;           ///< edge of the finest mesh: in mode sph that of a thin plate, which no pilot has coarser [m]
  std::vector<double> smallest;    ///< [body] volume of the smallest element as built, in mode sph of the mean one [m3]
};

/// What a run has taken up to a time.
struct Mark {
  double time = 0;                     ///< [s]
  double steps = 0;
  std::array<double, n_parts> part{};  ///< seconds
  std::vector<double> converted;       ///< [body] elements that became particles
};

struct Pilot {
  Size size;
  double reached = 0;              ///< part of the run [-]
  double seconds = 0;              ///< that it took
  std::vector<Mark> marks;         ///< every hundredth of the run, as far as it got
  Mark whole;                      ///< at its end, what is missing extrapolated
  double bytes_beside = 0;         ///< most that it held at any of them beyond what it was built with and corner forces: particles, those beside them, contact
};

static Size size_of(const Simulation& s) {
  Size r;
  r.across = s.spec.elements_across;
  r.n_elements = static_cast<double>(s.n_elements_initial);
  for (const auto& b : place_bodies(s.spec)) r.finest = std::min(r.finest, b.element_size);
  const auto& e = s.mesh.elements;
  for (const auto range : s.mesh.body_elements) {
    double least = 1e300;
    for (std::size_t el = range.first; el < range.last; ++el) least = std::min(least, e.volume_0[el]);
    r.smallest.push_back(least);
  }
  // in mode sph no element is left: the mean of those that the particles were, so that numbers of particles go over as they are
  std::vector<double> volume(r.smallest.size(), 0), n(r.smallest.size(), 0);
  for (std::size_t i = 0; i < s.particles.size(); ++i) {
    const auto b = static_cast<std::size_t>(s.particles.body[i]);
    volume[b] += s.particles.pt.m[i] / s.rho_0[b];
    n[b] += std::pow(s.spec.particles_per_edge, -3);
  }
  for (std::size_t b = 0; b < n.size(); ++b)
    if (n[b] > 0) r.smallest[b] = volume[b] / n[b];
  return r;
}

static std::array<double, n_parts> parts(const Work& work) {
  std::array<double, n_parts> r{};
  for (std::size_t k = 0; k < n_stages; ++k) r[part_of(static_cast<Stage>(k))] += work.seconds[k];
  return r;
}

/// What converted in the pilot, in elements of another mesh.
static double matter(const Pilot& p, const Size& at) {
  double n = 0;
  for (std::size_t b = 0; b < p.whole.converted.size(); ++b) n += p.whole.converted[b] * p.size.smallest[b] / at.smallest[b];
  return n;
}

/// Factors by which the parts grow from the pilot to another mesh.
static std::array<double, n_parts> growth(const Pilot& p, const Size& to) {
  const double steps = p.size.finest / to.finest;
  const double n = to.n_elements / p.size.n_elements;
  const double now = matter(p, p.size), m = now > 0 ? matter(p, to) / now : n;
  return {n * steps, m * steps, std::sqrt(n * m) * steps};
}

/// Factor by which what is held beside elements grows to another mesh, and to the run's end: particles by the number of elements that convert, elements at
/// their seam, which take up more, by its two-thirds power where that is smooth.
static double growth_beside(const Pilot& p, const Size& to) {
  const double now = matter(p, p.size), reached = std::accumulate(p.marks.back().converted.begin(), p.marks.back().converted.end(), 0.0);
  if (!(reached > 0)) return to.n_elements / p.size.n_elements;
  constexpr double power = 0.9;
  return std::pow(matter(p, to) / now, power) * now / reached;
}

/// p.whole is what the pilot took as far as it got. One that did not get to the end goes on as the one before it did, by as much more as it took up to there; the first of
/// all as in the last third of the time it covered.
static void extrapolate(Pilot& p, const Pilot* before, double end) {
  const Mark last = p.whole;
  const auto mark_at = [](const Pilot& of, double time) {
    return *std::find_if(of.marks.rbegin(), of.marks.rend() - 1, [&](const Mark& m) { return m.time <= time; });
  };
  if (!before) {
    const Mark third = mark_at(p, last.time * 2 / 3);
    const double left = (end - last.time) / std::max(last.time - third.time, 1e-300);
    p.whole.steps += left * (last.steps - third.steps);
    for (std::size_t k = 0; k < n_parts; ++k) p.whole.part[k] += left * (last.part[k] - third.part[k]);
    for (std::size_t b = 0; b < last.converted.size(); ++b) p.whole.converted[b] += left * (last.converted[b] - third.converted[b]);
    return;
  }
  const Mark then = mark_at(*before, last.time);
  const auto rest = [](double now, double was, double whole, double expected) { return (whole - was) * (was > 0 ? now / was : expected); };
  for (std::size_t b = 0; b < last.converted.size(); ++b)
    p.whole.converted[b] += rest(last.converted[b], then.converted[b], before->whole.converted[b], before->size.smallest[b] / p.size.smallest[b]);
  const auto expected = growth(*before, p.size);
  p.whole.steps += rest(last.steps, then.steps, before->whole.steps, before->size.finest / p.size.finest);
  for (std::size_t k = 0; k < n_parts; ++k) p.whole.part[k] += rest(last.part[k], then.part[k], before->whole.part[k], expected[k]);
}

/// Of corner forces that there is no room for yet.
static double bytes_to_wake(const fem::Elements& e) {
  const auto asleep = std::count_if(e.corner_force.begin(), e.corner_force.end(), [](const auto& chunk) { return chunk.empty(); });
  return static_cast<double>(asleep) * fem::blocks_in_chunk * fem::block_size * 24 * sizeof(double);
}

/// What the process has asked for and not given back [byte].
static double allocated_bytes() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

/// The case on a coarser mesh, to its end or for at most `budget` seconds.
static Pilot fly(const io::Case& given, int across, double budget, const Pilot* before) {
  io::Case spec = given;
  spec.elements_across = across;
  spec.fidelity = "custom";
  for (auto& b : spec.bodies)
    if (b.element_size) b.element_size = *b.element_size * given.elements_across / across;
  const auto s = set_up(spec);
  begin(*s);
  Pilot p;
  p.size = size_of(*s);
  const double built = allocated_bytes() + bytes_to_wake(s->mesh.elements);
  const auto mark = [&] {
    p.marks.push_back({s->time, static_cast<double>(s->steps), parts(s->work), std::vector<double>(s->mesh.body_elements.size(), 0)});
    for (const auto body : s->particles.body) p.marks.back().converted[body] += std::pow(spec.particles_per_edge, -3);
    p.bytes_beside = std::max(p.bytes_beside, allocated_bytes() + bytes_to_wake(s->mesh.elements) - built);
  };
  mark();
  using Wall = std::chrono::steady_clock;
  const auto wall_start = Wall::now();
  const double start = work_clock();
  while (s->time < spec.end * (1 - 1e-12) && work_clock() - start < budget) {
    choose_step(*s, spec.end);
    try {
      step(*s);
    } catch (const core::GuardError&) {  // too coarse to last: what it did until here still counts
      break;
    }
    if (s->time >= static_cast<double>(p.marks.size()) * 0.01 * spec.end) mark();
  }
  mark();
  p.seconds = work_clock() - start;
  // stages are timed on the wall; with one thread the processor's time is what counts
  const double on_wall = std::chrono::duration<double>(Wall::now() - wall_start).count();
  const double quiet = p.seconds / std::max(on_wall, 1e-9);
  p.reached = s->time / spec.end;
  double staged = 0;
  for (const double part : p.marks.back().part) staged += part;
  const double beside = on_wall / std::max(staged, 1e-9);  // choose_step lies between the stages
  for (Mark& m : p.marks)
    for (double& part : m.part) part *= quiet * beside;
  p.whole = p.marks.back();
  if (p.reached < 1 - 1e-9) extrapolate(p, before, spec.end);
  return p;
}

/// Element rates of meshes of two sizes, the second over the first: caches hold the one and not the other.
static double element_slowdown(double n_from, double n_to) {
  const auto rate = [](double n) {
    const int edge = std::clamp(static_cast<int>(std::lround(std::cbrt(n))), 6, 60);
    return time_hex(edge, bench_material(), 0.2).element_steps_per_second.median;
  };
  return rate(n_from) / rate(n_to);
}

double resident_bytes() {
  std::ifstream f("/proc/self/statm");
  double all = 0, resident = 0;
  f >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Of a particle: its rows, its actor, its list with room to grow, scratch.
static double bytes_per_particle() {
  const auto s = straining_block(16, bench_material(), io::Mode::sph);
  choose_step(*s, 1);
  step(*s);
  const double n = static_cast<double>(s->particles.size());
  constexpr double rows = 16 * sizeof(double) + 4 * sizeof(core::Vec3) + 40, scratch = 2 * sizeof(core::Mat3) + 150, tree = 100;
  constexpr double group = sizeof(sph::Sixteen<float>);
  const double lists = 4 * static_cast<double>(s->hood.pairs.list.size()) + group * static_cast<double>(3 * s->hood.near.size() + s->hood.pull.size());
  return rows + sph::Actors::bytes_each + scratch + tree + lists / n;
}

Cost predict_cost(const Simulation& built, double budget) {
  const Size wanted = size_of(built);
  const double memory = resident_bytes();
  std::vector<Pilot> pilots;
  double spent = 0;
  for (const int across : {4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64}) {
    if (across >= built.spec.elements_across && !pilots.empty()) break;
    double may_take = most_first * budget;
    if (!pilots.empty()) {
      const double took = pilots.back().seconds;
      // the second as long as the first, whatever is left: one alone tells no trend
      may_take = pilots.size() == 1 ? std::max(took, budget - spent) : budget - spent;
      if (pilots.back().reached < 1 - 1e-9 || may_take < took) break;  // less than that is too early a part of a run to tell
    }
    pilots.push_back(fly(built.spec, std::min(across, built.spec.elements_across), may_take, pilots.empty() ? nullptr : &pilots.back()));
    spent += pilots.back().seconds;
  }
  const Pilot& last = pilots.back();
  auto factor = growth(last, wanted);
  if (wanted.across > last.size.across) factor[elements] *= element_slowdown(last.size.n_elements, wanted.n_elements);
  // what the pilots before say beyond that
  double steps_trend = 0;
  std::array<double, n_parts> trend{};
  if (pilots.size() > 1) {
    const auto& first = pilots[pilots.size() > 2 ? pilots.size() - 3 : 0];
    const double ratio = std::log(last.size.across / first.size.across);
    const auto expected = growth(first, last.size);
    const auto of = [&](double found, double was) { return found > 0 && was > 0 ? std::clamp(std::log(found / was) / ratio, -most_trend, most_trend) : 0.0; };
    for (std::size_t k = 0; k < n_parts; ++k) trend[k] = 0.5 * of(last.whole.part[k], expected[k] * first.whole.part[k]);
    steps_trend = 0.5 * of(last.whole.steps, first.whole.steps * first.size.finest / last.size.finest);
  }
  const double finer = wanted.across / last.size.across;
  Cost c;
  c.steps = last.whole.steps * last.size.finest / wanted.finest * std::pow(finer, steps_trend);
  const auto seconds = [&](Part k) { return last.whole.part[k] * factor[k] * std::pow(finer, trend[k]); };
  c.elements_seconds = seconds(elements);
  c.particles_seconds = seconds(particles);
  c.contact_seconds = seconds(contact);
  c.seconds = c.elements_seconds + c.particles_seconds + c.contact_seconds;
  c.particles = matter(last, wanted) * std::pow(built.spec.particles_per_edge, 3);
  // in mode sph the particles are there already, without lists, and nothing else is
  const bool particles_alone = built.spec.mode == io::Mode::sph;
  const double measured = built.scene.plates.size() > 1 ? measured_bytes_per_row + measured_bytes_per_copy * built.spec.symmetry.copies() : 0.0;
  if (particles_alone)
    c.bytes = small_arrays + static_cast<double>(built.particles.size()) * (bytes_per_particle() + measured);
  else  // what a cloud's measurement takes is given back before the cloud strikes
    c.bytes = small_arrays + memory + bytes_to_wake(built.mesh.elements) + more_bytes_per_element * wanted.n_elements +
              std::max(measured * (wanted.n_elements + c.particles), last.bytes_beside * growth_beside(last, wanted));
  c.pilot_across = static_cast<int>(last.size.across);
  c.pilot_part = last.reached;
  c.pilot_seconds = spent;
  return c;
}

}  // namespace app
