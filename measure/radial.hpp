// SPDX-License-Identifier: Apache-2.0
// The inner edge of material round an opening: rays in a plate's plane, evenly spaced in azimuth from the centre of the
// opening, and the nearest material that each meets.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "measure/surface.hpp"

namespace measure {

constexpr int n_rays = 720;

/// Heights above the plate's mid-plane between which material counts, one pair for every ray [m].
struct Band {
  std::array<double, n_rays> low, high;
  static Band everything();
  static Band about(double w, double half);
};

struct InnerEdge {
  double center[2] = {0, 0};          ///< [m]
  std::array<double, n_rays> radius;  ///< along each ray [m], infinite where it meets nothing
  bool exists() const;                ///< at least half of the rays meet material
  double mean_diameter() const;       ///< 2 x mean radius, over lines that meet material on both sides where there are any [m]
  /// Smallest and largest distance between the two edges along a line through the centre [m].
  std::array<double, 2> extreme_diameters() const;
};

double ray_azimuth(int ray);

/// Edges of faces as seen along the normal: pairs of points in the plate's frame.
using Edges = std::vector<std::array<core::Vec3, 2>>;
/// All edges of the faces that are not flat.
Edges edges_of(const Surface& surface);
/// The lines in which the surface at height w above a plate's middle cuts the faces.
Edges cut_at(const Surface& surface, const Middle& middle, double w);
/// The spheres that it cuts.
std::vector<Sphere> cut_spheres(const Surface& surface, const Middle& middle, double w);

/// First hits of rays from a fixed centre.
InnerEdge inner_edge(const Edges& edges, std::span<const Sphere> spheres, const Band& band, const double center[2]);
/// The same from the centroid of the opening, found by iteration from a first guess inside it.
InnerEdge centred_inner_edge(const Edges& edges, std::span<const Sphere> spheres, const Band& band,
                             const double guess[2]);

}  // namespace measure
