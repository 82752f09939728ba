// SPDX-License-Identifier: Apache-2.0
// What the octree's kernels see: plain arrays. The kernels exist once for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/aligned.hpp"
#include "core/isa.hpp"

namespace core {

constexpr std::size_t octree_padding = 16;  ///< readable entries behind the n of x, order and radius
constexpr std::size_t octree_leaf = 16;     ///< most points of a leaf
constexpr std::size_t octree_block = 16;    ///< candidates of a block
constexpr std::size_t octree_fan = 8;       ///< nodes of one level that make a node of the next

struct OctreeView {
  const double* x[3];          ///< along the curve
  const std::uint32_t* order;  ///< padded; place on the curve -> index
  const std::uint32_t* rank;   ///< index -> place on the curve
  bool in_order;               ///< both are the identity
  const std::uint32_t* leaf;   ///< first point of each leaf, and n
  const std::size_t* level;    ///< first node of each level
  int n_levels;
  const double* box[6];        ///< of each node
};

struct RowQuery {
  const double* radius;         ///< along the curve
  const double* node_radius_2;  ///< largest squared radius in each node; null: only the radius of the row's point counts
  bool along_curve;             ///< rows by place on the curve, else by index
  bool sorted;                  ///< by index within each row; if not, the order has no meaning
  const std::uint8_t* wanted;   ///< [index] 0 where the row may stay empty; null: all rows are wanted
};

/// Candidates side by side: coordinates in their party's frame, the limits of the squared distance that follow from their
/// own radius (symmetric queries only), and indices.
struct Candidates {
  float *x = nullptr, *y = nullptr, *z = nullptr, *high = nullptr, *low = nullptr;
  std::uint32_t* id = nullptr;
};

/// Boxes of blocks of candidates, and the greatest of their limits (symmetric queries only).
struct Blocks {
  float *low[3] = {}, *high[3] = {}, *reach = nullptr;
};

/// Work space for a number of rows, and its result: the rows one after the other and the length of each. The kernels use
/// the pointers only; growing is out of line, so that no library template is compiled for a set the machine may lack.
struct RowScratch {
  Candidates party;
  Blocks block;
  std::uint32_t* near = nullptr;                   // blocks within reach of a row
  std::uint32_t *leaf = nullptr, *node = nullptr;  // leaves within reach of a party, and nodes on the way to them
  std::uint32_t* row = nullptr;
  std::uint32_t* count = nullptr;
  std::size_t candidate_room = 0, node_room = 0, row_room = 0;

  explicit RowScratch(std::size_t n_rows);
  /// Rows are stored in `list` from entry `first` on, rather than in an array of their own.
  void store_in(std::vector<std::uint32_t>& list, std::size_t first);
  void grow_candidates(std::size_t n);
  void grow_nodes(std::size_t n);  // keeps `node`
  void grow_rows(std::size_t n);
  /// Puts the first n candidates of the party in order of their indices.
  void sort_party(std::size_t n, bool symmetric);

 private:
  std::vector<std::uint32_t>* list_ = nullptr;
  std::size_t list_first_ = 0;
  Candidates sorted_;
  void sort_slots(std::size_t n);
  void sort_strays();

  Aligned<float> real_;
  Aligned<std::uint32_t> id_;
  std::vector<std::uint32_t> near_, leaf_, node_, row_, count_, slot_, stray_, stray_2_;
};

namespace baseline {
void morton_keys(const double* xyz, std::size_t n, const double* low, double scale, std::uint64_t* key);
void find_rows(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, RowScratch& scratch);
}  // namespace baseline
namespace avx2 {
void morton_keys(const double* xyz, std::size_t n, const double* low, double scale, std::uint64_t* key);
void find_rows(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, RowScratch& scratch);
}  // namespace avx2
namespace avx512 {
void morton_keys(const double* xyz, std::size_t n, const double* low, double scale, std::uint64_t* key);
void find_rows(const OctreeView& tree, const RowQuery& query, std::size_t first, std::size_t last, RowScratch& scratch);
}  // namespace avx512

struct OctreeKernels {
  decltype(&baseline::morton_keys) morton_keys;
  decltype(&baseline::find_rows) find_rows;
};
OctreeKernels octree_kernels(Isa isa);

}  // namespace core
