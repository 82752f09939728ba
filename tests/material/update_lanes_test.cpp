// SPDX-License-Identifier: Apache-2.0
// update() in lanes against update() one point at a time: the same bits for every model; and nothing but finite numbers
// over a wide sweep of states: density 0.01 to 2.5 rho_0, energy from absolute zero to 1e8 J/kg.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/material/materials.hpp"

namespace {

struct Sample {
  material::Point<double> pt;
  material::Increment<double> inc;
  double rho_new, q, dt;
};

/// The numbers of a point, in order.
template <class T>
std::vector<T*> fields(material::Point<T>& p) {
  std::vector<T*> f{&p.m, &p.rho, &p.e, &p.p, &p.c, &p.temperature};
  for (T& s : p.s) f.push_back(&s);
  f.push_back(&p.eps_p);
  f.push_back(&p.damage);
  return f;
}

std::vector<Sample> samples(const material::Material& m, int n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<Sample> all;
  for (int i = 0; i < n; ++i) {
    Sample s{};
    const bool wild = i % 2 == 0;
    s.pt.m = m.rho_0 * std::pow(10.0, -12 - 3 * u(random));
    s.pt.rho = m.rho_0 * (wild ? 0.01 + 2.49 * u(random) : 0.95 + 0.3 * u(random));
    s.pt.e = eos::cold_energy(m.eos, s.pt.rho) + std::pow(10.0, (wild ? 8 : 6) * u(random));
    s.pt.p = eos::state(m.eos, s.pt.rho, s.pt.e).p;
    double mean = 0;
    for (double& a : s.pt.s) a = 1e9 * (u(random) - 0.5);
    for (int k = 0; k < 3; ++k) mean += s.pt.s[k] / 3;
    for (int k = 0; k < 3; ++k) s.pt.s[k] -= mean;
    s.pt.eps_p = i % 5 == 0 ? 0.0 : u(random);
    s.pt.damage = i % 7 == 0 ? 1.0 : u(random);
    const double size = std::pow(10.0, -5 * u(random)) * 0.1;
    for (double& a : s.inc.d) a = size * (u(random) - 0.5);
    for (double& a : s.inc.w) a = size * (u(random) - 0.5);
    if (i % 11 == 0) s.inc = {};
    s.rho_new = s.pt.rho * std::exp(-s.inc.d[0] - s.inc.d[1] - s.inc.d[2]);
    s.q = 1e9 * u(random);
    all.push_back(s);
  }
  return all;
}

template <class T>
void compare(const material::Material& m, const std::vector<Sample>& all) {
  constexpr int width = core::Lanes<T>::width;
  constexpr double dt = 1e-8;
  for (std::size_t i = 0; i + width <= all.size(); i += width) {
    material::Point<T> lanes;
    material::Increment<T> inc;
    T rho_new, q;
    for (int k = 0; k < width; ++k) {
      Sample s = all[i + k];
      const auto from = fields(s.pt);
      const auto to = fields(lanes);
      for (std::size_t f = 0; f < from.size(); ++f) to[f]->set(k, *from[f]);
      for (int c = 0; c < 6; ++c) inc.d[c].set(k, s.inc.d[c]);
      for (int c = 0; c < 3; ++c) inc.w[c].set(k, s.inc.w[c]);
      rho_new.set(k, s.rho_new);
      q.set(k, s.q);
    }
    material::update(m, dt, rho_new, inc, q, lanes);
    const auto many = fields(lanes);
    for (int k = 0; k < width; ++k) {
      Sample s = all[i + k];
      const auto before = s.pt;
      material::update(m, dt, s.rho_new, s.inc, s.q, s.pt);
      const auto one = fields(s.pt);
      for (std::size_t f = 0; f < one.size(); ++f) {
        EXPECT_EQ(core::bits(core::lane(*many[f], k)), core::bits(*one[f])) << m.name << ", field " << f;
        EXPECT_TRUE(std::isfinite(*one[f])) << m.name << ", field " << f;
      }
      EXPECT_GT(s.pt.c, 0);
      EXPECT_GE(s.pt.damage, before.damage);
      EXPECT_LE(s.pt.damage, 1);
      EXPECT_GE(s.pt.eps_p, before.eps_p);
      EXPECT_LT(s.pt.eps_p - before.eps_p, 0.5);  // steps of at most 0.1 and stresses of at most 1e9 Pa
      if (s.pt.damage == 1) {
        EXPECT_GE(s.pt.p, 0);
        for (double a : s.pt.s) EXPECT_EQ(a, 0.0);
      }
    }
  }
}

void sweep(material::Material m) {
  m.damage = damage_4340();
  m.spall = 1.5e9;
  m.fracture_energy = 2e4;
  m.e_melt = 0.5e6, m.e_melted = 1e6;
  const auto all = samples(m, 4096);
  compare<core::Pack<2>>(m, all);
  compare<core::Pack<4>>(m, all);
  compare<core::Pack<8>>(m, all);
}

material::Material with(eos::Eos model, double rho_0, material::Strength strength) {
  material::Material m;
  m.name = "sample";
  m.rho_0 = rho_0;
  m.eos = model;
  m.strength = strength;
  material::prepare(m);
  return m;
}

}  // namespace

TEST(UpdateLanes, NoStrength) { sweep(aluminium(material::NoStrength{})); }
TEST(UpdateLanes, PerfectlyPlastic) { sweep(aluminium(material::PerfectlyPlastic{28.6e9, 0.26e9})); }
TEST(UpdateLanes, JohnsonCook) { sweep(aluminium(jc_2024())); }
TEST(UpdateLanes, SteinbergGuinan) { sweep(aluminium(sg_2024())); }
TEST(UpdateLanes, ZerilliArmstrongOfCopper) { sweep(aluminium(za_copper())); }
TEST(UpdateLanes, ZerilliArmstrongOfIron) { sweep(aluminium(za_iron())); }
TEST(UpdateLanes, Tillotson) {
  sweep(with(eos::Tillotson{.rho_0 = 2700, .a = 0.5, .b = 1.63, .A = 75.2e9, .B = 65e9, .alpha = 5, .beta = 5,
                            .E_0 = 5e6, .E_iv = 3e6, .E_cv = 13.9e6, .cv = 884},
             2700, jc_2024()));
}
TEST(UpdateLanes, Polynomial) {
  sweep(with(eos::Polynomial{.rho_0 = 2700, .C1 = 75e9, .C2 = 60e9, .C4 = 2, .C5 = 0.5, .cv = 900}, 2700, jc_2024()));
}
TEST(UpdateLanes, IdealGas) { sweep(with(eos::IdealGas{1.4, 718}, 1.2, material::NoStrength{})); }
