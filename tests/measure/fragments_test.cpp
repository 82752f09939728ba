// SPDX-License-Identifier: Apache-2.0
// Connected pieces of debris and what they add up to.
#include "synthetic.hpp"

using namespace synthetic;

namespace {

measure::Scene scene_with_plate() {
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, 0.8 * mm);
  return s;
}

}  // namespace

TEST(Fragments, TwoPiecesAndALoneParticle) {
  measure::Matter m;
  Block chunk = plate(mm, mm, 3, 3);  // 27 elements of the projectile
  chunk.body = 0;
  chunk.v = Vec3(0, 0, -5000);
  chunk.place = [](const Vec3& x) { return Vec3(x - Vec3(0, 0, 10 * mm)); };
  add_block(m, chunk);
  const double d = 0.3 * mm;
  add_particle(m, {0, 0, -10 * mm + 0.65 * mm}, {0, 10, -5000}, d, 1);  // hangs on to the chunk
  for (int i = 0; i < 8; ++i)                                           // a second piece of particles
    add_particle(m, Vec3(5 * mm + (i & 1) * d, (i >> 1 & 1) * d, -12 * mm + (i >> 2) * d), {500, 0, -4000}, d, 1);
  add_particle(m, {-5 * mm, 0, -9 * mm}, {-900, 0, -3000}, d, 1);       // alone
  add_particle(m, {5 * mm - d, 0, -12 * mm}, {-500, 0, -4000}, d, 1);   // near the second piece, but passing by
  const measure::Result r = measure::measure(m, scene_with_plate());
  ASSERT_EQ(r.fragments.size(), 4u);
  EXPECT_EQ(get(r, "fragments.count"), 4);
  EXPECT_EQ(r.fragments[0].n_points, 28);
  EXPECT_EQ(r.fragments[1].n_points, 8);
  const double one = rho_0 * d * d * d, chunk_mass = rho_0 * std::pow(mm, 3);
  EXPECT_NEAR(r.fragments[0].mass, chunk_mass + one, 1e-12 * chunk_mass);
  EXPECT_NEAR(r.fragments[0].projectile_fraction, chunk_mass / (chunk_mass + one), 1e-12);
  EXPECT_NEAR(r.fragments[1].size, std::cbrt(6 / core::pi * 8) * d, 1e-12);
  EXPECT_NEAR((r.fragments[1].v - Vec3(500, 0, -4000)).norm(), 0, 1e-9);
  int lone = 0;
  for (const auto& f : r.fragments) lone += f.lone;
  EXPECT_EQ(lone, 1);
  EXPECT_NEAR(get(r, "fragments.lone_mass_fraction"), one / get(r, "fragments.mass"), 1e-12);
  EXPECT_NEAR(get(r, "fragments.largest_mass"), chunk_mass + one, 1e-12 * chunk_mass);
}

TEST(Fragments, AddUpToTheCloud) {
  measure::Matter m;
  unsigned seed = 1;
  const auto random = [&seed] { return (seed = seed * 1664525u + 1013904223u) / 4294967296.0; };
  for (int i = 0; i < 3000; ++i)
    add_particle(m, {10 * mm * random(), 10 * mm * random(), -20 * mm + 18 * mm * random()},
                 {100 * random(), 100 * random(), -5000 + 100 * random()}, (0.2 + 0.3 * random()) * mm, i % 2);
  const measure::Result r = measure::measure(m, scene_with_plate());
  double mass = 0, momentum = 0, sum = 0;
  Vec3 total = Vec3::Zero(), expected = Vec3::Zero();
  for (const auto& f : r.fragments) {
    mass += f.mass, momentum -= f.mass * f.v.z();
    total += f.mass * f.v;
  }
  for (std::size_t i = 0; i < m.x.size(); ++i) sum += m.m[i], expected += m.m[i] * m.v[i];
  EXPECT_LT(r.fragments.size(), 3000u);
  EXPECT_NEAR(mass, sum, 1e-13 * sum);
  EXPECT_NEAR(mass, get(r, "cloud.mass"), 1e-13 * sum);
  EXPECT_NEAR(momentum, get(r, "cloud.momentum"), 1e-13 * momentum);
  EXPECT_NEAR((total - expected).norm(), 0, 1e-13 * expected.norm());
  for (std::size_t k = 1; k < r.fragments.size(); ++k) EXPECT_GE(r.fragments[k - 1].mass, r.fragments[k].mass);
}

TEST(Fragments, DilutedParticlesDoNotBondOverTheirSpacing) {
  measure::Matter m;  // a tenth of the density: spacings are large, the pieces are not connected
  for (int i = 0; i < 3; ++i) {
    add_particle(m, {i * 0.5 * mm, 0, -9 * mm}, {0, 0, -5000}, 0.2 * mm, 1);
    m.size.own.back() *= std::cbrt(10.0), m.rho.own.back() /= 10;
  }
  EXPECT_EQ(get(measure::measure(m, scene_with_plate()), "fragments.count"), 3);
}

namespace {

/// Two halves of a bar of six particles as built, a gap between them now; the scene knows where they were built.
measure::Result cut_bar(bool failed) {
  measure::Matter m;
  measure::Scene s = scene_with_plate();
  std::vector<core::Vec3f> built;
  const double d = 0.3 * mm;
  for (int i = 0; i < 6; ++i) {
    const double gap = i < 3 ? 0 : 4 * d;
    add_particle(m, {i * d + gap, 0, -10 * mm}, {i < 3 ? 0.0 : 300.0, 0, -5000}, d, 0);
    built.push_back(Vec3(i * d, 0, 5 * mm).cast<float>());
    m.parent.own.push_back(static_cast<std::uint32_t>(i));
  }
  s.built = built;
  if (failed) m.damage.own[3] = 1;
  return measure::measure(m, s);
}

}  // namespace

TEST(Fragments, PiecesThatDrewApartAreToldFromPiecesThatBroke) {
  for (const bool failed : {false, true}) {
    const measure::Result r = cut_bar(failed);
    ASSERT_EQ(r.fragments.size(), 2u);
    for (const auto& f : r.fragments) {
      EXPECT_EQ(f.n_points, 3);
      EXPECT_EQ(f.links_cut, 1);  // the one across the gap
      EXPECT_EQ(f.cut_by_reach, failed ? 0 : 1);
    }
    EXPECT_EQ(get(r, "fragments.reach_mass_fraction"), failed ? 0 : 1);
    EXPECT_NEAR(get(r, "fragments.failed_mass_fraction"), failed ? 1.0 / 6 : 0, 1e-12);
  }
}

TEST(Fragments, CutsAreNotReportedWhereTheBuiltPlacesAreUnknown) {
  measure::Matter m;
  add_particle(m, {0, 0, -10 * mm}, {0, 0, -5000}, 0.3 * mm, 0);
  const measure::Result r = measure::measure(m, scene_with_plate());
  EXPECT_FALSE(find(r, "fragments.reach_mass_fraction"));
  EXPECT_EQ(r.fragments.front().links_cut, 0);
}

TEST(Fragments, AQuarterCutsTheSameLinksAsTheWhole) {
  measure::Matter quarter;
  measure::Scene s = scene_with_plate();
  std::vector<core::Vec3f> built;
  const double d = 0.3 * mm;
  for (int i = 0; i < 3; ++i) {  // beside the planes; the outermost flies off
    add_particle(quarter, {(i + 0.5) * d + (i == 2 ? 3 * d : 0), 0.5 * d, -10 * mm}, {i == 2 ? 400.0 : 0.0, 0, -5000}, d, 0);
    built.push_back(Vec3((i + 0.5) * d, 0.5 * d, 5 * mm).cast<float>());
    quarter.parent.own.push_back(static_cast<std::uint32_t>(i));
  }
  s.built = built;
  s.symmetry.plane[0] = s.symmetry.plane[1] = true;
  const measure::Result r = measure::measure(quarter, s);
  ASSERT_EQ(r.fragments.size(), 3u);
  EXPECT_EQ(r.fragments[0].n_points, 8);
  EXPECT_EQ(r.fragments[0].links_cut, 4);  // two on either side
  EXPECT_EQ(r.fragments[1].links_cut, 2);
}
