// SPDX-License-Identifier: Apache-2.0
#include "sph/particle_forces.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "sph/kernel.hpp"

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
  a.in_tension = false;
  const double largest = sigma.diagonal().maxCoeff() + sigma.cwiseAbs().sum() - sigma.diagonal().cwiseAbs().sum();
  if (!(largest > 0) || epsilon == 0) return;  // a bound on the largest principal stress
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(sigma);
  const Vec3 pull = solver.eigenvalues().cwiseMax(0.0);
  if (pull.maxCoeff() <= 0) return;
  a.artificial = -epsilon * solver.eigenvectors() * pull.asDiagonal() * solver.eigenvectors().transpose();
  a.in_tension = true;
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

void correct_gradients(const Particles& p, const ParticleSettings& settings, Neighbourhood& hood,
                       std::vector<Mat3>& correction) {
  correction.resize(p.size());
  const auto& pairs = hood.pairs;
  core::for_each_block(p.size(), 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      Actor& a = hood.actors[i];
      Mat3 moment = Mat3::Zero();
      for (auto k = pairs.start[i]; k < pairs.start[i + 1]; ++k) {
        const Actor& b = hood.actors[pairs.list[k]];
        const Vec3 d = a.x - b.x;
        const double h = 0.5 * (a.h + b.h), r2 = d.squaredNorm();
        if (r2 >= kernel_reach * kernel_reach * h * h) continue;
        moment.noalias() -= (b.volume * kernel_slope(std::sqrt(r2), h)) * d * d.transpose();
      }
      correction[i] = correction_of(moment);
      const Mat3 sigma = stress_of(p.pt, i);
      a.stress = sigma * correction[i].transpose();
      artificial_stress(sigma, settings.artificial_stress, a);
    }
  });
}

struct PairForce {
  Vec3 own{0, 0, 0};      ///< part of the force on i that i's own stress makes: its work is i's
  Vec3 other{0, 0, 0};    ///< part that j's stress makes
  Vec3 viscous{0, 0, 0};  ///< shared half and half
  Vec3 gradient{0, 0, 0}; ///< grad_i W
  bool in_reach = false;
};

/// Monaghan's viscosity; zero for pairs that part. Leaves mu for the time step.
static double viscosity(const ParticleSettings& s, const Actor& a, const Actor& b, const Vec3& d, double r2, double h) {
  const double approach = (a.v - b.v).dot(d);
  if (approach >= 0) return 0;
  const double mu = h * approach / (r2 + 0.01 * h * h);
  const double spread = 0.5 * (a.spread + b.spread);
  return (-s.viscosity_linear * 0.5 * (a.c + b.c) * mu * spread + s.viscosity_quadratic * mu * mu) /
         (0.5 * (a.rho + b.rho));
}

/// Everything between actors i and j at time n; the mirror image of f(j, i) to the last bit.
static PairForce pair_force(const ParticleSettings& s, const Actor& a, const Actor& b) {
  PairForce f;
  const Vec3 d = a.x - b.x;
  const double h = 0.5 * (a.h + b.h), r2 = d.squaredNorm();
  if (r2 >= kernel_reach * kernel_reach * h * h) return f;
  f.in_reach = true;
  const double r = std::sqrt(r2);
  f.gradient = kernel_slope(r, h) * d;
  const double vv = a.volume * b.volume;
  if (a.body == b.body) {
    f.own = vv * (a.stress * f.gradient);
    f.other = vv * (b.stress * f.gradient);
    if (a.in_tension || b.in_tension) {
      // nothing at the regular spacing, where it would only weaken the matter; held below where pairs nearly meet
      const double w = kernel(r, h) / kernel(h / h_over_spacing, h), w2 = w * w, close = std::clamp(w2 * w2 - 1, 0.0, 1.0);
      if (a.in_tension) f.own += (vv * close) * (a.artificial * f.gradient);
      if (b.in_tension) f.other += (vv * close) * (b.artificial * f.gradient);
    }
  } else {
    f.own = (-vv * a.p_contact) * f.gradient;
    f.other = (-vv * b.p_contact) * f.gradient;
  }
  f.viscous = (-a.m * b.m * viscosity(s, a, b, d, r2, h)) * f.gradient;
  return f;
}

/// Calls share(anchor, weight) for the anchors of foreigner k; weights add up to one and fall to nothing within one spacing
/// of anchors from the middle of the pair. A lattice under uniform stress is then held still within 2e-3 of the stress at any seam.
template <class Share>
static void share_among_anchors(const Neighbourhood& hood, std::size_t k, const Actor& a, const Actor& b, Share&& share) {
  constexpr double spread = 0.9 / h_over_spacing, floor = 1e-9;
  const Vec3 middle = 0.5 * (a.x + b.x);
  const double radius = hood.anchor_spacing * spread * 0.5 * (a.h + b.h), scale = 1 / (radius * radius);
  const auto weight = [&](std::uint32_t n) {
    const double u = std::max(1 - (hood.anchor_x[n] - middle).squaredNorm() * scale, 0.0);
    return u * u + floor;
  };
  double sum = 0;
  for (auto n = hood.anchor_start[k]; n < hood.anchor_start[k + 1]; ++n) sum += weight(n);
  for (auto n = hood.anchor_start[k]; n < hood.anchor_start[k + 1]; ++n) share(n, weight(n) / sum);
}

void add_pair_forces(const ParticleSettings& settings, Neighbourhood& hood, Particles& p) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  hood.anchor_force.assign(hood.anchor_x.size(), Vec3::Zero());
  const bool walls = std::any_of(hood.mirrors.begin(), hood.mirrors.end(), [](const Mirror& m) { return m.wall; });
  hood.wall_force.assign(walls ? hood.n_particles : 0, Vec3::Zero());
  const auto& pairs = hood.pairs;
  core::for_each_block(n_real, 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const bool foreign = i >= hood.n_particles;
      Vec3 sum = Vec3::Zero();
      for (auto k = pairs.start[i]; k < pairs.start[i + 1]; ++k) {
        const std::uint32_t j = pairs.list[k];
        if (foreign && !hood.is_particle(j)) continue;
        const PairForce f = pair_force(settings, hood.actors[i], hood.actors[j]);
        if (!f.in_reach) continue;
        const Vec3 force = (f.own + f.other) + f.viscous;
        if (foreign)
          share_among_anchors(hood, i - hood.n_particles, hood.actors[i], hood.actors[j],
                              [&](std::uint32_t n, double weight) { hood.anchor_force[n] += weight * force; });
        else
          sum += force;
        if (walls && !foreign && hood.actors[j].body == wall_body) hood.wall_force[i] += force;
      }
      if (!foreign) p.f[i] = sum;
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
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  hood.foreign_heat.assign(hood.n_foreign, 0.0);
  velocity_gradient.resize(p.size());
  const auto& pairs = hood.pairs;
  core::for_each_block(n_real, 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const bool foreign = i >= hood.n_particles;
      const Actor& a = hood.actors[i];
      Mat3 l = Mat3::Zero();
      double work = 0, signal = 0;
      for (auto k = pairs.start[i]; k < pairs.start[i + 1]; ++k) {
        const std::uint32_t j = pairs.list[k];
        if (foreign && !hood.is_particle(j)) continue;
        const Actor& b = hood.actors[j];
        const PairForce f = pair_force(settings, a, b);
        if (!f.in_reach) continue;
        if (foreign) {
          // what the particle does not book of the pair's work: its force acts on the anchors, not at the centre
          Vec3 v = Vec3::Zero();
          share_among_anchors(hood, i - hood.n_particles, a, b,
                              [&](std::uint32_t n, double weight) { v += weight * hood.anchor_v_mean[n]; });
          work += ((f.own + f.other) + f.viscous).dot(v - b.v_mean) -
                  (f.other + 0.5 * f.viscous).dot(a.v_mean - b.v_mean);
          continue;
        }
        work += (f.own + 0.5 * f.viscous).dot(a.v_mean - b.v_mean);
        const Vec3 d = a.x - b.x;
        // a stranger that recedes leaves no tension behind: nothing would have paid for it
        if (a.body == b.body || a.p_contact > 0 || (a.v_new - b.v_new).dot(d) < 0)
          l.noalias() += (b.volume * (b.v_new - a.v_new)) * f.gradient.transpose();
        const double h = 0.5 * (a.h + b.h), mu = -h * (a.v_new - b.v_new).dot(d) / (d.squaredNorm() + 0.01 * h * h);
        signal = std::max(signal, settings.viscosity_quadratic * mu);
      }
      if (foreign) {
        hood.foreign_heat[i - hood.n_particles] = -work * dt_kick;
        continue;
      }
      p.pt.e[i] -= work * dt_kick / a.m;
      velocity_gradient[i] = at_mid_step(l * correction[i], dt_drift);
      p.dt[i] = 0.5 * a.h / (a.c + 0.6 * (settings.viscosity_linear * a.c + signal));
    }
  });
}

std::uint64_t n_pairs(const Neighbourhood& hood) {
  return hood.pairs.start.empty() ? 0 : hood.pairs.start[hood.n_particles];
}

}  // namespace sph
