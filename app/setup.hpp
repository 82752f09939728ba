// SPDX-License-Identifier: Apache-2.0
// A case becomes a state: meshes, symmetry, materials, settings, and the scene that measurements refer to.
#pragma once

#include <memory>
#include <string>

#include "app/simulation.hpp"
#include "io/case.hpp"

namespace app {

/// Builds the whole state, ready for begin(). Throws core::CaseError for bodies that overlap, symmetry that the scene does
/// not have, and a mesh that needs more memory than the machine has.
std::unique_ptr<Simulation> set_up(const io::Case& spec);

/// Planes about which the scene is symmetric.
core::Symmetry find_symmetry(const io::Case& spec);

/// What a case will cost before it is built.
struct Estimate {
  struct Body {
    std::string name;
    double elements = 0;      ///< more of them may be asked for than can be counted
    double element_size = 0;  ///< smallest edge [m]
  };
  std::vector<Body> bodies;
  double elements = 0;
  double bytes = 0;           ///< memory at the start, and as much again for what may be converted
  double available = 0;       ///< free memory of this machine [bytes]
};
Estimate estimate(const io::Case& spec);

/// Free memory of this machine [bytes].
double available_memory();

}  // namespace app
