// SPDX-License-Identifier: Apache-2.0
// The octree: points sorted by Morton key, cells as ranges of the sorted order, no node pointers. Serves neighbour lists,
// contact candidates and fragments, with a radius of its own for every point.
//
// Source of the idea: M. S. Warren and J. K. Salmon, "A parallel hashed oct-tree N-body algorithm", Supercomputing 1993
// (keys instead of pointers); S. Keller et al., "Cornerstone: octree construction algorithms for scalable particle
// simulations", PASC 2023 (the tree as ranges of a sorted array). What is done differently: cells are packed into leaves
// of at most 16 points, about as wide as a vector register, and carry the tight box of their points, so that neither
// outliers nor voids cost memory or time; eight leaves in a row make a node of the next level, and so on up.
//
// Memory: about 75 bytes a point, and 8 to 16 more while a query runs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/aligned.hpp"
#include "core/isa.hpp"
#include "core/octree_sort.hpp"
#include "core/types.hpp"

namespace core {

/// Neighbours of every point, by index and without itself, in compressed rows: row i is list[start[i]] ...
/// list[start[i + 1] - 1]. Use one object again and again: its memory is kept.
struct Neighbours {
  std::vector<std::uint64_t> start;
  std::vector<std::uint32_t> list;

  std::span<const std::uint32_t> of(std::size_t i) const {
    return {list.data() + start[i], static_cast<std::size_t>(start[i + 1] - start[i])};
  }
};

struct OctreeView;
struct RowQuery;

class Octree {
 public:
  /// Sorts the points. O(n), and quicker where x is nearly in order() already; the result does not depend on the number
  /// of threads. x must be finite and is not needed any more afterwards.
  void build(std::span<const Vec3> x);

  /// All pairs with |x_i - x_j| < max(radius_i, radius_j) where `symmetric`, else < radius_i: exactly those for which
  /// dx*dx + dy*dy + dz*dz < r*r in double arithmetic. Radii may differ by any factor. Row i is that of point i, sorted.
  /// About as quick as rows along the curve where points are stored along it; else sorting costs up to several times as much.
  /// Where `wanted` is given, [point], rows of points that it marks with 0 stay empty.
  void neighbours(std::span<const double> radius, bool symmetric, Neighbours& result, std::span<const std::uint8_t> wanted = {}) const;

  /// The same pairs as they are found: row k is that of point order()[k], its entries in the order of the curve.
  void neighbours_along_curve(std::span<const double> radius, bool symmetric, Neighbours& result) const;

  /// Points inside the closed box [low, high], sorted by index, appended to `found`.
  void in_box(const Vec3& low, const Vec3& high, std::vector<std::uint32_t>& found) const;

  /// The order along the Morton curve: order()[k] is the index of the k-th point. Points of equal key, if there are few,
  /// stand in the order of their indices; if many, in the order of a curve through their own box.
  std::span<const std::uint32_t> order() const { return {order_.data(), n_}; }
  std::size_t size() const { return n_; }

  /// The instruction set to use, at most what the machine has. The results do not depend on it.
  void set_isa(Isa isa);

 private:
  enum class RowOrder { by_index, along_curve };
  void find(std::span<const double> radius, bool symmetric, RowOrder rows, std::span<const std::uint8_t> wanted, Neighbours& result) const;
  bool rows_near_curve(std::span<const std::uint8_t> wanted) const;
  void find_rows(const RowQuery& query, std::vector<std::uint64_t>& start, std::vector<std::uint32_t>& list) const;
  OctreeView view() const;
  void cut_leaves();
  void box_nodes();
  Aligned<double> largest_squared_radii(std::span<const double> radius_on_curve) const;

  Isa isa_ = core::isa();
  MortonSort sort_;
  std::size_t n_ = 0;
  std::vector<std::uint32_t> order_, rank_;  // rank_ is the inverse of order_, which is padded like x_
  bool in_order_ = true;                     // order_ is the identity
  std::array<std::vector<double>, 3> x_;     // coordinates along the curve, padded to whole vector registers
  std::vector<std::uint32_t> leaf_;          // first point of each leaf, and n at the end
  std::vector<std::size_t> level_;           // first node of each level, leaves first; multiples of 8
  std::array<Aligned<double>, 6> box_;       // of each node: low x y z, high x y z; padding nodes are empty
};

}  // namespace core
