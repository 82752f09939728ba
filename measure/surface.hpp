// SPDX-License-Identifier: Apache-2.0
// The outer surface of a plate's material, in the plate's frame: the faces between elements that belong to it and
// anything else, and its particles as spheres. Hole, crater and wall are read from it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "measure/whole.hpp"

namespace measure {

struct Quad {
  std::array<core::Vec3, 4> x;  ///< plate frame [m]
  bool flat = false;            ///< still on the plate's front or back face as built, or on its outer edge
};

struct Sphere {
  core::Vec3 x;         ///< plate frame [m]
  double spacing = 0;   ///< its diameter [m]
};

struct Surface {
  std::vector<Quad> quads;
  std::vector<Sphere> spheres;
};

/// The surface of the rows of one body that are marked in `members`.
Surface surface_of(const Whole& whole, const PlateFrame& frame, int body, std::span<const char> members);

/// The part of the plate that the impact changed: a rectangle in its plane, and the size of its elements there.
struct Window {
  bool exists = false;
  double low[2] = {0, 0}, high[2] = {0, 0};  ///< [m]
  double size = 0;                           ///< typical edge [m]
};
Window disturbed_window(const Surface& surface, const PlateFrame& frame);

/// Columns over a window, `h` apart; index(i, j) = j * n[0] + i.
struct Columns {
  double low[2] = {0, 0};
  double h = 0;
  int n[2] = {0, 0};
  std::size_t size() const { return static_cast<std::size_t>(n[0]) * n[1]; }
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j) * n[0] + i; }
  double x(int axis, int i) const { return low[axis] + (i + 0.5) * h; }
  int cell(int axis, double x) const { return static_cast<int>(std::floor((x - low[axis]) / h)); }
  /// f(index) for a column and the eight round it, as far as there are any.
  template <class F>
  void each_around(int i, int j, F&& f) const {
    for (int b = std::max(0, j - 1); b <= std::min(n[1] - 1, j + 1); ++b)
      for (int a = std::max(0, i - 1); a <= std::min(n[0] - 1, i + 1); ++a) f(index(a, b));
  }
};

/// Where the middle of a plate lies that may be bent: its height over a grid of columns, carried on where nothing is left.
struct Middle {
  Columns columns;
  std::vector<double> height;  ///< [m]; empty: at 0 everywhere
  double at(double x, double y) const;
};
/// The mean height of the surface's front and back, over squares of the given edge [m].
Middle middle_of(const Surface& surface, const Window& window, double edge);

/// A connected set of columns.
struct Patch {
  std::size_t n_columns = 0;
  double center[2] = {0, 0};  ///< [m]
};
/// The largest set of marked columns that share sides; the first one among equals.
Patch largest_patch(const Columns& columns, std::span<const char> marked);

/// What the surface leaves open.
struct Opening {
  bool through = false;   ///< space in front of the plate is connected to space behind it
  Patch seen;             ///< largest patch of columns that nothing blocks: what one sees looking along the normal
  Middle bent;            ///< where the plate's middle lies, over squares of its thickness
  Patch middle;           ///< largest patch, in that middle, of the space connected to its front
};
/// Flood fill, from the front side, of the voxels that the surface does not touch.
Opening find_opening(const Surface& surface, const Window& disturbed, const PlateFrame& frame);

/// Height of the front-most point of the surface over every column [m]; lowest() where there is none.
std::vector<double> front_heights(const Surface& surface, const Columns& columns);
constexpr double no_height = std::numeric_limits<double>::lowest();
Columns columns_over(const Window& window, double h);

}  // namespace measure
