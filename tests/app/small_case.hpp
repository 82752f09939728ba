// SPDX-License-Identifier: Apache-2.0
// A small shot through the case file: a sphere of 1 mm on a plate of 0.3 mm at 6 km/s, eight elements across.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "app/setup.hpp"
#include "app/simulation.hpp"
#include "io/case_file.hpp"

namespace small_case {

inline const char* const text = R"(title = "small shot"
[run]
mode = "hybrid"
end = "1 us"
elements_across = 8
[[body]]
name = "projectile"
shape = "sphere"
diameter = "1 mm"
center = ["0 mm", "0 mm", "0.52 mm"]
velocity = ["0 km/s", "0 km/s", "-6 km/s"]
material = "Al2024-T351"
[[body]]
name = "bumper"
shape = "plate"
size = ["6 mm", "6 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-0.15 mm"]
material = "Al2024-T351"
)";

/// The same shot along x at a plate with its normal along x.
inline const char* const turned = R"(title = "small shot along x"
[run]
mode = "hybrid"
end = "1 us"
elements_across = 8
[[body]]
name = "projectile"
shape = "sphere"
diameter = "1 mm"
center = ["0.52 mm", "0 mm", "0 mm"]
velocity = ["-6 km/s", "0 km/s", "0 km/s"]
material = "Al2024-T351"
[[body]]
name = "bumper"
shape = "plate"
size = ["6 mm", "6 mm"]
thickness = "0.3 mm"
center = ["-0.15 mm", "0 mm", "0 mm"]
normal = [1, 0, 0]
material = "Al2024-T351"
)";

inline std::string write(const std::string& toml) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(info->test_suite_name()) + "_" + info->name();
  std::replace(name.begin(), name.end(), '/', '_');
  const auto path = std::filesystem::temp_directory_path() / ("ejecta_" + name + "_" + std::to_string(getpid()) + ".toml");
  std::ofstream(path) << toml;
  return path.string();
}

inline std::unique_ptr<app::Simulation> set_up(const std::vector<std::string>& set = {}, const std::string& toml = text) {
  const auto path = write(toml);
  const auto spec = io::read_case(path, set);
  std::filesystem::remove(path);
  return app::set_up(spec);
}

inline std::unique_ptr<app::Simulation> begin(const std::vector<std::string>& set = {}, const std::string& toml = text) {
  auto s = set_up(set, toml);
  app::begin(*s);
  return s;
}

inline void run(app::Simulation& s, std::int64_t steps) {
  while (s.steps < steps && s.time < s.spec.end * (1 - 1e-12)) {
    app::choose_step(s, s.spec.end);
    app::step(s);
  }
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Arrays that differ, by name; empty for equal states.
inline std::string differences(app::Simulation& a, app::Simulation& b) {
  std::string r;
  const auto compare = [&](const std::string& name, const auto& x, const auto& y) {
    if (same_bits(x, y)) return;
    std::size_t rows = 0;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) rows += std::memcmp(&x[i], &y[i], sizeof(x[i])) != 0;
    r += name + " (" + std::to_string(rows) + " of " + std::to_string(x.size()) + "/" + std::to_string(y.size()) + " rows) ";
  };
  compare("nodes.x", a.mesh.nodes.x, b.mesh.nodes.x);
  compare("nodes.v", a.mesh.nodes.v, b.mesh.nodes.v);
  compare("nodes.m", a.mesh.nodes.m, b.mesh.nodes.m);
  compare("alive", a.mesh.elements.alive, b.mesh.elements.alive);
  const auto points = [&](const std::string& name, core::Points& p, core::Points& q) {
    std::vector<const std::vector<double>*> fields;
    p.each_field([&](std::vector<double>& f) { fields.push_back(&f); });
    std::size_t k = 0;
    q.each_field([&](std::vector<double>& f) { compare(name + "." + std::to_string(k), *fields[k], f), ++k; });
  };
  points("elements", a.mesh.elements.pt, b.mesh.elements.pt);
  points("particles", a.particles.pt, b.particles.pt);
  compare("particles.x", a.particles.x, b.particles.x);
  compare("particles.v", a.particles.v, b.particles.v);
  compare("particles.h", a.particles.h, b.particles.h);
  compare("particles.parent", a.particles.parent, b.particles.parent);
  if (a.time != b.time) r += "time ";
  if (a.dt != b.dt) r += "dt ";
  if (a.steps != b.steps) r += "steps ";
  if (a.ledger.total() != b.ledger.total()) r += "ledger ";
  return r;
}

}  // namespace small_case
