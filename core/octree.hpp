// SPDX-License-Identifier: Apache-2.0
// The octree: points sorted by Morton key, cells as ranges of the sorted order, no node pointers. Serves neighbour lists,
// contact candidates and fragments, with a radius of its own for every point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/types.hpp"

namespace core {

/// Neighbours of every point in compressed rows: those of point i are list[start[i]] ... list[start[i + 1] - 1], sorted by
/// index, without i itself.
struct Neighbours {
  std::vector<std::uint64_t> start;
  std::vector<std::uint32_t> list;
};

class Octree {
 public:
  /// Sorts the points. O(n); the result does not depend on the number of threads. x must be finite.
  void build(std::span<const Vec3> x);

  /// All pairs with |x_i - x_j| < max(radius_i, radius_j) where `symmetric`, else < radius_i.
  void neighbours(std::span<const double> radius, bool symmetric, Neighbours& result) const;

  /// Points inside the closed box [low, high], sorted by index, appended to `found`.
  void in_box(const Vec3& low, const Vec3& high, std::vector<std::uint32_t>& found) const;

  /// The order along the Morton curve: order()[k] is the index of the k-th point.
  std::span<const std::uint32_t> order() const { return order_; }

 private:
  std::vector<std::uint32_t> order_;
};

}  // namespace core
