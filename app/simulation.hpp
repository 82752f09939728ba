// SPDX-License-Identifier: Apache-2.0
// The whole state of a run and one step of it. This is the page to read first: step() in simulation.cpp, whose stages
// are numbered as the table in README.md.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/ledger.hpp"
#include "coupling/bond.hpp"
#include "coupling/contact.hpp"
#include "fem/added_inertia.hpp"
#include "fem/criteria.hpp"
#include "fem/element_kernel.hpp"
#include "fem/mesh.hpp"
#include "io/case.hpp"
#include "measure/matter.hpp"
#include "sph/neighbourhood.hpp"
#include "sph/particle_forces.hpp"
#include "sph/particles.hpp"

namespace app {

/// What holds the time step down.
struct StepLimit {
  std::string kind;       ///< "element", "particle", "contact", "growth", "end"
  std::size_t index = 0;  ///< element or particle
  double value = 0;       ///< [s]
};

enum class Stage { search, pair_forces, kick, contact, pair_work, drift, elements, particles, convert, account };
constexpr std::size_t n_stages = 10;
constexpr std::array<const char*, n_stages> stage_names{"search", "pair_forces", "kick",      "contact", "pair_work",
                                                        "drift",  "elements",    "particles", "convert", "account"};

/// Work done so far, for the summary.
struct Work {
  std::uint64_t element_updates = 0, element_updates_asleep = 0, element_updates_slowed = 0;
  std::uint64_t particle_updates = 0, particle_updates_asleep = 0;
  std::uint64_t pair_updates = 0;
  std::array<double, n_stages> seconds{};
  double cpu_seconds_before = 0;  ///< of processes that this run began in
};

struct Simulation {
  io::Case spec;
  std::vector<material::Material> materials;
  std::vector<double> rho_0;               ///< [body] [kg/m3]

  fem::Mesh mesh;
  sph::Particles particles;
  sph::Neighbourhood hood;                 ///< built when there is a first particle
  coupling::Bond bond;
  coupling::Contact contact;               ///< built when there is something to strike
  std::vector<coupling::Wall> walls;

  fem::ElementSettings element_settings;
  sph::ParticleSettings particle_settings;
  fem::Criteria criteria;
  coupling::ContactSettings contact_settings;
  double sleep_threshold = 0;              ///< [m/s]; negative: nothing sleeps

  double time = 0;                         ///< [s]
  double dt = 0;                           ///< of the step to come [s]
  double dt_old = 0;                       ///< of the step before; 0 at the start [s]
  std::int64_t steps = 0;
  StepLimit limit;
  std::vector<fem::Slowed> slowed;         ///< elements that would hold the step to come, and the inertia they get
  std::size_t n_elements_initial = 0, n_converted = 0, n_eroded = 0;
  Ledger ledger;
  Work work;
  std::vector<core::Vec3f> built;          ///< [element] centres as built [m]; scene.built sees them
  measure::Scene scene;
  std::vector<std::uint32_t> on_axis;      ///< elements built within one element of the line of flight, ascending
  std::vector<measure::Value> frozen;      ///< clouds as they were just before they met the next plate
  std::vector<std::uint8_t> cloud_frozen;  ///< [plate]
  double clouds_due = 0;                   ///< before this time none of them can be near the next plate [s]
  std::vector<std::string> warnings;       ///< meshes that do not match; one a material at most: matter that left its table
  std::vector<std::uint8_t> off_table;     ///< [material] it has been said
  double peak_removed = 0, peak_removed_axis = 0;  ///< highest pressures in elements that were deleted [Pa]
  double peak_impact = 0;                  ///< highest on the axis until the first cloud met the next plate; 0 before [Pa]
  std::vector<core::Vec3> taken_along;     ///< [body] momentum that deleted elements had received [kg m/s]

  std::vector<core::Mat3> correction, velocity_gradient;  ///< scratch of the particles
};

/// One step: from x, stress at n and v at n - 1/2 to n + 1 and n + 1/2. Throws core::GuardError when an invariant breaks;
/// the state is then that of the step's end.
void step(Simulation& s);

/// The stable step for the state now, not beyond `stop` [s].
void choose_step(Simulation& s, double stop);

/// First forces, stable steps and ledger of a freshly built state.
void begin(Simulation& s);

}  // namespace app
