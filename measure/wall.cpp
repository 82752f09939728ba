// SPDX-License-Identifier: Apache-2.0
// What a wall suffered as a whole: perforated or not, how far its back bulges, what came off it, the impulse it took.
#include <algorithm>
#include <cmath>

#include "measure/families.hpp"

namespace measure {
namespace {

/// Material of the plate itself that came off and recedes beyond its back face: spall, or the plug of a hole.
double detached_mass(const Whole& whole, const Plate& plate) {
  const Matter& m = whole.matter;
  const core::Vec3 normal = plate.frame.axes.row(2).transpose();
  double mass = 0;
  for (std::size_t row = 0; row < whole.size(); ++row)
    if (m.body[row] == plate.body && whole.debris[row] && plate.frame.local(m.x[row]).z() < -plate.frame.half.z() &&
        (m.v[row] - whole.rims[plate.body].velocity).dot(normal) < 0)
      mass += m.m[row];
  return mass;
}

}  // namespace

double bulge(const Plate& plate) {
  const double back = -plate.frame.half.z();
  double lowest = back;
  for (const Quad& q : plate.held.quads)
    for (const core::Vec3& x : q.x) lowest = std::min(lowest, x.z());
  for (const Sphere& s : plate.held.spheres) lowest = std::min(lowest, s.x.z() - 0.5 * s.spacing);
  return back - lowest;
}

Plate make_plate(const Whole& whole, const Scene& scene, int body) {
  Plate plate;
  plate.body = body;
  plate.name = scene.bodies[body].name;
  plate.frame = plate_frame(scene, body);
  plate.sound = surface_of(whole, plate.frame, body, whole.sound);
  plate.held = surface_of(whole, plate.frame, body, whole.held);
  plate.settled = surface_of(whole, plate.frame, body, whole.settled);
  plate.window = disturbed_window(plate.sound, plate.frame);
  plate.opening = find_opening(plate.sound, plate.window, plate.frame);
  return plate;
}

void measure_wall(const Whole& whole, const Plate& plate, Result& result) {
  add(result, plate.name + ".perforated", plate.opening.through ? 1 : 0, "bool");
  add(result, plate.name + ".bulge", bulge(plate), "m");
  add(result, plate.name + ".detached_mass", detached_mass(whole, plate), "kg");
  add(result, plate.name + ".rim_displacement", whole.rims[plate.body].displacement, "m");
}

void measure_impulse(const Scene& scene, int body, Result& result) {
  const BodyScene& b = scene.bodies[body];
  add(result, b.name + ".impulse", std::abs(b.normal.normalized().dot(b.impulse)), "N s");
}

}  // namespace measure
