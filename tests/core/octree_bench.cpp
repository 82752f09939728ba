// SPDX-License-Identifier: Apache-2.0
// Times the octree: median milliseconds to build and to find all neighbours of a jittered lattice and, with --points FILE
// (float32 x y z radius a point), of that cloud with one radius for all and with its own radii. Before each repetition
// every point is moved a little, as in a time step. Not a test.
//   octree_bench [--points FILE] [--threads N] [--reps N] [--side N] [--isa baseline|avx2|avx512] [--symmetric]
//                [--set one|own] [--sort | --shuffle]
// --sort stores the points along the curve before each repetition; --shuffle at random.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numeric>
#include <random>
#include <string>

#include "core/octree.hpp"
#include "core/parallel.hpp"

using core::Vec3;

struct Options {
  std::string points, set;
  int threads = 1, reps = 7, side = 100;
  bool symmetric = false, sort = false, shuffle = false;
  core::Isa isa = core::isa();
};

/// Processor time of one thread, or time on the wall of several.
static double now_ms(int threads) {
  if (threads == 1) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  return 1e-6 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

static double median(std::vector<double> t) {
  std::sort(t.begin(), t.end());
  return t[t.size() / 2];
}

template <class T>
static std::vector<T> permuted(const std::vector<T>& a, std::span<const std::uint32_t> order) {
  std::vector<T> b(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) b[k] = a[order[k]];
  return b;
}

static void time_cloud(const char* name, std::vector<Vec3> base, std::vector<double> radius, const Options& o) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> shift(-0.02f, 0.02f);
  core::Octree tree;
  tree.set_isa(o.isa);
  tree.build(base);
  std::vector<std::uint32_t> order(tree.order().begin(), tree.order().end());
  if (o.shuffle) std::shuffle(order.begin(), order.end(), random);
  base = permuted(base, order);
  radius = permuted(radius, order);
  core::Neighbours found;
  std::vector<double> build, query, both;
  for (int rep = -1; rep < o.reps; ++rep) {
    std::vector<Vec3> x = base;
    for (Vec3& p : x)
      for (int d = 0; d < 3; ++d) p[d] = static_cast<float>(p[d]) + shift(random);
    std::vector<double> r = radius;
    if (o.sort) {
      tree.build(x);
      x = permuted(x, tree.order());
      r = permuted(r, tree.order());
    }
    const double t_0 = now_ms(o.threads);
    tree.build(x);
    const double t_1 = now_ms(o.threads);
    tree.neighbours(r, o.symmetric, found);
    const double t_2 = now_ms(o.threads);
    if (rep < 0) continue;
    build.push_back(t_1 - t_0);
    query.push_back(t_2 - t_1);
    both.push_back(t_2 - t_0);
  }
  std::printf("%-18s %8zu points %7.2f neighbours each; build %6.1f ms, query %6.1f ms, both %6.1f ms\n", name, base.size(),
              static_cast<double>(found.list.size()) / static_cast<double>(base.size()), median(build), median(query),
              median(both));
}

int main(int argc, char** argv) {
  Options o;
  for (int a = 1; a < argc; ++a) {
    const std::string key = argv[a];
    const auto value = [&]() -> std::string { return a + 1 < argc ? argv[++a] : ""; };
    if (key == "--points") o.points = value();
    else if (key == "--set") o.set = value();
    else if (key == "--threads") o.threads = std::atoi(value().c_str());
    else if (key == "--reps") o.reps = std::atoi(value().c_str());
    else if (key == "--side") o.side = std::atoi(value().c_str());
    else if (key == "--symmetric") o.symmetric = true;
    else if (key == "--sort") o.sort = true;
    else if (key == "--shuffle") o.shuffle = true;
    else if (key == "--isa") {
      const std::string isa = value();
      o.isa = isa == "baseline" ? core::Isa::baseline : isa == "avx2" ? core::Isa::avx2 : core::Isa::avx512;
    } else {
      std::printf("unknown option %s; see the head of octree_bench.cpp\n", key.c_str());
      return 2;
    }
  }
  core::set_threads(o.threads);
  const double r = std::cbrt(61.0 * 3 / (4 * core::pi));  // about 60 neighbours where there is one point in a unit volume

  if (o.side > 0) {
    std::mt19937 random(42);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2);
    std::vector<Vec3> x;
    for (int k = 0; k < o.side; ++k)
      for (int j = 0; j < o.side; ++j)
        for (int i = 0; i < o.side; ++i) x.push_back(Vec3(i + jitter(random), j + jitter(random), k + jitter(random)));
    time_cloud("lattice", x, std::vector<double>(x.size(), r), o);
  }
  if (o.points.empty()) return 0;
  std::FILE* file = std::fopen(o.points.c_str(), "rb");
  if (!file) {
    std::printf("cannot open %s\n", o.points.c_str());
    return 2;
  }
  std::vector<Vec3> x;
  std::vector<double> radius;
  for (float p[4]; std::fread(p, sizeof p, 1, file) == 1;) {
    x.push_back(Vec3(p[0], p[1], p[2]));
    radius.push_back(p[3]);
  }
  std::fclose(file);
  if (o.set != "own") time_cloud("cloud, one radius", x, std::vector<double>(x.size(), r), o);
  if (o.set != "one") time_cloud("cloud, own radii", x, radius, o);
}
