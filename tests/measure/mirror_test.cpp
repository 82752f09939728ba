// SPDX-License-Identifier: Apache-2.0
// Mirrored parts: mass, momentum, orientation and connection of the whole.
#include "measure/whole.hpp"
#include "synthetic.hpp"

using namespace synthetic;

namespace {

double signed_volume(const measure::Matter& m, std::size_t el) {
  const auto& c = m.node[el];
  const Vec3 o = m.node_x[c[0]];
  return (m.node_x[c[1]] - o).cross(m.node_x[c[3]] - o).dot(m.node_x[c[4]] - o);
}

measure::Matter eighth() {
  measure::Matter m;
  Block b = plate(2 * mm, 2 * mm, 3, 3);
  b.low = Vec3::Zero();
  b.v = Vec3(1, 2, 3);
  add_block(m, b);
  add_particle(m, {mm, mm, mm}, {1, 2, 3}, 0.1 * mm, 0);
  return m;
}

}  // namespace

TEST(Mirror, EighthBecomesWhole) {
  const measure::Matter part = eighth(), whole = measure::mirrored(part, {{true, true, true}});
  ASSERT_EQ(whole.n_elements, 8 * part.n_elements);
  ASSERT_EQ(whole.x.size(), 8 * part.x.size());
  ASSERT_EQ(whole.node_x.size(), 343u);  // 7 x 7 x 7: nodes on the planes are shared
  Vec3 momentum = Vec3::Zero();
  for (std::size_t i = 0; i < whole.x.size(); ++i) momentum += whole.m[i] * whole.v[i];
  EXPECT_NEAR(momentum.norm(), 0, 1e-12 * part.m[0] * 1000);  // round-off of the sum
  for (std::size_t el = 0; el < whole.n_elements; ++el) EXPECT_GT(signed_volume(whole, el), 0);
}

TEST(Mirror, FacesAreFoundOnce) {
  const measure::Matter whole = measure::mirrored(eighth(), {{true, true, true}});
  std::size_t free = 0, shared = 0;
  for (const measure::Face& f : measure::faces_where(whole, [](const measure::Face&) { return true; })) ++(f.b < 0 ? free : shared);
  EXPECT_EQ(free, 6u * 36u);
  EXPECT_EQ(shared, 3u * 5u * 36u);
}

TEST(Mirror, QuarterMeasuresLikeTheWhole) {
  measure::Scene s = scene_at();
  add_plate(s, "bumper", 20 * mm, 0.8 * mm);
  measure::Matter full, quarter;
  Block b = plate(20 * mm, 0.8 * mm, 80, 3);
  b.keep = [](const Vec3& x) { return std::hypot(x.x(), x.y()) > 3.6 * mm; };
  add_block(full, b);
  b.keep = [](const Vec3& x) { return x.x() > 0 && x.y() > 0 && std::hypot(x.x(), x.y()) > 3.6 * mm; };
  add_block(quarter, b);
  for (int i = 0; i < 4; ++i) {
    const double a = i < 2 ? 1 : -1, c = i % 2 ? 1 : -1;
    add_particle(full, {a * mm, c * 2 * mm, -9 * mm}, {a * 900, c * 1800, -6000}, 0.2 * mm, 0);
  }
  add_particle(quarter, {mm, 2 * mm, -9 * mm}, {900, 1800, -6000}, 0.2 * mm, 0);
  const measure::Result r = measure::measure(full, s);
  s.symmetry = {{true, true, false}};
  const measure::Result q = measure::measure(quarter, s);
  ASSERT_EQ(r.values.size(), q.values.size());
  for (std::size_t i = 0; i < r.values.size(); ++i) {
    EXPECT_EQ(r.values[i].key, q.values[i].key);
    // round-off of sums in another order
    EXPECT_NEAR(r.values[i].value, q.values[i].value, 1e-9 * std::abs(r.values[i].value) + 1e-15) << r.values[i].key;
  }
  EXPECT_EQ(r.fragments.size(), 4u);
}
