// SPDX-License-Identifier: Apache-2.0
// Exposed faces of a block as built, on symmetry planes, and as elements go.
#include "fem/surface.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fem/elements.hpp"
#include "fem/hex8.hpp"

namespace {

using core::Vec3;

fem::Mesh cube_of_27() {
  fem::Mesh mesh;
  fem::add_body(mesh, fem::box({0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 3}), 0, 1000);
  fem::finish(mesh);
  return mesh;
}

std::size_t element_at(const fem::Mesh& mesh, const Vec3& where) {
  for (std::size_t el = 0; el < mesh.elements.size(); ++el)
    if (mesh.elements.alive[el] && (fem::centre(mesh, el, mesh.nodes.x) - where).norm() < 1e-12) return el;
  ADD_FAILURE();
  return 0;
}

TEST(Surface, FacesOfABlock) {
  const auto mesh = cube_of_27();
  fem::Surface s;
  fem::update_surface(mesh, s);
  EXPECT_EQ(s.faces.size(), 54u);
  EXPECT_EQ(s.nodes.size(), 64u - 8u);
}

TEST(Surface, FacesAppearWhenAnInnerElementGoes) {
  auto mesh = cube_of_27();
  fem::Surface s;
  fem::update_surface(mesh, s);
  fem::remove_element(mesh, element_at(mesh, {1.5, 1.5, 1.5}), false);
  fem::update_surface(mesh, s);
  EXPECT_EQ(s.faces.size(), 54u + 6u);
  EXPECT_EQ(s.nodes.size(), 64u);
}

TEST(Surface, FacesAppearAndGoWithACornerElement) {
  auto mesh = cube_of_27();
  fem::Surface s;
  fem::update_surface(mesh, s);
  fem::remove_element(mesh, element_at(mesh, {0.5, 0.5, 0.5}), false);  // three go, three appear
  fem::update_surface(mesh, s);
  EXPECT_EQ(s.faces.size(), 54u);
  EXPECT_EQ(s.nodes.size(), 56u - 1u + 1u);  // the outer corner goes, the inner one appears
}

TEST(Surface, FacesOnSymmetryPlanesAreNone) {
  auto mesh = cube_of_27();
  for (std::size_t nd = 0; nd < mesh.nodes.size(); ++nd)
    if (mesh.nodes.x[nd][0] == 0) mesh.nodes.fixed[nd] = 1;
  fem::Surface s;
  fem::update_surface(mesh, s);
  EXPECT_EQ(s.faces.size(), 45u);
}

TEST(Surface, KeptUpEqualsBuiltAnew) {
  auto mesh = cube_of_27();
  fem::Surface kept;
  fem::update_surface(mesh, kept);
  std::mt19937 random(5);
  while (mesh.n_alive > 0) {
    for (int i = 0; i < 3 && mesh.n_alive > 0; ++i) {
      std::size_t el = random() % mesh.elements.size();
      while (!mesh.elements.alive[el]) el = (el + 1) % mesh.elements.size();
      fem::remove_element(mesh, el, false);
    }
    const auto nodes_before = kept.nodes;
    fem::update_surface(mesh, kept);
    fem::Surface anew;
    fem::update_surface(mesh, anew);
    EXPECT_EQ(kept.nodes, anew.nodes);
    ASSERT_EQ(kept.faces.size(), anew.faces.size());
    for (std::size_t k = 0; k < kept.faces.size(); ++k) {
      EXPECT_EQ(kept.faces[k].element, anew.faces[k].element);
      EXPECT_EQ(kept.faces[k].face, anew.faces[k].face);
    }
    EXPECT_EQ(nodes_before.size() + kept.new_nodes.size() - kept.lost_nodes.size(), kept.nodes.size());
  }
  EXPECT_TRUE(kept.faces.empty());
}

TEST(Surface, NormalsPointOutward) {
  const auto mesh = cube_of_27();
  fem::Surface s;
  fem::update_surface(mesh, s);
  Vec3 sum = Vec3::Zero();
  double volume = 0;  // divergence theorem: sum of area . x / 3
  for (const auto& f : s.faces) {
    Vec3 x[4];
    for (int k = 0; k < 4; ++k)
      x[k] = mesh.nodes.x[static_cast<std::size_t>(
          mesh.elements.node[f.element][static_cast<std::size_t>(fem::face_corner[f.face][k])])];
    const Vec3 area = 0.5 * (x[2] - x[0]).cross(x[3] - x[1]);
    sum += area;
    volume += area.dot(x[0] + x[1] + x[2] + x[3]) / 12;
  }
  EXPECT_LT(sum.norm(), 1e-13);
  EXPECT_NEAR(volume, 27, 1e-12);
}

}  // namespace
