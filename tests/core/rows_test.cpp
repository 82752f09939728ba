// SPDX-License-Identifier: Apache-2.0
#include "core/rows.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace {

TEST(Rows, KeepTheOrderInWhichThingsCome) {
  const std::vector<std::pair<std::size_t, int>> things{{3, 10}, {0, 11}, {3, 12}, {1, 13}, {3, 14}, {0, 15}};
  std::vector<std::uint32_t> start{7, 7, 7};  // what was there is gone
  std::vector<int> list{1, 2, 3};
  core::sort_into_rows(
      5, [&](auto&& put) { for (const auto& [row, value] : things) put(row, value); }, start, list);
  EXPECT_EQ(start, (std::vector<std::uint32_t>{0, 2, 3, 3, 6, 6}));
  EXPECT_EQ(list, (std::vector<int>{11, 15, 13, 10, 12, 14}));
}

TEST(Rows, MayBeEmpty) {
  std::vector<std::uint64_t> start;
  std::vector<std::uint32_t> list{1};
  core::sort_into_rows(0, [](auto&&) {}, start, list);
  EXPECT_EQ(start, std::vector<std::uint64_t>{0});
  EXPECT_TRUE(list.empty());
}

}  // namespace
