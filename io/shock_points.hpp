// SPDX-License-Identifier: Apache-2.0
// Measured shock states of the library's materials (material/shock_points.toml, built into the program).
#pragma once

#include <string>
#include <vector>

namespace io {

/// One series of experiments.
struct ShockSeries {
  std::string source;
  double rho_0 = 0;  ///< density of the samples [kg/m3]
  struct Point {
    double up;   ///< particle velocity behind the shock [m/s]
    double Us;   ///< shock velocity [m/s]
    double p;    ///< [Pa]
    double rho;  ///< [kg/m3]
  };
  std::vector<Point> points;  ///< by rising up
};

/// Series measured on the matter of any of these materials of the library; empty where none is stored.
std::vector<ShockSeries> shock_series(const std::vector<std::string>& materials);

}  // namespace io
