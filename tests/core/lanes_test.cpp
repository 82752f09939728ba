// SPDX-License-Identifier: Apache-2.0
// Packs of lanes: every lane has the bits that a plain double would have, and the functions of lane_math.hpp agree with
// those of the standard library.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/lane_math.hpp"
#include "core/pack.hpp"

using core::Pack;

namespace {

std::vector<double> samples(std::size_t n, double exponents) {
  std::vector<double> a{0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 1e-310, 1e-300, 1e300, 707.9, -707.9, 709.0, -709.0, 1e9};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> m(-2, 2), e(-exponents, exponents);
  while (a.size() < n) a.push_back(m(random) * std::exp2(e(random)));
  return a;
}

/// f(double) and f(Pack<W>) on the same numbers.
template <int W, class F>
void expect_same_bits_at(F f, const std::vector<double>& a, const std::vector<double>& b) {
  for (std::size_t i = 0; i + W <= a.size(); i += W) {
    const Pack<W> p = f(core::load<Pack<W>>(&a[i]), core::load<Pack<W>>(&b[i]));
    for (int lane = 0; lane < W; ++lane)
      ASSERT_EQ(core::bits(p[lane]), core::bits(f(a[i + lane], b[i + lane])))
          << "lane " << lane << " of " << W << " of " << a[i + lane] << ", " << b[i + lane];
  }
}
template <class F>
void expect_same_bits(F f, double exponents = 40) {
  const std::vector<double> a = samples(4096, exponents), b(a.rbegin(), a.rend());
  expect_same_bits_at<2>(f, a, b);
  expect_same_bits_at<4>(f, a, b);
  expect_same_bits_at<8>(f, a, b);
}

/// Distance of two doubles of the same sign in units of the last place.
double ulps(double a, double b) { return std::abs(static_cast<double>(core::bits(a) - core::bits(b))); }

}  // namespace

TEST(Pack, ArithmeticHasTheBitsOfDouble) {
  expect_same_bits([](auto a, auto b) { return a + b; });
  expect_same_bits([](auto a, auto b) { return a - b; });
  expect_same_bits([](auto a, auto b) { return a * b; });
  expect_same_bits([](auto a, auto b) { return a / core::select(b > -0.0, b, decltype(b)(3.0)); });
  expect_same_bits([](auto a, auto) { return -a; });
  expect_same_bits([](auto a, auto b) { return a * b + a; });  // not fused
  expect_same_bits([](auto a, auto b) { a += b; a *= b; a -= b; return a; });
}

TEST(Pack, FunctionsHaveTheBitsOfDouble) {
  expect_same_bits([](auto a, auto) { return core::sqrt(core::abs(a)); });
  expect_same_bits([](auto a, auto b) { return core::min(a, b); });
  expect_same_bits([](auto a, auto b) { return core::max(a, b); });
  expect_same_bits([](auto a, auto b) { return core::select((a < b) | !(a <= b + b), a, b); });
  expect_same_bits([](auto a, auto b) { return core::select((a > b) & (a >= -b), a, b); });
}

TEST(Pack, BroadcastKeepsTheBits) {
  for (const double a : {0.0, -0.0, 1.5, 1e-310, std::numeric_limits<double>::infinity()}) {
    const Pack<4> p(a);
    for (int lane = 0; lane < 4; ++lane) EXPECT_EQ(core::bits(p[lane]), core::bits(a)) << a;
  }
}

TEST(Pack, MinAndMaxGiveTheSecondWhereOneIsNaN) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(core::min(nan, 2.0), 2.0);
  EXPECT_EQ(core::max(nan, 2.0), 2.0);
  EXPECT_TRUE(std::isnan(core::max(2.0, nan)));
  EXPECT_EQ(core::min(Pack<4>(nan), Pack<4>(2.0))[3], 2.0);
  EXPECT_TRUE(std::isnan(core::max(Pack<4>(2.0), Pack<4>(nan))[0]));
}

TEST(Pack, AnyAndLanes) {
  Pack<4> a(1.0);
  EXPECT_FALSE(core::any(a < 1.0));
  a.set(2, 0.5);
  EXPECT_TRUE(core::any(a < 1.0));
  EXPECT_TRUE(core::lane(a < 1.0, 2));
  EXPECT_FALSE(core::lane(a < 1.0, 1));
  EXPECT_EQ(core::lane(a, 2), 0.5);
  double stored[4];
  core::store(stored, a);
  EXPECT_EQ(stored[2], 0.5);
  EXPECT_EQ(core::Lanes<Pack<8>>::width, 8);
  EXPECT_EQ(core::Lanes<double>::width, 1);
}

TEST(LaneMath, HasTheBitsOfDoubleAtEveryWidth) {
  expect_same_bits([](auto a, auto) { return core::exp(a); });
  expect_same_bits([](auto a, auto) { return core::log(core::max(core::abs(a), decltype(a)(1e-300))); });
  expect_same_bits([](auto a, auto b) { return core::pow(core::abs(a), b); }, 3);
  expect_same_bits([](auto a, auto) { return core::cbrt(core::abs(a)); });
}

// The relative error stated in lane_math.hpp is below 3e-16, that is 1.4 to 2.7 units in the last place; the library's
// own is below one.
TEST(LaneMath, ExpAgreesWithTheLibrary) {
  for (double x = -707.99; x < 708; x += 0.0371) ASSERT_LE(ulps(core::exp(x), std::exp(x)), 3) << x;
  for (double x = 1e-20; x < 1; x *= 1.37) ASSERT_LE(ulps(core::exp(-x), std::exp(-x)), 3) << x;
  EXPECT_EQ(core::exp(0.0), 1.0);
}

TEST(LaneMath, ExpSaturates) {
  EXPECT_EQ(core::exp(1e9), core::exp(708.0));
  EXPECT_EQ(core::exp(-1e9), core::exp(-708.0));
  EXPECT_GT(core::exp(-1e9), 0.0);
  EXPECT_LT(core::exp(1e9), std::numeric_limits<double>::infinity());
}

TEST(LaneMath, LogAgreesWithTheLibrary) {
  for (double x = 1e-300; x < 1e300; x *= 1.0173) ASSERT_LE(ulps(core::log(x), std::log(x)), 3) << x;
  for (double d = 1e-15; d < 0.4; d *= 1.21) {  // about 1, where the result is small
    ASSERT_LE(ulps(core::log(1 + d), std::log(1 + d)), 3) << d;
    ASSERT_LE(ulps(core::log(1 - d), std::log(1 - d)), 3) << d;
  }
  EXPECT_EQ(core::log(1.0), 0.0);
}

// An error of e in y log x is one of e |y log x| in the result; with |y log x| < 20 about 40 units in the last place.
TEST(LaneMath, PowAgreesWithTheLibrary) {
  for (double x = 1e-6; x < 1e6; x *= 1.093)
    for (const double y : {0.01, 0.25, 1.0 / 3, 0.5, 1.0, 1.03, 1.4}) ASSERT_LE(ulps(core::pow(x, y), std::pow(x, y)), 40) << x << " ^ " << y;
  EXPECT_EQ(core::pow(0.0, 0.3), 0.0);
  EXPECT_EQ(core::pow(1.0, 0.3), 1.0);
}

TEST(LaneMath, CbrtAgreesWithTheLibrary) {
  for (double x = 1e-18; x < 1e18; x *= 1.171) ASSERT_LE(ulps(core::cbrt(x), std::cbrt(x)), 30) << x;
  EXPECT_EQ(core::cbrt(0.0), 0.0);
}
