// SPDX-License-Identifier: Apache-2.0
// The kernel: unit integral, slope against finite differences, compact support.
#include "sph/kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

constexpr double h = 0.7, reach = sph::kernel_reach * h;

TEST(Kernel, IntegratesToOne) {
  // 4 pi r^2 W is a polynomial of degree 7 inside: Simpson's error with 2000 intervals is below round-off of the sum.
  constexpr int n = 2000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double r = reach * i / n, weight = i == 0 || i == n ? 1 : i % 2 ? 4 : 2;
    sum += weight * 4 * core::pi * r * r * sph::kernel(r, h);
  }
  EXPECT_NEAR(sum * reach / n / 3, 1, 1e-12);
}

TEST(Kernel, SlopeIsTheDerivative) {
  constexpr double step = 1e-5;  // central difference: error step^2 W'''/6 about 1e-9
  for (double r = 0.05; r < reach - 0.01; r += 0.05) {
    const double difference = (sph::kernel(r + step, h) - sph::kernel(r - step, h)) / (2 * step);
    EXPECT_NEAR(sph::kernel_slope(r, h) * r, difference, 1e-8) << r;
  }
}

TEST(Kernel, SlopeIsFiniteAtZero) { EXPECT_TRUE(std::isfinite(sph::kernel_slope(0.0, h))); }

TEST(Kernel, ZeroOutside) {
  for (const double r : {reach, 1.001 * reach, 5 * reach}) {
    EXPECT_EQ(sph::kernel(r, h), 0.0);
    EXPECT_EQ(sph::kernel_slope(r, h), 0.0);
  }
}

TEST(Kernel, MomentOfTheGradientIsUnity) {
  // Integral of -x (dW/dx) = 1 for each direction: 4 pi/3 r^4 (-dW/dr / r); degree 7 again.
  constexpr int n = 2000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double r = reach * i / n, weight = i == 0 || i == n ? 1 : i % 2 ? 4 : 2;
    sum -= weight * 4 * core::pi / 3 * r * r * r * r * sph::kernel_slope(r, h);
  }
  EXPECT_NEAR(sum * reach / n / 3, 1, 1e-12);
}

}  // namespace
