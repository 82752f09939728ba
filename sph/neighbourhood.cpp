// SPDX-License-Identifier: Apache-2.0
#include "sph/neighbourhood.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "sph/kernel.hpp"

namespace sph {

using core::Vec3;

/// Part of the reach that lists hold beyond it.
constexpr double skin = 0.1;

bool still_valid(const Neighbourhood& hood, const std::vector<Vec3>& particle_x, const std::vector<Vec3>& foreign_x) {
  const std::size_t n = particle_x.size();
  if (!hood.valid || hood.n_particles != n || hood.n_foreign != foreign_x.size()) return false;
  const double limit = hood.slack * hood.slack;
  const auto moved = [&](std::size_t i) {
    const Vec3& x = i < n ? particle_x[i] : foreign_x[i - n];
    return -(x - hood.x_built[i]).squaredNorm();
  };
  return -core::min_where(n + foreign_x.size(), moved).value <= limit;
}

/// One plane's images of everything there is so far, images of earlier planes included: corners mirror twice and thrice.
static void add_images(Neighbourhood& hood, std::uint32_t mirror, double reach) {
  const Mirror& plane = hood.mirrors[mirror];
  const std::size_t n = hood.actors.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double distance = plane.normal.dot(hood.actors[i].x - plane.point);
    if (distance < reach && distance > -reach) {
      hood.images.push_back({static_cast<std::uint32_t>(i), mirror});
      hood.actors.push_back(hood.actors[i]);
    }
  }
}

void build(Neighbourhood& hood) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  hood.actors.resize(n_real);
  hood.images.clear();
  double h_max = 0, h_min = 1e300;
  for (const Actor& a : hood.actors) {
    h_max = std::max(h_max, a.h);
    h_min = std::min(h_min, a.h);
  }
  hood.slack = 0.5 * skin * kernel_reach * h_min;
  for (std::uint32_t k = 0; k < hood.mirrors.size(); ++k) add_images(hood, k, kernel_reach * h_max * (1 + skin));
  reflect_images(hood);

  std::vector<Vec3> x(hood.actors.size());
  std::vector<double> radius(hood.actors.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = hood.actors[i].x;
    radius[i] = kernel_reach * hood.actors[i].h + 2 * hood.slack;
  }
  core::Octree tree;
  tree.build(x);
  tree.neighbours(radius, true, hood.pairs);
  hood.x_built.assign(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n_real));
  hood.valid = true;
  ++hood.builds;
}

static Vec3 reflect(const Mirror& m, const Vec3& a) { return a - 2 * m.normal.dot(a) * m.normal; }

static core::Mat3 reflect(const Mirror& m, const core::Mat3& a) {
  const core::Mat3 r = core::Mat3::Identity() - 2 * m.normal * m.normal.transpose();
  return r * a * r;
}

void reflect_images(Neighbourhood& hood) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  // In order: an image of an image finds its source done.
  for (std::size_t k = 0; k < hood.images.size(); ++k) {
    const Mirror& m = hood.mirrors[hood.images[k].mirror];
    const Actor& s = hood.actors[hood.images[k].source];
    Actor a = s;
    a.x = m.point + reflect(m, Vec3(s.x - m.point));
    a.v = reflect(m, s.v);
    a.v_new = reflect(m, s.v_new);
    a.v_mean = reflect(m, s.v_mean);
    a.stress = reflect(m, s.stress);
    if (s.in_tension) a.artificial = reflect(m, s.artificial);
    if (m.wall) a.body = -1;  // pushes whatever comes, holds nothing
    hood.actors[n_real + k] = a;
  }
}

void reflect_velocities(Neighbourhood& hood) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  for (std::size_t k = 0; k < hood.images.size(); ++k) {
    const Mirror& m = hood.mirrors[hood.images[k].mirror];
    const Actor& s = hood.actors[hood.images[k].source];
    hood.actors[n_real + k].v_new = reflect(m, s.v_new);
    hood.actors[n_real + k].v_mean = reflect(m, s.v_mean);
  }
}

}  // namespace sph
