// SPDX-License-Identifier: Apache-2.0
// The families of measurements. Each appends its values to a result; docs/measurements.md defines every key.
#pragma once

#include <string>

#include "measure/surface.hpp"
#include "measure/whole.hpp"

namespace measure {

/// Appends a value unless it is not a finite number.
void add(Result& result, const std::string& key, double value, const std::string& unit);

/// One plate with what several families need of it.
struct Plate {
  int body = 0;
  std::string name;
  PlateFrame frame;
  Surface sound, held, settled;  ///< surfaces of what belongs to it, see Whole
  Window window;                 ///< what the impact changed
  Opening opening;               ///< through the sound material
};
Plate make_plate(const Whole& whole, const Scene& scene, int body);

/// How far the held material reaches beyond the back face as built [m].
double bulge(const Plate& plate);

void measure_hole(const Whole& whole, const Plate& plate, Result& result);
void measure_crater(const Plate& plate, Result& result);
void measure_wall(const Whole& whole, const Plate& plate, Result& result);
/// Of any plate, whether its rim is still there or not.
void measure_impulse(const Scene& scene, int body, Result& result);
void measure_bar(const Whole& whole, const Scene& scene, int body, Result& result);

/// Rows of debris that passed the plate scene.plates[plate_index] and fly on, without that of bodies built behind it.
std::vector<std::uint32_t> cloud_rows(const Whole& whole, const Scene& scene, std::size_t plate_index);
void measure_cloud_behind(const Whole& whole, const Scene& scene, std::size_t plate_index, Result& result);
void measure_debris_behind(const Whole& whole, const Scene& scene, std::size_t plate_index, Result& result);
void measure_ejecta(const Whole& whole, const Scene& scene, Result& result);

void measure_fragments(const Whole& whole, const Scene& scene, Result& result);

}  // namespace measure
