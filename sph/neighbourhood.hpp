// SPDX-License-Identifier: Apache-2.0
// Who feels whom. Actors are the rows of the pair sums: first the particles, then foreigners (points that others own:
// elements of the bond), then images of both behind mirrors (symmetry planes, rigid walls). Particles and foreigners
// have neighbour rows; images only stand in them. Lists hold everything within reach plus a skin. They are made anew when two
// actors that may be neighbours have moved by more than the skin against each other: actors are binned when the lists are
// made, and displacements are compared between touching bins only, so a cloud that flies as a whole keeps its lists.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/octree.hpp"
#include "core/types.hpp"
#include "sph/particles.hpp"

namespace sph {

/// Laid out for the pair sums (pair_kernel.cpp): what distances and viscosity need fills the first two lines of eight
/// doubles, in fours; of the next two each column of a tensor lies within one line; the last is for hourglass control.
struct alignas(64) Actor {
  core::Vec3 x{0, 0, 0};
  double h = 0;
  double volume = 0;
  std::int32_t body = 0;
  std::int32_t tension = 0;    ///< 1 where artificial stress acts
  double m = 0, c = 0;

  core::Vec3 v{0, 0, 0};       ///< before the kick, n - 1/2: what viscosity sees
  double rho = 0;
  core::Vec3 v_new{0, 0, 0};   ///< after the kick and contact, n + 1/2: what strains; the forces work on the mean of both
  double spread = 0;           ///< shear switch of the viscosity [-]

  std::array<double, 5> artificial{};       ///< artificial stress of Gray et al., xx xy zx yz zz [Pa]
  core::Mat3 stress = core::Mat3::Zero();   ///< sigma B^T, see particle_forces.hpp [Pa]
  double artificial_yy = 0;
  double p_contact = 0;        ///< max(p, 0): all that bodies say to each other [Pa]

  std::array<double, 6> rate{};  ///< strain rate of the last step, xx yy zz xy yz zx [1/s]
  double firm = 0;               ///< 1 where it bears shear and its gradients are exact: motion beside `rate` is damped
  double unused = 0;
};
static_assert(sizeof(Actor) == 320);

/// What images behind a rigid wall say they belong to: they push whatever comes and hold nothing.
constexpr std::int32_t wall_body = -1;

/// A plane that mirrors: symmetry plane (particles and their images are one body) or rigid wall (they only push).
struct Mirror {
  core::Vec3 point{0, 0, 0}, normal{0, 0, 1};  ///< matter on the normal's side
  bool wall = false;
};

struct Image {
  std::uint32_t source;   ///< actor
  std::uint32_t mirror;
};

struct Neighbourhood {
  std::vector<Mirror> mirrors;
  std::size_t n_particles = 0, n_foreign = 0;
  std::vector<Actor> actors;
  std::vector<Image> images;
  core::Neighbours pairs;            ///< rows of particles and foreigners
  std::vector<std::uint16_t> near;   ///< one bit a candidate of `pairs`: in reach at this step? (pair_kernel.hpp)
  std::vector<std::uint32_t> n_near; ///< [row] how many are
  std::vector<core::Vec3> x_built;   ///< positions of all actors when the lists were made
  std::vector<double> h_built;       ///< and their smoothing lengths [m]
  std::vector<core::Vec3> watched_built;  ///< of what is no actor but near enough to become one
  std::vector<std::uint32_t> bin;    ///< [actors, then watched]
  std::vector<std::uint32_t> bin_start, bin_touching;  ///< rows of bins that touch, each bin its own first
  double slack = 0;                  ///< how far two actors of touching bins may move against each other [m]
  double far_path = 0;               ///< how far anything may move against what lies beyond touching bins [m]
  double far_speed = 0;              ///< bound on the speed at which it does [m/s]
  double age = 0;                    ///< time since the lists were made [s]
  bool valid = false;
  std::uint64_t builds = 0;

  std::vector<core::Vec3> wall_force;     ///< [n_particles] part of each particle's force that rigid walls give; empty without [N]
  // Force of its own kind on a foreigner acts on its anchors, the nearer to the middle of the pair the more: rows of points
  // per foreigner. The last of each row is its own place: that takes what strangers push, and all where it is the only one.
  double anchor_spacing = 1;                 ///< of neighbouring anchors, in spacings of particles
  std::vector<std::uint32_t> anchor_start;   ///< [n_foreign + 1]
  std::vector<core::Vec3> anchor_x;          ///< at n [m]
  std::vector<core::Vec3> anchor_v_mean;     ///< velocity at which the force does its work [m/s]
  std::vector<core::Vec3> anchor_force;      ///< of the particles [N]
  std::vector<double> foreign_heat;       ///< [n_foreign] energy it gains in the pairs [J]
};

/// True when the lists, made for the same actors, still hold every pair in reach of where particles and foreigners
/// (hood.actors) and what is watched are now.
bool still_valid(const Neighbourhood& hood, const std::vector<core::Vec3>& watched_x);

/// What lies within foreign_reaches of a particle must be an actor when the lists are made, what lies within
/// watched_reaches must be watched.
constexpr double foreign_reaches = 1.25, watched_reaches = 3.0;

/// Makes images and lists. actors[0 .. n_particles + n_foreign) hold current x, h and v. outside_speed: of the fastest
/// thing that is no actor yet but could become a neighbour [m/s].
void build(Neighbourhood& hood, const std::vector<core::Vec3>& watched_x, double outside_speed);

/// Images follow their sources: everything an Actor holds, reflected.
void reflect_images(Neighbourhood& hood);

/// Velocities after the kick to the images alone.
void reflect_velocities(Neighbourhood& hood);

}  // namespace sph
