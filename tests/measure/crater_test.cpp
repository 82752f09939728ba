// SPDX-License-Identifier: Apache-2.0
// A hemispherical crater with a lip, in a box whose mesh follows it and in one cut in steps.
#include "synthetic.hpp"

using namespace synthetic;

namespace {

constexpr double width = 40 * mm, thickness = 20 * mm, radius = 6 * mm, lip = mm;

measure::Result measured(const measure::Matter& m) {
  measure::Scene s = scene_at();
  add_plate(s, "target", width, thickness, {0, 0, -thickness / 2});
  return measure::measure(m, s);
}

/// Columns of elements pressed down to the bottom of a crater, with a lip that falls off outside it.
Vec3 pressed(const Vec3& x) {
  const double r = std::hypot(x.x(), x.y());
  const double front = r < radius ? -std::sqrt(radius * radius - r * r) : lip * std::exp(-(r - radius) / mm);
  const double part = (x.z() + thickness) / thickness;  // 0 at the back, 1 at the front
  return {x.x(), x.y(), -thickness + part * (thickness + front)};
}

}  // namespace

TEST(Crater, HemisphereWithLip) {
  measure::Matter m;
  Block b = plate(width, thickness, 160, 8);
  b.low.z() = -thickness, b.high.z() = 0;
  b.map = pressed;
  add_block(m, b);
  const measure::Result r = measured(m);
  EXPECT_NEAR(get(r, "target.crater_depth"), radius, 0.01 * radius);
  // nodes stand 0.25 mm apart, so the wall between the last one inside and the first on the lip is that far from sharp
  EXPECT_NEAR(get(r, "target.crater_diameter"), 2 * radius, 0.25 * mm);
  EXPECT_NEAR(get(r, "target.crater_lip_height"), lip, 0.15 * lip);
  EXPECT_EQ(get(r, "target.perforated"), 0);
  EXPECT_NEAR(get(r, "target.bulge"), 0, 1e-12);
}

TEST(Crater, StaircaseOfMissingElements) {
  measure::Matter m;
  Block b = plate(width, thickness, 100, 50);  // elements of 0.4 mm
  b.low.z() = -thickness, b.high.z() = 0;
  b.keep = [](const Vec3& x) { return x.norm() > radius; };
  add_block(m, b);
  add_particle(m, {mm, 0, -mm}, {0, 0, 3}, 0.4 * mm, 1);  // loose, inside the crater
  const measure::Result r = measured(m);
  EXPECT_NEAR(get(r, "target.crater_depth"), radius, 0.2 * mm);
  EXPECT_NEAR(get(r, "target.crater_diameter"), 2 * radius, 0.25 * mm);
  EXPECT_EQ(get(r, "target.crater_lip_height"), 0);
}

TEST(Crater, OfADishedWallHasNoDiameter) {
  Block b = plate(20 * mm, 2 * mm, 80, 8);
  b.keep = [](const Vec3& x) { return x.z() < 0.5 * mm || std::hypot(x.x(), x.y()) > mm; };  // a pit 1 mm in radius
  b.map = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 2 * mm * std::exp(-x.head<2>().squaredNorm() / (16 * mm * mm)))); };
  measure::Matter m;
  add_block(m, b);
  measure::Scene s = scene_at();
  add_plate(s, "wall", 20 * mm, 2 * mm);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "wall.perforated"), 0);
  EXPECT_FALSE(find(r, "wall.crater_diameter"));
  EXPECT_NEAR(get(r, "wall.crater_depth"), 2.5 * mm, 0.05 * mm);
  EXPECT_NEAR(get(r, "wall.bulge"), 2 * mm, 1e-9);
}

TEST(Crater, APerforatedPlateHasNoDiameterHoweverCleanItsHole) {
  Block b = plate(20 * mm, mm, 80, 4);
  b.keep = [](const Vec3& x) { return std::hypot(x.x(), x.y()) > 3 * mm; };
  measure::Matter m;
  add_block(m, b);
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, mm);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "bumper.perforated"), 1);
  EXPECT_FALSE(find(r, "bumper.crater_depth"));
  EXPECT_FALSE(find(r, "bumper.crater_diameter"));
}
