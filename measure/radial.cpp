// SPDX-License-Identifier: Apache-2.0
// First hits of rays. Of a face seen along the normal only its edges can be the first thing that a ray meets. A sphere
// stands as a disc of half its spacing; out to three quarters of its spacing it still stops a ray, at the distance of its
// centre, so that no ray slips through between two bonded particles.
#include "measure/radial.hpp"

#include <algorithm>
#include <cmath>

namespace measure {
namespace {

using core::Vec3;

constexpr double ray_step = 2 * core::pi / n_rays;
constexpr double stopping = 0.75;  // half-width of the shadow of a sphere, of its spacing
constexpr double infinite = 1e300;

struct Rays {
  std::array<double, n_rays> cosine, sine;
  Rays() {
    for (int j = 0; j < n_rays; ++j) cosine[j] = std::cos(ray_azimuth(j)), sine[j] = std::sin(ray_azimuth(j));
  }
};
const Rays rays;

/// f(ray) for the rays with azimuth in [from, to], to - from < 2 pi.
template <class F>
void each_ray(double from, double to, F&& f) {
  const int first = static_cast<int>(std::ceil(from / ray_step - 0.5));
  const int last = static_cast<int>(std::floor(to / ray_step - 0.5));
  for (int j = first; j <= last; ++j) f(((j % n_rays) + n_rays) % n_rays);
}

void hit_edge(const Vec3& p, const Vec3& q, const Band& band, std::array<double, n_rays>& radius) {
  const double cross = p.x() * q.y() - p.y() * q.x();
  if (cross == 0) return;  // along a ray: its ends belong to other edges
  double from = std::atan2(p.y(), p.x()), to = std::atan2(q.y(), q.x());
  if (cross < 0) std::swap(from, to);
  if (to < from) to += 2 * core::pi;
  const Vec3 d = q - p;
  each_ray(from, to, [&](int j) {
    const double along = d.x() * rays.sine[j] - d.y() * rays.cosine[j];
    if (along == 0) return;
    const double t = std::clamp((p.y() * rays.cosine[j] - p.x() * rays.sine[j]) / along, 0.0, 1.0);
    const Vec3 x = p + t * d;
    if (x.z() < band.low[j] || x.z() > band.high[j]) return;
    radius[j] = std::min(radius[j], std::max(0.0, x.x() * rays.cosine[j] + x.y() * rays.sine[j]));
  });
}

void hit_sphere(const Vec3& x, double spacing, const Band& band, std::array<double, n_rays>& radius) {
  const double distance = std::hypot(x.x(), x.y()), half = 0.5 * spacing, shadow = stopping * spacing;
  const double azimuth = std::atan2(x.y(), x.x());
  const double spread = distance > shadow ? std::asin(shadow / distance) : core::pi * (1 - 1e-12);
  each_ray(azimuth - spread, azimuth + spread, [&](int j) {
    if (x.z() + half < band.low[j] || x.z() - half > band.high[j]) return;
    const double along = x.x() * rays.cosine[j] + x.y() * rays.sine[j];
    const double aside = x.y() * rays.cosine[j] - x.x() * rays.sine[j];
    const double depth = std::sqrt(std::max(0.0, half * half - aside * aside));
    if (along + depth >= 0) radius[j] = std::min(radius[j], std::max(0.0, along - depth));
  });
}

/// Moves the centre to the centroid of the opening; returns how far.
double recentre(InnerEdge& edge) {
  double area = 0, x = 0, y = 0;
  for (int j = 0; j < n_rays; ++j) {
    const double r = edge.radius[j];
    if (r >= infinite) return 0;
    area += 0.5 * r * r;
    x += r * r * r / 3 * rays.cosine[j];
    y += r * r * r / 3 * rays.sine[j];
  }
  if (area <= 0) return 0;
  edge.center[0] += x / area;
  edge.center[1] += y / area;
  return std::hypot(x, y) / area;
}

}  // namespace

double ray_azimuth(int ray) { return (ray + 0.5) * ray_step; }

Band Band::everything() { return about(0, infinite); }
Band Band::about(double w, double half) {
  Band band;
  band.low.fill(w - half);
  band.high.fill(w + half);
  return band;
}

bool InnerEdge::exists() const {
  return 2 * std::count_if(radius.begin(), radius.end(), [](double r) { return r < infinite; }) >= n_rays;
}

/// f(distance) for the lines through the centre that meet material on both sides; returns how many they are.
template <class F>
static int each_diameter(const InnerEdge& edge, F&& f) {
  int n = 0;
  for (int j = 0; j < n_rays / 2; ++j) {
    const double one = edge.radius[j], other = edge.radius[j + n_rays / 2];
    if (one < infinite && other < infinite) f(one + other), ++n;
  }
  return n;
}

double InnerEdge::mean_diameter() const {
  double sum = 0;
  if (const int n = each_diameter(*this, [&](double d) { sum += d; }); n > 0) return sum / n;
  int n = 0;
  for (const double r : radius)
    if (r < infinite) sum += r, ++n;
  return n > 0 ? 2 * sum / n : 0;
}

std::array<double, 2> InnerEdge::extreme_diameters() const {
  std::array<double, 2> d{infinite, 0};
  each_diameter(*this, [&](double across) { d = {std::min(d[0], across), std::max(d[1], across)}; });
  if (d[1] < d[0]) d.fill(mean_diameter());
  return d;
}

Edges edges_of(const Surface& surface) {
  Edges edges;
  for (const Quad& q : surface.quads)
    if (!q.flat)
      for (int a = 0; a < 4; ++a) edges.push_back({q.x[a], q.x[(a + 1) % 4]});
  return edges;
}

Edges cut_at(const Surface& surface, const Middle& middle, double w) {
  Edges edges;
  const auto above = [&](const Vec3& x) { return x.z() - middle.at(x.x(), x.y()) - w; };
  const auto cut_triangle = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    std::array<Vec3, 3> x{a, b, c}, cut;
    int n = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 &p = x[k], &q = x[(k + 1) % 3];
      const double a_p = above(p), a_q = above(q);
      if ((a_p < 0) != (a_q < 0)) cut[n++] = p + a_p / (a_p - a_q) * (q - p);
    }
    if (n == 2) edges.push_back({cut[0], cut[1]});
  };
  for (const Quad& q : surface.quads) {
    cut_triangle(q.x[0], q.x[1], q.x[2]);
    cut_triangle(q.x[0], q.x[2], q.x[3]);
  }
  return edges;
}

std::vector<Sphere> cut_spheres(const Surface& surface, const Middle& middle, double w) {
  std::vector<Sphere> cut;
  for (const Sphere& s : surface.spheres)
    if (std::abs(s.x.z() - middle.at(s.x.x(), s.x.y()) - w) <= 0.5 * s.spacing) cut.push_back(s);
  return cut;
}

InnerEdge inner_edge(const Edges& edges, std::span<const Sphere> spheres, const Band& band, const double center[2]) {
  InnerEdge edge;
  edge.center[0] = center[0], edge.center[1] = center[1];
  edge.radius.fill(infinite);
  const Vec3 origin(center[0], center[1], 0);
  for (const auto& [p, q] : edges) hit_edge(p - origin, q - origin, band, edge.radius);
  for (const Sphere& s : spheres) hit_sphere(s.x - origin, s.spacing, band, edge.radius);
  return edge;
}

InnerEdge centred_inner_edge(const Edges& edges, std::span<const Sphere> spheres, const Band& band,
                             const double guess[2]) {
  constexpr int most_iterations = 15;
  constexpr double tolerance = 1e-4;  // of the diameter
  InnerEdge edge = inner_edge(edges, spheres, band, guess);
  for (int k = 0; k < most_iterations && edge.exists(); ++k) {
    InnerEdge next = edge;
    const double moved = recentre(next);
    if (moved <= tolerance * edge.mean_diameter()) break;
    next = inner_edge(edges, spheres, band, next.center);
    if (next.mean_diameter() < 0.5 * edge.mean_diameter()) break;  // the centroid lies outside a crooked opening
    edge = next;
  }
  return edge;
}

}  // namespace measure
