// SPDX-License-Identifier: Apache-2.0
#include "core/octree.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/octree_kernel.hpp"
#include "core/parallel.hpp"

namespace core {

namespace {

constexpr std::size_t leaf_least = 8;      // points of a leaf, the last of a piece aside
constexpr std::size_t leaf_piece = 4096;               // points whose leaves are cut together
constexpr std::size_t row_block = 256;                 // rows that are found together
constexpr std::uint32_t far_on_curve = 64;              // places

template <class V>
void grow(V& a, typename V::value_type*& pointer, std::size_t n) {
  a.resize(n);
  pointer = a.data();
}

/// Reserves memory for the rows of n points, going by the `total` length of those of the first `done`.
void foresee(std::vector<std::uint32_t>& list, std::size_t total, std::size_t done, std::size_t n) {
  if (total <= list.capacity()) return;
  const double whole = static_cast<double>(total) * static_cast<double>(n) / static_cast<double>(done);
  list.reserve(std::max(static_cast<std::size_t>(1.1 * whole), total) + 8192);
}

}  // namespace

OctreeKernels octree_kernels(Isa isa) {
  switch (isa) {
    case Isa::avx512: return {avx512::morton_keys, avx512::find_rows};
    case Isa::avx2: return {avx2::morton_keys, avx2::find_rows};
    default: return {baseline::morton_keys, baseline::find_rows};
  }
}

void Octree::set_isa(Isa isa) { isa_ = std::min(isa, core::isa()); }

void Octree::build(std::span<const Vec3> x) {
  const std::size_t n = x.size();
  if (n >= std::numeric_limits<std::uint32_t>::max() - octree_padding)
    throw std::length_error("octree: " + std::to_string(n) + " points are more than 32-bit indices can tell apart");
  n_ = n;
  sort_.sort(x, isa_, order_);
  order_.resize(n + octree_padding, 0);
  rank_.resize(n);
  for_each(n, [&](std::size_t k) { rank_[order_[k]] = static_cast<std::uint32_t>(k); });
  for (auto& a : x_) a.resize(n + octree_padding, 0.0);
  for_each(n, [&](std::size_t k) {
    const Vec3& p = x[order_[k]];
    for (int d = 0; d < 3; ++d) x_[d][k] = p[d];
  });
  in_order_ = sum(n, std::uint32_t{0}, [&](std::size_t k) { return std::uint32_t{order_[k] != k}; }) == 0;
  cut_leaves();
  box_nodes();
}

/// Leaves end where the keys of two successive points part at the highest level, so that they are whole cells of the
/// octree as far as their size allows.
void Octree::cut_leaves() {
  const std::span<const std::uint64_t> key = sort_.keys();
  const std::size_t n = key.size(), n_pieces = (n + leaf_piece - 1) / leaf_piece;
  std::vector<std::vector<std::uint32_t>> part(n_pieces);
  for_each_block(n, leaf_piece, [&](std::size_t first, std::size_t last) {
    auto& starts = part[first / leaf_piece];
    starts.reserve(leaf_piece / leaf_least + 1);
    for (std::size_t begin = first; begin < last;) {
      starts.push_back(static_cast<std::uint32_t>(begin));
      std::size_t cut = std::min(begin + octree_leaf, last);
      if (cut < last) {
        std::uint64_t highest = 0;
        for (std::size_t k = begin + leaf_least; k <= begin + octree_leaf; ++k)
          if (const std::uint64_t parting = key[k - 1] ^ key[k]; parting >= highest) {
            highest = parting;
            cut = k;
          }
      }
      begin = cut;
    }
  });
  std::vector<std::size_t> start(n_pieces + 1, 0);
  for (std::size_t p = 0; p < n_pieces; ++p) start[p + 1] = start[p] + part[p].size();
  leaf_.resize(start.back() + 1);
  leaf_.back() = static_cast<std::uint32_t>(n);
  for_each_block(n_pieces, 1, [&](std::size_t p, std::size_t) {
    std::copy(part[p].begin(), part[p].end(), leaf_.begin() + static_cast<std::ptrdiff_t>(start[p]));
  });
}

/// The boxes of the leaves, and level by level those of eight nodes in a row.
void Octree::box_nodes() {
  const auto padded = [](std::size_t n) { return (n + octree_fan - 1) / octree_fan * octree_fan; };
  const std::size_t n_leaves = leaf_.size() - 1;
  level_.clear();
  std::size_t n_nodes = 0;
  for (std::size_t on_level = n_leaves;; on_level = (on_level + octree_fan - 1) / octree_fan) {
    level_.push_back(n_nodes);
    n_nodes += std::max(padded(on_level), octree_fan);
    if (on_level <= octree_fan) break;
  }
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d) {
    box_[d].assign(n_nodes, inf);
    box_[3 + d].assign(n_nodes, -inf);
  }
  for_each(n_leaves, [&](std::size_t l) {
    double low[3] = {inf, inf, inf}, high[3] = {-inf, -inf, -inf};
    for (std::size_t k = leaf_[l]; k < leaf_[l + 1]; ++k)
      for (int d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], x_[d][k]);
        high[d] = std::max(high[d], x_[d][k]);
      }
    for (int d = 0; d < 3; ++d) {
      box_[d][l] = low[d];
      box_[3 + d][l] = high[d];
    }
  });
  for (std::size_t level = 1; level < level_.size(); ++level) {
    const std::size_t below = level_[level - 1], n_parents = (level_[level] - below) / octree_fan;
    for_each(n_parents, [&](std::size_t p) {
      for (int d = 0; d < 3; ++d)
        for (std::size_t c = below + p * octree_fan; c < below + (p + 1) * octree_fan; ++c) {
          box_[d][level_[level] + p] = std::min(box_[d][level_[level] + p], box_[d][c]);
          box_[3 + d][level_[level] + p] = std::max(box_[3 + d][level_[level] + p], box_[3 + d][c]);
        }
    });
  }
}

OctreeView Octree::view() const {
  OctreeView v{};
  for (int d = 0; d < 3; ++d) v.x[d] = x_[d].data();
  for (int d = 0; d < 6; ++d) v.box[d] = box_[d].data();
  v.order = order_.data();
  v.rank = rank_.data();
  v.in_order = in_order_;
  v.leaf = leaf_.data();
  v.level = level_.data();
  v.n_levels = static_cast<int>(level_.size());
  return v;
}

/// For each node, the largest squared radius of its points.
Aligned<double> Octree::largest_squared_radii(std::span<const double> radius) const {
  Aligned<double> most(box_[0].size(), 0.0);
  for_each(leaf_.size() - 1, [&](std::size_t l) {
    for (std::size_t k = leaf_[l]; k < leaf_[l + 1]; ++k) most[l] = std::max(most[l], radius[k] * radius[k]);
  });
  for (std::size_t level = 1; level < level_.size(); ++level) {
    const std::size_t below = level_[level - 1], n_parents = (level_[level] - below) / octree_fan;
    for_each(n_parents, [&](std::size_t p) {
      for (std::size_t c = below + p * octree_fan; c < below + (p + 1) * octree_fan; ++c)
        most[level_[level] + p] = std::max(most[level_[level] + p], most[c]);
    });
  }
  return most;
}

/// Rows one after the other, as the query wants them: start has n + 1 entries.
void Octree::find_rows(const RowQuery& query, std::vector<std::uint64_t>& start, std::vector<std::uint32_t>& list) const {
  const OctreeView tree = view();
  const auto find = octree_kernels(isa_).find_rows;
  start.resize(n_ + 1);
  start[0] = 0;
  if (threads() == 1) {  // into their place at once
    RowScratch scratch(row_block);
    for (std::size_t begin = 0; begin < n_; begin += row_block) {
      const std::size_t end = std::min(n_, begin + row_block);
      if (begin > 0) foresee(list, start[begin] * (begin + row_block) / begin, begin + row_block, n_);
      scratch.store_in(list, start[begin]);
      find(tree, query, begin, end, scratch);
      for (std::size_t k = begin; k < end; ++k) start[k + 1] = start[k] + scratch.count[k - begin];
    }
  } else {
    // A few blocks for each thread at a time: their rows are still in the cache when they are copied to their place.
    const std::size_t at_a_time = 4 * static_cast<std::size_t>(threads());
    std::vector<RowScratch> scratch;
    for (std::size_t b = 0; b < std::min(at_a_time, (n_ + row_block - 1) / row_block); ++b) scratch.emplace_back(row_block);
    for (std::size_t begin = 0; begin < n_; begin += at_a_time * row_block) {
      const std::size_t end = std::min(n_, begin + at_a_time * row_block);
      for_each_block(end - begin, row_block, [&](std::size_t first, std::size_t last) {
        find(tree, query, begin + first, begin + last, scratch[first / row_block]);
      });
      for (std::size_t k = begin; k < end; ++k)
        start[k + 1] = start[k] + scratch[(k - begin) / row_block].count[(k - begin) % row_block];
      if (start[end] > list.size()) {
        foresee(list, start[end], end, n_);
        list.resize(start[end]);
      }
      for_each_block(end - begin, row_block, [&](std::size_t first, std::size_t last) {
        std::copy_n(scratch[first / row_block].row, start[begin + last] - start[begin + first],
                    list.data() + start[begin + first]);
      });
    }
  }
  list.resize(start[n_]);
}

/// Do at most half of the wanted rows, by index, jump along the curve from the one before?
bool Octree::rows_near_curve(std::span<const std::uint8_t> wanted) const {
  std::size_t n_rows = 0, n_jumps = 0;
  std::uint32_t last = n_ > 0 ? rank_[0] : 0;
  for (std::size_t i = 0; i < n_; ++i) {
    if (!wanted.empty() && !wanted[i]) continue;
    ++n_rows;
    n_jumps += rank_[i] - last + far_on_curve > 2 * far_on_curve;  // forwards or back, modulo 2^32
    last = rank_[i];
  }
  return 2 * n_jumps <= n_rows;
}

void Octree::find(std::span<const double> radius, bool symmetric, RowOrder rows, std::span<const std::uint8_t> wanted,
                  Neighbours& result) const {
  const std::size_t n = n_;
  if (radius.size() != n)
    throw std::invalid_argument("octree: " + std::to_string(radius.size()) + " radii for " + std::to_string(n) + " points");
  constexpr double largest = 1e150;  // its square is finite, and so is the square of any distance that matters
  const bool differ = sum(n, std::size_t{0}, [&](std::size_t i) { return std::size_t{radius[i] != radius[0]}; }) != 0;
  std::vector<double> own(n + octree_padding, n > 0 ? std::min(radius[0], largest) : 0.0);
  if (differ) for_each(n, [&](std::size_t k) { own[k] = std::min(radius[order_[k]], largest); });
  Aligned<double> node_radius_2;
  if (symmetric && differ) node_radius_2 = largest_squared_radii(own);
  RowQuery query{own.data(), node_radius_2.empty() ? nullptr : node_radius_2.data(), true, false, wanted.empty() ? nullptr : wanted.data()};

  if (rows == RowOrder::along_curve) return find_rows(query, result.start, result.list);
  // Where the points are stored nearly along the curve, rows are found by index and are in their place at once.
  if (rows_near_curve(wanted)) {
    query.along_curve = false, query.sorted = true;
    return find_rows(query, result.start, result.list);
  }
  Neighbours found;
  const bool mutual = symmetric && wanted.empty();
  query.sorted = !mutual;
  find_rows(query, found.start, found.list);
  result.start.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) result.start[i + 1] = result.start[i] + found.of(rank_[i]).size();
  result.list.resize(result.start[n]);
  if (!mutual) {
    for_each(n, [&](std::size_t i) {
      const auto row = found.of(rank_[i]);
      std::copy(row.begin(), row.end(), result.list.data() + result.start[i]);
    });
    return;
  }
  // Who has j in its row is in the row of j: going through the rows by index puts every entry in its place and in order.
  std::vector<std::uint64_t> next(result.start.begin(), result.start.end() - 1);
  for_each_share(n, [&](std::size_t low, std::size_t high) {
    for (std::size_t i = 0; i < n; ++i)
      for (const std::uint32_t j : found.of(rank_[i]))
        if (j - low < high - low) result.list[next[j]++] = static_cast<std::uint32_t>(i);
  });
}

void Octree::neighbours(std::span<const double> radius, bool symmetric, Neighbours& result, std::span<const std::uint8_t> wanted) const {
  find(radius, symmetric, RowOrder::by_index, wanted, result);
}

void Octree::neighbours_along_curve(std::span<const double> radius, bool symmetric, Neighbours& result) const {
  find(radius, symmetric, RowOrder::along_curve, {}, result);
}

void Octree::in_box(const Vec3& low, const Vec3& high, std::vector<std::uint32_t>& found) const {
  const std::size_t before = found.size();
  const auto outside = [&](std::size_t node) {
    if (box_[0][node] > box_[3][node]) return true;  // padding
    for (int d = 0; d < 3; ++d)
      if (box_[d][node] > high[d] || box_[3 + d][node] < low[d]) return true;
    return false;
  };
  const auto descend = [&](auto&& self, std::size_t level, std::size_t eight) -> void {
    for (std::size_t c = eight * octree_fan; c < (eight + 1) * octree_fan; ++c) {
      if (outside(level_[level] + c)) continue;
      if (level > 0) {
        self(self, level - 1, c);
        continue;
      }
      for (std::size_t k = leaf_[c]; k < leaf_[c + 1]; ++k) {
        bool in = true;
        for (int d = 0; d < 3; ++d) in = in && x_[d][k] >= low[d] && x_[d][k] <= high[d];
        if (in) found.push_back(order_[k]);
      }
    }
  };
  if (n_ > 0) descend(descend, level_.size() - 1, 0);
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end());
}

RowScratch::RowScratch(std::size_t n_rows) {
  grow(count_, count, n_rows);
  grow_candidates(2048);
  grow_nodes(1024);
  grow_rows(n_rows * 64);
}

void RowScratch::grow_candidates(std::size_t n) {
  candidate_room = (std::max(n, candidate_room + candidate_room / 2) + octree_block - 1) / octree_block * octree_block;
  const std::size_t block_room = (candidate_room / octree_block + octree_padding) / 16 * 16 + 16;  // whole cache lines
  real_.resize(10 * candidate_room + 7 * block_room);
  id_.resize(2 * candidate_room);
  grow(near_, near, block_room);
  float* next = real_.data();
  for (Candidates* c : {&party, &sorted_})
    for (float** part : {&c->x, &c->y, &c->z, &c->high, &c->low}) {
      *part = next;
      next += candidate_room;
    }
  for (float** part : {&block.low[0], &block.low[1], &block.low[2], &block.high[0], &block.high[1], &block.high[2],
                       &block.reach}) {
    *part = next;
    next += block_room;
  }
  party.id = id_.data();
  sorted_.id = id_.data() + candidate_room;
}

void RowScratch::grow_nodes(std::size_t n) {
  node_room = std::max(n, 2 * node_room);
  const bool swapped = node != nullptr && node == leaf_.data();
  grow(leaf_, leaf, node_room);
  grow(node_, node, node_room);
  if (swapped) std::swap(leaf, node);
}

void RowScratch::grow_rows(std::size_t n) {
  if (!list_) {
    row_room = std::max(n, row_room + row_room / 2);
    return grow(row_, row, row_room);
  }
  // In small steps where there is capacity, since new entries are set to zero.
  const std::size_t needed = list_first_ + n + 4096;
  if (needed > list_->capacity()) list_->reserve(needed + needed / 2);
  list_->resize(needed);
  store_in(*list_, list_first_);
}

void RowScratch::store_in(std::vector<std::uint32_t>& list, std::size_t first) {
  list_ = &list;
  list_first_ = first;
  row = list.data() + first;
  row_room = list.size() - std::min<std::size_t>(first, list.size());
}

/// Puts the strays in order of the indices that they stand for: few by comparing them, many digit by digit.
void RowScratch::sort_strays() {
  const std::uint32_t* const id = party.id;
  constexpr std::size_t few = 48;
  if (stray_.size() <= few) {
    std::sort(stray_.begin(), stray_.end(), [id](std::uint32_t a, std::uint32_t b) { return id[a] < id[b]; });
    return;
  }
  constexpr int digit_bits = 8;
  std::uint32_t low = id[stray_[0]], high = low;
  for (const auto s : stray_) low = std::min(low, id[s]), high = std::max(high, id[s]);
  stray_2_.resize(stray_.size());
  for (int shift = 0; shift < 32 && (high - low) >> shift != 0; shift += digit_bits) {
    const auto digit = [&](std::uint32_t s) { return (id[s] - low) >> shift & ((1u << digit_bits) - 1); };
    std::array<std::uint32_t, 1u << digit_bits> start{};
    for (const auto s : stray_) ++start[digit(s)];
    std::uint32_t total = 0;
    for (auto& s : start) total += std::exchange(s, total);
    for (const auto s : stray_) stray_2_[start[digit(s)]++] = s;
    stray_.swap(stray_2_);
  }
}

/// Fills slot_ with 0 ... n - 1 in order of the party's indices. As in octree_sort.cpp: few are out of place as a rule, so
/// those are picked out (with the one before, which may be the culprit as well), sorted, and merged with the rest.
void RowScratch::sort_slots(std::size_t n) {
  const std::uint32_t* const id = party.id;
  slot_.resize(n);
  stray_.clear();
  std::size_t n_kept = 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (n_kept > 0 && id[k] < id[slot_[n_kept - 1]]) {
      stray_.push_back(slot_[--n_kept]);
      stray_.push_back(k);
    } else {
      slot_[n_kept++] = k;
    }
  }
  sort_strays();
  std::size_t to = n;  // from the back, so that nothing is overwritten
  while (!stray_.empty()) {
    const std::uint32_t s = stray_.back();
    while (n_kept > 0 && id[slot_[n_kept - 1]] > id[s]) slot_[--to] = slot_[--n_kept];
    slot_[--to] = s;
    stray_.pop_back();
  }
}

void RowScratch::sort_party(std::size_t n, bool symmetric) {
  sort_slots(n);
  const auto permute = [&](const auto* from, auto* to) {
    for (std::size_t k = 0; k < n; ++k) to[k] = from[slot_[k]];
  };
  permute(party.x, sorted_.x);
  permute(party.y, sorted_.y);
  permute(party.z, sorted_.z);
  permute(party.id, sorted_.id);
  if (symmetric) {
    permute(party.high, sorted_.high);
    permute(party.low, sorted_.low);
  }
  std::swap(party, sorted_);
}

}  // namespace core
