// SPDX-License-Identifier: Apache-2.0
// Cells against std::map, hashed and tabulated, in a crowd and far apart.
#include "core/cells.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

using core::Cell;
using core::Cells;

namespace {

void expect_same(const Cells& cells, const std::map<Cell, std::uint32_t>& expected, std::int64_t reach) {
  ASSERT_EQ(cells.size(), expected.size());
  for (const auto& [c, number] : expected) {
    EXPECT_EQ(cells.find(c), number);
    EXPECT_EQ(cells[number], c);
    for (std::int64_t i = -1; i <= 1; ++i)
      for (const Cell& near : {Cell{c[0] + i, c[1], c[2]}, Cell{c[0], c[1] + i, c[2]}, Cell{c[0], c[1], c[2] + i * reach}}) {
        const auto there = expected.find(near);
        EXPECT_EQ(cells.find(near), there == expected.end() ? Cells::none : there->second);
      }
  }
}

}  // namespace

TEST(Cells, FloorOfEveryCoordinate) {
  Cells cells;
  cells.reset(0.5);
  EXPECT_EQ(cells.cell({-0.1, 0.0, 0.1}), (Cell{-1, 0, 0}));
  EXPECT_EQ(cells.cell({-0.5, 0.5, -1.0}), (Cell{-1, 1, -2}));
  EXPECT_EQ(cells.cell({-1e9 - 0.1, 1e9 + 0.1, -0.0}), (Cell{-2000000001, 2000000000, 0}));
}

TEST(Cells, FoundWithAndWithoutATable) {
  std::mt19937 random(7);
  for (const std::int64_t reach : {4, 100000}) {  // a crowd; so far apart that no table is worth it
    std::uniform_int_distribution<std::int64_t> at(-reach, reach);
    Cells cells;
    cells.reset(1);
    std::map<Cell, std::uint32_t> expected;
    const auto add = [&](int n) {
      for (int k = 0; k < n; ++k) {
        const Cell c{at(random), at(random), at(random)};
        const auto number = expected.emplace(c, static_cast<std::uint32_t>(expected.size())).first->second;
        EXPECT_EQ(cells.insert(c), number);
      }
    };
    cells.tabulate();
    EXPECT_EQ(cells.find({0, 0, 0}), Cells::none);
    add(300);
    expect_same(cells, expected, 2 * reach);
    cells.tabulate();
    expect_same(cells, expected, 2 * reach);
    add(300);  // ends the table
    expect_same(cells, expected, 2 * reach);
    cells.tabulate();
    expect_same(cells, expected, 2 * reach);
    cells.reset(1);
    EXPECT_EQ(cells.find(expected.begin()->first), Cells::none);
  }
}
