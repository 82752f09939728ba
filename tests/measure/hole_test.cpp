// SPDX-License-Identifier: Apache-2.0
// Holes of known shape. The mean radius of a polygon with n corners on a circle is below the circle's by (pi/n)^2 / 3.
#include "synthetic.hpp"

using namespace synthetic;

namespace {

constexpr double width = 30 * mm, thickness = 0.8 * mm;

measure::Result measured(const measure::Matter& m, const Vec3& center = {0, 0, 0}, const Vec3& normal = {0, 0, 1}) {
  measure::Scene s = scene_at();
  add_plate(s, "bumper", width, thickness, center, normal);
  return measure::measure(m, s);
}

}  // namespace

TEST(Hole, BodyFittedCircleIsExact) {
  for (const int layers : {1, 2, 3, 4}) {
    measure::Matter m;
    add_block(m, ring_plate(width, thickness, 3.9 * mm, 3.9 * mm, 96, 12, layers));
    const measure::Result r = measured(m);
    EXPECT_EQ(get(r, "bumper.perforated"), 1);
    EXPECT_NEAR(get(r, "bumper.hole_diameter"), 7.8 * mm, 7.8 * mm * 4e-4) << layers;
    EXPECT_NEAR(get(r, "bumper.hole_diameter_min"), 7.8 * mm, 7.8 * mm * 1.1e-3);
    EXPECT_NEAR(get(r, "bumper.hole_diameter_max"), 7.8 * mm, 7.8 * mm * 1e-3);
  }
}

TEST(Hole, ShiftsByLessThanAnElementAreSeen) {
  for (const double radius : {3.80, 3.83, 3.86}) {
    measure::Matter m;
    add_block(m, ring_plate(width, thickness, radius * mm, radius * mm, 96, 12, 3));
    EXPECT_NEAR(get(measured(m), "bumper.hole_diameter"), 2 * radius * mm, 2 * radius * mm * 4e-4);
  }
}

TEST(Hole, StaircaseIsWithinPartOfAnElement) {
  measure::Matter m;
  Block b = plate(width, thickness, 150, 4);  // elements of 0.2 mm
  b.keep = [](const Vec3& x) { return std::hypot(x.x() - 2 * mm, x.y() + mm) > 3.9 * mm; };  // off the centre
  add_block(m, b);
  const double d = get(measured(m), "bumper.hole_diameter");
  // elements are cut by their centres, so what is left begins on average a fraction of half an element inside
  EXPECT_NEAR(d, 7.8 * mm, 0.1 * mm);
}

TEST(Hole, TiltedAndShiftedPlate) {
  const Vec3 normal = Vec3(1, 0.3, 1).normalized(), center(3 * mm, -mm, -7 * mm);
  measure::Matter m;
  Block b = ring_plate(width, thickness, 3.9 * mm, 3.9 * mm, 96, 12, 3);
  b.place = [&](const Vec3& x) { return Vec3(center + turn(normal) * x); };
  add_block(m, b);
  EXPECT_NEAR(get(measured(m, center, normal), "bumper.hole_diameter"), 7.8 * mm, 7.8 * mm * 4e-4);
  EXPECT_NEAR(get(measured(m, center, -normal), "bumper.hole_diameter"), 7.8 * mm, 7.8 * mm * 4e-4);
}

TEST(Hole, NearTheEndOfAnOblongPlateWhicheverWayItFaces) {
  // own x and y lie along y and z where the normal is along x, along z and x where it is along y, as meshes are built (core/orientation.hpp)
  const double length = 60 * mm, across = 16 * mm;
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0.5, 0.2, 1), Vec3(-0.5, -0.2, -1)}) {
    const Vec3 up = normal.sum() < 0 ? Vec3(-normal) : normal;
    core::Mat3 axes = turn(up);
    if (up[0] == 1) axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    if (up[1] == 1) axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    measure::Matter m;
    Block b;
    b.n[0] = 300, b.n[1] = 80, b.n[2] = 2;
    b.low = Vec3(-length, -across, -thickness) / 2, b.high = -b.low;
    b.body = 1;
    b.keep = [](const Vec3& x) { return std::hypot(x.x() - 18 * mm, x.y()) > 3.9 * mm; };
    b.place = [&](const Vec3& x) { return Vec3(axes * x); };
    add_block(m, b);
    measure::Scene s = scene_at(-impact_speed * normal.normalized());
    add_plate(s, "bumper", length, thickness, {0, 0, 0}, normal);
    s.bodies[1].extent = Vec3(length, across, thickness);
    EXPECT_NEAR(get(measure::measure(m, s), "bumper.hole_diameter"), 7.8 * mm, 0.1 * mm) << normal.transpose();
  }
}

TEST(Hole, OfAPlateThatFliesIsThatOfOneAtRest) {
  const Vec3 velocity(0, 50, 500);
  measure::Matter m;
  Block b = ring_plate(width, thickness, 3.9 * mm, 3.9 * mm, 96, 12, 3);
  const double time = 20e-6;
  b.place = [&](const Vec3& x) { return Vec3(x + time * velocity); };
  b.v = velocity;
  add_block(m, b);
  measure::Scene s = scene_at();
  add_plate(s, "bumper", width, thickness);
  s.bodies[1].velocity = velocity;
  s.time = time;
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "bumper.hole_diameter"), 7.8 * mm, 7.8 * mm * 4e-4);
  EXPECT_NEAR(get(r, "bumper.rim_displacement"), 0, 1e-12);
}

TEST(Hole, EllipseHasItsAxes) {
  measure::Matter m;
  add_block(m, ring_plate(width, thickness, 5 * mm, 3 * mm, 160, 12, 3));
  const measure::Result r = measured(m);
  EXPECT_NEAR(get(r, "bumper.hole_diameter_min"), 6 * mm, 6e-3 * mm);
  EXPECT_NEAR(get(r, "bumper.hole_diameter_max"), 10 * mm, 1e-2 * mm);
  double mean = 0;  // of 2 r(azimuth)
  for (int i = 0; i < 3600; ++i) {
    const double a = 2 * core::pi * i / 3600;
    mean += 2 / std::hypot(std::cos(a) / (5 * mm), std::sin(a) / (3 * mm)) / 3600;
  }
  EXPECT_NEAR(get(r, "bumper.hole_diameter"), mean, 1e-3 * mean);
}

TEST(Hole, BentLipCountsWhereItsEdgeIs) {
  measure::Matter m;
  Block b = ring_plate(width, thickness, 4 * mm, 4 * mm, 96, 24, 2);
  const auto flat = b.map;
  b.map = [=](const Vec3& x) {  // bends back by two thicknesses towards the hole
    Vec3 y = flat(x);
    y.z() -= 2 * thickness * std::exp(-(std::hypot(y.x(), y.y()) - 4 * mm) / mm);
    return y;
  };
  add_block(m, b);
  const measure::Result r = measured(m);
  EXPECT_NEAR(get(r, "bumper.hole_diameter"), 8 * mm, 8 * mm * 4e-4);
  EXPECT_NEAR(get(r, "bumper.bulge"), 2 * thickness, 1e-2 * thickness);
}

TEST(Hole, ABiteIsAsWideAsFromEdgeToEdge) {
  // Half a disc of radius 9 mm bitten out of the plate's edge. Lines that find an edge on one side alone do not count: their single
  // radii, short towards the middle of the plate, would make the mean less than the least width.
  measure::Matter m;
  Block b = plate(width, thickness, 150, 4);
  b.keep = [](const Vec3& x) { return std::hypot(x.x() - 0.5 * width, x.y()) > 9 * mm; };
  add_block(m, b);
  const measure::Result r = measured(m);
  EXPECT_EQ(get(r, "bumper.perforated"), 1);
  const double d = get(r, "bumper.hole_diameter"), least = get(r, "bumper.hole_diameter_min"), most = get(r, "bumper.hole_diameter_max");
  EXPECT_LE(least, d);
  EXPECT_LE(d, most);
  EXPECT_LE(most, 18.5 * mm);
}

TEST(Hole, FastMaterialAndDetachedMaterialDoNotCount) {
  measure::Matter m;
  add_block(m, ring_plate(width, thickness, 4 * mm, 4 * mm, 96, 12, 2));
  Block scrap = plate(mm, 0.4 * mm, 2, 1);  // slow, inside the hole, touches nothing
  add_block(m, scrap);
  add_particle(m, {3.5 * mm, 0, 0}, {0, 0, -2000}, 0.6 * mm, 1);  // near the edge, but flying
  EXPECT_NEAR(get(measured(m), "bumper.hole_diameter"), 8 * mm, 8 * mm * 4e-4);
}

TEST(Hole, PlateThatStillBendsIsWhole) {
  measure::Matter m;
  add_block(m, ring_plate(width, thickness, 4 * mm, 4 * mm, 96, 12, 2));
  const double speed = scene_at().impact_velocity.norm();
  for (std::size_t el = 0; el < m.n_elements; ++el)
    if (m.x[el].head<2>().norm() < 8 * mm) m.v.own[el] = Vec3(0, 0, -0.03 * speed);
  EXPECT_NEAR(get(measured(m), "bumper.hole_diameter"), 8 * mm, 8 * mm * 4e-4);
  for (std::size_t el = 0; el < m.n_elements; ++el)  // a ring that departs, though it still touches
    if (m.x[el].head<2>().norm() < 8 * mm) m.v.own[el] = Vec3(0, 0, -0.2 * speed);
  EXPECT_GT(get(measured(m), "bumper.hole_diameter"), 12 * mm);
}

TEST(Hole, BondedParticlesFormTheEdge) {
  measure::Matter m;
  add_block(m, ring_plate(width, thickness, 4 * mm, 4 * mm, 96, 12, 4));
  const double spacing = 0.2 * mm, radius = 3.9 * mm;
  const int n = 122;  // neighbours touch
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k) {
      const double a = 2 * core::pi * i / n;
      add_particle(m, {radius * std::cos(a), radius * std::sin(a), (k - 1.5) * spacing}, {0, 0, 1}, spacing, 1);
    }
  // the mean of a disc's front is pi/8 of its spacing before its centre
  const double expected = 2 * (radius - core::pi / 8 * spacing);
  EXPECT_NEAR(get(measured(m), "bumper.hole_diameter"), expected, 0.01 * mm);
}

TEST(Hole, APlateOfParticlesMayBendAsOneOfElementsMay) {
  // a slow shot: 1 % of its speed is 10 m/s, and the plate still bends at up to 60
  const double radius = 3 * mm, spacing = 0.4 * mm;
  const auto bending = [&](const Vec3& x) { return Vec3(0, 0, -60 * std::max(0.0, 1 - x.head<2>().norm() / (0.5 * width))); };
  const auto shot = [&](bool one_element) {
    measure::Matter m;
    if (one_element) {  // at the edge: a plate of mode hybrid, whose particles are what has become of its lip
      Block b;
      b.low = Vec3(0.5 * width - spacing, -0.5 * spacing, -0.5 * thickness), b.high = Vec3(0.5 * width, 0.5 * spacing, 0.5 * thickness);
      b.body = 1;
      add_block(m, b);
    }
    const int n = static_cast<int>(std::lround(width / spacing));
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const Vec3 x = Vec3(i + 0.5 - 0.5 * n, j + 0.5 - 0.5 * n, k - 0.5) * spacing;
          if (x.head<2>().norm() > radius) add_particle(m, x, bending(x), spacing, 1);
        }
    measure::Scene s = scene_at({0, 0, -1000});
    add_plate(s, "bumper", width, thickness);
    return measure::measure(m, s);
  };
  const auto r = shot(false);
  EXPECT_NEAR(get(r, "bumper.hole_diameter"), 2 * radius, spacing);
  EXPECT_EQ(get(r, "bumper.debris_mass_behind"), 0);
  EXPECT_NEAR(get(r, "bumper.bulge"), 0, 1e-12);
  EXPECT_GT(get(shot(true), "bumper.hole_diameter"), 3 * radius);
}
