// SPDX-License-Identifier: Apache-2.0
#include "sph/particle_forces.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "sph/stress_kernel.hpp"

namespace sph {

using core::Mat3;
using core::Vec3;

/// A point's volume is never taken larger than this many times its volume at the reference density: expanded matter
/// keeps the weight that its spacing can carry.
constexpr double largest_expansion = 4.0;

void fill_actors(const Particles& p, const std::vector<double>& rho_0, Neighbourhood& hood) {
  Actors& a = hood.actors;
  hood.unit = p.size() > 0 ? std::exp2(std::round(std::log2(p.h[0]))) : 1;
  const double per_unit = 1 / (hood.unit * hood.unit * hood.unit);
  core::for_each(p.size(), [&](std::size_t i) {
    const double density = std::max(p.pt.rho[i], rho_0[p.body[i]] / largest_expansion);
    a.place[i] = {p.x[i], single(p.h[i]), single(p.pt.m[i] / density * per_unit)};
    a.flow[i] = {p.v[i], single(p.pt.c[i]), single(p.pt.rho[i])};
    const auto &d = p.stretch[i], &s = p.shear[i];
    a.strain[i] = {{single(d[0]), single(d[1]), single(d[2]), single(s[0]), single(s[1]), single(s[2])}, single(density), single(p.spread[i])};
    a.kind[i] = kind_of_body(p.body[i]);
  });
}

/// Rows that one call of a kernel goes through: what it leaves for them fits the first cache.
constexpr std::size_t row_block = 64;

PairView view(Neighbourhood& hood) {
  Actors& a = hood.actors;
  return {a.place.data(),      a.flow.data(),          a.strain.data(),        a.stress.data(), a.artificial.data(),
          a.motion.data(),     a.kind.data(),          a.p_contact.data(),     hood.pairs.start.data(), hood.pairs.list.data(),
          hood.near_start.data(), hood.near.data(), hood.weight.data(), hood.push.data(), hood.pull_start.data(), hood.pull.data(), hood.n_near.data(),     hood.mixed.data(), hood.anchored.data(), hood.unit};
}

struct PairKernels {
  decltype(&baseline::find_near) find_near;
  decltype(&baseline::find_strangers) find_strangers;
  decltype(&baseline::correct_rows) correct_rows;
  decltype(&baseline::pair_forces) pair_forces;
  decltype(&baseline::pair_work) pair_work;
  decltype(&baseline::foreign_forces) foreign_forces;
  decltype(&baseline::foreign_work) foreign_work;
};

static PairKernels kernels() {
#define EJECTA_KERNELS(isa) \
  {isa::find_near, isa::find_strangers, isa::correct_rows, isa::pair_forces, isa::pair_work, isa::foreign_forces, isa::foreign_work}
  switch (core::isa()) {
    case core::Isa::avx512: return EJECTA_KERNELS(avx512);
    case core::Isa::avx2: return EJECTA_KERNELS(avx2);
    default: return EJECTA_KERNELS(baseline);
  }
#undef EJECTA_KERNELS
}

static AnchorView anchors_of(Neighbourhood& hood, double* scratch) {
  return {hood.n_particles, hood.anchor_start.data(), hood.anchor_xi.data(), hood.frame.data(), hood.anchor_v_mean.data(), hood.anchor_force.data(), hood.bears.data(),
          hood.wall_force.empty() ? nullptr : hood.wall_force.data() + hood.n_particles, scratch};
}

/// n . a n of a symmetric tensor, xx yy zz xy yz zx.
static double along(const std::array<double, 6>& a, const Vec3& n) {
  return (a[0] * n[0] * n[0] + a[1] * n[1] * n[1] + a[2] * n[2] * n[2]) + 2 * (a[3] * n[0] * n[1] + a[4] * n[1] * n[2] + a[5] * n[2] * n[0]);
}

static bool strangers_may_meet(const Neighbourhood& hood) {
  const auto& kind = hood.actors.kind;
  return hood.n_foreign > 0 || std::any_of(kind.begin(), kind.end(), [&](Kind k) { return (k & body_bits) != (kind[0] & body_bits); });
}

/// What particles say to strangers: their traction on a plane that faces those, and not their pressure alone, or an elastic bar would rebound
/// from another as if it bore no shear.
static void find_tractions(const Particles& p, Neighbourhood& hood) {
  Actors& a = hood.actors;
  const PairView pairs = view(hood);
  const auto kernel = kernels();
  core::for_each_block(hood.n_particles, row_block, [&](std::size_t first, std::size_t last) {
    std::array<Vec3, row_block> towards;
    kernel.find_strangers(pairs, first, last, towards.data());
    for (std::size_t i = first; i < last; ++i) {
      const Vec3& n = towards[i - first];
      const double n2 = n.squaredNorm();
      a.p_contact[i] = n2 > 0 ? single(std::max(-along(core::stress(p.pt, i), n) / n2, 0.0)) : 0;
    }
  });
}

void correct_gradients(const Particles& p, const ParticleSettings& settings, Neighbourhood& hood,
                       std::vector<Mat3>& correction) {
  correction.resize(p.size());
  hood.acoustic.resize(p.size());
  const auto kernel = kernels();
  for (;;) {
    const PairView pairs = view(hood);
    core::for_each_block(hood.n_foreign, row_block, [&](std::size_t first, std::size_t last) {
      kernel.find_near(pairs, hood.n_particles + first, hood.n_particles + last, nullptr);
    });
    core::for_each_block(hood.n_particles, row_block, [&](std::size_t first, std::size_t last) {
      std::array<Moment, row_block> moment;
      kernel.find_near(pairs, first, last, moment.data());
      kernel.correct_rows(p.pt, settings.artificial_stress, first, last, moment.data(), correction.data(), hood.acoustic.data(), hood.actors);
    });
    if (has_room(hood)) break;
    make_room(hood);
  }
  if (strangers_may_meet(hood)) find_tractions(p, hood);
}

static Vec3 vec(const double* a) { return {a[0], a[1], a[2]}; }

void add_pair_forces(const ParticleSettings& settings, Neighbourhood& hood, Particles& p) {
  const bool walls = std::any_of(hood.mirrors.begin(), hood.mirrors.end(), [](const Mirror& m) { return m.wall; });
  hood.wall_force.resize(walls ? hood.n_particles + hood.n_foreign : 0);
  hood.approach.resize(hood.n_particles);
  hood.anchored.resize(hood.n_particles);
  hood.anchor_force.resize(hood.anchor_xi.size());
  hood.bears.resize(hood.n_foreign);
  make_room_for_pull(hood);
  const PairView pairs = view(hood);
  const auto kernel = kernels();
  core::for_each_block(hood.n_particles, row_block, [&](std::size_t first, std::size_t last) {
    std::array<RowForce, row_block> force;
    kernel.pair_forces(pairs, settings, first, last, force.data());
    for (std::size_t i = first; i < last; ++i) {
      p.f[i] = vec(force[i - first].all);
      hood.approach[i] = force[i - first].approach;
      if (walls) hood.wall_force[i] = vec(force[i - first].wall);
    }
  });
  std::uint32_t longest = 0;
  for (std::size_t k = 0; k < hood.n_foreign; ++k) longest = std::max(longest, hood.anchor_start[k + 1] - hood.anchor_start[k]);
  core::for_each_block(hood.n_foreign, row_block, [&](std::size_t first, std::size_t last) {
    std::vector<double> scratch(anchor_scratch * longest);
    kernel.foreign_forces(pairs, settings, anchors_of(hood, scratch.data()), hood.n_particles + first, hood.n_particles + last);
  });
}

/// dv/dx at mid-step from that of the end velocities at the step's start: L (1 + L dt/2)^-1.
static Mat3 at_mid_step(const Mat3& l, double dt) {
  const Mat3 f = Mat3::Identity() + 0.5 * dt * l;
  const double det = f.determinant();
  return det > 0.1 ? Mat3(l * f.inverse()) : l;
}

constexpr double unlimited = 1e300;  ///< step of a particle in free flight: nothing acts on it

/// Stable step [s]: h / (c + 0.6 (alpha c + beta mu)) as Monaghan (1992, section 10) has it, a third of it, c times
/// the row's acoustic share.
static double stable_step(double h, double c, const ParticleSettings& s, double approach) {
  return h / 3 / ((1 + 0.6 * s.viscosity_linear) * c + 0.6 * s.viscosity_quadratic * approach);
}

/// dv/dx of a particle that nothing holds: its surface moves at p / (rho c) until it bears no pressure or weighs in the sums as what has
/// expanded most. What it would gain in motion outwards stays with its heat. It goes half of the way in a step at most.
static Mat3 free_expansion(const core::Points& pt, std::size_t i, double rho_0, double dt) {
  if (!(pt.p[i] > 0) || pt.rho[i] * largest_expansion <= rho_0) return Mat3::Zero();
  const double c = pt.c[i], edge = std::cbrt(pt.m[i] / pt.rho[i]);
  return Mat3::Identity() * (pt.p[i] / (pt.rho[i] * c * c) * std::min(c / edge, 0.5 / dt) / 3);
}

/// f(j, weight, push) for every pair of a particle whose force acts on j's anchors.
template <class F>
static void for_each_anchored_pair(const Neighbourhood& hood, std::size_t i, F&& f) {
  for (std::size_t n = 0; n < hood.n_near[i]; ++n) {
    const std::size_t slot = hood.near_start[i] + n / group, l = n % group, j = hood.near[slot].at[l];
    if (acts_on_anchors(hood.actors.kind[i], hood.actors.kind[j]))
      f(j, hood.weight[slot].at[l], hood.push[slot].at[l]);
  }
}

/// Where the anchors of a pair of a particle at x_i and foreigner j are, in the mean by their weights, and how fast: now, and in the mean of the kick;
/// and the velocity gradient of the elements round them.
struct Foot {
  Vec3 x, v, v_mean;
  Mat3 gradient;
};

static Foot foot(const Neighbourhood& hood, const Vec3& x_i, std::size_t j) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  if (j >= n_real) {  // an image's anchors are images
    const Image& image = hood.images[j - n_real];
    const Mirror& m = hood.mirrors[image.mirror];
    const Foot source = foot(hood, mirrored(m, x_i), image.source);
    const Mat3 mirror = Mat3::Identity() - 2 * m.normal * m.normal.transpose();
    return {mirrored(m, source.x), reflect(m, source.v), reflect(m, source.v_mean), mirror * source.gradient * mirror};
  }
  const std::size_t k = j - hood.n_particles, begin = hood.anchor_start[k], centre = hood.anchor_start[k + 1] - 1;
  if (begin == centre) return {hood.anchor_x[centre], hood.anchor_v[centre], hood.anchor_v_mean[centre], hood.foreign_gradient[k]};
  const Frame& frame = hood.frame[k];
  const Vec3 middle = frame.xi + 0.5 * frame.per_x * (x_i - hood.anchor_x[centre]);
  double sum = 0;
  Foot f{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), hood.foreign_gradient[k]};
  for (std::size_t n = begin; n < centre; ++n) {
    const double w = anchor_weight((hood.anchor_xi[n] - middle).squaredNorm());
    sum += w, f.x += w * hood.anchor_x[n], f.v += w * hood.anchor_v[n], f.v_mean += w * hood.anchor_v_mean[n];
  }
  return {f.x / sum, f.v / sum, f.v_mean / sum, f.gradient};
}

static Vec3 times(const Stress& s, const Vec3& g) {
  Vec3 f;
  for (int e = 0; e < 3; ++e) f[e] = double(s.column[0][e]) * g[0] + double(s.column[1][e]) * g[1] + double(s.column[2][e]) * g[2];
  return f;
}

/// What a particle's pairs with anchored foreigners add to what it takes from them as if its forces acted at their centres.
struct AtAnchors {
  Mat3 gradient;  ///< to its velocity gradient [1/s]
  double power;   ///< to the power of its forces [W]
};

/// Power of a force on the deformation of a foreigner's owner [W].
struct OwnersPower {
  std::size_t foreigner;
  double power;
};

/// The gradient: of the anchors' motion, carried on to the middles of the pairs as the elements round them deform, beyond what the centres' motion says. The
/// power: of each pair's force at its anchors, less what pair_work() booked. What the force does on the elements' deformation between anchors and middle
/// strains the particle no more than the foreigner's owner; it goes to both, by mass.
static AtAnchors at_anchors(const Neighbourhood& hood, std::size_t i, double mass, const Mat3& correction, std::vector<OwnersPower>& owners) {
  const Actors& a = hood.actors;
  const auto velocity = [&](std::size_t k) { return Vec3(a.motion[k].end[0], a.motion[k].end[1], a.motion[k].end[2]); };
  const auto mean = [&](std::size_t k) { return Vec3(0.5 * a.motion[k].sum[0], 0.5 * a.motion[k].sum[1], 0.5 * a.motion[k].sum[2]); };
  const double per_unit = hood.unit * hood.unit * hood.unit;
  AtAnchors r{Mat3::Zero(), 0};
  for_each_anchored_pair(hood, i, [&](std::size_t j, float weight, float push) {
    const Vec3 &x_i = a.place[i].x, &x_j = a.place[j].x;
    const Foot at = foot(hood, x_i, j);
    const Vec3 d = x_i - x_j, carried = at.gradient * (2 * at.x - x_i - x_j);
    r.gradient += double(weight) * (2 * at.v - velocity(i) - velocity(j) - carried) * d.transpose();
    // the force on the particle: its stress twice and viscosity, of which it books half where its kin would book the other
    const Vec3 plain = times(a.stress[i], double(weight) * d), viscous = -double(push) * d;
    const std::size_t foreigner = owner(hood, j) - hood.n_particles;
    const double others = hood.foreign_mass[foreigner] / (mass + hood.foreign_mass[foreigner]) * plain.dot(carried);
    r.power += (plain + 0.5 * viscous).dot(mean(j) - mean(i)) - (2 * plain + viscous).dot(at.v_mean - mean(i)) + others;
    owners.push_back({foreigner, -per_unit * others});
  });
  r.gradient = r.gradient * correction / double(a.place[i].volume);
  r.power *= per_unit;
  return r;
}

void pair_work(const ParticleSettings& settings, const std::vector<double>& rho_0, double dt_kick, double dt_drift, const std::vector<Mat3>& correction,
               Neighbourhood& hood, Particles& p, std::vector<Mat3>& velocity_gradient) {
  hood.foreign_power.resize(hood.n_foreign);
  velocity_gradient.resize(p.size());
  const PairView pairs = view(hood);
  const auto kernel = kernels();
  std::vector<std::vector<OwnersPower>> owners((hood.n_particles + row_block - 1) / row_block);
  core::for_each_block(hood.n_particles, row_block, [&](std::size_t first, std::size_t last) {
    std::array<RowWork, row_block> work;
    kernel.pair_work(pairs, first, last, work.data());
    for (std::size_t i = first; i < last; ++i) {
      const RowWork& w = work[i - first];
      p.pt.e[i] -= w.power * dt_kick / p.pt.m[i];
      using Rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
      Mat3 l = Rows(w.rate[0]) * correction[i] + Rows(w.pushed[0]);
      if (hood.anchored[i]) {
        const AtAnchors seam = at_anchors(hood, i, p.pt.m[i], correction[i], owners[first / row_block]);
        l += seam.gradient;
        p.pt.e[i] -= seam.power * dt_kick / p.pt.m[i];
      }
      l = velocity_gradient[i] = hood.n_near[i] > 0 ? at_mid_step(l, dt_drift) : free_expansion(p.pt, i, rho_0[p.body[i]], dt_drift);
      p.stretch[i] = l.diagonal();
      p.shear[i] = 0.5 * Vec3(l(0, 1) + l(1, 0), l(1, 2) + l(2, 1), l(2, 0) + l(0, 2));
      p.dt[i] = hood.n_near[i] > 0 ? stable_step(p.h[i], double(hood.acoustic[i]) * p.pt.c[i], settings, hood.approach[i]) : unlimited;
    }
  });
  core::for_each_block(hood.n_foreign, row_block, [&](std::size_t first, std::size_t last) {
    kernel.foreign_work(pairs, anchors_of(hood, nullptr), hood.n_particles + first, hood.n_particles + last, hood.foreign_power.data() + first);
  });
  for (const auto& block : owners)
    for (const auto& o : block) hood.foreign_power[o.foreigner] += o.power;
}

std::uint64_t n_pairs(const Neighbourhood& hood) {
  return hood.pairs.start.empty() ? 0 : hood.pairs.start[hood.n_particles];
}

}  // namespace sph
