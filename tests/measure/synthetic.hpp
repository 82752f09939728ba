// SPDX-License-Identifier: Apache-2.0
// Matter with known answers: blocks of hexes with elements left out and nodes moved, and single particles.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "measure/matter.hpp"

namespace synthetic {

using core::Vec3;
constexpr double rho_0 = 2700, mm = 1e-3, impact_speed = 8000;

/// The rotation from a body's own axes to the scene's, as the shortest one that turns z to the normal.
inline core::Mat3 turn(const Vec3& normal) {
  return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normal.normalized()).toRotationMatrix();
}

struct Block {
  int n[3] = {1, 1, 1};
  Vec3 low, high;                                            ///< own axes [m]
  std::function<bool(const Vec3&)> keep = [](const Vec3&) { return true; };    ///< by centre before the map
  std::function<Vec3(const Vec3&)> map = [](const Vec3& x) { return x; };      ///< of nodes, own axes
  std::function<Vec3(const Vec3&)> place = [](const Vec3& x) { return x; };    ///< own axes to the scene
  bool periodic_x = false;                                   ///< the last nodes along x are the first ones
  int body = 0;
  Vec3 v{0, 0, 0};
};

inline void add_row(measure::Matter& m, const Vec3& x, const Vec3& v, double mass, double size, int body) {
  m.x.own.push_back(x), m.v.own.push_back(v), m.m.own.push_back(mass), m.size.own.push_back(size), m.body.own.push_back(body);
  m.rho.own.push_back(mass / (size * size * size));
  for (auto* field : {&m.e, &m.T, &m.damage}) field->own.push_back(0);
}

/// Adds elements; before any particle.
inline void add_block(measure::Matter& m, const Block& b) {
  std::map<std::array<int, 3>, std::int32_t> nodes;
  const auto at = [&](int i, int j, int k) {
    return Vec3(b.low + (b.high - b.low).cwiseProduct(Vec3(double(i) / b.n[0], double(j) / b.n[1], double(k) / b.n[2])));
  };
  const auto node = [&](int i, int j, int k) {
    if (b.periodic_x) i %= b.n[0];
    const auto [it, is_new] = nodes.try_emplace({i, j, k}, static_cast<std::int32_t>(m.node_x.size()));
    if (is_new) m.node_x.push_back(b.place(b.map(at(i, j, k))));
    return it->second;
  };
  for (int k = 0; k < b.n[2]; ++k)
    for (int j = 0; j < b.n[1]; ++j)
      for (int i = 0; i < b.n[0]; ++i) {
        if (!b.keep(0.5 * (at(i, j, k) + at(i + 1, j + 1, k + 1)))) continue;
        const std::array<std::int32_t, 8> c{node(i, j, k),         node(i + 1, j, k),     node(i + 1, j + 1, k),
                                            node(i, j + 1, k),     node(i, j, k + 1),     node(i + 1, j, k + 1),
                                            node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)};
        Vec3 centre = Vec3::Zero();
        for (const auto nd : c) centre += m.node_x[nd] / 8;
        const Vec3 a = m.node_x[c[1]] - m.node_x[c[0]], d = m.node_x[c[3]] - m.node_x[c[0]],
                   e = m.node_x[c[4]] - m.node_x[c[0]];
        const double size = std::cbrt(std::abs(a.cross(d).dot(e)));
        m.node.push_back(c);
        add_row(m, centre, b.v, rho_0 * size * size * size, size, b.body);
        ++m.n_elements;
      }
}

inline void add_particle(measure::Matter& m, const Vec3& x, const Vec3& v, double spacing, int body) {
  add_row(m, x, v, rho_0 * spacing * spacing * spacing, spacing, body);
}

/// A projectile (body 0) that flies along -z into plates added one by one.
inline measure::Scene scene_at(const Vec3& velocity = {0, 0, -impact_speed}) {
  measure::Scene s;
  measure::BodyScene projectile;
  projectile.name = "projectile";
  projectile.is_projectile = true;
  projectile.rho_0 = rho_0;
  s.bodies.push_back(projectile);
  s.impact_velocity = velocity;
  s.projectile_size = 4 * mm;
  return s;
}

inline int add_plate(measure::Scene& s, const std::string& name, double width, double thickness,
                     const Vec3& center = {0, 0, 0}, const Vec3& normal = {0, 0, 1}) {
  measure::BodyScene b;
  b.name = name;
  b.is_plate = true;
  b.center = center;
  b.normal = normal;
  b.thickness = thickness;
  b.extent = Vec3(width, width, thickness);
  b.rho_0 = rho_0;
  s.bodies.push_back(b);
  s.plates.push_back(static_cast<int>(s.bodies.size()) - 1);
  return s.plates.back();
}

inline std::optional<double> find(const measure::Result& r, const std::string& key) {
  for (const auto& v : r.values)
    if (v.key == key) return v.value;
  return std::nullopt;
}

inline double get(const measure::Result& r, const std::string& key) {
  const auto v = find(r, key);
  EXPECT_TRUE(v.has_value()) << key;
  return v.value_or(NAN);
}

/// A square plate of n x n x layers elements about the origin, body 1, own axes.
inline Block plate(double width, double thickness, int n, int layers) {
  Block b;
  b.n[0] = b.n[1] = n, b.n[2] = layers;
  b.low = Vec3(-width / 2, -width / 2, -thickness / 2);
  b.high = -b.low;
  b.body = 1;
  return b;
}

/// A square plate with a round or elliptical hole that its mesh follows: rings of elements from the hole to the edge.
inline Block ring_plate(double width, double thickness, double a, double b, int n_round, int n_out, int layers) {
  Block r;
  r.n[0] = n_round, r.n[1] = n_out, r.n[2] = layers;
  r.low = Vec3(0, 0, -thickness / 2);
  r.high = Vec3(2 * core::pi, 1, thickness / 2);
  r.periodic_x = true;
  r.body = 1;
  r.map = [=](const Vec3& x) {
    const double c = std::cos(x.x()), s = std::sin(x.x()), edge = width / 2 / std::max(std::abs(c), std::abs(s));
    const Vec3 inner(a * c, b * s, 0), outer(edge * c, edge * s, 0);
    return Vec3(inner + x.y() * x.y() * (outer - inner) + Vec3(0, 0, x.z()));
  };
  return r;
}

}  // namespace synthetic
