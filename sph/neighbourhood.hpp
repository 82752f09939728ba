// SPDX-License-Identifier: Apache-2.0
// Who feels whom. Actors are the rows of the pair sums: first the particles, then foreigners (points that others own:
// elements of the bond), then images of both behind mirrors (symmetry planes, rigid walls). Particles and foreigners
// have neighbour rows; images only stand in them. Lists hold everything within reach plus a skin. They are made anew when two
// actors that may be neighbours have moved by more than the skin against each other: actors are binned when the lists are
// made, and displacements are compared between touching bins only, so a cloud that flies as a whole keeps its lists.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/octree.hpp"
#include "core/types.hpp"
#include "sph/particles.hpp"

namespace sph {

// Actors are laid out for the pair sums (pair_kernel.cpp), one array for each of their loops, in rows of 32 bytes or so.
// Differences of positions and of velocities are formed in double, so those are kept in double; all else is single.
// Volumes are in units of unit^3, which keeps products of theirs within the range of single numbers at any scale.

inline float single(double a) { return static_cast<float>(a); }

struct alignas(32) Place {
  core::Vec3 x{0, 0, 0};
  float h = 0;
  float volume = 0;            ///< [unit^3]
};

struct alignas(32) Flow {
  core::Vec3 v{0, 0, 0};       ///< before the kick, n - 1/2: what viscosity sees
  float c = 0, rho = 0;
};

struct alignas(32) Strain {
  std::array<float, 6> rate{};  ///< of the last step, xx yy zz xy yz zx [1/s]
  float density = 0;            ///< mass over volume [kg/m3]
  float spread = 0;             ///< shear switch of the viscosity [-]
};

/// Columns of a stress, three of each four numbers [Pa].
struct alignas(16) Stress {
  float column[3][4] = {};
  /// Size of its greatest component, kept where the first column has room [Pa].
  float& most() { return column[0][3]; }
  float most() const { return column[0][3]; }
};

/// The matrix, rounded.
inline Stress stress_of(const core::Mat3& a) {
  Stress s;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) s.column[c][r] = single(a(r, c));
  s.most() = single(a.cwiseAbs().maxCoeff());
  return s;
}

/// Velocities once the kick and contact are done.
struct alignas(64) Motion {
  double sum[4] = {};  ///< of those before and after: the forces work on half of it [m/s]
  double end[4] = {};  ///< after, n + 1/2: what strains [m/s]
};

/// What kind of neighbour an actor is, in one number: its body, and three bits.
using Kind = std::int32_t;
constexpr Kind firm_bit = 1;     ///< bears shear and its gradients are exact: motion beside `rate` is damped
constexpr Kind tension_bit = 2;  ///< artificial stress acts
constexpr Kind foreign_bit = 4;  ///< stands for what others own
constexpr Kind body_bits = ~(firm_bit | tension_bit | foreign_bit);
constexpr Kind kind_of_body(std::int32_t body) { return body * 8; }
/// Are two of one body? They hold each other; strangers only push.
constexpr bool kin(Kind a, Kind b) { return (b & body_bits) == (a & body_bits); }
/// Does the force between a particle and another act on the other's anchors? Strangers and particles have none.
constexpr bool acts_on_anchors(Kind particle, Kind other) { return (other & (body_bits | foreign_bit)) == ((particle & body_bits) | foreign_bit); }

/// Numbers of sixteen pairs.
template <class T>
struct alignas(64) Sixteen {
  T at[16];
};

struct Actors {
  std::vector<Place> place;
  std::vector<Flow> flow;
  std::vector<Strain> strain;
  std::vector<Stress> stress;      ///< sigma B^T, see particle_forces.hpp
  std::vector<Stress> artificial;  ///< artificial stress of Gray et al., where the kind says so
  std::vector<Motion> motion;
  std::vector<Kind> kind;
  std::vector<float> p_contact;    ///< what strangers are pushed with, none where it would pull: particles' traction on a plane that faces them, foreigners' pressure [Pa]

  static constexpr std::size_t bytes_each = 3 * 32 + 2 * sizeof(Stress) + sizeof(Motion) + sizeof(Kind) + sizeof(float);
  std::size_t size() const { return place.size(); }
  template <class F>
  void each_array(F&& f) { f(place), f(flow), f(strain), f(stress), f(artificial), f(motion), f(kind), f(p_contact); }
  void resize(std::size_t n) {
    each_array([n](auto& a) { a.resize(n); });
  }
};

/// What images behind a rigid wall say they belong to: they push whatever comes and hold nothing.
constexpr std::int32_t wall_body = -1;

/// A plane that mirrors: symmetry plane (particles and their images are one body) or rigid wall (they only push).
struct Mirror {
  core::Vec3 point{0, 0, 0}, normal{0, 0, 1};  ///< matter on the normal's side
  bool wall = false;
};
inline core::Vec3 reflect(const Mirror& m, const core::Vec3& a) { return a - 2 * m.normal.dot(a) * m.normal; }
/// Where the image of a point is.
inline core::Vec3 mirrored(const Mirror& m, const core::Vec3& x) { return m.point + reflect(m, core::Vec3(x - m.point)); }

struct Image {
  std::uint32_t source;   ///< actor
  std::uint32_t mirror;
};

/// Coordinates in which a foreigner's anchors lie on a lattice of spacing 2, as in an element's parent cube.
struct Frame {
  core::Vec3 xi{0, 0, 0};                        ///< where the foreigner is [-]
  core::Mat3 per_x = core::Mat3::Identity();     ///< d xi / d x [1/m]
};

inline double positive_part(double a) { return 0.5 * (a + std::abs(a)); }  ///< exact, and without a branch

/// Weight of an anchor in a pair, by its squared distance from the pair's middle in that frame: nothing beyond one spacing of
/// anchors, but never nothing of all. A lattice under uniform stress is then held still within 2e-3 of the stress at any seam.
template <class T>
T anchor_weight(T squared_distance) {
  constexpr double radius = 1.8, floor = 1e-9;  // nodes are 2 apart
  const T u = positive_part(T(1.0) - squared_distance * T(1 / (radius * radius)));
  return u * u + T(floor);
}

struct Neighbourhood {
  std::vector<Mirror> mirrors;
  std::size_t n_particles = 0, n_foreign = 0;
  Actors actors;
  double unit = 1;                   ///< length near h, a power of two: scaling by it rounds nothing [m]
  std::vector<Image> images;         ///< mirror after mirror
  core::Neighbours pairs;            ///< rows of particles and foreigners
  // Pairs in reach at this step, in rows of whole groups (pair_kernel.hpp). The row itself fills up its last group.
  std::vector<std::uint64_t> near_start;     ///< [row + 1] groups that each has room for; most of `pairs` is out of reach
  std::vector<Sixteen<std::uint32_t>> near;  ///< who
  std::vector<Sixteen<float>> weight;   ///< V_i V_j (dW/dr)/r [unit^3]
  std::vector<Sixteen<float>> push;     ///< m_i m_j Pi (dW/dr)/r of the viscosity: times d it is a force [unit^3]
  std::vector<std::uint64_t> pull_start;     ///< [particle] first of its groups below
  std::vector<Sixteen<float>> pull;     ///< weight times Gray's factor, of rows where artificial stress acts and no others [unit^3]
  std::vector<std::uint32_t> n_near;    ///< [row] how many are
  std::vector<std::uint8_t> mixed;      ///< [row] is one of another body?
  std::vector<float> acoustic;          ///< [n_particles] share of the speed of sound that counts in the stable step [-]
  std::vector<double> approach;         ///< [n_particles] largest mu of the viscosity, 0 where all part [m/s]
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

  std::vector<core::Vec3> wall_force;     ///< [particles, then foreigners] part of the force on each that rigid walls give; empty without [N]
  // Force of its own kind on a foreigner acts on its anchors, the nearer to the middle of the pair the more: rows of points
  // per foreigner. The last of each row is its own place: that takes what strangers push, and all where it is the only one.
  std::vector<std::uint32_t> anchor_start;   ///< [n_foreign + 1]
  std::vector<core::Vec3> anchor_xi;         ///< in the foreigner's frame [-]
  std::vector<Frame> frame;                  ///< [n_foreign]
  std::vector<core::Vec3> anchor_x;          ///< [m]
  std::vector<core::Mat3> foreign_gradient;  ///< [n_foreign] dv/dx round the anchors after the kick, by which their motion is carried on from them [1/s]
  std::vector<double> foreign_mass;          ///< [n_foreign] of who owns it [kg]
  std::vector<core::Vec3> anchor_v;          ///< after the kick [m/s]
  std::vector<core::Vec3> anchor_v_mean;     ///< velocity at which the force does its work [m/s]
  std::vector<core::Vec3> anchor_force;      ///< of the particles [N]
  std::vector<std::uint8_t> bears;           ///< [n_foreign] does any of its pairs press or pull?
  std::vector<std::uint8_t> anchored;        ///< [n_particles] is one of its pairs with a foreigner's anchors?
  std::vector<double> foreign_power;         ///< [n_foreign] what pairs do at its place, or on its owner's deformation, beyond what particles book: it gains that [W]
};

/// The particle or foreigner of which an actor is an image, perhaps of an image; itself where it is none.
inline std::size_t owner(const Neighbourhood& hood, std::size_t actor) {
  const std::size_t n_real = hood.n_particles + hood.n_foreign;
  while (actor >= n_real) actor = hood.images[actor - n_real].source;
  return actor;
}

/// True when the lists, made for the same actors, still hold every pair in reach of where particles and foreigners
/// (hood.actors) and what is watched are now.
bool still_valid(const Neighbourhood& hood, const std::vector<core::Vec3>& watched_x);

/// What lies within foreign_reaches of a particle must be an actor when the lists are made, what lies within
/// watched_reaches must be watched.
constexpr double foreign_reaches = 1.25, watched_reaches = 3.0;

/// Makes images and lists. Actors [0, n_particles + n_foreign) hold current x, h and v. outside_speed: of the fastest
/// thing that is no actor yet but could become a neighbour [m/s].
void build(Neighbourhood& hood, const std::vector<core::Vec3>& watched_x, double outside_speed);

/// Is there room for all pairs that are in reach? n_near says how many those are.
bool has_room(const Neighbourhood& hood);
/// Makes room for them and for a few more.
void make_room(Neighbourhood& hood);
/// And for what artificial stress needs to keep, once the kinds are known.
void make_room_for_pull(Neighbourhood& hood);

/// A particle that has passed a symmetry plane changes places with its image: the other half sends the same this way. Where
/// they stay, pairs behind the plane have no images, and there is nothing to strike.
void keep_in_front(const std::vector<Mirror>& mirrors, Particles& p);

/// Images follow their sources: where they are, how large and of what kind. What build() leaves is so already.
void reflect_places(Neighbourhood& hood);
/// And all else that actors hold but motion.
void reflect_images(Neighbourhood& hood);

/// Velocities after the kick into an actor's motion, and of the sources into the images'.
void set_motion(Neighbourhood& hood, std::size_t i, const core::Vec3& v_new);
void reflect_velocities(Neighbourhood& hood);

}  // namespace sph
