// SPDX-License-Identifier: Apache-2.0
// Crater in a plate or box, from the front-most point of the held material over every column. Depth: as far below the front
// face as built as a gauge reaches. Diameter: 2 x the mean over azimuth of the inner radius in the plane of the front
// face (a tenth of an element below it, so that the undisturbed face itself does not count). Lip: the highest point.
#include <algorithm>
#include <cmath>

#include "measure/families.hpp"
#include "measure/radial.hpp"

namespace measure {
namespace {

constexpr double below_face = 0.1;        // of an element
constexpr double least_depth = 0.5;       // of an element: shallower is no crater
constexpr double dished_part = 0.5;       // of the depth: a wall whose back gave way by more is dished
constexpr double column_of_element = 0.5;
constexpr double most_columns = 4e6;

Columns crater_columns(const Window& window) {
  double h = column_of_element * window.size;
  const double area = (window.high[0] - window.low[0]) * (window.high[1] - window.low[1]);
  return columns_over(window, std::max(h, std::sqrt(area / most_columns)));
}

double lip_height(const Surface& surface, double face) {
  double highest = face;
  for (const Quad& q : surface.quads)
    for (const core::Vec3& x : q.x) highest = std::max(highest, x.z());
  for (const Sphere& s : surface.spheres) highest = std::max(highest, s.x.z() + 0.5 * s.spacing);
  return highest - face;
}

/// How deep the tip of a gauge goes that is as wide as the columns round one, an element and a half: into craters, not into
/// the gaps between particles that line them.
double gauge(const Columns& columns, const std::vector<double>& heights, double face) {
  double depth = 0;
  for (int j = 0; j < columns.n[1]; ++j)
    for (int i = 0; i < columns.n[0]; ++i) {
      double rests_at = no_height;
      columns.each_around(i, j, [&](std::size_t k) { rests_at = std::max(rests_at, heights[k]); });
      if (rests_at != no_height) depth = std::max(depth, face - rests_at);
    }
  return depth;
}

}  // namespace

void measure_crater(const Plate& plate, Result& result) {
  if (!plate.window.exists) return;
  const double face = plate.frame.half.z();
  const Columns columns = crater_columns(plate.window);
  const std::vector<double> heights = front_heights(plate.held, columns);
  const double depth = gauge(columns, heights, face);
  if (!plate.opening.through) add(result, plate.name + ".crater_depth", depth, "m");
  add(result, plate.name + ".crater_lip_height", lip_height(plate.held, face), "m");

  // The plane of the front face cuts a dished wall along the dish's rim, wherever its crater ends.
  if (plate.opening.through || bulge(plate) > dished_part * depth) return;
  std::vector<char> sunk(heights.size());
  for (std::size_t k = 0; k < heights.size(); ++k) sunk[k] = heights[k] < face - least_depth * plate.window.size;
  const Patch crater = largest_patch(columns, sunk);
  if (crater.n_columns == 0) {
    add(result, plate.name + ".crater_diameter", 0, "m");
    return;
  }
  const double w = face - below_face * plate.window.size;
  const InnerEdge edge =
      centred_inner_edge(cut_at(plate.held, {}, w), cut_spheres(plate.held, {}, w), Band::everything(), crater.center);
  if (edge.exists()) add(result, plate.name + ".crater_diameter", edge.mean_diameter(), "m");
}

}  // namespace measure
