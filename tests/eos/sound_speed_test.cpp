// SPDX-License-Identifier: Apache-2.0
// c^2 of every model in every region against the central difference of p along an isentrope: e changes with rho by
// p/rho^2. Also that lanes give the bits of single points.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/eos/models.hpp"

namespace {

/// dp/drho along the isentrope through (rho, e); the short path is one Runge-Kutta midpoint step each way.
double difference(const eos::Eos& m, double rho, double e) {
  const double h = 1e-5 * rho;
  const auto along = [&](double step) {
    const auto de = [&](double r, double energy) { return eos::state(m, r, energy).p / (r * r); };
    const double half = e + step / 2 * de(rho, e);
    return eos::state(m, rho + step, e + step * de(rho + step / 2, half)).p;
  };
  return (along(h) - along(-h)) / (2 * h);
}

void expect_sound_speed(const eos::Eos& m, double rho, double e) {
  const double c2 = eos::state(m, rho, e).c2, expected = difference(m, rho, e);
  EXPECT_NEAR(c2, expected, 1e-6 * (std::abs(expected) + 1e4)) << "rho " << rho << ", e " << e;  // h^2 and round-off
}

template <class T, class Model>
void expect_same_bits(const Model& m, const std::vector<double>& rho, const std::vector<double>& e) {
  constexpr int width = core::Lanes<T>::width;
  for (std::size_t i = 0; i + width <= rho.size(); i += width) {
    const auto lanes = eos::state(eos::Eos(m), core::load<T>(&rho[i]), core::load<T>(&e[i]));
    for (int k = 0; k < width; ++k) {
      const auto one = eos::state(eos::Eos(m), rho[i + k], e[i + k]);
      EXPECT_EQ(core::bits(core::lane(lanes.p, k)), core::bits(one.p));
      EXPECT_EQ(core::bits(core::lane(lanes.c2, k)), core::bits(one.c2));
      EXPECT_EQ(core::bits(core::lane(lanes.temperature, k)), core::bits(one.temperature));
      EXPECT_TRUE(std::isfinite(one.p) && std::isfinite(one.c2) && std::isfinite(one.temperature));
      EXPECT_GT(one.c2, 0);
      EXPECT_GE(one.temperature, 0);
    }
  }
}

}  // namespace

TEST(SoundSpeed, MieGrueneisen) {
  for (const auto& m : {aluminium_2024(), copper(), iron(), hafnium()})
    for (double eta : {0.05, 0.3, 0.7, 0.95, 0.99, 1.01, 1.1, 1.4, 1.7})
      for (double e : {2.0, 4.0, 8.0}) expect_sound_speed(m, eta * m.rho_0, e * m.c_0 * m.c_0);
  for (double eta : {0.95, 0.99, 1.05}) expect_sound_speed(aluminium_2024(), eta * 2785, 1e5);
}

TEST(SoundSpeed, MieGrueneisenBeyondTheGuard) {
  const auto m = iron();
  expect_sound_speed(m, 1.1 * m.rho_0 / (1 - m.x_guard), 1e7);
}

TEST(SoundSpeed, Tillotson) {
  const auto m = aluminium_tillotson();
  for (double eta : {1.05, 1.4, 2.0})
    for (double e : {1e5, 1e6, 5e6, 3e7}) expect_sound_speed(m, eta * 2700, e);
  for (double e : {1e4, 1e6, 2.5e6}) expect_sound_speed(m, 0.98 * 2700, e);  // expanded, cold
  for (double eta : {0.75, 0.9}) expect_sound_speed(m, eta * 2700, 2.9e6);  // the same, fading
  for (double eta : {0.1, 0.4, 0.9}) expect_sound_speed(m, eta * 2700, 8e6);  // between
  for (double eta : {0.1, 0.5, 0.9}) expect_sound_speed(m, eta * 2700, 2e7);  // hot
}

TEST(SoundSpeed, Polynomial) {
  for (double eta : {0.9, 1.1, 1.5})
    for (double e : {1e5, 3e6}) expect_sound_speed(cubic(), eta * 2700, e);
}

TEST(SoundSpeed, IdealGas) { expect_sound_speed(eos::IdealGas{1.4, 718}, 3.0, 2e6); }

TEST(Lanes, EveryModelGivesTheBitsOfSinglePointsAndNoNaN) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0, 1);
  const auto sweep = [&](const auto& m, double rho_0) {
    std::vector<double> rho, e;
    for (int i = 0; i < 4096; ++i) {
      rho.push_back(rho_0 * (0.01 + 2.49 * u(random)));
      e.push_back(eos::cold_energy(m, rho.back()) + std::pow(10.0, 8 * u(random)));
    }
    expect_same_bits<core::Pack<2>>(m, rho, e);
    expect_same_bits<core::Pack<4>>(m, rho, e);
    expect_same_bits<core::Pack<8>>(m, rho, e);
  };
  sweep(aluminium_2024(), 2785);
  sweep(iron(), 7850);
  sweep(hafnium(), 13300);
  sweep(aluminium_tillotson(), 2700);
  sweep(cubic(), 2700);
  sweep(eos::IdealGas{1.4, 718}, 1.2);
}
