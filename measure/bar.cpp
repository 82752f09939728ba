// SPDX-License-Identifier: Apache-2.0
// A bar that struck a rigid wall end on, as a laboratory measures it after the test of Taylor (Proc. R. Soc. Lond. A 194 (1948) 289): the
// length that is left, and the outline near the foot. Of the largest piece of the body: what broke off is no bar.
#include <algorithm>
#include <limits>
#include <optional>

#include "measure/families.hpp"

namespace measure {
namespace {

constexpr double at_foot = 0.05;         ///< of the length as built, from the foot
constexpr double at_fifth = 0.2;
constexpr double slice = 0.02;           ///< half of it, about a height whose diameter is asked for
constexpr double on_axis = 0.2;          ///< of the largest radius

/// Matter's surface at one point: along the axis and across it [m].
struct Outer {
  double height, radius, half;           ///< half: how far matter reaches beyond the point
};

std::vector<char> largest_piece(const Whole& whole, int body) {
  std::vector<char> mask(whole.size());
  for (std::size_t row = 0; row < mask.size(); ++row) mask[row] = whole.matter.body[row] == body;
  const auto piece = connected_pieces(whole, mask, false);
  std::vector<double> mass(whole.size(), 0);
  for (std::size_t row = 0; row < mask.size(); ++row)
    if (mask[row]) mass[static_cast<std::size_t>(piece[row])] += whole.matter.m[row];
  const auto largest = std::max_element(mass.begin(), mass.end()) - mass.begin();
  for (std::size_t row = 0; row < mask.size(); ++row) mask[row] = mask[row] && piece[row] == largest;
  return mask;
}

/// Corners of elements, and particles as spheres of their spacing.
std::vector<Outer> outline(const Whole& whole, const BodyScene& bar, const std::vector<char>& mask) {
  const Matter& m = whole.matter;
  std::vector<Outer> points;
  const auto take = [&](const core::Vec3& x, double half) {
    const core::Vec3 d = x - bar.center;
    const double height = d.dot(bar.bar_axis);
    points.push_back({height, (d - height * bar.bar_axis).norm(), half});
  };
  for (std::size_t row = 0; row < mask.size(); ++row) {
    if (!mask[row]) continue;
    if (!whole.is_element(row))
      take(m.x[row], 0.5 * m.size[row]);
    else
      for (const auto nd : m.node[row]) take(m.node_x[static_cast<std::size_t>(nd)], 0);
  }
  return points;
}

template <class In>
std::optional<double> widest(const std::vector<Outer>& points, In&& in) {
  double radius = -1;
  for (const Outer& p : points)
    if (in(p)) radius = std::max(radius, p.radius + p.half);
  return radius < 0 ? std::nullopt : std::optional(2 * radius);
}

/// Diameter of the outline at a height: of what lies in a slice about it, or between the nearest slices that hold something, since
/// rows of nodes may be further apart.
std::optional<double> diameter_at(const std::vector<Outer>& points, double height, double length) {
  struct Known {
    double at, diameter;
  };
  std::optional<Known> below, above;
  constexpr int reach = 5;  // slices to either side
  for (int k = -reach; k <= reach; ++k) {
    const double at = height + k * slice * length;
    const auto d = widest(points, [&](const Outer& p) { return std::abs(p.height - at) < slice * length; });
    if (!d) continue;
    if (k <= 0) below = {at, *d};
    if (k >= 0 && !above) above = {at, *d};
  }
  if (!below || !above) return std::nullopt;
  if (below->at == above->at) return below->diameter;
  return below->diameter + (above->diameter - below->diameter) * (height - below->at) / (above->at - below->at);
}

}  // namespace

void measure_bar(const Whole& whole, const Scene& scene, int body, Result& result) {
  const BodyScene& bar = scene.bodies[static_cast<std::size_t>(body)];
  auto points = outline(whole, bar, largest_piece(whole, body));
  if (points.empty()) return;
  double foot = std::numeric_limits<double>::max(), radius = 0;
  for (const Outer& p : points) foot = std::min(foot, p.height - p.half), radius = std::max(radius, p.radius);
  double length = 0;
  for (Outer& p : points) {
    p.height -= foot;
    if (p.radius <= on_axis * radius) length = std::max(length, p.height + p.half);
  }
  add(result, bar.name + ".final_length", length, "m");
  if (const auto d = widest(points, [&](const Outer& p) { return p.height < at_foot * bar.extent.z(); })) add(result, bar.name + ".foot_diameter", *d, "m");
  if (const auto d = diameter_at(points, at_fifth * bar.extent.z(), bar.extent.z())) add(result, bar.name + ".diameter_at_fifth", *d, "m");
}

}  // namespace measure
