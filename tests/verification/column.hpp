// SPDX-License-Identifier: Apache-2.0
// A square column of particles along z with mirror planes on its four sides: one-dimensional flow in SPH. The column is
// `across` spacings wide, at least the kernel's reach with its skin, because one image of each plane must do.
#pragma once

#include "tests/verification/rig.hpp"

namespace rig {

struct Column {
  Column(int n, double low, double high, int across, const material::Material& m, const std::function<Vec3(const Vec3&)>& velocity)
      : Column(line(low, high, n), (high - low) / n, across, m, velocity) {}
  /// z: faces between the layers; dx: spacing across.
  Column(const std::vector<double>& z, double dx_, int across, const material::Material& m, const std::function<Vec3(const Vec3&)>& velocity)
      : dx(dx_), width(across * dx) {
    rig.s->spec.mode = io::Mode::sph;
    rig.add(fem::box(line(0, width, across), line(0, width, across), z), m, velocity);
    auto& mirrors = rig.s->hood.mirrors;
    mirrors.push_back({Vec3(0, 0, 0), Vec3(1, 0, 0), false});
    mirrors.push_back({Vec3(width, 0, 0), Vec3(-1, 0, 0), false});
    mirrors.push_back({Vec3(0, 0, 0), Vec3(0, 1, 0), false});
    mirrors.push_back({Vec3(0, width, 0), Vec3(0, -1, 0), false});
  }
  void mirror_at(double z, double direction) {
    rig.s->hood.mirrors.push_back({Vec3(0, 0, z), Vec3(0, 0, direction), false});
  }
  double mean(const std::vector<double>& a, double from, double to) const {
    const auto& p = rig.s->particles;
    double sum = 0;
    int n = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.x[i][2] > from && p.x[i][2] < to) sum += a[i], ++n;
    return sum / n;
  }
  /// L1 norm of the density per unit length, every particle standing for its own share of the length.
  template <class Exact>
  double l1(Exact&& exact) const {
    const auto& p = rig.s->particles;
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
      sum += std::abs(p.pt.rho[i] - exact(p.x[i][2])) * p.pt.m[i] / (p.pt.rho[i] * width * width);
    return sum;
  }
  Rig rig;
  double dx, width;
};

}  // namespace rig
