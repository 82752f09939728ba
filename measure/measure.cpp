// SPDX-License-Identifier: Apache-2.0
// The order of all measurements: each plate in turn, bars, the clouds, what flew back, the fragments, the pressure.
#include <cmath>
#include <utility>

#include "measure/families.hpp"

namespace measure {
namespace {

/// Brings matter to where it would be, and to the speeds it would have, had the first plate stood still from the start.
void stand_still(Matter& matter, Scene& scene) {
  const core::Vec3 velocity = std::exchange(scene.rest, core::Vec3::Zero()), flown = scene.time * velocity;
  if (velocity.isZero(0)) return;
  for (auto& x : matter.x.own) x -= flown;
  for (auto& x : matter.node_x) x -= flown;
  for (auto& v : matter.v.own) v -= velocity;
  for (auto& body : scene.bodies) body.velocity -= velocity;
}

void measure_pressure(const Scene& scene, Result& result) {
  const auto put = [&](const char* key, double p) {
    if (p > 0) add(result, key, p, "Pa");
  };
  put("peak_pressure", scene.peak_pressure_axis);
  put("peak_pressure_hugoniot", scene.peak_pressure_axis_hugoniot);
  put("peak_pressure_max", scene.peak_pressure_max);
  put("peak_pressure_jetting", scene.peak_pressure_jetting);
}

void measure_plate(const Whole& whole, const Scene& scene, int body, Result& result) {
  measure_impulse(scene, body, result);
  if (!whole.rims[body].exists) return;
  const Plate plate = make_plate(whole, scene, body);
  measure_wall(whole, plate, result);
  measure_hole(whole, plate, result);
  measure_crater(plate, result);
}

}  // namespace

void add(Result& result, const std::string& key, double value, const std::string& unit) {
  if (std::isfinite(value)) result.values.push_back({key, value, unit});
}

Result measure(Matter matter, const Scene& given) {
  Scene scene = given;
  stand_still(matter, scene);
  Whole whole = make_whole(std::move(matter), scene);
  whole.faces = bounding_faces(whole);
  Result result;
  for (const int body : whole.plates) measure_plate(whole, scene, body, result);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (!scene.bodies[b].bar_axis.isZero(0)) measure_bar(whole, scene, static_cast<int>(b), result);
  if (whole.impact_speed > 0 && !scene.plates.empty()) {
    for (std::size_t k = 0; k < scene.plates.size(); ++k) measure_cloud_behind(whole, scene, k, result);
    for (std::size_t k = 0; k < scene.plates.size(); ++k) measure_debris_behind(whole, scene, k, result);
    measure_ejecta(whole, scene, result);
  }
  if (whole.impact_speed > 0) measure_fragments(whole, scene, result);
  measure_pressure(scene, result);
  return result;
}

Result measure_cloud(Matter matter, const Scene& given, std::size_t plate_index) {
  Result result;
  Scene scene = given;
  stand_still(matter, scene);
  if (scene.impact_velocity.norm() <= 0 || plate_index >= scene.plates.size()) return result;
  Whole whole = make_whole(std::move(matter), scene);
  whole.faces = bounding_faces(whole);
  measure_cloud_behind(whole, scene, plate_index, result);
  return result;
}

}  // namespace measure
