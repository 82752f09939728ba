// SPDX-License-Identifier: Apache-2.0
// Mirror images of a half, quarter or eighth: one plane after the other. A node nearer to the plane than a millionth of
// an element is its own image, so that an element and its image share a face.
#include <algorithm>
#include <cmath>

#include "measure/whole.hpp"

namespace measure {
namespace {

constexpr double on_plane = 1e-6;  // of the mean element size

/// The corner order of an image, so that it is right-handed again: swaps the two ends along the mirrored axis.
constexpr std::array<std::array<int, 8>, 3> image_corners{{{1, 0, 3, 2, 5, 4, 7, 6},
                                                           {3, 2, 1, 0, 7, 6, 5, 4},
                                                           {4, 5, 6, 7, 0, 1, 2, 3}}};

double mean_size(const Matter& m) {
  const std::size_t n = m.size.copies.n_elements;  // of the part: its images are as large
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += m.size.own[i];
  return n > 0 ? sum / static_cast<double>(n) : 0.0;
}

void mirror_mesh(Matter& m, int axis) {
  const double tolerance = on_plane * mean_size(m);
  const std::size_t n_nodes = m.node_x.size();
  std::vector<std::int32_t> image(n_nodes);
  m.node_x.reserve(2 * n_nodes);
  for (std::size_t nd = 0; nd < n_nodes; ++nd) {
    image[nd] = static_cast<std::int32_t>(nd);
    if (std::abs(m.node_x[nd][axis]) <= tolerance) continue;
    image[nd] = static_cast<std::int32_t>(m.node_x.size());
    core::Vec3 x = m.node_x[nd];
    x[axis] = -x[axis];
    m.node_x.push_back(x);
  }
  m.node.reserve(2 * m.n_elements);
  for (std::size_t el = 0; el < m.n_elements; ++el) {
    std::array<std::int32_t, 8> corners;
    for (int a = 0; a < 8; ++a) corners[a] = image[m.node[el][image_corners[axis][a]]];
    m.node.push_back(corners);
  }
}

}  // namespace

Matter mirrored(Matter m, const core::Symmetry& symmetry) {
  Copies copies{m.n_elements, 0, {}};
  m.size.copies = copies;
  for (int axis = 0; axis < 3; ++axis) {
    if (!symmetry.plane[static_cast<std::size_t>(axis)]) continue;
    mirror_mesh(m, axis);
    copies.axis[static_cast<std::size_t>(copies.n_planes++)] = axis;
    m.n_elements *= 2;
  }
  m.each_field([&](auto& field) { field.copies = copies; });
  return m;
}

}  // namespace measure
