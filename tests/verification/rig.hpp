// SPDX-License-Identifier: Apache-2.0
// Builds a simulation from meshes and materials without a case file, for problems with exact solutions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "app/simulation.hpp"
#include "fem/elements.hpp"
#include "fem/generate.hpp"

namespace rig {

using core::Vec3;

/// Linear Us-up Mie-Grueneisen material.
inline material::Material mie_grueneisen(double rho_0, double c_0, double s, double gamma, double a = 0) {
  material::Material m;
  m.name = "test";
  m.rho_0 = rho_0;
  eos::MieGrueneisen e;
  e.rho_0 = rho_0, e.c_0 = c_0, e.s_1 = s, e.gamma_0 = gamma, e.a = a, e.cv = 900;
  m.eos = e;
  eos::prepare(m.eos);
  m.strength = material::NoStrength{};
  return m;
}

/// Linear elastic to a good approximation: Us = c_0, no heating, bulk modulus rho c_0^2, and no yield.
inline material::Material elastic(double rho_0, double K, double G) {
  auto m = mie_grueneisen(rho_0, std::sqrt(K / rho_0), 0, 0);
  m.strength = material::PerfectlyPlastic{G, 1e6 * G};
  return m;
}

inline material::Material ideal_gas(double rho_0, double gamma) {
  material::Material m;
  m.name = "gas";
  m.rho_0 = rho_0;
  m.eos = eos::IdealGas{gamma, 718};
  m.strength = material::NoStrength{};
  return m;
}

class Rig {
 public:
  Rig() : s(std::make_unique<app::Simulation>()) {
    s->spec.mode = io::Mode::fem;
    s->spec.end = 1e300;
    s->sleep_threshold = -1;
    s->scene.impact_velocity = Vec3::Zero();
  }

  /// Adds a body moving at v(x).
  void add(const fem::HexMesh& mesh, const material::Material& material, const std::function<Vec3(const Vec3&)>& velocity) {
    s->materials.push_back(material);
    s->rho_0.push_back(material.rho_0);
    fem::add_body(s->mesh, mesh, static_cast<int>(s->materials.size()) - 1, material.rho_0);
    auto& n = s->mesh.nodes;
    for (auto nd = s->mesh.body_nodes.back().first; nd < s->mesh.body_nodes.back().last; ++nd)
      n.v[nd] = n.v_mean[nd] = velocity(n.x[nd]);
    auto& e = s->mesh.elements;
    for (auto el = s->mesh.body_elements.back().first; el < s->mesh.body_elements.back().last; ++el) {
      const auto state = eos::state(material.eos, material.rho_0, 0.0);
      e.pt.T[el] = state.temperature;
      e.pt.c[el] = std::sqrt(state.c2 + 4.0 / 3.0 * material::shear_modulus(material.strength) / material.rho_0);
    }
  }

  /// No motion along the marked directions, on every node for which `where` holds.
  void fix(int bits, const std::function<bool(const Vec3&)>& where) {
    for (std::size_t nd = 0; nd < s->mesh.nodes.size(); ++nd)
      if (where(s->mesh.nodes.x[nd])) s->mesh.nodes.fixed[nd] = static_cast<std::uint8_t>(s->mesh.nodes.fixed[nd] | bits);
  }

  void begin() {
    fem::finish(s->mesh);
    if (s->element_settings.hourglass_stiffness)
      s->mesh.elements.hourglass.assign(s->mesh.elements.size() * 12, 0.0);
    app::begin(*s);
  }

  void run(double end) {
    while (s->time < end * (1 - 1e-12)) {
      app::choose_step(*s, end);
      app::step(*s);
    }
  }

  std::unique_ptr<app::Simulation> s;
};

/// Prints a measured value beside the exact one, records it for the test report, and returns the relative error.
inline double report(const std::string& name, double measured, double exact) {
  const double error = exact != 0 ? measured / exact - 1 : measured;
  std::printf("  %-44s measured %-14.7g exact %-14.7g error %+.3e\n", name.c_str(), measured, exact, error);
  char text[160];
  std::snprintf(text, sizeof text, "measured %.9g exact %.9g error %.3e", measured, exact, error);
  std::string key;
  for (const char c : name) key += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  ::testing::Test::RecordProperty(key, text);
  return error;
}

/// A number with no exact value beside it.
inline void note(const std::string& name, double value) {
  std::printf("  %-44s %.6g\n", name.c_str(), value);
  std::string key;
  for (const char c : name) key += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  ::testing::Test::RecordProperty(key, std::to_string(value));
}

/// Order of convergence seen between two errors on meshes that differ by a factor of two.
inline double observed_order(const std::string& name, double coarse, double fine) {
  const double order = std::log2(std::abs(coarse) / std::abs(fine));
  std::printf("  %-44s coarse %.4e fine %.4e order %.3f\n", name.c_str(), coarse, fine, order);
  std::string key;
  for (const char c : name) key += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  ::testing::Test::RecordProperty(key + "_order", std::to_string(order));
  return order;
}

inline std::vector<double> line(double first, double last, int n) {
  std::vector<double> x;
  for (int i = 0; i <= n; ++i) x.push_back(first + (last - first) * i / n);
  return x;
}

}  // namespace rig
