// SPDX-License-Identifier: Apache-2.0
// The pair sums' inner loops, compiled once for each instruction set and chosen at run time. What they compute is written
// at the head of particle_forces.hpp. Who is in reach and with what weight is decided once a step, in find_near().
// What a pair is - weight, viscosity - is worked out in single precision, by operations that do not change when its two
// particles change places, from differences that are formed in double: both rows find the same bits. What pairs do is summed
// in double. Momentum, energy and the gradients of linear fields are thereby exact to double round-off, whatever single
// precision does to a weight. Neighbours go through in sixteens, in the order of the list and whatever the width of the
// machine's registers, and sums are joined in one order: the same bits on every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sph/neighbourhood.hpp"

namespace sph {

struct ParticleSettings;

constexpr std::size_t group = 16;  ///< neighbours that go through together

/// Plain arrays of a Neighbourhood.
struct PairView {
  const Place* place;
  const Flow* flow;
  const Strain* strain;
  const Stress* stress;
  const Stress* artificial;
  const Motion* motion;
  const Kind* kind;
  const float* p_contact;
  const std::uint64_t* start;  ///< rows of `list`
  const std::uint32_t* list;
  const std::uint64_t* near_start;
  Sixteen<std::uint32_t>* near;
  Sixteen<float>* weight;
  Sixteen<float>* push;
  const std::uint64_t* pull_start;
  Sixteen<float>* pull;
  std::uint32_t* n_near;  ///< [row]
  std::uint8_t* mixed;    ///< [row]
  std::uint8_t* anchored;  ///< [particle]
  double unit;
};

PairView view(Neighbourhood& hood);

/// Moment of the kernel gradient's error: sum of -V (dW/dr)/r d (x) d over what is near; xx yy zz xy yz zx.
struct Moment {
  double sum[6];
};

/// The anchors on which forces on foreigners act (Neighbourhood): rows for the foreigners, which are rows n_particles
/// and on of the pairs.
struct AnchorView {
  std::size_t n_particles;
  const std::uint32_t* start;
  const core::Vec3* xi;
  const Frame* frame;  ///< [row - n_particles]
  const core::Vec3* v_mean;
  core::Vec3* force;
  std::uint8_t* bears;  ///< [row - n_particles] does any of its pairs press or pull?
  core::Vec3* wall;  ///< [row - n_particles] part of images behind rigid walls; none if there are no walls [N]
  double* scratch;  ///< of forces: anchor_scratch doubles for each anchor of the longest row
};
constexpr std::size_t anchor_scratch = 32;

/// Force on a particle [N].
struct RowForce {
  double all[3];
  double wall[3];   ///< part of images behind rigid walls
  double approach;  ///< largest mu of the viscosity, 0 where all part [m/s]
};

/// What a particle's forces do at mid-step.
struct RowWork {
  double power;         ///< of the row's own stress and half the viscosity, at the neighbours' own velocities [W]
  double rate[3][3];    ///< sum of V (v_j - v_i) (x) grad W over kin and images behind walls, before correction [1/s]
  double pushed[3][3];  ///< the same over strangers, not to be corrected [1/s]
};

#define EJECTA_DECLARE(isa)                                                                                         \
  namespace isa {                                                                                                   \
  /** Counts who is near and, in rows that have room for them, keeps them and finds the moment. */                  \
  void find_near(const PairView&, std::size_t first, std::size_t last, Moment* moment);                             \
  /** Sum of weight times d over strangers that are near; zero where none is. */                                    \
  void find_strangers(const PairView&, std::size_t first, std::size_t last, core::Vec3* towards);                   \
  void pair_forces(const PairView&, const ParticleSettings&, std::size_t first, std::size_t last, RowForce* force); \
  void pair_work(const PairView&, std::size_t first, std::size_t last, RowWork* work);                              \
  void foreign_forces(const PairView&, const ParticleSettings&, const AnchorView&, std::size_t first, std::size_t last); \
  void foreign_work(const PairView&, const AnchorView&, std::size_t first, std::size_t last, double* power);        \
  }
EJECTA_DECLARE(baseline)
EJECTA_DECLARE(avx2)
EJECTA_DECLARE(avx512)
#undef EJECTA_DECLARE

}  // namespace sph
