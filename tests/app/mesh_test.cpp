// SPDX-License-Identifier: Apache-2.0
// Meshes of whole cases: where they are fine, that round bodies have the mass they should, and what is refused.
#include "app/body_mesh.hpp"
#include "core/error.hpp"
#include "fem/elements.hpp"
#include <fmt/format.h>

#include "tests/app/small_case.hpp"

namespace {

using core::Vec3;

constexpr double mm = 1e-3;

std::string projectile(const std::string& shape, const std::string& center, const std::string& velocity) {
  return "title = \"shot\"\n[run]\nend = \"1 us\"\nelements_across = 6\n[[body]]\nname = \"projectile\"\n" + shape + "\ncenter = " + center +
         "\nvelocity = " + velocity + "\nmaterial = \"Al2024-T351\"\n";
}
std::string plate(const std::string& name, const std::string& size, const std::string& thickness, const std::string& center, const std::string& more = "") {
  return "[[body]]\nname = \"" + name + "\"\nshape = \"plate\"\nsize = " + size + "\nthickness = " + thickness + "\ncenter = " + center + "\n" + more +
         "\nmaterial = \"Al2024-T351\"\n";
}
const std::string ball = "shape = \"sphere\"\ndiameter = \"2 mm\"", down = "[0, 0, \"-6 km/s\"]";
const std::string bumper = plate("bumper", "[\"50 mm\", \"20 mm\"]", "\"0.8 mm\"", "[0, 0, \"-0.4 mm\"]");

/// Edges along x, y, z of the box round the element of a body that is nearest to a point [mm].
Vec3 edges_at(const app::Simulation& s, std::size_t body, const Vec3& where) {
  std::size_t nearest = 0;
  double least = 1e300;
  for (auto el = s.mesh.body_elements[body].first; el < s.mesh.body_elements[body].last; ++el) {
    if (!s.mesh.elements.alive[el]) continue;
    const double d = (fem::centre(s.mesh, el, s.mesh.nodes.x) - mm * where).norm();
    if (d < least) least = d, nearest = el;
  }
  core::Box box;
  for (const auto nd : s.mesh.elements.node[nearest]) box.add(s.mesh.nodes.x[static_cast<std::size_t>(nd)]);
  return (box.high - box.low) / mm;
}

double mass(const app::Simulation& s, std::size_t body) {
  double m = 0;
  for (auto el = s.mesh.body_elements[body].first; el < s.mesh.body_elements[body].last; ++el) m += s.mesh.elements.pt.m[el];
  return s.spec.symmetry.copies() * m;
}

double lowest(const app::Simulation& s, std::size_t body) {
  double z = 1e300;
  for (auto nd = s.mesh.body_nodes[body].first; nd < s.mesh.body_nodes[body].last; ++nd) z = std::min(z, s.mesh.nodes.x[nd].z());
  return z;
}

TEST(RoundBodies, WeighWhatTheyShouldAndStandWhereTheyStood) {
  for (const char* across : {"run.elements_across=4", "run.elements_across=7", "run.elements_across=20"})
    for (const char* symmetry : {"run.symmetry=\"none\"", "run.symmetry=\"auto\""}) {
      const auto sphere = small_case::set_up({across, symmetry}, projectile(ball, "[0, 0, \"1.3 mm\"]", down) + bumper);
      EXPECT_NEAR(mass(*sphere, 0), 2785 * core::pi / 6 * 8e-9, 1e-12 * 2785 * 8e-9) << across;
      EXPECT_NEAR(lowest(*sphere, 0), 0.3 * mm, 1e-12) << "its front";
      const std::string rod = "shape = \"cylinder\"\ndiameter = \"2 mm\"\nlength = \"3 mm\"";
      const auto upright = small_case::set_up({across, symmetry}, projectile(rod, "[0, 0, \"1.8 mm\"]", down) + bumper);
      EXPECT_NEAR(mass(*upright, 0), 2785 * core::pi / 4 * 12e-9, 1e-12 * 2785 * 12e-9) << across;
      EXPECT_NEAR(lowest(*upright, 0), 0.3 * mm, 1e-12);
      const auto lying = small_case::set_up({across, symmetry}, projectile(rod + "\nnormal = [1, 0, 0]", "[0, 0, \"1.3 mm\"]", down) + bumper);
      EXPECT_NEAR(mass(*lying, 0), 2785 * core::pi / 4 * 12e-9, 1e-12 * 2785 * 12e-9) << across;
      EXPECT_NEAR(lowest(*lying, 0), 0.3 * mm, 1e-12);
    }
}

TEST(RoundBodies, AHalfHasHalfTheElements) {
  const auto cylinder = projectile("shape = \"cylinder\"\ndiameter = \"3 mm\"\nlength = \"3.5 mm\"\nnormal = [1, 0, 0]", "[0, 0, \"1.55 mm\"]", down) + bumper;
  const auto whole = small_case::set_up({"run.symmetry=\"none\""}, cylinder), quarter = small_case::set_up({"run.symmetry=\"auto\""}, cylinder);
  const auto alive = [](const app::Simulation& s) {
    std::size_t n = 0;
    for (auto el = s.mesh.body_elements[0].first; el < s.mesh.body_elements[0].last; ++el) n += s.mesh.elements.alive[el];
    return n;
  };
  EXPECT_EQ(alive(*whole), 4 * alive(*quarter));
}

TEST(FineMesh, IsAtTheNoseOfARod) {
  const auto s = small_case::set_up({}, projectile("shape = \"box\"\nsize = [\"2 mm\", \"2 mm\", \"12 mm\"]", "[0, 0, \"6.05 mm\"]", down) + bumper);
  EXPECT_LT(edges_at(*s, 0, {0, 0, 0.05}).z(), 0.36);
  EXPECT_GT(edges_at(*s, 0, {0, 0, 12}).z(), 0.5);
}

TEST(FineMesh, IsWhereABlockIsStruckFromTheSide) {
  const auto s = small_case::set_up({}, projectile(ball, "[\"11.02 mm\", 0, 0]", "[\"-6 km/s\", 0, 0]") +
                                            "[[body]]\nname = \"block\"\nshape = \"box\"\nsize = [\"20 mm\", \"20 mm\", \"20 mm\"]\nmaterial = \"Al2024-T351\"\n");
  EXPECT_LT(edges_at(*s, 1, {10, 0, 0}).maxCoeff(), 0.4);
}

TEST(FineMesh, IsWhereEachOfTwoStrikes) {
  std::string second = projectile(ball, "[\"14 mm\", 0, \"1.05 mm\"]", down);
  second = second.substr(second.find("[[body]]"));
  second.replace(second.find("\"projectile\""), 12, "\"second\"");
  const auto s = small_case::set_up({}, projectile(ball, "[0, 0, \"1.05 mm\"]", down) + second + bumper);
  EXPECT_LT(edges_at(*s, 2, {0, 0, 0}).maxCoeff(), 0.42);
  EXPECT_LT(edges_at(*s, 2, {14, 0, 0}).maxCoeff(), 0.42);
}

TEST(FineMesh, IsWhereAFlyingPlateIsStruckAndAtAnEdge) {
  const auto flying = small_case::set_up({}, projectile(ball, "[0, 0, \"11 mm\"]", down) +
                                                 plate("bumper", "[\"50 mm\", \"20 mm\"]", "\"0.8 mm\"", "[0, 0, \"-0.4 mm\"]", "velocity = [\"5 km/s\", 0, 0]"));
  EXPECT_LT(edges_at(*flying, 1, {-5 * 11 / 6.0, 0, 0}).maxCoeff(), 0.42);
  const auto edge = small_case::set_up({}, projectile(ball, "[\"10.5 mm\", 0, \"1.05 mm\"]", down) + plate("bumper", "[\"20 mm\", \"20 mm\"]", "\"0.8 mm\"", "[0, 0, \"-0.4 mm\"]"));
  EXPECT_LT(edges_at(*edge, 1, {10, 0, 0}).maxCoeff(), 0.42);
}

TEST(FineMesh, HasNoGapsForParticles) {
  const auto of = [](const std::string& thickness, const std::string& z) {
    return small_case::set_up({"run.mode=\"sph\""}, projectile(ball, "[0, 0, \"1.2 mm\"]", down) + plate("bumper", "[\"12 mm\", \"12 mm\"]", thickness, "[0, 0, " + z + "]"));
  };
  const auto foil = of("\"0.1 mm\"", "\"-0.05 mm\""), block = of("\"5 mm\"", "\"-2.5 mm\"");
  EXPECT_LT(edges_at(*foil, 1, {5, 5, 0}).maxCoeff(), 0.11);
  EXPECT_LT(edges_at(*block, 1, {5, 5, -4}).maxCoeff(), 0.42);
}

TEST(Plates, HaveFourLayersIfNotFlatterThanHalfAnEdgeAndFiveIfTwoThirds) {
  // a sphere of 2 mm, edge 0.2 mm at ten across
  const auto layers = [](double thickness, const std::string& more = "", const std::string& mode = "hybrid") {
    const auto length = [](double l) { return "\"" + std::to_string(l) + " mm\""; };
    const auto s = small_case::set_up({"run.elements_across=10", "run.mode=\"" + mode + "\""},
                                      projectile(ball, "[0, 0, \"1.05 mm\"]", down) +
                                          plate("bumper", "[\"12 mm\", \"12 mm\"]", length(thickness), "[0, 0, " + length(-thickness / 2) + "]", more));
    return std::lround(thickness / edges_at(*s, 1, {0.1, 0.1, -thickness / 2})[2]);
  };
  EXPECT_EQ(layers(0.05), 2);
  EXPECT_EQ(layers(0.29), 2);
  EXPECT_EQ(layers(0.3), 3);
  EXPECT_EQ(layers(0.39), 3);
  EXPECT_EQ(layers(0.4), 4);
  EXPECT_EQ(layers(0.54), 4);
  EXPECT_EQ(layers(0.66), 4);
  EXPECT_EQ(layers(0.67), 5);
  EXPECT_EQ(layers(0.8), 5);
  EXPECT_EQ(layers(1), 5);
  EXPECT_EQ(layers(1.4), 7);
  EXPECT_EQ(layers(0.8, "element_size = \"0.2 mm\""), 4) << "as asked for";
  EXPECT_EQ(layers(0.8, "elements_through = 3"), 3) << "as asked for";
  EXPECT_EQ(layers(0.8, "", "sph"), 4) << "cubes";
}

TEST(Plates, OfFlatLayersWarn) {
  // a sphere of 2 mm, edge 0.2 mm; thin_plate at 20 across to 0.2 us has 116, 133, 151 and 216 GPa with layers of 0.8, 0.5, 0.4 and 0.25 of the edge, where 119 is right
  const auto warnings = [](const std::string& thickness, const std::string& more, const std::string& mode = "hybrid") {
    const auto s = small_case::set_up({"run.elements_across=10", "run.mode=\"" + mode + "\""},
                                      projectile(ball, "[0, 0, \"1.05 mm\"]", down) + plate("bumper", "[\"12 mm\", \"12 mm\"]", thickness, "[0, 0, \"-0.4 mm\"]", more));
    return s->warnings;
  };
  EXPECT_TRUE(warnings("\"0.8 mm\"", "elements_through = 8").empty()) << "half an edge, as thin plates have by themselves";
  EXPECT_TRUE(warnings("\"0.4 mm\"", "").empty());
  const auto flat = warnings("\"0.8 mm\"", "elements_through = 10");
  ASSERT_EQ(flat.size(), 1u);
  EXPECT_NE(flat[0].find("body \"bumper\" has layers of elements of 0.08 mm and \"projectile\", which strikes it, elements of 0.2 mm"), std::string::npos) << flat[0];
  const auto fine = warnings("\"0.8 mm\"", "element_size = \"0.1 mm\"\nelements_through = 4");
  ASSERT_EQ(fine.size(), 1u);
  EXPECT_NE(fine[0].find("body \"bumper\" has elements of 0.1 mm and"), std::string::npos) << fine[0];
  EXPECT_TRUE(warnings("\"0.2 mm\"", "", "sph").empty()) << "particles";
}

TEST(Plates, OfParticlesCanBecomeThinner) {
  // A plate of 0.3 mm with a sphere 4 elements across, thinner than one and a half of its elements. Between 2 and 2.8 mm from the axis, 0.5 us
  // after 6 km/s, hexes move at 17 m/s and particles at 8; in one layer, which bears pressure in its plane like a block, at 225 m/s.
  auto s = small_case::begin({"run.mode=\"sph\"", "run.elements_across=4", "run.end=\"0.5 us\""});
  small_case::run(*s, 1000000);
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < s->particles.size(); ++i) {
    const double r = s->particles.x[i].head<2>().norm();
    if (s->particles.body[i] == 1 && r > 2 * mm && r < 2.8 * mm) sum += s->particles.v[i].norm(), ++n;
  }
  EXPECT_GT(n, 0);
  EXPECT_LT(sum / n, 30);
}

/// Highest pressure [Pa] that a shot of 2 km/s has seen on its axis by `end` [us], a sphere of 2 mm on what lies below z = 0, nothing converted.
double peak_pressure(const std::string& target, double gap, int across, double end) {
  auto s = small_case::begin({"run.mode=\"fem\"", "run.elements_across=" + std::to_string(across), "run.end=" + std::to_string(end) + " us"},
                             projectile(ball, fmt::format("[0, 0, \"{} mm\"]", 1 + gap), "[0, 0, \"-2 km/s\"]") + target);
  small_case::run(*s, 1000000);
  EXPECT_EQ(s->contact.leaks, 0u);
  double most = 0;
  for (const auto el : s->on_axis) most = std::max(most, s->mesh.elements.pt.p_max[el]);
  return most;
}

TEST(Touching, RoundBodiesThatTouchDoNotOverlapAsTheyAreMeshed) {
  // The sphere that is struck was widened to its volume and reached 6 um into the other. Contact let those nodes pass: 6.4 GPa for 13.
  const std::string sphere = "[[body]]\nname = \"target\"\nshape = \"sphere\"\ndiameter = \"2 mm\"\ncenter = [0, 0, \"-1 mm\"]\nmaterial = \"Al2024-T351\"\n";
  const double touching = peak_pressure(sphere, 0, 16, 0.25), apart = peak_pressure(sphere, 0.02, 16, 0.26);
  std::printf("touching %.4g GPa, apart %.4g\n", touching * 1e-9, apart * 1e-9);
  EXPECT_NEAR(touching, apart, 0.01 * apart);
}

TEST(Touching, WhatIsTooLittleToBeRefusedDoesNotLetBodiesPass) {
  // 0.8 nm are 8e-7 of the plate's thickness, within what is taken for touching; contact took it for behind the face: pole and plate went through each other.
  const auto block = plate("block", "[\"6 mm\", \"6 mm\"]", "\"1 mm\"", "[0, 0, \"-0.5 mm\"]");
  const double flush = peak_pressure(block, 0, 10, 0.3), inside = peak_pressure(block, -0.8e-6, 10, 0.3);
  std::printf("flush %.4g GPa, inside %.4g\n", flush * 1e-9, inside * 1e-9);
  EXPECT_NEAR(inside, flush, 0.01 * flush);
}

TEST(Symmetry, WhatIsTiltedByAMillionthIsNotCut) {
  // Its cut face would lie beside the plane of symmetry, held by nothing: 4.6 GPa for 5.2 at 1 km/s, and a bulge of two thirds.
  const auto symmetry = [](const std::string& normal) {
    return small_case::set_up({}, projectile(ball, "[0, 0, \"1.05 mm\"]", down) + plate("bumper", "[\"12 mm\", \"12 mm\"]", "\"0.8 mm\"", "[0, 0, \"-0.4 mm\"]", "normal = " + normal))
        ->spec.symmetry.plane;
  };
  EXPECT_EQ(symmetry("[0, 0, 1]"), (std::array{true, true, false}));
  EXPECT_EQ(symmetry("[1e-7, 0, 1]"), (std::array{false, true, false}));
}

TEST(Plates, OneBesideTheLineOfFlightIsNotStruck) {
  const auto side = plate("side", "[\"20 mm\", \"10 mm\"]", "\"1 mm\"", "[\"27 mm\", 0, \"1 mm\"]", "normal = [1, 0, 0]");
  const auto s = small_case::set_up({}, projectile(ball, "[0, 0, \"1.05 mm\"]", down) + bumper + side);
  EXPECT_EQ(app::plates_in_order(s->spec), std::vector<int>{1});
  EXPECT_TRUE(s->warnings.empty());
}

TEST(Plates, ThatCrossAreRefused) {
  const auto shot = projectile(ball, "[0, 0, \"1.05 mm\"]", down);
  const auto rib = [](const std::string& z) { return plate("rib", "[\"20 mm\", \"20 mm\"]", "\"0.1 mm\"", "[\"7.73 mm\", 0, " + z + "]", "normal = [1, 0, 0]"); };
  EXPECT_THROW(small_case::set_up({}, shot + bumper + rib("\"-0.4 mm\"")), core::CaseError);
  EXPECT_NO_THROW(small_case::set_up({}, shot + bumper + rib("\"-10.8 mm\""))) << "it touches the bumper's back";
}

}  // namespace
