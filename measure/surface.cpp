// SPDX-License-Identifier: Apache-2.0
// Surfaces of plates on grids. Voxels are half an element wide. One that a face or a sphere touches is solid, and the
// flood passes through sides of voxels only: so a gap is open when it is at least one element wide, elements that meet
// in an edge do not leak, and bent, stretched or flattened elements are closed however thin. Spheres block to three
// quarters of their spacing, which closes the gaps in a layer of particles that are bonded.
#include "measure/surface.hpp"

#include <algorithm>
#include <cmath>

#include "core/box.hpp"

namespace measure {
namespace {

using core::Box;
using core::Vec3;

constexpr double flat_tolerance = 0.02;       // of the thickness ...
constexpr double flat_tolerance_size = 0.1;   // ... and of the face's edge, whichever is smaller
constexpr double edge_begins = 0.97;          // of the half edges
constexpr double half_way = 0.5;              // from the middle to the edge
constexpr double voxel_of_element = 0.5;
constexpr double most_voxels = 12e6;
constexpr double samples_per_voxel = 2.5;
constexpr double blocking = 0.75;             // radius of a sphere that blocks, of its spacing
constexpr double off_lattice = 0.3719;        // shifts the grid off the planes of the mesh [voxels]
constexpr double gone = 0.1;                  // of the plate's area: what covers less of it is no plate any more

double edge_length(const Quad& q) { return std::sqrt(0.5 * (q.x[2] - q.x[0]).cross(q.x[3] - q.x[1]).norm()); }

bool is_flat(const Quad& q, const PlateFrame& frame, double displacement) {
  const Vec3 centre = 0.25 * (q.x[0] + q.x[1] + q.x[2] + q.x[3]);
  if (frame.rim(centre) > edge_begins) return true;
  const double tolerance = std::min(flat_tolerance * frame.thickness, flat_tolerance_size * edge_length(q));
  const auto on = [&](double w) {
    return std::all_of(q.x.begin(), q.x.end(), [&](const Vec3& x) { return std::abs(x.z() - w) <= tolerance; });
  };
  return on(displacement + frame.half.z()) || on(displacement - frame.half.z());
}

/// Calls f(i, j) for every marked column that `start` is connected to by sides, itself included, and takes the marks away.
template <class F>
void take_patch(const Columns& columns, std::size_t start, std::vector<char>& marked, F&& f) {
  std::vector<std::size_t> todo;
  const auto visit = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= columns.n[0] || j >= columns.n[1]) return;
    const std::size_t k = columns.index(i, j);
    if (marked[k]) marked[k] = 0, todo.push_back(k);
  };
  const auto column = [&](std::size_t k, int axis) { return static_cast<int>(axis == 0 ? k % columns.n[0] : k / columns.n[0]); };
  visit(column(start, 0), column(start, 1));
  while (!todo.empty()) {
    const int i = column(todo.back(), 0), j = column(todo.back(), 1);
    todo.pop_back();
    f(i, j);
    visit(i - 1, j), visit(i + 1, j), visit(i, j - 1), visit(i, j + 1);
  }
}

/// Grid of voxels over a window; marks and floods them.
class Voxels {
 public:
  Voxels(const Window& window, double low, double high) {
    double h = voxel_of_element * window.size;
    const double depth = high - low;
    for (;; h *= 1.1) {
      columns_ = columns_over(window, h);
      layers_ = static_cast<int>(std::ceil(depth / h)) + 4;
      if (static_cast<double>(columns_.size()) * layers_ <= most_voxels) break;
    }
    bottom_ = low - (1 + off_lattice) * h;
    solid_.assign(columns_.size() * layers_, 0);
  }
  const Columns& columns() const { return columns_; }

  void mark(const Quad& q) {
    const double step = columns_.h / samples_per_voxel;
    const double across = std::max((q.x[1] - q.x[0]).norm(), (q.x[2] - q.x[3]).norm());
    const double along = std::max((q.x[3] - q.x[0]).norm(), (q.x[2] - q.x[1]).norm());
    const int n = static_cast<int>(across / step) + 1, m = static_cast<int>(along / step) + 1;
    for (int i = 0; i <= n; ++i) {
      const double a = static_cast<double>(i) / n;
      const Vec3 p = q.x[0] + a * (q.x[1] - q.x[0]), r = q.x[3] + a * (q.x[2] - q.x[3]);
      for (int j = 0; j <= m; ++j) mark_point(p + (static_cast<double>(j) / m) * (r - p));
    }
  }

  void mark(const Sphere& s) {
    const double radius = blocking * s.spacing, touch = radius + 0.25 * columns_.h;
    int a[3], b[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = std::max(0, cell(k, s.x[k] - radius));
      b[k] = std::min(count(k) - 1, cell(k, s.x[k] + radius));
    }
    for (int l = a[2]; l <= b[2]; ++l)
      for (int j = a[1]; j <= b[1]; ++j)
        for (int i = a[0]; i <= b[0]; ++i) {
          const Vec3 x(columns_.x(0, i), columns_.x(1, j), bottom_ + (l + 0.5) * columns_.h);
          if ((x - s.x).squaredNorm() <= touch * touch) solid_[index(i, j, l)] = 1;
        }
    mark_point(s.x);
  }

  /// Fills columns without material that lie open to the side: beyond the edge of a plate that has moved or is drawn in. No plate that holds
  /// together moves as far as half-way to its middle: there it is gone.
  void close_outside(const PlateFrame& frame) {
    std::vector<char> empty(columns_.size(), 1);
    for (int j = 0; j < count(1); ++j)
      for (int i = 0; i < count(0); ++i)
        if (frame.rim({columns_.x(0, i), columns_.x(1, j), 0}) < half_way) empty[columns_.index(i, j)] = 0;
    for (std::size_t k = 0; k < solid_.size(); ++k)
      if (solid_[k] != 0) empty[k % columns_.size()] = 0;
    for (int j = 0; j < count(1); ++j)
      for (int i = 0; i < count(0); ++i)
        if (i == 0 || j == 0 || i == count(0) - 1 || j == count(1) - 1)
          take_patch(columns_, columns_.index(i, j), empty, [&](int a, int c) {
            for (int l = 0; l < layers_; ++l) solid_[index(a, c, l)] = 1;
          });
  }

  /// Marks with 2 what the front side is connected to. True where that reaches the back side.
  bool flood() {
    std::vector<std::uint32_t> todo;
    const auto visit = [&](int i, int j, int l) {
      if (i < 0 || j < 0 || l < 0 || i >= count(0) || j >= count(1) || l >= layers_) return;
      const std::size_t k = index(i, j, l);
      if (solid_[k] != 0) return;
      solid_[k] = 2;
      todo.push_back(static_cast<std::uint32_t>(k));
    };
    for (int j = 0; j < count(1); ++j)
      for (int i = 0; i < count(0); ++i) visit(i, j, layers_ - 1);
    while (!todo.empty()) {
      const std::size_t k = todo.back();
      todo.pop_back();
      const int i = static_cast<int>(k % columns_.n[0]), j = static_cast<int>(k / columns_.n[0] % columns_.n[1]);
      const int l = static_cast<int>(k / columns_.size());
      visit(i - 1, j, l), visit(i + 1, j, l);
      visit(i, j - 1, l), visit(i, j + 1, l);
      visit(i, j, l - 1), visit(i, j, l + 1);
    }
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (solid_[c] == 2) return true;
    return false;
  }

  std::vector<char> open_columns() const {
    std::vector<char> open(columns_.size(), 1);
    for (std::size_t k = 0; k < solid_.size(); ++k)
      if (solid_[k] == 1) open[k % columns_.size()] = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (solid_[c] != 2) open[c] = 0;
    return open;
  }

  std::vector<char> flooded_in(const Middle& middle) const {
    std::vector<char> open(columns_.size(), 0);
    for (int j = 0; j < count(1); ++j)
      for (int i = 0; i < count(0); ++i) {
        const int l = std::clamp(cell(2, middle.at(columns_.x(0, i), columns_.x(1, j))), 0, layers_ - 1);
        open[columns_.index(i, j)] = solid_[index(i, j, l)] == 2;
      }
    return open;
  }

 private:
  int count(int axis) const { return axis < 2 ? columns_.n[axis] : layers_; }
  int cell(int axis, double x) const {
    return axis < 2 ? columns_.cell(axis, x) : static_cast<int>(std::floor((x - bottom_) / columns_.h));
  }
  std::size_t index(int i, int j, int l) const { return columns_.index(i, j) + l * columns_.size(); }
  void mark_point(const Vec3& x) {
    const int i = cell(0, x[0]), j = cell(1, x[1]), l = cell(2, x[2]);
    if (i >= 0 && j >= 0 && l >= 0 && i < count(0) && j < count(1) && l < layers_) solid_[index(i, j, l)] = 1;
  }

  Columns columns_;
  int layers_ = 0;
  double bottom_ = 0;
  std::vector<char> solid_;  // 0 empty, 1 touched, 2 empty and connected to the front side
};

bool touches(const Window& window, const Vec3& low, const Vec3& high) {
  for (int k = 0; k < 2; ++k)
    if (high[k] < window.low[k] || low[k] > window.high[k]) return false;
  return true;
}

Box box_of(const Quad& q) {
  Box box;
  for (const Vec3& x : q.x) box.add(x);
  return box;
}
Box box_of(const Sphere& s) {
  const Vec3 r = Vec3::Constant(blocking * s.spacing);
  return {s.x - r, s.x + r};
}

/// f(piece) for every quad and sphere of the surface that lies over the window.
template <class F>
void each_over(const Surface& surface, const Window& window, F&& f) {
  const auto visit = [&](const auto& piece) {
    const Box box = box_of(piece);
    if (touches(window, box.low, box.high)) f(piece);
  };
  for (const Quad& q : surface.quads) visit(q);
  for (const Sphere& s : surface.spheres) visit(s);
}

/// The columns from `low` to `high` along one axis, clamped to the grid; empty where they miss it.
std::array<int, 2> column_range(const Columns& c, int axis, double low, double high) {
  const double a = std::ceil((low - c.low[axis]) / c.h - 0.5 - 1e-9), b = std::floor((high - c.low[axis]) / c.h - 0.5 + 1e-9);
  return {static_cast<int>(std::clamp(a, 0.0, static_cast<double>(c.n[axis]))),
          static_cast<int>(std::clamp(b, -1.0, c.n[axis] - 1.0))};
}

void raise_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Columns& columns, std::vector<double>& height) {
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
  if (area == 0) return;
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const auto [i0, i1] = column_range(columns, 0, low.x(), high.x());
  const auto [j0, j1] = column_range(columns, 1, low.y(), high.y());
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const double x = columns.x(0, i) - a.x(), y = columns.x(1, j) - a.y();
      const double s = (x * (c.y() - a.y()) - (c.x() - a.x()) * y) / area;
      const double t = ((b.x() - a.x()) * y - x * (b.y() - a.y())) / area;
      if (s < -1e-9 || t < -1e-9 || s + t > 1 + 1e-9) continue;
      double& w = height[columns.index(i, j)];
      w = std::max(w, a.z() + s * (b.z() - a.z()) + t * (c.z() - a.z()));
    }
}

void raise_sphere(const Sphere& sphere, const Columns& columns, std::vector<double>& height) {
  const double reach = blocking * sphere.spacing, r2 = 0.25 * sphere.spacing * sphere.spacing;
  const auto [i0, i1] = column_range(columns, 0, sphere.x.x() - reach, sphere.x.x() + reach);
  const auto [j0, j1] = column_range(columns, 1, sphere.x.y() - reach, sphere.x.y() + reach);
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const double x = columns.x(0, i) - sphere.x.x(), y = columns.x(1, j) - sphere.x.y(), d2 = x * x + y * y;
      if (d2 > reach * reach) continue;
      double& w = height[columns.index(i, j)];
      w = std::max(w, sphere.x.z() + std::sqrt(std::max(0.0, r2 - d2)));
    }
}

}  // namespace

Surface surface_of(const Whole& whole, const PlateFrame& frame, int body, std::span<const char> members) {
  const Matter& m = whole.matter;
  Surface surface;
  const auto inside = [&](std::int32_t el) { return el >= 0 && m.body[el] == body && members[el]; };
  for (const Face& face : whole.faces) {
    if (inside(face.a) == inside(face.b)) continue;
    Quad q;
    for (int a = 0; a < 4; ++a) q.x[a] = frame.local(m.node_x[face.node[a]]);
    q.flat = is_flat(q, frame, whole.rims[body].displacement);
    surface.quads.push_back(q);
  }
  for (std::size_t row = m.n_elements; row < whole.size(); ++row)
    if (m.body[row] == body && members[row]) surface.spheres.push_back({frame.local(m.x[row]), m.size[row]});
  return surface;
}

Window disturbed_window(const Surface& surface, const PlateFrame& frame) {
  Box box;
  std::vector<double> sizes;
  const auto include = [&](const Box& piece, double size) {
    box.add(piece);
    sizes.push_back(size);
  };
  for (const Quad& q : surface.quads)
    if (!q.flat) include(box_of(q), edge_length(q));
  for (const Sphere& s : surface.spheres) include(box_of(s), s.spacing);
  Window window;
  if (sizes.empty()) return window;
  const auto typical = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), typical, sizes.end());
  window.exists = *typical > 0;
  window.size = *typical;
  for (int k = 0; k < 2; ++k) {
    window.low[k] = std::max(box.low[k] - window.size, -edge_begins * frame.half[k]);
    window.high[k] = std::min(box.high[k] + window.size, edge_begins * frame.half[k]);
    window.exists = window.exists && window.high[k] > window.low[k];
  }
  return window;
}

Columns columns_over(const Window& window, double h) {
  Columns c;
  c.h = h;
  for (int k = 0; k < 2; ++k) {
    c.low[k] = window.low[k] - off_lattice * h;
    c.n[k] = static_cast<int>((window.high[k] - c.low[k]) / h) + 1;
  }
  return c;
}

double Middle::at(double x, double y) const {
  if (height.empty()) return 0;
  const double place[2] = {x, y};
  int k[2];
  double part[2];
  for (int a = 0; a < 2; ++a) {
    const double u = std::clamp((place[a] - columns.low[a]) / columns.h - 0.5, 0.0, columns.n[a] - 1.0);
    k[a] = std::min(static_cast<int>(u), std::max(0, columns.n[a] - 2));
    part[a] = u - k[a];
  }
  const auto h = [&](int i, int j) { return height[columns.index(std::min(i, columns.n[0] - 1), std::min(j, columns.n[1] - 1))]; };
  const double near = (1 - part[0]) * h(k[0], k[1]) + part[0] * h(k[0] + 1, k[1]);
  const double far = (1 - part[0]) * h(k[0], k[1] + 1) + part[0] * h(k[0] + 1, k[1] + 1);
  return (1 - part[1]) * near + part[1] * far;
}

Middle middle_of(const Surface& surface, const Window& window, double edge) {
  Middle middle;
  if (!window.exists) return middle;
  middle.columns = columns_over(window, std::max({edge, (window.high[0] - window.low[0]) / 1000, (window.high[1] - window.low[1]) / 1000}));
  const Columns& c = middle.columns;
  std::vector<double> area(c.size(), 0), moment(c.size(), 0);
  for (const Quad& q : surface.quads) {
    const Vec3 centre = 0.25 * (q.x[0] + q.x[1] + q.x[2] + q.x[3]);
    const int i = c.cell(0, centre.x()), j = c.cell(1, centre.y());
    if (i < 0 || j < 0 || i >= c.n[0] || j >= c.n[1]) continue;
    const double a = 0.5 * std::abs((q.x[2] - q.x[0]).cross(q.x[3] - q.x[1]).z());
    area[c.index(i, j)] += a;
    moment[c.index(i, j)] += a * centre.z();
  }
  // squares without any take the mean of those around them, from the rim of the gap inwards
  middle.height.assign(c.size(), 0);
  std::vector<char> known(c.size(), 0);
  for (std::size_t k = 0; k < c.size(); ++k)
    if (area[k] > 0) middle.height[k] = moment[k] / area[k], known[k] = 1;
  for (bool more = true; more;) {
    more = false;
    const std::vector<char> before = known;
    for (int j = 0; j < c.n[1]; ++j)
      for (int i = 0; i < c.n[0]; ++i) {
        if (before[c.index(i, j)]) continue;
        double sum = 0;
        int n = 0;
        c.each_around(i, j, [&](std::size_t k) {
          if (before[k]) sum += middle.height[k], ++n;
        });
        if (n == 0) continue;
        middle.height[c.index(i, j)] = sum / n;
        known[c.index(i, j)] = 1;
        more = true;
      }
  }
  return middle;
}

Patch largest_patch(const Columns& columns, std::span<const char> marked) {
  Patch best;
  std::vector<char> left(marked.begin(), marked.end());
  for (std::size_t start = 0; start < left.size(); ++start) {
    if (!left[start]) continue;
    Patch patch;
    take_patch(columns, start, left, [&](int i, int j) {
      ++patch.n_columns;
      patch.center[0] += columns.x(0, i), patch.center[1] += columns.x(1, j);
    });
    for (double& x : patch.center) x /= static_cast<double>(patch.n_columns);
    if (patch.n_columns > best.n_columns) best = patch;
  }
  return best;
}

/// The window with the plate's edge and what is beyond, on the sides where it comes near the edge: there what still stands of the
/// edge closes the opening in its middle.
static Window with_edges(Window window, const Surface& surface, const PlateFrame& frame) {
  Box all;
  for (const Quad& q : surface.quads) all.add(box_of(q));
  for (const Sphere& s : surface.spheres) all.add(box_of(s));
  for (int k = 0; k < 2; ++k) {
    if (window.low[k] <= -edge_begins * frame.half[k]) window.low[k] = all.low[k] - window.size;
    if (window.high[k] >= edge_begins * frame.half[k]) window.high[k] = all.high[k] + window.size;
  }
  return window;
}

/// The part of a plate's area, seen along its normal, that what is left of it covers at most.
static double covered_part(const Surface& surface, const PlateFrame& frame) {
  double area = 0;
  for (const Quad& q : surface.quads)  // above and below
    if (frame.rim(0.25 * (q.x[0] + q.x[1] + q.x[2] + q.x[3])) <= 1) area += 0.25 * std::abs((q.x[2] - q.x[0]).cross(q.x[3] - q.x[1]).z());
  for (const Sphere& s : surface.spheres)
    if (frame.rim(s.x) <= 1) area += s.spacing * s.spacing;
  return area / (4 * frame.half.x() * frame.half.y());
}

Opening find_opening(const Surface& surface, const Window& disturbed, const PlateFrame& frame) {
  Opening opening;
  opening.through = covered_part(surface, frame) < gone;
  if (opening.through || !disturbed.exists) return opening;
  const Window window = with_edges(disturbed, surface, frame);
  double low = 1e300, high = -1e300;
  each_over(surface, window, [&](const auto& piece) {
    const Box box = box_of(piece);
    low = std::min(low, box.low.z()), high = std::max(high, box.high.z());
  });
  if (high < low) return opening;
  Voxels voxels(window, low, high);
  each_over(surface, window, [&](const auto& piece) { voxels.mark(piece); });
  voxels.close_outside(frame);
  opening.through = voxels.flood();
  if (!opening.through) return opening;
  opening.seen = largest_patch(voxels.columns(), voxels.open_columns());
  opening.bent = middle_of(surface, window, frame.thickness);
  opening.middle = largest_patch(voxels.columns(), voxels.flooded_in(opening.bent));
  return opening;
}

std::vector<double> front_heights(const Surface& surface, const Columns& columns) {
  std::vector<double> height(columns.size(), no_height);
  for (const Quad& q : surface.quads) {
    raise_triangle(q.x[0], q.x[1], q.x[2], columns, height);
    raise_triangle(q.x[0], q.x[2], q.x[3], columns, height);
  }
  for (const Sphere& s : surface.spheres) raise_sphere(s, columns, height);
  return height;
}

}  // namespace measure
