// SPDX-License-Identifier: Apache-2.0
// The pair sums' inner loops, compiled once for each instruction set and chosen at run time. What they compute is written
// at the head of particle_forces.hpp; who is in reach is decided once a step, in find_near(), and kept as one bit a pair.
// Neighbours go through in fours, in the order of the list, whatever the width of the machine's registers, and the four
// partial sums are joined in one order: the same bits on every instruction set. A row's loops are short ones, one after the
// other: a processor has registers for several fours at a time in those.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sph/neighbourhood.hpp"

namespace sph {

struct ParticleSettings;

/// Candidates a word of Neighbourhood::near speaks of.
constexpr std::size_t near_word = 16;

/// Where the words of row i begin, if its candidates begin at `start`: rows share no word.
constexpr std::size_t first_near_word(std::uint64_t start, std::size_t i) { return start / near_word + i; }

/// Plain arrays of a Neighbourhood.
struct PairView {
  const Actor* actor;
  const std::uint64_t* start;  ///< rows of `list`
  const std::uint32_t* list;
  std::uint16_t* near;         ///< one bit a candidate: is it in reach now?
  std::uint32_t* n_near;       ///< [row] how many are
};

/// Moment of the kernel gradient's error: sum of -V (dW/dr)/r d (x) d over what is near; xx yy zz xy yz zx.
struct Moment {
  double sum[6];
};

/// The anchors on which forces on foreigners act (Neighbourhood): rows for the foreigners, which are rows n_particles
/// and on of the pairs.
struct AnchorView {
  std::size_t n_particles;
  double spacing;  ///< of neighbouring anchors, in spacings of particles
  const std::uint32_t* start;
  const core::Vec3* x;
  const core::Vec3* v_mean;
  core::Vec3* force;
  double* scratch;  ///< 16 doubles for each anchor of the longest row
};

/// Force on a particle [N].
struct RowForce {
  double all[3];
  double wall[3];  ///< part of images behind rigid walls
};

/// What a particle's forces do at mid-step.
struct RowWork {
  double power;        ///< of the row's own stress and half the viscosity [W]
  double rate[3][3];   ///< sum of V (v_j - v_i) (x) grad W, before correction [1/s]
  double approach;     ///< largest mu of the viscosity, 0 where all part [m/s]
};

#define EJECTA_DECLARE(isa)                                                                                         \
  namespace isa {                                                                                                   \
  void find_near(const PairView&, std::size_t first, std::size_t last, Moment* moment);                             \
  void pair_forces(const PairView&, const ParticleSettings&, std::size_t first, std::size_t last, RowForce* force); \
  void pair_work(const PairView&, const ParticleSettings&, std::size_t first, std::size_t last, RowWork* work);     \
  void foreign_forces(const PairView&, const ParticleSettings&, const AnchorView&, std::size_t first, std::size_t last); \
  void foreign_work(const PairView&, const ParticleSettings&, const AnchorView&, std::size_t first, std::size_t last,    \
                    double* power);                                                                                      \
  }
EJECTA_DECLARE(baseline)
EJECTA_DECLARE(avx2)
EJECTA_DECLARE(avx512)
#undef EJECTA_DECLARE

}  // namespace sph
