// SPDX-License-Identifier: Apache-2.0
// What there is to measure: the matter of one instant, elements first, particles after, and the scene it came from.
// Built by app/ from a running simulation and by `ejecta measure` from run.h5: both give the same numbers.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/types.hpp"

namespace measure {

/// The part of the scene that was computed, and its images: of n elements and p particles and k planes, rows c n + i are the
/// elements' of copy c < 2^k, which is mirrored in plane j where bit j of c is set, and the particles' follow likewise.
struct Copies {
  std::size_t n_elements = 0;       ///< of the part
  int n_planes = 0;
  std::array<int, 3> axis{};        ///< [plane] along its normal
};

/// A field over all rows, stored for the part alone.
template <class T>
struct Field {
  std::vector<T> own;
  Copies copies;

  std::size_t size() const { return own.size() << copies.n_planes; }
  bool empty() const { return own.empty(); }
  T operator[](std::size_t row) const {
    if (copies.n_planes == 0) return own[row];
    const std::size_t n_elements = copies.n_elements, elements = n_elements << copies.n_planes;
    const bool element = row < elements;
    std::size_t left = element ? row : row - elements, each = element ? n_elements : own.size() - n_elements, copy = 0;
    while (left >= each) left -= each, ++copy;
    T a = own[element ? left : n_elements + left];
    if constexpr (std::is_same_v<T, core::Vec3>)
      for (int j = 0; j < copies.n_planes; ++j)
        if (copy >> j & 1) a[copies.axis[static_cast<std::size_t>(j)]] *= -1;
    return a;
  }
};

/// One row an alive element (rows [0, n_elements)) or a particle (the rest).
struct Matter {
  std::size_t n_elements = 0;
  Field<core::Vec3> x;        ///< centre [m]
  Field<core::Vec3> v;        ///< velocity [m/s]
  Field<double> m;            ///< mass [kg]
  Field<double> rho, e, T;    ///< [kg/m3] [J/kg] [K]
  Field<double> damage;
  Field<double> size;         ///< edge of an element (cube root of its volume), spacing of a particle (cbrt(m/rho)) [m]
  Field<int> body;            ///< parent body
  Field<std::uint32_t> parent; ///< element it is or came from, a row of Scene::built; may be empty
  Field<core::Vec3> built;    ///< where that element was built [m]; filled by make_whole
  std::vector<std::array<std::int32_t, 8>> node;  ///< [n_elements] corners, see fem/mesh.hpp for their order
  std::vector<core::Vec3> node_x;   ///< [m]

  /// Calls f(field) for every field over the rows.
  template <class F>
  void each_field(F&& f) {
    f(x), f(v), f(m), f(rho), f(e), f(T), f(damage), f(size), f(body), f(parent), f(built);
  }
};

struct BodyScene {
  std::string name;
  bool is_plate = false;            ///< plate or box at rest that something flies towards
  bool is_projectile = false;       ///< the body that moves
  core::Vec3 center{0, 0, 0}, normal{0, 0, 1};  ///< as built [m]; the front face is at center + normal * thickness / 2
  core::Vec3 velocity{0, 0, 0};     ///< that it began with [m/s]
  double thickness = 0;             ///< [m]
  core::Vec3 bar_axis{0, 0, 0};     ///< away from the wall, of a cylinder that strikes a rigid one end on; zero of others
  core::Vec3 extent{0, 0, 0};       ///< full edges in the body's own axes [m]
  double rho_0 = 0;                 ///< reference density; 0 where unknown: expanded particles then count as large [kg/m3]
  double e_melt = 1e300, e_melted = 1e300, e_vapour = 1e300, e_vaporised = 1e300;  ///< see material::Material [J/kg]
  core::Vec3 impulse{0, 0, 0};      ///< momentum the body received so far, all copies [N s]
};

struct Scene {
  std::vector<BodyScene> bodies;
  std::vector<int> plates;          ///< indices of bodies in the order in which the projectile's line of flight meets them
  int projectile = 0;               ///< index
  core::Vec3 rest{0, 0, 0};         ///< velocity that the first plate began with: all is measured as seen from there [m/s]
  core::Vec3 impact_velocity{0, 0, 0};  ///< projectile's, as seen from there [m/s]
  core::Vec3 aim{0, 0, 0};          ///< where the line of flight meets the first plate's front face as built [m]
  double projectile_size = 0;       ///< diameter [m]
  double element_size = 0;          ///< fine mesh of the first plate [m]
  std::span<const core::Vec3f> built; ///< centres of all elements as built [m]; empty where unknown; not owned
  core::Symmetry symmetry;          ///< the matter given is the part on the positive sides
  double time = 0;                  ///< [s]
  double peak_pressure_axis = 0, peak_pressure_axis_hugoniot = 0, peak_pressure_max = 0;  ///< recorded while running [Pa]
  double peak_pressure_jetting = 0;  ///< of the oblique impact at which jetting begins, 0 unless a sphere strikes [Pa]
};

struct Value {
  std::string key;                  ///< as DESIGN names it, "bumper.hole_diameter"
  double value = 0;
  std::string unit;                 ///< SI, "" for a pure number or a truth value (1 or 0, unit "bool")
};

/// One connected piece of debris.
struct Fragment {
  double mass = 0, size = 0, temperature = 0;   ///< [kg] [m, diameter of the sphere of its volume] [K, mass mean]
  core::Vec3 x{0, 0, 0}, v{0, 0, 0};            ///< centre of mass [m], velocity [m/s], as seen from the first plate
  double projectile_fraction = 0;               ///< mass that came from the projectile [-]
  int n_points = 0;
  bool lone = false;                            ///< a single particle out of every kernel's reach
  double failed_fraction = 0;                   ///< mass that has failed: powder, whatever piece it lies in [-]
  int links_cut = 0;                            ///< neighbours as built that are no longer of this piece
  double cut_by_reach = 0;                      ///< part of them cut though neither side had failed [-]
};

struct Result {
  std::vector<Value> values;
  std::vector<Fragment> fragments;  ///< largest first
};

/// [body] can the debris behind the plate scene.plates[plate_index] hold its matter? Not of later plates, nor of anything else
/// that stood behind it, nor of what flies past its edges.
std::vector<std::uint8_t> built_before(const Scene& scene, std::size_t plate_index);

/// Every measurement that the scene allows. Keys and definitions: docs/measurements.md.
Result measure(Matter matter, const Scene& scene);

/// The debris cloud behind the plate scene.plates[plate_index] alone, with the same keys and values as measure() would
/// give for this matter: for the moment before the cloud's front reaches the next plate.
Result measure_cloud(Matter matter, const Scene& scene, std::size_t plate_index);

}  // namespace measure
