// SPDX-License-Identifier: Apache-2.0
// The verdicts of every instruction set that this machine has against one element at a time, written out in plain sentences, on
// random states and shapes, inverted ones among them.
#include <gtest/gtest.h>

#include <random>

#include "core/isa.hpp"
#include "fem/criteria_kernel.hpp"
#include "tests/fem/shapes.hpp"

namespace fem {
#define EJECTA_DECLARE(isa)                                                                                                    \
  namespace isa {                                                                                                              \
  void flag_blocks(const Mesh&, const Criteria&, const std::vector<double>&, double, std::span<const std::uint32_t>, std::uint8_t*); \
  }
EJECTA_DECLARE(baseline)
EJECTA_DECLARE(avx2)
EJECTA_DECLARE(avx512)
#undef EJECTA_DECLARE
}  // namespace fem

namespace {

using core::Vec3;
using Kernel = decltype(&fem::flag_blocks);

/// The kernel of each instruction set that this machine has.
std::vector<std::pair<const char*, Kernel>> kernels() {
  std::vector<std::pair<const char*, Kernel>> r{{"baseline", fem::baseline::flag_blocks}};
  if (core::isa() >= core::Isa::avx2) r.push_back({"avx2", fem::avx2::flag_blocks});
  if (core::isa() >= core::Isa::avx512) r.push_back({"avx512", fem::avx512::flag_blocks});
  return r;
}

constexpr std::size_t n_elements = 4000;
constexpr double rho_0 = 1000, first_step = 1e-4;

/// Hexes that share no node, each crumpled in its own way and in a state of its own. The step of a dead one is 1e300.
fem::Mesh random_mesh(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  fem::HexMesh cubes;
  for (std::size_t el = 0; el < n_elements; ++el) {
    auto& node = cubes.node.emplace_back();
    for (std::size_t i = 0; i < 8; ++i) {
      node[i] = static_cast<std::int32_t>(cubes.x.size());
      cubes.x.push_back(Vec3(shapes::sign[i][0], shapes::sign[i][1], shapes::sign[i][2]));
    }
  }
  fem::Mesh mesh;
  fem::add_body(mesh, cubes, 0, rho_0);
  fem::finish(mesh);
  auto& e = mesh.elements;
  for (std::size_t el = 0; el < n_elements; ++el) {
    const double size = u(random);
    for (const auto nd : e.node[el])
      for (int d = 0; d < 3; ++d) mesh.nodes.x[static_cast<std::size_t>(nd)][d] += size * (2 * u(random) - 1);
    const auto often = [&](double chance, double a, double b) { return u(random) < chance ? a : b; };
    e.alive[el] = u(random) < 0.9;
    e.dt_0[el] = first_step;
    e.dt[el] = e.alive[el] ? first_step * often(0.9, 0.3 + u(random), 0.2 * u(random)) : 1e300;
    e.deformation[el] = often(0.2, 0.04, 2.2) * u(random);
    e.ratio_0[el] = 1 + u(random);
    e.pt.eps_p[el] = 1.1 * u(random);
    e.pt.damage[el] = often(0.1, 1.0, u(random));
    e.pt.c[el] = 5000;
    e.pt.rho[el] = rho_0 * (0.78 + u(random));
    e.pt.p[el] = often(0.3, 1e8, 1e6) * (u(random) - 0.2);  // 1 % of rho c^2 is 2.5e8 Pa times rho/rho_0
    e.pt.p[el] = often(0.3, 6e8 * u(random), e.pt.p[el]);
    e.pt.q[el] = often(0.5, 0.0, 1e6 * u(random));
  }
  return mesh;
}

/// fem::flag_elements for one element.
bool too_distorted(const fem::Mesh& mesh, std::size_t el, const fem::Criteria& c, double from) {
  const auto& e = mesh.elements;
  const auto& pt = e.pt;
  if (!e.alive[el]) return false;
  if (e.dt[el] < c.collapse * e.dt_0[el]) return true;
  if (e.deformation[el] < from) return false;
  if (pt.rho[el] < c.expansion * rho_0) return true;
  fem::Corners<double> x;
  fem::gather(e, el, mesh.nodes.x, [&](int i, int d, double v) { x.c[i][d] = v; });
  const bool deformed = e.deformation[el] >= 0.02;
  if (deformed && shapes::jacobians(x, 1).first <= 0) return true;
  const double modulus = pt.rho[el] * pt.c[el] * pt.c[el];
  if (pt.q[el] > 0 && pt.p[el] > 0.01 * modulus) return false;
  if (c.use_deformation && e.deformation[el] > c.deformation) return true;
  if (c.use_plastic_strain && pt.eps_p[el] > c.plastic_strain) return true;
  if (c.use_timestep && e.dt[el] < c.timestep_ratio * e.dt_0[el]) return true;
  if (c.use_damage && pt.damage[el] >= c.damage) return true;
  // no hex shares a node: all of them hang on to little
  if (from == 0 && e.dt[el] < c.left_over * e.dt_0[el] && std::abs(pt.p[el]) + pt.q[el] <= 0.002 * modulus) return true;
  return deformed && c.use_jacobian && (shapes::jacobian_ratio(x) > c.jacobian_ratio * e.ratio_0[el] || fem::smallest_angle(x) < c.min_angle);
}

void expect_the_same(const fem::Criteria& criteria, double from, double least, double most) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    const fem::Mesh mesh = random_mesh(seed);
    for (const auto& [name, kernel] : kernels()) {
      std::vector<std::uint8_t> flags(mesh.awake_blocks.size(), 0xaa);
      kernel(mesh, criteria, {rho_0}, from, mesh.awake_blocks, flags.data());
      std::size_t flagged = 0, wrong = 0;
      for (std::size_t el = 0; el < n_elements; ++el) {
        const bool flag = flags[el / 8] >> el % 8 & 1;
        wrong += flag != too_distorted(mesh, el, criteria, from);
        flagged += flag;
      }
      EXPECT_EQ(wrong, 0u) << name;
      EXPECT_GT(static_cast<double>(flagged), least * n_elements) << name;
      EXPECT_LT(static_cast<double>(flagged), most * n_elements) << name;
    }
  }
}

TEST(CriteriaLanes, CollapseAndInvertedCornersAlone) { expect_the_same({}, 0, 0.03, 0.6); }

TEST(CriteriaLanes, OnlyCollapseIsLookedForBelowTheDeformationAskedFor) {
  expect_the_same({.use_deformation = true, .use_jacobian = true}, 1e300, 0.005, 0.05);
  expect_the_same({.use_deformation = true, .use_jacobian = true}, 1.5, 0.02, 0.4);
}

TEST(CriteriaLanes, RatioAndAngle) {
  expect_the_same({.use_jacobian = true, .min_angle = 0.9}, 0, 0.2, 0.8);
  expect_the_same({.use_jacobian = true, .jacobian_ratio = 1e300, .min_angle = 1.0}, 0, 0.2, 0.8);
  expect_the_same({.use_jacobian = true, .jacobian_ratio = 1.4, .min_angle = 0}, 0, 0.2, 0.8);
}

TEST(CriteriaLanes, QuantitiesOfAnElement) {
  expect_the_same({.use_deformation = true}, 0, 0.03, 0.7);
  expect_the_same({.use_plastic_strain = true, .plastic_strain = 1.0}, 0, 0.03, 0.7);
  expect_the_same({.use_timestep = true}, 0, 0.03, 0.7);
  expect_the_same({.use_damage = true}, 0, 0.03, 0.7);
}

TEST(CriteriaLanes, AllOfAHybridRun) {
  expect_the_same({.use_deformation = true, .use_jacobian = true, .use_plastic_strain = true, .use_timestep = true, .use_damage = true,
                   .plastic_strain = 1.0, .expansion = 0.8, .left_over = 0.5}, 0, 0.3, 0.95);
}

}  // namespace
