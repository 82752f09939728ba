// SPDX-License-Identifier: Apache-2.0
// Which points may strike which faces soon. Points and faces are binned where they are when the lists are made; a pair is
// a candidate when the point lies in the face's box widened by `reach`. The lists hold as long as displacements since then
// differ by less than that between a bin's points and the corners of the faces known to it (those within `far`), by less
// than `far` within touching districts, and by less than `apart` between any two: what flies as a whole keeps its lists. Nodes and
// faces of one body that have nothing but that body in their own and touching districts are quiet: nothing can strike or be struck there
// before `apart` is used up, and they are not binned.
// As elements go, the faces, nodes and particles that appear are put into the same lists as if they had been there, moved
// with their surroundings.
// Lists are a superset and nothing else: results depend neither on when they were made nor on their order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/box.hpp"
#include "core/cells.hpp"
#include "core/types.hpp"
#include "coupling/meeting.hpp"
#include "fem/mesh.hpp"
#include "fem/surface.hpp"
#include "sph/particles.hpp"

namespace coupling {

struct ContactPoint {
  std::uint32_t index;     ///< node or particle
  bool particle;
  std::int32_t body = -1;  ///< of a node that belongs to elements: it does not strike that body; -1: strikes all
  std::uint32_t bin = core::Cells::none;
};

struct ContactFace {
  fem::Face face;
  FaceNodes node;
  std::int32_t body;
  core::Box box;         ///< when the lists were made, widened by reach
  static constexpr std::uint32_t unpaired = 0xffffffff;
  std::uint32_t paired = unpaired;  ///< its place in ContactLists::paired
};

/// One point that may strike one face.
struct Candidate {
  std::uint32_t point, face;  ///< rows of ContactLists::points and faces
};

struct ContactBin {
  std::vector<std::uint32_t> points;     ///< that were in it when the lists were made
  std::vector<std::uint32_t> faces;      ///< within `far` of it
  std::vector<std::uint32_t> face_bins;  ///< bins of those faces' corners; kept where something may strike
  bool contested = false;                ///< a point may strike a face here
};

/// Candidates by the points that strike and by the corners of the faces that are struck.
struct CandidateRows {
  std::size_t n = 0;                       ///< candidates that stand in them; others came later
  std::vector<std::uint32_t> start, list;  ///< [point + 1]
};

struct ContactLists {
  fem::Surface surface;
  std::vector<ContactPoint> points;
  std::vector<ContactFace> faces;         ///< dead ones stay until the next search
  std::vector<Candidate> candidates;
  std::vector<std::uint32_t> paired;      ///< faces that stand in candidates
  CandidateRows rows;                     ///< see candidates_of
  core::Cells cells;
  std::vector<ContactBin> bins;           ///< [cell]
  std::vector<std::uint32_t> district;    ///< [bin] where it belongs to: cubes larger than any face is wide and `apart`
  std::vector<std::uint8_t> beside_quiet; ///< [district] it touches one whose nodes are quiet
  std::vector<std::uint32_t> quiet;       ///< nodes that are
  std::vector<std::vector<std::uint32_t>> touching;  ///< [district] districts that touch it, itself included
  static constexpr std::uint32_t no_point = 0xffffffff;
  std::vector<std::uint32_t> node_point, particle_point;  ///< [node], [particle] its row of points; corners of faces have one
  core::Vec3 origin{0, 0, 0};             ///< of the following [m]
  std::vector<core::Vec3f> node_built;    ///< positions when the lists were made, rounded: lists have far more slack [m]
  std::vector<core::Vec3f> particle_built;
  double reach = 0, far = 0, apart = 0;   ///< [m]
  std::vector<std::uint8_t> left_out;     ///< [body] nothing can reach it, nor it anything, before `until`
  double until = 0;                       ///< [s]
  bool valid = false;
};

/// How many steps ahead, at the velocities now, pairs are in the lists.
constexpr double steps_covered = 2.1;

/// Puts what has appeared since into the lists. False when that cannot be done, or when they no longer hold every pair
/// that may meet within the next steps_covered steps at the velocities now. time: of the step's start [s].
bool keep_lists(const fem::Mesh& mesh, const sph::Particles& particles, double time, double dt, ContactLists& lists);

/// New lists, without the bodies whose time to meet anything is far off.
void make_lists(const fem::Mesh& mesh, const sph::Particles& particles, std::span<const double> times_to_meet, double time,
                double dt, ContactLists& lists);

/// Candidates in which any of these nodes and particles, alone or as a corner, may have a part; each of them once.
std::vector<Candidate> candidates_of(std::span<const ContactPoint> matter, ContactLists& lists);

/// For each body, how long its elements cannot touch those of another body nor any particle [s].
std::vector<double> times_to_meet(const fem::Mesh& mesh, const sph::Particles& particles);

}  // namespace coupling
