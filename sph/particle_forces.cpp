// SPDX-License-Identifier: Apache-2.0
#include "sph/particle_forces.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "sph/pair_kernel.hpp"

namespace sph {

using core::Mat3;
using core::Vec3;

/// A point's volume is never taken larger than this many times its volume at the reference density: expanded matter
/// keeps the weight that its spacing can carry.
constexpr double largest_expansion = 4.0;

void fill_actors(const Particles& p, const std::vector<double>& rho_0, Neighbourhood& hood) {
  core::for_each(p.size(), [&](std::size_t i) {
    Actor& a = hood.actors[i];
    a.x = p.x[i];
    a.v = p.v[i];
    a.m = p.pt.m[i];
    a.h = p.h[i];
    a.rho = p.pt.rho[i];
    a.volume = a.m / std::max(a.rho, rho_0[p.body[i]] / largest_expansion);
    a.c = p.pt.c[i];
    a.p_contact = std::max(p.pt.p[i], 0.0);
    a.spread = p.spread[i];
    a.body = p.body[i];
  });
}

static Mat3 stress_of(const core::Points& pt, std::size_t i) {
  Mat3 s;
  s << pt.s[0][i], pt.s[3][i], pt.s[5][i], pt.s[3][i], pt.s[1][i], pt.s[4][i], pt.s[5][i], pt.s[4][i], pt.s[2][i];
  s.diagonal().array() -= pt.p[i];
  return s;
}

/// -epsilon sigma for every tensile principal stress: pushes along it (Gray et al., eqs 3.12-3.14).
static void artificial_stress(const Mat3& sigma, double epsilon, Actor& a) {
  a.tension = 0;
  const double largest = sigma.diagonal().maxCoeff() + sigma.cwiseAbs().sum() - sigma.diagonal().cwiseAbs().sum();
  if (!(largest > 0) || epsilon == 0) return;  // a bound on the largest principal stress
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(sigma);
  const Vec3 pull = solver.eigenvalues().cwiseMax(0.0);
  if (pull.maxCoeff() <= 0) return;
  const Mat3 r = -epsilon * solver.eigenvectors() * pull.asDiagonal() * solver.eigenvectors().transpose();
  a.artificial = {r(0, 0), r(1, 1), r(2, 2), r(0, 1), r(1, 2), r(2, 0)};
  a.tension = 1;
}

/// B from the moment matrix M: its inverse where the neighbours span space, the identity where they do not.
static Mat3 correction_of(const Mat3& moment) {
  constexpr double poor = 0.004, enough = 0.016;  // det M on a lattice: 0.95 inside, 0.30 face, 0.093 edge, 0.028 corner
  const double det = moment.determinant();
  if (!(det > poor)) return Mat3::Identity();
  const double w = std::min(1.0, (det - poor) / (enough - poor));
  Mat3 b = moment.inverse();
  // a thin sheet can have a fair determinant and one weak direction
  const double size = b.cwiseAbs().maxCoeff();
  if (size > 8) return Mat3::Identity();
  return w * b + (1 - w) * Mat3::Identity();
}

/// Rows that one call of a kernel goes through: what it leaves for them fits the first cache.
constexpr std::size_t row_block = 64;

static PairView view(Neighbourhood& hood) {
  return {hood.actors.data(), hood.pairs.start.data(), hood.pairs.list.data(), hood.near.data(), hood.n_near.data()};
}

struct PairKernels {
  decltype(&baseline::find_near) find_near;
  decltype(&baseline::pair_forces) pair_forces;
  decltype(&baseline::pair_work) pair_work;
};

static PairKernels kernels() {
  switch (core::isa()) {
    case core::Isa::avx512: return {avx512::find_near, avx512::pair_forces, avx512::pair_work};
    case core::Isa::avx2: return {avx2::find_near, avx2::pair_forces, avx2::pair_work};
    default: return {baseline::find_near, baseline::pair_forces, baseline::pair_work};
  }
}

/// f(first, last) over blocks of rows, those of particles and those of foreigners apart.
template <class F>
static void for_each_row_block(const Neighbourhood& hood, F&& f) {
  core::for_each_block(hood.n_particles, row_block, f);
  core::for_each_block(hood.n_foreign, row_block,
                       [&](std::size_t first, std::size_t last) { f(hood.n_particles + first, hood.n_particles + last); });
}

void correct_gradients(const Particles& p, const ParticleSettings& settings, Neighbourhood& hood,
                       std::vector<Mat3>& correction) {
  correction.resize(p.size());
  const PairView pairs = view(hood);
  const auto find_near = kernels().find_near;
  for_each_row_block(hood, [&](std::size_t first, std::size_t last) {
    if (first >= hood.n_particles) return find_near(pairs, first, last, nullptr);
    std::array<Moment, row_block> moment;
    find_near(pairs, first, last, moment.data());
    for (std::size_t i = first; i < last; ++i) {
      const double* s = moment[i - first].sum;
      Mat3 m;
      m << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
      correction[i] = correction_of(m);
      const Mat3 sigma = stress_of(p.pt, i);
      hood.actors[i].stress = sigma * correction[i].transpose();
      artificial_stress(sigma, settings.artificial_stress, hood.actors[i]);
    }
  });
}

static Vec3 vec(const double* a) { return {a[0], a[1], a[2]}; }

void add_pair_forces(const ParticleSettings& settings, Neighbourhood& hood, Particles& p) {
  hood.foreign_force.resize(hood.n_foreign);
  const bool walls = std::any_of(hood.mirrors.begin(), hood.mirrors.end(), [](const Mirror& m) { return m.wall; });
  hood.wall_force.resize(walls ? hood.n_particles : 0);
  const PairView pairs = view(hood);
  const auto pair_forces = kernels().pair_forces;
  for_each_row_block(hood, [&](std::size_t first, std::size_t last) {
    std::array<RowForce, row_block> force;
    pair_forces(pairs, settings, first, last, force.data());
    for (std::size_t i = first; i < last; ++i) {
      const RowForce& f = force[i - first];
      (i < hood.n_particles ? p.f[i] : hood.foreign_force[i - hood.n_particles]) = vec(f.all);
      if (walls && i < hood.n_particles) hood.wall_force[i] = vec(f.wall);
    }
  });
}

/// dv/dx at mid-step from that of the end velocities at the step's start: L (1 + L dt/2)^-1.
static Mat3 at_mid_step(const Mat3& l, double dt) {
  const Mat3 f = Mat3::Identity() + 0.5 * dt * l;
  const double det = f.determinant();
  return det > 0.1 ? Mat3(l * f.inverse()) : l;
}

void pair_work(const ParticleSettings& settings, double dt_kick, double dt_drift, const std::vector<Mat3>& correction,
               Neighbourhood& hood, Particles& p, std::vector<Mat3>& velocity_gradient) {
  hood.foreign_heat.resize(hood.n_foreign);
  velocity_gradient.resize(p.size());
  const PairView pairs = view(hood);
  const auto row_work = kernels().pair_work;
  for_each_row_block(hood, [&](std::size_t first, std::size_t last) {
    std::array<RowWork, row_block> work;
    row_work(pairs, settings, first, last, work.data());
    for (std::size_t i = first; i < last; ++i) {
      const RowWork& w = work[i - first];
      if (i >= hood.n_particles) {
        hood.foreign_heat[i - hood.n_particles] = -w.power * dt_kick;
        continue;
      }
      const Actor& a = hood.actors[i];
      p.pt.e[i] -= w.power * dt_kick / a.m;
      const Mat3 rate = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(w.rate[0]);
      velocity_gradient[i] = at_mid_step(rate * correction[i], dt_drift);
      const double signal = settings.viscosity_quadratic * w.approach;
      p.dt[i] = 0.5 * a.h / (a.c + 0.6 * (settings.viscosity_linear * a.c + signal));
    }
  });
}

std::uint64_t n_pairs(const Neighbourhood& hood) {
  return hood.pairs.start.empty() ? 0 : hood.pairs.start[hood.n_particles];
}

}  // namespace sph
