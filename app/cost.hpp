// SPDX-License-Identifier: Apache-2.0
// What a run will cost, for `ejecta check`: the case itself is run on coarser meshes (pilots), within seconds, and what
// each stage took is carried over to the mesh asked for. Nothing about shots or kernels is assumed that the pilots do not
// show: how far steps shrink, what wakes, what converts and when, what contact takes. How they are carried over:
//   steps      with the edge of the finest mesh, h:                                        n_s ~ 1/h
//   elements   stage time ~ (elements of the mesh) n_s / (element rate of the mesh's size), the rate by bench's time_hex
//   particles  stage time ~ (matter that converted, in elements of the mesh asked for) n_s
//   contact    stage time ~ (the geometric mean of both) n_s
// and each of the three is corrected by the power of h that the last pilots show beyond that, damped by half and held
// within `most_trend`. Memory: what the state asked for holds as built, and what the pilot held beside its elements ~ (matter that converted)^0.9.
// The last pilot need not get to the end: it goes on as the one before it did. There are two at least.
#pragma once

#include <string>

#include "app/simulation.hpp"
#include "io/case.hpp"

namespace app {

struct Cost {
  double seconds = 0;                                    ///< of the run, on the wall of a machine that does nothing else
  double steps = 0;
  double elements_seconds = 0, particles_seconds = 0, contact_seconds = 0;  ///< parts of `seconds`
  double particles = 0;                                  ///< at the end
  double bytes = 0;                                      ///< peak memory
  int pilot_across = 0;                                  ///< elements across of the finest pilot
  double pilot_part = 1;                                 ///< part of the run that it went through
  double pilot_seconds = 0;                              ///< that all pilots took
};

/// `built` is the case at its own resolution, begun. Uses the threads that are set; budget: for the pilots [s]. The first two may take
/// twice as much each.
Cost predict_cost(const Simulation& built, double budget = 6);

/// Memory that the process holds now [byte].
double resident_bytes();

}  // namespace app
