// SPDX-License-Identifier: Apache-2.0
// Rates of the kernels on this machine, through the functions that a step uses: `ejecta bench`, the calibration of `ejecta
// check`, and the performance suite. What is timed really works: matter strains plastically by strain_per_step in every step.
// With one thread the time is that of the processor, so that what else runs on the machine does not count; with several it is
// that on the wall.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/simulation.hpp"
#include "material/material.hpp"

namespace app {

/// Median and quartiles of repeated measurements.
struct Spread {
  double median = 0, low = 0, high = 0;
  int repetitions = 0;
};
Spread spread(std::vector<double> samples);

/// Seconds since some instant: of the processor with one thread, on the wall with several.
double work_clock();

/// Largest strain of the matter that is timed, in one step [-]: an impact's order in what it breaks up.
constexpr double strain_per_step = 2e-3;

/// A block of edge^3 cubes of 0.1 mm of the material in a smooth flow, begun: elements (mode fem) or particles (mode sph).
std::unique_ptr<Simulation> straining_block(int edge, const material::Material& material, io::Mode mode);

/// Aluminium with Mie-Grueneisen and Johnson-Cook that does not fail, so that every repetition finds solid matter.
material::Material bench_material();

/// What of an element a step goes through: forces gathered to the nodes, kick, drift, element kernel, stable step.
void step_elements(Simulation& s);

struct HexRate {
  std::size_t elements = 0;
  Spread element_steps_per_second;
};
/// The steps of step_elements on edge^3 elements; `seconds` is about how long to measure.
HexRate time_hex(int edge, const material::Material& material, double seconds = 2);

struct SphRate {
  std::size_t particles = 0;
  double neighbours_each = 0;   ///< within the kernel's reach, in lists with their skin
  double steps_between_lists = 0;
  Spread particle_steps_per_second;
};
/// Whole steps (app::step and choose_step) of about n particles that fill a cube.
SphRate time_sph(std::size_t n, const material::Material& material, double seconds = 4);

struct Cloud {
  std::string name;
  std::vector<core::Vec3> x;
  std::vector<double> radius;
};
/// edge^3 points, one in a unit of volume, off their lattice by up to 0.2 along each axis, with about 61 neighbours each.
Cloud jittered_lattice(int edge);
/// float32 x y z radius, point after point. Throws core::CaseError where the file is something else.
Cloud read_cloud(const std::string& path);

struct OctreeTime {
  std::size_t points = 0;
  std::uint64_t neighbours = 0;   ///< ordered pairs (i, j), i != j, with |x_i - x_j| < radius_i
  Spread build_ms, query_ms, both_ms;
};
/// Tree and all neighbours. Before every repetition each point moves by up to a hundredth of its radius, as in a step;
/// neighbours are counted where the points were given.
OctreeTime time_octree(const Cloud& cloud, double seconds = 3);

struct BenchRequest {
  std::string kernel = "all";   ///< hex | sph | octree | all
  int size = 0;                 ///< hex: elements along an edge; sph, octree: number; with "all" along an edge; 0: default
  std::string points;           ///< octree: file of points in place of the lattice
  std::string json;             ///< file to write
};
/// Times, prints a table, writes the JSON. Throws core::CaseError for a request that cannot be met, core::GuardError where
/// the file cannot be written.
void bench(const BenchRequest& request);

/// Model of the processor as the system names it.
std::string processor_name();

}  // namespace app
