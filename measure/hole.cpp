// SPDX-License-Identifier: Apache-2.0
// Hole in a plate. Seen along the normal, the settled material's inner edge gives a first radius for every azimuth. The
// lip there may be bent out of the plate's mid-plane, so its own middle height is taken from the ring of material behind
// the edge, one thickness wide, and the radius counts material within half a thickness of that height. The hole's centre
// is the centroid of the opening. A channel too crooked to see through is measured in the plate's
// middle, bent as that may be.
#include <algorithm>
#include <cmath>

#include "measure/families.hpp"
#include "measure/radial.hpp"

namespace measure {
namespace {

constexpr int n_sectors = 24;           // of azimuth, for the height of the lip
constexpr double lip_half_band = 0.6;   // of the thickness: half of it, and a little for faces that lie on the limit
constexpr double off_mid_plane = 0.01;  // of an element: a plane that holds no faces

/// Middle height of the settled material just behind the inner edge, one value a sector.
std::array<double, n_sectors> lip_heights(const Whole& whole, const Plate& plate, const InnerEdge& edge) {
  const Matter& m = whole.matter;
  const double ring = std::max(plate.frame.thickness, 2 * plate.window.size);
  std::array<double, n_sectors + 1> mass{}, moment{};
  for (std::size_t row = 0; row < whole.size(); ++row) {
    if (m.body[row] != plate.body || !whole.settled[row]) continue;
    const core::Vec3 x = plate.frame.local(m.x[row]);
    const double u = x.x() - edge.center[0], v = x.y() - edge.center[1];
    double azimuth = std::atan2(v, u) / (2 * core::pi);
    azimuth -= std::floor(azimuth);
    const int ray = std::min(n_rays - 1, static_cast<int>(azimuth * n_rays));
    if (std::hypot(u, v) > edge.radius[ray] + ring) continue;
    for (const int s : {std::min(n_sectors - 1, static_cast<int>(azimuth * n_sectors)), n_sectors})
      mass[s] += m.m[row], moment[s] += m.m[row] * x.z();
  }
  const double mean = mass[n_sectors] > 0 ? moment[n_sectors] / mass[n_sectors] : 0;
  std::array<double, n_sectors> height;
  for (int s = 0; s < n_sectors; ++s) height[s] = mass[s] > 0 ? moment[s] / mass[s] : mean;
  return height;
}

InnerEdge edge_of_hole(const Whole& whole, const Plate& plate) {
  const Edges edges = edges_of(plate.settled);
  if (plate.opening.seen.n_columns == 0) {
    const double w = off_mid_plane * plate.window.size;
    return centred_inner_edge(cut_at(plate.settled, plate.opening.bent, w), cut_spheres(plate.settled, plate.opening.bent, w),
                              Band::everything(), plate.opening.middle.center);
  }
  const InnerEdge seen =
      centred_inner_edge(edges, plate.settled.spheres, Band::everything(), plate.opening.seen.center);
  if (!seen.exists()) return seen;
  const auto height = lip_heights(whole, plate, seen);
  Band band;
  for (int j = 0; j < n_rays; ++j) {
    const double w = height[j * n_sectors / n_rays];
    band.low[j] = w - lip_half_band * plate.frame.thickness;
    band.high[j] = w + lip_half_band * plate.frame.thickness;
  }
  const InnerEdge lip = inner_edge(edges, plate.settled.spheres, band, seen.center);
  return lip.exists() ? lip : seen;
}

}  // namespace

void measure_hole(const Whole& whole, const Plate& plate, Result& result) {
  const std::string key = plate.name + ".hole_diameter";
  if (!plate.opening.through) {
    for (const char* suffix : {"", "_min", "_max"}) add(result, key + suffix, 0, "m");
    return;
  }
  const InnerEdge edge = edge_of_hole(whole, plate);
  if (!edge.exists()) return;
  const auto [least, most] = edge.extreme_diameters();
  add(result, key, edge.mean_diameter(), "m");
  add(result, key + "_min", least, "m");
  add(result, key + "_max", most, "m");
}

}  // namespace measure
