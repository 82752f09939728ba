// SPDX-License-Identifier: Apache-2.0
#include "sph/neighbourhood.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/box.hpp"
#include "core/cells.hpp"
#include "core/parallel.hpp"
#include "core/rows.hpp"
#include "sph/kernel.hpp"
#include "sph/pair_kernel.hpp"

namespace sph {

using core::Vec3;

/// Part of the reach that lists hold beyond it.
constexpr double skin = 0.25;
static_assert(1 + skin <= foreign_reaches, "whatever a list holds must be an actor when it is made");

/// The axis that a plane is normal to, -1 where it is oblique.
static int axis_of(const Mirror& m) {
  for (int d = 0; d < 3; ++d)
    if (std::abs(m.normal[d]) == 1) return d;
  return -1;
}

static core::Mat3 reflect(const Mirror& m, const core::Mat3& a) {
  core::Mat3 r = a;
  if (const int d = axis_of(m); d >= 0) {
    r.row(d) *= -1;
    r.col(d) *= -1;
    return r;
  }
  r = core::Mat3::Identity() - 2 * m.normal * m.normal.transpose();
  return r * a * r;
}

/// A symmetric tensor, xx yy zz xy yz zx.
template <class T>
static std::array<T, 6> reflect(const Mirror& m, const std::array<T, 6>& a) {
  core::Mat3 full;
  full << a[0], a[3], a[5], a[3], a[1], a[4], a[5], a[4], a[2];
  const Eigen::Matrix<T, 3, 3> r = reflect(m, full).template cast<T>();
  return {r(0, 0), r(1, 1), r(2, 2), r(0, 1), r(1, 2), r(2, 0)};
}

static Stress reflect(const Mirror& m, const Stress& a) {
  core::Mat3 full;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) full(r, c) = a.column[c][r];
  return stress_of(reflect(m, full));
}

void keep_in_front(const std::vector<Mirror>& mirrors, Particles& p) {
  for (const Mirror& m : mirrors) {
    if (m.wall) continue;
    core::for_each(p.size(), [&](std::size_t i) {
      if (!(m.normal.dot(p.x[i] - m.point) < 0)) return;
      p.x[i] = mirrored(m, p.x[i]);
      for (auto* v : {&p.v, &p.v_mean}) (*v)[i] = reflect(m, (*v)[i]);
      std::array<double, 6> s;
      for (std::size_t k = 0; k < 6; ++k) s[k] = p.pt.s[k][i];
      s = reflect(m, s);
      for (std::size_t k = 0; k < 6; ++k) p.pt.s[k][i] = s[k];
      const Vec3 &d = p.stretch[i], &g = p.shear[i];
      const std::array<double, 6> rate = reflect(m, std::array<double, 6>{d[0], d[1], d[2], g[0], g[1], g[2]});
      p.stretch[i] = {rate[0], rate[1], rate[2]}, p.shear[i] = {rate[3], rate[4], rate[5]};
    });
  }
}

/// A bin's displacements, and how much a smoothing length in it has grown.
struct Change {
  core::Box moved;
  double growth = 0;
};

bool still_valid(const Neighbourhood& hood, const std::vector<Vec3>& watched_x) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  if (hood.age * hood.far_speed > hood.far_path) return false;
  std::vector<Vec3> moved(hood.x_built.size());
  std::vector<Change> changes(hood.bin_start.size() - 1);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (i < n_real) {
      moved[i] = hood.actors.place[i].x - hood.x_built[i];
    } else {
      const Image& image = hood.images[i - n_real];
      moved[i] = reflect(hood.mirrors[image.mirror], moved[image.source]);
    }
    Change& bin = changes[hood.bin[i]];
    bin.moved.add(moved[i]);
    const std::size_t source = owner(hood, i);
    bin.growth = std::max(bin.growth, hood.actors.place[source].h - hood.h_built[source]);
  }
  for (std::size_t k = 0; k < watched_x.size(); ++k)
    changes[hood.bin[moved.size() + k]].moved.add(watched_x[k] - hood.watched_built[k]);
  for (std::size_t b = 0; b < changes.size(); ++b)
    for (auto k = hood.bin_start[b]; k < hood.bin_start[b + 1]; ++k) {
      const Change& other = changes[hood.bin_touching[k]];
      const double limit = 2 * hood.slack - changes[b].growth - other.growth;
      if (limit < 0 || changes[b].moved.apart(other.moved).squaredNorm() > limit * limit) return false;
    }
  return true;
}

/// Cubes of the given edge that hold actors, and which of them touch.
static void bin_actors(Neighbourhood& hood, double edge) {
  core::Cells bins;
  bins.reset(edge);
  hood.bin.clear();
  core::Cell last{};
  const auto put = [&](const Vec3& x) {  // mostly where the one before lies
    const core::Cell c = bins.cell(x);
    hood.bin.push_back(!hood.bin.empty() && c == last ? hood.bin.back() : bins.insert(c));
    last = c;
  };
  for (const Place& a : hood.actors.place) put(a.x);
  for (const Vec3& x : hood.watched_built) put(x);
  bins.tabulate();
  hood.bin_start.assign(1, 0);
  hood.bin_touching.clear();
  for (std::uint32_t b = 0; b < bins.size(); ++b) {
    const core::Cell& c = bins[b];
    for (std::int64_t i = -1; i <= 1; ++i)
      for (std::int64_t j = -1; j <= 1; ++j)
        for (std::int64_t k = -1; k <= 1; ++k)
          if (const auto found = bins.find({c[0] + i, c[1] + j, c[2] + k}); found != core::Cells::none) hood.bin_touching.push_back(found);
    hood.bin_start.push_back(static_cast<std::uint32_t>(hood.bin_touching.size()));
  }
}

/// One plane's images of everything there is so far, images of earlier planes included: corners mirror twice and thrice.
static void add_images(Neighbourhood& hood, std::uint32_t mirror, double reach) {
  const Mirror& plane = hood.mirrors[mirror];
  auto& place = hood.actors.place;
  const std::size_t n = place.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double distance = plane.normal.dot(place[i].x - plane.point);
    if (distance < reach && distance > -reach) {
      hood.images.push_back({static_cast<std::uint32_t>(i), mirror});
      place.push_back(place[i]);
    }
  }
}

/// 1 for particles, and for their images where there are foreigners; nothing where there are only particles.
static std::vector<std::uint8_t> wanted_rows(const Neighbourhood& hood) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  if (hood.actors.size() == hood.n_particles) return {};
  std::vector<std::uint8_t> wanted(hood.actors.size(), 0);
  std::fill_n(wanted.begin(), hood.n_particles, 1);
  if (hood.n_foreign > 0)
    for (std::size_t j = n_real; j < wanted.size(); ++j) wanted[j] = wanted[hood.images[j - n_real].source];
  return wanted;
}

/// Foreigners feel particles and their images only, and images feel nothing: from the rows of the first two, which are all
/// there are, come those of the foreigners, and those of the images go.
static void turn_rows(Neighbourhood& hood) {
  const std::size_t n = hood.n_particles, n_real = n + hood.n_foreign;
  std::vector<std::uint64_t>& start = hood.pairs.start;
  std::vector<std::uint32_t>& list = hood.pairs.list;
  if (hood.n_foreign == 0) return start.resize(n + 1);  // images have no rows then
  std::vector<std::uint64_t> row;
  std::vector<std::uint32_t> rows;
  core::sort_into_rows(
      hood.n_foreign,
      [&](auto&& put) {
        for (std::size_t j = 0; j + 1 < start.size(); ++j)
          for (std::uint64_t k = start[j]; k < start[j + 1]; ++k)
            if (list[k] >= n && list[k] < n_real) put(list[k] - n, static_cast<std::uint32_t>(j));
      },
      row, rows);
  for (auto& at : row) at += start[n];
  start.resize(n);
  start.insert(start.end(), row.begin(), row.end());
  list.resize(row[0]);
  list.insert(list.end(), rows.begin(), rows.end());
}

void build(Neighbourhood& hood, const std::vector<Vec3>& watched_x, double outside_speed) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  hood.actors.resize(n_real);
  hood.images.clear();
  double h_max = 0, h_min = 1e300, speed = outside_speed;
  for (std::size_t i = 0; i < n_real; ++i) {
    h_max = std::max(h_max, double(hood.actors.place[i].h));
    h_min = std::min(h_min, double(hood.actors.place[i].h));
    speed = std::max(speed, hood.actors.flow[i].v.norm());
  }
  const double reach = kernel_reach * h_max;
  hood.slack = 0.5 * skin * kernel_reach * h_min;
  // Beyond touching bins lies nothing nearer than a bin's edge, less what may still be inside a kernel's reach.
  hood.far_path = (watched_reaches - 1 - skin) * reach;
  hood.far_speed = 2 * 1.25 * speed;  // two that meet head on, both sped up a little meanwhile
  hood.age = 0;
  for (std::uint32_t k = 0; k < hood.mirrors.size(); ++k) add_images(hood, k, (1 + 2 * skin) * reach);
  hood.actors.resize(hood.actors.size());
  reflect_places(hood);
  hood.watched_built = watched_x;
  bin_actors(hood, watched_reaches * reach);

  std::vector<double> radius(hood.actors.size());
  hood.x_built.resize(hood.actors.size());
  hood.h_built.resize(hood.actors.size());
  for (std::size_t i = 0; i < radius.size(); ++i) {
    hood.x_built[i] = hood.actors.place[i].x;
    hood.h_built[i] = hood.actors.place[i].h;
    radius[i] = kernel_reach * hood.h_built[i] + 2 * hood.slack;
  }
  core::Octree tree;
  tree.build(hood.x_built);
  tree.neighbours(radius, true, hood.pairs, wanted_rows(hood));
  turn_rows(hood);
  hood.near_start.assign(n_real + 1, 0);
  hood.n_near.assign(n_real, 0);
  hood.mixed.resize(n_real);
  make_room(hood);
  hood.valid = true;
  ++hood.builds;
}

bool has_room(const Neighbourhood& hood) {
  for (std::size_t i = 0; i < hood.n_near.size(); ++i)
    if (hood.n_near[i] > group * (hood.near_start[i + 1] - hood.near_start[i])) return false;
  return true;
}

/// So many groups and one, so that rows without any have a place too; what they hold is lost.
template <class... Groups>
static void size_anew(std::size_t n_groups, Groups&... groups) {
  const std::size_t n = n_groups + 1;
  if (((n > groups.capacity()) || ...)) {
    core::free_all(groups...);  // first, so that old and new never take up room together
    (groups.reserve(n + n / 16), ...);
  }
  (groups.resize(n), ...);
}

void make_room(Neighbourhood& hood) {
  constexpr double near_part = 0.7;  // of a list, where it is long: a few more than there are, as a rule
  for (std::size_t i = 0; i < hood.n_near.size(); ++i) {
    const std::uint64_t listed = hood.pairs.start[i + 1] - hood.pairs.start[i], now = hood.n_near[i];
    const std::uint64_t most = std::min(listed, std::max(now + now / 8 + group / 2, static_cast<std::uint64_t>(near_part * static_cast<double>(listed)) + group));
    hood.near_start[i + 1] = hood.near_start[i] + (most + group - 1) / group;
  }
  size_anew(hood.near_start.back(), hood.near, hood.weight, hood.push);
}

void make_room_for_pull(Neighbourhood& hood) {
  hood.pull_start.resize(hood.n_particles);
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < hood.n_particles; ++i) {
    hood.pull_start[i] = n;
    if (hood.actors.kind[i] & tension_bit) n += (hood.n_near[i] + group - 1) / group;
  }
  size_anew(n, hood.pull);
}

/// f(image, source, mirror), mirror after mirror: an image of an image finds its source done.
template <class F>
static void each_image(const Neighbourhood& hood, F&& f) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  for (auto first = hood.images.begin(); first != hood.images.end();) {
    const auto last = std::upper_bound(first, hood.images.end(), first->mirror, [](std::uint32_t m, const Image& i) { return m < i.mirror; });
    const auto begin = static_cast<std::size_t>(first - hood.images.begin());
    const Mirror& mirror = hood.mirrors[first->mirror];
    core::for_each(static_cast<std::size_t>(last - first), [&](std::size_t k) { f(n_real + begin + k, hood.images[begin + k].source, mirror); });
    first = last;
  }
}

static Kind kind_of_image(const Mirror& m, Kind source) { return m.wall ? kind_of_body(wall_body) | (source & tension_bit) : source; }

void reflect_places(Neighbourhood& hood) {
  auto& place = hood.actors.place;
  each_image(hood, [&](std::size_t i, std::size_t s, const Mirror& m) {
    place[i] = place[s];
    place[i].x = mirrored(m, place[s].x);
    hood.actors.kind[i] = kind_of_image(m, hood.actors.kind[s]);
  });
}

void reflect_images(Neighbourhood& hood) {
  Actors& a = hood.actors;
  each_image(hood, [&](std::size_t i, std::size_t s, const Mirror& m) {
    a.flow[i] = a.flow[s];
    a.flow[i].v = reflect(m, a.flow[s].v);
    a.strain[i] = a.strain[s];
    if (a.kind[s] & firm_bit) a.strain[i].rate = reflect(m, a.strain[s].rate);
    a.stress[i] = reflect(m, a.stress[s]);
    if (a.kind[s] & tension_bit) a.artificial[i] = reflect(m, a.artificial[s]);
    a.kind[i] = kind_of_image(m, a.kind[s]);
    a.p_contact[i] = a.p_contact[s];
  });
}

void set_motion(Neighbourhood& hood, std::size_t i, const Vec3& v_new) {
  Motion& m = hood.actors.motion[i];
  for (int e = 0; e < 3; ++e) m.end[e] = v_new[e], m.sum[e] = hood.actors.flow[i].v[e] + v_new[e];
}

void reflect_velocities(Neighbourhood& hood) {
  each_image(hood, [&](std::size_t i, std::size_t s, const Mirror& m) {
    const double* const end = hood.actors.motion[s].end;
    set_motion(hood, i, reflect(m, Vec3(end[0], end[1], end[2])));
  });
}

}  // namespace sph
