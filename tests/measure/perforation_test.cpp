// SPDX-License-Identifier: Apache-2.0
// What is a perforation and what only looks like one; the bulge of a wall.
#include "synthetic.hpp"

using namespace synthetic;

namespace {

constexpr double width = 20 * mm, thickness = 2 * mm;

measure::Result measured(const Block& b) {
  measure::Matter m;
  add_block(m, b);
  measure::Scene s = scene_at();
  s.bodies.reserve(4);
  add_plate(s, "wall", width, thickness);
  s.bodies[1].impulse = Vec3(0.1, 0, -0.7);
  return measure::measure(m, s);
}

}  // namespace

TEST(Perforation, ClosedPlateIsWhole) {
  const measure::Result r = measured(plate(width, thickness, 40, 4));
  EXPECT_EQ(get(r, "wall.perforated"), 0);
  EXPECT_EQ(get(r, "wall.hole_diameter"), 0);
  EXPECT_NEAR(get(r, "wall.bulge"), 0, 1e-12);
  EXPECT_NEAR(get(r, "wall.impulse"), 0.7, 1e-12);
  EXPECT_FALSE(find(r, "wall.crater_depth"));
}

TEST(Perforation, NoWayRoundAPlateThatMovedIsAHole) {
  Block b = plate(width, thickness, 40, 4);
  const auto dent = [](const Vec3& x) { return 0.5 * mm * std::exp(-x.head<2>().squaredNorm() / (16 * mm * mm)); };
  b.map = [&](const Vec3& x) { return Vec3(x - Vec3(0, 0, dent(x)) + Vec3(1.5 * mm, -mm, 0)); };  // sideways
  EXPECT_EQ(get(measured(b), "wall.perforated"), 0);
  b.map = [&](const Vec3& x) { return Vec3(0.93 * x.x(), 0.93 * x.y(), x.z() - dent(x)); };  // drawn in
  EXPECT_EQ(get(measured(b), "wall.perforated"), 0);
  b.keep = [](const Vec3& x) { return std::hypot(x.x(), x.y()) > mm; };
  EXPECT_EQ(get(measured(b), "wall.perforated"), 1);
}

TEST(Perforation, OneThatHasEatenAllButTheEdgeIsAHole) {
  for (const double left : {1.0, 0.5}) {  // width of what still stands [mm]
    const auto stands = [&](const Vec3& x) { return std::max(std::abs(x.x()), std::abs(x.y())) > 0.5 * width - left * mm; };
    Block b = plate(width, thickness, 40, 4);
    b.keep = stands;
    EXPECT_EQ(get(measured(b), "wall.perforated"), 1) << left;
    measure::Matter m;  // the same as particles
    for (int i = 0; i < 40; ++i)
      for (int j = 0; j < 40; ++j)
        for (int k = 0; k < 4; ++k) {
          const Vec3 x = Vec3(i - 19.5, j - 19.5, k - 1.5) * 0.5 * mm;
          if (stands(x)) add_particle(m, x, {0, 0, 0}, 0.5 * mm, 1);
        }
    measure::Scene s = scene_at();
    add_plate(s, "wall", width, thickness);
    const measure::Result r = measure::measure(m, s);
    EXPECT_EQ(get(r, "wall.perforated"), 1) << left;
    EXPECT_GT(get(r, "wall.hole_diameter"), width - 2 * left * mm) << left;  // a square: 2 x half its width x mean of sec
    EXPECT_FALSE(find(r, "wall.crater_diameter")) << left;
  }
}

TEST(Perforation, APlateInPiecesIsPerforated) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) { return std::max(std::abs(x.x()), std::abs(x.y())) > 4 * mm && std::abs(x.y() - x.x()) > 2 * mm; };  // torn across
  EXPECT_EQ(get(measured(b), "wall.perforated"), 1);
  b.keep = [](const Vec3& x) { return x.x() > 3 * mm; };  // what is left of it
  EXPECT_EQ(get(measured(b), "wall.perforated"), 1);
  b.keep = [](const Vec3& x) { return std::hypot(x.x() - 0.5 * width, x.y()) > 3 * mm; };  // a bite
  EXPECT_EQ(get(measured(b), "wall.perforated"), 0);
}

TEST(Perforation, OfAPlateThatIsGoneNoPieceClosesWhereItStood) {
  measure::Matter m;  // what is left of a small plate under a heavy projectile: two grains, farther out than its edge was
  for (const double y : {-1.4 * mm, 1.4 * mm}) add_particle(m, Vec3(1.5 * width, y, 0.4 * thickness), Vec3(0, 0, 0), 1.3 * mm, 1);
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "wall.perforated"), 1);
  EXPECT_FALSE(find(r, "wall.hole_diameter").has_value());
}

TEST(Perforation, OneColumnOfElementsIsAHole) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) { return std::abs(x.x() - 0.25 * mm) > 0.2 * mm || std::abs(x.y() - 0.25 * mm) > 0.2 * mm; };
  const measure::Result r = measured(b);
  EXPECT_EQ(get(r, "wall.perforated"), 1);
  EXPECT_NEAR(get(r, "wall.hole_diameter"), 0.56 * mm, 0.02 * mm);  // a square of 0.5 mm: 2 x 0.25 x mean of sec = 0.561
}

TEST(Perforation, FrontCraterAndBackSpallThatDoNotMeet) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) {
    const double r = std::hypot(x.x(), x.y());
    return !((x.z() > 0.5 * mm && r < 3 * mm) || (x.z() < 0 && r < 4 * mm));
  };
  EXPECT_EQ(get(measured(b), "wall.perforated"), 0);
}

TEST(Perforation, FrontCraterAndBackSpallThatMeetInACorner) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) {  // the two voids share edges of elements only
    const bool front = x.z() > 0 && x.x() > 0 && x.x() < 2 * mm && std::abs(x.y()) < mm;
    const bool back = x.z() < 0 && x.x() < 0 && x.x() > -2 * mm && std::abs(x.y()) < mm;
    return !front && !back;
  };
  EXPECT_EQ(get(measured(b), "wall.perforated"), 0);
}

TEST(Perforation, CrookedChannelIsAHole) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) {
    const bool front = x.z() > -0.5 * mm && x.x() > 0 && x.x() < 2 * mm && std::abs(x.y()) < mm;
    const bool back = x.z() < 0.5 * mm && x.x() < 0 && x.x() > -2 * mm && std::abs(x.y()) < mm;
    return !front && !back;
  };
  const measure::Result r = measured(b);
  EXPECT_EQ(get(r, "wall.perforated"), 1);
  EXPECT_GT(get(r, "wall.hole_diameter"), mm);
}

TEST(Perforation, CrookedChannelInABentWallIsMeasuredInTheWall) {
  Block b = plate(width, thickness, 80, 4);
  b.keep = [](const Vec3& x) {
    const bool front = x.z() > -0.5 * mm && x.x() > 0 && x.x() < 2 * mm && std::abs(x.y()) < mm;
    const bool back = x.z() < 0.5 * mm && x.x() < 0 && x.x() > -2 * mm && std::abs(x.y()) < mm;
    return !front && !back;
  };
  const double flat = get(measured(b), "wall.hole_diameter");
  b.map = [](const Vec3& x) {  // as far as three thicknesses, wide beside the channel
    return Vec3(x - Vec3(0, 0, 6 * mm * std::exp(-x.head<2>().squaredNorm() / (64 * mm * mm))));
  };
  const measure::Result r = measured(b);
  EXPECT_EQ(get(r, "wall.perforated"), 1);
  // mean distance from the middle of a 4 mm x 2 mm rectangle to its edge, twice: (4/pi) (a asinh(b/a) + b asinh(a/b)), a = 2, b = 1 mm
  EXPECT_NEAR(flat, 4 / core::pi * (2 * std::asinh(0.5) + std::asinh(2.0)) * mm, 0.1 * mm);
  EXPECT_NEAR(get(r, "wall.hole_diameter"), flat, 0.15 * mm);
}

TEST(Perforation, ThinBulgeIsClosed) {
  Block b = plate(width, thickness, 40, 4);
  b.map = [](const Vec3& x) {  // a deep dome, stretched to a third of its thickness at the top
    const double dome = std::exp(-x.head<2>().squaredNorm() / (9 * mm * mm));
    return Vec3(x.x(), x.y(), x.z() * (1 - 0.67 * dome) - 6 * mm * dome);
  };
  const measure::Result r = measured(b);
  EXPECT_EQ(get(r, "wall.perforated"), 0);
  EXPECT_EQ(get(r, "wall.hole_diameter"), 0);
  EXPECT_NEAR(get(r, "wall.bulge"), 6 * mm - 0.67 * mm, 1e-9);
}

TEST(Perforation, HoleInABulge) {
  Block b = plate(width, thickness, 80, 4);
  b.keep = [](const Vec3& x) { return std::hypot(x.x(), x.y()) > 1.5 * mm; };
  b.map = [](const Vec3& x) {
    return Vec3(x - Vec3(0, 0, 5 * mm * std::exp(-x.head<2>().squaredNorm() / (16 * mm * mm))));
  };
  const measure::Result r = measured(b);
  EXPECT_EQ(get(r, "wall.perforated"), 1);
  EXPECT_NEAR(get(r, "wall.hole_diameter"), 3 * mm, 0.12 * mm);  // staircase of 0.25 mm
}

TEST(Perforation, MovingWallStaysClosed) {
  Block b = plate(width, thickness, 40, 4);
  measure::Matter m;
  add_block(m, b);
  for (std::size_t el = 0; el < m.n_elements; ++el)
    if (m.x[el].head<2>().norm() < 4 * mm) m.v.own[el] = Vec3(0, 0, -600);
  for (Vec3& x : m.node_x) x.z() -= 3 * mm * std::exp(-x.head<2>().squaredNorm() / (9 * mm * mm));
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  EXPECT_EQ(get(measure::measure(m, s), "wall.perforated"), 0);
}

TEST(Perforation, ParticlesCloseAHole) {
  measure::Matter m;
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) { return std::max(std::abs(x.x()), std::abs(x.y())) > 2 * mm; };
  add_block(m, b);
  measure::Matter layer = m;
  for (int i = -4; i < 4; ++i)
    for (int j = -4; j < 4; ++j)  // one layer, stretched by a tenth, bent back
      add_particle(layer, {(i + 0.5) * 0.5 * mm, (j + 0.5) * 0.5 * mm, -0.1 * mm * (7 - std::abs(i + 0.5) - std::abs(j + 0.5))},
                   {0, 0, 10.0 * i}, 0.45 * mm, 1);
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  EXPECT_EQ(get(measure::measure(m, s), "wall.perforated"), 1);
  EXPECT_EQ(get(measure::measure(layer, s), "wall.perforated"), 0);
}

TEST(Perforation, SpalledWallIsWholeAndReportsItsSpall) {
  // The back half of the middle came off as a cap of elements and a few particles; the front half is dished and holds.
  measure::Matter m;
  const auto spalls = [](const Vec3& x) { return x.z() < 0 && std::hypot(x.x(), x.y()) < 3 * mm; };
  const auto dished = [](const Vec3& x) {
    return Vec3(x - Vec3(0, 0, mm * std::exp(-x.head<2>().squaredNorm() / (9 * mm * mm))));
  };
  Block wall = plate(width, thickness, 40, 4);
  wall.keep = [&](const Vec3& x) { return !spalls(x); };
  wall.map = dished;
  add_block(m, wall);
  double cap_mass = 0;
  Block cap = plate(width, thickness, 40, 4);
  cap.keep = spalls;
  cap.map = dished;
  cap.place = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 5 * mm)); };
  cap.v = Vec3(0, 0, -200);
  const std::size_t first = m.x.size();
  add_block(m, cap);
  for (int i = 0; i < 5; ++i) add_particle(m, {i * mm, 0, -9 * mm}, {0, 0, -300}, 0.4 * mm, 1);
  add_particle(m, {0, 0, 6 * mm}, {0, 0, 300}, 0.4 * mm, 1);     // thrown back off the front: no spall
  add_particle(m, {5 * mm, 0, -4 * mm}, {0, 0, 50}, 0.4 * mm, 1);  // behind, on its way back: no spall
  for (std::size_t row = first; row + 2 < m.x.size(); ++row) cap_mass += m.m[row];
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "wall.perforated"), 0);
  EXPECT_EQ(get(r, "wall.hole_diameter"), 0);
  EXPECT_NEAR(get(r, "wall.detached_mass"), cap_mass, 1e-12 * cap_mass);
  // the ring round the cap reaches farthest: its inner corners are up to half a diagonal of an element inside 3 mm
  const double inner = 3 - 0.25 * std::sqrt(2.0);
  EXPECT_NEAR(get(r, "wall.bulge"), mm * std::exp(-inner * inner / 9), 0.05 * mm);
}

TEST(Perforation, SpallThatStillHangsOnIsBulgeAndNotDetached) {
  measure::Matter m;
  Block wall = plate(width, thickness, 40, 4);
  wall.map = [](const Vec3& x) {  // the back layers bulge, a cavity inside: nothing is missing, nothing is open
    const double dome = x.z() < -0.2 * mm ? 2 * mm * std::exp(-x.head<2>().squaredNorm() / (4 * mm * mm)) : 0;
    return Vec3(x - Vec3(0, 0, dome));
  };
  add_block(m, wall);
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  const measure::Result r = measure::measure(m, s);
  EXPECT_EQ(get(r, "wall.perforated"), 0);
  EXPECT_EQ(get(r, "wall.detached_mass"), 0);
  EXPECT_NEAR(get(r, "wall.bulge"), 2 * mm, 1e-9);
}

/// A wall whose middle, four millimetres wide, is one layer of particles that go backwards, the faster the further from its edge.
/// damage(inwards): how far a particle is from that edge [0.5 mm].
template <class Damage>
measure::Result mended_wall(Damage&& damage, double gradient = 0) {
  measure::Matter m;
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) { return std::max(std::abs(x.x()), std::abs(x.y())) > 2 * mm; };
  add_block(m, b);
  for (int i = -4; i < 4; ++i)
    for (int j = -4; j < 4; ++j) {
      const double inwards = 4 - std::max(std::abs(i + 0.5), std::abs(j + 0.5));  // neighbours part slowly enough to be bonded
      add_particle(m, {(i + 0.5) * 0.5 * mm, (j + 0.5) * 0.5 * mm, -0.3 * mm}, {0, 0, -gradient * inwards}, 0.5 * mm, 1);
      m.damage.own.back() = damage(inwards);
    }
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  return measure::measure(m, s);
}

TEST(Perforation, PowderClosesNoHole) {
  for (const double gradient : {0.0, 5.0, 70.0}) {  // m/s per half millimetre: it lies in the hole, or blows through it
    EXPECT_EQ(get(mended_wall([](double) { return 0.99; }, gradient), "wall.perforated"), 0);
    EXPECT_EQ(get(mended_wall([](double) { return 1; }, gradient), "wall.perforated"), 1);
  }
}

TEST(Perforation, WhatHangsOnPowderAloneClosesNoHole) {
  for (const double ring : {0.5, 1.0})  // damage of the particles that touch the elements
    EXPECT_EQ(get(mended_wall([&](double inwards) { return inwards < 1 ? ring : 0.0; }), "wall.perforated"), ring < 1 ? 0 : 1);
}

// Particles of a graded plate: large ones below, which reach the edge, and small ones above, which end short of it.
TEST(Rim, IsDisplacedFromWhereItWasBuilt) {
  measure::Matter m;
  std::vector<core::Vec3f> built;
  constexpr double sunk = 0.1 * mm;
  const auto layer = [&](int n, double spacing, double z) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const Vec3 x((i + 0.5 - 0.5 * n) * spacing, (j + 0.5 - 0.5 * n) * spacing, z);
        built.push_back(x.cast<float>());
        m.parent.own.push_back(static_cast<std::uint32_t>(m.parent.size()));
        add_particle(m, x - Vec3(0, 0, sunk), {0, 0, 0}, spacing, 1);
      }
  };
  layer(20, mm, -0.5 * mm), layer(36, 0.5 * mm, 0.5 * mm);
  measure::Scene s = scene_at();
  add_plate(s, "wall", width, thickness);
  s.built = built;
  EXPECT_NEAR(get(measure::measure(m, s), "wall.rim_displacement"), -sunk, 1e-9);
}

/// A free plate with a hole that was struck, has drifted so far and flies so fast by now.
measure::Result drifting_plate(double drift, double speed = 0) {
  Block b = plate(width, thickness, 40, 4);
  b.keep = [](const Vec3& x) { return std::max(std::abs(x.x()), std::abs(x.y())) > 2 * mm; };
  b.v = {0, 0, -speed};
  measure::Matter m;
  add_block(m, b);
  std::vector<core::Vec3f> built;
  for (std::size_t el = 0; el < m.n_elements; ++el) {
    built.push_back(m.x[el].cast<float>());
    m.parent.own.push_back(static_cast<std::uint32_t>(el));
    m.x.own[el].z() -= drift;
  }
  for (Vec3& x : m.node_x) x.z() -= drift;
  measure::Scene s = scene_at({0, 0, -500});
  add_plate(s, "wall", width, thickness);
  s.built = built;
  return measure::measure(m, s);
}

// A rod that strikes a free plate end on carries it off at some tens of metres a second; a plate that flies with what struck it is debris.
TEST(Rim, OfAPlateThatWasCarriedOff) {
  const measure::Result stands = drifting_plate(0), carried = drifting_plate(0.5 * thickness, 40), swept = drifting_plate(2.5 * thickness, 400);
  EXPECT_EQ(get(carried, "wall.perforated"), 1);
  EXPECT_NEAR(get(carried, "wall.hole_diameter"), get(stands, "wall.hole_diameter"), 1e-3 * mm);
  EXPECT_EQ(get(carried, "cloud.mass"), 0);
  EXPECT_GT(get(swept, "cloud.mass"), 0);
}

// Struck at 0.3 km/s, a free plate drifts at a few metres a second, by more than its thickness within a millisecond: it is the same plate.
TEST(Rim, OfAPlateThatHasDriftedByMoreThanItsThickness) {
  const measure::Result stands = drifting_plate(0), drifted = drifting_plate(2.5 * thickness);
  EXPECT_EQ(get(stands, "wall.perforated"), 1);
  EXPECT_EQ(get(drifted, "wall.perforated"), 1);
  EXPECT_NEAR(get(drifted, "wall.hole_diameter"), get(stands, "wall.hole_diameter"), 1e-3 * mm);
  EXPECT_NEAR(get(drifted, "wall.rim_displacement"), -2.5 * thickness, 1e-6 * mm);
  EXPECT_EQ(get(drifted, "cloud.mass"), 0);
}
