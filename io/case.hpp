// SPDX-License-Identifier: Apache-2.0
// A case as its file states it, resolved to SI numbers. Read by io/case_file; nothing here knows TOML.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"
#include "material/material.hpp"

namespace io {

enum class Mode { hybrid, erosion, fem, sph };
enum class Shape { sphere, cylinder, plate, box, mesh };

struct BodySpec {
  std::string name;
  Shape shape = Shape::sphere;
  double diameter = 0;                       ///< sphere, cylinder [m]
  double length = 0;                         ///< cylinder, along z before rotation [m]
  core::Vec3 size{0, 0, 0};                  ///< plate: x, y edges (z holds the thickness); box: x, y, z [m]
  core::Vec3 center{0, 0, 0};                ///< [m]
  core::Vec3 normal{0, 0, 1};                ///< direction of the body's z axis (front face of a plate at the larger z)
  core::Vec3 velocity{0, 0, 0};              ///< [m/s]
  core::Vec3 spin{0, 0, 0};                  ///< angular velocity about the center [rad/s]
  std::string material;                      ///< name
  std::string file;                          ///< mesh: LS-DYNA keyword deck with *NODE and *ELEMENT_SOLID, relative to the case
  core::Vec3 deck_middle{0, 0, 0};           ///< mesh: middle of the box round the file's coordinates [m]
  std::optional<double> element_size;        ///< overrides what fidelity gives [m]
  std::optional<double> fine_radius;         ///< plate, box: radius of the fine mesh round where it is struck [m]
  std::optional<int> elements_through;       ///< plate: elements through the thickness
};

/// Full edges in the body's own axes [m]; of a mesh zero until its file is measured.
inline core::Vec3 extent(const BodySpec& b) {
  switch (b.shape) {
    case Shape::sphere: return core::Vec3::Constant(b.diameter);
    case Shape::cylinder: return {b.diameter, b.diameter, b.length};
    default: return b.size;
  }
}

/// A plane that nothing passes and that does not give way: {x : normal . (x - point) = 0}, matter on the normal's side.
struct RigidWall {
  core::Vec3 point{0, 0, 0}, normal{0, 0, 1};
};

struct Case {
  std::string title;
  std::string file;                          ///< path it was read from

  // [run]
  Mode mode = Mode::hybrid;
  double end = 0;                            ///< [s]
  double mesh_end = 0;                       ///< plates that nothing can get to before it are coarse [s]; 0: end
  int elements_across = 20;                  ///< elements over the projectile's smallest extent; from fidelity or elements_across
  std::string fidelity = "standard";         ///< draft | standard | fine | reference, or "custom" where elements_across was given
  bool symmetry_auto = true;
  core::Symmetry symmetry;                   ///< resolved by app/setup where auto
  double sleep = 0;                          ///< nodal speed below which untouched elements sleep [m/s]; 0 exact, negative off
  double cfl = 0.9;                          ///< fraction of the stable step, elements and particles
  std::string hourglass = "viscous";         ///< viscous | stiffness
  double hourglass_coefficient = -1;         ///< -1: the form's default [-]
  double viscosity_linear = -1, viscosity_quadratic = -1;  ///< bulk viscosity of elements, -1: default [-]
  double energy_tolerance = 1e-6;            ///< a run stops where |energy error| exceeds this part of the initial kinetic energy

  std::vector<BodySpec> bodies;              ///< [[body]]
  std::vector<RigidWall> walls;              ///< [[wall]] point, normal

  // [convert]: what flags an element, for conversion (hybrid) and for deletion (erosion)
  std::vector<std::string> criteria{"jacobian"};  ///< deformation | jacobian | plastic_strain | timestep | damage
  double deformation = 2.0;                  ///< total deformation [-]
  double jacobian_ratio = 2.5;               ///< largest over smallest det J of eight points [-]
  double min_angle = 0.5;                    ///< smallest corner angle of a face [rad]
  double plastic_strain = 2.5;               ///< [-]
  double timestep_ratio = 0.1;               ///< element's stable step over its first one [-]
  double damage = 1.0;                       ///< [-]
  int particles_per_edge = 1;                ///< 1, 2 or 3
  bool bond = true;
  bool keep_nodes = false;                   ///< erosion: nodes that lose their last element fly on as free masses

  // [contact]
  bool contact = true;
  double friction = 0;                       ///< Coulomb coefficient [-]

  // [output]
  double every = 0;                          ///< interval between snapshots in run.h5 [s]; 0: twenty over the run
  double history_every = 0;                  ///< interval between rows of history.csv [s]; 0: 1000 over the run
  double checkpoint_every = 0;               ///< wall-clock seconds between checkpoints; 0: 600

  struct Reference {
    double value = 0;                        ///< SI
    std::string source;
    int line = 0;
  };
  std::map<std::string, Reference> reference;     ///< [reference]

  std::map<std::string, material::Material> materials;  ///< those that bodies use, by name
};

}  // namespace io
