// SPDX-License-Identifier: Apache-2.0
// Times whole steps of a jittered block of aluminium (Johnson-Cook, Mie-Grueneisen, gradient correction, artificial stress,
// 57 neighbours in the kernel): processor time of each pass for one particle, and particle-steps a second. Not a test.
//   sph_bench [side] [steps] [threads]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/isa.hpp"
#include "tests/material/materials.hpp"
#include "tests/sph/particle_block.hpp"

/// Processor time of one thread, or time on the wall of several [s].
static double now(int threads) {
  if (threads == 1) return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  return 1e-9 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

int main(int argc, char** argv) {
  const int side = argc > 1 ? std::atoi(argv[1]) : 32, steps = argc > 2 ? std::atoi(argv[2]) : 60,
            threads = argc > 3 ? std::atoi(argv[3]) : 1;
  core::set_threads(threads);
  ParticleBlock block(side, 1e-4, 0.1, 300, aluminium(jc_2024()));
  double spent[ParticleBlock::n_passes] = {}, total = 0;
  for (int k = -2; k < steps; ++k) {  // the first two warm the memory
    double t = now(threads);
    block.step(block.stable_step(), [&](ParticleBlock::Pass pass) {
      const double t_new = now(threads);
      if (k >= 0) spent[pass] += t_new - t;
      t = t_new;
    });
  }
  const double n = static_cast<double>(block.p.size()), per = 1e9 / (n * steps);
  std::printf("%s, %.0f particles, %.1f candidates each, %d steps, %d builds\n", core::isa_name(), n,
              static_cast<double>(sph::n_pairs(block.hood)) / n, steps, static_cast<int>(block.hood.builds));
  for (int k = 0; k < ParticleBlock::n_passes; ++k) {
    std::printf("  %-12s %7.1f ns\n", ParticleBlock::pass_names[k], spent[k] * per);
    total += spent[k];
  }
  double energy = 0, failed = 0;
  core::Vec3 momentum = core::Vec3::Zero();
  for (std::size_t i = 0; i < block.p.size(); ++i) {
    energy += block.p.pt.m[i] * (block.p.pt.e[i] + 0.5 * block.p.v[i].squaredNorm());
    momentum += block.p.pt.m[i] * block.p.v[i];
    failed += block.p.pt.damage[i] >= 1;
  }
  std::printf("  %-12s %7.1f ns: %.3f million particle-steps/s\n", "all", total * per, 1e-6 * n * steps / total);
  std::printf("  energy %.17g J, momentum %.17g Ns, failed %.0f\n", energy, momentum[0], failed);
}
