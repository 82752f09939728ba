// SPDX-License-Identifier: Apache-2.0
// Structured meshes on an integer lattice. Sphere and cylinder (an O-grid): of the lattice [-c - m, c + m]^d the cells
// that leave the core [-c, c] along at most one axis; a point beyond the core is in layer l = 1..m of a cap, and points
// of two or three caps that meet on an edge or a corner of the core are one point (weld()). A smooth map takes each
// block to space, so that det J within an element tends to a constant as the mesh is refined. With coordinates scaled
// to [0, 1] over half a block and the sphere's radius to 1:
//   core    x = u F(u^2, v^2, w^2), y = v F(v^2, w^2, u^2), z = w F(w^2, u^2, v^2), F a polynomial symmetric in its
//   last
//           two arguments: invariant under every symmetry of the cube, 0 exactly on its planes
//   cap z   (1 - t) core(u, v, 1) + t s / |s| + t (1 - t) (b + (2 t - 1) b') d, where s and d are (T(u, v), T(v, u), 1)
//   with
//           T(u, v) = u (1 + (1 - u^2) P(u^2, v^2)), so that T(1, v) = 1 and neighbouring caps agree on u = 1
// and the same in the plane. The coefficients were fitted, as linear functions of c / (c + m) - 1/2, to make the
// smallest of edges and of volume / largest face as large as it gets, for n_across from 6 to 48, with angles above 1
// rad and the largest edges and det J ratios held down (the time step of a run hangs on the smallest element).
#include "fem/generate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "fem/hex8.hpp"

namespace fem {
namespace {

using core::Vec3;
using Lattice = std::array<int, 3>;

constexpr int corner_offset[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// A coefficient of the map: its value for equally many core and cap elements on a radius, and its slope against
/// core / (core + cap) - 1/2.
struct Coefficient {
  double value, slope;
};

template <std::size_t n>
std::array<double, n> evaluate(const Coefficient (&c)[n], double slope_by) {
  std::array<double, n> r;
  for (std::size_t i = 0; i < n; ++i) r[i] = c[i].value + slope_by * c[i].slope;
  return r;
}

// F, then P of s, b, b', and P of d, each in ascending powers as SphereMap spells them out.
constexpr Coefficient sphere_core[] = {
    {0.50207, 1.10522}, {0.00562, -0.27735}, {-0.13303, -0.57337}, {0.02195, 0.21499},   {0.03435, 0.00623},
    {0.04266, 0.15579}, {0.04235, 0.19119},  {-0.09126, 0.15007},  {-0.03660, -0.04345}, {0.07103, -0.02567}};
constexpr Coefficient sphere_surface[] = {
    {-0.10370, -0.04003}, {0.13276, -0.28121}, {0.14035, 0.24366}, {-0.11536, -0.01707}};
constexpr Coefficient sphere_bulge[] = {
    {-0.02844, -0.04381}, {0.05958, 0.06525}, {-0.03489, -0.09805}, {-0.02411, -0.03037}};
constexpr Coefficient sphere_skew[] = {
    {-0.06811, 0.07510}, {0.04936, -0.12097}, {-0.08487, 0.13977}, {0.02243, 0.07523}};
constexpr Coefficient sphere_lean[] = {
    {-0.05377, -0.19594}, {-0.11469, -0.03899}, {-0.32483, 0.13609}, {0.02427, -0.15195}};

// The same for the circle, as CircleMap spells them out.
constexpr Coefficient circle_core[] = {{0.52399, 0.71476},   {0.04150, 0.48022},  {-0.29364, -0.78482},
                                       {-0.03932, -0.33174}, {0.04432, -0.17963}, {0.19503, 0.73251},
                                       {0.07146, 0.56194},   {-0.13173, -0.52808}};
constexpr Coefficient circle_surface[] = {{-0.19115, 0.40441}, {-0.03360, 1.29369}};
constexpr Coefficient circle_bulge[] = {{-0.00529, 0.10042}, {0.08136, -0.33004}, {-0.07283, 0.19246}};
constexpr Coefficient circle_skew[] = {{0.00236, 0.00344}, {-0.05892, 0.28909}, {0.05649, -0.28680}};
constexpr Coefficient circle_lean[] = {{-0.34086, -0.10300}, {-0.93185, 0.63692}};

/// Elements on a radius: in the core and in a cap. About as many in one as in the other: a larger core makes short
/// edges at its corners, a smaller one long edges on the surface.
struct Radius {
  int core, cap;
  int total() const { return core + cap; }
  double off_half() const { return static_cast<double>(core) / total() - 0.5; }
};

Radius split_radius(int n_across) {
  const int half = std::max(2, n_across / 2 + n_across % 2);
  return {(half + 1) / 2, half / 2};
}

/// The map of one eighth of the unit sphere; u, v, w, t in [0, 1].
class SphereMap {
 public:
  explicit SphereMap(Radius r)
      : core_(evaluate(sphere_core, r.off_half())),
        surface_(evaluate(sphere_surface, r.off_half())),
        bulge_(evaluate(sphere_bulge, r.off_half())),
        skew_(evaluate(sphere_skew, r.off_half())),
        lean_(evaluate(sphere_lean, r.off_half())) {}

  Vec3 core(double u, double v, double w) const {
    const double uu = u * u, vv = v * v, ww = w * w;
    return {u * core_factor(uu, vv, ww), v * core_factor(vv, ww, uu), w * core_factor(ww, uu, vv)};
  }

  Vec3 cap(double u, double v, double t) const {
    const Vec3 outer = direction(surface_, u, v).normalized();
    const double bulge = symmetric(bulge_, u, v) + (2 * t - 1) * symmetric(skew_, u, v);
    return (1 - t) * core(u, v, 1) + t * outer + (t * (1 - t) * bulge) * direction(lean_, u, v);
  }

 private:
  double core_factor(double a, double b, double c) const {
    const auto& p = core_;
    const double s = b + c, q = b * c;
    return p[0] + p[1] * a + p[2] * s + p[3] * a * a + p[4] * a * s + p[5] * q + p[6] * (s * s - 2 * q) + p[7] * a * q +
           p[8] * a * a * s + p[9] * a * a * q;
  }
  static double tangent(const std::array<double, 4>& p, double u, double v) {
    const double a = u * u, b = v * v;
    return u * (1 + (1 - a) * (p[0] + p[1] * a + p[2] * b + p[3] * a * b));
  }
  static Vec3 direction(const std::array<double, 4>& p, double u, double v) {
    return {tangent(p, u, v), tangent(p, v, u), 1.0};
  }
  static double symmetric(const std::array<double, 4>& p, double u, double v) {
    const double a = u * u, b = v * v;
    return p[0] + p[1] * (a + b) + p[2] * a * b + p[3] * (a * a + b * b);
  }

  std::array<double, 10> core_;
  std::array<double, 4> surface_, bulge_, skew_, lean_;
};

/// The map of a quarter of the unit circle; u, v, t in [0, 1].
class CircleMap {
 public:
  explicit CircleMap(Radius r)
      : core_(evaluate(circle_core, r.off_half())),
        surface_(evaluate(circle_surface, r.off_half())),
        bulge_(evaluate(circle_bulge, r.off_half())),
        skew_(evaluate(circle_skew, r.off_half())),
        lean_(evaluate(circle_lean, r.off_half())) {}

  std::array<double, 2> core(double u, double v) const {
    const double uu = u * u, vv = v * v;
    return {u * core_factor(uu, vv), v * core_factor(vv, uu)};
  }

  /// The cap about the x axis.
  std::array<double, 2> cap(double v, double t) const {
    const auto inner = core(1, v);
    const double s = tangent(surface_, v), length = std::sqrt(1 + s * s);
    const double bulge = t * (1 - t) * (even(bulge_, v) + (2 * t - 1) * even(skew_, v));
    return {(1 - t) * inner[0] + t / length + bulge, (1 - t) * inner[1] + t * s / length + bulge * tangent(lean_, v)};
  }

 private:
  double core_factor(double a, double b) const {
    const auto& p = core_;
    return p[0] + p[1] * a + p[2] * b + p[3] * a * a + p[4] * a * b + p[5] * b * b + p[6] * a * a * b +
           p[7] * a * b * b;
  }
  static double tangent(const std::array<double, 2>& p, double v) {
    return v * (1 + (1 - v * v) * (p[0] + p[1] * v * v));
  }
  static double even(const std::array<double, 3>& p, double v) { return p[0] + p[1] * v * v + p[2] * v * v * v * v; }

  std::array<double, 8> core_;
  std::array<double, 2> surface_;
  std::array<double, 3> bulge_, skew_;
  std::array<double, 2> lean_;
};

/// Which of the first n_axes coordinates is largest in size (the first of equals), and that size.
std::pair<int, int> outermost(const Lattice& p, int n_axes) {
  int axis = 0;
  for (int d = 1; d < n_axes; ++d)
    if (std::abs(p[d]) > std::abs(p[axis])) axis = d;
  return {axis, std::abs(p[axis])};
}

/// A point of a cap cell as the one lattice point that stands for it in all caps it belongs to: on the edges of a cap
/// the coordinates across move out with the layer.
Lattice weld(Lattice p, int n_axes, int core) {
  const int reach = outermost(p, n_axes).second;
  if (reach <= core) return p;
  for (int d = 0; d < n_axes; ++d)
    if (std::abs(p[d]) == core) p[d] = p[d] < 0 ? -reach : reach;
  return p;
}

/// True where the cell with this lowest corner belongs to the core or to one cap.
bool in_o_grid(const Lattice& cell, int n_axes, int core) {
  int outside = 0;
  for (int d = 0; d < n_axes; ++d) outside += cell[d] < -core || cell[d] >= core;
  return outside <= 1;
}

Vec3 sphere_point(const SphereMap& map, Radius r, const Lattice& p) {
  const auto [axis, reach] = outermost(p, 3);
  const double c = r.core;
  std::array<double, 3> local;
  for (int d = 0; d < 3; ++d) local[d] = std::abs(p[d]) == reach ? 1.0 : std::abs(p[d]) / c;
  Vec3 x;
  if (reach <= r.core) {
    x = map.core(std::abs(p[0]) / c, std::abs(p[1]) / c, std::abs(p[2]) / c);
  } else {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const Vec3 y = map.cap(local[a], local[b], static_cast<double>(reach - r.core) / r.cap);
    x[a] = y[0];
    x[b] = y[1];
    x[axis] = y[2];
  }
  for (int d = 0; d < 3; ++d)
    if (p[d] < 0) x[d] = -x[d];
  return x;
}

/// x and y on the unit circle's disc; z is left 0.
Vec3 circle_point(const CircleMap& map, Radius r, const Lattice& p) {
  const auto [axis, reach] = outermost(p, 2);
  const double c = r.core;
  Vec3 x(0, 0, 0);
  if (reach <= r.core) {
    const auto y = map.core(std::abs(p[0]) / c, std::abs(p[1]) / c);
    x[0] = y[0];
    x[1] = y[1];
  } else {
    const int across = 1 - axis;
    const double v = std::abs(p[across]) == reach ? 1.0 : std::abs(p[across]) / c;
    const auto y = map.cap(v, static_cast<double>(reach - r.core) / r.cap);
    x[axis] = y[0];
    x[across] = y[1];
  }
  for (int d = 0; d < 2; ++d)
    if (p[d] < 0) x[d] = -x[d];
  return x;
}

/// Bits of n spread to every third place.
std::uint64_t spread_bits(std::uint64_t n) {
  n &= 0x1fffff;
  n = (n | n << 32) & 0x1f00000000ffff;
  n = (n | n << 16) & 0x1f0000ff0000ff;
  n = (n | n << 8) & 0x100f00f00f00f00f;
  n = (n | n << 4) & 0x10c30c30c30c30c3;
  return (n | n << 2) & 0x1249249249249249;
}

std::uint64_t morton(const Lattice& p, const Lattice& low) {
  std::uint64_t key = 0;
  for (int d = 0; d < 3; ++d) key |= spread_bits(static_cast<std::uint64_t>(p[d] - low[d])) << d;
  return key;
}

/// Cells of a lattice box [low, high] in Morton order; cells for which keep(cell) is false are left out.
template <class Keep>
std::vector<Lattice> cells_in_order(const Lattice& low, const Lattice& high, Keep&& keep) {
  std::vector<std::pair<std::uint64_t, Lattice>> keyed;
  for (int k = low[2]; k < high[2]; ++k)
    for (int j = low[1]; j < high[1]; ++j)
      for (int i = low[0]; i < high[0]; ++i)
        if (const Lattice cell{i, j, k}; keep(cell)) keyed.push_back({morton(cell, low), cell});
  std::sort(keyed.begin(), keyed.end());
  std::vector<Lattice> cells;
  cells.reserve(keyed.size());
  for (const auto& [key, cell] : keyed) cells.push_back(cell);
  return cells;
}

/// The mesh of those cells: nodes at position(lattice point), corners of cells renamed by canonical(lattice point).
template <class Canonical, class Position>
HexMesh mesh_of(const std::vector<Lattice>& cells, const Lattice& low, const Lattice& high, Canonical&& canonical,
                Position&& position) {
  const auto n_in = [&](int d) { return static_cast<std::size_t>(high[d] - low[d] + 1); };
  const auto flat = [&](const Lattice& p) {
    return (static_cast<std::size_t>(p[2] - low[2]) * n_in(1) + static_cast<std::size_t>(p[1] - low[1])) * n_in(0) +
           static_cast<std::size_t>(p[0] - low[0]);
  };
  const auto corner_of = [&](const Lattice& cell, int a) {
    const int* o = corner_offset[a];
    return canonical(Lattice{cell[0] + o[0], cell[1] + o[1], cell[2] + o[2]});
  };
  std::vector<std::int32_t> number(n_in(0) * n_in(1) * n_in(2), -1);
  std::vector<std::pair<std::uint64_t, Lattice>> points;
  for (const Lattice& cell : cells)
    for (int a = 0; a < 8; ++a) {
      const Lattice p = corner_of(cell, a);
      if (number[flat(p)] == -1) points.push_back({morton(p, low), p});
      number[flat(p)] = 0;
    }
  std::sort(points.begin(), points.end());

  HexMesh mesh;
  mesh.x.reserve(points.size());
  for (const auto& [key, p] : points) {
    number[flat(p)] = static_cast<std::int32_t>(mesh.x.size());
    mesh.x.push_back(position(p));
  }
  mesh.node.reserve(cells.size());
  for (const Lattice& cell : cells) {
    auto& node = mesh.node.emplace_back();
    for (int a = 0; a < 8; ++a) node[static_cast<std::size_t>(a)] = number[flat(corner_of(cell, a))];
  }
  return mesh;
}

/// The lattice box of an O-grid, cut to the positive half along every plane that is kept.
std::pair<Lattice, Lattice> lattice_box(const Lattice& half, const core::Symmetry& keep) {
  Lattice low;
  for (std::size_t d = 0; d < 3; ++d) low[d] = keep.plane[d] ? 0 : -half[d];
  return {low, half};
}

void require(bool good, const std::string& message) {
  if (!good) throw core::CaseError(message);
}

Corners<double> corners_of(const HexMesh& mesh, const std::array<std::int32_t, 8>& node) {
  Corners<double> x;
  for (std::size_t a = 0; a < 8; ++a)
    for (int d = 0; d < 3; ++d) x.c[a][d] = mesh.x[static_cast<std::size_t>(node[a])][d];
  return x;
}

/// Largest over smallest det J of the eight corners and the eight points of the 2x2x2 Gauss rule.
double worst_jacobian_ratio(const Corners<double>& x) {
  const Edges<double> edge = edges(x);
  double low, high, low_inside, high_inside;
  extreme_jacobians(edge, low, high);
  extreme_jacobians(gauss_lines(edge), low_inside, high_inside);
  low = std::min(low, low_inside);
  return low > 0 ? std::max(high, high_inside) / low : 1e300;
}

double shortest_edge(const Corners<double>& x) {
  double squared = 1e300;
  for (const auto& f : face_corner)
    for (int k = 0; k < 4; ++k) {
      const double *a = x.c[f[k]], *b = x.c[f[(k + 1) % 4]];
      double s = 0;
      for (int d = 0; d < 3; ++d) s += (a[d] - b[d]) * (a[d] - b[d]);
      squared = std::min(squared, s);
    }
  return std::sqrt(squared);
}

// ---- graded line ----

/// Edge k = 1, 2, ... beside a fine edge h.
double graded_edge(double h, double ratio, int k, double coarse) { return std::min(h * std::pow(ratio, k), coarse); }

double graded_length(double h, double ratio, int n, double coarse) {
  double s = 0;
  for (int k = 1; k <= n; ++k) s += graded_edge(h, ratio, k, coarse);
  return s;
}

/// The edges that fill `length` beside a fine edge h; none where no ratio in [1, growth] does.
std::vector<double> graded_edges(double length, double h, double growth, double coarse) {
  coarse = std::max(coarse, h);
  int n = 0;
  for (double s = 0; s < length; s += graded_edge(h, growth, n, coarse)) ++n;
  if (n * h > length) return {};
  double low = 1, high = growth;
  for (int it = 0; it < 100; ++it) {
    const double middle = 0.5 * (low + high);
    (graded_length(h, middle, n, coarse) < length ? low : high) = middle;
  }
  std::vector<double> edge;
  for (int k = 1; k <= n; ++k) edge.push_back(graded_edge(h, high, k, coarse));
  return edge;
}

/// The part of the line that has equal edges.
struct FinePart {
  double first, last;
  int n;
  double edge() const { return (last - first) / n; }
};

FinePart with_count(double first, double last, double fine) {
  return {first, last, std::max(1, static_cast<int>(std::lround((last - first) / fine)))};
}

/// The fine part cut off at the ends of the line, at least one element wide where the line allows.
FinePart fine_part(double first, double last, const Grading& g) {
  const double half = std::max(g.fine_half, 0.5 * g.fine);
  const double focus = std::clamp(g.focus, first, last);
  const double a = std::max(first, std::min(focus - half, last - g.fine));
  const double b = std::min(last, std::max(focus + half, a + g.fine));
  return with_count(a, b, g.fine);
}

std::vector<double> line_between(double first, double last, const Grading& g) {
  FinePart part = fine_part(first, last, g);
  std::vector<double> before, after;
  for (bool settled = false; !settled;) {
    settled = true;
    before = graded_edges(part.first - first, part.edge(), g.growth, g.coarse);
    after = graded_edges(last - part.last, part.edge(), g.growth, g.coarse);
    const bool stretch_low = part.first > first && before.empty(), stretch_high = part.last < last && after.empty();
    if (stretch_low || stretch_high) {
      part = with_count(stretch_low ? first : part.first, stretch_high ? last : part.last, g.fine);
      settled = false;
    }
  }
  std::vector<double> x{first};
  for (auto edge = before.rbegin(); edge != before.rend(); ++edge) x.push_back(x.back() + *edge);
  x.back() = part.first;
  for (int k = 1; k <= part.n; ++k) x.push_back(part.first + (part.last - part.first) * k / part.n);
  for (const double edge : after) x.push_back(x.back() + edge);
  x.back() = last;
  return x;
}

}  // namespace

HexMesh sphere(double diameter, int n_across, core::Symmetry keep_positive) {
  require(diameter > 0, "sphere: diameter " + std::to_string(diameter) + " m; it must be positive");
  const Radius r = split_radius(n_across);
  const SphereMap map(r);
  const auto [low, high] = lattice_box({r.total(), r.total(), r.total()}, keep_positive);
  const auto cells = cells_in_order(low, high, [&](const Lattice& cell) { return in_o_grid(cell, 3, r.core); });
  return mesh_of(
      cells, low, high, [&](const Lattice& p) { return weld(p, 3, r.core); },
      [&](const Lattice& p) { return Vec3(0.5 * diameter * sphere_point(map, r, p)); });
}

HexMesh cylinder(double diameter, double length, int n_across, int n_along, core::Symmetry keep_positive) {
  require(diameter > 0 && length > 0, "cylinder: diameter " + std::to_string(diameter) + " m, length " +
                                          std::to_string(length) + " m; both must be positive");
  const Radius r = split_radius(n_across);
  const CircleMap map(r);
  n_along = std::max(1, n_along);
  if (keep_positive.plane[2]) n_along += n_along % 2;
  Lattice low{-r.total(), -r.total(), 0}, high{r.total(), r.total(), n_along};
  if (keep_positive.plane[0]) low[0] = 0;
  if (keep_positive.plane[1]) low[1] = 0;
  if (keep_positive.plane[2]) low[2] = n_along / 2;
  const auto cells = cells_in_order(low, high, [&](const Lattice& cell) { return in_o_grid(cell, 2, r.core); });
  return mesh_of(
      cells, low, high, [&](const Lattice& p) { return weld(p, 2, r.core); },
      [&](const Lattice& p) {
        Vec3 x = 0.5 * diameter * circle_point(map, r, p);
        x[2] = length * (2 * p[2] - n_along) / (2 * n_along);
        return x;
      });
}

std::vector<double> graded_line(double first, double last, const Grading& grading) {
  require(first < last, "line of nodes from " + std::to_string(first) + " to " + std::to_string(last) +
                            " m; the end must lie above the start");
  require(grading.fine > 0,
          "line of nodes: fine element size " + std::to_string(grading.fine) + " m; must be positive");
  require(grading.growth >= 1, "line of nodes: growth " + std::to_string(grading.growth) + "; must be 1 or more");
  if (first != -last || grading.focus != 0) return line_between(first, last, grading);
  const std::vector<double> half = line_between(0, last, grading);
  std::vector<double> x;
  for (std::size_t i = half.size() - 1; i > 0; --i) x.push_back(-half[i]);
  x.insert(x.end(), half.begin(), half.end());
  return x;
}

HexMesh box(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z) {
  for (const auto* line : {&x, &y, &z})
    require(line->size() >= 2 &&
                std::adjacent_find(line->begin(), line->end(), std::greater_equal<double>()) == line->end(),
            "box: each axis needs two or more coordinates, strictly ascending");
  const Lattice low{0, 0, 0};
  const Lattice high{static_cast<int>(x.size()) - 1, static_cast<int>(y.size()) - 1, static_cast<int>(z.size()) - 1};
  const auto cells = cells_in_order(low, high, [](const Lattice&) { return true; });
  return mesh_of(
      cells, low, high, [](const Lattice& p) { return p; },
      [&](const Lattice& p) {
        return Vec3(x[static_cast<std::size_t>(p[0])], y[static_cast<std::size_t>(p[1])],
                    z[static_cast<std::size_t>(p[2])]);
      });
}

MeshQuality quality(const HexMesh& mesh) {
  MeshQuality q{.shortest_edge = 1e300, .jacobian_ratio = 1, .smallest_angle = core::pi, .volume = 0};
  for (const auto& node : mesh.node) {
    const Corners<double> x = corners_of(mesh, node);
    const auto m = modes(x);
    q.volume += volume(m, gradient(m));
    q.shortest_edge = std::min(q.shortest_edge, shortest_edge(x));
    q.jacobian_ratio = std::max(q.jacobian_ratio, worst_jacobian_ratio(x));
    q.smallest_angle = std::min(q.smallest_angle, smallest_angle(x));
  }
  return q;
}

}  // namespace fem
