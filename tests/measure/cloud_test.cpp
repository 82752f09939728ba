// SPDX-License-Identifier: Apache-2.0
// Clouds of particles whose angles, velocities and masses are known.
#include "synthetic.hpp"

using namespace synthetic;

namespace {

constexpr double degree = core::pi / 180;

/// n particles on a cone about the axis `d` from `tip`, speed `v`, at `distance` from the tip.
void add_cone(measure::Matter& m, const Vec3& tip, const Vec3& d, double angle, int n, double v, double distance,
              double spacing, int body) {
  const core::Mat3 t = turn(d);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * core::pi * (i + 0.5) / n;
    const Vec3 u = t * Vec3(std::sin(angle) * std::cos(a), std::sin(angle) * std::sin(a), std::cos(angle));
    add_particle(m, tip + distance * u, v * u, spacing, body);
  }
}

}  // namespace

TEST(Cloud, AnglesOfCones) {
  measure::Matter m;
  const Vec3 tip(0, 0, 0), d(0, 0, -1);
  add_cone(m, tip, d, 10 * degree, 50, 7000, 30 * mm, 0.2 * mm, 0);
  add_cone(m, tip, d, 29 * degree, 50, 6000, 30 * mm, 0.2 * mm, 1);   // 90 % of the momentum lies within these
  add_cone(m, tip, d, 60 * degree, 10, 1000, 30 * mm, 0.2 * mm, 1);   // slow and wide
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 40 * mm, 0.8 * mm);
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "cloud.spray_half_angle"), 29 * degree, 1e-9);
  EXPECT_NEAR(get(r, "cloud.fast_half_angle"), 29 * degree, 1e-9);
  EXPECT_NEAR(get(r, "cloud.half_angle_outer_projectile"), 10 * degree, 1e-9);
  EXPECT_NEAR(get(r, "cloud.envelope_half_angle"), 60 * degree, 1e-9);
  EXPECT_NEAR(get(r, "cloud.axial_velocity_front"), 7000 * std::cos(10 * degree), 1e-6);
  EXPECT_NEAR(get(r, "cloud.axial_velocity_rear"), 1000 * std::cos(60 * degree), 1e-6);
  EXPECT_NEAR(get(r, "cloud.radial_velocity_max"), 6000 * std::sin(29 * degree), 1e-6);
  EXPECT_NEAR(get(r, "cloud.length"), 30 * mm * (std::cos(10 * degree) - std::cos(60 * degree)), 1e-9);
  EXPECT_NEAR(get(r, "cloud.width"), 60 * mm * std::sin(60 * degree), 1e-9);
  const double one = rho_0 * std::pow(0.2 * mm, 3);
  EXPECT_NEAR(get(r, "cloud.mass"), 110 * one, 1e-12 * one);
  EXPECT_NEAR(get(r, "cloud.momentum"), one * (350000 * std::cos(10 * degree) + 300000 * std::cos(29 * degree) + 5000), 1e-9 * one);
}

TEST(Cloud, FollowsAnObliqueLineOfFlight) {
  measure::Matter m;
  const Vec3 d = Vec3(1, 0, -1).normalized();
  add_cone(m, {mm, 0, 0}, d, 20 * degree, 64, 6000, 30 * mm, 0.2 * mm, 0);
  measure::Scene s = scene_at(impact_speed * d);
  s.aim = Vec3(0.6 * mm, 0, 0.4 * mm);
  add_plate(s, "bumper", 40 * mm, 0.8 * mm);
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "cloud.spray_half_angle"), 20 * degree, 1e-9);
  EXPECT_NEAR(get(r, "cloud.envelope_half_angle"), 20 * degree, 1e-9);
}

TEST(Cloud, EmptyOneHasNoAngles) {
  measure::Matter m;
  add_block(m, plate(20 * mm, 0.8 * mm, 10, 2));
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, 0.8 * mm);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "cloud.mass"), 0);
  EXPECT_EQ(get(r, "fragments.count"), 0);
  for (const char* key : {"cloud.spray_half_angle", "cloud.length", "cloud.melt_fraction", "fragments.largest_mass"})
    EXPECT_FALSE(find(r, key)) << key;
  for (const auto& v : r.values) EXPECT_TRUE(std::isfinite(v.value)) << v.key;
}

TEST(Cloud, MeltFractionIsLinearInEnergy) {
  measure::Matter m;
  for (int i = 0; i < 4; ++i) {
    add_particle(m, {0, i * mm, -9 * mm}, {0, 0, -5000}, 0.2 * mm, i == 3 ? 0 : 1);
    m.e.own.back() = 1e5 * i;  // 0, half molten, molten; the last one of another body
  }
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, 0.8 * mm);
  s.bodies[1].e_melt = 0.5e5, s.bodies[1].e_melted = 1.5e5;
  s.bodies[0].e_melt = 2e5, s.bodies[0].e_melted = 6e5;
  s.bodies[0].e_vapour = 2.5e5, s.bodies[0].e_vaporised = 3.5e5;
  s.bodies[1].e_vapour = 2.5e5, s.bodies[1].e_vaporised = 3.5e5;
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "cloud.melt_fraction"), (0 + 0.5 + 1 + 0.25) / 4, 1e-12);
  EXPECT_NEAR(get(r, "cloud.projectile_melt_fraction"), 0.25, 1e-12);
  EXPECT_NEAR(get(r, "cloud.vapour_fraction"), 0.125, 1e-12);
}

TEST(Cloud, WhatMeltsAtNoKnownEnergyHasNoMeltFraction) {
  measure::Matter m;
  add_particle(m, {0, 0, -9 * mm}, {0, 0, -5000}, 0.2 * mm, 0);
  add_particle(m, {0, mm, -9 * mm}, {0, 0, -5000}, 0.2 * mm, 1);
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, 0.8 * mm);
  s.bodies[0].e_melt = 2e5, s.bodies[0].e_melted = 6e5;
  const measure::Result r = measure::measure(m, s);
  EXPECT_TRUE(find(r, "cloud.mass").has_value());
  EXPECT_FALSE(find(r, "cloud.melt_fraction").has_value());
  EXPECT_FALSE(find(r, "cloud.vapour_fraction").has_value());
  EXPECT_TRUE(find(r, "cloud.projectile_melt_fraction").has_value());
}

TEST(Cloud, WhatStoodBehindThePlateIsNoneOfIt) {
  measure::Matter m;
  measure::Scene s = scene_at();
  add_block(m, plate(20 * mm, mm, 20, 2));
  add_plate(s, "bumper", 20 * mm, mm);
  for (const double z : {-30 * mm, 30 * mm}) {  // bodies 2 and 3, no plates
    measure::BodyScene rod;
    rod.name = z < 0 ? "behind" : "before";
    rod.center = Vec3(0, 0, z);
    s.bodies.push_back(rod);
  }
  for (const int body : {0, 1, 2, 3}) add_particle(m, {0, 0, -9 * mm}, {0, 0, -5000}, (0.1 + 0.1 * body) * mm, body);
  const double mass = rho_0 * 1e-12 * (1 + 8 + 64);  // edges of 0.1, 0.2 and 0.4 mm; 0.3 mm stood behind
  EXPECT_NEAR(get(measure::measure(m, s), "cloud.mass"), mass, 1e-12 * mass);
}

TEST(Cloud, MassBehindThreePlatesAt45Degrees) {
  measure::Matter m;
  measure::Scene s = scene_at();
  const Vec3 normal = Vec3(1, 0, 1).normalized();
  const double width = 30 * mm;
  for (int k = 0; k < 3; ++k) {
    const Vec3 center(0, 0, -38 * mm * k);
    const int body = add_plate(s, "plate" + std::to_string(k + 1), width, mm, center, normal);
    Block b = plate(width, mm, 30, 2);
    b.body = body;
    b.place = [=](const Vec3& x) { return Vec3(center + turn(normal) * x); };
    if (k < 2) b.keep = [](const Vec3& x) { return std::hypot(x.x(), x.y()) > 3 * mm; };
    add_block(m, b);
  }
  const double d = 0.5 * mm, one = rho_0 * d * d * d;
  const Vec3 down(100, 50, -5000);
  for (int i = 0; i < 6; ++i) add_particle(m, {0, 2 * i * mm, -10 * mm}, down, d, i % 2);           // behind plate 1
  for (int i = 0; i < 4; ++i) add_particle(m, {5 * mm, 2 * i * mm, -50 * mm}, down, d, 1 + i % 2);  // behind plate 2
  for (int i = 0; i < 3; ++i) add_particle(m, {-5 * mm, 2 * i * mm, 15 * mm}, {800, 0, 900}, d, 1); // ejecta
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "plate1.debris_mass_behind") / one, 8, 1e-9);  // two of ten come from plate 2
  EXPECT_NEAR(get(r, "plate2.debris_mass_behind") / one, 4, 1e-9);
  EXPECT_EQ(get(r, "plate3.debris_mass_behind"), 0);
  EXPECT_NEAR(get(r, "cloud.mass") / one, 8, 1e-9);
  EXPECT_NEAR(get(r, "plate2.cloud.mass") / one, 4, 1e-9);
  EXPECT_NEAR(get(r, "ejecta.mass") / one, 3, 1e-9);
  EXPECT_NEAR(get(r, "ejecta.momentum") / one, 2700, 1e-6);
  EXPECT_EQ(get(r, "plate2.perforated"), 1);
  EXPECT_EQ(get(r, "plate3.perforated"), 0);
  const measure::Result second = measure::measure_cloud(m, s, 1);
  EXPECT_EQ(get(second, "plate2.cloud.mass"), get(r, "plate2.cloud.mass"));
  EXPECT_FALSE(find(second, "cloud.mass"));
}

TEST(Cloud, DebrisThatFlewRoundAWallIsNotBehindIt) {
  measure::Matter m;
  measure::Scene s = scene_at();
  const int bumper = add_plate(s, "bumper", 40 * mm, mm);
  const int wall = add_plate(s, "wall", 40 * mm, mm, {0, 0, -50 * mm});
  const double d = 0.5 * mm, one = rho_0 * d * d * d;
  const auto from_hole = [&](double x_at_wall, double beyond, int body) {  // straight from the bumper's hole
    const Vec3 u = Vec3(x_at_wall, 0, -50 * mm);
    add_particle(m, u * (1 + beyond / (50 * mm)), 5000 * u.normalized(), d, body);
  };
  from_hole(15 * mm, 10 * mm, 0);       // through the wall
  from_hole(19 * mm, 40 * mm, bumper);  // through it near its edge, by now outside its outline
  from_hole(22 * mm, 10 * mm, 0);       // round it
  from_hole(-30 * mm, 60 * mm, bumper);
  add_particle(m, {0, 0, -52 * mm}, {0, 900, -300}, d, wall);  // the wall's own spall, wherever it seems to come from
  const measure::Result r = measure::measure(m, s);
  EXPECT_NEAR(get(r, "wall.debris_mass_behind") / one, 3, 1e-9);
  EXPECT_NEAR(get(r, "wall.cloud.mass") / one, 3, 1e-9);
  EXPECT_NEAR(get(r, "cloud.mass") / one, 4, 1e-9);  // all that left the bumper: its hole is where they come from
}

TEST(Cloud, DebrisThatLiesInTheDishOfAWallIsNotBehindIt) {
  measure::Matter m;
  Block b = plate(20 * mm, mm, 40, 2);
  b.map = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 3 * mm * std::exp(-x.head<2>().squaredNorm() / (9 * mm * mm)))); };
  add_block(m, b);
  const double d = 0.3 * mm, one = rho_0 * d * d * d;
  add_particle(m, {0.2 * mm, 0, -2.2 * mm}, {0, 0, -90}, d, 0);   // below the back face as built, above the bulge
  add_particle(m, {0.2 * mm, 0, -6 * mm}, {0, 0, -100}, d, 0);    // came through, slowly
  measure::Scene s = scene_at();
  add_plate(s, "wall", 20 * mm, mm);
  EXPECT_NEAR(get(measure::measure(m, s), "wall.debris_mass_behind") / one, 1, 1e-9);
  EXPECT_NEAR(get(measure::measure_cloud(m, s, 0), "cloud.mass") / one, 1, 1e-9);
}

TEST(Cloud, WhatStillPushesTheDishOfAWallThatHoldsIsNotBehindIt) {
  const double d = 0.3 * mm, one = rho_0 * d * d * d;
  for (const bool perforated : {false, true}) {  // beside the dish
    measure::Matter m;
    Block b = plate(20 * mm, mm, 40, 2);
    b.map = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 3 * mm * std::exp(-x.head<2>().squaredNorm() / (9 * mm * mm)))); };
    if (perforated) b.keep = [](const Vec3& x) { return (x - Vec3(5 * mm, 0, 0)).head<2>().norm() > 2 * mm; };
    add_block(m, b);
    add_particle(m, {0.2 * mm, 0, -2.2 * mm}, {0, 0, -900}, d, 0);
    add_particle(m, {0.2 * mm, 0, -6 * mm}, {0, 0, -900}, d, 0);
    measure::Scene s = scene_at();
    add_plate(s, "wall", 20 * mm, mm);
    const measure::Result r = measure::measure(m, s);
    EXPECT_EQ(get(r, "wall.perforated"), perforated);
    EXPECT_NEAR(get(r, "wall.debris_mass_behind") / one, perforated ? 2 : 1, 1e-9);
    EXPECT_NEAR(get(r, "fragments.mass") / one, perforated ? 2 : 1, 1e-9);
  }
}

TEST(Cloud, AVelocityOfTheWholeSceneChangesNothing) {
  measure::Matter m;
  measure::Scene s = scene_at();
  Block b = plate(20 * mm, mm, 20, 2);
  b.keep = [](const Vec3& x) { return x.head<2>().norm() > 3 * mm; };
  add_block(m, b);
  add_plate(s, "bumper", 20 * mm, mm);
  b.body = add_plate(s, "wall", 20 * mm, mm, {0, 0, -30 * mm});
  b.n[2] = 4;
  b.keep = [](const Vec3& x) { return x.head<2>().norm() > 3 * mm || x.z() < -0.25 * mm; };
  b.place = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 30 * mm)); };
  add_block(m, b);
  const Vec3 d(0, 0, -1);
  add_cone(m, {0, 0, 0}, d, 20 * degree, 50, 5000, 15 * mm, 0.2 * mm, 0);
  add_cone(m, {0, 0, 0}, d, 35 * degree, 40, 3000, 9 * mm, 0.3 * mm, 1);
  add_cone(m, {0, 0, -30 * mm}, d, 5 * degree, 9, 2000, 5 * mm, 0.2 * mm, 1);
  add_cone(m, {0, 0, -30 * mm}, d, 8 * degree, 9, 500, 3 * mm, 0.2 * mm, 2);
  add_cone(m, {0, 0, 0}, -d, 50 * degree, 20, 900, 6 * mm, 0.2 * mm, 1);
  const measure::Result still = measure::measure(m, s);
  EXPECT_GT(get(still, "cloud.mass"), 0);
  EXPECT_GT(get(still, "wall.cloud.mass"), 0);
  EXPECT_GT(get(still, "ejecta.mass"), 0);
  EXPECT_GT(get(still, "wall.crater_depth"), 0);

  for (const Vec3& velocity : {Vec3(0, 0, 3000), Vec3(4000, -1500, 0), Vec3(-700, 900, 9000)}) {
    measure::Matter moved = m;
    measure::Scene as = s;
    as.time = 5e-6, as.rest = velocity;
    for (auto& x : moved.x.own) x += as.time * velocity;
    for (auto& x : moved.node_x) x += as.time * velocity;
    for (auto& v : moved.v.own) v += velocity;
    for (auto& body : as.bodies) body.velocity = velocity;
    const measure::Result r = measure::measure(moved, as);
    ASSERT_EQ(r.values.size(), still.values.size());
    for (const auto& v : still.values) EXPECT_NEAR(get(r, v.key), v.value, 1e-9 * std::abs(v.value) + 1e-12) << v.key;
    ASSERT_EQ(r.fragments.size(), still.fragments.size());
    for (std::size_t k = 0; k < r.fragments.size(); ++k) {
      EXPECT_NEAR(r.fragments[k].mass, still.fragments[k].mass, 1e-9 * still.fragments[k].mass);
      EXPECT_NEAR((r.fragments[k].v - still.fragments[k].v).norm(), 0, 1e-6);
    }
    for (const auto& v : measure::measure_cloud(moved, as, 1).values) EXPECT_NEAR(v.value, get(still, v.key), 1e-9 * std::abs(v.value) + 1e-12) << v.key;
  }
}
