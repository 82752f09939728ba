// SPDX-License-Identifier: Apache-2.0
// A bar with a known outline: of elements on a cone, quarter or whole, and of particles; chips beside it count for nothing.
#include "tests/measure/synthetic.hpp"

namespace {

using namespace synthetic;

constexpr double length_0 = 25 * mm, length = 20 * mm, foot = 6 * mm, top = 3 * mm;  // radii

/// Straight from the foot's radius to the top's; the corners of a square block lie on it.
double radius(double height) { return foot + (top - foot) * height / length; }

measure::Scene scene(const Vec3& normal) {
  auto s = scene_at(-190.0 * normal);
  auto& bar = s.bodies[0];
  bar.name = "bar";
  bar.center = 0.5 * length_0 * normal + Vec3(1, 2, 3) * mm;
  bar.normal = bar.bar_axis = normal;
  bar.extent = Vec3(2 * top, 2 * top, length_0);
  return s;
}

/// The bar along z with its foot at the wall; `low`: 0 for a quarter, -1 for the whole.
Block cone(const measure::Scene& s, double low, int layers) {
  Block b;
  b.n[0] = b.n[1] = low < 0 ? 8 : 4, b.n[2] = layers;
  b.low = {low, low, 0}, b.high = {1, 1, length};
  b.map = [](const Vec3& x) { return Vec3(x[0] * radius(x[2]) / std::sqrt(2.0), x[1] * radius(x[2]) / std::sqrt(2.0), x[2]); };
  const auto& bar = s.bodies[0];
  const core::Mat3 axes = turn(bar.bar_axis);
  const Vec3 wall = bar.center - 0.5 * length_0 * bar.bar_axis;
  b.place = [axes, wall](const Vec3& x) { return Vec3(axes * x + wall); };
  return b;
}

void expect_cone(const measure::Result& r, double slice) {
  EXPECT_NEAR(get(r, "bar.final_length"), length, 1e-12);
  EXPECT_NEAR(get(r, "bar.foot_diameter"), 2 * foot, 1e-12);
  EXPECT_NEAR(get(r, "bar.diameter_at_fifth"), 2 * radius(0.2 * length_0), slice);
}

TEST(Bar, LengthAndOutlineOfACone) {
  for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(0.6, 0, 0.8)}) {
    const auto s = scene(normal);
    measure::Matter m;
    add_block(m, cone(s, -1, 80));
    // twice the largest radius within 0.02 L0 stands lower by less than that
    expect_cone(measure::measure(m, s), 2 * (foot - top) * 0.02 * length_0 / length);
  }
}

TEST(Bar, AQuarterIsMirrored) {
  auto s = scene({0, 0, 1});
  s.bodies[0].center = {0, 0, 0.5 * length_0};
  s.symmetry.plane = {true, true, false};
  measure::Matter m;
  add_block(m, cone(s, 0, 80));
  expect_cone(measure::measure(m, s), 2 * (foot - top) * 0.02 * length_0 / length);
}

TEST(Bar, BetweenRowsOfNodesTheOutlineIsInterpolated) {
  const auto s = scene({0, 0, 1});
  measure::Matter m;
  add_block(m, cone(s, -1, 13));  // rows 1.54 mm apart, slices 1 mm high: none about 5 mm
  const auto r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "bar.diameter_at_fifth"), 2 * radius(5 * mm), 0.15 * mm);
}

TEST(Bar, WhatBrokeOffIsNoBar) {
  const auto s = scene({0, 0, 1});
  measure::Matter m;
  add_block(m, cone(s, -1, 80));
  const Vec3 wall = s.bodies[0].center - Vec3(0, 0, 0.5 * length_0);
  add_particle(m, wall + Vec3(20 * mm, 0, 0.2 * mm), {300, 0, 0}, 0.3 * mm, 0);
  add_particle(m, wall + Vec3(0, 0, 40 * mm), {0, 0, 50}, 0.3 * mm, 0);
  expect_cone(measure::measure(m, s), 2 * (foot - top) * 0.02 * length_0 / length);
}

TEST(Bar, ParticlesReachBeyondTheirCentres) {
  const auto s = scene({0, 0, 1});
  measure::Matter m;
  const double d = 0.5 * mm;
  const Vec3 wall = s.bodies[0].center - Vec3(0, 0, 0.5 * length_0);
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = 0; k < 40; ++k)
        if (i * i + j * j <= 36) add_particle(m, wall + Vec3(i * d, j * d, (k + 0.5) * d), Vec3::Zero(), d, 0);
  const auto r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "bar.final_length"), 40 * d, 1e-12);
  for (const char* key : {"bar.foot_diameter", "bar.diameter_at_fifth"}) EXPECT_NEAR(get(r, key), 13 * d, 1e-12) << key;
}

TEST(Bar, IsOnlyWhatStruckAWallEndOn) {
  auto s = scene({0, 0, 1});
  measure::Matter m;
  add_block(m, cone(s, -1, 20));
  s.bodies[0].bar_axis.setZero();
  EXPECT_FALSE(find(measure::measure(m, s), "bar.final_length"));
}

}  // namespace
