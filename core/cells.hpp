// SPDX-License-Identifier: Apache-2.0
// Cubes of one edge that hold something, numbered in the order in which they are first met: a hash table with open
// addressing and linear probing. Costs memory for what is there only, however far apart it lies. Where many are looked for
// and no more come, a table of the box around them spares the hashing, unless that box is mostly empty.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace core {

using Cell = std::array<std::int64_t, 3>;

class Cells {
 public:
  static constexpr std::uint32_t none = 0xffffffff;

  /// Empty, with cubes of this edge [m].
  void reset(double edge) {
    inverse_ = 1 / edge;
    cells_.clear();
    slots_.assign(64, none);
    table_.clear();
  }
  Cell cell(const Vec3& x) const {
    Cell c;
    for (std::size_t d = 0; d < 3; ++d) {
      const double a = x[static_cast<int>(d)] * inverse_;
      c[d] = static_cast<std::int64_t>(a);
      c[d] -= a < static_cast<double>(c[d]);  // floor, which is a call where the processor need not have it
    }
    return c;
  }
  /// Number of the cell, none where it is not there.
  std::uint32_t find(const Cell& c) const {
    if (table_.empty()) return slots_[slot(c)];
    for (std::size_t d = 0; d < 3; ++d)
      if (from_low(c, d) >= n_[d]) return none;
    return table_[row(c)];
  }
  /// Number of the cell, a new one where it was not there.
  std::uint32_t insert(const Cell& c) {
    table_.clear();
    std::size_t s = slot(c);
    if (slots_[s] != none) return slots_[s];
    if (2 * (cells_.size() + 1) > slots_.size()) {
      grow();
      s = slot(c);
    }
    cells_.push_back(c);
    return slots_[s] = static_cast<std::uint32_t>(cells_.size() - 1);
  }
  /// Finds are quick from here on, until the next insert.
  void tabulate() {
    constexpr double emptiest = 64;  // cubes of the box for each that is there
    if (cells_.empty()) return;
    Cell high = low_ = cells_[0];
    for (const Cell& c : cells_)
      for (std::size_t d = 0; d < 3; ++d) low_[d] = std::min(low_[d], c[d]), high[d] = std::max(high[d], c[d]);
    double volume = 1;
    for (std::size_t d = 0; d < 3; ++d) volume *= static_cast<double>(high[d] - low_[d]) + 1;
    if (volume > emptiest * static_cast<double>(cells_.size())) return;
    for (std::size_t d = 0; d < 3; ++d) n_[d] = static_cast<std::uint64_t>(high[d] - low_[d]) + 1;
    table_.assign(n_[0] * n_[1] * n_[2], none);
    for (std::size_t k = 0; k < cells_.size(); ++k) table_[row(cells_[k])] = static_cast<std::uint32_t>(k);
  }
  std::size_t size() const { return cells_.size(); }
  const Cell& operator[](std::size_t k) const { return cells_[k]; }

 private:
  /// Cubes from the low side of the table's box; huge below it.
  std::uint64_t from_low(const Cell& c, std::size_t d) const { return static_cast<std::uint64_t>(c[d] - low_[d]); }
  /// Where in the table a cell of its box stands.
  std::size_t row(const Cell& c) const { return (from_low(c, 0) * n_[1] + from_low(c, 1)) * n_[2] + from_low(c, 2); }
  /// Where the cell stands or would stand.
  std::size_t slot(const Cell& c) const {
    std::uint64_t h = 0;
    for (const auto i : c) {
      h = (h ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15ull;
      h ^= h >> 29;
    }
    const std::size_t mask = slots_.size() - 1;
    std::size_t s = static_cast<std::size_t>(h) & mask;
    while (slots_[s] != none && !same(cells_[slots_[s]], c)) s = (s + 1) & mask;
    return s;
  }
  static bool same(const Cell& a, const Cell& b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }  // no call of memcmp
  void grow() {
    slots_.assign(2 * slots_.size(), none);
    for (std::size_t k = 0; k < cells_.size(); ++k) slots_[slot(cells_[k])] = static_cast<std::uint32_t>(k);
  }

  double inverse_ = 1;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(64, none);
  std::vector<std::uint32_t> table_;  ///< [cube of the box from low_] its number; empty where there is no table
  Cell low_{};
  std::array<std::uint64_t, 3> n_{};
};

}  // namespace core
