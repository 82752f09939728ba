// SPDX-License-Identifier: Apache-2.0
#include "app/trade.hpp"

#include <gtest/gtest.h>

namespace {

using Front = std::vector<bool>;

TEST(Trade, TheFrontHoldsWhatNothingCheaperBeats) {
  EXPECT_EQ(app::pareto_front({4, 1, 2, 3}, {0.1, 0.5, 0.6, 0.2}), (Front{true, true, false, true}));
  EXPECT_EQ(app::pareto_front({1, 1, 2}, {0.5, 0.4, 0.4}), (Front{false, true, false}));  // as cheap, and no better for twice the cost
  EXPECT_EQ(app::pareto_front({1, 1}, {0.5, 0.5}), (Front{true, false}));                  // of equals the first
  EXPECT_EQ(app::pareto_front({}, {}), Front{});
}

}  // namespace
