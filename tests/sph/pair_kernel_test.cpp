// SPDX-License-Identifier: Apache-2.0
// The pair kernels have the same bits on every instruction set that this machine has, and see whom a plain search sees.
#include "sph/pair_kernel.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "core/isa.hpp"
#include "sph/stress_kernel.hpp"
#include "tests/material/materials.hpp"
#include "tests/sph/particle_block.hpp"

namespace {

struct Kernels {
  decltype(&sph::baseline::find_near) find_near;
  decltype(&sph::baseline::correct_rows) correct_rows;
  decltype(&sph::baseline::pair_forces) pair_forces;
  decltype(&sph::baseline::pair_work) pair_work;
};

struct Result {
  std::vector<sph::Moment> moment;
  std::vector<core::Mat3> correction;
  std::vector<float> acoustic;
  std::vector<sph::RowForce> force;
  std::vector<sph::RowWork> work;
  explicit Result(std::size_t n) : moment(n), correction(n), acoustic(n), force(n), work(n) {}
};

Result pass(ParticleBlock& block, const Kernels& kernel) {
  const std::size_t n = block.p.size();
  auto& hood = block.hood;
  sph::PairView view = sph::view(hood);
  Result r(n);
  kernel.find_near(view, 0, n, r.moment.data());
  kernel.correct_rows(block.p.pt, 0.3, 0, n, r.moment.data(), r.correction.data(), r.acoustic.data(), hood.actors);
  sph::make_room_for_pull(hood);
  view = sph::view(hood);
  kernel.pair_forces(view, block.settings, 0, n, r.force.data());
  kernel.pair_work(view, 0, n, r.work.data());
  return r;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// A block after a few steps: stress of all signs, two bodies.
ParticleBlock worked_block() {
  ParticleBlock block(9, 1e-4, 0.2, 500, aluminium(jc_2024()));
  block.rho_0.push_back(block.rho_0[0]);
  block.body_material.push_back(0);
  for (std::size_t i = 0; i < block.p.size(); ++i) block.p.body[i] = block.p.x[i][0] > 4e-4;
  for (int k = 0; k < 8; ++k) block.step(block.stable_step(), [](ParticleBlock::Pass) {});
  return block;
}

TEST(PairKernels, SameBitsOnEveryInstructionSet) {
  using namespace sph;
  auto block = worked_block();
  const auto narrow =
      pass(block, {baseline::find_near, baseline::correct_rows, baseline::pair_forces, baseline::pair_work});
  const auto compare = [&](const Kernels& kernel) {
    const auto wide = pass(block, kernel);
    EXPECT_TRUE(same_bits(narrow.moment, wide.moment));
    EXPECT_TRUE(same_bits(narrow.correction, wide.correction));
    EXPECT_TRUE(same_bits(narrow.acoustic, wide.acoustic));
    EXPECT_TRUE(same_bits(narrow.force, wide.force));
    EXPECT_TRUE(same_bits(narrow.work, wide.work));
  };
  if (core::isa() >= core::Isa::avx2)
    compare({avx2::find_near, avx2::correct_rows, avx2::pair_forces, avx2::pair_work});
  if (core::isa() >= core::Isa::avx512)
    compare({avx512::find_near, avx512::correct_rows, avx512::pair_forces, avx512::pair_work});
}

TEST(PairKernels, NearAreThoseWithinTwoMeanSmoothingLengths) {
  auto block = worked_block();
  block.step(block.stable_step(), [](ParticleBlock::Pass) {});
  const auto& hood = block.hood;
  for (std::size_t i = 0; i < hood.n_particles; ++i) {
    std::uint32_t n = 0;
    for (std::size_t j = 0; j < hood.n_particles; ++j) {
      const auto &a = hood.actors.place[i], &b = hood.actors.place[j];
      const double reach = double(a.h) + double(b.h);
      n += j != i && (a.x - b.x).squaredNorm() < reach * reach;
    }
    EXPECT_EQ(hood.n_near[i], n) << i;
  }
}

}  // namespace
