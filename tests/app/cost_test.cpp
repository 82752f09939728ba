// SPDX-License-Identifier: Apache-2.0
// What `ejecta check` says a run will cost, against the run.
#include "app/cost.hpp"

#include <gtest/gtest.h>

#include "tests/app/small_case.hpp"

namespace {

TEST(Cost, AFoilOfParticlesIsNoCoarserInThePilot) {
  // In mode sph a plate's particles are as fine as it is thick, whatever the sphere's: steps of a pilot 4 across are those of the run. Taken
  // as if all meshes were coarser, they came out three times too many.
  const std::vector<std::string> set{"run.mode=\"sph\"", "run.elements_across=14", "run.end=\"0.1 us\"", "body.bumper.thickness=\"0.05 mm\"",
                                     "body.bumper.size=[\"1.6 mm\", \"1.6 mm\"]", "body.bumper.center=[\"0 mm\", \"0 mm\", \"-0.025 mm\"]"};
  auto s = small_case::begin(set);
  const double steps = app::predict_cost(*s, 0.1).steps;
  small_case::run(*s, 1000000);
  EXPECT_GT(steps, 0.5 * static_cast<double>(s->steps));
  EXPECT_LT(steps, 2.0 * static_cast<double>(s->steps));
}

}  // namespace
