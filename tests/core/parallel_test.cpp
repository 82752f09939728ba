// SPDX-License-Identifier: Apache-2.0
// Loops and sums give the same bits on any number of threads.
#include "core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

struct Parallel : testing::Test {
  void TearDown() override { core::set_threads(1); }
};

/// Numbers whose sum depends on the order of the additions.
static std::vector<double> rough_numbers(std::size_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-30, 30);
  std::vector<double> a(n);
  for (double& v : a) v = (random() % 2 ? 1 : -1) * std::exp2(exponent(random));
  return a;
}

TEST_F(Parallel, SumHasTheSameBitsOnAnyNumberOfThreads) {
  for (const std::size_t n : {0u, 1u, 1000u, 1024u, 1025u, 100003u}) {
    const std::vector<double> a = rough_numbers(n);
    core::set_threads(1);
    const double one = core::sum(n, 0.0, [&](std::size_t i) { return a[i]; });
    for (const int threads : {2, 7}) {
      core::set_threads(threads);
      const double many = core::sum(n, 0.0, [&](std::size_t i) { return a[i]; });
      EXPECT_EQ(std::memcmp(&one, &many, sizeof one), 0) << n << " numbers, " << threads << " threads";
    }
  }
}

TEST_F(Parallel, SumOfIntegersIsExact) {
  core::set_threads(3);
  EXPECT_EQ(core::sum(100001, std::size_t{0}, [](std::size_t i) { return i; }), std::size_t{100000} * 100001 / 2);
}

TEST_F(Parallel, MinWhereGivesTheLowestIndexOfTheLeast) {
  std::vector<double> a(50000, 3.0);
  a[40000] = a[12345] = a[12346] = -1.0;
  for (const int threads : {1, 2, 7}) {
    core::set_threads(threads);
    const core::MinWhere m = core::min_where(a.size(), [&](std::size_t i) { return a[i]; });
    EXPECT_EQ(m.value, -1.0);
    EXPECT_EQ(m.index, 12345u);
  }
}

TEST_F(Parallel, LoopsVisitEveryIndexOnce) {
  for (const int threads : {1, 2, 7}) {
    core::set_threads(threads);
    for (const std::size_t n : {0u, 1u, 255u, 257u, 10007u}) {
      std::vector<int> visits(n, 0);
      core::for_each(n, [&](std::size_t i) { ++visits[i]; });
      core::for_each_block(n, 100, [&](std::size_t first, std::size_t last) {
        EXPECT_LE(last, n);
        for (std::size_t i = first; i < last; ++i) ++visits[i];
      });
      EXPECT_EQ(visits, std::vector<int>(n, 2));
    }
  }
}

/// The first block of one thread's share waits for all others: its thread is held, so that somebody else must do them.
TEST_F(Parallel, ThreadsThatAreDoneHelp) {
  core::set_threads(2);
  constexpr std::size_t n = 40;
  std::atomic<std::size_t> done = 0;
  bool all = false;
  core::for_each_block(n, 1, [&](std::size_t first, std::size_t) {
    if (first != 0) {
      ++done;
      return;
    }
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!(all = done == n - 1) && std::chrono::steady_clock::now() < patience) std::this_thread::yield();
  });
  EXPECT_TRUE(all);
}
