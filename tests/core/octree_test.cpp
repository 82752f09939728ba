// SPDX-License-Identifier: Apache-2.0
// The octree against a brute-force twin: the lists must be equal, entry by entry, with no tolerance.
#include "core/octree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "core/parallel.hpp"

using core::Isa;
using core::Neighbours;
using core::Octree;
using core::Vec3;
using Cloud = std::vector<Vec3>;
using Radii = std::vector<double>;

static Neighbours brute_force(const Cloud& x, const Radii& radius, bool symmetric) {
  Neighbours found{.start = {0}, .list = {}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double r = symmetric ? std::max(radius[i], radius[j]) : radius[i];
      const double dx = x[j][0] - x[i][0], dy = x[j][1] - x[i][1], dz = x[j][2] - x[i][2];
      if (j != i && dx * dx + dy * dy + dz * dz < r * r) found.list.push_back(static_cast<std::uint32_t>(j));
    }
    found.start.push_back(found.list.size());
  }
  return found;
}

static double uniform(std::mt19937& random, double a = 0, double b = 1) {
  return std::uniform_real_distribution<double>(a, b)(random);
}
static Vec3 in_cube(std::mt19937& random) {
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}
static Vec3 direction(std::mt19937& random) {
  const double c = uniform(random, -1, 1), phi = uniform(random, 0, 2 * core::pi), s = std::sqrt(1 - c * c);
  return {s * std::cos(phi), s * std::sin(phi), c};
}

struct NamedCloud {
  std::string name;
  Cloud x;
  double spacing;  // a typical distance of neighbours
};

/// A thin dense slab, a bubble of ten times its spacing, and three points far away.
static Cloud debris(std::mt19937& random, std::size_t n) {
  Cloud x;
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 2)
      x.push_back(Vec3(0, 0, 3) + 3 * (1 + 0.02 * uniform(random)) * direction(random));
    else
      x.push_back(in_cube(random).cwiseProduct(Vec3(1, 1, 0.1)));
  }
  x.push_back({5000, 0, 0});
  x.push_back({0, -7000, 100});
  x.push_back({1, 2, 9000});
  return x;
}

static std::vector<NamedCloud> clouds() {
  std::mt19937 random(1);
  const auto made = [](std::size_t n, const std::function<Vec3(std::size_t)>& point) {
    Cloud x;
    for (std::size_t i = 0; i < n; ++i) x.push_back(point(i));
    return x;
  };
  const auto lattice = [](std::size_t i) { return Vec3(double(i % 11), double(i / 11 % 11), double(i / 121)); };
  std::vector<NamedCloud> all;
  const auto add = [&](const std::string& name, double spacing, const Cloud& x) { all.push_back({name, x, spacing}); };
  add("none", 1, {});
  add("one", 1, {Vec3(1, 2, 3)});
  add("two", 1, {Vec3(1, 2, 3), Vec3(1.5, 2, 3)});
  add("uniform", 0.087, made(1500, [&](std::size_t) { return in_cube(random); }));
  add("lattice", 1, made(1331, lattice));
  add("fine lattice", 0.1, made(1331, [&](std::size_t i) -> Vec3 { return 0.1 * lattice(i); }));
  add("clusters", 0.01, made(1500, [&](std::size_t i) -> Vec3 {
        return Vec3(std::pow(double(i % 7), 3), double(i % 5) * 20, 0) + 0.1 * std::pow(uniform(random), 3) * direction(random);
      }));
  add("debris", 0.05, debris(random, 1500));
  add("plane", 0.03, made(1000, [&](std::size_t) { return Vec3(uniform(random), 3.0, uniform(random)); }));
  add("line", 0.005, made(700, [&](std::size_t) -> Vec3 { return uniform(random) * Vec3(1, 2, 3); }));
  add("huge offset", 0.1, made(1000, [&](std::size_t) -> Vec3 { return Vec3(1e9, -2e9, 3e9) + in_cube(random); }));
  add("coincident", 1, made(300, [](std::size_t) { return Vec3(0.1, 0.2, 0.3); }));
  add("coincident in groups", 1, made(1000, [](std::size_t i) { return Vec3(double(i % 10), double(i / 10 % 3), 0); }));
  add("ever smaller", 1e-20, made(800, [&](std::size_t i) -> Vec3 { return std::ldexp(1.0, -int(i) / 4) * direction(random); }));
  add("very far outliers", 0.1, made(1200, [&](std::size_t i) -> Vec3 {
        return i % 400 == 7 ? Vec3(1e12 * direction(random)) : in_cube(random);
      }));
  add("minute", 1e-31, made(800, [&](std::size_t) -> Vec3 { return 1e-30 * in_cube(random); }));
  add("gigantic", 1e29, made(800, [&](std::size_t) -> Vec3 { return 1e30 * in_cube(random); }));
  return all;
}

static std::vector<std::pair<std::string, Radii>> radii(const NamedCloud& c) {
  std::mt19937 random(2);
  const std::size_t n = c.x.size();
  const double s = c.spacing;
  Radii spread(n), by_place(n), few_large(n);
  for (std::size_t i = 0; i < n; ++i) {
    spread[i] = 0.1 * s * std::pow(100.0, uniform(random));  // over a factor of 100
    by_place[i] = s * (1 + std::abs(std::sin(3 * c.x[i][0] / (20 * s))));
    few_large[i] = i % 211 == 5 ? 20 * s : i % 17 == 3 ? 0 : s;
  }
  return {{"one", Radii(n, 2 * s)},      {"one, ties", Radii(n, std::sqrt(2.0) * s)}, {"spread", spread},
          {"by place", by_place},        {"few large", few_large},                    {"zero", Radii(n, 0.0)},
          {"everything", Radii(n, 1e9 * s)}};
}

static std::vector<Isa> instruction_sets() {
  std::vector<Isa> sets;
  for (Isa i : {Isa::baseline, Isa::avx2, Isa::avx512})
    if (i <= core::isa()) sets.push_back(i);
  return sets;
}

static Cloud in_order(const Cloud& x, std::span<const std::uint32_t> order) {
  Cloud y;
  for (std::uint32_t i : order) y.push_back(x[i]);
  return y;
}

/// Stored at random, along the curve, and along the curve but for a few.
static std::vector<NamedCloud> stored_in_three_ways(const NamedCloud& c) {
  Octree tree;
  tree.build(c.x);
  const Cloud sorted = in_order(c.x, tree.order());
  Cloud nearly = sorted;
  std::mt19937 random(3);
  for (std::size_t k = 0; k < nearly.size() / 40; ++k)
    std::swap(nearly[random() % nearly.size()], nearly[random() % nearly.size()]);
  return {c, {c.name + ", sorted", sorted, c.spacing}, {c.name + ", nearly sorted", nearly, c.spacing}};
}

static void expect_equal(const Neighbours& found, const Neighbours& expected, const std::string& what) {
  ASSERT_EQ(found.start, expected.start) << what;
  ASSERT_TRUE(found.list == expected.list) << what;
}

/// Rows that stand along the curve, by index and sorted.
static Neighbours by_index(const Neighbours& found, const Octree& tree) {
  std::vector<std::vector<std::uint32_t>> row(tree.size());
  for (std::size_t k = 0; k < tree.size(); ++k) {
    const auto r = found.of(k);
    row[tree.order()[k]].assign(r.begin(), r.end());
  }
  Neighbours sorted{.start = {0}, .list = {}};
  for (auto& r : row) {
    std::sort(r.begin(), r.end());
    sorted.list.insert(sorted.list.end(), r.begin(), r.end());
    sorted.start.push_back(sorted.list.size());
  }
  return sorted;
}

/// Every third point of every other 64.
static std::vector<std::uint8_t> every_third(std::size_t n) {
  std::vector<std::uint8_t> wanted(n);
  for (std::size_t i = 0; i < n; ++i) wanted[i] = i / 64 % 2 == 0 ? i % 3 == 0 : 0;
  return wanted;
}
static Neighbours only(const Neighbours& all, const std::vector<std::uint8_t>& wanted) {
  Neighbours some{.start = {0}, .list = {}};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i])
      for (const auto j : all.of(i)) some.list.push_back(j);
    some.start.push_back(some.list.size());
  }
  return some;
}

struct OctreeTest : testing::Test {
  void TearDown() override { core::set_threads(1); }
};

TEST_F(OctreeTest, NeighboursAreThoseOfBruteForce) {
  for (const NamedCloud& base : clouds()) {
    for (const NamedCloud& c : stored_in_three_ways(base)) {
      Octree tree;
      Neighbours found;  // used again on purpose
      for (const auto& [name, r] : radii(c)) {
        for (const bool symmetric : {false, true}) {
          const Neighbours expected = brute_force(c.x, r, symmetric);
          for (const Isa isa : instruction_sets()) {
            core::set_threads(isa == core::isa() && name == "spread" ? 2 : 1);
            tree.set_isa(isa);
            tree.build(c.x);
            tree.neighbours(r, symmetric, found);
            expect_equal(found, expected, c.name + " cloud, radii: " + name + (symmetric ? ", symmetric" : "") + ", isa " +
                                              std::to_string(static_cast<int>(isa)));
            if (HasFatalFailure()) return;
            const auto some = every_third(c.x.size());
            tree.neighbours(r, symmetric, found, some);
            expect_equal(found, only(expected, some), c.name + " cloud, every third row, radii: " + name);
            if (HasFatalFailure()) return;
            if (isa != core::isa()) continue;
            tree.neighbours_along_curve(r, symmetric, found);
            expect_equal(by_index(found, tree), expected, c.name + " cloud along the curve, radii: " + name);
            if (HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

TEST_F(OctreeTest, ThreadsAndInstructionSetsChangeNothing) {
  std::mt19937 random(4);
  const Cloud x = debris(random, 30000);
  Radii r;
  for (const Vec3& p : x) r.push_back(p[2] < 0.1 ? 0.02 : 0.15 + 0.1 * uniform(random));
  for (const bool sorted : {false, true}) {
    Octree tree;
    tree.build(x);
    const Cloud y = sorted ? in_order(x, tree.order()) : x;
    Neighbours first, first_along, found;
    std::vector<std::uint32_t> first_order;
    for (const int n_threads : {1, 2, 7})
      for (const Isa isa : instruction_sets()) {
        core::set_threads(n_threads);
        tree.set_isa(isa);
        tree.build(y);
        tree.neighbours(r, true, found);
        Neighbours along;
        tree.neighbours_along_curve(r, true, along);
        if (first_order.empty()) {
          first = found;
          first_along = along;
          first_order.assign(tree.order().begin(), tree.order().end());
          ASSERT_GT(found.list.size(), x.size());
        }
        ASSERT_TRUE(std::equal(first_order.begin(), first_order.end(), tree.order().begin()));
        expect_equal(found, first, std::to_string(n_threads) + " threads");
        expect_equal(along, first_along, std::to_string(n_threads) + " threads, along the curve");
      }
  }
}

/// A key worked out bit by bit, in the cube around the cloud.
static std::uint64_t key_by_bits(const Vec3& x, const Vec3& low, double extent) {
  std::uint64_t key = 0;
  for (int bit = 20; bit >= 0; --bit)
    for (int d = 0; d < 3; ++d) {
      const double cell = std::min(std::floor((x[d] - low[d]) * (0x1p21 / extent)), 0x1p21 - 1);
      key = key << 1 | (static_cast<std::uint64_t>(cell) >> bit & 1);
    }
  return key;
}

TEST_F(OctreeTest, OrderIsAPermutationSortedByKeyThenIndex) {
  std::mt19937 random(5);
  Cloud x;
  for (int i = 0; i < 50000; ++i) x.push_back(in_cube(random).cwiseProduct(Vec3(3, 1, 2)));
  for (int i = 0; i < 100; ++i) x[std::size_t(3 * i + 1)] = x[std::size_t(300 * i)];  // equal keys
  Vec3 low = x[0], high = x[0];
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Octree tree;
  tree.build(x);
  Cloud nearly = in_order(x, tree.order());
  for (Vec3& p : nearly) p = (p + 1e-3 * (in_cube(random) - Vec3::Constant(0.5))).cwiseMax(low).cwiseMin(high);
  nearly[0] = low;
  nearly[1] = high;
  for (const Cloud& y : {x, nearly})
    for (const int n_threads : {1, 2, 7}) {
      core::set_threads(n_threads);
      tree.build(y);
      std::vector<std::uint32_t> all(tree.order().begin(), tree.order().end());
      for (std::size_t k = 1; k < all.size(); ++k) {
        const auto a = std::pair(key_by_bits(y[all[k - 1]], low, (high - low).maxCoeff()), all[k - 1]);
        const auto b = std::pair(key_by_bits(y[all[k]], low, (high - low).maxCoeff()), all[k]);
        ASSERT_LT(a, b) << k;
      }
      std::sort(all.begin(), all.end());
      for (std::size_t k = 0; k < all.size(); ++k) ASSERT_EQ(all[k], k);
    }
}

TEST_F(OctreeTest, BoxesHoldWhatBruteForceFinds) {
  std::mt19937 random(6);
  for (const NamedCloud& c : clouds()) {
    Octree tree;
    tree.build(c.x);
    for (int rep = 0; rep < 50 && !c.x.empty(); ++rep) {
      const Vec3 a = c.x[random() % c.x.size()], b = c.x[random() % c.x.size()];
      Vec3 low = a.cwiseMin(b), high = a.cwiseMax(b);
      if (rep == 0) low.setConstant(-1e300), high.setConstant(1e300);
      if (rep == 1) low.setConstant(-HUGE_VAL), high.setConstant(HUGE_VAL);
      if (rep == 2) std::swap(low, high);
      std::vector<std::uint32_t> found{42}, expected{42};
      tree.in_box(low, high, found);
      for (std::size_t i = 0; i < c.x.size(); ++i)
        if ((c.x[i].array() >= low.array()).all() && (c.x[i].array() <= high.array()).all())
          expected.push_back(static_cast<std::uint32_t>(i));
      ASSERT_EQ(found, expected) << c.name;
    }
  }
}

TEST_F(OctreeTest, OneTreeServesCloudsOfAnySizeInTurn) {
  std::mt19937 random(7);
  Octree tree;
  Neighbours found;
  for (const std::size_t n : {3000u, 10u, 0u, 500u, 2999u}) {
    Cloud x;
    for (std::size_t i = 0; i < n; ++i) x.push_back(in_cube(random));
    const Radii r(n, 0.1);
    tree.build(x);
    tree.neighbours(r, false, found);
    expect_equal(found, brute_force(x, r, false), std::to_string(n) + " points");
  }
}

TEST_F(OctreeTest, RadiiMustMatchThePoints) {
  Octree tree;
  tree.build(Cloud(3, Vec3::Zero()));
  Neighbours found;
  EXPECT_THROW(tree.neighbours(Radii(2, 1.0), false, found), std::invalid_argument);
}
